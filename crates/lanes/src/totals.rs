//! How many vertices and triangles a slice adds to those below it, where nobody asks which row makes them.
//!
//! A cell has as many triangles as `euler.rs` says: corners − 2 · faces + 4 · cell, of what is inside completely,
//! and four fewer where there is a hole. Take a cell with its four edges along x. Corners less twice the edges
//! that are inside are the cut edges; each edge is in two pairs, so twice the edges less twice the faces that join
//! them are the pairs of which just one is inside; and so of the faces across x and the cell. So a cell has
//!
//! > cut edges along x + pairs of neighbouring edges along x of which one is inside
//! > − 2 (one of the faces across x is inside) − 4 holes
//!
//! triangles. In a sum over cells neighbours share most of that, so no cell is looked at by itself.

use crate::{Level, euler::Bits};

mod side_by_side;
#[cfg(target_arch = "x86_64")]
mod wide;

/// What a slice adds to those below it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layer {
    /// On cut edges along x and y of the slice, and along z to the one below.
    pub vertices: u64,
    /// In the cells below.
    pub triangles: u64,
    /// What the slice by itself adds to the triangles of the cells below it, and of those above.
    share: u64,
}

/// How slices lie in memory: row by row, and then one word more, whose bits mean nothing. Bits beyond a row's
/// last point are 0.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// Words in a row.
    pub words: usize,
    /// For every word of a slice, without the one more, a bit for each point of a row but the last.
    pub cells: &'a [u64],
}

/// Numbers of bits in a slice.
#[derive(Clone, Copy, Debug, Default)]
struct InSlice {
    /// Cut edges along x of all rows, and those of the first and the last.
    cut: u64,
    cut_of_ends: u64,
    /// Cut edges along y.
    along_y: u64,
    /// Neighbouring edges along x of which one is inside.
    pairs: u64,
}

/// Numbers of bits in two slices and between them.
#[derive(Clone, Copy, Debug, Default)]
struct InCells {
    /// Cut edges along z.
    along_z: u64,
    /// Edges along x, one above another, of which one is inside: of all rows, and of the first and the last.
    pairs: u64,
    pairs_of_ends: u64,
    /// Cells of which just one of both faces across x is inside.
    faces: u64,
    /// Cells of which just two corners are outside, opposite ones.
    holes: u64,
}

/// A function with the instructions of a level, or the one that is made for the level.
macro_rules! at_level {
    ($level:expr, $plain:ident $avx2:ident $avx512:ident, $arguments:tt) => {
        match $level {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => {
                $level.assert_available();
                // SAFETY: the machine has the level, asserted above; the function asks nothing else.
                unsafe { $avx512 $arguments }
            }
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => {
                $level.assert_available();
                // SAFETY: as above.
                unsafe { wide::$avx2 $arguments }
            }
            _ => $plain $arguments,
        }
    };
}

impl InSlice {
    /// What the slice adds if there is none below.
    fn layer(self) -> Layer {
        // Each row of cells has the edges of two rows.
        let share = 2 * self.cut - self.cut_of_ends + self.pairs;
        Layer { vertices: self.cut + self.along_y, triangles: 0, share }
    }
}

