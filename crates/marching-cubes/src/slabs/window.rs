//! The slices of a volume that are in memory.

use super::{Held, Slabs, needed::Needed};
use crate::{Placement, Skipped, found::Found, planes::Lattice};
use isokit_job::{Cancelled, Job, OverLimit, Work};
use isokit_lanes::{has_nan, nans, words};
use isokit_volume::{Bricks, Grid, Sample, Scaling, SlabSource, View};
use rayon::prelude::*;
use std::ops::Range;

/// Some slices that follow each other, and those among them whose surface is made next.
pub(super) struct Window<T> {
    grid: Grid,
    scaling: Scaling,
    /// Room for as many slices as are held at the most.
    samples: Vec<T>,
    slice: usize,
    /// The slices that are held, by their numbers in the volume.
    held: Range<u64>,
    /// Of those the ones that have just come.
    new: Range<u64>,
    /// What says how many slices below and above a slice its surface looks at.
    placement: Placement,
    /// What is looked at, where that is not all.
    needed: Option<Needed<T>>,
    /// Samples that the source was asked for.
    samples_read: u64,
    /// NaN samples met so far, where somebody looked.
    pub(super) nan: Found,
}

/// Samples fetched between two looks at the cancel token.
const PIECE: usize = 1 << 20;

impl<T: Sample> Window<T> {
    /// Before the first slice, with room for as many slices as `slabs` says.
    pub(super) fn new(
        source: &impl SlabSource<T>,
        slabs: &Slabs<'_>,
        job: &Job,
    ) -> Result<Self, OverLimit> {
        let (grid, scaling) = (*source.grid(), source.scaling());
        let placement = slabs.options.placement;
        let slices = slabs.budget.window.max(placement.least_window()) as u64;
        let slices = slices.min(grid.dims()[2]);
        let count = grid.slice_count().checked_mul(slices);
        let samples = job.limits.zeroed("window of slices", count)?;
        let slice = grid.slice_count() as usize;
        let (held, new, nan) = (0..0, 0..0, Found::default());
        let (needed, samples_read) = (Needed::new(source, slabs), 0);
        Ok(Self { grid, scaling, samples, slice, held, new, placement, needed, samples_read, nan })
    }

    /// Whether the last slice is held.
    pub(super) fn is_last(&self) -> bool {
        self.held.end == self.grid.dims()[2]
    }

    /// Goes on by as many slices as there is room for. Those that are still looked at move down.
    pub(super) fn advance<R: SlabSource<T>>(
        &mut self,
        source: &mut R,
        job: &Job,
    ) -> Result<(), R::Error> {
        let looked_at = self.placement.below() + self.placement.above();
        let keep = (self.held.end - self.held.start).min(looked_at as u64);
        let first = self.held.end - keep;
        let kept = self.place(first)..self.place(self.held.end);
        let filled = kept.len();
        self.samples.copy_within(kept, 0);
        let room = ((self.samples.len() - filled) / self.slice) as u64;
        let more = room.min(self.grid.dims()[2] - self.held.end);
        let empty = filled..filled + more as usize * self.slice;
        let nx = self.grid.dims()[0];
        match &self.needed {
            None => {
                let pieces = (PIECE / self.slice).max(1) * self.slice;
                for slices in self.samples[empty].chunks_mut(pieces) {
                    job.check()?;
                    source.fill(slices)?;
                    self.samples_read += slices.len() as u64;
                }
            }
            Some(needed) => {
                let slices = self.samples[empty].chunks_exact_mut(self.slice);
                for (slice, k) in slices.zip(self.held.end..) {
                    job.check()?;
                    let rows = needed.rows(k);
                    self.samples_read += nx * rows.len() as u64;
                    source.fill_rows(slice, rows)?;
                }
            }
        }
        self.new = self.held.end..self.held.end + more;
        self.held = first..self.new.end;
        Ok(())
    }

    /// How many slices have just come.
    pub(super) fn new_slices(&self) -> u64 {
        self.new.end - self.new.start
    }

    /// Where a slice begins among the samples.
    fn place(&self, slice: u64) -> usize {
        (slice - self.held.start) as usize * self.slice
    }

    /// All slices that are held, and which of them are to be made.
    pub(super) fn held(&self, lattice: Lattice) -> Held<'_, T> {
        Held { view: self.view(), first: self.held.start, own: self.own(lattice) }
    }

    /// What is known of the slices that are held.
    pub(super) fn bricks(&self) -> Option<Bricks<T>> {
        self.needed.as_ref()?.slices(&self.held)
    }

    /// What was not done so far.
    pub(super) fn skipped(&self) -> Skipped {
        let all = Skipped { samples_read: self.samples_read, ..Skipped::default() };
        self.needed.as_ref().map_or(all, |needed| needed.skipped(self.samples_read))
    }

    /// All slices that are held, in the frame of the volume.
    pub(super) fn view(&self) -> View<'_, T> {
        self.part(self.held.clone())
    }

    fn part(&self, slices: Range<u64>) -> View<'_, T> {
        let [nx, ny, _] = self.grid.dims();
        let grid = Grid::new([nx, ny, slices.end - slices.start], self.grid.frame);
        let samples = &self.samples[self.place(slices.start)..self.place(slices.end)];
        let view = grid.ok().and_then(|grid| View::new(samples, &grid).ok());
        view.expect("slices that are held").with_scaling(self.scaling)
    }

    /// The slices of the lattice over the window whose surface is made now.
    fn own(&self, lattice: Lattice) -> Range<usize> {
        let start = if self.held.start == 0 { 0 } else { self.placement.below() + lattice.guard };
        let looked_at = if self.is_last() { 0 } else { self.placement.above() + lattice.guard };
        start..lattice.points[2] - looked_at
    }

    /// Counts the NaN samples among the slices that have just come; where bricks tell that there are none, without a look.
    pub(super) fn look_for_nan(&mut self, job: &Job) -> Result<(), Cancelled> {
        if T::DTYPE.is_integer() || self.needed.is_some() {
            return Ok(());
        }
        let view = self.part(self.new.clone());
        let ([nx, ny, nz], before) = (view.dims(), self.new.start as usize);
        let of_slice: Work<'_, _, _> = &|k: usize| {
            job.check()?;
            let (mut found, mut scratch, mut bits) = (Found::default(), vec![], vec![0; words(nx)]);
            for j in 0..ny {
                let row = view.row(j, k).gather(&mut scratch);
                if has_nan(row) {
                    nans(row, &mut bits);
                    found.add(Found::in_row(&bits, [j, before + k]));
                }
            }
            Ok(found)
        };
        let found: Result<Vec<Found>, Cancelled> =
            job.threads.run(|| (0..nz).into_par_iter().map(of_slice).collect());
        found?.into_iter().for_each(|found| self.nan.add(found));
        Ok(())
    }
}
