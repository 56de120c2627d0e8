//! Surfaces with bricks against the same without.

use super::{all_options, chance};
use crate::{
    Boundary, ExtractError, ExtractOptions, Nan, Skipped, Source, Topology, count_many, extract,
    extract_many,
};
use isokit_job::Job;
use isokit_mesh::TriMesh;
use isokit_volume::{Bricks, Grid, Sample, Scaling, View, Volume};
use proptest::prelude::*;

/// What was skipped.
#[track_caller]
fn check<T: Sample>(view: &View<'_, T>, isos: &[f64], options: &ExtractOptions) -> Skipped {
    let of = |topology| check_one(view, isos, &options.clone().with_topology(topology));
    assert_eq!(of(Topology::Table), of(Topology::Trilinear));
    of(Topology::Table)
}

#[track_caller]
fn check_one<T: Sample>(view: &View<'_, T>, isos: &[f64], options: &ExtractOptions) -> Skipped {
    let job = Job::default();
    let bricks = Bricks::of(view, &job).unwrap();
    let source = Source::with_bricks(view, &bricks).unwrap();
    let mut meshes = vec![TriMesh::with_normals(); isos.len()];
    let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
    let all = extract_many(source, isos, options, &mut sinks, &job).unwrap();
    drop(sinks);
    for (mesh, &iso) in meshes.iter().zip(isos) {
        let expected = extract(view, iso, options, &job).unwrap();
        assert_eq!(*mesh, expected, "{iso} of {isos:?}, {:?}, {options:?}", view.dims());
    }
    let counts: Vec<_> = meshes.iter().map(TriMesh::counts).collect();
    assert_eq!(count_many(source, isos, options, &job).unwrap(), counts);
    all.first().map_or(Skipped::default(), |one| one.skipped)
}

/// Depth in a ball, in steps, so that whole bricks have one value and ties are many.
fn ball<T: Sample>(dims: [u64; 3], step: f64, make: fn(f64) -> T) -> Volume<T> {
    let grid = Grid::new(dims, Default::default()).unwrap();
    let [nx, ny, _] = dims.map(|n| n as usize);
    let sample = |n: usize| {
        let place = [n % nx, n / nx % ny, n / nx / ny];
        let from = std::array::from_fn::<f64, 3, _>(|k| place[k] as f64 - dims[k] as f64 / 2.0);
        let square: f64 = from.iter().map(|c| c * c).sum();
        make(((40.0 - square.sqrt()) / step).round() * step)
    };
    Volume::new(grid, (0..grid.count() as usize).map(sample).collect()).unwrap()
}

const SIZES: [[u64; 3]; 10] = [
    [1, 1, 1],
    [2, 9, 17],
    [64, 8, 8],
    [65, 9, 9],
    [66, 10, 10],
    [63, 17, 1],
    [128, 20, 3],
    [129, 1, 25],
    [130, 30, 18],
    [257, 24, 26],
];

#[test]
fn a_ball_is_the_same_with_bricks() {
    for dims in SIZES {
        for options in all_options() {
            let isos = [0.0, 20.0, 21.3, -40.0, 39.0, -1e3, 1e3];
            check(&ball(dims, 1.0, |v| v as f32).view(), &isos, &options);
            check(&ball(dims, 4.0, |v| v as i16).view(), &isos[..3], &options);
            check(&ball(dims, 0.1, |v| v as u8).view(), &isos, &options);
        }
    }
}

#[test]
fn each_value_alone_is_the_same_too() {
    let volume = ball([130, 70, 60], 0.5, |v| v);
    for boundary in [Boundary::Closed, Boundary::Open] {
        let options = ExtractOptions::DEFAULT.with_boundary(boundary);
        for iso in [-60.0, -35.0, -20.0, 0.0, 10.5, 30.0, 39.9, 41.0] {
            let skipped = check(&volume.view(), &[iso], &options);
            assert_eq!(skipped.bricks, 3 * 9 * 8);
            assert!(skipped.bricks_skipped > 0, "{iso}: {skipped:?}");
            assert!(skipped.samples_read < 130 * 70 * 60, "{iso}: {skipped:?}");
        }
    }
}

