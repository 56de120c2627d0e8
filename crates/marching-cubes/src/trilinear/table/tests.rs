//! What makes the table right, for every code and every choice of its faces.

use super::{AMBIGUOUS, CENTRE, FIRST, RESOLVED, derive, is_simple, resolved};
use crate::case::{CROSSED, TRIANGLES};
use isokit_geom::cube::{Corner, Edge, Face};
use std::{
    collections::{BTreeMap, BTreeSet},
    env, fs,
};

#[test]
fn generated_file_is_current() {
    let (mut first, mut rows) = ([u16::MAX; 256], vec![]);
    for code in derive::codes() {
        first[usize::from(code)] = rows.len() as u16;
        for joined in derive::choices(code) {
            let disc = |ring: &Vec<Edge>| {
                let edges: Vec<_> = ring.iter().map(|edge| edge.index()).collect();
                format!("Disc {{ ring: &{edges:?}, triangles: &{:?} }}", derive::triangles(ring))
            };
            let discs: Vec<_> = derive::loops(code, joined).iter().map(disc).collect();
            let (regions, discs) = (derive::regions(code, joined), discs.join(", "));
            rows.push(format!(
                "    Resolved {{ regions: {regions:?}, discs: &[{discs}] }}, // {code:08b}, {joined:06b}\n"
            ));
        }
    }
    let text = format!(
        "//! Written by `trilinear/table/tests.rs` from `trilinear/table/derive.rs`; do not edit.\n//!\n\
         //! `UPDATE=1 cargo test -p isokit-marching-cubes` writes it again.\n\n\
         use super::{{Disc, Resolved}};\n\n\
         /// The first row of each code; none for one that is simple.\n\
         pub(super) static FIRST: [u16; 256] = {first:?};\n\n\
         /// Beside each row stand its code, the signs of corners 7 to 0, and the faces 5 to 0 that join.\n\
         pub(super) static RESOLVED: [Resolved; {}] = [\n{}];\n",
        rows.len(),
        rows.concat(),
    );
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/src/trilinear/table/generated.rs");
    if env::var_os("UPDATE").is_some() {
        fs::write(file, &text).unwrap();
    }
    assert_eq!(fs::read_to_string(file).unwrap(), text, "run again with UPDATE=1");
}

/// Every code that is not simple with every choice of faces.
fn all() -> impl Iterator<Item = (u8, u8)> {
    derive::codes().flat_map(|code| derive::choices(code).map(move |joined| (code, joined)))
}

fn triangles(code: u8, joined: u8) -> impl Iterator<Item = [u8; 3]> {
    resolved(code, joined).discs.iter().flat_map(|disc| disc.triangles).copied()
}

