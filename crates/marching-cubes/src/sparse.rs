//! Only the bricks that can hold the surface: of the others no sample is compared, and in each layer of bricks only the rows
//! of bits from the first to the last of them are looked at.
//!
//! A brick all of whose samples are on one side has words of nothing but zeros or ones. Zeros are what
//! fresh memory holds; ones are written only in rows that are looked at, and next to them. What is
//! looked at is therefore true, and so the surface is the same as without bricks, to the last bit.

use crate::planes::Lattice;
use isokit_lanes::{Side, Threshold, WORD, words};
use isokit_volume::{BrickGrid, Bricks, Sample, Sides, View};
use std::{ops::Range, sync::Arc};

/// The samples that surfaces are made of, and what is known of them beforehand.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a, T> {
    pub(crate) view: View<'a, T>,
    pub(crate) bricks: Option<&'a Bricks<T>>,
}

impl<'a, T: Sample> Source<'a, T> {
    /// Samples and their bricks: the surfaces are the same, byte for byte, as without them, and sooner
    /// made. `None` if these are not bricks of as many samples; that they are of other ones of the same
    /// sizes nobody finds out.
    pub fn with_bricks(view: &View<'a, T>, bricks: &'a Bricks<T>) -> Option<Self> {
        let fits = bricks.grid().dims() == view.dims();
        fits.then_some(Self { view: *view, bricks: Some(bricks) })
    }
}

impl<'a, T> From<&View<'a, T>> for Source<'a, T>
where
    View<'a, T>: Copy,
{
    fn from(view: &View<'a, T>) -> Self {
        Self { view: *view, bricks: None }
    }
}

/// What a call did not have to do because bricks told so.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Skipped {
    /// Bricks of the volume; 0 without bricks.
    pub bricks: u64,
    /// Those of which no sample was compared.
    pub bricks_skipped: u64,
    /// Samples that were compared; by [`extract_slabs`](crate::extract_slabs), those that the source was asked for.
    pub samples_read: u64,
}

/// Some words of the rows of each brick.
#[derive(Clone, Debug)]
pub(crate) struct Runs {
    grid: BrickGrid,
    /// Where the runs of each row of bricks begin, and after the last, where they end.
    starts: Vec<usize>,
    runs: Vec<Range<usize>>,
}

impl Runs {
    /// Those of the samples that bricks begin with, of chosen bricks.
    fn new(grid: BrickGrid, chosen: impl Fn(usize) -> bool) -> Self {
        let [nx, ny, nz] = grid.counts();
        let all_words = words(grid.dims()[0]);
        let (mut starts, mut runs): (_, Vec<Range<usize>>) = (vec![0], vec![]);
        for row in 0..ny * nz {
            let first = runs.len();
            for x in (0..nx).filter(|x| chosen(x + nx * row)) {
                // The last one has what is left.
                let end = if x + 1 == nx { all_words } else { x + 1 };
                match runs[first..].last_mut() {
                    Some(last) if last.end == x => last.end = end,
                    _ => runs.push(x..end),
                }
            }
            starts.push(runs.len());
        }
        Self { grid, starts, runs }
    }

    /// The runs of the brick in which sample row (j, k) begins.
    #[inline(always)]
    pub(crate) fn of_row(&self, j: usize, k: usize) -> &[Range<usize>] {
        let row = self.grid.number([0, self.grid.brick_of(1, j), self.grid.brick_of(2, k)]);
        let row = row / self.grid.counts()[0];
        &self.runs[self.starts[row]..self.starts[row + 1]]
    }

    /// The samples of all words.
    fn samples(&self) -> u64 {
        let [nx, ..] = self.grid.dims();
        let [rows, slices] = [1, 2].map(|axis| {
            // How many begin in each brick.
            let mut begin = vec![0; self.grid.counts()[axis]];
            (0..self.grid.dims()[axis]).for_each(|i| begin[self.grid.brick_of(axis, i)] += 1);
            begin
        });
        let rows = slices.iter().flat_map(|slices| rows.iter().map(move |rows| rows * slices));
        let of_run = |run: &Range<usize>| (nx.min(run.end * WORD) - run.start * WORD) as u64;
        let of_bricks =
            |ends: &[usize]| self.runs[ends[0]..ends[1]].iter().map(of_run).sum::<u64>();
        self.starts.windows(2).map(of_bricks).zip(rows).map(|(samples, rows)| samples * rows).sum()
    }

    /// Whether no brick in which slice `k` begins has one.
    pub(crate) fn skips_slice(&self, k: usize) -> bool {
        let rows = self.grid.counts()[1];
        let first = self.grid.brick_of(2, k) * rows;
        self.starts[first] == self.starts[first + rows]
    }
}

/// Whether brick `n`, whose samples are on a side, can hold a part of the surface: where that is closed, there is a cap
/// between samples inside and the border.
pub(crate) fn can_hold(grid: &BrickGrid, n: usize, side: Side, is_closed: bool) -> bool {
    side == Side::Both || is_closed && side == Side::Inside && grid.is_at_border(n)
}

