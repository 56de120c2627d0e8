//! Numbers by which the table can be known from outside: totals, orbits, simple codes.

use super::derive::{self, Pairing};
use crate::case::{COUNTS, CROSSED, TRIANGLES};
use isokit_geom::cube::{Corner, Face};
use std::collections::{BTreeMap, BTreeSet};

#[test]
fn totals_are_those_of_the_classic_table() {
    let counts = TRIANGLES.map(<[_]>::len);
    assert_eq!((counts.iter().sum(), counts.iter().max()), (820_usize, Some(&5)));
    assert_eq!(COUNTS.map(usize::from), counts);
}

#[test]
fn both_pairings_have_the_same_totals() {
    for pairing in [Pairing::SeparateInside, Pairing::SeparateOutside] {
        let counts = (0..=255).map(|case| derive::triangles(case, pairing).len());
        assert_eq!((counts.clone().sum(), counts.max()), (820_usize, Some(5)), "{pairing:?}");
        let mut lengths = BTreeMap::new();
        for ring in (0..=255).flat_map(|case| derive::loops(case, pairing)) {
            *lengths.entry(ring.len()).or_default() += 1;
        }
        let expected = [(3, 144), (4, 66), (5, 72), (6, 52), (7, 24)];
        assert_eq!(lengths, BTreeMap::from(expected), "{pairing:?}");
    }
}

#[test]
fn the_complement_under_the_other_pairing_is_the_same_surface_reversed() {
    for case in 0..=255 {
        let cuts = |case, pairing| -> BTreeSet<_> {
            Face::all().flat_map(|face| derive::cuts(case, face, pairing)).collect()
        };
        let there = cuts(case, Pairing::SeparateInside);
        let back = cuts(!case, Pairing::SeparateOutside).into_iter().map(|[p, q]| [q, p]).collect();
        assert_eq!(there, back, "case {case:#010b}");
    }
}

#[test]
fn the_orbits_are_23_and_22_and_with_complements_15_and_14() {
    let all = symmetries();
    let rotations: Vec<_> = all.iter().copied().filter(|s| s.is_rotation).collect();
    assert_eq!((rotations.len(), all.len()), (24, 48));
    assert_eq!(orbits(&rotations, |case| case), 23);
    assert_eq!(orbits(&all, |case| case), 22);
    assert_eq!(orbits(&rotations, |case| case.min(!case)), 15);
    assert_eq!(orbits(&all, |case| case.min(!case)), 14);
}

#[test]
fn half_of_the_codes_are_simple_and_none_of_those_is_ambiguous() {
    let mut by_ambiguous_faces = BTreeMap::new();
    for case in 0..=255 {
        let ambiguous = Face::all().filter(|&face| derive::is_ambiguous(case, face)).count();
        *by_ambiguous_faces.entry((is_simple(case), ambiguous)).or_default() += 1;
    }
    let others = [(0, 8), (1, 72), (2, 30), (3, 16), (6, 2)];
    let mut expected = BTreeMap::from(others.map(|(faces, codes)| ((false, faces), codes)));
    expected.insert((true, 0), 128);
    assert_eq!(by_ambiguous_faces, expected);
}

#[test]
fn a_simple_code_is_one_disc_unless_nothing_is_crossed() {
    for case in (0..=255).filter(|&case| is_simple(case)) {
        let discs = derive::loops(case, Pairing::SeparateInside).len();
        assert_eq!(discs, usize::from(CROSSED[case as usize] != 0), "case {case:#010b}");
    }
}

/// Whether the inside corners hang together along edges, and the outside ones too.
fn is_simple(case: u8) -> bool {
    pieces(case) <= 1 && pieces(!case) <= 1
}

/// How many pieces the corners in `set` make, joined along edges.
fn pieces(mut set: u8) -> usize {
    let mut pieces = 0;
    while set != 0 {
        let mut todo = vec![Corner::new(set.trailing_zeros() as u8)];
        while let Some(k) = todo.pop() {
            if derive::is_inside(set, k) {
                set &= !(1 << k.index());
                todo.extend((0..3).map(|axis| k.across(axis)));
            }
        }
        pieces += 1;
    }
    pieces
}

/// A way to turn a cube onto itself: where each corner goes.
#[derive(Clone, Copy)]
struct Symmetry {
    to: [usize; 8],
    is_rotation: bool,
}

fn symmetries() -> Vec<Symmetry> {
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let mut found = vec![];
    for (order, swaps) in orders.into_iter().zip([0, 0, 0, 1, 1, 1]) {
        let turned = |k: usize| (0..3).fold(0, |to, axis| to | (k >> order[axis] & 1) << axis);
        for flips in 0..8_usize {
            let to = std::array::from_fn(|k| turned(k) ^ flips);
            let is_rotation = (swaps + flips.count_ones()).is_multiple_of(2);
            found.push(Symmetry { to, is_rotation });
        }
    }
    found
}

/// How many cases remain when those that `symmetries` or `also` take into each other count as one.
fn orbits(symmetries: &[Symmetry], also: fn(u8) -> u8) -> usize {
    let turned = |case: u8, s: &Symmetry| (0..8).fold(0, |to, k| to | (case >> k & 1) << s.to[k]);
    let least = |case| symmetries.iter().map(|s| also(turned(case, s))).min();
    (0..=255).map(least).collect::<BTreeSet<_>>().len()
}
