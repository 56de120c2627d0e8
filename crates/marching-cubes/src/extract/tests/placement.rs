//! Vertices on curves against those on straight lines: the same triangles, on the same edges.

use super::{all_options, chance};
use crate::{Degenerate, ExtractOptions, Gradient, Placement, extract};
use isokit_geom::Frame;
use isokit_job::Job;
use isokit_mesh::TriMesh;
use isokit_volume::{Bricks, Grid, Sample, Volume};

const CURVED: [Placement; 2] = [Placement::Cubic, Placement::Quintic];

/// With normals from as many samples.
const MATCHING: ExtractOptions = ExtractOptions::DEFAULT.with_gradient(Gradient::Matching);

fn mesh<T: Sample>(volume: &Volume<T>, iso: f64, options: &ExtractOptions) -> TriMesh {
    extract(&volume.view(), iso, options, &Job::default()).unwrap()
}

fn made<T: Sample>(dims: [u64; 3], mut sample: impl FnMut([u64; 3]) -> T) -> Volume<T> {
    let grid = Grid::new(dims, Frame::default()).unwrap();
    let at = |n: u64| sample([n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]]);
    Volume::new(grid, (0..grid.count()).map(at).collect()).unwrap()
}

/// Asserts that nothing but places along edges and normals differs; gives how many places do, by more than f32 rounds.
#[track_caller]
fn check<T: Sample>(volume: &Volume<T>, iso: f64, options: &ExtractOptions) -> usize {
    let options = options.clone().with_placement(Placement::Linear);
    let linear = mesh(volume, iso, &options);
    assert!(mesh(volume, iso, &options.clone().with_gradient(Gradient::Matching)) == linear);
    let mut moved = 0;
    for placement in CURVED {
        let options = options.clone().with_placement(placement);
        let found = mesh(volume, iso, &options);
        let matching = mesh(volume, iso, &options.with_gradient(Gradient::Matching));
        assert!(matching.positions == found.positions && matching.triangles == found.triangles);
        assert_eq!(found.triangles, linear.triangles);
        for (found, linear) in found.positions.iter().zip(linear.positions.iter()) {
            let off: Vec<usize> = (0..3).filter(|&axis| found[axis] != linear[axis]).collect();
            let [] = off[..] else {
                let [axis] = off[..] else { panic!("{found:?} is off the edge of {linear:?}") };
                // An edge without its ends has one whole number below; a vertex may also be at an end.
                let low = linear[axis].min(found[axis]).floor();
                let is_within = linear[axis].max(found[axis]) <= low + 1.0;
                assert!(is_within, "{found:?} is beyond the end of {linear:?}");
                moved += usize::from((found[axis] - linear[axis]).abs() > 1e-6);
                continue;
            };
        }
        for normal in found.normals.unwrap().into_iter().chain(matching.normals.unwrap()) {
            let length = normal.iter().map(|c| c * c).sum::<f32>().sqrt();
            assert!((length - 1.0).abs() < 1e-6, "{normal:?}");
        }
    }
    moved
}

#[test]
fn in_noise_at_steps_and_at_ties_no_vertex_leaves_its_edge() {
    let sizes = [[1, 1, 1], [2, 2, 2], [3, 4, 5], [6, 1, 7], [12, 11, 10]];
    let mut moved = 0;
    for (seed, dims) in (0..).zip(sizes.repeat(3)) {
        for options in all_options() {
            moved += check(&chance(dims, seed, |r| (r % 2) as u8 * 255), 127.5, &options);
            moved += check(&chance(dims, seed, |r| (r % 2) as f32), 0.25, &options);
            moved += check(&chance(dims, seed, |r| (r % 7) as i8 - 3), 0.0, &options);
            moved += check(&chance(dims, seed, |r| (r % 1000) as f64 * 1e-3), 0.3, &options);
            moved += check(&chance(dims, seed, |r| f32::from_bits(r as u32)), 1.0, &options);
            let step = |r: u64| if r.is_multiple_of(9) { f64::NAN } else { (r % 90) as f64 };
            moved += check(&chance(dims, seed, step), 40.0, &options);
        }
    }
    assert!(moved > 1000, "only {moved} vertices are on curves");
}

#[test]
fn at_a_noisy_step_every_curve_stays_in_the_cell_of_the_step() {
    let mut state = 1_u64;
    let mut noise = || {
        state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        (state >> 40) as f64 / 2_f64.powi(24) - 0.5
    };
    let step = made([16, 12, 12], |[x, ..]| if x < 8 { 0.0 } else { 100.0 } + 20.0 * noise());
    assert!(check(&step, 50.0, &ExtractOptions::DEFAULT) > 100);
    for placement in CURVED {
        let options = ExtractOptions::DEFAULT.with_boundary(crate::Boundary::Open);
        let mesh = mesh(&step, 50.0, &options.with_placement(placement));
        let is_near = mesh.positions.iter().all(|place| (place[0] - 7.5).abs() < 0.2);
        assert!(is_near && mesh.positions.len() == 144);
    }
}

