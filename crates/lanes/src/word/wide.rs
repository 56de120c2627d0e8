//! Several words in a register, of one row or of several.

#[macro_use]
mod operators;

mod avx2;
mod avx512;
mod open;

use super::{BitRows, FACES, WORD, Word};
use crate::euler::Bits;
use std::ops::{Add, Range};

pub(crate) use avx2::Four;
pub(crate) use avx512::Eight;
pub(crate) use open::{OpenPlaces, PackRoom};

/// Words in a register. Who holds one has the instructions: only the unsafe functions make one from nothing.
pub(crate) trait Pack: Bits + Add<Output = Self> {
    /// Its words one by one.
    type Words: AsRef<[u64]>;

    /// The eight words that eight packs have in one place.
    type Column: Copy;

    /// One for each place.
    type Columns: AsRef<[Self::Column]>;

    /// How many words it has: 8 at the most.
    const WORDS: usize;

    /// The same word everywhere.
    ///
    /// # Safety
    ///
    /// The machine must have the instructions.
    unsafe fn splat(word: u64) -> Self;

    /// The first words of some, and zeros behind them.
    ///
    /// # Safety
    ///
    /// As for [`splat`](Self::splat).
    unsafe fn load(words: &[u64]) -> Self;

    /// The first words.
    ///
    /// # Safety
    ///
    /// As for [`splat`](Self::splat), and there must be as many.
    unsafe fn load_all(words: *const u64) -> Self;

    /// Each word shifted down by one bit, with the lowest bit of the word in `next` on top.
    fn shifted_in(self, next: Self) -> Self;

    /// Its own words where the bits of `places` are set, and ones elsewhere.
    fn at(self, places: u8) -> Self;

    /// The words that are not 0.
    fn found(self) -> u8;

    /// How many bits of each word are set.
    fn count_ones(self) -> Self;

    /// The sums of the numbers that the bits of each word are the digits of, three a number, the lowest first.
    #[inline(always)]
    fn sums([ones, twos, fours]: [Self; 3]) -> Self {
        let (twos, fours) = (twos.count_ones(), fours.count_ones());
        let pairs = twos + fours + fours;
        ones.count_ones() + pairs + pairs
    }

    /// Four times 16 bits of each word, the lowest first.
    fn quarters(parts: [Self; 4]) -> Self;

    /// One by one.
    fn words(self) -> Self::Words;

    /// Eight packs, word by word.
    fn columns(packs: [Self; 8]) -> Self::Columns;

    /// The words of a column.
    fn eight(column: Self::Column) -> [u64; 8];
}

/// Neighbouring words of rows of cells, a pack of them or as many as there are.
#[derive(Clone, Copy)]
pub(crate) struct Group<P> {
    /// The low-x corners of the four rows; behind the last word zeros.
    pub(crate) low: [P; 4],
    pub(crate) high: [P; 4],
    pub(crate) cells: P,
    /// The crossed cells.
    active: P,
    /// The words that are not blank.
    found: u8,
    /// Row and place in it of the first word, and words in a row.
    place: [usize; 2],
    words: usize,
}

impl<P: Pack> Group<P> {
    /// Row and place in it of word `n`.
    #[inline(always)]
    pub(crate) fn place(&self, n: usize) -> [usize; 2] {
        forward(self.place, n, self.words)
    }

    /// The corners of each word.
    #[inline(always)]
    fn corners(&self) -> P::Columns {
        // What came to the last word of a row from the next row is no corner.
        let (a, b, cells) = (self.low, self.high, self.cells);
        P::columns([a[0], b[0] & cells, a[1], b[1] & cells, a[2], b[2] & cells, a[3], b[3] & cells])
    }

    /// The eight lists of cut edges of each word.
    #[inline(always)]
    fn cuts(&self) -> P::Columns {
        let ([a, b, c, d], high) = (self.low, self.high);
        let along_x = |low: P, n: usize| (low ^ high[n]) & self.cells;
        let x = [along_x(a, 0), along_x(b, 1), along_x(c, 2), along_x(d, 3)];
        P::columns([x[0], x[1], x[2], x[3], a ^ b, c ^ d, a ^ c, b ^ d])
    }

