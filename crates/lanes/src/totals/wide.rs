//! Columns of four words with AVX2: what a row has is kept for the next row. AVX2 has no count of bits: bytes count
//! their own, and are added up in time. With plain loops instead, eight isovalues of rows of four words take a sixth
//! more time (EPYC, November 2026; row `many` of `scripts/bench`).

use super::{InCells, InSlice, Line, Rows, Wall};
use crate::word::wide::{Four, Pack};

/// How many counts of eight bits a byte can add up.
const PER_BYTE: usize = u8::MAX as usize / 8;

#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn in_slice_avx2(rows: &Rows<'_>, slice: &[u64]) -> InSlice {
    if !is_worth_columns(rows) {
        return super::in_slice(rows, slice);
    }
    let mut sums = InSlice::default();
    for first in (0..rows.words).step_by(Four::WORDS) {
        // SAFETY: this function runs only where the machine has the instructions.
        unsafe { Column::new(rows, first).in_slice(slice, &mut sums) };
    }
    sums
}

#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn in_cells_avx2(rows: &Rows<'_>, slices: [&[u64]; 2]) -> InCells {
    if !is_worth_columns(rows) {
        return super::in_cells(rows, slices);
    }
    let mut sums = InCells::default();
    for first in (0..rows.words).step_by(Four::WORDS) {
        // SAFETY: as above.
        unsafe { Column::new(rows, first).in_cells(slices, &mut sums) };
    }
    sums
}

/// Whether at most a quarter of the registers is idle. Where a quarter is, plain loops, which fill them, take as long:
/// so measured for rows of three words and of six.
fn is_worth_columns(rows: &Rows<'_>) -> bool {
    3 * rows.words.next_multiple_of(Four::WORDS) <= 4 * rows.words
}

/// Four words of every row, or as many as there are; words that others own are between. Who holds one has AVX2.
struct Column {
    /// Words in a row, the first of the column's, and the number of rows.
    words: usize,
    first: usize,
    rows: usize,
    /// Ones in the column's own words, and the points that begin a cell.
    own: Four,
    cells: Four,
    zero: Four,
}

impl Column {
    /// The words of all rows from word `first` on.
    ///
    /// # Safety
    ///
    /// The machine must have AVX2.
    #[inline(always)]
    unsafe fn new(&Rows { words, cells }: &Rows<'_>, first: usize) -> Self {
        let own = [u64::MAX; Four::WORDS];
        let own = &own[..(words - first).min(Four::WORDS)];
        // SAFETY: the caller says so.
        unsafe {
            let (zero, own, of_row) =
                (Four::splat(0), Four::load(own), Four::load(&cells[first..words]));
            Self { words, first, rows: cells.len() / words, own, cells: of_row, zero }
        }
    }

    /// The points of row `y` at low and high x.
    #[inline(always)]
    fn points(&self, slice: &[u64], y: usize) -> [Four; 2] {
        let at = y * self.words + self.first;
        if at + Four::WORDS < slice.len() {
            let words = slice.as_ptr().wrapping_add(at);
            // SAFETY: there are four words and one more, and there is a column.
            let (low, next) =
                unsafe { (Four::load_all(words), Four::load_all(words.wrapping_add(1))) };
            return [low, low.shifted_in(next)];
        }
        // SAFETY: there is a column.
        let (low, next) = unsafe { (Four::load(&slice[at..]), Four::load(&slice[at + 1..])) };
        [low, low.shifted_in(next)]
    }

    #[inline(always)]
    fn in_slice(&self, slice: &[u64], sums: &mut InSlice) {
        let mut line = Line::new(self.points(slice, 0), self.cells);
        sums.cut_of_ends += sum(line.cut.ones_of_bytes());
        for first in (1..self.rows).step_by(PER_BYTE) {
            let (mut cut, mut along_y, mut pairs) = (self.zero, self.zero, self.zero);
            for y in first..self.rows.min(first + PER_BYTE) {
                let next = Line::new(self.points(slice, y), self.cells);
                let [of_y, of_two] = line.beside(&next);
                cut = cut.add_bytes(line.cut.ones_of_bytes());
                along_y = along_y.add_bytes((of_y & self.own).ones_of_bytes());
                pairs = pairs.add_bytes(of_two.ones_of_bytes());
                line = next;
            }
            sums.cut += sum(cut);
            sums.along_y += sum(along_y);
            sums.pairs += sum(pairs);
        }
        sums.cut += sum(line.cut.ones_of_bytes());
        sums.cut_of_ends += sum(line.cut.ones_of_bytes());
    }

    #[inline(always)]
    fn in_cells(&self, slices: [&[u64]; 2], sums: &mut InCells) {
        let [low, high] = slices;
        let (mut wall, [z, of_first]) =
            Wall::new(self.points(low, 0), self.points(high, 0), self.cells);
        sums.along_z += sum((z & self.own).ones_of_bytes());
        sums.pairs += sum(of_first.ones_of_bytes());
        sums.pairs_of_ends += sum(of_first.ones_of_bytes());
        let mut of_last = of_first;
        for first in (1..self.rows).step_by(PER_BYTE) {
            let (mut along_z, mut pairs, mut faces) = (self.zero, self.zero, self.zero);
            for y in first..self.rows.min(first + PER_BYTE) {
                let (next, [z, of_two]) =
                    Wall::new(self.points(low, y), self.points(high, y), self.cells);
                along_z = along_z.add_bytes((z & self.own).ones_of_bytes());
                pairs = pairs.add_bytes(of_two.ones_of_bytes());
                faces = faces.add_bytes(wall.faces(&next, self.cells).ones_of_bytes());
                let [one, other] = wall.saddles(&next);
                // Smooth fields have none.
                if (one | other).found() != 0 {
                    let ([a, c], [b, d]) = (self.both(slices, y - 1), self.both(slices, y));
                    let holes = wall.holes(&next, [a ^ d, b ^ c]);
                    sums.holes += sum(holes.ones_of_bytes());
                }
                (wall, of_last) = (next, of_two);
            }
            sums.along_z += sum(along_z);
            sums.pairs += sum(pairs);
            sums.faces += sum(faces);
        }
        sums.pairs_of_ends += sum(of_last.ones_of_bytes());
    }

    /// The points of row `y` in both slices.
    #[inline(always)]
    fn both(&self, [low, high]: [&[u64]; 2], y: usize) -> [Four; 2] {
        [self.points(low, y)[0], self.points(high, y)[0]]
    }
}

#[inline(always)]
fn sum(bytes: Four) -> u64 {
    bytes.sums_of_bytes().words().iter().sum()
}
