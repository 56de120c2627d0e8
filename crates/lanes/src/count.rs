//! How many vertices and triangles rows make.

use crate::{BitRows, Level, WORD, Word, euler::triangles, word::open_words_of_rows_at};
use std::ops::Range;

#[cfg(target_arch = "x86_64")]
mod wide;

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

/// Counts what some rows make, each into its place in `out`.
///
/// # Panics
///
/// If there are no such rows, or `out` has not room for exactly those.
pub fn count_rows(bits: &BitRows<'_>, rows: Range<usize>, out: &mut [RowCounts]) {
    count_rows_at(Level::current(), bits, rows, out, None);
}

/// The same, and the words that hold an [open](Word::open) cell, row by row, into `open`: as
/// [`open_words_of_rows`](crate::open_words_of_rows) has them.
///
/// # Panics
///
/// As [`count_rows`].
pub fn count_rows_with_open(
    bits: &BitRows<'_>,
    rows: Range<usize>,
    out: &mut [RowCounts],
    open: &mut Vec<Word>,
) {
    count_rows_at(Level::current(), bits, rows, out, Some(open));
}

/// Counts only the vertices on edges along x and y of some rows; other counts are 0.
///
/// # Panics
///
/// As [`count_rows`].
pub fn count_flat_rows(bits: &BitRows<'_>, rows: Range<usize>, out: &mut [RowCounts]) {
    count_flat_rows_at(Level::current(), bits, rows, out);
}

fn count_flat_rows_at(level: Level, bits: &BitRows<'_>, rows: Range<usize>, out: &mut [RowCounts]) {
    begin(bits, &rows, out);
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { count_flat_rows_avx512(bits, rows, out) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { count_flat_rows_avx2(bits, rows, out) }
        }
        _ => count_rows_plain::<true>(bits, rows, out),
    }
}

/// Refuses what does not fit, and makes counts 0.
fn begin(bits: &BitRows<'_>, rows: &Range<usize>, out: &mut [RowCounts]) {
    assert!(rows.end <= bits.rows(), "rows {rows:?} of {}", bits.rows());
    assert_eq!(rows.len(), out.len(), "a count for each row");
    out.fill(RowCounts::default());
}

