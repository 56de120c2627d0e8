//! Eight planes at once, whose words lie side by side: word `w` of plane `k` is `[w][k]`.
//!
//! What a row has is kept for the next one, and with AVX-512 a register has the same word of all eight planes. So none of
//! its lanes is idle, however short rows are, and no word is loaded twice for the bits that follow it.

use super::{Layer, Rows};
use crate::Level;

#[cfg(target_arch = "x86_64")]
use super::{InCells, InSlice, Wall};
#[cfg(target_arch = "x86_64")]
use crate::word::wide::{Eight, Pack};
#[cfg(target_arch = "x86_64")]
use std::ops::Range;

/// Planes that lie side by side.
const PLANES: usize = 8;

/// Words of eight planes that are counted row by row before the next ones: of two slices they fit the first cache.
#[cfg(target_arch = "x86_64")]
const BLOCK: usize = 128;

impl Rows<'_> {
    /// Whether several planes are sooner counted side by side on this machine than one after another.
    pub fn are_side_by_side() -> bool {
        #[cfg(target_arch = "x86_64")]
        return Level::current() == Level::Avx512;
        #[cfg(not(target_arch = "x86_64"))]
        return false;
    }

    /// What the lowest slices of eight planes add. There is no one word more.
    ///
    /// # Panics
    ///
    /// As [`lowest`](Self::lowest).
    pub fn lowest_of_eight(&self, slice: &[[u64; PLANES]]) -> [Layer; PLANES] {
        [0, 1, 2, 3, 4, 5, 6, 7].map(|k| self.lowest(&plane(slice, k)))
    }

    /// What slices of eight planes add that are above others, of which that is known. There is no one word more.
    ///
    /// # Panics
    ///
    /// As [`above`](Self::above).
    pub fn above_of_eight(
        &self,
        low: (&[[u64; PLANES]], &[Layer; PLANES]),
        slice: &[[u64; PLANES]],
    ) -> [Layer; PLANES] {
        self.above_of_eight_at(Level::current(), low, slice)
    }

    fn above_of_eight_at(
        &self,
        level: Level,
        (low, below): (&[[u64; PLANES]], &[Layer; PLANES]),
        slice: &[[u64; PLANES]],
    ) -> [Layer; PLANES] {
        #[cfg(target_arch = "x86_64")]
        if level == Level::Avx512 {
            level.assert_available();
            self.check_sizes([low.len() + 1, slice.len() + 1]);
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            let sums = unsafe { in_layers(self, [low, slice]) };
            return std::array::from_fn(|k| Self::layer(below[k], sums[k]));
        }
        std::array::from_fn(|k| self.above_at(level, (&plane(low, k), below[k]), &plane(slice, k)))
    }
}

/// One plane of eight, and one word more.
fn plane(slice: &[[u64; PLANES]], k: usize) -> Vec<u64> {
    slice.iter().map(|words| words[k]).chain([0]).collect()
}

/// Edges along y are counted with those along z.
#[cfg(target_arch = "x86_64")]
#[target_feature(
    enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi2,avx512vpopcntdq"
)]
fn in_layers(rows: &Rows<'_>, slices: [&[[u64; PLANES]]; 2]) -> [(InSlice, InCells); PLANES] {
    // SAFETY: this function runs only where the machine has the instructions.
    let zero = unsafe { Eight::splat(0) };
    let mut sums = Sums::none(zero);
    let (count, block) = (rows.cells.len() / rows.words, (BLOCK / rows.words).max(8));
    for word in 0..rows.words {
        // SAFETY: as above.
        unsafe { Column::new(rows, word, slices) }.add_ends(&mut sums);
    }
    for first in (1..count).step_by(block) {
        for word in 0..rows.words {
            // SAFETY: as above.
            let column = unsafe { Column::new(rows, word, slices) };
            column.add(first..count.min(first + block), &mut sums);
        }
    }
    sums.of_planes()
}

/// A word of every row of two slices. Who holds one has AVX-512.
#[cfg(target_arch = "x86_64")]
struct Column<'a> {
    slices: [&'a [[u64; PLANES]]; 2],
    /// Words in a row, the column's own, and the number of rows.
    words: usize,
    own: usize,
    rows: usize,
    /// The points that begin a cell.
    cells: Eight,
    zero: Eight,
}

