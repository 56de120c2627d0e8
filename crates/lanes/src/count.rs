//! How many vertices and triangles a row makes.

use crate::{Level, Word, word::each_word};

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

/// Counts what a row of `points` lattice points makes, from the four rows around its cells at (y, z) =
/// 00, 10, 01, 11; `triangles` has the number of triangles of each case.
///
/// # Panics
///
/// If the rows are not of `points` points each.
pub fn count_row(rows: [&[u64]; 4], points: usize, triangles: &[u8; 256]) -> RowCounts {
    count_row_at(Level::current(), rows, points, triangles)
}

fn count_row_at(
    level: Level,
    rows: [&[u64]; 4],
    points: usize,
    triangles: &[u8; 256],
) -> RowCounts {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { wide::count_row_avx512(rows, points, triangles) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { wide::count_row_avx2(rows, points, triangles) }
        }
        _ => count_row_plain(rows, points, triangles),
    }
}

#[inline(always)]
fn count_row_plain(rows: [&[u64]; 4], points: usize, triangles: &[u8; 256]) -> RowCounts {
    let mut counts = RowCounts::default();
    each_word(rows, points, |word| counts.add(word, triangles));
    counts
}

/// Counts words of a row, as [`words_of_row`](crate::words_of_row) gives them.
pub fn count(words: &[Word], triangles: &[u8; 256]) -> RowCounts {
    let mut counts = RowCounts::default();
    words.iter().for_each(|word| counts.add(word, triangles));
    counts
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
    use super::{RowCounts, count_row_plain};
    use crate::word::wide::{Eight, words};
    use std::arch::x86_64::*;

    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn count_row_avx2(
        rows: [&[u64]; 4],
        points: usize,
        triangles: &[u8; 256],
    ) -> RowCounts {
        count_row_plain(rows, points, triangles)
    }

    /// All 64 cases of a word at once, looked up in a table of four registers.
    #[target_feature(
        enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi,avx512vbmi2,avx512vpopcntdq,gfni"
    )]
    pub(super) fn count_row_avx512(
        rows: [&[u64]; 4],
        points: usize,
        triangles: &[u8; 256],
    ) -> RowCounts {
        let (table, _) = triangles.as_chunks::<64>();
        // SAFETY: each of the four chunks is 64 bytes; the load needs no alignment.
        let part = |n: usize| unsafe { _mm512_loadu_epi8(table[n].as_ptr().cast()) };
        let zero = _mm512_setzero_si512();
        let (mut sums, mut sum) = ([zero; 3], zero);
        for w in (0..crate::words(points)).step_by(8) {
            let eight = Eight::new(rows, w, points);
            if eight.found == 0 {
                continue;
            }
            for (sum, owned) in sums.iter_mut().zip(eight.owned) {
                *sum = _mm512_add_epi64(*sum, _mm512_popcnt_epi64(owned));
            }
            let (corners, active) = (eight.corners(), words(eight.active));
            let mut found = _mm512_test_epi64_mask(eight.active, eight.active);
            while found != 0 {
                let n = found.trailing_zeros() as usize;
                found &= found - 1;
                let cases = cases(corners[n]);
                // The lower half of the table for cases below 128, the upper for the others.
                let low = _mm512_permutex2var_epi8(part(0), cases, part(1));
                let high = _mm512_permutex2var_epi8(part(2), cases, part(3));
                let found = _mm512_mask_blend_epi8(_mm512_movepi8_mask(cases), low, high);
                let found = _mm512_maskz_mov_epi8(active[n], found);
                sum = _mm512_add_epi64(sum, _mm512_sad_epu8(found, zero));
            }
        }
        if _mm512_test_epi64_mask(sum, sum) == 0 && sums_are_zero(sums) {
            return RowCounts::default();
        }
        RowCounts {
            x: _mm512_reduce_add_epi64(sums[0]) as u32,
            y: _mm512_reduce_add_epi64(sums[1]) as u32,
            z: _mm512_reduce_add_epi64(sums[2]) as u32,
            triangles: _mm512_reduce_add_epi64(sum) as u32,
        }
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

    #[inline]
    #[target_feature(enable = "avx512f")]
    fn sums_are_zero([x, y, z]: [__m512i; 3]) -> bool {
        let any = _mm512_or_si512(_mm512_or_si512(x, y), z);
        _mm512_test_epi64_mask(any, any) == 0
    }
}

#[cfg(test)]
mod tests {
    use super::{RowCounts, count, count_row_at};
    use crate::{Level, Word, words_of_row};

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
                let mut row = || -> Vec<u64> {
                    let mut word = || if is_sparse && chance() % 4 > 0 { 0 } else { chance() };
                    let mut row: Vec<u64> = (0..points.div_ceil(64)).map(|_| word()).collect();
                    if !points.is_multiple_of(64) {
                        row[points / 64] &= (1 << (points % 64)) - 1;
                    }
                    row
                };
                let rows = [row(), row(), row(), row()];
                let rows = rows.each_ref().map(Vec::as_slice);
                words_of_row(rows, points, &mut words);
                let expected = by_definition(&words, &table);
                assert_eq!(count(&words, &table), expected, "{points} points");
                for &level in Level::available() {
                    let found = count_row_at(level, rows, points, &table);
                    assert_eq!(found, expected, "{level}, {points} points");
                }
            }
        }
    }

    fn by_definition(words: &[Word], table: &[u8; 256]) -> RowCounts {
        let mut counts = RowCounts::default();
        for (word, i) in words.iter().flat_map(|word| (0..64).map(move |i| (word, i))) {
            let bit = |mask: u64| (mask >> i & 1) as u32;
            counts.x += bit(word.cuts[0]);
            counts.y += bit(word.cuts[4]);
            counts.z += bit(word.cuts[6]);
            counts.triangles += bit(word.active) * u32::from(table[usize::from(word.case(i))]);
        }
        counts
    }
}
