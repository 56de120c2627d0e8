//! How many vertices and triangles a row makes.

use crate::{Level, Word};

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

/// Counts a row's words; `triangles` has the number of triangles of each case.
pub fn count(words: &[Word], triangles: &[u8; 256]) -> RowCounts {
    count_at(Level::current(), words, triangles)
}

fn count_at(level: Level, words: &[Word], triangles: &[u8; 256]) -> RowCounts {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { wide::count_avx512(words, triangles) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { wide::count_avx2(words, triangles) }
        }
        _ => count_plain(words, triangles),
    }
}

#[inline(always)]
fn count_plain(words: &[Word], triangles: &[u8; 256]) -> RowCounts {
    let mut counts = RowCounts::default();
    for word in words {
        counts.add_edges(word);
        let mut active = word.active;
        while active != 0 {
            let case = word.case(active.trailing_zeros());
            counts.triangles += u32::from(triangles[usize::from(case)]);
            active &= active - 1;
        }
    }
    counts
}

impl RowCounts {
    #[inline(always)]
    fn add_edges(&mut self, word: &Word) {
        let [x, y, z] = word.owned();
        self.x += x.count_ones();
        self.y += y.count_ones();
        self.z += z.count_ones();
    }
}

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::{RowCounts, Word, count_plain};
    use std::arch::x86_64::*;

    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn count_avx2(words: &[Word], triangles: &[u8; 256]) -> RowCounts {
        count_plain(words, triangles)
    }

    /// All 64 cases of a word at once, looked up in a table of four registers.
    #[target_feature(
        enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi,avx512vpopcntdq"
    )]
    pub(super) fn count_avx512(words: &[Word], triangles: &[u8; 256]) -> RowCounts {
        let (table, _) = triangles.as_chunks::<64>();
        // SAFETY: each of the four chunks is 64 bytes; the load needs no alignment.
        let part = |n: usize| unsafe { _mm512_loadu_epi8(table[n].as_ptr().cast()) };
        let table = [part(0), part(1), part(2), part(3)];
        let (mut counts, mut sum) = (RowCounts::default(), _mm512_setzero_si512());
        for word in words {
            counts.add_edges(word);
            let cases = cases(word);
            // The lower half of the table for cases below 128, the upper for the others.
            let low = _mm512_permutex2var_epi8(table[0], cases, table[1]);
            let high = _mm512_permutex2var_epi8(table[2], cases, table[3]);
            let found = _mm512_mask_blend_epi8(_mm512_movepi8_mask(cases), low, high);
            let found = _mm512_maskz_mov_epi8(word.active, found);
            sum = _mm512_add_epi64(sum, _mm512_sad_epu8(found, _mm512_setzero_si512()));
        }
        counts.triangles += _mm512_reduce_add_epi64(sum) as u32;
        counts
    }

    #[target_feature(enable = "avx512f,avx512bw")]
    fn cases(word: &Word) -> __m512i {
        let mut cases = _mm512_setzero_si512();
        for (k, &corner) in word.corners.iter().enumerate() {
            let bit = _mm512_maskz_set1_epi8(corner, (1_u8 << k) as i8);
            cases = _mm512_or_si512(cases, bit);
        }
        cases
    }
}

#[cfg(test)]
mod tests {
    use super::{RowCounts, count_at};
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
        for points in 1..=200_usize {
            let mut row = || -> Vec<u64> {
                let mut row: Vec<u64> = (0..points.div_ceil(64)).map(|_| chance()).collect();
                if !points.is_multiple_of(64) {
                    row[points / 64] &= (1 << (points % 64)) - 1;
                }
                row
            };
            let rows = [row(), row(), row(), row()];
            words_of_row(rows.each_ref().map(Vec::as_slice), points, &mut words);
            let expected = by_definition(&words, &table);
            for &level in Level::available() {
                assert_eq!(count_at(level, &words, &table), expected, "{level}, {points} points");
            }
        }
    }

    fn by_definition(words: &[Word], table: &[u8; 256]) -> RowCounts {
        let mut counts = RowCounts::default();
        for (word, i) in words.iter().flat_map(|word| (0..64).map(move |i| (word, i))) {
            let bit = |mask: u64| (mask >> i & 1) as u32;
            counts.x += bit(word.x[0]);
            counts.y += bit(word.y[0]);
            counts.z += bit(word.z[0]);
            counts.triangles += bit(word.active) * u32::from(table[usize::from(word.case(i))]);
        }
        counts
    }
}
