//! Which lattice points are inside, one bit each.
//!
//! The *lattice* is the samples, and for a closed boundary one guard point beyond each end of each axis,
//! all of them outside. No volume is copied for that: a row is shifted by one bit, and the guard rows are
//! one row of zeros that all share. Bit `i % 64` of word `i / 64` is point `i`; bits beyond the last point
//! are 0.

use crate::{Boundary, sparse::Visits};
use isokit_lanes::words;
use std::sync::Arc;

mod chosen;
mod classify;
#[cfg(test)]
mod tests;

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

    /// The cells in word `w` of a row: every point but the last is the low corner of one.
    #[inline(always)]
    pub(crate) fn cells(&self, w: usize) -> u64 {
        match w + 1 == self.words {
            true => (1 << ((self.points[0] - 1) % 64)) - 1,
            false => u64::MAX,
        }
    }
}

/// One bit for every lattice point.
#[derive(Debug)]
pub(crate) struct Plane {
    lattice: Lattice,
    /// The rows that hold samples.
    bits: Vec<u64>,
    /// The row of every guard.
    zeros: Vec<u64>,
}

impl Plane {
    /// Row `y` of slice `z` of the lattice.
    #[inline(always)]
    pub(crate) fn row(&self, y: usize, z: usize) -> &[u64] {
        let Lattice { points, guard, words } = self.lattice;
        let (j, k) = (y.wrapping_sub(guard), z.wrapping_sub(guard));
        let (ny, nz) = (points[1] - 2 * guard, points[2] - 2 * guard);
        if j < ny && k < nz {
            let first = (j + ny * k) * words;
            &self.bits[first..first + words]
        } else {
            &self.zeros
        }
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
    /// The words that are to be looked at, where not all are.
    pub(crate) visits: Option<Visits>,
}

impl Planes {
    /// Whether it is known without a look that there is no surface.
    pub(crate) fn is_empty(&self) -> bool {
        self.inside.bits.is_empty()
    }
}