    /// The open cells.
    #[inline(always)]
    fn open(&self) -> P {
        let (a, b) = (self.low, self.high);
        let k = [a[0], b[0], a[1], b[1], a[2], b[2], a[3], b[3]];
        let uneven = (k[0] ^ k[7]) | (k[1] ^ k[6]) | (k[2] ^ k[5]) | (k[3] ^ k[4]);
        let mut open = !uneven;
        for [a, b, c, d] in FACES {
            open = open | (k[a] ^ k[b]) & (k[b] ^ k[c]) & (k[c] ^ k[d]);
        }
        open & self.active
    }

    /// Adds those of the words that are not blank.
    #[inline(always)]
    fn push_words(&self, out: &mut Vec<Word>) {
        if self.found == 0 {
            return;
        }
        let (corners, cuts, active) = (self.corners(), self.cuts(), self.active.words());
        for n in 0..P::WORDS {
            if self.found >> n & 1 == 1 {
                let [row, w] = self.place(n);
                out.push(Word {
                    corners: P::eight(corners.as_ref()[n]),
                    cuts: P::eight(cuts.as_ref()[n]),
                    active: active.as_ref()[n],
                    row,
                    first: WORD * w,
                });
            }
        }
    }
}

/// Row and place in it of the word that lies so many words after one, in rows of `words`.
#[inline(always)]
fn forward([mut row, mut w]: [usize; 2], by: usize, words: usize) -> [usize; 2] {
    w += by;
    while w >= words {
        (row, w) = (row + 1, w - words);
    }
    [row, w]
}

/// The words of rows, a stretch at a time: all but the last row of all, and that one, which has no next row.
pub(crate) struct Groups<'a, P> {
    bits: BitRows<'a>,
    left: Range<usize>,
    /// Every cell of a word, and those of the last word of a row.
    cells: [P; 2],
}

/// Goes through the words of rows that lie one behind another, a pack at a time, and leaves out nearly all that is
/// blank. A pack may be of several rows.
///
/// What the loop needs is in registers where nothing else refers to it: so a stretch knows no [`Groups`].
pub(crate) struct Stretch<'a, P> {
    /// Words of some rows, and of those beside and above them: in each list as many.
    flat: [&'a [u64]; 4],
    at: usize,
    /// A row that begins no later than at `at`, and where it does.
    row: [usize; 2],
    words: usize,
    has_cells: bool,
    cells: [P; 2],
}

/// Of eight words, of which the first has place `p` in a row of `n` words, which end a row: `[n][p]`, for
/// rows that are shorter than that.
const LAST_OF_ROW: [[u8; 8]; 8] = {
    let mut table = [[0; 8]; 8];
    let mut i = 0;
    while i < 512 {
        let (words, place, n) = (i / 64, i / 8 % 8, i % 8);
        if words > 0 && (place + n) % words == words - 1 {
            table[words][place] |= 1 << n;
        }
        i += 1;
    }
    table
};

impl<'a, P: Pack> Groups<'a, P> {
    /// The words of some rows.
    ///
    /// # Safety
    ///
    /// The machine must have the instructions of the pack.
    #[inline(always)]
    pub(crate) unsafe fn new(bits: &BitRows<'a>, rows: Range<usize>) -> Self {
        // SAFETY: the caller says so.
        let cells = unsafe { [P::splat(u64::MAX), P::splat(bits.cells(bits.words() - 1))] };
        Self { bits: *bits, left: rows, cells }
    }

    /// The next rows; none if none are left.
    #[inline(always)]
    pub(crate) fn next(&mut self) -> Option<Stretch<'a, P>> {
        if self.left.is_empty() {
            return None;
        }
        let first = self.left.start;
        let end = self.left.end.min(self.bits.rows() - 1).max(first + 1);
        self.left.start = end;
        Some(Stretch {
            flat: self.bits.flat(first..end),
            at: 0,
            row: [first, 0],
            words: self.bits.words(),
            has_cells: self.bits.has_cells(first),
            cells: self.cells,
        })
    }
}

