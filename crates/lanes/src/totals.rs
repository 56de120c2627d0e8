//! How many vertices and triangles there are between two slices, where nobody asks which row makes them.
//!
//! A cell has as many triangles as `euler.rs` says: corners − 2 · faces + 4 · cell, of what is inside completely,
//! and four fewer where there is a hole. In a sum over cells neighbours share most of that, so no cell is looked
//! at by itself: a slice gives its points and faces once, for the cells below and above it. And a cell that is
//! inside has both of its faces across x inside, which together take away what the cell adds.

use crate::Level;

/// What a slice has by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flat {
    /// On cut edges along x and y.
    pub vertices: u64,
    /// What it adds to the triangles of the cells above it, and of those below.
    share: u64,
}

/// What lies between two slices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Between {
    /// On cut edges along z.
    pub vertices: u64,
    /// In the cells.
    pub triangles: u64,
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

impl Rows<'_> {
    /// What a slice has by itself.
    ///
    /// # Panics
    ///
    /// If it has no rows, they have no words, or it is not of this size.
    pub fn flat(&self, slice: &[u64]) -> Flat {
        self.flat_at(Level::current(), slice)
    }

    /// What lies between two slices, of which is known what they have by themselves.
    ///
    /// # Panics
    ///
    /// As [`flat`](Self::flat).
    pub fn between(&self, low: (&[u64], Flat), high: (&[u64], Flat)) -> Between {
        self.between_at(Level::current(), low, high)
    }

    fn flat_at(&self, level: Level, slice: &[u64]) -> Flat {
        let [first, inner, last] = self.sums::<InSlice>(level, [slice; 2]);
        // Each row of cells has the points of two rows.
        let points = 2 * inner.points + last.points - first.points;
        Flat {
            vertices: inner.along_x + last.along_x + inner.along_y,
            share: points - 2 * inner.faces,
        }
    }

    fn between_at(&self, level: Level, low: (&[u64], Flat), high: (&[u64], Flat)) -> Between {
        let [first, inner, last] = self.sums::<InCells>(level, [low.0, high.0]);
        let across_y = 2 * inner.across_y + last.across_y - first.across_y;
        let taken = 2 * (across_y + inner.across_x) + 4 * inner.holes;
        Between {
            vertices: inner.along_z + last.along_z,
            triangles: low.1.share + high.1.share - taken,
        }
    }

    /// The sums of the first row, of all rows but the last, and of the last. Rows that stand alone have themselves
    /// as the next.
    fn sums<S: Sums>(&self, level: Level, slices: [&[u64]; 2]) -> [S; 3] {
        let Self { words, cells } = *self;
        let last = cells.len().checked_sub(words).expect("a slice has rows");
        slices.iter().for_each(|slice| assert_eq!(slice.len(), cells.len() + 1, "one word more"));
        let [low, high] = slices;
        let row = |at: usize| {
            let [low, high] = slices.map(|slice| &slice[at..=at + words]);
            S::at(level, [low, low, high, high], &cells[at..at + words])
        };
        let inner = [&low[..=last], &low[words..], &high[..=last], &high[words..]];
        [row(0), S::at(level, inner, &cells[..last]), row(last)]
    }
}

/// Numbers of bits in the words of four rows, at y, z = 00, 10, 01, 11. A row has one word more than there are
/// words of cells.
trait Sums: Sized {
    /// The one loop for all levels, which the compiler makes as wide as it may. It has no closures: those are not
    /// always inlined, and then it checks every index.
    fn of(rows: [&[u64]; 4], cells: &[u64]) -> Self;

