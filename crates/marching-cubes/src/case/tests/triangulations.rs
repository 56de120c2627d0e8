//! How loops can be filled, and that the table fills them in the best way.

use super::{
    super::polygons::triangulations,
    derive::{self, Pairing},
    triangles,
    triangulate::{self, Triangle},
};
use isokit_geom::cube::Edge;
use std::collections::{BTreeMap, BTreeSet};

#[test]
fn a_loop_has_as_many_triangulations_as_catalan_says() {
    let edges: Vec<_> = Edge::all().collect();
    for (sides, count) in [(3, 1), (4, 2), (5, 5), (6, 14), (7, 42), (8, 132)] {
        let all = triangulations(&edges[..sides]);
        assert!(all.iter().all(|triangles| triangles.len() == sides - 2));
        let different: BTreeSet<BTreeSet<_>> =
            all.into_iter().map(|triangles| triangles.into_iter().collect()).collect();
        assert_eq!(different.len(), count, "{sides} sides");
    }
}

#[test]
fn all_fillings_are_face_safe_but_for_some_hexagons_and_every_heptagon() {
    let mut loops_by_fillings = BTreeMap::new();
    for ring in loops() {
        let key = (ring.len(), triangulate::face_safe(&ring).len());
        *loops_by_fillings.entry(key).or_default() += 1;
    }
    let expected =
        [((3, 1), 144), ((4, 2), 66), ((5, 5), 72), ((6, 4), 12), ((6, 14), 40), ((7, 16), 24)];
    assert_eq!(loops_by_fillings, BTreeMap::from(expected));
}

#[test]
fn no_face_safe_filling_has_a_greater_least_angle() {
    for ring in loops() {
        let chosen = least_angle(&triangulate::best(&ring));
        for other in triangulate::face_safe(&ring) {
            assert!(chosen > least_angle(&other) - 1e-9, "{ring:?}: {other:?}");
        }
    }
}

#[test]
fn ties_go_to_the_least_edges() {
    for ring in loops() {
        let chosen = triangulate::best(&ring);
        let angle = least_angle(&chosen);
        let fillings = triangulate::face_safe(&ring).into_iter();
        let tied = fillings.filter(|other| (least_angle(other) - angle).abs() < 1e-9);
        assert_eq!(tied.map(by_edges).min(), Some(chosen), "{ring:?}");
    }
}

#[test]
fn a_filling_does_not_depend_on_where_the_loop_is_entered() {
    for mut ring in loops() {
        let chosen = triangulate::best(&ring);
        for _ in 0..ring.len() {
            ring.rotate_left(1);
            assert_eq!(triangulate::best(&ring), chosen, "{ring:?}");
        }
    }
}

#[test]
fn no_angle_at_edge_midpoints_is_below_30_degrees() {
    let least = (1..255).map(|case| least_angle(&triangles(case).collect::<Vec<_>>()));
    let degrees = least.fold(f64::INFINITY, f64::min).to_degrees();
    assert!((degrees - 30.0).abs() < 1e-9, "{degrees}");
}

fn loops() -> impl Iterator<Item = Vec<Edge>> {
    (0..=255).flat_map(|case| derive::loops(case, Pairing::SeparateInside))
}

/// The order the table uses: each triangle from its least edge, then ascending.
fn by_edges(mut triangles: Vec<Triangle>) -> Vec<Triangle> {
    for triangle in &mut triangles {
        let least = (0..3).min_by_key(|&i| triangle[i]).unwrap();
        triangle.rotate_left(least);
    }
    triangles.sort_unstable();
    triangles
}

/// The least angle of some triangles in radians, in floating point: not how `triangulate` compares them.
fn least_angle(triangles: &[Triangle]) -> f64 {
    let corners = triangles.iter().flat_map(|&[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]]);
    let angles = corners.map(|corner| {
        let [at, to, and] = corner.map(triangulate::middle);
        let [u, v]: [[f64; 3]; 2] =
            [to, and].map(|end| std::array::from_fn(|i| f64::from(end[i] - at[i])));
        let dot = |a: [f64; 3], b: [f64; 3]| -> f64 { (0..3).map(|i| a[i] * b[i]).sum() };
        (dot(u, v) / (dot(u, u) * dot(v, v)).sqrt()).acos()
    });
    angles.fold(f64::INFINITY, f64::min)
}
