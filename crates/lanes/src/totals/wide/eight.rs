//! The same word of eight planes in a register, with AVX-512: a column of words, row after row.

use super::{
    super::{InCells, InSlice, Rows, side_by_side::PLANES},
    row::{Between, Row, holes},
};
use crate::word::wide::{Eight, Pack};
use std::ops::Range;

/// Words of eight planes that are counted row by row before the next ones: of two slices they fit the first cache.
const BLOCK: usize = 128;

/// Edges along y are counted with those along z.
#[target_feature(
    enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi2,avx512vpopcntdq"
)]
pub(in super::super) fn in_layers(
    rows: &Rows<'_>,
    slices: [&[[u64; PLANES]]; 2],
) -> [(InSlice, InCells); PLANES] {
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
    fn row(&self, y: usize) -> Row<Eight> {
        Row::new(self.points(0, y), self.points(1, y), self.cells)
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
        let mut some = self.zero;
        for y in rows.clone() {
            let next = self.row(y);
            let Between { pairs, along_y, faces, may_hole } = row.before(&next);
            sums.add_row(&next);
            sums.pairs = sums.pairs + pairs.count_ones();
            sums.along = sums.along + along_y.count_ones();
            sums.faces = sums.faces + (faces & self.cells).count_ones();
            some = some | may_hole;
            row = next;
        }
        if some.found() != 0 {
            for y in rows {
                sums.holes = sums.holes + self.holes(y - 1).count_ones();
            }
        }
    }

    /// Of the cells between row `y` and the next those with a hole.
    #[inline(always)]
    fn holes(&self, y: usize) -> Eight {
        let low = [self.points(0, y), self.points(0, y + 1)];
        let high = [self.points(1, y), self.points(1, y + 1)];
        holes(low, high, self.cells)
    }
}

/// Numbers of bits, of each plane.
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
    fn add_row(&mut self, row: &Row<Eight>) {
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
