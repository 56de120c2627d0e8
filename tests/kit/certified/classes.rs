//! The classes of cells that there are, and why there are no others.
//!
//! The 256 codes have 656 ways to join or part their ambiguous faces. 36 of them no eight values bring about.
//! 620 are left, and of these 132 may have one tunnel, and eight either of two: 768 classes. That no other
//! occurs is proved here; that these do is left to the tests, which find cells for each.
//!
//! **Faces.** Only in the two checkerboards, where every other corner is inside, do opposite faces decide against
//! each other. A face with inside corners A and C and outside corners B and D joins its inside if AC ≥ BD. The
//! four inside corners of a checkerboard are those of two opposite faces, and so are the outside ones. Hence
//! for two opposite faces the left sides multiply to the product of all inside corners and the right sides to
//! that of all outside ones, whichever two they are. If both join, the former is not less; if both stay
//! apart, it is less. So where two opposite faces join, no two opposite faces stay apart. That rules out 18
//! choices of 64: [`UNREALISABLE`].
//!
//! **Tunnels.** Around the neck of a tunnel what is on the other side is a ring. Take one axis, and A, B, C and D
//! for the field on the edges along it, in cyclic order. Two pieces of slices, say at B and D, are apart for z
//! between some p and q and joined at both, and between them the neck joins those at A and C. So AC − BD, a
//! quadratic in z, is positive between p and q and 0 at both, hence negative beyond them. This holds for each
//! axis: there are two opposite edges along it, one with an end in one of the joined regions and one with an
//! end in the other, and AC − BD is negative at both ends of the axis. With B and D in place of A and C it is
//! positive there, so all necks are between the same two edges and in the same interval: there is one at most.

use super::{Class, pieces::Pieces};
use isokit::geom::cube::{Edge, Face};
use std::collections::BTreeSet;

/// The faces that join their inside, in ways in which no checkerboard has them; bit `f` for face `f`. The faces
/// along x are the last two digits, along z the first two: each of these has two 1s in one place and two 0s
/// in another.
pub const UNREALISABLE: [usize; 18] = [
    0b00_00_11, 0b00_01_11, 0b00_10_11, 0b00_11_00, 0b00_11_01, 0b00_11_10, 0b00_11_11, 0b01_00_11,
    0b01_11_00, 0b10_00_11, 0b10_11_00, 0b11_00_00, 0b11_00_01, 0b11_00_10, 0b11_00_11, 0b11_01_00,
    0b11_10_00, 0b11_11_00,
];

/// Codes whose inside is every other corner.
const CHECKERBOARDS: [usize; 2] = [0x69, 0x96];

/// All classes that there are.
pub fn classes() -> BTreeSet<Class> {
    let of_code = |code: usize| {
        let joins = (0..64).filter(move |joins| joins & !ambiguous(code) == 0);
        let is_real =
            move |joins: &usize| !(CHECKERBOARDS.contains(&code) && UNREALISABLE.contains(joins));
        joins.filter(is_real).flat_map(move |joins| {
            let tunnels = pairs(regions(code, joins)).into_iter();
            let tunnels = tunnels.filter(move |&pair| may_join(code, joins, pair)).map(Some);
            tunnels.chain([None]).map(move |tunnel| Class { code, joins, tunnel })
        })
    };
    (0..256).flat_map(of_code).collect()
}

/// The ambiguous faces of a code: bit `f` for face `f`.
fn ambiguous(code: usize) -> usize {
    let alternates = |f: &usize| {
        let [a, b, c, d] = Face::new(*f as u8).corners().map(|k| code >> k.index() & 1);
        a == c && b == d && a != b
    };
    (0..6).filter(alternates).map(|f| 1 << f).sum()
}

