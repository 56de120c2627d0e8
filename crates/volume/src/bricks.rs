//! Least and greatest sample of every brick: which parts of a volume an isovalue has nothing to do with.
//!
//! A brick is 64 × 8 × 8 cells, at the upper ends of the axes fewer. It has the samples at all corners of
//! its cells, so neighbours share a layer of samples, and every edge of the lattice lies in a brick. Along
//! x it is as long as a word of bits.
//!
//! There is no tree: one brick stands for 4096 cells, so even a large volume has few enough to look at one
//! by one.

mod any;
mod build;
mod part;
mod query;

pub use any::AnyBricks;
pub use query::Sides;

use crate::Sample;
use isokit_lanes::Extent;
use std::ops::{Range, RangeInclusive};

/// The least and the greatest sample of every brick of a lattice, as stored: what samples mean may change.
///
/// # Guarantees
///
/// There is one extent for every brick, and no sample of a brick is beyond it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bricks<T> {
    grid: BrickGrid,
    extents: Vec<Extent<T>>,
}

/// How a lattice is cut into bricks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BrickGrid {
    dims: [usize; 3],
    counts: [usize; 3],
    /// Cells of the first brick along each axis that lie before the lattice, which is a part of another.
    before: [usize; 3],
}

impl BrickGrid {
    /// Cells of a brick along x, y, z.
    pub const CELLS: [usize; 3] = [64, 8, 8];

    /// For a lattice of `dims` samples. Along an axis without a cell there is one brick.
    pub fn new(dims: [usize; 3]) -> Self {
        Self::behind([0; 3], dims)
    }

    fn behind(before: [usize; 3], dims: [usize; 3]) -> Self {
        let cells = |axis: usize| dims[axis].saturating_sub(1).saturating_add(before[axis]);
        let count = |axis: usize| cells(axis).div_ceil(Self::CELLS[axis]).max(1);
        Self { dims, counts: std::array::from_fn(count), before }
    }

    /// The bricks of a part of the lattice: along y and z the same, as far as they lie in it, along x new ones, that
    /// begin with its first sample as words of bits do. `None` if the lattice does not have such a part.
    pub fn part(&self, part: &[Range<usize>; 3]) -> Option<Self> {
        let fits = |axis: usize| !part[axis].is_empty() && part[axis].end <= self.dims[axis];
        let before = |axis: usize| (self.before[axis] + part[axis].start) % Self::CELLS[axis];
        let dims = part.each_ref().map(Range::len);
        (0..3).all(fits).then(|| Self::behind([0, before(1), before(2)], dims))
    }

    /// Samples of the lattice along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Bricks along x, y, z.
    pub fn counts(&self) -> [usize; 3] {
        self.counts
    }

    /// All bricks. `None` if there are more than can be counted.
    pub fn count(&self) -> Option<u64> {
        self.counts.iter().try_fold(1_u64, |count, &n| count.checked_mul(n as u64))
    }

    /// The brick that has, along an axis, sample `i` and the one after it, if there is one.
    #[inline(always)]
    pub fn brick_of(&self, axis: usize, i: usize) -> usize {
        ((i + self.before[axis]) / Self::CELLS[axis]).min(self.counts[axis] - 1)
    }

    /// The samples that a brick has along an axis.
    pub fn samples(&self, axis: usize, brick: usize) -> RangeInclusive<usize> {
        let (first, before) = (brick * Self::CELLS[axis], self.before[axis]);
        first.saturating_sub(before)..=(first + Self::CELLS[axis] - before).min(self.dims[axis] - 1)
    }

    /// Whether the brick of a number has a side at the border of the lattice.
    pub fn is_at_border(&self, number: usize) -> bool {
        let [nx, ny, nz] = self.counts;
        let at = [number % nx, number / nx % ny, number / nx / ny];
        at.iter().zip([nx, ny, nz]).any(|(&i, count)| i == 0 || i + 1 == count)
    }

    /// The number of a brick.
    #[inline(always)]
    pub fn number(&self, brick: [usize; 3]) -> usize {
        brick[0] + self.counts[0] * (brick[1] + self.counts[1] * brick[2])
    }
}

impl<T: Sample> Bricks<T> {
    /// Extents that are known, x fastest. `None` if there are more or fewer than bricks, or if one has
    /// NaN for an end.
    pub fn from_extents(dims: [usize; 3], extents: Vec<Extent<T>>) -> Option<Self> {
        let grid = BrickGrid::new(dims);
        let sound = |extent: &Extent<T>| extent.least.partial_cmp(&extent.greatest).is_some();
        let fits = grid.count() == Some(extents.len() as u64) && extents.iter().all(sound);
        fits.then_some(Self { grid, extents })
    }

    /// How the lattice is cut.
    pub fn grid(&self) -> &BrickGrid {
        &self.grid
    }

    /// Least and greatest of each brick, x fastest.
    pub fn extents(&self) -> &[Extent<T>] {
        &self.extents
    }
}
