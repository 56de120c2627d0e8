//! Fields as samples.

use crate::{chance::Chance, fields::Field};
use isokit::{
    geom::{Affine, Frame},
    volume::{Grid, Sample, Volume},
};

/// A sample for each place, in the order in which they are stored.
///
/// # Panics
///
/// If a size is 0.
pub fn made<T: Sample>(dims: [u64; 3], sample: impl FnMut([u64; 3]) -> T) -> Volume<T> {
    let grid = Grid::new(dims, Frame::default()).expect("sizes that are not 0");
    let at = |n: u64| [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]];
    let samples = (0..grid.count()).map(at).map(sample).collect();
    Volume::new(grid, samples).expect("one sample for each place")
}

/// A field on the cube from −1 to 1, so many samples along each axis.
pub fn cube(field: &Field, points: u64) -> Volume<f64> {
    let step = 2.0 / (points - 1) as f64;
    placed(field, [points; 3], Affine::axis_aligned([step; 3], [-1.0; 3]).expect("a lattice"))
}

/// A field of the world on any lattice.
///
/// # Panics
///
/// If a size is 0.
pub fn placed(field: &Field, dims: [u64; 3], index_to_world: Affine) -> Volume<f64> {
    let frame = Frame { index_to_world, ..Frame::default() };
    let grid = Grid::new(dims, frame).expect("sizes that are not 0");
    let [nx, ny, _] = dims;
    let place = |n: u64| [n % nx, n / nx % ny, n / nx / ny].map(|i| i as f64);
    let value = |n: u64| field(index_to_world.point(place(n)));
    Volume::new(grid, (0..grid.count()).map(value).collect()).expect("one sample for each place")
}

/// Whole numbers from −`most` to `most`, which are often the isovalue 0.
///
/// # Panics
///
/// If a size is 0.
pub fn ties(dims: [u64; 3], most: u64, seed: u64) -> Volume<i8> {
    let mut chance = Chance::new(seed);
    made(dims, |_| chance.below(2 * most + 1) as i8 - most as i8)
}

/// Numbers from −1 to 1.
///
/// # Panics
///
/// If a size is 0.
pub fn noise(dims: [u64; 3], seed: u64) -> Volume<f32> {
    let mut chance = Chance::new(seed);
    made(dims, |_| (2.0 * chance.unit() - 1.0) as f32)
}
