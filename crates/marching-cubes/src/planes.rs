//! Which lattice points are inside, one bit each.
//!
//! The *lattice* is the samples, and for a closed boundary one guard point beyond each end of each axis,
//! all of them outside. No volume is copied for that: a row is shifted by one bit, and the rows of guards are
//! zeros. Bit `i % 64` of word `i / 64` is point `i`; bits beyond the last point
//! are 0.

use crate::{Boundary, sparse::Visits};
use isokit_lanes::{BitRows, RowCounts, WORD, words};
use isokit_volume::{Sample, View};
use std::{ops::Range, slice::Chunks, sync::Arc};

mod chosen;
mod classify;
mod signs;
#[cfg(test)]
mod tests;

pub(crate) use signs::Signs;

/// Sizes of the lattice, and where the samples are in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lattice {
    /// Points along x, y, z.
    pub(crate) points: [usize; 3],
    /// Lattice index of the first sample on each axis: 1 behind a guard, else 0.
    pub(crate) guard: usize,
    /// Words per row.
    pub(crate) words: usize,
}

impl Lattice {
    pub(crate) fn new(dims: [usize; 3], boundary: Boundary) -> Self {
        let guard = usize::from(boundary == Boundary::Closed);
        let points = dims.map(|n| n.saturating_add(2 * guard));
        Self { points, guard, words: words(points[0]) }
    }

    /// Whether there is a cell. Without one no triangle uses an edge, so no edge has a vertex.
    pub(crate) fn has_cells(&self) -> bool {
        self.points.iter().all(|&n| n > 1)
    }

    /// Rows of points.
    pub(crate) fn rows(&self) -> Option<u64> {
        (self.points[1] as u64).checked_mul(self.points[2] as u64)
    }

    /// How many of some slices have samples: those beyond the border have none.
    pub(crate) fn sampled(&self, slices: &Range<usize>) -> u64 {
        let own = self.guard..self.points[2] - self.guard;
        let [start, end] = [slices.start, slices.end].map(|z| z.clamp(own.start, own.end));
        (end - start) as u64
    }

    /// Words of a slice.
    pub(crate) fn slice_words(&self) -> usize {
        self.words * self.points[1]
    }

    /// Where in a slice the words of a row of samples are.
    pub(crate) fn row_of_samples(&self, j: usize) -> Range<usize> {
        let y = j + self.guard;
        y * self.words..(y + 1) * self.words
    }

    /// The samples of a slice as one long row, where the rows lie one behind another and fill all bits of their
    /// words; in pieces of [`PIECE`] samples, which stay in the first cache.
    fn as_one_row<'a, T: Sample>(&self, view: &View<'a, T>, k: usize) -> Option<Chunks<'a, T>> {
        let samples = view.slice(k).filter(|all| all.len() == WORD * self.slice_words())?;
        Some(samples.chunks(PIECE))
    }

    /// The cells in word `w` of a row: every point but the last is the low corner of one.
    #[inline(always)]
    pub(crate) fn cells(&self, w: usize) -> u64 {
        match w + 1 == self.words {
            true => (1 << ((self.points[0] - 1) % 64)) - 1,
            false => u64::MAX,
        }
    }
}

/// Samples of a piece of a slice that is one long row.
const PIECE: usize = PIECE_WORDS * WORD;

/// Words of a piece.
const PIECE_WORDS: usize = 64;

/// Moves the bits of a row of samples behind a guard.
#[inline(always)]
pub(crate) fn behind_guard(row: &mut [u64]) {
    behind_guards::<1>(row.as_chunks_mut().0);
}

/// The same of planes whose words lie side by side.
#[inline(always)]
pub(crate) fn behind_guards<const PLANES: usize>(row: &mut [[u64; PLANES]]) {
    let mut carries = [0; PLANES];
    for words in row {
        for (carry, word) in carries.iter_mut().zip(words) {
            (*carry, *word) = (*word >> 63, *word << 1 | *carry);
        }
    }
}

