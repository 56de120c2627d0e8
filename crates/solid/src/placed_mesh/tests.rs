//! Meshes on lattices keep the laws of fields, agree with voxels, and have the slopes of their faces.

use super::PlacedMesh;
use crate::{
    Inside, MeshSolid, SolidOptions, VoxelOptions, Winding,
    kit::{Chance, ball, bowl, broken, cube, mesh, moved, turned},
    voxelize,
};
use isokit_field::{FieldSamples, Interval, ScalarField, Slope, conformance::check, sample};
use isokit_geom::{
    Aabb, Affine, Frame,
    vector::{dot, length, sub},
};
use isokit_job::Job;
use isokit_mesh::TriMesh;
use isokit_volume::{AnyVolume, Grid};

fn solid(mesh: &TriMesh) -> MeshSolid {
    MeshSolid::new(mesh, SolidOptions::default(), &Job::default()).unwrap()
}

fn as_it_is(mesh: &TriMesh) -> MeshSolid {
    let options = SolidOptions { winding: Winding::AsItIs, ..SolidOptions::default() };
    MeshSolid::new(mesh, options, &Job::default()).unwrap()
}

fn grid(dims: [u64; 3], index_to_world: Affine) -> Grid {
    Grid::new(dims, Frame { index_to_world, ..Frame::default() }).unwrap()
}

/// From −1.5 to 1.5, with samples on faces, edges and corners of the cube, and above their diagonals.
fn even() -> Grid {
    grid([13; 3], Affine::axis_aligned([0.25; 3], [-1.5; 3]).unwrap())
}

fn oblique() -> Grid {
    let columns = [[0.11, 0.02, 0.0], [-0.03, 0.17, 0.04], [0.01, 0.0, 0.2]];
    grid([23, 17, 18], Affine::new(columns, [-1.2, -1.6, -2.0]).unwrap())
}

/// The lattice whose index space is the world.
fn world() -> Grid {
    grid([2; 3], Affine::IDENTITY)
}

/// Three triangles of a needle, a point and an edge.
fn thin() -> TriMesh {
    let places = [[-0.9, 0.1, 0.2], [0.9, 0.1, 0.2], [0.1, 0.1 + 1e-9, 0.2], [0.5; 3]];
    mesh(&places, &[[0, 1, 2], [3, 3, 3], [0, 3, 0]])
}

/// The cube with each face of so many squares along a side.
fn divided(n: u32) -> TriMesh {
    let mut all = TriMesh::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let place = |i: u32, j: u32| {
                let [u, v] = [i, j].map(|c| 2.0 * f64::from(c) / f64::from(n) - 1.0);
                let mut place = [side; 3];
                (place[(axis + 1) % 3], place[(axis + 2) % 3]) = (u, side * v);
                place
            };
            let name = |i: u32, j: u32| j * (n + 1) + i;
            let squares = (0..n * n).map(|k| [k % n, k / n]);
            let two = |[i, j]: [u32; 2]| {
                let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
                [[a, b, c], [a, c, d]]
            };
            let places: Vec<_> = (0..=n).flat_map(|j| (0..=n).map(move |i| place(i, j))).collect();
            let face = mesh(&places, squares.map(two).collect::<Vec<_>>().as_flattened());
            all = if all.triangles.is_empty() {
                face
            } else {
                TriMesh::joined(&[all, face]).unwrap()
            };
        }
    }
    all
}

fn meshes() -> Vec<TriMesh> {
    let sheet = mesh(&[[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.0, 0.5, 0.0]], &[[0, 1, 2]]);
    let within = TriMesh::joined(&[cube(), sheet.clone(), turned(&sheet)]).unwrap();
    vec![
        cube(),
        divided(4),
        ball(12),
        turned(&ball(7)),
        bowl(0.8),
        bowl(0.1),
        broken(),
        TriMesh::joined(&[ball(6), cube()]).unwrap(),
        TriMesh::joined(&[cube(), turned(&cube())]).unwrap(),
        sheet,
        within,
        thin(),
        Chance(3).soup(30),
    ]
}

