//! From the cases of a row of cells to triangles.
//!
//! The twelve edges of a cell belong to eight lists of numbered vertices: the x edges of its four rows,
//! the y edges of its two slices, the z edges of its two rows. In each list the vertex of an edge has the
//! list's first number plus the set bits before it. An x edge is the cell's own bit; of the y and z
//! edges the cell has two neighbours in the list, the first at its own bit, the second one further on if
//! the first is cut, else at the same number.

use crate::{Level, Word};

#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod wide;

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

/// Writes the triangles of rows of cells to the front of `out`, and gives how many there are. What is behind
/// them in `out` may be anything afterwards.
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
