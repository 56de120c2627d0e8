//! Meshes with one flaw each, and one name for it; then chance.

mod chance;

use super::{Topology, topology};
use crate::{
    Component, TriMesh,
    kit::{cube, graph, mesh, moved, positions, sphere, strip, tetrahedron, torus},
};
use isokit_job::{Cancelled, Job, Limits, Stopped};

pub(crate) fn of(mesh: &TriMesh) -> Topology {
    topology(mesh, &Job::default()).unwrap()
}

/// The counters of flaws, in the order in which [`Topology`] has them, and χ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Flaws {
    unused: u64,
    non_finite: u64,
    out_of_range: u64,
    degenerate: u64,
    duplicate: u64,
    boundary: u64,
    nonmanifold_edges: u64,
    nonmanifold_vertices: u64,
    inconsistent: u64,
    components: usize,
    euler: i64,
}

#[track_caller]
fn check(mesh: &TriMesh, expected: Flaws) {
    let found = of(mesh);
    let flaws = Flaws {
        unused: found.unused_vertices,
        non_finite: found.non_finite_vertices,
        out_of_range: found.out_of_range_triangles,
        degenerate: found.degenerate_triangles,
        duplicate: found.duplicate_triangles,
        boundary: found.boundary_edges,
        nonmanifold_edges: found.nonmanifold_edges,
        nonmanifold_vertices: found.nonmanifold_vertices,
        inconsistent: found.inconsistent_edges,
        components: found.components.len(),
        euler: found.euler(),
    };
    assert_eq!(flaws, expected);
}

const SPHERE: Flaws = Flaws {
    unused: 0,
    non_finite: 0,
    out_of_range: 0,
    degenerate: 0,
    duplicate: 0,
    boundary: 0,
    nonmanifold_edges: 0,
    nonmanifold_vertices: 0,
    inconsistent: 0,
    components: 1,
    euler: 2,
};

#[test]
fn closed_surfaces_have_no_flaw_and_a_genus() {
    for (mesh, euler, genus) in
        [(tetrahedron(), 2, 0), (cube(), 2, 0), (sphere(3), 2, 0), (torus(7), 0, 1)]
    {
        check(&mesh, Flaws { euler, ..SPHERE });
        assert_eq!(of(&mesh).genus(), Some(genus));
        assert_eq!(of(&mesh).shortfalls(), Vec::<String>::new());
    }
}

#[test]
fn pieces_stand_in_the_order_of_their_first_triangles() {
    let mesh = TriMesh::joined(&[torus(5), tetrahedron()]).unwrap();
    check(&mesh, Flaws { components: 2, ..SPHERE });
    let found = of(&mesh);
    let [torus, tetrahedron] = &found.components[..] else { panic!("two pieces") };
    assert_eq!((torus.triangles, torus.vertices, torus.edges), (50, 25, 75));
    assert_eq!((torus.genus(), tetrahedron.genus()), (Some(1), Some(0)));
    assert_eq!((tetrahedron.triangles, tetrahedron.vertices, tetrahedron.edges), (4, 4, 6));
    assert!((tetrahedron.volume - 1.0 / 6.0).abs() < 1e-15);
    assert_eq!(found.genus(), Some(1));
}

#[test]
fn a_disc_is_open_and_has_no_genus() {
    let disc = graph(5, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]);
    check(&disc, Flaws { boundary: 4, euler: 1, ..SPHERE });
    assert_eq!(of(&disc).genus(), None);
    assert_eq!(of(&disc).shortfalls(), ["4 edges with one triangle only: not closed"]);
}

#[test]
fn a_moebius_strip_is_manifold_but_not_oriented() {
    check(&strip(5, false), Flaws { boundary: 10, euler: 0, ..SPHERE });
    check(&strip(5, true), Flaws { boundary: 10, inconsistent: 1, euler: 0, ..SPHERE });
    assert!(of(&strip(5, true)).is_manifold());
}

