//! The cells of a slice that do not have the triangles of their case.

use super::{
    cell::{Cell, Values},
    patch::Patch,
};
use isokit_geom::cube::Face;
use isokit_lanes::Word;
use isokit_volume::Sample;
use std::ops::Range;

/// A cell that has other triangles than its case.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Special {
    /// Its place in its row.
    pub(super) x: u32,
    /// Its row.
    pub(super) y: u32,
    /// The faces that join their inside.
    pub(super) joined: u8,
    /// Two corners that the interior joins.
    pub(super) tunnel: Option<[u8; 2]>,
}

/// What is special in a slice, and what it makes.
#[derive(Debug, Default)]
pub(crate) struct SpecialCells {
    /// Row by row.
    cells: Vec<Special>,
    /// Vertices in the interior of cells.
    pub(crate) vertices: u64,
    /// Triangles of all these cells.
    pub(crate) triangles: u64,
    /// Cells with a saddle exactly on the isovalue, special or not.
    pub(crate) singular: u64,
}

impl SpecialCells {
    /// What one of them takes in memory.
    pub(crate) const BYTES: usize = size_of::<Special>();

    /// Adds the special cells of some words of slice `z`, which come row by row, and takes them out of the
    /// words' crossed cells.
    pub(crate) fn look_at<T: Sample>(
        &mut self,
        values: &Values<'_, T>,
        words: &mut [Word],
        z: usize,
    ) {
        for word in words {
            let mut rest = open(word);
            while rest != 0 {
                let n = rest.trailing_zeros();
                rest &= rest - 1;
                let x = word.first + n as usize;
                let cell = values.cell(word.case(n), [x, word.row, z]);
                if self.add(&cell, [x, word.row]) {
                    word.active &= !(1 << n);
                }
            }
        }
    }

    /// Says whether the cell is special.
    fn add(&mut self, cell: &Cell, [x, y]: [usize; 2]) -> bool {
        let verdict = cell.verdict();
        self.singular += u64::from(verdict.is_singular);
        if verdict.is_plain() {
            return false;
        }
        let patch = Patch::new(cell, verdict.joined, verdict.tunnel);
        self.vertices += patch.vertices() as u64;
        self.triangles += patch.triangles() as u64;
        let (joined, tunnel) = (verdict.joined, verdict.tunnel);
        self.cells.push(Special { x: x as u32, y: y as u32, joined, tunnel });
        true
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.cells.len()
    }

    /// No more memory than is needed.
    pub(crate) fn shrunk(mut self) -> Self {
        self.cells.shrink_to_fit();
        self
    }

    /// Those of some rows.
    pub(super) fn of_rows(&self, rows: Range<usize>) -> &[Special] {
        let first = |y: usize| self.cells.partition_point(|cell| (cell.y as usize) < y);
        &self.cells[first(rows.start)..first(rows.end)]
    }
}

/// The faces of a cell, as corners in cyclic order.
const FACES: [[usize; 4]; 6] = {
    let mut faces = [[0; 4]; 6];
    let mut f = 0;
    while f < 6 {
        let [a, b, c, d] = Face::new(f as u8).corners();
        faces[f] = [a.index(), b.index(), c.index(), d.index()];
        f += 1;
    }
    faces
};

/// The crossed cells whose code is not simple: those with an ambiguous face, and those of which each two
/// opposite corners have one sign.
fn open(word: &Word) -> u64 {
    let k = &word.corners;
    let alternate = |[a, b, c, d]: [usize; 4]| (k[a] ^ k[b]) & (k[b] ^ k[c]) & (k[c] ^ k[d]);
    let is_ambiguous = FACES.into_iter().fold(0, |any, face| any | alternate(face));
    let is_even = (0..4).fold(u64::MAX, |all, n| all & !(k[n] ^ k[7 - n]));
    (is_ambiguous | is_even) & word.active
}

#[cfg(test)]
mod tests {
    use super::{SpecialCells, open};
    use crate::trilinear::table::is_simple;
    use isokit_lanes::Word;

    #[test]
    fn the_cells_that_are_looked_at_are_those_whose_code_is_not_simple() {
        for block in 0..4_usize {
            let code = |n: usize| (64 * block + n) as u8;
            let corner = |k: usize| (0..64).fold(0, |w, n| w | u64::from(code(n) >> k & 1) << n);
            let active = !u64::from(block == 0) & !(u64::from(block == 3) << 63);
            let word = Word { corners: std::array::from_fn(corner), active, ..Word::default() };
            for n in 0..64 {
                let is_open = open(&word) >> n & 1 == 1;
                let crossed = active >> n & 1 == 1;
                assert_eq!(is_open, crossed && !is_simple(code(n)), "{:08b}", code(n));
            }
        }
    }

    #[test]
    fn a_special_cell_takes_twelve_bytes() {
        assert_eq!(SpecialCells::BYTES, 12);
    }
}
