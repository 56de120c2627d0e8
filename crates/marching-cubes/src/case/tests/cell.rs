//! One cell by itself: its triangles use what they should, once, and keep out of its faces.

use super::{
    derive::{self, Pairing},
    rim, sides, triangles, triangulate,
};
use crate::case::{COUNTS, CROSSED, EDGES, TRIANGLES};
use isokit_geom::cube::{Corner, Edge, Face};

#[test]
fn every_case_uses_its_crossed_edges_and_no_other() {
    for case in 0..=255 {
        let used = triangles(case).flatten().fold(0, |mask, e| mask | 1_u16 << e.index());
        assert_eq!(used, CROSSED[case as usize], "case {case:#010b}");
    }
}

#[test]
fn an_edge_is_crossed_where_its_ends_differ() {
    for (case, e) in (0..=255).flat_map(|case| Edge::all().map(move |e| (case, e))) {
        let [a, b] = e.ends().map(|k| derive::is_inside(case, k));
        let crossed = CROSSED[case as usize] >> e.index() & 1 == 1;
        assert_eq!(crossed, a != b, "case {case:#010b}, {e:?}");
    }
}

#[test]
fn the_flat_forms_say_what_the_triangles_say() {
    for (case, triangles) in TRIANGLES.iter().enumerate() {
        let used = 3 * COUNTS[case] as usize;
        assert_eq!(&EDGES[case][..used], triangles.as_flattened(), "case {case:#010b}");
        assert!(EDGES[case][used..].iter().all(|&e| e == 0), "case {case:#010b}");
    }
}

#[test]
fn no_directed_side_occurs_twice_in_a_cell() {
    for case in 0..=255 {
        assert_eq!(sides(case).len(), 3 * triangles(case).count(), "case {case:#010b}");
    }
}

#[test]
fn the_rim_of_every_case_is_the_cuts_of_its_faces() {
    for case in 0..=255 {
        let cuts = Face::all().flat_map(|face| derive::cuts(case, face, Pairing::SeparateInside));
        assert_eq!(rim(case), cuts.collect(), "case {case:#010b}");
    }
}

#[test]
fn every_side_of_the_rim_lies_in_one_face() {
    for case in 0..=255 {
        for [p, q] in rim(case) {
            let faces = Face::all().filter(|face| face.contains(p) && face.contains(q));
            assert_eq!(faces.count(), 1, "case {case:#010b}, {p:?} to {q:?}");
        }
    }
}

#[test]
fn no_inner_side_lies_in_a_face() {
    for case in 0..=255 {
        for [p, q] in sides(case).difference(&rim(case)) {
            assert_eq!(p.common_face(*q), None, "case {case:#010b}, {p:?} to {q:?}");
        }
    }
}

#[test]
fn no_triangle_lies_in_a_face() {
    for case in 0..=255 {
        for triangle in triangles(case) {
            let flat = Face::all().any(|face| triangle.iter().all(|&e| face.contains(e)));
            assert!(!flat, "case {case:#010b}, {triangle:?}");
        }
    }
}

#[test]
fn one_inside_corner_faces_away_from_it() {
    for k in Corner::all() {
        let [case, hole] = [1_u8 << k.index(), !(1 << k.index())];
        let outward = k.offset().map(|x| 1 - 2 * x as i32);
        assert_eq!(signs_of_normal(case), outward, "inside {k:?}");
        assert_eq!(signs_of_normal(hole), outward.map(|x| -x), "outside {k:?}");
    }
}

/// Which way the first triangle of `case` faces, axis by axis.
fn signs_of_normal(case: u8) -> [i32; 3] {
    let [p, q, r] = triangles(case).next().unwrap().map(triangulate::middle);
    let [u, v]: [[i32; 3]; 2] = [q, r].map(|end| std::array::from_fn(|i| end[i] - p[i]));
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        (u[j] * v[k] - u[k] * v[j]).signum()
    })
}