impl<P: Pack> Stretch<'_, P> {
    /// Whether there are cells between the rows and the next.
    pub(crate) fn has_cells(&self) -> bool {
        self.has_cells
    }

    /// The next words of which one is not blank. Where a row ends, and in rows without cells, all of them may be.
    #[inline(always)]
    pub(crate) fn next(&mut self) -> Option<Group<P>> {
        loop {
            let at = self.at;
            if at >= self.flat[0].len() {
                return None;
            }
            self.at += P::WORDS;
            let (low, high) = self.corners(at);
            let ([a, b, c, d], [a1, b1, c1, d1]) = (low, high);
            // Corners unlike the first; where a row ends, some that are none.
            let unlike = (a ^ a1) | (a ^ b) | (a ^ c) | (a ^ d) | (a ^ b1) | (a ^ c1) | (a ^ d1);
            if unlike.found() != 0 {
                return Some(self.group((low, high), unlike, at));
            }
        }
    }

    /// The corners at low x, and at high x.
    #[inline(always)]
    fn corners(&self, at: usize) -> ([P; 4], [P; 4]) {
        let [every, _] = self.cells;
        let (mut low, mut high) = ([every; 4], [every; 4]);
        let count = self.flat[0].len();
        if at + P::WORDS < count {
            for (n, row) in self.flat.iter().enumerate() {
                debug_assert_eq!(row.len(), count, "as many in each list");
                let words = row.as_ptr().wrapping_add(at);
                // SAFETY: who made this said that the machine has the instructions. Each list has as many words as the
                // first, of which one more than a pack are left.
                let next = unsafe { P::load_all(words.wrapping_add(1)) };
                // SAFETY: as above.
                low[n] = unsafe { P::load_all(words) };
                high[n] = low[n].shifted_in(next);
            }
            return (low, high);
        }
        for (n, row) in self.flat.iter().enumerate() {
            // SAFETY: as above.
            let next = unsafe { P::load(&row[at + 1..]) };
            // SAFETY: as above.
            low[n] = unsafe { P::load(&row[at..]) };
            high[n] = low[n].shifted_in(next);
        }
        (low, high)
    }

    /// The words that begin at `at`. Where corners are `unlike` the first one of their cell, a cell is crossed, if there is
    /// one.
    #[inline(always)]
    fn group(&mut self, (low, high): ([P; 4], [P; 4]), unlike: P, at: usize) -> Group<P> {
        let words = self.words;
        let [row, begin] = &mut self.row;
        while at - *begin >= words {
            (*row, *begin) = (*row + 1, *begin + words);
        }
        let place = [*row, at - *begin];
        let last_of_row = match words < 8 {
            true => LAST_OF_ROW[words][place[1]],
            false => (1_u64 << (words - 1 - place[1]).min(63)) as u8,
        };
        let [every, last] = self.cells;
        let cells = last.at(last_of_row);
        let (x, y, z) = ((low[0] ^ high[0]) & cells, low[0] ^ low[1], low[0] ^ low[2]);
        let active = if self.has_cells { unlike & cells } else { !every };
        let found = (active | x | y | z).found();
        Group { low, high, cells, active, found, place, words }
    }
}

/// Adds the words that are not blank.
#[inline(always)]
fn push_words<P: Pack>(mut groups: Groups<'_, P>, out: &mut Vec<Word>) {
    while let Some(mut stretch) = groups.next() {
        while let Some(group) = stretch.next() {
            group.push_words(out);
        }
    }
}

/// The functions of a level, with all of its instructions.
macro_rules! level {
    ($name:ident $pack:ident $features:literal) => {
        pub(super) mod $name {
            use super::{BitRows, Groups, OpenPlaces, PackRoom, Range, Word, push_words, $pack};

            #[target_feature(enable = $features)]
            pub(in super::super) fn words_of_rows(
                bits: &BitRows<'_>,
                rows: Range<usize>,
                out: &mut Vec<Word>,
            ) {
                // SAFETY: this function runs only where the machine has the instructions.
                push_words(unsafe { Groups::<$pack>::new(bits, rows) }, out);
            }

            #[target_feature(enable = $features)]
            pub(in super::super) fn open_words_of_rows(
                bits: &BitRows<'_>,
                rows: Range<usize>,
                out: &mut Vec<Word>,
            ) {
                // SAFETY: as above.
                let mut groups = unsafe { Groups::<$pack>::new(bits, rows) };
                let mut room = PackRoom::new();
                let mut open = OpenPlaces::new(&groups, &mut room);
                while let Some(mut stretch) = groups.next() {
                    while let Some(group) = stretch.next() {
                        open.add(&group);
                    }
                }
                bits.look_up(open.packs(), out);
            }
        }
    };
}

level!(with_avx2 Four "avx2,bmi1,bmi2,lzcnt,popcnt");
level!(with_avx512 Eight "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vbmi2,avx512vpopcntdq");
