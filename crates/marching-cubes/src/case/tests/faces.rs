//! Two cells at their common face: what one draws there the other must draw the other way round.

use super::{derive, rim_in};
use isokit_geom::cube::{Corner, Edge, Face};
use std::collections::{BTreeMap, BTreeSet};

#[test]
fn neighbours_cut_their_common_face_alike() {
    for axis in 0..3 {
        let cuts_by_signs = by_signs(axis);
        for (signs, cuts) in &cuts_by_signs {
            assert_eq!(cuts.len(), 1, "axis {axis}, signs {signs:?}: {cuts:?}");
        }
        assert_eq!(cuts_by_signs.len(), 16, "axis {axis}: every pattern of four signs occurs");
    }
}

#[test]
fn an_ambiguous_face_cuts_off_each_inside_corner() {
    for (case, face) in (0..=255).flat_map(|case| Face::all().map(move |face| (case, face))) {
        if !derive::is_ambiguous(case, face) {
            continue;
        }
        assert_eq!(rim_in(case, face).count(), 2);
        for [p, q] in rim_in(case, face) {
            let common = p.ends().into_iter().find(|end| q.ends().contains(end)).unwrap();
            assert!(derive::is_inside(case, common), "case {case:#010b}, {face:?}");
        }
    }
}

type Cuts = BTreeSet<[Edge; 2]>;

/// All that the table draws on a face across `axis`, by the signs of its corners. Both sides of the face
/// are named as the cell above it names them; the cell below is read backwards.
fn by_signs(axis: usize) -> BTreeMap<[bool; 4], BTreeSet<Cuts>> {
    let [low, high] = [2 * axis as u8, 2 * axis as u8 + 1].map(Face::new);
    let raised = |e: Edge| {
        let [a, b] = e.ends().map(|k| k.across(axis));
        Edge::between(a, b).unwrap()
    };
    let mut found: BTreeMap<_, BTreeSet<Cuts>> = BTreeMap::new();
    for case in 0..=255 {
        let signs = |at: fn(Corner, usize) -> Corner| {
            low.corners().map(|k| derive::is_inside(case, at(k, axis)))
        };
        let above = rim_in(case, low).collect();
        let below = rim_in(case, high).map(|[p, q]| [raised(q), raised(p)]).collect();
        found.entry(signs(|k, _| k)).or_default().insert(above);
        found.entry(signs(Corner::across)).or_default().insert(below);
    }
    found
}