#[test]
fn three_triangles_on_an_edge_are_not_manifold() {
    let fins = graph(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
    let flaws = Flaws { boundary: 6, nonmanifold_edges: 1, nonmanifold_vertices: 2, ..SPHERE };
    check(&fins, Flaws { euler: 1, ..flaws });
}

#[test]
fn three_triangles_that_pass_an_edge_in_one_direction_are_inconsistent() {
    let fins = graph(5, &[[0, 1, 2], [0, 1, 3], [0, 1, 4]]);
    let flaws = Flaws { boundary: 6, nonmanifold_edges: 1, nonmanifold_vertices: 2, ..SPHERE };
    check(&fins, Flaws { inconsistent: 1, euler: 1, ..flaws });
}

#[test]
fn cubes_that_touch_in_an_edge_are_one_closed_oriented_piece() {
    let upper = moved(&cube(), |x| x + 1.0);
    let mut both = TriMesh::joined(&[cube(), upper]).unwrap();
    // The cubes touch in one corner; sharing a neighbour of it too makes an edge.
    both.triangles.iter_mut().flatten().for_each(|v| {
        *v = match *v {
            8 => 7,
            9 => 6,
            v => v,
        }
    });
    let flaws = Flaws { unused: 2, nonmanifold_edges: 1, nonmanifold_vertices: 2, ..SPHERE };
    check(&both, Flaws { euler: 3, ..flaws });
    assert!(of(&both).is_closed() && of(&both).is_oriented() && !of(&both).is_manifold());
}

#[test]
fn pieces_that_touch_in_a_vertex_stay_two_and_sound() {
    let bow_tie = graph(7, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
    let mut both = bow_tie.clone();
    let renamed = |v: u32| if v == 0 { 0 } else { v + 3 };
    both.triangles.extend(bow_tie.triangles.iter().map(|triangle| triangle.map(renamed)));
    check(&both, Flaws { nonmanifold_vertices: 1, components: 2, euler: 3, ..SPHERE });
    let sound = |component: &Component| (component.nonmanifold_vertices, component.genus());
    assert!(of(&both).components.iter().all(|component| sound(component) == (0, Some(0))));
    assert!(!of(&both).is_manifold());
}

#[test]
fn a_piece_that_touches_itself_in_a_vertex_is_not_sound() {
    let mut torus = torus(8);
    // One vertex takes the place of another far away.
    torus.triangles.iter_mut().flatten().for_each(|v| *v = if *v == 36 { 0 } else { *v });
    check(&torus, Flaws { unused: 1, nonmanifold_vertices: 1, euler: -1, ..SPHERE });
    let component = of(&torus).components[0];
    assert_eq!((component.nonmanifold_vertices, component.genus()), (1, None));
}

#[test]
fn a_triangle_there_twice_is_a_duplicate() {
    let mut mesh = tetrahedron();
    mesh.triangles.push([1, 0, 2]);
    let flaws = Flaws { duplicate: 1, nonmanifold_edges: 3, nonmanifold_vertices: 3, ..SPHERE };
    // Each of its edges is passed twice in one direction, once in the other: a fin, wound as it may be.
    check(&mesh, Flaws { euler: 3, ..flaws });
    mesh.triangles.push([0, 1, 2]);
    check(&mesh, Flaws { duplicate: 2, euler: 4, ..flaws });
    mesh.triangles.extend([[1, 0, 2], [1, 0, 2]]);
    check(&mesh, Flaws { duplicate: 4, inconsistent: 3, euler: 6, ..flaws });
}

#[test]
fn two_sides_of_one_triangle_are_closed_but_duplicate() {
    let pillow = graph(3, &[[0, 1, 2], [2, 1, 0]]);
    check(&pillow, Flaws { duplicate: 1, ..SPHERE });
    assert_eq!(of(&pillow).shortfalls(), ["1 triangle there more than once"]);
}

#[test]
fn a_flipped_triangle_is_wound_against_its_three_neighbours() {
    let mut mesh = sphere(2);
    mesh.triangles[17].reverse();
    check(&mesh, Flaws { inconsistent: 3, ..SPHERE });
    assert_eq!(of(&mesh).genus(), None);
}

#[test]
fn triangles_without_area_are_degenerate_but_keep_the_surface_closed() {
    let mut coincident = tetrahedron();
    positions(&mut coincident)[3] = [0.0; 3];
    check(&coincident, Flaws { degenerate: 2, ..SPHERE });
    let mut collinear = tetrahedron();
    positions(&mut collinear)[3] = [0.1, 0.0, 0.0];
    check(&collinear, Flaws { degenerate: 1, ..SPHERE });
}

#[test]
fn a_vertex_named_twice_is_degenerate_and_no_neighbour() {
    let mut mesh = tetrahedron();
    mesh.triangles.extend([[0, 0, 1], [1, 2, 1], [3, 3, 3]]);
    check(&mesh, Flaws { degenerate: 3, ..SPHERE });
    assert_eq!(of(&mesh).shortfalls(), ["3 triangles without area"]);
}

#[test]
fn missing_and_unfinite_vertices_are_counted_and_left_out() {
    let mut mesh = cube();
    positions(&mut mesh).push([0.0, f64::NAN, 0.0]);
    positions(&mut mesh).push([f64::NEG_INFINITY, 0.0, 0.0]);
    mesh.triangles.extend([[0, 1, 10], [u32::MAX, u32::MAX, 0]]);
    check(&mesh, Flaws { unused: 2, non_finite: 2, out_of_range: 2, ..SPHERE });
    assert_eq!((of(&mesh).measure.area, of(&mesh).measure.volume), (6.0, 1.0));
    let lines = ["2 triangles naming a missing vertex", "2 vertices not finite"];
    assert_eq!(of(&mesh).shortfalls(), lines);

    let mut mesh = cube();
    positions(&mut mesh)[7] = [f64::NAN; 3];
    check(&mesh, Flaws { non_finite: 1, ..SPHERE });
    assert!(of(&mesh).measure.area.is_finite());
}

#[test]
fn unused_vertices_are_counted_but_do_no_harm() {
    let mut mesh = cube();
    positions(&mut mesh).extend([[9.0; 3]; 5]);
    check(&mesh, Flaws { unused: 5, ..SPHERE });
    assert_eq!(of(&mesh).shortfalls(), Vec::<String>::new());
}

#[test]
fn an_empty_mesh_is_a_surface() {
    check(&mesh(&[], &[]), Flaws { components: 0, euler: 0, ..SPHERE });
    assert_eq!(of(&mesh(&[], &[])), Topology::default());
    assert_eq!(of(&mesh(&[], &[])).shortfalls(), Vec::<String>::new());
    // No vertex, and triangles that name some.
    let flaws = Flaws { out_of_range: 1, components: 0, euler: 0, ..SPHERE };
    check(&mesh(&[], &[[0, 1, 2]]), flaws);
}

#[test]
fn inside_out_is_told_for_the_whole_and_not_for_cavities() {
    let mut cavity = moved(&cube(), |x| 0.25 + x / 2.0);
    cavity.triangles.iter_mut().for_each(|triangle| triangle.reverse());
    let hollow = TriMesh::joined(&[cube(), cavity.clone()]).unwrap();
    let volumes: Vec<f64> = of(&hollow).components.iter().map(|c| c.volume).collect();
    assert_eq!(volumes, [1.0, -0.125]);
    assert_eq!(of(&hollow).shortfalls(), Vec::<String>::new());
    assert_eq!(of(&cavity).shortfalls(), ["inside out: the volume is -0.125"]);
}

#[test]
fn a_vertex_of_many_triangles_is_as_good_as_any() {
    let n = 1000;
    let rim = (0..n).map(|i| (i + 2, (i + 1) % n + 2));
    let triangles: Vec<_> = rim.flat_map(|(a, b)| [[0, a, b], [1, b, a]]).collect();
    check(&graph(n + 2, &triangles), SPHERE);
}

#[test]
fn a_cancelled_check_stops_and_a_limit_holds() {
    let job = Job::default();
    job.cancel.cancel();
    assert_eq!(topology(&cube(), &job), Err(Stopped::Cancelled(Cancelled)));
    let job = Job { limits: Limits { bytes: 100 }, ..Job::default() };
    assert!(matches!(topology(&cube(), &job), Err(Stopped::OverLimit(_))));
}

#[test]
fn the_whole_is_measured_as_by_measure() {
    let (sphere, job) = (sphere(6), Job::default());
    assert_eq!(of(&sphere).measure, crate::measure(&sphere, &job).unwrap());
}

#[test]
fn progress_ends_where_it_said() {
    let job = Job::default();
    topology(&sphere(3), &job).unwrap();
    assert_eq!(job.progress.snapshot().done, job.progress.snapshot().total);
}