impl Rows<'_> {
    /// What the lowest slice of all adds.
    ///
    /// # Panics
    ///
    /// If it has no rows, they have no words or not all the same number, or it is not of this size.
    pub fn lowest(&self, slice: &[u64]) -> Layer {
        self.lowest_at(Level::current(), slice)
    }

    /// What a slice adds that is above another, of which that is known.
    ///
    /// # Panics
    ///
    /// As [`lowest`](Self::lowest).
    pub fn above(&self, low: (&[u64], Layer), slice: &[u64]) -> Layer {
        self.above_at(Level::current(), low, slice)
    }

    fn lowest_at(&self, level: Level, slice: &[u64]) -> Layer {
        self.check([slice]);
        at_level!(level, in_slice in_slice_avx2 in_slice_avx512, (self, slice)).layer()
    }

    fn above_at(&self, level: Level, low: (&[u64], Layer), slice: &[u64]) -> Layer {
        let slices = [low.0, slice];
        self.check(slices);
        let sums = at_level!(level, in_layer in_layer_avx2 in_layer_avx512, (self, slices));
        Self::layer(low.1, sums)
    }

    /// What a slice adds, by what is in it and between it and the one below, which added that.
    fn layer(low: Layer, sums: (InSlice, InCells)) -> Layer {
        // Of these `along_y + along_z` and `pairs − faces` are right at any level, and those four as they are named
        // at some.
        let (high, InCells { along_z, pairs, pairs_of_ends, faces, holes }) = sums;
        let Layer { vertices, share, .. } = high.layer();
        let shares = low.share + share + 2 * pairs - pairs_of_ends;
        let triangles = shares - 2 * faces - 4 * holes;
        Layer { vertices: vertices + along_z, triangles, share }
    }

    fn check<const N: usize>(&self, slices: [&[u64]; N]) {
        self.check_sizes(slices.map(<[u64]>::len));
    }

    fn check_sizes<const N: usize>(&self, slices: [usize; N]) {
        let Self { words, cells } = *self;
        assert!(words > 0 && !cells.is_empty(), "a slice has rows");
        assert!(cells.len().is_multiple_of(words), "all rows have as many words");
        slices.iter().for_each(|slice| assert_eq!(*slice, cells.len() + 1, "one word more"));
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(
    enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi2,avx512vpopcntdq"
)]
fn in_slice_avx512(rows: &Rows<'_>, slice: &[u64]) -> InSlice {
    in_slice(rows, slice)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(
    enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi2,avx512vpopcntdq"
)]
fn in_layer_avx512(rows: &Rows<'_>, slices: [&[u64]; 2]) -> (InSlice, InCells) {
    in_layer(rows, slices)
}

/// By plain loops, which the compiler makes as wide as it may.
#[inline(always)]
fn in_slice(&Rows { words, cells }: &Rows<'_>, slice: &[u64]) -> InSlice {
    let last = cells.len() - words;
    let inner = in_lines([slice, &slice[words..]], &cells[..last]);
    // Rows that stand alone have themselves as the next.
    let end = in_lines([&slice[last..]; 2], &cells[last..]);
    let first = in_lines([slice; 2], &cells[..words]);
    InSlice { cut: inner.cut + end.cut, cut_of_ends: first.cut + end.cut, ..inner }
}

/// The higher slice by itself, and then both.
#[inline(always)]
fn in_layer(rows: &Rows<'_>, slices: [&[u64]; 2]) -> (InSlice, InCells) {
    (in_slice(rows, slices[1]), in_cells(rows, slices))
}

/// By plain loops.
#[inline(always)]
fn in_cells(&Rows { words, cells }: &Rows<'_>, [low, high]: [&[u64]; 2]) -> InCells {
    let last = cells.len() - words;
    let inner = in_walls([low, &low[words..], high, &high[words..]], &cells[..last]);
    let [low_end, high_end] = [&low[last..], &high[last..]];
    let end = in_walls([low_end, low_end, high_end, high_end], &cells[last..]);
    let first = in_walls([low, low, high, high], &cells[..words]);
    InCells {
        along_z: inner.along_z + end.along_z,
        pairs: inner.pairs + end.pairs,
        pairs_of_ends: first.pairs + end.pairs,
        ..inner
    }
}

/// What rows have with those beside them, at y = 0, 1. A row has one word more than there are words of cells.
/// There are no closures: those are not always inlined, and then every index is checked.
#[inline(always)]
fn in_lines([a, b]: [&[u64]; 2], cells: &[u64]) -> InSlice {
    let (n, mut sums) = (cells.len(), InSlice::default());
    let (a, a1, b, b1) = (&a[..n], &a[1..=n], &b[..n], &b[1..=n]);
    for i in 0..n {
        let line = Line::new(along_x(a[i], a1[i]), cells[i]);
        let [y, pairs] = line.beside(&Line::new(along_x(b[i], b1[i]), cells[i]));
        sums.cut += u64::from(line.cut.count_ones());
        sums.along_y += u64::from(y.count_ones());
        sums.pairs += u64::from(pairs.count_ones());
    }
    sums
}

