//! Distances and windings of meshes that are known, of chance, and of broken ones.

use super::{Inside, MeshSolid, SolidError, SolidOptions, Winding};
use crate::kit::{Chance, ball, bowl, cube, mesh, moved, turned};
use isokit_geom::vector::{cross, dot, length, sub};
use isokit_job::Job;
use isokit_mesh::TriMesh;
use std::f64::consts::TAU;

fn solid(mesh: &TriMesh) -> MeshSolid {
    MeshSolid::new(mesh, SolidOptions::default(), &Job::default()).unwrap()
}

fn as_it_is(mesh: &TriMesh) -> MeshSolid {
    let options = SolidOptions { winding: Winding::AsItIs, ..SolidOptions::default() };
    MeshSolid::new(mesh, options, &Job::default()).unwrap()
}

/// The nearest point by halving what is left of a triangle's two parameters: slow, plain, and the same for any triangle.
fn distance_by_search([a, b, c]: [[f64; 3]; 3], p: [f64; 3]) -> f64 {
    let at = |u: f64, v: f64| {
        let q: [f64; 3] = [0, 1, 2].map(|k| a[k] + u * ((b[k] - a[k]) + v * (c[k] - b[k])) - p[k]);
        length(q)
    };
    let least = |f: &dyn Fn(f64) -> f64| {
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        for _ in 0..48 {
            let (x, y) = (low + (high - low) * 0.382, low + (high - low) * 0.618);
            if f(x) < f(y) { high = y } else { low = x }
        }
        f(0.5 * (low + high)).min(f(0.0)).min(f(1.0))
    };
    least(&|u| least(&|v| at(u, v)))
}

/// The sum of all solid angles over 4π, in the plainest way.
fn plain_winding(mesh: &TriMesh, p: [f64; 3]) -> f64 {
    let angle = |&t: &[u32; 3]| {
        let [a, b, c] = mesh.corners(t).map(|corner| sub(corner, p));
        let [x, y, z] = [a, b, c].map(length);
        let rest = x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y;
        2.0 * dot(a, cross(b, c)).atan2(rest)
    };
    mesh.triangles.iter().map(angle).sum::<f64>() / (2.0 * TAU)
}

#[test]
fn a_distance_is_the_least_of_those_to_all_triangles() {
    let mut chance = Chance(1);
    let flat = |mesh: TriMesh| moved(&mesh, |[x, y, _]| [x, y, 0.25]);
    for round in 0..46 {
        let soup = chance.soup(1 + round % 23);
        let soup = if round % 5 == 0 { flat(soup) } else { soup };
        let found = solid(&soup);
        for _ in 0..6 {
            let p = chance.point().map(|c| 1.5 * c);
            let all = soup.triangles.iter().map(|&t| distance_by_search(soup.corners(t), p));
            let least = all.fold(f64::INFINITY, f64::min);
            let closest = found.closest(p).unwrap();
            assert!((closest.distance - least).abs() < 1e-8, "{} is not {least}", closest.distance);
            assert!((length(sub(p, closest.point)) - closest.distance).abs() < 1e-12);
            let own = soup.corners(soup.triangles[closest.triangle as usize]);
            assert!((distance_by_search(own, p) - least).abs() < 1e-8);
        }
    }
}

#[test]
fn a_needle_is_as_far_as_its_edges() {
    for height in [1e-4, 1e-7, 1e-9, 1e-12, 0.0] {
        let needle = mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [0.4, height, 0.0]], &[[0, 1, 2]]);
        let found = solid(&needle);
        for p in [[0.5, 0.0, 0.1], [-0.3, 0.0, 0.4], [1.3, -0.4, 0.0], [0.25, 0.5 * height, 2.0]] {
            let least = distance_by_search(needle.corners([0, 1, 2]), p);
            assert!((found.closest(p).unwrap().distance - least).abs() < 2e-8, "{height} {p:?}");
        }
    }
}

