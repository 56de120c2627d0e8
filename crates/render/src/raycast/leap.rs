//! Bricks of which nothing can be seen.

use crate::{transfer::Lookup, trilinear::Scale};
use isokit_lanes::Extent;
use isokit_volume::{BrickGrid, Bricks, Sample, Scaling};

/// For each brick whether none of its values can be seen.
#[derive(Clone, Debug)]
pub(super) struct Clear {
    grid: BrickGrid,
    is_clear: Vec<bool>,
}

impl Clear {
    /// A value between samples is between their least and greatest, but for the rounding of three
    /// interpolations, one after another; so a brick is clear if the lookup shows nothing from there to there.
    pub(super) fn new<T: Sample>(
        bricks: &Bricks<T>,
        scaling: Scaling,
        lookup: &Lookup<'_>,
    ) -> Self {
        let scale = Scale::of(scaling);
        let is_clear = |extent: &Extent<T>| {
            let Some(range) = extent.range() else { return true }; // all samples are NaN
            let [least, greatest] = range.map(|end| end.to_f64() as f32);
            let slack = 8.0 * f32::EPSILON * least.abs().max(greatest.abs());
            let [a, b] = [least - slack, greatest + slack].map(|stored| scale.value(stored));
            lookup.is_clear([a.min(b), a.max(b)])
        };
        Self { grid: *bricks.grid(), is_clear: bricks.extents().iter().map(is_clear).collect() }
    }

    /// The box, in index space, of the brick of a cell, if nothing in it can be seen.
    #[inline(always)]
    pub(super) fn around(&self, cell: [usize; 3]) -> Option<[[f64; 2]; 3]> {
        let brick: [usize; 3] = std::array::from_fn(|axis| self.grid.brick_of(axis, cell[axis]));
        self.is_clear[self.grid.number(brick)].then(|| {
            std::array::from_fn(|axis| {
                let samples = self.grid.samples(axis, brick[axis]);
                [*samples.start() as f64, *samples.end() as f64]
            })
        })
    }
}
