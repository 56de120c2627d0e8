//! How many vertices and triangles rows make.

use crate::{BitRows, Level, Word};
use std::ops::Range;

/// Vertices on the edges that a row owns, along x, y and z, and triangles of its cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RowCounts {
    /// On edges along x.
    pub x: u32,
    /// On edges along y.
    pub y: u32,
    /// On edges along z.
    pub z: u32,
    /// In the cells that start at the row.
    pub triangles: u32,
}

/// Counts what some rows make, each into its place in `out`; `triangles` has the number of triangles of
/// each case.
///
/// # Panics
///
/// If there are no such rows, or `out` has not room for exactly those.
pub fn count_rows(
    bits: &BitRows<'_>,
    rows: Range<usize>,
    triangles: &[u8; 256],
    out: &mut [RowCounts],
) {
    count_rows_at(Level::current(), bits, rows, triangles, out);
}

fn count_rows_at(
    level: Level,
    bits: &BitRows<'_>,
    rows: Range<usize>,
    triangles: &[u8; 256],
    out: &mut [RowCounts],
) {
    assert!(rows.end <= bits.rows(), "rows {rows:?} of {}", bits.rows());
    assert_eq!(rows.len(), out.len(), "a count for each row");
    out.fill(RowCounts::default());
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { wide::count_rows_avx512(bits, rows, triangles, out) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { wide::count_rows_avx2(bits, rows, triangles, out) }
        }
        _ => count_rows_plain(bits, rows, triangles, out),
    }
}

/// Counts words that were picked out before, each into the place of its row in `out`.
///
/// # Panics
///
/// If a word's row has no place.
pub fn count_words(words: &[Word], triangles: &[u8; 256], out: &mut [RowCounts]) {
    count_words_at(Level::current(), words, triangles, out);
}

fn count_words_at(level: Level, words: &[Word], triangles: &[u8; 256], out: &mut [RowCounts]) {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { wide::count_words_avx512(words, triangles, out) }
        }
        _ => words.iter().for_each(|word| out[word.row].add(word, triangles)),
    }
}

#[inline(always)]
fn count_rows_plain(
    bits: &BitRows<'_>,
    rows: Range<usize>,
    triangles: &[u8; 256],
    out: &mut [RowCounts],
) {
    let first = rows.start;
    bits.each_word(rows, |word| out[word.row - first].add(word, triangles));
}

impl RowCounts {
    #[inline(always)]
    fn add(&mut self, word: &Word, triangles: &[u8; 256]) {
        let [x, y, z] = word.owned();
        self.x += x.count_ones();
        self.y += y.count_ones();
        self.z += z.count_ones();
        let mut active = word.active;
        while active != 0 {
            let case = word.case(active.trailing_zeros());
            self.triangles += u32::from(triangles[usize::from(case)]);
            active &= active - 1;
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::{BitRows, RowCounts, Word, count_rows_plain};
    use crate::word::wide::{Eights, words};
    use std::{arch::x86_64::*, ops::Range};

    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn count_rows_avx2(
        bits: &BitRows<'_>,
        rows: Range<usize>,
        triangles: &[u8; 256],
        out: &mut [RowCounts],
    ) {
        count_rows_plain(bits, rows, triangles, out);
    }

    /// All 64 cases of a word at once, looked up in a table of four registers.
    #[target_feature(
        enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi,avx512vbmi2,avx512vpopcntdq,gfni"
    )]
    pub(super) fn count_rows_avx512(
        bits: &BitRows<'_>,
        rows: Range<usize>,
        triangles: &[u8; 256],
        out: &mut [RowCounts],
    ) {
        let table = registers(triangles);
        let first = rows.start;
        let mut eights = Eights::new(bits, rows);
        while let Some(eight) = eights.next() {
            let [x, y, z] = eight.owned;
            let x = words(_mm512_popcnt_epi64(x));
            let y = words(_mm512_popcnt_epi64(y));
            let z = words(_mm512_popcnt_epi64(z));
            let active = words(eight.active);
            let corners = eight.corners();
            let mut found = eight.found;
            while found != 0 {
                let n = found.trailing_zeros() as usize;
                found &= found - 1;
                let counts = &mut out[eight.place(n)[0] - first];
                counts.x += x[n] as u32;
                counts.y += y[n] as u32;
                counts.z += z[n] as u32;
                counts.triangles += triangles_of(corners[n], active[n], table);
            }
        }
    }