/// The same of two slices, at y, z = 00, 10, 01, 11.
#[inline(always)]
fn in_walls([a, b, c, d]: [&[u64]; 4], cells: &[u64]) -> InCells {
    let (n, mut sums) = (cells.len(), InCells::default());
    let (a, a1, b, b1) = (&a[..n], &a[1..=n], &b[..n], &b[1..=n]);
    let (c, c1, d, d1) = (&c[..n], &c[1..=n], &d[..n], &d[1..=n]);
    for i in 0..n {
        let (a, b) = (along_x(a[i], a1[i]), along_x(b[i], b1[i]));
        let (c, d) = (along_x(c[i], c1[i]), along_x(d[i], d1[i]));
        let (wall, [z, pairs]) = Wall::new(a, c, cells[i]);
        let (next, _) = Wall::new(b, d, cells[i]);
        let holes = wall.holes(&next, [a[0] ^ d[0], b[0] ^ c[0]]);
        sums.along_z += u64::from(z.count_ones());
        sums.pairs += u64::from(pairs.count_ones());
        sums.faces += u64::from(wall.faces(&next, cells[i]).count_ones());
        sums.holes += u64::from(holes.count_ones());
    }
    sums
}

/// A word of a row, which another follows, and the same of the points that follow along x.
#[inline(always)]
fn along_x(word: u64, next: u64) -> [u64; 2] {
    [word, word >> 1 | next << 63]
}

/// A row of points.
#[derive(Clone, Copy)]
struct Line {
    points: u64,
    /// Edges along x that are cut, and that are inside.
    cut: u64,
    edges: u64,
}

impl Line {
    /// Given are the points at low and high x.
    #[inline(always)]
    fn new([points, high]: [u64; 2], cells: u64) -> Self {
        Self { points, cut: (points ^ high) & cells, edges: points & high & cells }
    }

    /// Cut edges along y to the row beside it, and neighbouring edges along x of which one is inside.
    #[inline(always)]
    fn beside(&self, next: &Self) -> [u64; 2] {
        [self.points ^ next.points, self.edges ^ next.edges]
    }
}

/// A row of a slice and the one above it.
#[derive(Clone, Copy)]
struct Wall<B> {
    /// Edges along x that are cut, or lead on behind the last point, in the lower slice and in the higher one.
    cut: [B; 2],
    /// And those that are inside.
    edges: [B; 2],
    /// Edges along z that are inside, at low and high x.
    upright: [B; 2],
}

impl<B: Bits> Wall<B> {
    /// Given are the points of both slices at low and high x. With it come its cut edges along z, and edges along
    /// x, one above another, of which one is inside.
    #[inline(always)]
    fn new([a, a1]: [B; 2], [c, c1]: [B; 2], cells: B) -> (Self, [B; 2]) {
        let edges = [a & a1 & cells, c & c1 & cells];
        let wall = Self { cut: [a ^ a1, c ^ c1], edges, upright: [a & c, a1 & c1] };
        (wall, [a ^ c, edges[0] ^ edges[1]])
    }

    /// Of the cells to the wall beside it, those of which just one face across x is inside.
    #[inline(always)]
    fn faces(&self, next: &Self, cells: B) -> B {
        ((self.upright[0] & next.upright[0]) ^ (self.upright[1] & next.upright[1])) & cells
    }

    /// Of the cells to the wall beside it, those of which just two corners are outside, opposite ones: two opposite
    /// edges along x are inside, and the other two are cut. Given is which points at low x differ from the
    /// opposite ones.
    #[inline(always)]
    fn holes(&self, next: &Self, differ: [B; 2]) -> B {
        let one = self.cut[0] & next.cut[1] & next.edges[0] & self.edges[1];
        let other = next.cut[0] & self.cut[1] & self.edges[0] & next.edges[1];
        one & differ[0] | other & differ[1]
    }
}

#[cfg(test)]
mod tests {
    use super::{Layer, Rows};
    use crate::{BitRows, Level, RowCounts, count_rows};