#[test]
fn a_linear_field_is_placed_as_by_lines() {
    for dims in [[1, 3, 5], [2, 2, 2], [9, 8, 7]] {
        let slope = made(dims, |[i, j, k]| (3 * i + 5 * j) as i32 - 7 * k as i32);
        for options in all_options() {
            for iso in [-8.0, 1.0, 4.5] {
                assert_eq!(check(&slope, iso, &options), 0);
            }
        }
    }
}

#[test]
fn a_checkerboard_is_placed_as_by_lines_away_from_its_border() {
    let is_white = |[i, j, k]: [u64; 3]| (i + j + k).is_multiple_of(2);
    let board = made([12; 3], |ijk| if is_white(ijk) { 1_i8 } else { -1 });
    check(&board, 0.0, &ExtractOptions::DEFAULT);
    let all = [Placement::Linear, Placement::Cubic, Placement::Quintic].map(|placement| {
        let mesh = mesh(&board, 0.0, &ExtractOptions::DEFAULT.with_placement(placement));
        let is_inner = |place: &[f64; 3]| place.iter().all(|c| (2.0..=9.0).contains(c));
        mesh.positions.iter().filter(is_inner).collect::<Vec<_>>()
    });
    assert_eq!(all[0].len(), 3 * 7 * 8 * 8);
    assert!(all[1] == all[0] && all[2] == all[0]);
}

/// A soft ball whose samples are whole numbers up to 120.
fn ball(ijk: [u64; 3]) -> f64 {
    let from = [6.3, 7.1, 5.9];
    let square: f64 = (0..3).map(|k| (ijk[k] as f64 - from[k]).powi(2)).sum();
    (120.0 * (-square / 20.0).exp()).round()
}

#[test]
fn every_type_of_sample_gives_the_same_bytes() {
    fn same<T: Sample>(sample: impl Fn(f64) -> T, expected: &[TriMesh]) {
        let volume = made([14, 13, 12], |ijk| sample(ball(ijk)));
        for (placement, expected) in CURVED.into_iter().zip(expected) {
            let options = MATCHING.with_placement(placement);
            assert!(mesh(&volume, 40.25, &options) == *expected, "{placement:?}");
        }
    }
    let doubles = made([14, 13, 12], ball);
    let expected =
        CURVED.map(|placement| mesh(&doubles, 40.25, &MATCHING.with_placement(placement)));
    assert!(check(&doubles, 40.25, &ExtractOptions::DEFAULT) > 500);
    same(|value| value as u8, &expected);
    same(|value| value as i8, &expected);
    same(|value| value as u16, &expected);
    same(|value| value as i16, &expected);
    same(|value| value as u32, &expected);
    same(|value| value as i32, &expected);
    same(|value| value as f32, &expected);
}

#[test]
fn bricks_change_nothing() {
    let volume = made([70, 13, 12], |[i, j, k]| ball([i % 14, j, k]) as u8);
    for placement in CURVED {
        let options = MATCHING.with_placement(placement);
        let (view, job) = (volume.view(), Job::default());
        let bricks = Bricks::of(&view, &job).unwrap();
        let source = crate::Source::with_bricks(&view, &bricks).unwrap();
        let mut found = [TriMesh::with_normals()];
        let mut sinks: Vec<_> = found.iter_mut().map(TriMesh::refill).collect();
        crate::extract_many(source, &[40.0], &options, &mut sinks, &job).unwrap();
        drop(sinks);
        assert!(found[0] == mesh(&volume, 40.0, &options), "{placement:?}");
    }
}

#[test]
fn a_missing_sample_matters_to_those_that_need_it_only() {
    let options = MATCHING.with_degenerate(Degenerate::Exact);
    let whole = made([30, 13, 12], ball);
    for x in [10, 12, 25] {
        let hole = made([30, 13, 12], |ijk| if ijk == [x, 7, 6] { f64::NAN } else { ball(ijk) });
        assert!(check(&hole, 40.0, &options) > 500);
        let [cubic, quintic] = CURVED.map(|placement| {
            let options = options.clone().with_placement(placement);
            mesh(&whole, 40.0, &options) == mesh(&hole, 40.0, &options)
        });
        // The last edge ends at 11; a cubic's differences look four samples farther, the others seven.
        assert_eq!([cubic, quintic], [x > 15, x > 18], "{x}");
    }
}
