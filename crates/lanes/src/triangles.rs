//! From the cases of a row of cells to triangles.
//!
//! The twelve edges of a cell belong to eight lists of numbered vertices: the x edges of its four rows,
//! the y edges of its two slices, the z edges of its two rows. In each list the vertex of an edge has the
//! list's first number plus the set bits before it. An x edge is the cell's own bit; of the y and z
//! edges the cell has two neighbours in the list, the first at its own bit, the second one further on if
//! the first is cut, else at the same number.

use crate::{Level, Word};

/// The triangles of the 256 cases, as edges of a cell.
#[derive(Debug)]
pub struct CaseTable {
    /// Triangles of each case; at most five.
    pub counts: [u8; 256],
    /// Three edges, below 12, for each triangle in turn; the rest is 0.
    pub edges: [[u8; 16]; 256],
}

/// The number of the first vertex in each of the eight lists that a row of cells takes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FirstVertices {
    /// On edges along x of the rows at (y, z) = 00, 10, 01, 11.
    pub x: [u32; 4],
    /// On edges along y at z = 0, 1.
    pub y: [u32; 2],
    /// On edges along z at y = 0, 1.
    pub z: [u32; 2],
}

/// Writes the triangles of rows of cells to the front of `out`, and gives how many there are.
///
/// `words` are all that hold a cut in these rows, as [`words_of_rows`](crate::words_of_rows) gives them.
/// `first` is asked for the first vertices of each row of theirs once.
///
/// # Panics
///
/// If `out` has not room for them all.
pub fn triangles(
    words: &[Word],
    first: impl FnMut(usize) -> FirstVertices,
    table: &CaseTable,
    out: &mut [[u32; 3]],
) -> usize {
    triangles_at(Level::current(), words, first, table, out)
}

fn triangles_at(
    level: Level,
    words: &[Word],
    first: impl FnMut(usize) -> FirstVertices,
    table: &CaseTable,
    out: &mut [[u32; 3]],
) -> usize {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { wide::triangles_avx512(words, first, table, out) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { wide::triangles_avx2(words, first, table, out) }
        }
        _ => triangles_plain(words, first, table, out),
    }
}

#[inline(always)]
fn triangles_plain(
    words: &[Word],
    mut first: impl FnMut(usize) -> FirstVertices,
    table: &CaseTable,
    out: &mut [[u32; 3]],
) -> usize {
    let (mut next, mut row) = (FirstVertices::default(), None);
    let mut filled = 0;
    for word in words {
        if row != Some(word.row) {
            (next, row) = (first(word.row), Some(word.row));
        }
        let mut active = word.active;
        while active != 0 {
            let cell = active.trailing_zeros();
            active &= active - 1;
            let ids = next.ids_plain(word, cell);
            let case = usize::from(word.case(cell));
            let end = filled + usize::from(table.counts[case]);
            let edges = table.edges[case].as_chunks::<3>().0;
            for (triangle, edges) in out[filled..end].iter_mut().zip(edges) {
                *triangle = edges.map(|e| ids[usize::from(e) % 16]);
            }
            filled = end;
        }
        next.pass_plain(word);
    }
    filled
}

impl FirstVertices {
    /// The vertices on the twelve edges of a cell, and four zeros. An edge that is not cut has a number
    /// of no meaning.
    pub fn ids(&self, word: &Word, cell: u32) -> [u32; 16] {
        #[cfg(target_arch = "x86_64")]
        if Level::current() > Level::Portable {
            Level::Avx2.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            return unsafe { wide::ids(self, word, cell) };
        }
        self.ids_plain(word, cell)
    }

    #[inline(always)]
    fn ids_plain(&self, word: &Word, cell: u32) -> [u32; 16] {
        let before = (1_u64 << cell) - 1;
        let at = |first: u32, cuts: u64| first.wrapping_add((cuts & before).count_ones());
        let pair = |first: u32, cuts: u64| {
            let low = at(first, cuts);
            [low, low.wrapping_add((cuts >> cell & 1) as u32)]
        };
        let cuts = &word.cuts;
        let [x0, x1, x2, x3]: [u32; 4] = std::array::from_fn(|n| at(self.x[n], cuts[n]));
        let [[y0, y1], [y2, y3]]: [_; 2] = std::array::from_fn(|n| pair(self.y[n], cuts[4 + n]));
        let [[z0, z1], [z2, z3]]: [_; 2] = std::array::from_fn(|n| pair(self.z[n], cuts[6 + n]));
        [x0, x1, x2, x3, y0, y1, y2, y3, z0, z1, z2, z3, 0, 0, 0, 0]
    }

    /// Leaves a word behind: from now on the numbers are those of the first vertices after it.
    pub fn pass(&mut self, word: &Word) {
        #[cfg(target_arch = "x86_64")]
        if Level::current() > Level::Portable {
            Level::Avx2.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            return unsafe { wide::pass(self, word) };
        }
        self.pass_plain(word);
    }