    fn at(level: Level, rows: [&[u64]; 4], cells: &[u64]) -> Self {
        match level {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => {
                level.assert_available();
                // SAFETY: the machine has the level, asserted above; the function asks nothing else.
                unsafe { sums_avx512(rows, cells) }
            }
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => {
                level.assert_available();
                // SAFETY: as above.
                unsafe { sums_avx2(rows, cells) }
            }
            _ => Self::of(rows, cells),
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn sums_avx2<S: Sums>(rows: [&[u64]; 4], cells: &[u64]) -> S {
    S::of(rows, cells)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(
    enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi2,avx512vpopcntdq"
)]
fn sums_avx512<S: Sums>(rows: [&[u64]; 4], cells: &[u64]) -> S {
    S::of(rows, cells)
}

/// What one slice has.
#[derive(Clone, Copy, Debug, Default)]
struct InSlice {
    /// Cut edges.
    along_x: u64,
    along_y: u64,
    /// Corners of cells in the rows themselves, inside.
    points: u64,
    /// Faces of cells across z, inside.
    faces: u64,
}

impl Sums for InSlice {
    #[inline(always)]
    fn of([a, b, ..]: [&[u64]; 4], cells: &[u64]) -> Self {
        let (n, mut sums) = (cells.len(), Self::default());
        let (a, a1, b, b1) = (&a[..n], &a[1..=n], &b[..n], &b[1..=n]);
        for i in 0..n {
            let ([a, a1], [b, b1]) = (along_x(a[i], a1[i]), along_x(b[i], b1[i]));
            let cells = cells[i];
            let (differ, both) = ((a ^ a1) & cells, a & a1 & cells);
            let differing = u64::from(differ.count_ones());
            sums.along_x += differing;
            sums.along_y += u64::from((a ^ b).count_ones());
            sums.points += differing + 2 * u64::from(both.count_ones());
            sums.faces += u64::from((both & b & b1).count_ones());
        }
        sums
    }
}

/// What two slices and the cells between them have.
#[derive(Clone, Copy, Debug, Default)]
struct InCells {
    /// Cut edges.
    along_z: u64,
    /// Faces of cells in the rows themselves, inside.
    across_y: u64,
    /// Cells of which one of both faces across x is inside.
    across_x: u64,
    /// Cells of which just two corners are outside, opposite ones.
    holes: u64,
}

impl Sums for InCells {
    #[inline(always)]
    fn of([a, b, c, d]: [&[u64]; 4], cells: &[u64]) -> Self {
        let (n, mut sums) = (cells.len(), Self::default());
        let (a, a1, b, b1) = (&a[..n], &a[1..=n], &b[..n], &b[1..=n]);
        let (c, c1, d, d1) = (&c[..n], &c[1..=n], &d[..n], &d[1..=n]);
        for i in 0..n {
            let ([a, a1], [b, b1]) = (along_x(a[i], a1[i]), along_x(b[i], b1[i]));
            let ([c, c1], [d, d1]) = (along_x(c[i], c1[i]), along_x(d[i], d1[i]));
            let cells = cells[i];
            let across_x = (a & b & c & d) ^ (a1 & b1 & c1 & d1);
            let on_one = (a ^ a1) & (a ^ d) & (d ^ d1) & (b & b1 & c & c1);
            let on_other = (b ^ b1) & (b ^ c) & (c ^ c1) & (a & a1 & d & d1);
            sums.along_z += u64::from((a ^ c).count_ones());
            sums.across_y += u64::from((a & a1 & c & c1 & cells).count_ones());
            sums.across_x += u64::from((across_x & cells).count_ones());
            sums.holes += u64::from(((on_one | on_other) & cells).count_ones());
        }
        sums
    }
}

/// A word of a row, which another follows, and the same of the points that follow along x.
#[inline(always)]
fn along_x(word: u64, next: u64) -> [u64; 2] {
    [word, word >> 1 | next << 63]
}

#[cfg(test)]
mod tests {
    use super::{Flat, Rows};
    use crate::{BitRows, Level, RowCounts, count_rows};

    #[test]
    fn every_level_agrees_with_the_counts_of_rows() {
        let mut state = 11_u64;
        let mut chance = || {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
            state ^ state >> 29
        };
        for points in (1..=140_usize).chain([511, 512, 513, 700]) {
            let words = points.div_ceil(64);
            for rows in [1, 2, 3, 8] {
                let mut slice = |dense: bool| -> Vec<u64> {
                    let mut word = |n: usize| {
                        let word = if dense { chance() } else { chance() | chance() | chance() };
                        let is_cut = n % words == words - 1 && !points.is_multiple_of(64);
                        if is_cut { word & ((1 << (points % 64)) - 1) } else { word }
                    };
                    (0..words * rows).map(&mut word).collect()
                };
                let slices = [slice(points % 2 == 0), slice(points % 3 == 0)];
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
                let [low, upper] =
                    slices.each_ref().map(|slice| [&slice[..], &[0x5A5A_0F0F_3333_9999]].concat());
                let all = Rows { words, cells: &cells };
                for &level in Level::available() {
                    let flat = |slice| -> Flat { all.flat_at(level, slice) };
                    let (low, upper) = ((&low[..], flat(&low)), (&upper[..], flat(&upper)));
                    let between = all.between_at(level, low, upper);
                    let found = [low.1.vertices, between.vertices, between.triangles];
                    assert_eq!(found, expected, "{level}, {points} points, {rows} rows");
                    assert_eq!(upper.1.vertices, high[0], "{level}, {points} points, {rows} rows");
                }
            }
        }
    }
}