#[test]
fn meshes_conform_be_they_closed_open_or_broken() {
    for mesh in meshes() {
        for solid in [solid(&mesh), as_it_is(&mesh)] {
            for grid in [even(), oblique()] {
                check(&solid.placed(&grid));
            }
        }
    }
}

#[test]
fn far_from_the_origin_and_in_any_size_meshes_conform() {
    for (size, shift) in [(1e-3, 1.0), (1e6, 0.0), (1.0, 1e5)] {
        let solid = solid(&moved(&cube(), |p| p.map(|c| c * size + shift)));
        let affine = Affine::axis_aligned([0.3 * size; 3], [shift - 1.7 * size; 3]).unwrap();
        check(&solid.placed(&grid([12; 3], affine)));
    }
}

#[test]
fn samples_of_the_field_are_those_of_voxels_to_the_bit() {
    for mesh in meshes() {
        for solid in [solid(&mesh), as_it_is(&mesh)] {
            for grid in [even(), oblique()] {
                let (field, job) = (solid.placed(&grid), Job::default());
                let samples = FieldSamples::new(&field, grid.frame).unwrap();
                let found = sample::<f32>(samples, &job).unwrap();
                let voxels = voxelize(&solid, grid, &VoxelOptions::default(), &job).unwrap();
                let AnyVolume::F32(voxels) = voxels else { panic!("{:?}", voxels.dtype()) };
                assert_eq!(found.grid(), voxels.grid());
                let bits =
                    |samples: &[f32]| samples.iter().map(|d| d.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(found.samples()), bits(voxels.samples()));
            }
        }
    }
}

#[test]
fn values_are_signed_distances_of_the_world() {
    let (solid, grid) = (solid(&broken()), oblique());
    let mut chance = Chance(21);
    for _ in 0..200 {
        let ijk = chance.point().map(|c| 12.0 * c + 9.0);
        let xyz = grid.frame.index_to_world.point(ijk);
        assert_eq!(solid.placed(&grid).value(ijk), solid.signed_distance(xyz));
    }
}

/// Against the cube from −1 to 1.
#[track_caller]
fn assert_slope(found: Slope, value: f64, gradient: [f64; 3], near: f64) {
    let off = length(sub(found.gradient, gradient)).max((found.value - value).abs());
    assert!(off <= near, "{found:?}, not {value} and {gradient:?}");
}

#[test]
fn slopes_lead_to_the_inside_within_and_without() {
    let (solid, world) = (solid(&cube()), world());
    let field = solid.placed(&world);
    let root = 0.5_f64.sqrt();
    for (place, value, gradient) in [
        ([0.75, 0.1, -0.2], 0.25, [-1.0, 0.0, 0.0]),
        ([1.5, 0.1, -0.2], -0.5, [-1.0, 0.0, 0.0]),
        ([0.3, -0.9, 0.1], 0.1, [0.0, 1.0, 0.0]),
        ([2.0, 2.0, 0.3], -2.0 * root, [-root, -root, 0.0]),
        ([-2.0, 3.0, -3.0], -3.0, [1.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0]),
    ] {
        assert_slope(field.slope(place), value, gradient, 1e-15);
    }
    // In index space it is as much as along a step.
    let affine = Affine::axis_aligned([0.5, 2.0, 0.1], [0.0; 3]).unwrap();
    let long = grid([2; 3], affine);
    assert_slope(solid.placed(&long).slope([1.5, 0.05, -2.0]), 0.25, [-0.5, 0.0, 0.0], 1e-15);
    assert_slope(solid.placed(&long).slope([0.5, 0.75, -2.0]), -0.5, [0.0, -2.0, 0.0], 1e-15);
}

