//! What 64 neighbouring cells of a row hold: which of their edges are cut, and their cases.
//!
//! A row of cells has four rows of lattice points around it, at (y, z) = 00, 10, 01, 11. In each bit
//! position of a [`Word`] stands one cell. Its low-x corners are the bits of those rows, its high-x
//! corners the same bits shifted down by one.

use crate::{Level, WORD};
use std::ops::Range;

mod cases;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
pub(crate) mod wide;

pub use cases::add_cases;

/// 64 cells of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Word {
    /// The corners: corner `k` is at the bits x, y, z of `k`.
    pub corners: [u64; 8],
    /// The edges that are cut, in eight lists: along x of the rows at (y, z) = 00, 10, 01, 11; along y
    /// from the low-x corner at z = 0, 1; along z from the low-x corner at y = 0, 1.
    pub cuts: [u64; 8],
    /// The cells that the surface crosses; of words that are listed for their open cells, those.
    pub active: u64,
    /// The row.
    pub row: usize,
    /// Number of the first cell in its row.
    pub first: usize,
}

/// Which of a word's lists of cut edges along x, y and z belong to the row itself.
pub(crate) const OWN: [usize; 3] = [0, 4, 6];

/// The corners of each face of a cell, in cyclic order.
const FACES: [[usize; 4]; 6] = {
    let mut faces = [[0; 4]; 6];
    let mut f = 0;
    while f < 6 {
        let (t, low) = (f / 2, (f % 2) << (f / 2));
        let (u, v) = (1 << ((t + 1) % 3), 1 << ((t + 2) % 3));
        faces[f] = [low, low | u, low | u | v, low | v];
        f += 1;
    }
    faces
};

impl Word {
    /// Word `w` of a row of cells. `cells` has a bit for each cell of the word.
    #[inline(always)]
    pub fn new(rows: [&[u64]; 4], w: usize, cells: u64) -> Self {
        let (mut corners, mut cuts) = ([0; 8], [0; 8]);
        let (mut any, mut all) = (0, u64::MAX);
        for (n, row) in rows.iter().enumerate() {
            let low = row[w];
            let high = low >> 1 | row.get(w + 1).map_or(0, |next| next << 63);
            (corners[2 * n], corners[2 * n + 1]) = (low, high);
            (any, all) = (any | low | high, all & low & high);
            cuts[n] = (low ^ high) & cells;
        }
        for n in 0..2 {
            cuts[4 + n] = corners[4 * n] ^ corners[4 * n + 2];
            cuts[6 + n] = corners[2 * n] ^ corners[2 * n + 4];
        }
        Self { corners, cuts, active: any & !all & cells, row: 0, first: WORD * w }
    }

    /// The edges that start at a low-x corner at (y, z) = 00 and are cut, along x, y and z.
    #[inline(always)]
    pub fn owned(&self) -> [u64; 3] {
        [self.cuts[OWN[0]], self.cuts[OWN[1]], self.cuts[OWN[2]]]
    }

    /// The case of cell `i`.
    #[inline(always)]
    pub fn case(&self, i: u32) -> u8 {
        (0..8).fold(0, |case, k| case | ((self.corners[k] >> i & 1) as u8) << k)
    }

    /// The crossed cells whose signs leave open what is connected: those with a face whose corners
    /// alternate, and those whose opposite corners have one sign each.
    #[inline(always)]
    pub fn open(&self) -> u64 {
        let k = &self.corners;
        let alternate = |[a, b, c, d]: [usize; 4]| (k[a] ^ k[b]) & (k[b] ^ k[c]) & (k[c] ^ k[d]);
        let is_ambiguous = FACES.into_iter().fold(0, |any, face| any | alternate(face));
        let is_uneven = (0..4).fold(0, |any, n| any | (k[n] ^ k[7 - n]));
        (is_ambiguous | !is_uneven) & self.active
    }

    /// Whether no cell is crossed and no edge that the row owns is cut.
    #[inline(always)]
    fn is_blank(&self) -> bool {
        let [x, y, z] = self.owned();
        self.active | x | y | z == 0
    }
}

/// The bits of a slice of lattice points and of the next slice: between them lie rows of cells.
///
/// Beyond the last row, and the last slice, the row itself stands in: no edge leads there, and no cell.
#[derive(Clone, Copy, Debug)]
pub struct BitRows<'a> {
    low: &'a [u64],
    high: &'a [u64],
    points: usize,
    has_layer: bool,
}

impl<'a> BitRows<'a> {
    /// A slice of rows of `points` points, and the next slice, if there is one.
    ///
    /// # Panics
    ///
    /// If a row has no point, or the slices are not of equally many whole rows.
    pub fn new(slice: &'a [u64], next: Option<&'a [u64]>, points: usize) -> Self {
        let high = next.unwrap_or(slice);
        assert!(points > 0 && slice.len().is_multiple_of(crate::words(points)), "whole rows");
        assert_eq!(slice.len(), high.len(), "equally many rows in both slices");
        Self { low: slice, high, points, has_layer: next.is_some() }
    }

    /// How many rows there are.
    pub fn rows(&self) -> usize {
        self.low.len() / self.words()
    }