/// One bit for every lattice point.
#[derive(Debug)]
pub(crate) struct Plane {
    lattice: Lattice,
    /// The slice of the lattice that the groups begin with. Those before and after are blank.
    first: usize,
    /// The rows of slices, so many slices together; nothing where all are blank.
    groups: Vec<Vec<u64>>,
    together: usize,
    /// A slice of nothing but zeros.
    blank: Vec<u64>,
}

impl Plane {
    /// Nothing but zeros.
    pub(crate) fn blank(lattice: Lattice) -> Self {
        let blank = vec![0; lattice.slice_words()];
        Self { lattice, first: lattice.guard, groups: vec![], together: 1, blank }
    }

    /// Zeros for some slices, of which `first` is the first. All others are blank.
    pub(crate) fn window(&mut self, first: usize, slices: usize) -> &mut [u64] {
        self.groups.resize(1, vec![]);
        (self.first, self.together) = (first, slices);
        let window = &mut self.groups[0];
        window.clear();
        window.resize(slices * self.blank.len(), 0);
        window
    }

    /// The rows of slice `z` of the lattice.
    #[inline(always)]
    fn slice(&self, z: usize) -> &[u64] {
        let k = z.wrapping_sub(self.first);
        let words = self.blank.len();
        match self.groups.get(k / self.together) {
            Some(group) => {
                let first = k % self.together * words;
                group.get(first..first + words).unwrap_or(&self.blank)
            }
            None => &self.blank,
        }
    }

    /// The rows of slice `z`, and those of the next.
    #[inline(always)]
    pub(crate) fn slices(&self, z: usize) -> BitRows<'_> {
        let [nx, _, nz] = self.lattice.points;
        BitRows::new(self.slice(z), (z + 1 < nz).then(|| self.slice(z + 1)), nx)
    }

    /// Row `y` of slice `z` of the lattice.
    #[inline(always)]
    pub(crate) fn row(&self, y: usize, z: usize) -> &[u64] {
        let words = self.lattice.words;
        &self.slice(z)[y * words..(y + 1) * words]
    }

    /// The four rows around the cells that start in row `y`, `z`: at (y, z) = 00, 10, 01, 11.
    #[inline(always)]
    pub(crate) fn rows(&self, y: usize, z: usize) -> [&[u64]; 4] {
        [(y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1)].map(|(y, z)| self.row(y, z))
    }
}

/// The planes of one extraction.
#[derive(Debug)]
pub(crate) struct Planes {
    pub(crate) lattice: Lattice,
    /// Which points are inside.
    pub(crate) inside: Plane,
    /// Which points have no value; only where those leave a border. The same for every isovalue.
    pub(crate) missing: Option<Arc<Plane>>,
    /// The rows that are to be looked at, where not all are.
    pub(crate) visits: Option<Visits>,
    /// What was counted on the way.
    pub(crate) counted: Option<Counted>,
}

/// What rows make, of slices that were counted while they were in the cache.
#[derive(Debug)]
pub(crate) struct Counted {
    /// Of all slices.
    pub(crate) rows: Vec<RowCounts>,
    /// For each slice, whether it is counted. The rows of the others are zeros.
    pub(crate) done: Vec<bool>,
}

impl Planes {
    /// No point is inside.
    pub(crate) fn blank(lattice: Lattice) -> Self {
        let inside = Plane::blank(lattice);
        Self { lattice, inside, missing: None, visits: None, counted: None }
    }

    /// The rows of slice `z` that are to be looked at.
    pub(crate) fn rows_of_slice(&self, z: usize) -> Range<usize> {
        self.visits.as_ref().map_or(0..self.lattice.points[1], |visits| visits.rows(z))
    }

    /// Whether it is known without a look that there is no surface.
    pub(crate) fn is_empty(&self) -> bool {
        self.inside.groups.iter().all(Vec::is_empty)
    }
}
