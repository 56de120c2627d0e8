//! Thousands of small volumes by chance: the extractor makes what its definition says.

use isokit::{
    geom::{Affine, Frame},
    marching_cubes::{Boundary, Degenerate, Diagonals, ExtractOptions, Nan, Placement, Topology},
    volume::{Grid, Sample, Scaling, Volume},
};
use isokit_tests::{chance::Chance, oracle::assert_as_defined};
use std::num::NonZeroUsize;

const DIMS: [[u64; 3]; 8] =
    [[2, 2, 2], [3, 3, 3], [5, 4, 3], [4, 6, 5], [7, 2, 4], [1, 4, 3], [66, 2, 2], [2, 3, 9]];

/// Puts volumes of one type to the test: samples that `sample` makes, compared with values it also makes.
fn check<T: Sample>(seed: u64, sample: impl Fn(&mut Chance) -> T) {
    let mut chance = Chance::new(seed);
    for round in 0..40 {
        for dims in DIMS {
            let grid = Grid::new(dims, frame(&mut chance)).unwrap();
            let samples = (0..grid.count()).map(|_| sample(&mut chance)).collect();
            let volume = Volume::new(grid, samples).unwrap();
            let exact = sample(&mut chance).to_f64();
            let iso = if !exact.is_finite() || round % 3 == 0 { 0.3 } else { exact };
            assert_as_defined(&volume.view(), iso, &options(&mut chance));
        }
    }
}

fn options(chance: &mut Chance) -> ExtractOptions {
    let mut of = |count| chance.below(count) as usize;
    ExtractOptions::DEFAULT
        .with_topology(Topology::Table)
        .with_placement(Placement::Linear)
        .with_boundary([Boundary::Closed, Boundary::Open][of(2)])
        .with_degenerate([Degenerate::Never, Degenerate::Exact][of(2)])
        .with_diagonals([Diagonals::Table, Diagonals::Fitted][of(2)])
        .with_nan([Nan::Outside, Nan::Mask][of(2)])
        .with_layers_per_task(NonZeroUsize::new(of(4) + 1).unwrap())
}

/// Plain, stretched, sheared or mirrored.
fn frame(chance: &mut Chance) -> Frame {
    let columns = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.7, 0.0, 0.0], [0.0, 0.7, 0.0], [0.0, 0.0, 2.5]],
        [[0.9, 0.1, 0.0], [-0.2, 0.8, 0.3], [0.4, 0.0, 1.3]],
        [[-1.5, 0.0, 0.0], [0.0, 1.0, 0.2], [0.0, -0.2, 1.0]],
    ];
    let origin = [-3.0, 0.25, 11.0].map(|c| c * chance.below(3) as f64);
    let index_to_world = Affine::new(columns[chance.below(4) as usize], origin).unwrap();
    Frame { index_to_world, ..Frame::default() }
}

#[test]
fn whole_numbers_of_every_type() {
    check(1, |chance| chance.below(5) as u8);
    check(2, |chance| chance.below(7) as i8 - 3);
    check(3, |chance| chance.below(4) as u16 * 20_000);
    check(4, |chance| chance.bits() as i16);
    check(5, |chance| chance.bits() as u32);
    check(6, |chance| [i32::MIN, -1, 0, 1, i32::MAX][chance.below(5) as usize]);
}

#[test]
fn floats_of_either_type() {
    check(7, |chance| chance.unit() as f32);
    check(8, |chance| chance.below(3) as f32 - 1.0);
    check(9, |chance| chance.unit() * 2.0 - 1.0);
    check(10, |chance| (chance.below(5) as f64 - 2.0) * 1e-300);
}

#[test]
fn samples_without_a_value_or_without_a_finite_one() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    check(11, move |chance| match chance.below(8) {
        n @ 0..3 => odd[n as usize],
        n => n as f32 - 4.5,
    });
    check(12, |chance| if chance.below(2) == 0 { f64::NAN } else { chance.unit() });
}

#[test]
fn stored_samples_that_mean_something_else() {
    let mut chance = Chance::new(13);
    for round in 0..200 {
        let grid = Grid::new(DIMS[round % DIMS.len()], frame(&mut chance)).unwrap();
        let samples: Vec<i16> = (0..grid.count()).map(|_| chance.below(9) as i16 - 4).collect();
        let scaling = Scaling::new([0.1, -2.5, 1e-3][round % 3], 7.0).unwrap();
        let volume = Volume::new(grid, samples).unwrap().with_scaling(scaling);
        let iso = scaling.value(chance.below(9) as f64 - 4.0);
        assert_as_defined(&volume.view(), iso, &options(&mut chance));
    }
}