    pub(crate) fn words(&self) -> usize {
        crate::words(self.points)
    }

    /// The four rows around row `y` of cells.
    #[inline(always)]
    fn around(&self, y: usize) -> [&'a [u64]; 4] {
        self.flat(y..y + 1)
    }

    /// Some rows and those around them, each as one list of words: more than one row only of those that have
    /// a next.
    #[inline(always)]
    pub(crate) fn flat(&self, rows: Range<usize>) -> [&'a [u64]; 4] {
        let words = self.words();
        let own = rows.start * words..rows.end * words;
        let next = match rows.end < self.rows() {
            true => own.start + words..own.end + words,
            false => own.clone(),
        };
        [&self.low[own.clone()], &self.low[next.clone()], &self.high[own], &self.high[next]]
    }

    /// Whether there are cells between a row and the next.
    #[inline(always)]
    pub(crate) fn has_cells(&self, y: usize) -> bool {
        self.has_layer && y + 1 < self.rows()
    }

    /// The bits of the cells in word `w` of a row: every point but the last is the low corner of one.
    #[inline(always)]
    pub(crate) fn cells(&self, w: usize) -> u64 {
        match w + 1 == self.words() {
            true => (1 << ((self.points - 1) % WORD)) - 1,
            false => u64::MAX,
        }
    }

    /// Adds words with open cells, told by the number of one among all words of all rows, and in the eight lowest bits by
    /// which of it and the seven after it they are. Their rows have cells.
    #[inline(always)]
    pub(crate) fn look_up(&self, packs: &[u64], out: &mut Vec<Word>) {
        let words = self.words();
        for &pack in packs {
            let (first, mut left) = ((pack >> 8) as usize, pack as u8);
            while left != 0 {
                let number = first + left.trailing_zeros() as usize;
                left &= left - 1;
                let (row, w) = (number / words, number % words);
                let whole = Word::new(self.around(row), w, self.cells(w));
                out.push(Word { row, cuts: [0; 8], active: whole.open(), ..whole });
            }
        }
    }

    /// Hands on the words of some rows that hold a crossed cell or a cut edge of the row.
    #[inline(always)]
    pub(crate) fn each_word(&self, rows: Range<usize>, mut take: impl FnMut(&Word)) {
        for y in rows {
            let (rows, has_cells) = (self.around(y), self.has_cells(y));
            for w in 0..self.words() {
                // Cheap first: in most words all four rows are alike and without a change.
                let [a, b, c, d] = [rows[0][w], rows[1][w], rows[2][w], rows[3][w]];
                let alike = ((a ^ b) | (a ^ c) | (a ^ d)) == 0;
                let next = |row: &[u64]| row.get(w + 1).map_or(a >> 63, |next| next & 1);
                let goes_on = (a == 0 && rows.iter().all(|row| next(row) == 0))
                    || (a == u64::MAX && rows.iter().all(|row| next(row) == 1));
                if alike && goes_on {
                    continue;
                }
                let mut word = Word { row: y, ..Word::new(rows, w, self.cells(w)) };
                if !has_cells {
                    word.active = 0;
                }
                if !word.is_blank() {
                    take(&word);
                }
            }
        }
    }
}

/// The words of some rows that hold a crossed cell or a cut edge of the row, row by row, into `out`.
///
/// # Panics
///
/// If there are no such rows.
pub fn words_of_rows(bits: &BitRows<'_>, rows: Range<usize>, out: &mut Vec<Word>) {
    words_of_rows_at(Level::current(), bits, rows, out);
}

pub(crate) fn words_of_rows_at(
    level: Level,
    bits: &BitRows<'_>,
    rows: Range<usize>,
    out: &mut Vec<Word>,
) {
    assert!(rows.end <= bits.rows(), "rows {rows:?} of {}", bits.rows());
    out.clear();
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { wide::with_avx512::words_of_rows(bits, rows, out) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { wide::with_avx2::words_of_rows(bits, rows, out) }
        }
        _ => bits.each_word(rows, |word| out.push(*word)),
    }
}

/// The words of some rows that hold an [open](Word::open) cell, row by row, into `out`. Their active cells are the open
/// ones, and their lists of cut edges are left empty.
///
/// # Panics
///
/// If there are no such rows.
pub fn open_words_of_rows(bits: &BitRows<'_>, rows: Range<usize>, out: &mut Vec<Word>) {
    open_words_of_rows_at(Level::current(), bits, rows, out);
}

pub(crate) fn open_words_of_rows_at(
    level: Level,
    bits: &BitRows<'_>,
    rows: Range<usize>,
    out: &mut Vec<Word>,
) {
    assert!(rows.end <= bits.rows(), "rows {rows:?} of {}", bits.rows());
    out.clear();
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { wide::with_avx512::open_words_of_rows(bits, rows, out) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { wide::with_avx2::open_words_of_rows(bits, rows, out) }
        }
        _ => bits.each_word(rows, |word| {
            let open = word.open();
            if open != 0 {
                out.push(Word { cuts: [0; 8], active: open, ..*word });
            }
        }),
    }
}
