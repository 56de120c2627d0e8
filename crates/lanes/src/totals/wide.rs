//! Columns of four words with AVX2, row after row: what a row has is kept for the next one. AVX2 has no count of bits.
//! So bits of two rows are added up as binary digits, of which only the highest are counted each time: bytes count
//! their own, and are added up in time. So eight isovalues of rows of four words take 0.81 of the time that they take
//! with plain loops, and of rows of three words 0.97 (EPYC, one thread, November 2026; gyroids of 256³ and 192³, as in
//! row `many` of `scripts/bench`).

mod eight;
mod row;

pub(super) use eight::in_layers;

use super::{InCells, InSlice, Rows};
use crate::{
    euler::add,
    word::wide::{Four, Pack},
};
use row::{Between, Row, holes};

/// How many counts of eight bits a byte can add up.
const PER_BYTE: usize = u8::MAX as usize / 8;

#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn in_slice_avx2(rows: &Rows<'_>, slice: &[u64]) -> InSlice {
    super::in_slice(rows, slice)
}

/// Edges along y are counted with those along z, and `pairs` and `faces` of both slices are too large by the same
/// number.
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn in_layer_avx2(rows: &Rows<'_>, slices: [&[u64]; 2]) -> (InSlice, InCells) {
    // Plain loops fill their registers. Where more than a quarter of a column's is idle, as in rows of five words, they
    // take no longer.
    if 3 * rows.words.next_multiple_of(Four::WORDS) > 4 * rows.words {
        return super::in_layer(rows, slices);
    }
    let (mut high, mut both) = (InSlice::default(), InCells::default());
    let whole = rows.words / Four::WORDS * Four::WORDS;
    for first in (0..whole).step_by(Four::WORDS) {
        // SAFETY: this function runs only where the machine has the instructions.
        let column = unsafe { Column::<true>::new(rows, first, slices) };
        column.add_to(&mut high, &mut both);
    }
    if whole < rows.words {
        // SAFETY: as above.
        let column = unsafe { Column::<false>::new(rows, whole, slices) };
        column.add_to(&mut high, &mut both);
    }
    (high, both)
}

/// Four words of every row of two slices; fewer, if it is not `WHOLE`, at the end of a row. Who holds one has AVX2.
struct Column<'a, const WHOLE: bool> {
    slices: [&'a [u64]; 2],
    /// Words in a row, the first of the column's, and the number of rows.
    words: usize,
    first: usize,
    rows: usize,
    /// Ones in the column's own words.
    own: Four,
    /// The points that begin a cell, and by how much the word behind each is shifted up to follow it: out of
    /// sight, where it is another row's.
    cells: Four,
    up: Four,
    zero: Four,
}

/// What a row adds to those before it.
struct Added {
    /// Cut edges along x of the higher slice; neighbouring ones of which one is inside.
    cut: Four,
    pairs: Four,
    /// Cut edges along y of the higher slice, and along z.
    edges: [Four; 2],
    /// Edges along x, one above another, of which one is inside, and cells of which both or none of the faces
    /// across x are.
    across: [Four; 2],
    /// Where there may be holes.
    may_hole: Four,
}