/// A row of two slices.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
struct Row {
    /// Points, edges along x that are inside, and those that are cut, of the higher slice.
    points: Eight,
    edges: Eight,
    cut: Eight,
    /// Cut edges along z.
    along_z: Eight,
    /// Edges along x, one above another, of which one is inside.
    pairs: Eight,
    /// Edges along z that are inside, at low and high x.
    upright: [Eight; 2],
}

#[cfg(target_arch = "x86_64")]
impl<'a> Column<'a> {
    /// Word `own` of all rows.
    ///
    /// # Safety
    ///
    /// The machine must have AVX-512.
    #[inline(always)]
    unsafe fn new(rows: &Rows<'_>, own: usize, slices: [&'a [[u64; PLANES]]; 2]) -> Self {
        let &Rows { words, cells } = rows;
        // SAFETY: the caller says so.
        let (cells_of_word, zero) = unsafe { (Eight::splat(cells[own]), Eight::splat(0)) };
        Self { slices, words, own, rows: cells.len() / words, cells: cells_of_word, zero }
    }

    /// The points of row `y` of a slice at low and high x.
    #[inline(always)]
    fn points(&self, slice: usize, y: usize) -> [Eight; 2] {
        let at = y * self.words + self.own;
        let (words, rest) = self.slices[slice][at..].split_first().expect("there is such a row");
        // SAFETY: there is a column; eight words are a register.
        let low = unsafe { Eight::load_all(words.as_ptr()) };
        // Behind a row nothing is inside, which is cut away where it matters.
        let next = match rest.first() {
            // SAFETY: as above.
            Some(next) if self.own + 1 < self.words => unsafe { Eight::load_all(next.as_ptr()) },
            _ => self.zero,
        };
        [low, low.shifted_in(next)]
    }

    #[inline(always)]
    fn row(&self, y: usize) -> Row {
        let ([b, b1], [d, d1]) = (self.points(0, y), self.points(1, y));
        let edges = d & d1;
        Row {
            points: d,
            edges,
            cut: (d ^ d1) & self.cells,
            along_z: b ^ d,
            pairs: (b & b1) ^ edges,
            upright: [b & d, b1 & d1],
        }
    }

    /// Adds the first row, and what counts of the first and of the last one.
    #[inline(always)]
    fn add_ends(&self, sums: &mut Sums) {
        sums.add_row(&self.row(0));
        for row in [self.row(0), self.row(self.rows - 1)] {
            sums.cut_of_ends = sums.cut_of_ends + row.cut.count_ones();
            sums.pairs_of_ends = sums.pairs_of_ends + row.pairs.count_ones();
        }
    }

    /// Adds some rows, and what is between them and those before.
    #[inline(always)]
    fn add(&self, rows: Range<usize>, sums: &mut Sums) {
        let mut row = self.row(rows.start - 1);
        // Of each of three pairs of edges one is inside, and the other edge of the higher slice is cut: smooth fields have
        // next to none of these.
        let mut may_hole = self.zero;
        for y in rows.clone() {
            let next = self.row(y);
            sums.add_row(&next);
            let pairs = row.edges ^ next.edges;
            sums.pairs = sums.pairs + pairs.count_ones();
            sums.along = sums.along + (row.points ^ next.points).count_ones();
            let low = row.upright[0] & next.upright[0];
            let high = row.upright[1] & next.upright[1];
            sums.faces = sums.faces + ((low ^ high) & self.cells).count_ones();
            may_hole = may_hole | row.pairs & pairs & next.pairs & (row.cut | next.cut);
            row = next;
        }
        if may_hole.found() != 0 {
            for y in rows {
                sums.holes = sums.holes + self.holes(y - 1).count_ones();
            }
        }
    }

    /// Of the cells between row `y` and the next those with a hole.
    #[inline(always)]
    fn holes(&self, y: usize) -> Eight {
        let (a, b) = (self.points(0, y), self.points(0, y + 1));
        let (c, d) = (self.points(1, y), self.points(1, y + 1));
        let (wall, _) = Wall::new(a, c, self.cells);
        let (next, _) = Wall::new(b, d, self.cells);
        wall.holes(&next, [a[0] ^ d[0], b[0] ^ c[0]])
    }
}

