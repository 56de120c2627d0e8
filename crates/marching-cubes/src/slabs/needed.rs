//! What of a volume that goes by is looked at, where bricks tell which of them hold the surfaces.
//!
//! Of each slice it is some rows that follow each other, from the first to the last that a brick needs; of many it
//! is none. All others are left unread, and whatever lies in the window there is compared with nothing: as in
//! memory (`sparse`), words of samples are compared in bricks that hold a surface only.

use super::Slabs;
use crate::{
    Boundary, Nan, Placement, Skipped,
    sparse::{around, can_hold, spans},
};
use isokit_lanes::Side;
use isokit_volume::{BrickGrid, Bricks, Sample, SlabSource};
use std::ops::Range;

/// What is known of all bricks, and what is needed for it.
pub(super) struct Needed<T> {
    bricks: Bricks<T>,
    /// For each layer of bricks the rows of its slices.
    rows: Vec<Range<usize>>,
    /// Bricks of which no sample is compared.
    skipped: u64,
}

/// Vertices and normals look at samples of the next brick, and no farther.
const _: () = {
    let [_, y, z] = BrickGrid::CELLS;
    assert!(y == z && z >= 8, "quintic corrections at a border take eight samples");
    assert!(Placement::Quintic.below() <= z && Placement::Quintic.above() <= z);
};

impl<T: Sample> Needed<T> {
    /// None if nothing is known of the samples, or if some are NaN and that matters: then all are looked at.
    pub(super) fn new(source: &impl SlabSource<T>, slabs: &Slabs<'_>) -> Option<Self> {
        let (dims, bricks) = (source.grid().dims(), source.bricks()?);
        let fits = dims.map(usize::try_from) == bricks.grid().dims().map(Ok);
        if !fits || slabs.options.nan != Nan::Outside && bricks.has_nan() {
            return None;
        }
        let isos = slabs.isos.iter().map(|&iso| source.scaling().threshold(iso));
        let sides: Vec<_> = isos.map(|threshold| bricks.sides(threshold).of_brick).collect();
        let is_closed = slabs.options.boundary == Boundary::Closed;
        let (grid, all) = (*bricks.grid(), bricks.extents().len());
        let spans = spans(&grid, |n| {
            sides.iter().any(|of_brick| can_hold(&grid, n, of_brick[n], is_closed))
        });
        let rows = around(&grid, &spans).into_iter().map(|bricks| match bricks.is_empty() {
            true => 0..0,
            false => {
                *grid.samples(1, bricks.start).start()..grid.samples(1, bricks.end - 1).end() + 1
            }
        });
        let rows = rows.collect();
        let is_compared = |n: &usize| sides.iter().any(|of_brick| of_brick[*n] == Side::Both);
        let skipped = (all - (0..all).filter(is_compared).count()) as u64;
        Some(Self { bricks: bricks.clone(), rows, skipped })
    }

    /// The rows of a slice that are looked at.
    pub(super) fn rows(&self, k: u64) -> Range<usize> {
        // The lattice fits in memory's numbers, or it would have no bricks.
        self.rows[self.bricks.grid().brick_of(2, k as usize)].clone()
    }

    /// What is known of some slices.
    pub(super) fn slices(&self, slices: &Range<u64>) -> Option<Bricks<T>> {
        let [nx, ny, _] = self.bricks.grid().dims();
        self.bricks.part(&[0..nx, 0..ny, slices.start as usize..slices.end as usize])
    }

    /// What was not done, if so many samples were asked for.
    pub(super) fn skipped(&self, samples_read: u64) -> Skipped {
        let bricks = self.bricks.extents().len() as u64;
        Skipped { bricks, bricks_skipped: self.skipped, samples_read }
    }
}