#[test]
fn on_a_face_the_slope_is_the_normal_that_leads_inside() {
    let doubled = {
        let mut all = cube();
        all.triangles.extend_from_within(..);
        all
    };
    let two_sided = TriMesh::joined(&[cube(), turned(&cube())]).unwrap();
    let overlapping = TriMesh::joined(&[cube(), moved(&cube(), |[x, y, z]| [x, 0.9 * y, 0.8 * z])]);
    for mesh in [cube(), turned(&cube()), doubled, two_sided, divided(3), overlapping.unwrap()] {
        let (solid, world) = (solid(&mesh), world());
        let field = solid.placed(&world);
        for n in 0..7 * 7 * 6 {
            let [u, v] = [n % 7, n / 7 % 7].map(|c| c as f64 / 4.0 - 0.75);
            let (axis, side) = (n / 49 % 3, if n < 147 { 1.0 } else { -1.0 });
            // On it, and as near as rounding leads on either side.
            for off in [0.0, 1e-16, -1e-16, 3e-14, -3e-14] {
                let mut place = [side + off; 3];
                (place[(axis + 1) % 3], place[(axis + 2) % 3]) = (u, v);
                let mut gradient = [0.0; 3];
                gradient[axis] = -side;
                assert_slope(field.slope(place), 0.0, gradient, 1e-13);
            }
        }
    }
}

#[test]
fn on_edges_and_corners_it_is_that_of_a_face_there() {
    for mesh in [cube(), turned(&cube()), divided(2)] {
        let (solid, world) = (solid(&mesh), world());
        let field = solid.placed(&world);
        for place in [[1.0, 1.0, 0.3], [1.0, -1.0, 0.0], [-1.0, 0.5, 1.0], [1.0, -1.0, 1.0]] {
            let Slope { value, gradient } = field.slope(place);
            let is_face = |k: usize| place[k].abs() == 1.0 && gradient[k] == -place[k];
            let faces = (0..3).filter(|&k| is_face(k)).count();
            assert!(
                value == 0.0 && faces == 1 && length(gradient) == 1.0,
                "{place:?}: {gradient:?}"
            );
        }
    }
}

#[test]
fn sheets_have_a_slope_and_what_has_no_face_has_none_on_itself() {
    let world = world();
    let sheet = mesh(&[[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.0, 0.5, 0.0]], &[[0, 1, 2]]);
    let back_to_back = TriMesh::joined(&[cube(), sheet.clone(), turned(&sheet)]).unwrap();
    for mesh in [sheet, back_to_back] {
        let found = solid(&mesh).placed(&world).slope([0.1, -0.1, 0.0]);
        assert_slope(found, 0.0, [0.0, 0.0, -1.0], 0.0);
    }
    let needle = solid(&thin());
    let field = needle.placed(&world);
    assert_slope(field.slope([0.5; 3]), 0.0, [0.0; 3], 0.0);
    // Where a face touches what has none, there is one.
    let mut finned = cube();
    finned.triangles.insert(0, [1, 3, 1]);
    let found = solid(&finned).placed(&world).slope([1.0, 0.0, -1.0]);
    assert!(length(found.gradient) == 1.0, "{found:?}");
}