fn sides([a, b, c]: [u8; 3]) -> [[u8; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

#[test]
fn there_are_as_many_choices_as_the_ambiguous_faces_allow() {
    assert_eq!(derive::codes().count(), 128);
    assert_eq!(all().count(), RESOLVED.len());
    let simple = (0..=255).filter(|&code| is_simple(code));
    assert_eq!(RESOLVED.len() + simple.count(), 656);
    let mut loops_by_length = BTreeMap::new();
    for ring in (0..=255)
        .flat_map(|code| derive::choices(code).flat_map(move |joined| derive::loops(code, joined)))
    {
        *loops_by_length.entry(ring.len()).or_insert(0) += 1;
    }
    let lengths: Vec<_> = loops_by_length.keys().copied().collect();
    assert_eq!(lengths, [3, 4, 5, 6, 7, 8, 9, 12]);
    assert_eq!((loops_by_length[&8], loops_by_length[&9], loops_by_length[&12]), (60, 96, 32));
}

#[test]
fn the_rows_are_found_by_code_and_faces() {
    for ((code, joined), row) in all().zip(&RESOLVED) {
        assert!(std::ptr::eq(resolved(code, joined), row), "{code:08b}, {joined:06b}");
        assert!(FIRST[usize::from(code)] < 528);
    }
}

#[test]
fn with_no_face_joined_the_surface_is_that_of_the_256_cases() {
    for code in derive::codes() {
        let found: BTreeSet<_> = triangles(code, 0).collect();
        assert_eq!(found, TRIANGLES[usize::from(code)].iter().copied().collect(), "{code:08b}");
    }
}

#[test]
fn the_discs_leave_the_cell_in_their_loops_and_nowhere_else() {
    for (code, joined) in all() {
        for disc in resolved(code, joined).discs {
            let next = disc.ring.iter().cycle().skip(1);
            let ring: BTreeSet<_> = disc.ring.iter().zip(next).map(|(&p, &q)| [p, q]).collect();
            let sides: Vec<_> = disc.triangles.iter().copied().flat_map(sides).collect();
            let once: BTreeSet<_> = sides.iter().copied().collect();
            assert_eq!(once.len(), sides.len(), "a side twice the same way: {disc:?}");
            let rim = once.iter().copied().filter(|&[p, q]| !once.contains(&[q, p]));
            assert_eq!(rim.collect::<BTreeSet<_>>(), ring);
            let corners: BTreeSet<_> = disc.triangles.as_flattened().iter().collect();
            let euler = corners.len() as i32 - (sides.len() as i32 + ring.len() as i32) / 2
                + disc.triangles.len() as i32;
            assert_eq!(euler, 1, "a disc: {disc:?}");
        }
        let used = triangles(code, joined).flatten().filter(|&edge| edge != CENTRE);
        let used = used.fold(0, |mask, edge| mask | 1_u16 << edge);
        assert_eq!(used, CROSSED[usize::from(code)], "{code:08b}, {joined:06b}");
    }
}

#[test]
fn no_inner_side_and_no_triangle_lies_in_a_face() {
    for (code, joined) in all() {
        let all: BTreeSet<_> = triangles(code, joined).flat_map(sides).collect();
        for &[p, q] in all.iter().filter(|&&[p, q]| all.contains(&[q, p])) {
            let in_face =
                p < CENTRE && q < CENTRE && Edge::new(p).common_face(Edge::new(q)).is_some();
            assert!(!in_face, "{code:08b}, {joined:06b}: {p} to {q}");
        }
        for triangle in triangles(code, joined) {
            let flat =
                |face: Face| triangle.iter().all(|&e| e < CENTRE && face.contains(Edge::new(e)));
            assert!(!Face::all().any(flat), "{code:08b}, {joined:06b}: {triangle:?}");
        }
    }
}

#[test]
fn only_loops_without_face_safe_triangles_have_a_vertex_of_their_own_and_a_cell_has_one_at_most() {
    let mut fans = BTreeMap::new();
    for (code, joined) in all() {
        let own = resolved(code, joined).discs.iter().filter(|disc| disc.is_fan());
        own.clone().for_each(|disc| *fans.entry(disc.ring.len()).or_insert(0) += 1);
        assert!(own.count() <= 1, "{code:08b}, {joined:06b}");
    }
    // Of the loops of twelve those that no cell has could do without.
    assert_eq!(fans, BTreeMap::from([(8, 12), (9, 96), (12, 32)]));
}

/// A cell's surface is cut by its loops into one region more than there are loops.
#[test]
fn there_is_one_loop_less_than_regions() {
    for (code, joined) in all() {
        let row = resolved(code, joined);
        let regions: BTreeSet<_> = row.regions.iter().collect();
        assert_eq!(row.discs.len() + 1, regions.len(), "{code:08b}, {joined:06b}");
        for k in 0..8 {
            let own = code >> row.regions[k] & 1;
            assert_eq!(own, code >> k & 1, "a region has one sign");
        }
    }
}

#[test]
fn every_loop_runs_between_one_inside_and_one_outside_region() {
    for (code, joined) in all() {
        let row = resolved(code, joined);
        let mut pairs = BTreeSet::new();
        for disc in row.discs {
            let beside = |inside: u8| -> BTreeSet<u8> {
                let ends = disc.ring.iter().flat_map(|&e| Edge::new(e).ends().map(Corner::index));
                ends.filter(|&k| code >> k & 1 == inside).map(|k| row.regions[k]).collect()
            };
            assert_eq!([beside(0).len(), beside(1).len()], [1, 1], "{code:08b}, {joined:06b}");
            assert!(pairs.insert([beside(0), beside(1)]), "no two loops share both");
        }
    }
}

/// What a cell draws on a face is a function of the face's signs and of its own bit.
#[test]
fn neighbours_whose_face_is_decided_alike_cut_it_alike() {
    let rim_in = |code: u8, joined: u8, face: Face| -> BTreeSet<[Edge; 2]> {
        let all: BTreeSet<_> = match is_simple(code) {
            true => TRIANGLES[usize::from(code)].iter().copied().flat_map(sides).collect(),
            false => triangles(code, joined).flat_map(sides).collect(),
        };
        let rim = all.iter().filter(|&&[p, q]| !all.contains(&[q, p]));
        let edges = rim.map(|side| side.map(Edge::new));
        edges.filter(|side| side.iter().all(|&edge| face.contains(edge))).collect()
    };
    for axis in 0..3 {
        let [low, high] = [2 * axis as u8, 2 * axis as u8 + 1].map(Face::new);
        let raised = |e: Edge| {
            let [a, b] = e.ends().map(|k| k.across(axis));
            Edge::between(a, b).unwrap()
        };
        let mut cuts: BTreeMap<_, BTreeSet<BTreeSet<[Edge; 2]>>> = BTreeMap::new();
        for code in 0..=255 {
            for joined in derive::choices(code) {
                let key = |face: Face, at: fn(Corner, usize) -> Corner| {
                    let signs = low.corners().map(|k| code >> at(k, axis).index() & 1);
                    (signs, joined >> face.index() & 1)
                };
                let above = rim_in(code, joined, low);
                let below = rim_in(code, joined, high);
                let below = below.into_iter().map(|[p, q]| [raised(q), raised(p)]).collect();
                cuts.entry(key(low, |k, _| k)).or_default().insert(above);
                cuts.entry(key(high, Corner::across)).or_default().insert(below);
            }
        }
        assert_eq!(cuts.len(), 16 + 2, "axis {axis}: two patterns have two ways each");
        assert!(cuts.values().all(|ways| ways.len() == 1), "axis {axis}: {cuts:?}");
    }
}

#[test]
fn a_face_is_ambiguous_where_its_corners_alternate() {
    for code in 0..=255_u8 {
        for face in Face::all() {
            let is_ambiguous = crate::case::derive::is_ambiguous(code, face);
            assert_eq!(AMBIGUOUS[usize::from(code)] >> face.index() & 1 == 1, is_ambiguous);
        }
    }
}
