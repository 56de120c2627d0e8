//! What 64 neighbouring cells of a row hold: which of their edges are cut, and their cases.
//!
//! A row of cells has four rows of lattice points around it, at (y, z) = 00, 10, 01, 11. In each bit
//! position of a [`Word`] stands one cell. Its low-x corners are the bits of those rows, its high-x
//! corners the same bits shifted down by one.

use crate::WORD;

/// 64 cells of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Word {
    /// Number of the first cell in its row.
    pub first: usize,
    /// The corners: corner `k` is at the bits x, y, z of `k`.
    pub corners: [u64; 8],
    /// Cut edges along x of the rows at (y, z) = 00, 10, 01, 11.
    pub x: [u64; 4],
    /// Cut edges along y from the low-x corner, at z = 0, 1.
    pub y: [u64; 2],
    /// Cut edges along z from the low-x corner, at y = 0, 1.
    pub z: [u64; 2],
    /// The cells that the surface crosses.
    pub active: u64,
}

impl Word {
    /// Word `w` of a row of cells. `cells` has a bit for each cell of the word.
    #[inline(always)]
    pub fn new(rows: [&[u64]; 4], w: usize, cells: u64) -> Self {
        let low = rows.map(|row| row[w]);
        let high = rows.map(|row| row[w] >> 1 | row.get(w + 1).map_or(0, |next| next << 63));
        let corners = std::array::from_fn(|k| if k & 1 == 0 { low[k / 2] } else { high[k / 2] });
        let any = corners.iter().fold(0, |any, corner| any | corner);
        let all = corners.iter().fold(u64::MAX, |all, corner| all & corner);
        Self {
            first: WORD * w,
            corners,
            x: std::array::from_fn(|row| (low[row] ^ high[row]) & cells),
            y: [low[0] ^ low[1], low[2] ^ low[3]],
            z: [low[0] ^ low[2], low[1] ^ low[3]],
            active: any & !all & cells,
        }
    }

    /// The edges that start at a low-x corner at (y, z) = 00 and are cut, along x, y and z.
    #[inline(always)]
    pub fn owned(&self) -> [u64; 3] {
        [self.x[0], self.y[0], self.z[0]]
    }

    /// The case of cell `i`.
    #[inline(always)]
    pub fn case(&self, i: u32) -> u8 {
        (0..8).fold(0, |case, k| case | ((self.corners[k] >> i & 1) as u8) << k)
    }
}

/// The words of a row of `points` lattice points that hold a crossed cell or a cut edge, into `out`.
///
/// # Panics
///
/// If the rows are not of `points` points each.
pub fn words_of_row(rows: [&[u64]; 4], points: usize, out: &mut Vec<Word>) {
    out.clear();
    let words = crate::words(points);
    let rows = rows.map(|row| &row[..words]);
    for w in 0..words {
        // Cheap first: in most words all four rows are alike and without a change.
        let [a, b, c, d] = rows.map(|row| row[w]);
        let alike = ((a ^ b) | (a ^ c) | (a ^ d)) == 0;
        let next = |row: &[u64]| row.get(w + 1).map_or(a >> 63, |next| next & 1);
        let goes_on = (a == 0 && rows.iter().all(|row| next(row) == 0))
            || (a == u64::MAX && rows.iter().all(|row| next(row) == 1));
        if alike && goes_on {
            continue;
        }
        let last = w + 1 == words;
        let cells = if last { (1 << ((points - 1) % WORD)) - 1 } else { u64::MAX };
        let word = Word::new(rows, w, cells);
        if word.active | word.x[0] | word.y[0] | word.z[0] != 0 {
            out.push(word);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Word, words_of_row};

    /// Each mask by its definition, from the corners of single cells.
    fn check(rows: [&[u64]; 4], points: usize) {
        let inside = |row: usize, i: usize| i < points && rows[row][i / 64] >> (i % 64) & 1 == 1;
        let mut words = vec![Word::default()];
        words_of_row(rows, points, &mut words);
        for i in 0..points {
            let blank = Word { first: i / 64 * 64, ..Word::default() };
            let word = *words.iter().find(|word| word.first == blank.first).unwrap_or(&blank);
            let is_cell = i + 1 < points;
            let corner = |k: usize| inside(k >> 1, i + (k & 1));
            let bit = |mask: u64| mask >> (i % 64) & 1 == 1;
            for n in 0..4 {
                assert_eq!(bit(word.x[n]), is_cell && corner(2 * n) != corner(2 * n + 1), "x {n}");
            }
            assert_eq!(word.y.map(bit)[0], corner(0) != corner(2), "y of {i}");
            assert_eq!(word.z.map(bit)[0], corner(0) != corner(4), "z of {i}");
            let case: u32 = (0..8).map(|k| u32::from(corner(k)) << k).sum();
            let active = is_cell && case != 0 && case != 255;
            assert_eq!(bit(word.active), active, "active {i}");
            if active {
                assert_eq!(word.y.map(bit)[1], corner(4) != corner(6), "y of {i}");
                assert_eq!(word.z.map(bit)[1], corner(2) != corner(6), "z of {i}");
                assert_eq!(u32::from(word.case(i as u32 % 64)), case, "case {i}");
            }
        }
    }

    #[test]
    fn agrees_with_the_definition_on_every_short_row() {
        for points in 1..=4 {
            for bits in 0..1_u64 << (4 * points) {
                let row = |r: usize| [bits >> (r * points) & ((1 << points) - 1)];
                let rows = [row(0), row(1), row(2), row(3)];
                check([&rows[0], &rows[1], &rows[2], &rows[3]], points);
            }
        }
    }

    #[test]
    fn agrees_with_the_definition_across_words() {
        let mut state = 1_u64;
        let mut chance = || {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
            state ^ state >> 29
        };
        for points in [63_usize, 64, 65, 127, 128, 129, 190].repeat(30) {
            let words = points.div_ceil(64);
            let tail = if points % 64 == 0 { u64::MAX } else { (1 << (points % 64)) - 1 };
            // Rows that are mostly alike, full or empty, so that blank words occur.
            let base: Vec<u64> = (0..words).map(|_| [0, u64::MAX][chance() as usize % 2]).collect();
            let mut row = || {
                let odd = chance();
                let mut row = base.clone();
                if odd % 3 == 0 {
                    row[odd as usize / 3 % words] = chance();
                }
                row[words - 1] &= tail;
                row
            };
            let rows = [row(), row(), row(), row()];
            check([&rows[0], &rows[1], &rows[2], &rows[3]], points);
        }
    }
}
