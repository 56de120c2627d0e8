//! Small meshes that come apart and together again; then chance against the rule taken literally.

use super::{Welded, weld_exact, weld_within};
use crate::{
    Positions, TriMesh,
    kit::{cube, exploded, mesh, moved, positions, sphere, threads, torus},
    topology::topology,
};
use isokit_job::{Cancelled, Job, Limits, Stopped};
use proptest::prelude::*;

fn exact(mesh: &TriMesh) -> Welded {
    weld_exact(mesh, &Job::default()).unwrap()
}

fn within(mesh: &TriMesh, tolerance: f64) -> Welded {
    weld_within(mesh, tolerance, &Job::default()).unwrap()
}

#[test]
fn a_soup_becomes_the_surface_it_was() {
    for whole in [cube(), sphere(3), torus(9)] {
        let welded = exact(&exploded(&whole));
        assert_eq!(welded.merged_vertices, 3 * whole.counts().triangles - whole.counts().vertices);
        assert_eq!((welded.dropped_triangles, welded.new_nonmanifold_edges), (0, 0));
        let genus = |mesh| topology(mesh, &Job::default()).unwrap().genus();
        assert_eq!(genus(&welded.mesh), genus(&whole));
        assert_eq!(within(&exploded(&whole), 1e-6), welded);
    }
}

#[test]
fn what_is_welded_stays_as_it_is() {
    for whole in [cube(), sphere(3), mesh(&[], &[])] {
        assert_eq!(exact(&whole), Welded { mesh: whole.clone(), ..Welded::default() });
        assert_eq!(within(&whole, 1e-3), exact(&whole));
    }
}

#[test]
fn the_first_keeps_its_place_and_its_normal() {
    let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut quad = mesh(&[x, y, z, y, [1.0; 3], z], &[[0, 1, 2], [5, 3, 4]]);
    quad.normals = Some((0..6).map(|n| [n as f32, 0.0, 0.0]).collect());
    let mut expected = mesh(&[x, y, z, [1.0; 3]], &[[0, 1, 2], [2, 1, 3]]);
    expected.normals = Some([0, 1, 2, 4].map(|n| [n as f32, 0.0, 0.0]).to_vec());
    assert_eq!(exact(&quad), Welded { mesh: expected, merged_vertices: 2, ..Welded::default() });
}

#[test]
fn minus_zero_is_zero_and_nan_is_nowhere() {
    let places = [[0.0, 1.0, f64::NAN], [0.0; 3], [-0.0, 0.0, -0.0], [0.0, 1.0, f64::NAN]];
    for welded in [exact(&mesh(&places, &[])), within(&mesh(&places, &[]), 0.5)] {
        assert_eq!((welded.merged_vertices, welded.mesh.positions.len()), (1, 3));
    }
}

#[test]
fn both_precisions_are_welded_and_kept() {
    let single = |mesh: &TriMesh| TriMesh {
        positions: Positions::F32(mesh.positions.iter().map(|p| p.map(|c| c as f32)).collect()),
        ..mesh.clone()
    };
    let whole = sphere(2);
    assert_eq!(exact(&single(&exploded(&whole))).mesh, single(&exact(&exploded(&whole)).mesh));
}

#[test]
fn the_tolerance_is_a_distance_and_still_within() {
    let two = |distance: f64| mesh(&[[0.0; 3], [0.6 * distance, 0.8 * distance, 0.0]], &[]);
    for (distance, merged) in [(0.5, 1), (1.0, 1), (1.001, 0), (1.7, 0)] {
        assert_eq!(within(&two(distance), 1.0).merged_vertices, merged, "{distance}");
    }
    // Zero, less and nothing at all are exact; everything is within infinity.
    for tolerance in [0.0, -1.0, f64::NAN] {
        assert_eq!(within(&two(1e-300), tolerance).merged_vertices, 0);
    }
    assert_eq!(within(&two(1e300), f64::INFINITY).merged_vertices, 1);
}

#[test]
fn a_chain_is_not_drawn_together() {
    let chain: Vec<[f64; 3]> = (0..7).map(|n| [0.8 * f64::from(n), 0.0, 0.0]).collect();
    let kept = within(&mesh(&chain, &[]), 1.0).mesh.positions;
    // Each even one is too far from the last one kept, each odd one is not.
    assert_eq!(kept, Positions::F64(vec![chain[0], chain[2], chain[4], chain[6]]));
}

#[test]
fn a_triangle_drawn_together_is_dropped_and_leaves_no_hole() {
    let mut dented = sphere(2);
    let [a, b, _] = dented.triangles[40];
    let place = dented.positions.get(a as usize);
    positions(&mut dented)[b as usize] = place.map(|c| c + 1e-9);
    let welded = within(&dented, 1e-8);
    assert_eq!((welded.merged_vertices, welded.dropped_triangles), (1, 2));
    let topology = topology(&welded.mesh, &Job::default()).unwrap();
    assert_eq!(topology.shortfalls(), Vec::<String>::new());
}