    #[target_feature(
        enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi,gfni"
    )]
    pub(super) fn count_words_avx512(words: &[Word], triangles: &[u8; 256], out: &mut [RowCounts]) {
        let table = registers(triangles);
        for word in words {
            let [x, y, z] = word.owned();
            // SAFETY: eight words fill one register; the load needs no alignment.
            let corners = unsafe { _mm512_loadu_epi64(word.corners.as_ptr().cast()) };
            let counts = &mut out[word.row];
            counts.x += x.count_ones();
            counts.y += y.count_ones();
            counts.z += z.count_ones();
            counts.triangles += triangles_of(corners, word.active, table);
        }
    }

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw")]
    fn registers(triangles: &[u8; 256]) -> [__m512i; 4] {
        let (table, _) = triangles.as_chunks::<64>();
        // SAFETY: each of the four chunks is 64 bytes; the load needs no alignment.
        let part = |n: usize| unsafe { _mm512_loadu_epi8(table[n].as_ptr().cast()) };
        [part(0), part(1), part(2), part(3)]
    }

    /// The triangles of the cells of a word that are crossed.
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vbmi,gfni")]
    fn triangles_of(corners: __m512i, active: u64, table: [__m512i; 4]) -> u32 {
        let cases = cases(corners);
        // The lower half of the table for cases below 128, the upper for the others.
        let low = _mm512_permutex2var_epi8(table[0], cases, table[1]);
        let high = _mm512_permutex2var_epi8(table[2], cases, table[3]);
        let all = _mm512_mask_blend_epi8(_mm512_movepi8_mask(cases), low, high);
        let sums = _mm512_sad_epu8(_mm512_maskz_mov_epi8(active, all), _mm512_setzero_si512());
        _mm512_reduce_add_epi64(sums) as u32
    }

    /// The cases of 64 cells, a byte each, from their corners, a word each.
    ///
    /// Bytes with the same eight cells come together, and each eight by eight bits are turned about their
    /// diagonal: a matrix product with the identity, which has its rows in reverse.
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vbmi,gfni")]
    fn cases(corners: __m512i) -> __m512i {
        const TOGETHER: [u8; 64] = {
            let mut order = [0; 64];
            let mut i = 0;
            while i < 64 {
                order[i] = (8 * (7 - i % 8) + i / 8) as u8;
                i += 1;
            }
            order
        };
        // SAFETY: the order fills one register; the load needs no alignment.
        let together = unsafe { _mm512_loadu_epi8(TOGETHER.as_ptr().cast()) };
        let matrices = _mm512_permutexvar_epi8(together, corners);
        _mm512_gf2p8affine_epi64_epi8::<0>(
            _mm512_set1_epi64(0x8040_2010_0804_0201_u64 as i64),
            matrices,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{RowCounts, count_rows_at, count_words_at};
    use crate::{BitRows, Level, Word, words_of_rows};

    #[test]
    fn every_level_agrees_with_the_definition() {
        let mut state = 5_u64;
        let mut chance = || {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
            state ^ state >> 31
        };
        let mut table = [0; 256];
        table.fill_with(|| chance() as u8 % 6);
        let mut words = vec![];
        for points in (1..=200_usize).chain([511, 512, 513, 600, 1100]) {
            for is_sparse in [false, true] {
                let rows = 1 + chance() as usize % 7;
                let mut slice = || -> Vec<u64> {
                    let per_row = points.div_ceil(64);
                    let mut word = |n: usize| {
                        let word = if is_sparse && chance() % 4 > 0 { 0 } else { chance() };
                        let is_cut = n % per_row == per_row - 1 && !points.is_multiple_of(64);
                        if is_cut { word & ((1 << (points % 64)) - 1) } else { word }
                    };
                    (0..per_row * rows).map(&mut word).collect()
                };
                let (low, high) = (slice(), slice());
                let next = (points % 5 > 0).then_some(&high[..]);
                let bits = BitRows::new(&low, next, points);
                let own = rows / 4..rows;
                words_of_rows(&bits, own.clone(), &mut words);
                let mut expected = vec![RowCounts::default(); own.len()];
                words.iter().for_each(|w| define(w, &table, &mut expected[w.row - own.start]));
                for &level in Level::available() {
                    let mut found = vec![RowCounts { x: 7, ..RowCounts::default() }; own.len()];
                    count_rows_at(level, &bits, own.clone(), &table, &mut found);
                    assert_eq!(found, expected, "{level}, {points} points");
                    let mut found = vec![RowCounts::default(); rows];
                    count_words_at(level, &words, &table, &mut found);
                    assert_eq!(found[own.start..], expected, "{level}, {points} points");
                }
            }
        }
    }

    fn define(word: &Word, table: &[u8; 256], counts: &mut RowCounts) {
        for i in 0..64 {
            let bit = |mask: u64| (mask >> i & 1) as u32;
            counts.x += bit(word.cuts[0]);
            counts.y += bit(word.cuts[4]);
            counts.z += bit(word.cuts[6]);
            counts.triangles += bit(word.active) * u32::from(table[usize::from(word.case(i))]);
        }
    }
}