#[test]
fn a_distance_turns_around_edges_and_corners_and_above_faces_not() {
    let world = world();
    for mesh in [cube(), divided(4), divided(5)] {
        let solid = solid(&mesh);
        let field = solid.placed(&world);
        // Above diagonals of faces, and beside corners that lie within faces and edges.
        for [u, v] in [[0.0, 0.0], [0.25, 0.25], [0.5, -0.5], [0.3, 0.1], [0.2, 0.2]] {
            for z in [0.875, 1.5, -1.25, -7.0] {
                assert_eq!(field.jet([u, v, z]).hessian, [[0.0; 3]; 3], "{u}, {v}, {z}");
            }
            // From the edge along z: −√(x² + y²), where x and y are how far it is beyond.
            let jet = field.jet([1.75, 2.0, u]);
            let d = 1.25;
            let expected = [[-0.64, 0.48, 0.0], [0.48, -0.36, 0.0], [0.0; 3]];
            for (found, expected) in jet.hessian.as_flattened().iter().zip(expected.as_flattened())
            {
                assert!((found - expected / d).abs() < 1e-13, "{u}: {jet:?}");
            }
        }
        let jet = field.jet([2.0, 3.0, -3.0]);
        let away = [1.0 / 3.0, 2.0 / 3.0, -2.0 / 3.0];
        for (i, j) in (0..9).map(|n| (n % 3, n / 3)) {
            let one = if i == j { 1.0 } else { 0.0 };
            let expected = -(one - away[i] * away[j]) / 3.0;
            assert!((jet.hessian[i][j] - expected).abs() < 1e-15, "{jet:?}");
        }
    }
    // Inside of a corner that points inwards it bends the other way.
    let hollow = TriMesh::joined(&[
        moved(&cube(), |p| p.map(|c| 3.0 * c)),
        turned(&moved(&cube(), |p| p.map(|c| 0.5 * c))),
    ]);
    let solid = as_it_is(&hollow.unwrap());
    let bend = solid.placed(&world).jet([0.8, 0.9, 0.0]).bend([-0.8, 0.6, 0.0]);
    assert!((bend - 2.0).abs() < 1e-13, "{bend}");
}

#[test]
fn above_what_rounding_takes_for_an_edge_of_a_plane_a_distance_does_not_turn() {
    let rows = [[2.0, -1.0, 2.0], [2.0, 2.0, -1.0], [-1.0, 2.0, 2.0]];
    let rotate = |p: [f64; 3]| rows.map(|row| dot(row, p) / 3.0);
    let (solid, world) = (solid(&moved(&divided(2), rotate)), world());
    let field = solid.placed(&world);
    // Above all edges that lie in the upper face, and the corner in its middle.
    for n in 0..=400 {
        let t = f64::from(2 * n + 1) / 1000.0 - 0.4;
        for [x, y] in [[t, 0.0], [0.0, t], [t, t], [t, t - t.signum()]] {
            let jet = field.jet(rotate([x, y, 1.0 + 0.3 * (t + 0.7)]));
            assert_eq!(jet.hessian, [[0.0; 3]; 3], "{x}, {y}: {jet:?}");
        }
    }
}

#[test]
fn bounds_of_a_closed_mesh_are_no_wider_than_the_box() {
    let (solid, world) = (solid(&cube()), world());
    let field = solid.placed(&world);
    let ijk = Aabb { min: [0.9, -0.1, -0.2], max: [1.0, 0.2, 0.0] };
    let half = 0.5 * length([0.1, 0.3, 0.2]);
    let Interval { low, high } = field.bounds(ijk);
    assert!((low - 0.05 + half).abs() < 1e-12 && (high - 0.05 - half).abs() < 1e-12);
    assert!(low < 0.05 - half && high > 0.05 + half);
    // A point is known as well as that.
    let Interval { low, high } = field.bounds(Aabb { min: [1.5; 3], max: [1.5; 3] });
    assert!(low < -0.75_f64.sqrt() && high > -0.75_f64.sqrt() && high - low < 1e-12);
}

#[test]
fn bounds_hold_both_signs_across_a_face_so_thin_that_it_counts_as_its_edges() {
    let mut split = cube();
    let mut places: Vec<_> = split.positions.iter().collect();
    places.push([0.0, -1.0 + 1e-8, 1.0]);
    // The upper face is corners 4, 5, 7, 6; the one that was added lies beside the edge from 4 to 5.
    split.triangles.retain(|t| !t.iter().all(|v| *v >= 4));
    split.triangles.extend([[4, 5, 8], [5, 7, 8], [7, 6, 8], [6, 4, 8]]);
    let solid = solid(&mesh(&places, &split.triangles));
    assert_eq!((solid.flaws().open_edges, solid.flaws().flat), (0, 0));
    let world = world();
    let field = solid.placed(&world);
    let [min, max] = [-1e-12, 2e-12].map(|off| [0.0, -1.0 + 4e-9, 1.0 + off]);
    let (bounds, values) = (field.bounds(Aabb { min, max }), [min, max].map(|p| field.value(p)));
    assert!(values[0] > 3e-9 && values[1] < -3e-9, "{values:?}");
    assert!(values.iter().all(|value| bounds.contains(*value)), "{bounds:?}, {values:?}");
    assert!(bounds.high - bounds.low < 1e-6);
}

