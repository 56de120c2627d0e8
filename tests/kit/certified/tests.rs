//! The oracle against what is known, against symmetry, and against brute force.

use super::{Cell, Patch, brute::brute, cell, code, face_joins, random, random_with_code, volume};
use crate::chance::Chance;
use isokit::geom::cube::{Corner, Edge, Face};
use std::collections::BTreeSet;

/// Which corner of a turned or mirrored cell is at corner `k`, for each of the 48 symmetries of the cube.
fn symmetries() -> Vec<[usize; 8]> {
    let axes = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let turned = |axes: [usize; 3], mirrored: usize| {
        std::array::from_fn(|k| (0..3).map(|t| (k >> t & 1) << axes[t]).sum::<usize>() ^ mirrored)
    };
    axes.iter().flat_map(|&axes| (0..8).map(move |mirrored| turned(axes, mirrored))).collect()
}

/// The same cell with corner `k` and all that depends on it at `to[k]`.
fn moved(cell: &Cell, to: [usize; 8]) -> Cell {
    let corner = |k: usize| Corner::new(to[k] as u8);
    let edge = |e: usize| {
        let [a, b] = Edge::new(e as u8).ends().map(|end| corner(end.index()));
        Edge::between(a, b).expect("neighbours stay neighbours").index()
    };
    let mut moved = cell.clone();
    for patch in &mut moved.patches {
        patch.edges.iter_mut().for_each(|e| *e = edge(*e));
        patch.edges.sort_unstable();
    }
    for region in &mut moved.regions {
        region.corners.iter_mut().for_each(|k| *k = to[*k]);
        region.corners.sort_unstable();
    }
    moved.patches.sort_by_key(|patch| patch.edges[0]);
    moved.regions.sort_by_key(|region| region.corners[0]);
    moved
}

fn cut_edges(code: usize) -> Vec<usize> {
    let inside = |corner: Corner| code >> corner.index() & 1 == 1;
    let cuts = |edge: &Edge| inside(edge.ends()[0]) != inside(edge.ends()[1]);
    Edge::all().filter(cuts).map(Edge::index).collect()
}

fn eulers(corners: [i64; 8]) -> Vec<i64> {
    cell(corners).unwrap().patches.iter().map(|patch| patch.euler).collect()
}

/// Two ambiguous corners below, all corners above of the other sign.
fn one_ambiguous_face(below: [i64; 4], above: i64) -> [i64; 8] {
    std::array::from_fn(|k| below.get(k).copied().unwrap_or(above))
}

#[test]
fn every_patch_parts_the_cell_once_more_and_reaches_its_edges() {
    let mut chance = Chance::new(1);
    for round in 0..20_000 {
        let corners = random([1 << 40, 1000, 4, 2][round % 4], &mut chance);
        let found = cell(corners).unwrap_or_else(|| panic!("{corners:?} is undecided"));
        assert_eq!(found.patches.len() + 1, found.regions.len(), "{corners:?}");
        let mut reached: Vec<usize> = found.patches.iter().flat_map(|p| p.edges.clone()).collect();
        reached.sort_unstable();
        assert_eq!(reached, cut_edges(code(corners)), "{corners:?}");
        assert!(found.patches.iter().all(|patch| patch.edges.len() > 2), "{corners:?}");
        let corners_held = found.regions.iter().map(|region| region.corners.len());
        assert_eq!(corners_held.sum::<usize>(), 8, "{corners:?}");
    }
}

#[test]
fn one_corner_or_one_layer_is_one_disc() {
    let disc = |edges: &[usize]| vec![Patch { euler: 1, edges: edges.to_vec() }];
    assert_eq!(cell([9, -1, -1, -1, -1, -1, -1, -1]).unwrap().patches, disc(&[0, 4, 8]));
    assert_eq!(cell([-9, 1, 1, 1, 1, 1, 1, 1]).unwrap().patches, disc(&[0, 4, 8]));
    assert_eq!(cell([1, 2, 3, 4, -1, -2, -3, -4]).unwrap().patches, disc(&[8, 9, 10, 11]));
    assert_eq!([cell([0; 8]), cell([5; 8])].map(|cell| cell.unwrap().patches), [vec![], vec![]]);
}