    #[inline(always)]
    fn pass_plain(&mut self, word: &Word) {
        let advance = |next: &mut [u32], cuts: &[u64]| {
            for (next, cuts) in next.iter_mut().zip(cuts) {
                *next = next.wrapping_add(cuts.count_ones());
            }
        };
        advance(&mut self.x, &word.cuts[..4]);
        advance(&mut self.y, &word.cuts[4..6]);
        advance(&mut self.z, &word.cuts[6..]);
    }
}

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::{CaseTable, FirstVertices, Word, triangles_plain};
    use std::arch::x86_64::*;

    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn triangles_avx2(
        words: &[Word],
        first: impl FnMut(usize) -> FirstVertices,
        table: &CaseTable,
        out: &mut [[u32; 3]],
    ) -> usize {
        triangles_plain(words, first, table, out)
    }

    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn ids(first: &FirstVertices, word: &Word, cell: u32) -> [u32; 16] {
        first.ids_plain(word, cell)
    }

    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn pass(next: &mut FirstVertices, word: &Word) {
        next.pass_plain(word);
    }

    /// The eight lists are the lanes of one register: a population count gives all eight numbers of a
    /// cell, a bit test its case, a permutation by the table its triangles, one store writes them.
    #[target_feature(
        enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl,avx512vpopcntdq"
    )]
    pub(super) fn triangles_avx512(
        words: &[Word],
        mut first: impl FnMut(usize) -> FirstVertices,
        table: &CaseTable,
        out: &mut [[u32; 3]],
    ) -> usize {
        let (mut next, mut row) = (_mm512_setzero_si512(), None);
        // From (x0…x3 y0 y2 z0 z2 | the same, one further on if cut) to the order of a cell's edges.
        let order = _mm512_setr_epi32(0, 1, 2, 3, 4, 12, 5, 13, 6, 14, 7, 15, 0, 0, 0, 0);
        let out = out.as_flattened_mut();
        let mut filled = 0;
        for word in words {
            if row != Some(word.row) {
                let FirstVertices { x: [a, b, c, d], y: [e, f], z: [g, h] } = first(word.row);
                let lists = [a, b, c, d, e, f, g, h].map(i64::from);
                // SAFETY: eight 64-bit numbers fill the register; the load needs no alignment.
                next = unsafe { _mm512_loadu_epi64(lists.as_ptr()) };
                row = Some(word.row);
            }
            // SAFETY: both are eight 64-bit numbers.
            let (cuts, corners) = unsafe {
                (
                    _mm512_loadu_epi64(word.cuts.as_ptr().cast()),
                    _mm512_loadu_epi64(word.corners.as_ptr().cast()),
                )
            };
            let mut active = word.active;
            while active != 0 {
                let cell = active.trailing_zeros();
                let bit = active & active.wrapping_neg();
                active ^= bit;
                let own = _mm512_set1_epi64(bit as i64);
                let before = _mm512_and_si512(cuts, _mm512_set1_epi64((bit - 1) as i64));
                let low = _mm512_add_epi64(next, _mm512_popcnt_epi64(before));
                let cut =
                    _mm512_srl_epi64(_mm512_and_si512(cuts, own), _mm_cvtsi64_si128(cell.into()));
                let high = _mm512_add_epi64(low, cut);
                let ids = _mm512_inserti64x4::<1>(
                    _mm512_castsi256_si512(_mm512_cvtepi64_epi32(low)),
                    _mm512_cvtepi64_epi32(high),
                );
                let ids = _mm512_permutexvar_epi32(order, ids);
                let case = usize::from(_mm512_test_epi64_mask(corners, own));
                // SAFETY: a row of the table is 16 bytes.
                let edges = unsafe { _mm_loadu_si128(table.edges[case].as_ptr().cast()) };
                let corners_of_all = _mm512_permutexvar_epi32(_mm512_cvtepu8_epi32(edges), ids);
                let count = 3 * usize::from(table.counts[case]);
                if let Some(room) = out[filled..].first_chunk_mut::<16>() {
                    // What is written too much is overwritten by the next cell, or masked below.
                    // SAFETY: there is room for 16 numbers.
                    unsafe { _mm512_storeu_epi32(room.as_mut_ptr().cast(), corners_of_all) };
                } else {
                    let room = &mut out[filled..filled + count];
                    let mask = ((1_u32 << count) - 1) as u16;
                    // SAFETY: the mask lets through `count` numbers, for which there is room.
                    unsafe {
                        _mm512_mask_storeu_epi32(room.as_mut_ptr().cast(), mask, corners_of_all);
                    }
                }
                filled += count;
            }
            next = _mm512_add_epi64(next, _mm512_popcnt_epi64(cuts));
        }
        filled / 3
    }
}