#[test]
fn edges_that_get_too_many_triangles_are_counted_once() {
    // Two cubes that share the place of an edge; then of a face, which both cut along one diagonal.
    for (step, expected) in [([1.0, 1.0, 0.0], 1), ([1.0, 0.0, 0.0], 5)] {
        let mut second = cube();
        positions(&mut second).iter_mut().for_each(|p| (0..3).for_each(|k| p[k] += step[k]));
        let welded = exact(&TriMesh::joined(&[cube(), second]).unwrap());
        assert_eq!(welded.new_nonmanifold_edges, expected);
        assert_eq!(exact(&welded.mesh), Welded { mesh: welded.mesh, ..Welded::default() });
    }
}

#[test]
fn an_edge_that_had_too_many_before_is_not_new() {
    let fins = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
    let mut places: Vec<[f64; 3]> = (0..5).map(|n| [f64::from(n), f64::from(n * n), 0.0]).collect();
    places.push(places[0]);
    places.push([0.0, 0.0, 9.0]);
    let mut triangles = fins.to_vec();
    triangles.push([5, 1, 6]);
    let welded = exact(&mesh(&places, &triangles));
    assert_eq!((welded.merged_vertices, welded.new_nonmanifold_edges), (1, 0));
}

#[test]
fn a_vertex_that_is_not_there_is_not_there_afterwards() {
    let welded = exact(&mesh(&[[0.0; 3], [1.0; 3], [0.0; 3]], &[[0, 1, 7], [1, 2, u32::MAX]]));
    assert_eq!(welded.mesh.triangles, [[0, 1, 7], [1, 0, u32::MAX]]);
}

#[test]
fn a_cancelled_weld_stops_and_a_limit_holds() {
    let job = Job::default();
    job.cancel.cancel();
    assert_eq!(weld_exact(&cube(), &job), Err(Stopped::Cancelled(Cancelled)));
    let job = Job { limits: Limits { bytes: 20 }, ..Job::default() };
    assert!(matches!(weld_within(&cube(), 0.1, &job), Err(Stopped::OverLimit(_))));
}

/// The rule as it is told.
fn by_the_rule(places: &[[f64; 3]], tolerance: f64) -> Vec<[f64; 3]> {
    let mut kept: Vec<[f64; 3]> = vec![];
    for &place in places {
        let square = |other: &[f64; 3]| (0..3).map(|k| (place[k] - other[k]).powi(2)).sum::<f64>();
        if !kept.iter().any(|other| square(other) <= tolerance * tolerance) {
            kept.push(place);
        }
    }
    kept
}

proptest! {
    #[test]
    fn welding_follows_its_rule(
        places in prop::collection::vec([-8..8_i32, -8..8_i32, -8..8_i32], 0..200),
        tolerance in 1..24_i32,
    ) {
        // Eighths, so that distances equal to the tolerance come up.
        let tolerance = f64::from(tolerance) / 8.0;
        let places: Vec<[f64; 3]> =
            places.into_iter().map(|place| place.map(|c| f64::from(c) / 4.0)).collect();
        let found = within(&mesh(&places, &[]), tolerance);
        let expected = by_the_rule(&places, tolerance);
        prop_assert_eq!(found.merged_vertices as usize, places.len() - expected.len());
        prop_assert_eq!(found.mesh.positions, Positions::F64(expected));
    }

    #[test]
    fn welding_counts_what_became_nonmanifold(
        triangles in prop::collection::vec([0..9_u32, 0..9_u32, 0..9_u32], 0..20),
        places in prop::collection::vec(0..5_u32, 9),
    ) {
        let places: Vec<[f64; 3]> = places.into_iter().map(|n| [n.into(), (n * n).into(), 0.0]).collect();
        let before = mesh(&places, &triangles);
        let welded = exact(&before);
        let overused = |mesh| topology(mesh, &Job::default()).unwrap().nonmanifold_edges;
        // Old ones may merge or vanish, so the new ones are at least the difference, at most all.
        prop_assert!(welded.new_nonmanifold_edges <= overused(&welded.mesh));
        prop_assert!(welded.new_nonmanifold_edges + overused(&before) >= overused(&welded.mesh));
    }
}

#[test]
fn any_number_of_threads_welds_the_same() {
    let soup = exploded(&moved(&sphere(5), |x| x * 3.0));
    let one = weld_within(&soup, 0.05, &threads(1)).unwrap();
    assert_eq!(weld_within(&soup, 0.05, &threads(3)).unwrap(), one);
}
