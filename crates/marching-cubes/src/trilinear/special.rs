//! The cells of a slice that do not have the triangles of their case.

use super::{
    cell::{Cell, Values},
    patch::Patch,
};
use isokit_lanes::Word;
use isokit_volume::Sample;

/// Words whose samples are asked for while those before them are looked at.
const AHEAD: usize = 8;

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

    /// Adds the special ones of the cells in some words of slice `z`, which come row by row and name those that signs leave
    /// open, and says of each to which row it belongs and which case it has.
    pub(crate) fn look_at<T: Sample>(
        &mut self,
        values: &Values<'_, T>,
        (z, words): (usize, &[Word]),
        mut found: impl FnMut(usize, u8),
    ) {
        for (n, word) in words.iter().enumerate() {
            if n.is_multiple_of(AHEAD) {
                let [first, end] = [n + AHEAD, n + 2 * AHEAD].map(|n| n.min(words.len()));
                values.expect(z, &words[first..end]);
            }
            let mut rest = word.active;
            while rest != 0 {
                let n = rest.trailing_zeros();
                rest &= rest - 1;
                let (x, case) = (word.first + n as usize, word.case(n));
                let cell = values.cell(case, [x, word.row, z]);
                if self.add(&cell, x as u32, word.row as u32) {
                    found(word.row, case);
                }
            }
        }
    }

    /// Says whether the cell is special.
    fn add(&mut self, cell: &Cell, x: u32, y: u32) -> bool {
        let verdict = cell.verdict();
        self.singular += u64::from(verdict.is_singular);
        if verdict.is_plain() {
            return false;
        }
        let patch = Patch::new(cell.code, verdict.joined, verdict.tunnel);
        self.vertices += patch.vertices() as u64;
        self.triangles += patch.triangles() as u64;
        let (joined, tunnel) = (verdict.joined, verdict.tunnel);
        self.cells.push(Special { x, y, joined, tunnel });
        true
    }

    /// None; the memory stays.
    pub(crate) fn clear(&mut self) {
        let Self { cells, .. } = std::mem::take(self);
        self.cells = cells;
        self.cells.clear();
    }

    /// No more memory than is needed.
    pub(crate) fn shrunk(mut self) -> Self {
        self.cells.shrink_to_fit();
        self
    }

    /// All of them, row by row.
    pub(crate) fn all(&self) -> &[Special] {
        &self.cells
    }
}

#[cfg(test)]
mod tests {
    use super::SpecialCells;
    use crate::trilinear::table::is_simple;
    use isokit_lanes::Word;

    #[test]
    fn the_cells_that_signs_leave_open_are_those_whose_code_is_not_simple() {
        for block in 0..4_usize {
            let code = |n: usize| (64 * block + n) as u8;
            let corner = |k: usize| (0..64).fold(0, |w, n| w | u64::from(code(n) >> k & 1) << n);
            let active = !u64::from(block == 0) & !(u64::from(block == 3) << 63);
            let word = Word { corners: std::array::from_fn(corner), active, ..Word::default() };
            for n in 0..64 {
                let is_open = word.open() >> n & 1 == 1;
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
