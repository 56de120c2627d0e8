//! From the cases of a row of cells to triangles.
//!
//! The twelve edges of a cell belong to eight lists of numbered vertices: the x edges of its four rows,
//! the y edges of its two slices, the z edges of its two rows. In each list the vertex of an edge has the
//! list's first number plus the set bits before it. An x edge is the cell's own bit; of the y and z
//! edges the cell has two neighbours in the list, the first at its own bit, the second one further on if
//! the first is cut, else at the same number.

use crate::{
    case::{COUNTS, EDGES},
    layout::{Layout, words_of_row},
    planes::Planes,
    row::Word,
};

/// The number that the next vertex of each list will have.
struct Next {
    x: [u32; 4],
    y: [u32; 2],
    z: [u32; 2],
}

/// Which way round triangles go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Winding {
    /// As the table has them.
    Kept,
    /// The other way, since the frame mirrors.
    Turned,
}

/// Writes the triangles of the cells that start in row `y`, `z`, and gives what is left of `out`.
pub(crate) fn fill_row<'o>(
    planes: &Planes,
    layout: &Layout,
    [y, z]: [usize; 2],
    winding: Winding,
    out: &'o mut [[u32; 3]],
) -> &'o mut [[u32; 3]] {
    let row = |dy: usize, dz: usize| layout.row(planes.lattice, y + dy, z + dz);
    let rows = [row(0, 0), row(1, 0), row(0, 1), row(1, 1)];
    let mut next =
        Next { x: rows.map(|row| row.x), y: [rows[0].y, rows[2].y], z: [rows[0].z, rows[1].z] };
    let mut filled = 0;
    let turn = usize::from(winding == Winding::Turned);
    words_of_row(planes, layout.live.as_ref(), [y, z], |_, word| {
        let mut active = word.active;
        while active != 0 {
            let cell = active.trailing_zeros();
            active &= active - 1;
            let ids = next.ids(word, cell);
            let case = word.case(cell);
            let count = usize::from(COUNTS[case]);
            let edges = EDGES[case].chunks_exact(3);
            for (triangle, edges) in out[filled..filled + count].iter_mut().zip(edges) {
                *triangle =
                    [edges[0], edges[1 + turn], edges[2 - turn]].map(|e| ids[usize::from(e)]);
            }
            filled += count;
        }
        next.pass(word);
    });
    &mut out[filled..]
}

impl Next {
    /// The vertices on the twelve edges of a cell. An edge that is not cut has a number of no meaning.
    #[inline(always)]
    fn ids(&self, word: &Word, cell: u32) -> [u32; 12] {
        let before = (1_u64 << cell) - 1;
        let at = |first: u32, cuts: u64| first.wrapping_add((cuts & before).count_ones());
        let pair = |first: u32, cuts: u64| {
            let low = at(first, cuts);
            [low, low.wrapping_add((cuts >> cell & 1) as u32)]
        };
        let [x0, x1, x2, x3]: [u32; 4] = std::array::from_fn(|n| at(self.x[n], word.x[n]));
        let [[y0, y1], [y2, y3]]: [_; 2] = std::array::from_fn(|n| pair(self.y[n], word.y[n]));
        let [[z0, z1], [z2, z3]]: [_; 2] = std::array::from_fn(|n| pair(self.z[n], word.z[n]));
        [x0, x1, x2, x3, y0, y1, y2, y3, z0, z1, z2, z3]
    }

    /// Leaves a word behind.
    #[inline(always)]
    fn pass(&mut self, word: &Word) {
        let advance = |next: &mut [u32], cuts: &[u64]| {
            for (next, cuts) in next.iter_mut().zip(cuts) {
                *next = next.wrapping_add(cuts.count_ones());
            }
        };
        advance(&mut self.x, &word.x);
        advance(&mut self.y, &word.y);
        advance(&mut self.z, &word.z);
    }
}