#[test]
fn a_value_that_nothing_or_everything_reaches_reads_no_sample() {
    let volume = ball([130, 30, 18], 1.0, |v| v as f32);
    for iso in [-1e6, 1e6, 41.0] {
        let skipped = check(&volume.view(), &[iso], &ExtractOptions::DEFAULT);
        let none = Skipped { bricks: 3 * 4 * 3, bricks_skipped: 3 * 4 * 3, samples_read: 0 };
        assert_eq!(skipped, none, "{iso}");
    }
}

#[test]
fn single_samples_in_uniform_bricks_are_found() {
    for at in [0, 63, 64, 65, 129, 130 * 8 + 64, 130 * (8 + 20 * 8) + 64, 130 * 20 * 18 - 1] {
        for (most, one) in [(0_u16, 9), (9, 0)] {
            let mut samples = vec![most; 130 * 20 * 18];
            samples[at] = one;
            let grid = Grid::new([130, 20, 18], Default::default()).unwrap();
            let volume = Volume::new(grid, samples).unwrap();
            for options in all_options() {
                check(&volume.view(), &[5.0, 9.0, 0.0], &options);
            }
        }
    }
}

#[test]
fn nan_in_uniform_bricks_is_treated_as_the_policy_says() {
    let holes = |v: f64| if v.rem_euclid(16.0) == 0.0 { f32::NAN } else { v as f32 };
    let volume = ball([130, 30, 26], 1.0, holes);
    let rare = chance([70, 20, 20], 5, |r| if r.is_multiple_of(9999) { f64::NAN } else { 1.0 });
    for options in all_options() {
        check(&volume.view(), &[0.0, -30.0, 1e3, -1e3], &options);
        check(&rare.view(), &[1.0, 0.5, 2.0], &options);
    }
    let bricks = Bricks::of(&volume.view(), &Job::default()).unwrap();
    let source = Source::with_bricks(&volume.view(), &bricks).unwrap();
    let refusing = ExtractOptions::DEFAULT.with_nan(Nan::Error);
    let found = count_many(source, &[0.0], &refusing, &Job::default());
    assert!(matches!(found, Err(ExtractError::Nan { count: 1.., .. })), "{found:?}");
    check(&ball([70, 20, 20], 1.0, |v| v as f32).view(), &[0.0], &refusing);
}

#[test]
fn falling_samples_and_rows_in_any_order_are_the_same_too() {
    let volume = ball([70, 30, 40], 1.0, |v| v as i16);
    let turned = Grid::new([40, 30, 70], Default::default()).unwrap();
    let view = View::strided(volume.samples(), 0, [2100, 70, 1], &turned).unwrap();
    let falling = Scaling::new(-0.5, 3.0).unwrap();
    for options in all_options() {
        check(&view, &[0.0, 17.0], &options);
        check(&view.with_scaling(falling), &[0.0, 3.0, -2.75, 23.0, -1e9], &options);
        check(&volume.view().part([3..69, 1..30, 7..40]).unwrap(), &[0.0], &options);
    }
}

#[test]
fn bricks_of_other_sizes_are_refused() {
    let [one, other] = [[9, 9, 9], [9, 9, 8]].map(|dims| chance(dims, 1, |r| r as u8));
    let bricks = Bricks::of(&one.view(), &Job::default()).unwrap();
    assert!(Source::with_bricks(&one.view(), &bricks).is_some());
    assert!(Source::with_bricks(&other.view(), &bricks).is_none());
}

proptest! {
    #[test]
    fn chance_is_the_same_with_bricks(
        dims in (1..140_u64, 1..20_u64, 1..20_u64),
        seed: u64,
        share in 1..400_u64,
        iso in -1.0..9.0_f64,
    ) {
        let mut volume = chance([dims.0, dims.1, dims.2], seed, |r| (r % 800) as u16);
        // Mostly one value, so that many bricks have one side.
        let samples = volume.samples().iter().map(|&s| if s < share as u16 { s % 8 } else { 4 });
        volume = Volume::new(*volume.grid(), samples.collect()).unwrap();
        for boundary in [Boundary::Closed, Boundary::Open] {
            let options = ExtractOptions::DEFAULT.with_boundary(boundary);
            check(&volume.view(), &[iso, iso.round(), 4.0, 4.5], &options);
        }
    }
}