impl<'a, const WHOLE: bool> Column<'a, WHOLE> {
    /// The words of all rows from word `first` on.
    ///
    /// # Safety
    ///
    /// The machine must have AVX2.
    #[inline(always)]
    unsafe fn new(&Rows { words, cells }: &Rows<'_>, first: usize, slices: [&'a [u64]; 2]) -> Self {
        assert!(!cells.is_empty(), "a slice has rows");
        assert!(!WHOLE || first + Four::WORDS <= words, "a row has the words");
        slices.iter().for_each(|slice| assert_eq!(slice.len(), cells.len() + 1, "one word more"));
        let own = [u64::MAX; Four::WORDS];
        let own = &own[..(words - first).min(Four::WORDS)];
        let up = [0, 1, 2, 3].map(|n| if first + n + 1 < words { 63 } else { 64 });
        // SAFETY: the caller says so.
        unsafe {
            Self {
                slices,
                words,
                first,
                rows: cells.len() / words,
                own: Four::load(own),
                cells: Four::load(&cells[first..words]),
                up: Four::load(&up),
                zero: Four::splat(0),
            }
        }
    }

    /// The points of row `y` of a slice at low and high x.
    #[inline(always)]
    fn points(&self, slice: usize, y: usize) -> [Four; 2] {
        let (slice, at) = (self.slices[slice], y * self.words + self.first);
        let (low, next) = if WHOLE || at + Four::WORDS < slice.len() {
            debug_assert!(at + Four::WORDS < slice.len(), "there is such a row");
            let words = slice.as_ptr().wrapping_add(at);
            // SAFETY: there are five words from `at` on: that was just asked; or, as callers stay below `rows`, the row
            // has four from `first` on, and each word of a row has another behind it. There is a column.
            unsafe { (Four::load_all(words), Four::load_all(words.wrapping_add(1))) }
        } else {
            // SAFETY: there is a column.
            unsafe { (Four::load(&slice[at..]), Four::load(&slice[at + 1..])) }
        };
        let low = if WHOLE { low } else { low & self.own };
        [low, low.followed_by(next, self.up)]
    }

    #[inline(always)]
    fn row(&self, y: usize) -> Row<Four> {
        Row::new(self.points(0, y), self.points(1, y), self.cells)
    }

    /// What row `next` adds to the one before.
    #[inline(always)]
    fn added(&self, row: &Row<Four>, next: &Row<Four>) -> Added {
        let Between { pairs, along_y, faces, may_hole } = row.before(next);
        Added {
            cut: next.cut,
            pairs,
            edges: [along_y, next.along_z],
            across: [next.pairs, faces.outside(self.cells)],
            may_hole,
        }
    }

    #[inline(always)]
    fn add_to(&self, high: &mut InSlice, both: &mut InCells) {
        let mut row = self.row(0);
        high.cut += ones(row.cut);
        both.along_z += ones(row.along_z);
        both.pairs += ones(row.pairs);
        for row in [&row, &self.row(self.rows - 1)] {
            high.cut_of_ends += ones(row.cut);
            both.pairs_of_ends += ones(row.pairs);
        }
        let mut y = 1;
        while y < self.rows {
            let (first, mut counts) = (y, Counts::none(self.zero));
            if !(self.rows - y).is_multiple_of(2) {
                // An odd row comes first of all: to counts that are empty it carries nothing.
                let next = self.row(y);
                counts.add([self.added(&row, &next), Added::none(self.zero)]);
                (row, y) = (next, y + 1);
            }
            let end = self.rows.min(y + 2 * PER_BYTE);
            for y in (y..end).step_by(2) {
                let middle = self.row(y);
                let one = self.added(&row, &middle);
                let last = self.row(y + 1);
                let other = self.added(&middle, &last);
                counts.add([one, other]);
                row = last;
            }
            counts.add_to(high, both);
            both.faces += (end - first) as u64 * ones(self.cells);
            if counts.may_hole.found() != 0 {
                for y in first..end {
                    both.holes += self.holes(y - 1);
                }
            }
            y = end;
        }
    }

    /// Cells between row `y` and the next of which just two corners are outside, opposite ones.
    #[inline(always)]
    fn holes(&self, y: usize) -> u64 {
        let low = [self.points(0, y), self.points(0, y + 1)];
        let high = [self.points(1, y), self.points(1, y + 1)];
        ones(holes(low, high, self.cells))
    }
}

impl Added {
    #[inline(always)]
    fn none(zero: Four) -> Self {
        Self { cut: zero, pairs: zero, edges: [zero; 2], across: [zero; 2], may_hole: zero }
    }
}

/// What rows add.
struct Counts {
    cut: Ones,
    pairs: Ones,
    edges: Twos,
    across: Twos,
    may_hole: Four,
}

impl Counts {
    #[inline(always)]
    fn none(zero: Four) -> Self {
        let (ones, twos) = (Ones([zero; 2]), Twos([zero; 3]));
        Self { cut: ones, pairs: ones, edges: twos, across: twos, may_hole: zero }
    }

    #[inline(always)]
    fn add(&mut self, [one, other]: [Added; 2]) {
        self.cut.add([one.cut, other.cut]);
        self.pairs.add([one.pairs, other.pairs]);
        self.edges.add([one.edges, other.edges]);
        self.across.add([one.across, other.across]);
        self.may_hole = self.may_hole | one.may_hole | other.may_hole;
    }

    #[inline(always)]
    fn add_to(&self, high: &mut InSlice, both: &mut InCells) {
        high.cut += self.cut.sum();
        high.pairs += self.pairs.sum();
        both.along_z += self.edges.sum();
        both.pairs += self.across.sum();
    }
}

/// Numbers of bits: their lowest binary digits, and of each byte the rest by half.
#[derive(Clone, Copy)]
struct Ones([Four; 2]);

impl Ones {
    #[inline(always)]
    fn add(&mut self, [a, b]: [Four; 2]) {
        let [ones, twos] = self.0;
        let (ones, carry) = add(a, b, ones);
        self.0 = [ones, twos.add_bytes(carry.ones_of_bytes())];
    }

    #[inline(always)]
    fn sum(&self) -> u64 {
        let [digits, twos] = self.0;
        ones(digits) + 2 * sum(twos)
    }
}

/// Numbers of bits: their two lowest binary digits, and of each byte the rest by a quarter.
#[derive(Clone, Copy)]
struct Twos([Four; 3]);

impl Twos {
    #[inline(always)]
    fn add(&mut self, [[a, b], [c, d]]: [[Four; 2]; 2]) {
        let [ones, twos, fours] = self.0;
        let (ones, first) = add(a, b, ones);
        let (ones, second) = add(c, d, ones);
        let (twos, carry) = add(first, second, twos);
        self.0 = [ones, twos, fours.add_bytes(carry.ones_of_bytes())];
    }

    #[inline(always)]
    fn sum(&self) -> u64 {
        let [digits, twos, fours] = self.0;
        ones(digits) + 2 * ones(twos) + 4 * sum(fours)
    }
}

/// How many bits are set.
#[inline(always)]
fn ones(bits: Four) -> u64 {
    sum(bits.ones_of_bytes())
}

#[inline(always)]
fn sum(bytes: Four) -> u64 {
    bytes.sums_of_bytes().words().iter().sum()
}
