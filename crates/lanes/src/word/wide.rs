//! Eight words in a register, of one row or of several.

use super::{BitRows, FACES, WORD, Word};
use std::{arch::x86_64::*, iter, ops::Range};

/// Eight neighbouring words of rows of cells, or as many as there are.
#[derive(Clone, Copy)]
pub(crate) struct Eight {
    /// The low-x corners of the four rows; behind the last word zeros.
    pub(crate) low: [__m512i; 4],
    pub(crate) high: [__m512i; 4],
    pub(crate) cells: __m512i,
    /// The crossed cells.
    pub(crate) active: __m512i,
    /// The words that are not blank.
    pub(crate) found: u8,
    /// Row and place in it of the first word, and words in a row.
    place: [usize; 2],
    words: usize,
}

impl Eight {
    /// Row and place in it of word `n`.
    #[inline(always)]
    pub(crate) fn place(&self, n: usize) -> [usize; 2] {
        let [mut row, mut w] = [self.place[0], self.place[1] + n];
        while w >= self.words {
            (row, w) = (row + 1, w - self.words);
        }
        [row, w]
    }

    /// The corners of each word: one register a word.
    #[inline]
    #[target_feature(enable = "avx512f")]
    pub(crate) fn corners(&self) -> [__m512i; 8] {
        // What came to the last word of a row from the next row is no corner.
        let (a, mut b) = (self.low, self.high);
        for high in &mut b {
            *high = _mm512_and_si512(*high, self.cells);
        }
        transposed([a[0], b[0], a[1], b[1], a[2], b[2], a[3], b[3]])
    }