fn count_rows_at(
    level: Level,
    bits: &BitRows<'_>,
    rows: Range<usize>,
    out: &mut [RowCounts],
    open: Option<&mut Vec<Word>>,
) {
    begin(bits, &rows, out);
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { wide::count_rows_avx512(bits, rows, out, open) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { wide::count_rows_avx2(bits, rows, out, open) }
        }
        _ => {
            if let Some(open) = open {
                open_words_of_rows_at(level, bits, rows.clone(), open);
            }
            count_rows_plain::<false>(bits, rows, out);
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn count_flat_rows_avx2(bits: &BitRows<'_>, rows: Range<usize>, out: &mut [RowCounts]) {
    count_rows_plain::<true>(bits, rows, out);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(
    enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi2,avx512vpopcntdq"
)]
fn count_flat_rows_avx512(bits: &BitRows<'_>, rows: Range<usize>, out: &mut [RowCounts]) {
    count_rows_plain::<true>(bits, rows, out);
}

/// Words that are counted before they are added to their rows.
const BLOCK: usize = 512;

/// The loop of the lowest level, and of the flat counts of all, which the compiler makes as wide as it may.
#[inline(always)]
fn count_rows_plain<const FLAT: bool>(
    bits: &BitRows<'_>,
    rows: Range<usize>,
    out: &mut [RowCounts],
) {
    let words = bits.words();
    if words > BLOCK {
        let first = rows.start;
        return bits.each_word(rows, |word| {
            let counts = &mut out[word.row - first];
            counts.add(word);
            if FLAT {
                (counts.z, counts.triangles) = (0, 0);
            }
        });
    }
    let (mut cells, mut packed) = ([u64::MAX; BLOCK], [0; BLOCK]);
    let last = bits.cells(words - 1);
    cells.iter_mut().skip(words - 1).step_by(words).for_each(|cells| *cells = last);
    let (mut rows, mut out) = (rows, out);
    while !rows.is_empty() {
        // The last row of all has no cells, and goes alone.
        let inner = rows.end.min(bits.rows() - 1).saturating_sub(rows.start);
        let block = inner.clamp(1, BLOCK / words);
        let packed = &mut packed[..block * words];
        let around = bits.flat(rows.start..rows.start + block);
        let has_cells = bits.has_cells(rows.start);
        let looked_at = if FLAT { &around[..2] } else { &around };
        let (of_block, rest) = out.split_at_mut(block);
        (out, rows.start) = (rest, rows.start + block);
        if are_alike(looked_at) {
            continue;
        }
        count_block::<FLAT>(around, &cells, packed);
        let mask = if has_cells { u64::MAX } else { u64::MAX >> 16 };
        for (row, packed) in of_block.iter_mut().zip(packed.chunks_exact(words)) {
            // So many words fill no 16 bits.
            for packed in packed.chunks(128) {
                row.unpack(packed.iter().map(|word| word & mask).sum());
            }
        }
    }
}

/// Whether all points of some rows are inside, or none: nothing is to be counted there.
#[inline(always)]
fn are_alike(rows: &[&[u64]]) -> bool {
    let first = rows[0][0];
    let unlike = |row: &[u64]| row.iter().fold(0, |any, word| any | (word ^ first));
    matches!(first, 0 | u64::MAX) && rows.iter().all(|row| unlike(row) == 0)
}

/// Counts the words of rows that lie one behind another: for each a number of four times 16 bits.
#[inline(always)]
fn count_block<const FLAT: bool>(rows: [&[u64]; 4], cells: &[u64; BLOCK], packed: &mut [u64]) {
    let last = packed.len() - 1;
    let [a, b, c, d] = rows.map(|row| &row[..=last]);
    let [a_next, b_next, c_next, d_next] = rows.map(|row| &row[1..=last]);
    let cells = &cells[..=last];
    for i in 0..last {
        let next = [a_next[i], b_next[i], c_next[i], d_next[i]];
        packed[i] = count_word::<FLAT>([a[i], b[i], c[i], d[i]], next, cells[i]);
    }
    // The last word ends a row: what follows is not asked.
    packed[last] = count_word::<FLAT>([a[last], b[last], c[last], d[last]], [0; 4], cells[last]);
}

#[inline(always)]
fn count_word<const FLAT: bool>(words: [u64; 4], next: [u64; 4], cells: u64) -> u64 {
    let high = |n: usize| words[n] >> 1 | next[n] << (WORD - 1);
    if FLAT {
        let x = u64::from(((words[0] ^ high(0)) & cells).count_ones());
        return x | u64::from((words[0] ^ words[1]).count_ones()) << 16;
    }
    count_corners(words, [high(0), high(1), high(2), high(3)], cells)
}

/// Counts 64 cells of which the corners at low and high x are given.
#[inline(always)]
fn count_corners(words: [u64; 4], high: [u64; 4], cells: u64) -> u64 {
    let corners = [0, 1, 2, 3].map(|n| [words[n], high[n]]);
    let x = u64::from(((corners[0][0] ^ corners[0][1]) & cells).count_ones());
    let y = u64::from((words[0] ^ words[1]).count_ones());
    let z = u64::from((words[0] ^ words[2]).count_ones());
    let digits = triangles(corners).map(|bits| u64::from((bits & cells).count_ones()));
    x | y << 16 | z << 32 | (digits[0] + 2 * digits[1] + 4 * digits[2]) << 48
}

/// Counts words that were picked out before, each into the place of its row in `out`.
///
/// # Panics
///
/// If a word's row has no place.
pub fn count_words(words: &[Word], out: &mut [RowCounts]) {
    words.iter().for_each(|word| out[word.row].add(word));
}

impl RowCounts {
    fn unpack(&mut self, packed: u64) {
        let part = |n: usize| packed >> (16 * n) & 0xFFFF;
        self.x += part(0) as u32;
        self.y += part(1) as u32;
        self.z += part(2) as u32;
        self.triangles += part(3) as u32;
    }

    #[inline(always)]
    fn add(&mut self, word: &Word) {
        let [x, y, z] = word.owned();
        self.x += x.count_ones();
        self.y += y.count_ones();
        self.z += z.count_ones();
        let corner = |k: usize| word.corners[k];
        let digits = triangles([0, 2, 4, 6].map(|k| [corner(k), corner(k + 1)]));
        let [ones, twos, fours] = digits.map(|bits| (bits & word.active).count_ones());
        self.triangles += ones + 2 * twos + 4 * fours;
    }
}

#[cfg(test)]
mod tests {
    use super::{RowCounts, count_flat_rows_at, count_rows_at, count_words};
    use crate::{BitRows, Level, Word, euler::by_loops, words_of_rows};
    use std::array;

    #[test]
    fn every_level_agrees_with_the_definition() {
        let mut state = 5_u64;
        let mut chance = || {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
            state ^ state >> 31
        };
        let table = array::from_fn(by_loops);
        let mut words = vec![];
        for points in (1..=200_usize).chain([511, 512, 513, 600, 1100, 9000, 33000, 70_000, 70_001])
        {
            for kind in 0..4 {
                let rows = 1 + chance() as usize % 7;
                let mut slice = || -> Vec<u64> {
                    let per_row = points.div_ceil(64);
                    let mut word = |n: usize| {
                        let word = match kind {
                            1 if chance() % 4 > 0 => 0,
                            2 if chance() % 4 > 0 => u64::MAX,
                            // Nothing but ones, or zeros, or one odd word somewhere.
                            3 if chance() % 64 > 0 => u64::MAX * (points % 2) as u64,
                            _ => chance(),
                        };
                        let is_cut = n % per_row == per_row - 1 && !points.is_multiple_of(64);
                        if is_cut { word & ((1 << (points % 64)) - 1) } else { word }
                    };
                    (0..per_row * rows).map(&mut word).collect()
                };
                let (low, high) = (slice(), slice());
                let next = (points % 5 > 0).then_some(&high[..]);
                let bits = BitRows::new(&low, next, points);
                let own = rows / 4..rows - points % 3 * rows / 5;
                words_of_rows(&bits, own.clone(), &mut words);
                let mut expected = vec![RowCounts::default(); own.len()];
                words.iter().for_each(|w| define(w, &table, &mut expected[w.row - own.start]));
                words.retain(|word| word.open() != 0);
                words.iter_mut().for_each(|word| (word.cuts, word.active) = ([0; 8], word.open()));
                let mut open = vec![];
                for &level in Level::available() {
                    let mut found = vec![RowCounts { x: 7, ..RowCounts::default() }; own.len()];
                    count_rows_at(level, &bits, own.clone(), &mut found, None);
                    assert_eq!(found, expected, "{level}, {points} points");
                    count_rows_at(level, &bits, own.clone(), &mut found, Some(&mut open));
                    assert_eq!((&found, &open), (&expected, &words), "{level}, {points} points");
                    count_flat_rows_at(level, &bits, own.clone(), &mut found);
                    let flat = expected.iter().map(|row| RowCounts { z: 0, triangles: 0, ..*row });
                    assert!(flat.eq(found.iter().copied()), "flat, {level}, {points} points");
                }
                words_of_rows(&bits, own.clone(), &mut words);
                let mut found = vec![RowCounts::default(); rows];
                count_words(&words, &mut found);
                assert_eq!(found[own.clone()], expected, "{points} points");
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