/// For each layer of bricks, the rows of bricks from the first to the last that has one that is set.
pub(crate) fn spans(grid: &BrickGrid, is_set: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let [nx, ny, nz] = grid.counts();
    let of_layer = |z: usize| {
        let has_one = |y: &usize| (nx * (y + ny * z)..).take(nx).any(&is_set);
        let Some(first) = (0..ny).find(has_one) else { return 0..0 };
        first..1 + (first..ny).rfind(has_one).unwrap_or(first)
    };
    (0..nz).map(of_layer).collect()
}

/// For each layer of bricks, the rows of bricks in [`spans`] and next to them, above and below too.
pub(crate) fn around(grid: &BrickGrid, spans: &[Range<usize>]) -> Vec<Range<usize>> {
    let [_, ny, nz] = grid.counts();
    let of_layer = |z: usize| {
        let near = spans[z.saturating_sub(1)..nz.min(z + 2)].iter().filter(|rows| !rows.is_empty());
        let near = near.map(|rows| rows.start.saturating_sub(1)..ny.min(rows.end + 1));
        near.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0)
    };
    (0..nz).map(of_layer).collect()
}

/// The rows of each slice of the lattice that can have a crossed cell or a cut edge, and some between them. Their bits are
/// true, and those of the rows next to them.
#[derive(Clone, Debug)]
pub(crate) struct Visits {
    grid: BrickGrid,
    guard: usize,
    /// Of the slices of each layer of bricks.
    rows: Arc<[Range<usize>]>,
}

impl Visits {
    /// Those of bricks in [`spans`].
    pub(crate) fn new(grid: BrickGrid, lattice: Lattice, spans: &[Range<usize>]) -> Self {
        // Behind a guard every row of samples is one further up.
        let begin = |y: usize| match y {
            0 => 0,
            _ if y == grid.counts()[1] => lattice.points[1],
            _ => grid.samples(1, y).start() + lattice.guard,
        };
        let rows = spans.iter().map(|rows| match rows.is_empty() {
            true => 0..0,
            false => begin(rows.start)..begin(rows.end),
        });
        Self { grid, guard: lattice.guard, rows: rows.collect() }
    }

    /// Whether there are some in slice `k` of the samples.
    fn are_in_slice(&self, k: usize) -> bool {
        !self.rows[self.grid.brick_of(2, k)].is_empty()
    }

    /// Those of slice `z` of the lattice.
    pub(crate) fn rows(&self, z: usize) -> Range<usize> {
        self.rows[self.grid.brick_of(2, z.saturating_sub(self.guard))].clone()
    }
}

/// What is done for the planes of several isovalues.
#[derive(Debug)]
pub(crate) struct Choice {
    /// Words of samples that are compared, for all isovalues.
    pub(crate) compared: Runs,
    /// For each isovalue, words of samples that are all ones and are needed.
    pub(crate) full: Vec<Runs>,
    /// For each isovalue.
    pub(crate) visits: Vec<Visits>,
    pub(crate) skipped: Skipped,
}

impl Choice {
    /// What bricks tell of each threshold.
    pub(crate) fn new<T: Sample>(
        bricks: &Bricks<T>,
        thresholds: &[Threshold<T>],
        lattice: Lattice,
    ) -> Self {
        let sides: Vec<_> = thresholds.iter().map(|&one| bricks.sides(one)).collect();
        let grid = *bricks.grid();
        let [nx, ny, _] = grid.counts();
        let count: usize = grid.counts().iter().product();
        let both = |n: usize| sides.iter().any(|sides| sides.of_brick[n] == Side::Both);
        let is_compared: Vec<bool> = (0..count).map(both).collect();
        let (mut full, mut visits) = (vec![], vec![]);
        for Sides { of_brick, .. } in &sides {
            let spans = spans(&grid, |n| can_hold(&grid, n, of_brick[n], lattice.guard == 1));
            let around = around(&grid, &spans);
            let is_around = |n: usize| around[n / (nx * ny)].contains(&(n / nx % ny));
            let is_needed =
                |n: usize| of_brick[n] == Side::Inside && !is_compared[n] && is_around(n);
            full.push(Runs::new(grid, is_needed));
            visits.push(Visits::new(grid, lattice, &spans));
        }
        let compared = is_compared.iter().filter(|&&compared| compared).count();
        let bricks_skipped = (count - compared) as u64;
        let compared = Runs::new(grid, |n| is_compared[n]);
        let samples_read = compared.samples();
        let skipped = Skipped { bricks: count as u64, bricks_skipped, samples_read };
        Self { compared, full, visits, skipped }
    }

    /// Whether some slices of samples, or the edges to them from the one below, can have something.
    pub(crate) fn needs(&self, slices: &Range<usize>) -> bool {
        let is_needed = |k: usize| !self.skips_slice(k);
        let below = slices.start.checked_sub(1);
        let is_visited = |k: usize| self.visits.iter().any(|visits| visits.are_in_slice(k));
        slices.clone().any(is_needed) || below.is_some_and(is_visited)
    }

    /// Whether no sample of slice `k` is compared or needed.
    pub(crate) fn skips_slice(&self, k: usize) -> bool {
        self.compared.skips_slice(k) && self.full.iter().all(|full| full.skips_slice(k))
    }
}

#[cfg(test)]
mod tests;
