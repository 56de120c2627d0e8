//! A row of two slices, and what it adds to the row before it: in words of one plane or of several.

use crate::{euler::Bits, totals::Wall};

/// A row of two slices.
#[derive(Clone, Copy)]
pub(super) struct Row<B> {
    /// Points, and edges along x that are inside, of the higher slice.
    points: B,
    edges: B,
    /// Cut edges along x of the higher slice, and those along z.
    pub(super) cut: B,
    pub(super) along_z: B,
    /// Edges along x, one above another, of which one is inside.
    pub(super) pairs: B,
    /// Edges along z that are inside, at low and high x.
    upright: [B; 2],
}

/// What is between a row and the one before.
pub(super) struct Between<B> {
    /// Neighbouring edges along x of the higher slice of which one is inside.
    pub(super) pairs: B,
    /// Cut edges along y of the higher slice.
    pub(super) along_y: B,
    /// Where just one of both faces across x is inside; behind a row's last cell this means nothing.
    pub(super) faces: B,
    /// Where there may be holes: of each of three pairs of edges one is inside, and the other edge of the higher slice
    /// is cut. Smooth fields have next to none.
    pub(super) may_hole: B,
}

impl<B: Bits> Row<B> {
    /// Given are the points of the lower and the higher slice at low and high x, and those that begin a cell.
    #[inline(always)]
    pub(super) fn new([b, b1]: [B; 2], [d, d1]: [B; 2], cells: B) -> Self {
        let edges = d & d1;
        Self {
            points: d,
            edges,
            cut: (d ^ d1) & cells,
            along_z: b ^ d,
            pairs: (b & b1) ^ edges,
            upright: [b & d, b1 & d1],
        }
    }

    /// What is between this row and the next one.
    #[inline(always)]
    pub(super) fn before(&self, next: &Self) -> Between<B> {
        let pairs = self.edges ^ next.edges;
        let low = self.upright[0] & next.upright[0];
        let high = self.upright[1] & next.upright[1];
        Between {
            pairs,
            along_y: self.points ^ next.points,
            faces: low ^ high,
            may_hole: self.pairs & pairs & next.pairs & (self.cut | next.cut),
        }
    }
}

/// The cells of which just two corners are outside, opposite ones. Given are the points of two rows of the lower slice
/// and of the higher one, each at low and high x, and those that begin a cell.
#[inline(always)]
pub(super) fn holes<B: Bits>([a, b]: [[B; 2]; 2], [c, d]: [[B; 2]; 2], cells: B) -> B {
    let (wall, _) = Wall::new(a, c, cells);
    let (next, _) = Wall::new(b, d, cells);
    wall.holes(&next, [a[0] ^ d[0], b[0] ^ c[0]])
}
