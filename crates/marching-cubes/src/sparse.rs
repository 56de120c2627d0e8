//! Only the bricks that can hold the surface: of the others no sample is compared, and no word is looked at
//! that nobody needs.
//!
//! A brick all of whose samples are on one side has words of nothing but zeros or ones. Zeros are what
//! fresh memory holds; ones are written only where a brick that is looked at is next to them. What is
//! looked at is therefore true, and so the surface is the same as without bricks, to the last bit.

use crate::planes::Lattice;
use isokit_lanes::{BitRows, Side, Word, words, words_of_run};
use isokit_volume::{BrickGrid, Bricks, Sample, Sides, View};
use std::ops::Range;

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
    /// `words(x)` are those of the bricks with number `x` along x.
    fn new(
        grid: BrickGrid,
        chosen: impl Fn(usize) -> bool,
        words: impl Fn(usize) -> Range<usize>,
    ) -> Self {
        let [nx, ny, nz] = grid.counts();
        let (mut starts, mut runs): (_, Vec<Range<usize>>) = (vec![0], vec![]);
        for row in 0..ny * nz {
            let first = runs.len();
            for x in (0..nx).filter(|x| chosen(x + nx * row)) {
                let more = words(x);
                match runs[first..].last_mut() {
                    Some(last) if last.end >= more.start => last.end = more.end,
                    _ => runs.push(more),
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

    /// Whether no brick in which slice `k` begins has one.
    pub(crate) fn skips_slice(&self, k: usize) -> bool {
        let rows = self.grid.counts()[1];
        let first = self.grid.brick_of(2, k) * rows;
        self.starts[first] == self.starts[first + rows]
    }
}

/// The words of a plane that can have a crossed cell or a cut edge.
#[derive(Clone, Debug)]
pub(crate) struct Visits {
    lattice: Lattice,
    runs: Runs,
}

/// Where the words of brick `x` of `nx` end.
fn last(x: usize, nx: usize, end: usize, words: usize) -> usize {
    if x + 1 == nx { words } else { end }
}

impl Visits {
    /// Those of the bricks that are set.
    pub(crate) fn new(grid: BrickGrid, lattice: Lattice, near: &[bool]) -> Self {
        let nx = grid.counts()[0];
        // Behind a guard every sample is one bit further up.
        let of_points = |x: usize| x..last(x, nx, x + 1 + lattice.guard, lattice.words);
        Self { lattice, runs: Runs::new(grid, |n| near[n], of_points) }
    }

    /// Whether a slice of the lattice has none.
    pub(crate) fn skips_slice(&self, z: usize) -> bool {
        self.runs.skips_slice(z.saturating_sub(self.lattice.guard))
    }

    /// Adds the words of a row of the lattice that have a crossed cell or a cut edge to `out`; `bits` are
    /// those of slice `z`.
    pub(crate) fn words_of_row(&self, bits: &BitRows<'_>, [y, z]: [usize; 2], out: &mut Vec<Word>) {
        let guard = self.lattice.guard;
        for run in self.runs.of_row(y.saturating_sub(guard), z.saturating_sub(guard)) {
            words_of_run(bits, y, run.clone(), out);
        }
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
    /// From the sides of all bricks for each isovalue.
    pub(crate) fn new(grid: BrickGrid, sides: &[Sides], lattice: Lattice) -> Self {
        let [nx, ..] = grid.counts();
        let of_samples = |x: usize| x..last(x, nx, x + 1, words(grid.dims()[0]));
        let count: usize = grid.counts().iter().product();
        let both = |n: usize| sides.iter().any(|sides| sides.of_brick[n] == Side::Both);
        let is_compared: Vec<bool> = (0..count).map(both).collect();
        let (mut full, mut visits) = (vec![], vec![]);
        for Sides { of_brick, .. } in sides {
            let mut near: Vec<bool> = of_brick.iter().map(|&side| side == Side::Both).collect();
            if lattice.guard == 1 {
                // Between samples inside and the guard lies a cap.
                let capped = |n: usize| of_brick[n] == Side::Inside && grid.is_at_border(n);
                near.iter_mut().enumerate().for_each(|(n, near)| *near |= capped(n));
            }
            visits.push(Visits::new(grid, lattice, &near));
            (0..3).for_each(|axis| spread(&mut near, grid.counts(), axis));
            let is_needed = |n: usize| near[n] && of_brick[n] == Side::Inside && !is_compared[n];
            full.push(Runs::new(grid, is_needed, of_samples));
        }
        let compared = is_compared.iter().filter(|&&compared| compared).count();
        let skipped = Skipped {
            bricks: count as u64,
            bricks_skipped: (count - compared) as u64,
            samples_read: 0,
        };
        let compared = Runs::new(grid, |n| is_compared[n], of_samples);
        Self { compared, full, visits, skipped }
    }
}

/// Sets what has a neighbour along an axis that is set.
fn spread(flags: &mut [bool], counts: [usize; 3], axis: usize) {
    let stride: usize = counts[..axis].iter().product();
    let line = stride * counts[axis];
    for block in flags.chunks_exact_mut(line) {
        for first in 0..stride {
            let mut before = false;
            for n in (first..line).step_by(stride) {
                let own = block[n];
                let after = block.get(n + stride).is_some_and(|&after| after);
                block[n] = before | own | after;
                before = own;
            }
        }
    }
}
