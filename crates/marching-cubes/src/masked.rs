//! Cells that give no surface because some corner has no value.

use crate::planes::{Lattice, Plane};
use isokit_job::{Job, OverLimit};
use isokit_lanes::{WORD, Word};

/// The cells that have a value at every corner: one bit each.
#[derive(Debug)]
pub(crate) struct LiveCells {
    rows: [usize; 2],
    words: usize,
    bits: Vec<u64>,
}

impl LiveCells {
    /// All cells of which no corner is missing.
    pub(crate) fn new(lattice: Lattice, missing: &Plane, job: &Job) -> Result<Self, OverLimit> {
        let rows = [lattice.points[1] - 1, lattice.points[2] - 1];
        let mut bits = job
            .limits
            .vec("cells", lattice.rows().and_then(|n| n.checked_mul(lattice.words as u64)))?;
        for (y, z) in (0..rows[1]).flat_map(|z| (0..rows[0]).map(move |y| (y, z))) {
            for w in 0..lattice.words {
                let word = Word::new(missing.rows(y, z), w, lattice.cells(w));
                let any = word.corners.iter().fold(0, |any, corner| any | corner);
                bits.push(!any & lattice.cells(w));
            }
        }
        Ok(Self { rows, words: lattice.words, bits })
    }

    /// Takes away the cells that have no value at some corner, and the edges that only such cells share.
    pub(crate) fn restrict(&self, word: &mut Word, z: usize) {
        let (w, y) = (word.first / WORD, word.row);
        // Cell rows are asked for one before their own as well; before the first there is none.
        let row = |dy: usize, dz: usize| self.word(y.wrapping_add(dy), z.wrapping_add(dz), w);
        let before = usize::MAX;
        for (n, x) in word.cuts[..4].iter_mut().enumerate() {
            let (dy, dz) = (n & 1, n >> 1);
            let (by, bz) = (dy.wrapping_add(before), dz.wrapping_add(before));
            *x &= row(dy, dz)[1] | row(by, dz)[1] | row(dy, bz)[1] | row(by, bz)[1];
        }
        // An edge along y or z belongs to cells on both sides in x: the cell of its bit, and the last.
        let both = |[a, b]: [[u64; 2]; 2]| {
            let cells = [a[0] | b[0], a[1] | b[1]];
            cells[1] | cells[1] << 1 | cells[0] >> 63
        };
        for n in 0..2_usize {
            let b = n.wrapping_add(before);
            word.cuts[4 + n] &= both([row(0, n), row(0, b)]);
            word.cuts[6 + n] &= both([row(n, 0), row(b, 0)]);
        }
        word.active &= row(0, 0)[1];
    }

    /// Word `w` of a row of cells, and before it the word before it.
    fn word(&self, y: usize, z: usize, w: usize) -> [u64; 2] {
        if y >= self.rows[0] || z >= self.rows[1] {
            return [0; 2];
        }
        let at = (y + self.rows[0] * z) * self.words + w;
        [if w == 0 { 0 } else { self.bits[at - 1] }, self.bits[at]]
    }
}
