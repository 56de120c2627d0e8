//! What 64 neighbouring cells of a row hold: which of their edges are cut, and their cases.
//!
//! A row of cells has four rows of lattice points around it, at (y, z) = 00, 10, 01, 11. In each bit
//! position of a [`Word`] stands one cell. Its low-x corners are the bits of those rows, its high-x
//! corners the same bits shifted down by one.

use crate::{Level, WORD};

/// 64 cells of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Word {
    /// The corners: corner `k` is at the bits x, y, z of `k`.
    pub corners: [u64; 8],
    /// The edges that are cut, in eight lists: along x of the rows at (y, z) = 00, 10, 01, 11; along y
    /// from the low-x corner at z = 0, 1; along z from the low-x corner at y = 0, 1.
    pub cuts: [u64; 8],
    /// The cells that the surface crosses.
    pub active: u64,
    /// Number of the first cell in its row.
    pub first: usize,
}

/// Which of a word's lists of cut edges along x, y and z belong to the row itself.
pub(crate) const OWN: [usize; 3] = [0, 4, 6];

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
        Self { corners, cuts, active: any & !all & cells, first: WORD * w }
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

    /// Whether no cell is crossed and no edge that the row owns is cut.
    #[inline(always)]
    fn is_blank(&self) -> bool {
        let [x, y, z] = self.owned();
        self.active | x | y | z == 0
    }
}

/// The words of a row of `points` lattice points that hold a crossed cell or a cut edge of its own, into
/// `out`.
///
/// # Panics
///
/// If the rows are not of `points` points each.
pub fn words_of_row(rows: [&[u64]; 4], points: usize, out: &mut Vec<Word>) {
    words_of_row_at(Level::current(), rows, points, out);
}

fn words_of_row_at(level: Level, rows: [&[u64]; 4], points: usize, out: &mut Vec<Word>) {
    out.clear();
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { wide::words_of_row_avx512(rows, points, out) }
        }
        _ => each_word(rows, points, |word| out.push(*word)),
    }
}

/// Hands on the words of a row that are not blank.
#[inline(always)]
pub(crate) fn each_word(rows: [&[u64]; 4], points: usize, mut take: impl FnMut(&Word)) {
    let words = crate::words(points);
    let rows = rows.map(|row| &row[..words]);
    for w in 0..words {
        // Cheap first: in most words all four rows are alike and without a change.
        let [a, b, c, d] = rows.map(|row| row[w]);
        let alike = ((a ^ b) | (a ^ c) | (a ^ d)) == 0;
        let next = |row: &[u64]| row.get(w + 1).map_or(a >> 63, |next| next & 1);
        let goes_on = (a == 0 && rows.iter().all(|row| next(row) == 0))
            || (a == u64::MAX && rows.iter().all(|row| next(row) == 1));
        if alike && goes_on {
            continue;
        }
        let word = Word::new(rows, w, cells_of_word(w, points));
        if !word.is_blank() {
            take(&word);
        }
    }
}

/// A bit for each cell of word `w`: every point but the last is the low corner of one.
#[inline(always)]
fn cells_of_word(w: usize, points: usize) -> u64 {
    match w + 1 == crate::words(points) {
        true => (1 << ((points - 1) % WORD)) - 1,
        false => u64::MAX,
    }
}

#[cfg(target_arch = "x86_64")]
pub(crate) mod wide {
    //! Eight words in a register.

    use super::{WORD, Word};
    use std::arch::x86_64::*;

    /// Eight words of a row of cells, or as many as there are.
    #[derive(Clone, Copy)]
    pub(crate) struct Eight {
        /// The low-x corners of the four rows; behind the last word zeros.
        low: [__m512i; 4],
        high: [__m512i; 4],
        cells: __m512i,
        /// The crossed cells.
        pub(crate) active: __m512i,
        /// The cut edges that the row owns, along x, y, z.
        pub(crate) owned: [__m512i; 3],
        /// The words that are not blank.
        pub(crate) found: u8,
    }