#[cfg(test)]
mod tests {
    use super::{CaseTable, FirstVertices, triangles_at};
    use crate::{BitRows, Level, words_of_rows};
    use std::collections::BTreeMap;

    struct Chance(u64);

    impl Chance {
        fn next(&mut self) -> u64 {
            self.0 = self.0.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
            self.0 ^ self.0 >> 31
        }

        /// A table that uses the cut edges of each case in any order.
        fn table(&mut self) -> CaseTable {
            let mut table = CaseTable { counts: [0; 256], edges: [[0; 16]; 256] };
            for case in 1..255_usize {
                let inside = |k: usize| case >> k & 1 == 1;
                let cut = |e: usize| {
                    let (t, n) = (e / 4, e % 4);
                    let [u, v] = [[1, 2], [0, 2], [0, 1]][t];
                    let low = (n & 1) << u | (n >> 1) << v;
                    inside(low) != inside(low | 1 << t)
                };
                let cut: Vec<u8> = (0..12).filter(|&e| cut(e)).map(|e| e as u8).collect();
                table.counts[case] = 1 + (self.next() % 5) as u8;
                for edge in &mut table.edges[case][..3 * usize::from(table.counts[case])] {
                    *edge = cut[self.next() as usize % cut.len()];
                }
            }
            table
        }

        fn row(&mut self, points: usize) -> Vec<u64> {
            let mut row: Vec<u64> = (0..points.div_ceil(64)).map(|_| self.next()).collect();
            if !points.is_multiple_of(64) {
                row[points / 64] &= (1 << (points % 64)) - 1;
            }
            row
        }
    }

    #[test]
    fn every_level_agrees_with_the_definition_and_writes_nothing_else() {
        let mut chance = Chance(3);
        let table = chance.table();
        let mut words = vec![];
        for points in 2..=200_usize {
            let [low, high] = [(); 2].map(|()| [(); 4].map(|()| chance.row(points)));
            let flat = [low.concat(), high.concat()];
            let bits = BitRows::new(&flat[0], Some(&flat[1]), points);
            words_of_rows(&bits, 0..4, &mut words);
            let first = |row: usize| {
                let n = 100_000 * row as u32;
                FirstVertices {
                    x: [5, 1000, 2000, 3000].map(|x| n + x),
                    y: [n + 4000, n + 5000],
                    z: [n + 6000, n + 7000],
                }
            };
            // No cell starts in the last row.
            let expected: Vec<_> = (0..3)
                .flat_map(|y| {
                    let rows = [&low[y][..], &low[y + 1], &high[y], &high[y + 1]];
                    by_definition(rows, points, first(y), &table)
                })
                .collect();
            for &level in Level::available() {
                let mut out = vec![[u32::MAX; 3]; expected.len() + 9];
                let (room, behind) = out.split_at_mut(expected.len());
                assert_eq!(triangles_at(level, &words, first, &table, room), expected.len());
                assert_eq!(room, expected, "{level}, {points} points");
                assert_eq!(behind, [[u32::MAX; 3]; 9]);
            }
        }
    }

    /// Cell by cell, with a map for the numbers.
    fn by_definition(
        rows: [&[u64]; 4],
        points: usize,
        first: FirstVertices,
        table: &CaseTable,
    ) -> Vec<[u32; 3]> {
        let inside = |k: usize, i: usize| {
            let i = i + (k & 1);
            rows[k >> 1][i / 64] >> (i % 64) & 1 == 1
        };
        let mut next = first;
        let mut numbers = BTreeMap::new();
        for i in 0..points {
            let mut number = |edge: usize, ends: [usize; 2], next: &mut u32| {
                if inside(ends[0], i) != inside(ends[1], i) {
                    numbers.insert((edge, i), *next);
                    *next += 1;
                }
            };
            if i + 1 < points {
                (0..4).for_each(|n| number(n, [2 * n, 2 * n + 1], &mut next.x[n]));
            }
            (0..2).for_each(|n| number(4 + 2 * n, [4 * n, 4 * n + 2], &mut next.y[n]));
            (0..2).for_each(|n| number(8 + 2 * n, [2 * n, 2 * n + 4], &mut next.z[n]));
        }
        let mut triangles = vec![];
        for i in 0..points - 1 {
            let case: usize = (0..8).map(|k| usize::from(inside(k, i)) << k).sum();
            let edges = table.edges[case].as_chunks::<3>().0;
            for edges in &edges[..usize::from(table.counts[case])] {
                // An odd edge along y or z is the even one of the next cell.
                let name = |e: usize| if e < 4 { (e, i) } else { (e & !1, i + (e & 1)) };
                triangles.push(edges.map(|e| numbers[&name(e.into())]));
            }
        }
        triangles
    }
}