#[test]
fn the_saddle_of_a_face_decides_and_a_tie_joins_the_inside() {
    for (below, discs) in [([2, -1, -1, 2], 1), ([1, -2, -2, 1], 2), ([6, -3, -4, 2], 1)] {
        assert_eq!(eulers(one_ambiguous_face(below, -5)), vec![1; discs], "{below:?}");
    }
    for (below, discs) in [([2, -1, -1, 2], 2), ([1, -2, -2, 1], 1), ([6, -3, -4, 2], 2)] {
        let [a, b, c, d] = below;
        assert_eq!(eulers(one_ambiguous_face([b, a, d, c], 5)), vec![1; discs], "{below:?}");
    }
}

#[test]
fn opposite_corners_join_through_the_cell_where_the_field_between_them_is_high() {
    assert_eq!(eulers([9, -1, -1, -1, -1, -1, -1, 9]), [0]);
    assert_eq!(eulers([2, -1, -1, -1, -1, -1, -1, 2]), [1, 1]);
    assert_eq!(eulers([-9, 1, 1, 1, 1, 1, 1, -9]), [0]);
    assert_eq!(eulers([-2, 1, 1, 1, 1, 1, 1, -2]), [1, 1]);
}

#[test]
fn brute_force_sees_the_same() {
    let mut chance = Chance::new(2);
    let (mut agreed, mut tunnels) = (0, 0);
    for round in 0..400 {
        // Half of them where the inside is two opposite corners, or all but these, or every other corner.
        let code = [0x81, 0x7E, 0x69, 0x96, 0x42, 0xBD, 0x18, 0xE7][round / 2 % 8];
        let corners = match round % 2 {
            0 => random(30, &mut chance),
            _ => random_with_code(code, 30, &mut chance),
        };
        let seen = brute(corners, 12);
        if seen == brute(corners, 17) {
            agreed += 1;
            assert_eq!(cell(corners), Some(seen.clone()), "{corners:?}");
            tunnels += usize::from(seen.patches.iter().any(|patch| patch.euler == 0));
        }
    }
    assert!(agreed > 350 && tunnels > 5, "{agreed}, {tunnels}");
}

#[test]
fn all_symmetries_of_the_cube_see_the_same() {
    let mut chance = Chance::new(3);
    for reach in [1 << 40, 300, 3, 2].repeat(25) {
        let corners = random(reach, &mut chance);
        let expected = cell(corners).unwrap();
        for from in symmetries() {
            let turned = cell(from.map(|k| corners[k])).unwrap();
            assert_eq!(moved(&turned, from), expected, "{corners:?}, {from:?}");
        }
    }
}

#[test]
fn without_ties_the_negative_has_the_same_surface() {
    let mut chance = Chance::new(4);
    for _ in 0..2000 {
        let corners = random(1 << 40, &mut chance).map(|v| v | 1);
        let (found, negative) = (cell(corners).unwrap(), cell(corners.map(|v| -v)).unwrap());
        assert_eq!(found.patches, negative.patches, "{corners:?}");
    }
}

#[test]
fn a_tie_is_what_a_field_a_little_higher_is() {
    for code in 0..3_usize.pow(8) {
        let corners = std::array::from_fn(|k| (code / 3_usize.pow(k as u32) % 3) as i64 - 1);
        let found = cell(corners);
        assert!(found.is_some(), "{corners:?}");
        for scale in [1009, 1 << 20] {
            assert_eq!(found, cell(corners.map(|v| v * scale + 1)), "{corners:?}, {scale}");
        }
    }
}