/// Boxes in which the sign changes away from the surface, and how many were known to be on one side.
fn boxes_beside_a_hole(solid: &MeshSolid) -> [usize; 2] {
    let world = world();
    let field: PlacedMesh<'_> = solid.placed(&world);
    let mut chance = Chance(23);
    let (mut changing, mut one_sided) = (0, 0);
    for _ in 0..300 {
        let [x, y, z] = chance.point();
        let (middle, half) = ([0.6 * x, 0.6 * y, 0.2 + z], 0.15 * chance.number().abs());
        let ijk = Aabb { min: middle.map(|c| c - half), max: middle.map(|c| c + half) };
        let bounds = field.bounds(ijk);
        let places = (0..200).map(|_| {
            let part = chance.point();
            [0, 1, 2].map(|k| middle[k] + half * part[k])
        });
        let values: Vec<f64> = places.chain(ijk.corners()).map(|p| field.value(p)).collect();
        assert!(values.iter().all(|value| bounds.contains(*value)), "{ijk:?}: {bounds:?}");
        let nearest = values.iter().fold(f64::INFINITY, |least, value| least.min(value.abs()));
        let [first, ..] = values[..] else { continue };
        let has_both = values.iter().any(|value| (*value < 0.0) != (first < 0.0));
        changing += usize::from(has_both && nearest > 2.0 * half);
        one_sided += usize::from(bounds.low > 0.0 || bounds.high < 0.0);
    }
    [changing, one_sided]
}

#[test]
fn where_a_mesh_is_open_bounds_hold_both_signs_if_there_are_and_mostly_only_then() {
    for mesh in [bowl(0.1), bowl(0.4)] {
        let [changing, one_sided] = boxes_beside_a_hole(&solid(&mesh));
        assert!(changing > 5 && one_sided > 100, "{changing}, {one_sided}");
    }
    let options = SolidOptions { inside: Inside::Outward, ..SolidOptions::default() };
    let outward = MeshSolid::new(&turned(&bowl(0.1)), options, &Job::default()).unwrap();
    let [changing, one_sided] = boxes_beside_a_hole(&outward);
    assert!(changing == 0 && one_sided > 100, "{changing}, {one_sided}");
}

#[test]
fn boxes_that_lead_nowhere_are_unknown() {
    let (solid, world) = (solid(&cube()), world());
    let field = solid.placed(&world);
    for end in [f64::NAN, f64::INFINITY] {
        let ijk = Aabb { min: [0.0; 3], max: [1.0, end, 1.0] };
        assert_eq!(field.bounds(ijk), Interval::EVERYTHING);
        let jet = field.jet([0.0, end, 0.0]);
        let all = jet.gradient.iter().chain(jet.hessian.as_flattened());
        assert!(jet.value.is_nan() && all.into_iter().all(|part| part.is_nan()));
        assert!(!field.is_known([0.0, end, 0.0]));
    }
    assert!(field.is_known([0.0; 3]));
}

#[test]
fn gradients_are_one_long_wherever_there_is_a_way_to_the_surface() {
    let world = world();
    let mut chance = Chance(29);
    for mesh in [ball(9), broken(), bowl(0.3)] {
        let solid = solid(&mesh);
        for _ in 0..100 {
            let place = chance.point();
            let Slope { value, gradient } = solid.placed(&world).slope(place);
            let closest = solid.closest(place).unwrap();
            let way = sub(place, closest.point).map(|c| c / value);
            assert!((length(gradient) - 1.0).abs() < 1e-14 && dot(gradient, way) > 1.0 - 1e-9);
        }
    }
}