    #[test]
    fn every_level_agrees_with_the_counts_of_rows() {
        let mut state = 11_u64;
        let mut chance = || {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
            state ^ state >> 29
        };
        for points in (1..=140_usize).chain([192, 256, 300, 321, 384, 448, 511, 512, 513, 700]) {
            let words = points.div_ceil(64);
            let rows = [1, 2, 3, 8, 70, 127];
            let kinds = |rows| [[points % 3, (points + rows) % 5 % 3], [2, 3], [4, 5]];
            for (rows, kinds) in rows.into_iter().flat_map(|n| kinds(n).map(|kinds| (n, kinds))) {
                let mut slice = |kind: usize| -> Vec<u64> {
                    let mut word = |n: usize| {
                        let word = match kind {
                            0 => chance(),
                            1 => chance() | chance() | chance(),
                            // Every edge along y is cut, and along z between these two.
                            2 => (n / words % 2) as u64 * u64::MAX,
                            3 => ((n / words + 1) % 2) as u64 * u64::MAX,
                            kind => (kind - 4) as u64 * u64::MAX,
                        };
                        let is_cut = n % words == words - 1 && !points.is_multiple_of(64);
                        if is_cut { word & ((1 << (points % 64)) - 1) } else { word }
                    };
                    (0..words * rows).map(&mut word).collect()
                };
                let slices = kinds.map(&mut slice);
                let count = |low: &[u64], high: Option<&[u64]>| {
                    let mut counts = vec![RowCounts::default(); rows];
                    count_rows(&BitRows::new(low, high, points), 0..rows, &mut counts);
                    let sum = |part: fn(&RowCounts) -> u32| {
                        counts.iter().map(part).map(u64::from).sum::<u64>()
                    };
                    [sum(|row| row.x + row.y), sum(|row| row.z), sum(|row| row.triangles)]
                };
                let cells: Vec<u64> = (0..words * rows)
                    .map(|n| match n % words == words - 1 {
                        true => (1 << ((points - 1) % 64)) - 1,
                        false => u64::MAX,
                    })
                    .collect();
                let [first, second] = &slices;
                let [expected, high] = [count(first, Some(second)), count(second, None)];
                // The one word more may be anything.
                let more = |slice: &[u64], word| [slice, &[word]].concat();
                let low = more(&slices[0], 0x5A5A_0F0F_3333_9999);
                let upper = more(&slices[1], 0x1234_5678_9ABC_DEF0);
                let all = Rows { words, cells: &cells };
                for &level in Level::available() {
                    let [lowest, alone] = [&low, &upper].map(|slice| all.lowest_at(level, slice));
                    let above = all.above_at(level, (&low, lowest), &upper);
                    let found = [lowest.vertices, above.vertices - alone.vertices, above.triangles];
                    assert_eq!(found, expected, "{level}, {points} points, {rows} rows");
                    let found = [alone.vertices, alone.triangles, above.share];
                    let expected = [high[0], 0, alone.share];
                    assert_eq!(found, expected, "{level}, {points} points, {rows} rows");
                }
            }
        }
    }

    /// A slice of `given` words, of rows of `words`, of which there are `cells` in all.
    fn count(words: usize, cells: usize, given: usize) {
        let (cells, slice) = (vec![1; cells], vec![0; given]);
        let rows = Rows { words, cells: &cells };
        rows.above((&slice, Layer::default()), &slice);
    }

    #[test]
    #[should_panic(expected = "one word more")]
    fn a_slice_that_is_too_short_is_refused() {
        count(4, 8, 8);
    }

    #[test]
    #[should_panic(expected = "a slice has rows")]
    fn a_slice_without_rows_is_refused() {
        count(4, 0, 1);
    }

    #[test]
    #[should_panic(expected = "a slice has rows")]
    fn rows_without_words_are_refused() {
        count(0, 4, 5);
    }

    #[test]
    #[should_panic(expected = "all rows have as many words")]
    fn a_row_that_is_shorter_than_others_is_refused() {
        count(4, 7, 8);
    }
}