/// For each corner of a code the least one that edges and faces connect it with.
pub(super) fn regions(code: usize, joins: usize) -> [usize; 8] {
    let (mut pieces, inside) = (Pieces::new(8), |k: usize| code >> k & 1);
    for [a, b] in Edge::all().map(|edge| edge.ends().map(|end| end.index())) {
        if inside(a) == inside(b) {
            pieces.join(a, b);
        }
    }
    for f in (0..6).filter(|f| ambiguous(code) >> f & 1 == 1) {
        let [a, b, c, d] = Face::new(f as u8).corners().map(|k| k.index());
        match inside(a) == joins >> f & 1 {
            true => pieces.join(a, c),
            false => pieces.join(b, d),
        }
    }
    std::array::from_fn(|k| pieces.root(k))
}

/// Any two of these regions.
pub(super) fn pairs(regions: [usize; 8]) -> Vec<[usize; 2]> {
    let all: BTreeSet<usize> = regions.into();
    all.iter().flat_map(|&r| all.range(r + 1..).map(move |&s| [r, s])).collect()
}

/// Whether nothing that is known of the faces forbids a tunnel between two regions.
fn may_join(code: usize, joins: usize, [r, s]: [usize; 2]) -> bool {
    let regions = regions(code, joins);
    let of = |region: usize| (0..8).filter(move |&k| regions[k] == region);
    let allows = |axis: usize| {
        let opposite = |&[j, k]: &[usize; 2]| (j ^ k) | 1 << axis == 7;
        let mut ends = of(r).flat_map(|j| of(s).map(move |k| [j, k])).filter(opposite);
        ends.any(|[j, _]| (0..2).all(|side| may_be_negative(code, joins, 2 * axis + side, j)))
    };
    code >> r & 1 == code >> s & 1 && (0..3).all(allows)
}

/// Whether AC − BD may be negative on a face, where A is on the edge across it that corner `k` is on.
fn may_be_negative(code: usize, joins: usize, face: usize, k: usize) -> bool {
    let mut corners = Face::new(face as u8).corners().map(|corner| corner.index());
    let above = 1 << (face / 2);
    let first = corners.iter().position(|a| (a ^ k) & !above == 0);
    corners.rotate_left(first.expect("each edge across a face meets it"));
    let [a, b, c, d] = corners.map(|corner| code >> corner & 1);
    match (a == c, b == d) {
        (true, true) if a != b => joins >> face & 1 != a,
        (alike, others_alike) => !alike || others_alike,
    }
}

#[cfg(test)]
mod tests {
    use super::{CHECKERBOARDS, UNREALISABLE, ambiguous, classes};
    use std::collections::BTreeSet;

    #[test]
    fn there_are_768_classes_of_620_choices_of_which_140_allow_a_tunnel() {
        let choices: usize = (0..256).map(|code| 1 << ambiguous(code).count_ones()).sum();
        let all = classes();
        let plain = all.iter().filter(|class| class.tunnel.is_none()).count();
        let tunnels = all.iter().filter(|class| class.tunnel.is_some());
        let with: BTreeSet<_> = tunnels.map(|class| (class.code, class.joins)).collect();
        assert_eq!((choices, plain, with.len(), all.len()), (656, 656 - 36, 140, 768));
    }

    #[test]
    fn what_no_checkerboard_has_is_opposite_faces_that_join_and_others_that_do_not() {
        let has_pair = |faces: usize| (0..3).any(|axis| faces >> (2 * axis) & 3 == 3);
        let refuted: Vec<_> = (0..64).filter(|&f| has_pair(f) && has_pair(!f & 63)).collect();
        assert_eq!(refuted, UNREALISABLE);
        assert!(CHECKERBOARDS.iter().all(|&code| ambiguous(code) == 63));
    }

    /// So a product of corners says nothing of more than one face.
    #[test]
    fn no_other_code_has_opposite_faces_twice_that_are_ambiguous() {
        let pairs = |code| (0..3).filter(|axis| ambiguous(code) >> (2 * axis) & 3 == 3).count();
        let found = (0..256).filter(|&code| pairs(code) > 1);
        assert_eq!(found.collect::<Vec<_>>(), CHECKERBOARDS);
    }
}