#[test]
fn singular_faces_are_decided_and_join_their_inside() {
    let mut chance = Chance::new(5);
    for reach in [4, 50, 1000, 30_000, 1 << 20].repeat(100) {
        let mut of = |least: i64| least + (chance.unit() * reach as f64) as i64;
        let [p, q, r, s] = [of(1), of(1), of(1), of(1)];
        let above = random(reach * reach, &mut chance);
        let corners = one_ambiguous_face([p * q, -p * r, -q * s, r * s], 0);
        let corners: [i64; 8] = std::array::from_fn(|k| if k < 4 { corners[k] } else { above[k] });
        assert_eq!(face_joins(corners)[4], Some(true));
        let found = cell(corners).unwrap_or_else(|| panic!("{corners:?} is undecided"));
        let joined =
            found.regions.iter().any(|region| [0, 3].iter().all(|k| region.corners.contains(k)));
        assert!(joined, "{corners:?}");
        assert_eq!(Some(found), cell(corners.map(|v| 3 * v)), "{corners:?}");
    }
}

/// The field xyz − x − y − z − 2 for x, y, z from −12 to 10, less its factor 242: its saddles are 0 at −1
/// and −1/60.5 at 1, so that no infinitesimal is above that.
#[test]
fn a_body_saddle_of_0_is_decided_beside_another_just_below() {
    let corners = [-7, 6, 6, -5, 6, -5, -5, 4];
    let found = cell(corners);
    assert!(found.is_some());
    for scale in [61, 1009, 1 << 40] {
        assert_eq!(found, cell(corners.map(|v| v * scale + 1)), "{scale}");
    }
    assert_ne!(found, cell(corners.map(|v| v * 60 + 1)));
}

#[test]
fn a_face_joins_its_inside_or_its_outside() {
    let mut chance = Chance::new(7);
    let mut ties = 0;
    for reach in [2, 4, 1000].repeat(3000) {
        let corners = random(reach, &mut chance);
        let regions = cell(corners).unwrap().regions;
        for (f, joins) in face_joins(corners).into_iter().enumerate() {
            let Some(inside) = joins else { continue };
            let ends = Face::new(f as u8).corners().map(Corner::index);
            let diagonal = |from: usize| [ends[from], ends[from + 2]];
            let from = usize::from((corners[ends[0]] >= 0) != inside);
            let joined =
                regions.iter().find(|region| region.corners.contains(&ends[from])).unwrap();
            assert!(joined.corners.contains(&diagonal(from)[1]), "{corners:?}, face {f}");
            let [[a, c], [b, d]] = [diagonal(0), diagonal(1)].map(|d| d.map(|k| corners[k]));
            ties += usize::from(a * c == b * d);
        }
    }
    assert!(ties > 100, "{ties}");
}

#[test]
fn a_checkerboard_is_one_to_four_discs_or_a_disc_and_a_tunnel() {
    let mut chance = Chance::new(8);
    let mut kinds = BTreeSet::new();
    for code in [0x69, 0x96].repeat(2000) {
        let patches = cell(random_with_code(code, 1000, &mut chance)).unwrap().patches;
        let mut kind: Vec<_> = patches.iter().map(|p| (p.edges.len(), p.euler)).collect();
        kind.sort_unstable();
        kinds.insert(kind);
    }
    let expected: [&[(usize, i64)]; 5] =
        [&[(12, 1)], &[(3, 1), (9, 1)], &[(3, 1), (3, 1), (6, 1)], &[(3, 1); 4], &[(3, 1), (9, 0)]];
    assert_eq!(kinds, expected.map(|kind| kind.to_vec()).into());
}

#[test]
fn a_checkerboard_joins_its_faces_in_46_ways_of_64() {
    let mut chance = Chance::new(6);
    for code in [0x69, 0x96] {
        let joins = (0..100_000).map(|_| face_joins(random_with_code(code, 1000, &mut chance)));
        let ways: BTreeSet<[bool; 6]> = joins.map(|f| f.map(|joins| joins.unwrap())).collect();
        assert_eq!(ways.len(), 46);
    }
}

/// scikit-image 8109: the saddle of the middle face is 0.
#[test]
fn two_cells_with_a_singular_face_between_them_are_decided_alike() {
    let samples = [13, -1, -1, -7, -1, 1, 7, -7, 15, -9, -3, -1];
    assert_eq!(volume([2, 2, 3], &samples), Some(vec![1, 1]));
}