    impl Eight {
        /// The words from `w` on, which is below the number of words in each row.
        #[inline]
        #[target_feature(enable = "avx512f,avx512vbmi2")]
        pub(crate) fn new(rows: [&[u64]; 4], w: usize, points: usize) -> Self {
            let words = crate::words(points);
            let left = words - w;
            let own = if left < 8 { (1_u8 << left) - 1 } else { u8::MAX };
            let next = if left < 9 { (1_u8 << (left - 1)) - 1 } else { u8::MAX };
            let zero = _mm512_setzero_si512();
            let (mut low, mut high) = ([zero; 4], [zero; 4]);
            let (mut any, mut all) = (zero, _mm512_set1_epi64(-1));
            for (n, row) in rows.into_iter().enumerate() {
                let row = &row[w..words];
                // SAFETY: the masks let through only words of the row.
                let (a, b) = unsafe {
                    (
                        _mm512_maskz_loadu_epi64(own, row.as_ptr().cast()),
                        _mm512_maskz_loadu_epi64(next, row.as_ptr().wrapping_add(1).cast()),
                    )
                };
                (low[n], high[n]) = (a, _mm512_shrdi_epi64::<1>(a, b));
                any = _mm512_or_si512(any, _mm512_or_si512(a, high[n]));
                all = _mm512_and_si512(all, _mm512_and_si512(a, high[n]));
            }
            let last = _mm512_set1_epi64(super::cells_of_word(words - 1, points) as i64);
            let whole = _mm512_maskz_set1_epi64(own, -1);
            let is_last = if left <= 8 { 1_u8 << (left - 1) } else { 0 };
            let cells = _mm512_mask_mov_epi64(whole, is_last, last);
            let active = _mm512_and_si512(_mm512_andnot_si512(all, any), cells);
            let x = _mm512_and_si512(_mm512_xor_si512(low[0], high[0]), cells);
            let owned = [x, _mm512_xor_si512(low[0], low[1]), _mm512_xor_si512(low[0], low[2])];
            let some =
                _mm512_or_si512(_mm512_or_si512(active, x), _mm512_or_si512(owned[1], owned[2]));
            let found = _mm512_test_epi64_mask(some, some);
            Self { low, high, cells, active, owned, found }
        }

        /// The corners of each word: one register a word.
        #[inline]
        #[target_feature(enable = "avx512f")]
        pub(crate) fn corners(&self) -> [__m512i; 8] {
            let (a, b) = (self.low, self.high);
            transposed([a[0], b[0], a[1], b[1], a[2], b[2], a[3], b[3]])
        }

        /// The eight lists of cut edges of each word.
        #[inline]
        #[target_feature(enable = "avx512f")]
        fn cuts(&self) -> [__m512i; 8] {
            let (mut cuts, low) = ([self.cells; 8], self.low);
            for n in 0..4 {
                let differ = _mm512_xor_si512(low[n], self.high[n]);
                cuts[n] = _mm512_and_si512(differ, self.cells);
            }
            for n in 0..2 {
                cuts[4 + n] = _mm512_xor_si512(low[2 * n], low[2 * n + 1]);
                cuts[6 + n] = _mm512_xor_si512(low[n], low[n + 2]);
            }
            transposed(cuts)
        }
    }