/// Numbers of bits, of each plane.
#[cfg(target_arch = "x86_64")]
struct Sums {
    cut: Eight,
    cut_of_ends: Eight,
    /// Cut edges along y and z.
    along: Eight,
    /// Neighbouring edges along x of which one is inside, beside each other and one above another.
    pairs: Eight,
    upright_pairs: Eight,
    pairs_of_ends: Eight,
    faces: Eight,
    holes: Eight,
}

#[cfg(target_arch = "x86_64")]
impl Sums {
    #[inline(always)]
    fn none(zero: Eight) -> Self {
        Self {
            cut: zero,
            cut_of_ends: zero,
            along: zero,
            pairs: zero,
            upright_pairs: zero,
            pairs_of_ends: zero,
            faces: zero,
            holes: zero,
        }
    }

    #[inline(always)]
    fn add_row(&mut self, row: &Row) {
        self.cut = self.cut + row.cut.count_ones();
        self.along = self.along + row.along_z.count_ones();
        self.upright_pairs = self.upright_pairs + row.pairs.count_ones();
    }

    fn of_planes(&self) -> [(InSlice, InCells); PLANES] {
        let each = [self.cut, self.cut_of_ends, self.pairs].map(Pack::words);
        let [cut, cut_of_ends, pairs] = each;
        let each = [self.along, self.upright_pairs, self.pairs_of_ends, self.faces, self.holes];
        let [along, upright_pairs, pairs_of_ends, faces, holes] = each.map(Pack::words);
        std::array::from_fn(|k| {
            let slice =
                InSlice { cut: cut[k], cut_of_ends: cut_of_ends[k], along_y: 0, pairs: pairs[k] };
            let cells = InCells {
                along_z: along[k],
                pairs: upright_pairs[k],
                pairs_of_ends: pairs_of_ends[k],
                faces: faces[k],
                holes: holes[k],
            };
            (slice, cells)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{PLANES, plane};
    use crate::{Layer, Level, Rows};

    #[test]
    fn planes_side_by_side_have_what_each_has_by_itself() {
        let mut state = 17_u64;
        let mut chance = || {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
            state ^ state >> 29
        };
        for points in (1..=70_usize).chain([127, 128, 129, 192, 256, 258, 321, 512]) {
            let words = points.div_ceil(64);
            for rows in [1, 2, 3, 8, 37] {
                let mut slice = || -> Vec<[u64; PLANES]> {
                    let mut words_of = |n: usize| {
                        // From noise to smooth, and to nothing but ones.
                        let word = |k: usize, noise: u64| match k {
                            0..3 => noise,
                            3 => noise | noise >> 7,
                            4 => u64::MAX << (noise % 64),
                            5 => u64::MAX,
                            _ => (n % 2) as u64 * u64::MAX,
                        };
                        let is_cut = n % words == words - 1 && !points.is_multiple_of(64);
                        let mask = if is_cut { (1 << (points % 64)) - 1 } else { u64::MAX };
                        std::array::from_fn(|k| word(k, chance()) & mask)
                    };
                    (0..words * rows).map(&mut words_of).collect()
                };
                let (low, high) = (slice(), slice());
                let last = |n: usize| n % words == words - 1;
                let cells = |n| if last(n) { (1 << ((points - 1) % 64)) - 1 } else { u64::MAX };
                let cells: Vec<u64> = (0..words * rows).map(cells).collect();
                let all = Rows { words, cells: &cells };
                let below = all.lowest_of_eight(&low);
                let expected: [Layer; PLANES] = std::array::from_fn(|k| {
                    assert_eq!(below[k], all.lowest(&plane(&low, k)));
                    all.above((&plane(&low, k), below[k]), &plane(&high, k))
                });
                for &level in Level::available() {
                    let found = all.above_of_eight_at(level, (&low, &below), &high);
                    assert_eq!(found, expected, "{level}, {points} points, {rows} rows");
                }
            }
        }
    }

    #[test]
    #[should_panic(expected = "one word more")]
    fn a_slice_that_is_too_short_is_refused() {
        let (cells, slice) = (vec![1; 8], vec![[0; PLANES]; 7]);
        let rows = Rows { words: 4, cells: &cells };
        rows.above_of_eight((&slice, &[Layer::default(); PLANES]), &slice);
    }
}