#[test]
fn a_closed_surface_winds_a_whole_number_of_times() {
    let small = moved(&ball(9), |p| p.map(|c| 0.3 * c));
    for (mesh, at_middle) in [
        (cube(), 1.0),
        (ball(12), 1.0),
        (turned(&ball(12)), -1.0),
        (TriMesh::joined(&[cube(), turned(&small)]).unwrap(), 0.0),
        (TriMesh::joined(&[cube(), small]).unwrap(), 2.0),
    ] {
        let found = as_it_is(&mesh);
        assert_eq!(found.flaws().open_edges, 0);
        let mut chance = Chance(2);
        for _ in 0..200 {
            let winding = found.winding(chance.point().map(|c| 2.0 * c), 0.0);
            assert!((winding - winding.round()).abs() < 1e-9, "{winding}");
        }
        assert!((found.winding([0.01, 0.02, 0.03], 0.0) - at_middle).abs() < 1e-12);
        assert!(found.winding([2.0, 3.0, 4.0], 0.0).abs() < 1e-12);
    }
}

#[test]
fn a_winding_is_the_sum_of_solid_angles_but_for_its_allowance() {
    let mut chance = Chance(3);
    for mesh in [ball(40), chance.soup(300), cube()] {
        let found = as_it_is(&mesh);
        let flipped = as_it_is(&turned(&mesh));
        for _ in 0..40 {
            let p = chance.point().map(|c| 2.5 * c);
            let plain = plain_winding(&mesh, p);
            // Doubled triangles of chance are few; a soup of 300 has none.
            for allowance in [0.0, 1e-6, 1e-3, 0.1, 1.0] {
                let error = (found.winding(p, allowance) - plain).abs();
                assert!(error <= allowance + 1e-9, "{error} of {allowance}");
                let sum = found.winding(p, allowance) + flipped.winding(p, allowance);
                assert!(sum.abs() < 1e-9, "turned over it is the negative");
            }
        }
    }
}

#[test]
fn windings_of_parts_add_up() {
    let (a, b) = (ball(10), moved(&cube(), |p| [p[0] + 0.7, p[1], p[2]]));
    let both = as_it_is(&TriMesh::joined(&[a.clone(), b.clone()]).unwrap());
    let (a, b) = (as_it_is(&a), as_it_is(&b));
    let mut chance = Chance(4);
    for _ in 0..200 {
        let p = chance.point().map(|c| 2.0 * c);
        let sum = a.winding(p, 0.0) + b.winding(p, 0.0);
        assert!((both.winding(p, 0.0) - sum).abs() < 1e-9);
    }
}

#[test]
fn a_ball_with_a_hole_is_a_ball_still() {
    let cap = solid(&bowl(0.8));
    assert!(cap.flaws().open_edges > 0);
    let mut chance = Chance(5);
    for _ in 0..300 {
        let p = chance.point();
        // Where the hole is, a lid is put that is seen under half of all directions.
        if p[2] < 0.6 && (length(p) - 1.0).abs() > 0.01 {
            assert_eq!(cap.is_inside(p), length(p) < 1.0, "{p:?}");
        }
    }
    // More than half of it is gone: nothing is seen under enough.
    assert!(!solid(&bowl(-0.5)).is_inside([0.0; 3]));
}

#[test]
fn a_ball_that_is_wound_inside_out_is_a_ball() {
    let found = solid(&turned(&ball(12)));
    assert!(found.is_inside([0.0; 3]) && !found.is_inside([2.0, 0.0, 0.0]));
    let options = SolidOptions { inside: Inside::Outward, ..SolidOptions::default() };
    let strict = MeshSolid::new(&turned(&ball(12)), options, &Job::default()).unwrap();
    assert!(!strict.is_inside([0.0; 3]));
}