    /// Register `n` of what comes out holds number `n` of each register.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn transposed(rows: [__m512i; 8]) -> [__m512i; 8] {
        let mut pairs = rows;
        for n in 0..4 {
            pairs[2 * n] = _mm512_unpacklo_epi64(rows[2 * n], rows[2 * n + 1]);
            pairs[2 * n + 1] = _mm512_unpackhi_epi64(rows[2 * n], rows[2 * n + 1]);
        }
        let mut columns = rows;
        for odd in 0..2 {
            let [a, b, c, d] = [pairs[odd], pairs[2 + odd], pairs[4 + odd], pairs[6 + odd]];
            let (ab, cd) = (_mm512_shuffle_i64x2::<0x88>(a, b), _mm512_shuffle_i64x2::<0x88>(c, d));
            columns[odd] = _mm512_shuffle_i64x2::<0x88>(ab, cd);
            columns[4 + odd] = _mm512_shuffle_i64x2::<0xDD>(ab, cd);
            let (ab, cd) = (_mm512_shuffle_i64x2::<0xDD>(a, b), _mm512_shuffle_i64x2::<0xDD>(c, d));
            columns[2 + odd] = _mm512_shuffle_i64x2::<0x88>(ab, cd);
            columns[6 + odd] = _mm512_shuffle_i64x2::<0xDD>(ab, cd);
        }
        columns
    }

    #[inline]
    #[target_feature(enable = "avx512f")]
    pub(crate) fn words(register: __m512i) -> [u64; 8] {
        let mut words = [0; 8];
        // SAFETY: eight words are one register; the store needs no alignment.
        unsafe { _mm512_storeu_epi64(words.as_mut_ptr().cast(), register) };
        words
    }

    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vbmi2")]
    pub(super) fn words_of_row_avx512(rows: [&[u64]; 4], points: usize, out: &mut Vec<Word>) {
        for w in (0..crate::words(points)).step_by(8) {
            let eight = Eight::new(rows, w, points);
            if eight.found == 0 {
                continue;
            }
            let (corners, cuts, active) = (eight.corners(), eight.cuts(), words(eight.active));
            out.reserve(8);
            let mut found = eight.found;
            while found != 0 {
                let n = found.trailing_zeros() as usize;
                found &= found - 1;
                let (corners, cuts) = (words(corners[n]), words(cuts[n]));
                out.push(Word { corners, cuts, active: active[n], first: WORD * (w + n) });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Word, words_of_row_at};
    use crate::Level;

    /// Each mask by its definition, from the corners of single cells.
    fn check(rows: [&[u64]; 4], points: usize) {
        Level::available().iter().for_each(|&level| check_at(level, rows, points));
    }

    fn check_at(level: Level, rows: [&[u64]; 4], points: usize) {
        let inside = |row: usize, i: usize| i < points && rows[row][i / 64] >> (i % 64) & 1 == 1;
        let mut words = vec![Word::default()];
        words_of_row_at(level, rows, points, &mut words);
        for i in 0..points {
            let blank = Word { first: i / 64 * 64, ..Word::default() };
            let word = *words.iter().find(|word| word.first == blank.first).unwrap_or(&blank);
            let is_cell = i + 1 < points;
            let corner = |k: usize| inside(k >> 1, i + (k & 1));
            let bit = |mask: u64| mask >> (i % 64) & 1 == 1;
            for n in 0..4 {
                assert_eq!(
                    bit(word.cuts[n]),
                    is_cell && corner(2 * n) != corner(2 * n + 1),
                    "x {n}"
                );
            }
            assert_eq!(bit(word.cuts[4]), corner(0) != corner(2), "y of {i}");
            assert_eq!(bit(word.cuts[6]), corner(0) != corner(4), "z of {i}");
            let case: u32 = (0..8).map(|k| u32::from(corner(k)) << k).sum();
            let active = is_cell && case != 0 && case != 255;
            assert_eq!(bit(word.active), active, "active {i}");
            if active {
                assert_eq!(bit(word.cuts[5]), corner(4) != corner(6), "y of {i}");
                assert_eq!(bit(word.cuts[7]), corner(2) != corner(6), "z of {i}");
                assert_eq!(u32::from(word.case(i as u32 % 64)), case, "case {i}");
            }
        }
    }

    #[test]
    fn agrees_with_the_definition_on_every_short_row() {
        for points in 1..=4 {
            for bits in 0..1_u64 << (4 * points) {
                let row = |r: usize| [bits >> (r * points) & ((1 << points) - 1)];
                let rows = [row(0), row(1), row(2), row(3)];
                check([&rows[0], &rows[1], &rows[2], &rows[3]], points);
            }
        }
    }

    #[test]
    fn agrees_with_the_definition_across_words() {
        let mut state = 1_u64;
        let mut chance = || {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
            state ^ state >> 29
        };
        for points in [63_usize, 64, 65, 127, 128, 129, 190].repeat(30) {
            let words = points.div_ceil(64);
            let tail = if points % 64 == 0 { u64::MAX } else { (1 << (points % 64)) - 1 };
            // Rows that are mostly alike, full or empty, so that blank words occur.
            let base: Vec<u64> = (0..words).map(|_| [0, u64::MAX][chance() as usize % 2]).collect();
            let mut row = || {
                let odd = chance();
                let mut row = base.clone();
                if odd % 3 == 0 {
                    row[odd as usize / 3 % words] = chance();
                }
                row[words - 1] &= tail;
                row
            };
            let rows = [row(), row(), row(), row()];
            check([&rows[0], &rows[1], &rows[2], &rows[3]], points);
        }
    }
}
