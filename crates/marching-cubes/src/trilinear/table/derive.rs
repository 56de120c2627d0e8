//! The rule behind the table: the same walk around the faces as for the 256 cases, face by face paired as
//! decided, and the same search for triangles.

use super::{AMBIGUOUS, CENTRE};
use crate::case::{
    derive::{self, Pairing},
    triangulate,
};
use isokit_geom::cube::{Corner, Edge, Face};

/// The codes of which corners of one sign are not connected along edges; but for none and all inside.
pub(crate) fn codes() -> impl Iterator<Item = u8> {
    (1..255).filter(|&code| {
        let regions = connected(code, &[]);
        (0..8).any(|k| [0, 1].iter().all(|&side| regions[k] != first_of(code, side)))
    })
}

/// The least corner that is inside, or outside.
fn first_of(code: u8, side: u8) -> u8 {
    (0..8).find(|k| code >> k & 1 == side).expect("corners of either sign")
}

/// Every choice of faces of a code that join their inside, as a mask of faces.
pub(crate) fn choices(code: u8) -> impl Iterator<Item = u8> {
    let ambiguous = AMBIGUOUS[usize::from(code)];
    (0..64).filter(move |choice| choice & !ambiguous == 0)
}

/// The least corner that each is connected with, along edges and the given diagonals.
fn connected(code: u8, diagonals: &[[usize; 2]]) -> [u8; 8] {
    let mut regions: [u8; 8] = [0, 1, 2, 3, 4, 5, 6, 7];
    let is_alike = |[a, b]: &[usize; 2]| (code >> a ^ code >> b) & 1 == 0;
    let edges = Edge::all().map(|edge| edge.ends().map(Corner::index));
    let joins: Vec<_> = edges.filter(is_alike).chain(diagonals.iter().copied()).collect();
    for _ in 0..8 {
        for &[a, b] in &joins {
            let least = regions[a].min(regions[b]);
            (regions[a], regions[b]) = (least, least);
        }
    }
    regions
}

/// What the surface of the cell connects.
pub(super) fn regions(code: u8, joined: u8) -> [u8; 8] {
    let ambiguous = Face::all().filter(|&face| derive::is_ambiguous(code, face));
    let diagonal = |face: Face| {
        let [a, b, c, d] = face.corners();
        let is_joined = joined >> face.index() & 1 == 1;
        let ends = if derive::is_inside(code, a) == is_joined { [a, c] } else { [b, d] };
        ends.map(Corner::index)
    };
    connected(code, &ambiguous.map(diagonal).collect::<Vec<_>>())
}

/// The loops.
pub(super) fn loops(code: u8, joined: u8) -> Vec<Vec<Edge>> {
    derive::loops_by(code, |face| match joined >> face.index() & 1 {
        0 => Pairing::SeparateInside,
        _ => Pairing::SeparateOutside,
    })
}

/// What fills a loop.
pub(super) fn triangles(ring: &[Edge]) -> Vec<[u8; 3]> {
    let numbers = |triangle: [Edge; 3]| triangle.map(|edge| edge.index() as u8);
    if ring.len() <= 8 && !triangulate::face_safe(ring).is_empty() {
        return triangulate::best(ring).into_iter().map(numbers).collect();
    }
    let next = ring.iter().cycle().skip(1);
    let side = |(p, q): (&Edge, &Edge)| [p.index() as u8, q.index() as u8, CENTRE];
    ring.iter().zip(next).map(side).collect()
}