    /// The words that hold an open cell.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn open(&self) -> u8 {
        let (a, b) = (self.low, self.high);
        let k = [a[0], b[0], a[1], b[1], a[2], b[2], a[3], b[3]];
        let differ = |p: usize, q: usize| _mm512_xor_si512(k[p], k[q]);
        let (mut ambiguous, mut uneven) = (_mm512_setzero_si512(), _mm512_setzero_si512());
        for [a, b, c, d] in FACES {
            let two = _mm512_and_si512(differ(a, b), differ(b, c));
            ambiguous = _mm512_or_si512(ambiguous, _mm512_and_si512(two, differ(c, d)));
        }
        for n in 0..4 {
            uneven = _mm512_or_si512(uneven, differ(n, 7 - n));
        }
        let even = _mm512_andnot_si512(uneven, self.active);
        let open = _mm512_or_si512(even, _mm512_and_si512(ambiguous, self.active));
        _mm512_test_epi64_mask(open, open)
    }

    /// Adds those of the words that are not blank.
    #[inline]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vbmi2")]
    fn push_words(&self, out: &mut Vec<Word>) {
        let (corners, cuts, active) = (self.corners(), self.cuts(), words(self.active));
        for n in Self::each(self.found) {
            let (corners, cuts) = (words(corners[n]), words(cuts[n]));
            let [row, w] = self.place(n);
            out.push(Word { corners, cuts, active: active[n], row, first: WORD * w });
        }
    }

    /// Adds those of the words that hold an open cell, without their cut edges.
    #[inline]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vbmi2")]
    pub(crate) fn push_open_words(&self, out: &mut Vec<Word>) {
        let open = self.open();
        if open != 0 {
            let (corners, active) = (self.corners(), words(self.active));
            for n in Self::each(open) {
                let [row, w] = self.place(n);
                let (corners, first) = (words(corners[n]), WORD * w);
                out.push(Word { corners, cuts: [0; 8], active: active[n], row, first });
            }
        }
    }

    /// The places of the bits that are set.
    #[inline(always)]
    fn each(mut wanted: u8) -> impl Iterator<Item = usize> {
        iter::from_fn(move || {
            let n = wanted.trailing_zeros() as usize;
            wanted &= wanted.wrapping_sub(1);
            (n < 8).then_some(n)
        })
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

/// Goes through the words of rows, eight at a time, and leaves out what is blank.
///
/// Rows lie one behind another, so eight words may be of several rows. Only the words of the last row of
/// all are taken apart: it has no next row.
pub(crate) struct Eights<'a> {
    bits: BitRows<'a>,
    /// The rows that are left once these words are through.
    left: Range<usize>,
    /// Words of some rows, and of those beside and above them; there may be more than are wanted.
    flat: [&'a [u64]; 4],
    wanted: usize,
    at: usize,
    /// Row of the word at `at`, and its place in the row.
    place: [usize; 2],
    has_cells: bool,
}

/// Of eight words, of which the first has place `p` in a row of `n` words, which end a row: `[n][p]`, for
/// rows that are shorter than that.
const LAST_OF_ROW: [[u8; 8]; 8] = {
    let mut table = [[0; 8]; 8];
    let mut i = 0;
    while i < 512 {
        let (words, place, n) = (i / 64, i / 8 % 8, i % 8);
        if words > 0 && (place + n) % words == words - 1 {
            table[words][place] |= 1 << n;
        }
        i += 1;
    }
    table
};

impl<'a> Eights<'a> {
    pub(crate) fn new(bits: &BitRows<'a>, rows: Range<usize>) -> Self {
        let place = [rows.start, 0];
        let flat = [&bits.low[..0]; 4];
        Self { bits: *bits, left: rows, flat, wanted: 0, at: 0, place, has_cells: false }
    }

    /// Only the words `run` of a row.
    pub(crate) fn of_run(bits: &BitRows<'a>, row: usize, run: Range<usize>) -> Self {
        // The last cell of the run has its high-x corners in the next word, if there is one.
        let end = bits.words().min(run.end + 1);
        let [a, b, c, d] = bits.around(row);
        Self {
            flat: [&a[run.start..end], &b[run.start..end], &c[run.start..end], &d[run.start..end]],
            wanted: run.len(),
            place: [row, run.start],
            has_cells: bits.has_cells(row),
            ..Self::new(bits, 0..0)
        }
    }

    /// The next eight words of which one is not blank.
    #[inline]
    #[target_feature(enable = "avx512f,avx512vbmi2")]
    pub(crate) fn next(&mut self) -> Option<Eight> {
        loop {
            if self.at >= self.wanted && !self.take_rows() {
                return None;
            }
            let eight = self.eight();
            self.at += 8;
            self.place = eight.place(8);
            if eight.found != 0 {
                return Some(eight);
            }
        }
    }

    /// Begins with the rows that are left: all but the last of all, or that one. None if none are.
    fn take_rows(&mut self) -> bool {
        if self.left.is_empty() {
            return false;
        }
        let first = self.left.start;
        let end = self.left.end.min(self.bits.rows() - 1).max(first + 1);
        self.flat = self.bits.flat(first..end);
        (self.at, self.wanted, self.place) = (0, self.flat[0].len(), [first, 0]);
        self.has_cells = self.bits.has_cells(first);
        self.left.start = end;
        true
    }

    #[inline]
    #[target_feature(enable = "avx512f,avx512vbmi2")]
    fn eight(&self) -> Eight {
        let (left, held) = (self.wanted - self.at, self.flat[0].len() - self.at);
        let own = if left < 8 { (1_u8 << left) - 1 } else { u8::MAX };
        let next = if held < 9 { (1_u8 << (held - 1)) - 1 } else { u8::MAX };
        let zero = _mm512_setzero_si512();
        let (mut low, mut high) = ([zero; 4], [zero; 4]);
        let (mut any, mut all) = (zero, _mm512_set1_epi64(-1));
        for (n, row) in self.flat.into_iter().enumerate() {
            let row = &row[self.at..];
            // SAFETY: the masks let through only words of the rows, as many as the first has.
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
        let words = self.bits.words();
        let last_of_row = match words < 8 {
            true => LAST_OF_ROW[words][self.place[1]],
            false => (1_u64 << (words - 1 - self.place[1]).min(63)) as u8,
        };
        let last = self.bits.cells(words - 1) as i64;
        let cells = _mm512_mask_set1_epi64(_mm512_set1_epi64(-1), last_of_row, last);
        let crossed = _mm512_and_si512(_mm512_andnot_si512(all, any), cells);
        let active = if self.has_cells { crossed } else { zero };
        let x = _mm512_and_si512(_mm512_xor_si512(low[0], high[0]), cells);
        let (y, z) = (_mm512_xor_si512(low[0], low[1]), _mm512_xor_si512(low[0], low[2]));
        let some = _mm512_or_si512(_mm512_or_si512(active, x), _mm512_or_si512(y, z));
        let found = _mm512_test_epi64_mask(some, some);
        Eight { low, high, cells, active, found, place: self.place, words }
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
pub(super) fn words_of_rows(bits: &BitRows<'_>, rows: Range<usize>, out: &mut Vec<Word>) {
    push_words(Eights::new(bits, rows), out);
}

#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vbmi2")]
pub(super) fn words_of_run(bits: &BitRows<'_>, row: usize, run: Range<usize>, out: &mut Vec<Word>) {
    push_words(Eights::of_run(bits, row, run), out);
}

#[inline]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vbmi2")]
fn push_words(mut eights: Eights<'_>, out: &mut Vec<Word>) {
    while let Some(eight) = eights.next() {
        eight.push_words(out);
    }
}

#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vbmi2")]
pub(super) fn open_words_of_rows(bits: &BitRows<'_>, rows: Range<usize>, out: &mut Vec<Word>) {
    let mut eights = Eights::new(bits, rows);
    while let Some(eight) = eights.next() {
        eight.push_open_words(out);
    }
}