#[test]
fn faces_that_are_turned_over_are_turned_back() {
    let mut mixed = ball(12);
    let mut chance = Chance(6);
    let mut turned = 0;
    for triangle in &mut mixed.triangles {
        if chance.below(4) == 0 {
            triangle.swap(0, 1);
            turned += 1;
        }
    }
    let found = solid(&mixed);
    assert_eq!((found.flaws().turned, found.flaws().open_edges), (turned, 0));
    for _ in 0..300 {
        let p = chance.point();
        if (length(p) - 0.985).abs() > 0.02 {
            assert_eq!(found.is_inside(p), length(p) < 0.985, "{p:?}");
        }
    }
    assert!(as_it_is(&mixed).flaws().open_edges > 0);
}

#[test]
fn faces_twice_over_count_once() {
    let mut doubled = cube();
    doubled.triangles.extend_from_within(3..9);
    doubled.triangles.push([0, 6, 4]); // against the first, [0, 4, 6]
    let found = solid(&doubled);
    assert_eq!((found.flaws().doubled, found.flaws().back_to_back), (6, 2));
    let mut doubled = cube();
    doubled.triangles.extend_from_within(..);
    let found = solid(&doubled);
    assert_eq!((found.flaws().doubled, found.flaws().open_edges), (12, 0));
    assert!((found.winding([0.1, 0.2, 0.3], 0.0) - 1.0).abs() < 1e-12);
}

#[test]
fn a_mesh_that_is_seen_from_both_sides_is_solid() {
    let both = TriMesh::joined(&[cube(), turned(&cube())]).unwrap();
    let found = solid(&both);
    assert_eq!((found.flaws().back_to_back, found.flaws().open_edges), (24, 0));
    assert!(found.is_inside([0.3, 0.2, 0.1]) && !found.is_inside([0.3, 0.2, 1.1]));
}

#[test]
fn a_sheet_within_a_cube_changes_nothing_but_distances() {
    let sheet = mesh(&[[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.0, 0.5, 0.0]], &[[0, 1, 2]]);
    let both = TriMesh::joined(&[cube(), sheet.clone(), turned(&sheet)]).unwrap();
    let found = solid(&both);
    for z in [-0.01, 0.01] {
        assert!((found.signed_distance([0.0, 0.0, z]) - 0.01).abs() < 1e-12);
    }
}

#[test]
fn what_is_no_mesh_is_refused_with_the_place() {
    let of = |mesh: &TriMesh| MeshSolid::new(mesh, SolidOptions::default(), &Job::default());
    assert_eq!(of(&mesh(&[], &[])).unwrap_err(), SolidError::Empty);
    for bad in [f64::NAN, f64::INFINITY] {
        let mut broken = cube();
        broken.positions =
            moved(&broken, |p| if p == [1.0; 3] { [1.0, bad, 1.0] } else { p }).positions;
        let error = of(&broken).unwrap_err().to_string();
        let expected =
            format!("triangle 2, vertex 7: expected finite coordinates, found [1.0, {bad:?}, 1.0]");
        assert_eq!(error, expected);
    }
    let error = of(&mesh(&[[0.0; 3]], &[[0, 0, 4]])).unwrap_err().to_string();
    assert_eq!(error, "triangle 0 names vertex 4, of 1");
    let point = solid(&mesh(&[[5.0; 3]], &[[0, 0, 0]]));
    assert_eq!(point.signed_distance([5.0, 5.0, 7.0]), -2.0);
    assert!(
        point.signed_distance([f64::NAN; 3]).is_nan() && point.closest([f64::NAN; 3]).is_none()
    );
}

#[test]
fn far_from_the_origin_and_in_any_size_answers_are_the_same() {
    let near = solid(&cube());
    for (size, shift) in [(1.0, 1e6), (1e-30, 0.0), (1e30, 0.0), (1e-3, 1.0)] {
        let far = solid(&moved(&cube(), |p| p.map(|c| c * size + shift)));
        let mut chance = Chance(7);
        for _ in 0..50 {
            let p = chance.point().map(|c| 2.0 * c);
            let found = far.signed_distance(p.map(|c| c * size + shift)) / size;
            assert!((found - near.signed_distance(p)).abs() < 1e-9, "{size} {shift}");
        }
    }
}
