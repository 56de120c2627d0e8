//! The ways in which a cell is cut once its ambiguous faces are decided.
//!
//! For each code that is not simple, and each choice of the ambiguous faces that join their inside: which
//! corners the cell's surface connects, the loops in which the interpolant's surface leaves the cell, and
//! a disc for each loop. Of the 656 choices of all codes, 528 belong to the codes that are not simple;
//! 36 of these, with all six faces ambiguous, no eight values bring about.
//!
//! Nobody typed this table either; `derive.rs` says how it is made. A disc is cut into the best-shaped
//! triangles on its loop that keep out of the faces. Twelve octagons, all loops of nine sides and the
//! loops of twelve that occur have no such triangles: their disc is a fan around a vertex of its own.

use isokit_geom::cube::Face;

#[cfg(test)]
pub(super) mod derive;
#[rustfmt::skip]
mod generated;
#[cfg(test)]
mod tests;

use generated::{FIRST, RESOLVED};

/// What a triangle calls the vertex in the interior that a fan is around; below it are edges.
pub(super) const CENTRE: u8 = 12;

/// A code whose ambiguous faces are decided.
#[derive(Debug)]
pub(super) struct Resolved {
    /// For each corner the least corner that the surface of the cell connects it with.
    pub(super) regions: [u8; 8],
    /// One for each loop, in the order of their least edges.
    pub(super) discs: &'static [Disc],
}

/// A loop and what fills it.
#[derive(Debug)]
pub(super) struct Disc {
    /// Its edges, counter-clockwise seen from outside.
    pub(super) ring: &'static [u8],
    /// Three edges each, or two and [`CENTRE`], counter-clockwise seen from outside.
    pub(super) triangles: &'static [[u8; 3]],
}

impl Disc {
    /// Whether it is a fan around a vertex of its own.
    pub(super) fn is_fan(&self) -> bool {
        self.triangles.len() == self.ring.len()
    }
}

/// The faces of each code whose corners alternate: bit `f` for face `f`.
pub(super) static AMBIGUOUS: [u8; 256] = {
    let mut table = [0; 256];
    let mut i = 0;
    while i < 256 * 6 {
        let (code, face) = (i / 6, i % 6);
        let [a, b, c, d] = Face::new(face as u8).corners();
        let (a, b) = (code >> a.index() & 1, code >> b.index() & 1);
        let (c, d) = (code >> c.index() & 1, code >> d.index() & 1);
        if a == c && b == d && a != b {
            table[code] |= 1 << face;
        }
        i += 1;
    }
    table
};

/// Whether both the inside and the outside corners of a code are connected along edges: its surface is
/// one disc, and nothing about it is open.
#[cfg(test)]
pub(super) fn is_simple(code: u8) -> bool {
    FIRST[usize::from(code)] == u16::MAX
}

/// The row of a code that is not simple, where the faces in `joined` join their inside.
pub(super) fn resolved(code: u8, joined: u8) -> &'static Resolved {
    let (mut rest, mut choice, mut weight) = (AMBIGUOUS[usize::from(code)], 0, 1);
    while rest != 0 {
        if joined >> rest.trailing_zeros() & 1 == 1 {
            choice += weight;
        }
        weight *= 2;
        rest &= rest - 1;
    }
    &RESOLVED[usize::from(FIRST[usize::from(code)]) + choice]
}
