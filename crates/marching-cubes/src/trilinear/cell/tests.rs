//! Verdicts against a fine lattice, against each other along the three axes, and under the symmetries.

use super::{Cell, Unit, Verdict};
use crate::trilinear::table::{AMBIGUOUS, derive::codes, is_simple};
use std::collections::BTreeSet;

struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        (self.0 ^ self.0 >> 31) >> 16
    }

    fn below(&mut self, end: u64) -> i64 {
        (self.next() % end) as i64
    }
}

fn cell(values: [f64; 8]) -> Cell {
    let code = (0..8).fold(0, |code, k| code | u8::from(values[k] >= 0.0) << k);
    Cell { code, known: u8::MAX, values, unit: Unit::UNKNOWN }
}

/// Small integers, larger odd ones, or f32 with any exponents.
fn chance(chance: &mut Chance, kind: usize) -> Cell {
    cell(std::array::from_fn(|_| match kind {
        0 => chance.below(7) as f64 - 3.0,
        1 => 2.0 * chance.below(2000) as f64 - 1999.0,
        2 => (chance.below(1 << 20) as f64 - f64::from(1 << 19)) * 1e-300,
        _ => loop {
            let value = f32::from_bits(chance.next() as u32);
            if value.is_finite() {
                break value.into();
            }
        },
    }))
}

/// Values that give each code that is not simple.
fn with_code(chance: &mut Chance, code: u8) -> Cell {
    cell(std::array::from_fn(|k| {
        let size = (1 + chance.below(50)).pow(2) as f64;
        if code >> k & 1 == 1 { size } else { -size }
    }))
}

/// The numbers of pieces into which the surface cuts the cell, inside and outside.
fn pieces(cell: &Cell, verdict: Verdict) -> [usize; 2] {
    let row = cell.resolved(verdict.joined);
    let of = |inside: bool| {
        let own = (0..8).filter(|&k| cell.is_inside(k) == inside).map(|k| row.regions[k]);
        let joins = verdict.tunnel.is_some_and(|[a, _]| cell.is_inside(a.into()) == inside);
        own.collect::<BTreeSet<_>>().len() - usize::from(joins)
    };
    [of(true), of(false)]
}

/// The pieces on a lattice of `n` steps along each axis, exactly, where values are small integers: points
/// of one sign that are neighbours along an axis are of one piece.
fn pieces_on_a_lattice(cell: &Cell, n: i64) -> [usize; 2] {
    let side = n as usize + 1;
    let value = |p: [usize; 3]| -> i64 {
        let weight = |k: usize| -> i64 {
            (0..3).map(|a| if k >> a & 1 == 1 { p[a] as i64 } else { n - p[a] as i64 }).product()
        };
        (0..8).map(|k| cell.values[k] as i64 * weight(k)).sum()
    };
    let place = |m: usize| [m % side, m / side % side, m / side / side];
    let inside: Vec<bool> = (0..side.pow(3)).map(|m| value(place(m)) >= 0).collect();
    let mut seen = vec![false; inside.len()];
    let mut counts = [0; 2];
    for first in 0..inside.len() {
        if seen[first] {
            continue;
        }
        counts[usize::from(!inside[first])] += 1;
        let mut open = vec![first];
        seen[first] = true;
        while let Some(m) = open.pop() {
            for (axis, step) in [1, side, side * side].into_iter().enumerate() {
                let p = place(m)[axis];
                let low = (p > 0).then(|| m - step);
                let high = (p + 1 < side).then(|| m + step);
                for next in low.into_iter().chain(high) {
                    if !seen[next] && inside[next] == inside[m] {
                        seen[next] = true;
                        open.push(next);
                    }
                }
            }
        }
    }
    counts
}

#[test]
fn what_is_joined_is_joined_on_a_fine_lattice_too() {
    let mut random = Chance(3);
    let (mut tunnels, mut compared) = (0, 0);
    for code in codes() {
        for _ in 0..8 {
            let cell = with_code(&mut random, code);
            let verdict = cell.verdict();
            let expected = pieces(&cell, verdict);
            // A narrow passage needs a fine lattice, and none is too fine to see what is apart.
            let found = [7, 16, 45].into_iter().any(|n| pieces_on_a_lattice(&cell, n) == expected);
            assert!(found, "{cell:?}: {verdict:?}, {:?}", pieces_on_a_lattice(&cell, 45));
            tunnels += usize::from(verdict.tunnel.is_some());
            compared += 1;
        }
    }
    assert!(tunnels > 5 && compared == 1024, "{tunnels} tunnels among {compared} cells");
}

#[test]
fn the_three_axes_agree() {
    let mut random = Chance(5);
    let (mut tunnels, mut singular) = (0, 0);
    for n in 0..200_000 {
        let cell = chance(&mut random, n % 4);
        if is_simple(cell.code) {
            continue;
        }
        let verdicts = [0, 1, 2].map(|axis| cell.verdict_along(axis));
        if cell.values.iter().all(|value| value.fract() == 0.0) {
            let whole = Cell { unit: Unit::ONE, ..cell };
            assert_eq!([0, 1, 2].map(|axis| whole.verdict_along(axis)), verdicts, "{cell:?}");
        }
        let row = cell.resolved(verdicts[0].joined);
        // The corners may be others of the same regions.
        let told = verdicts.map(|verdict| {
            let regions = verdict.tunnel.map(|ends| {
                ends.map(|k| row.regions[usize::from(k)]).into_iter().collect::<BTreeSet<_>>()
            });
            (verdict.joined, regions, verdict.is_singular)
        });
        assert!(told.iter().all(|one| *one == told[0]), "{cell:?}: {told:?}");
        tunnels += usize::from(told[0].1.is_some());
        singular += usize::from(told[0].2);
    }
    assert!(tunnels > 100 && singular > 100, "{tunnels} tunnels, {singular} singular cells");
}

#[test]
fn a_look_inside_adds_nothing_where_two_corners_of_a_face_are_alone() {
    let mut random = Chance(13);
    let alone =
        |code: &u8| matches!(code.count_ones(), 2 | 6) && AMBIGUOUS[usize::from(*code)] != 0;
    let codes: Vec<u8> = codes().filter(alone).collect();
    assert_eq!(codes.len(), 24, "two for each diagonal of a face");
    let (mut apart, mut singular) = (0, 0);
    for n in 0..200_000 {
        let code = codes[n / 2 % codes.len()];
        let cell = match n % 2 {
            0 => with_code(&mut random, code),
            // Many ties.
            _ => cell(std::array::from_fn(|k| match code >> k & 1 {
                1 => random.below(4) as f64,
                _ => -1.0 - random.below(4) as f64,
            })),
        };
        let verdict = cell.verdict();
        assert_eq!(verdict.tunnel, None, "{cell:?}");
        for axis in 0..3 {
            let mut looked = verdict;
            cell.look_inside(axis, cell.resolved(verdict.joined), None, &mut looked);
            assert_eq!(looked, verdict, "{cell:?}, axis {axis}");
        }
        apart += usize::from(cell.resolved(verdict.joined).discs.len() > 1);
        singular += usize::from(verdict.is_singular);
    }
    assert!(apart > 10_000 && singular > 1000, "{apart} kept apart, {singular} singular");
}

#[test]
fn verdicts_are_the_same_seen_from_48_sides_and_at_any_scale() {
    let mut random = Chance(7);
    for n in 0..3000 {
        let cell = chance(&mut random, n % 3);
        if is_simple(cell.code) {
            continue;
        }
        let verdict = cell.verdict();
        let expected = (pieces(&cell, verdict), verdict.is_singular);
        for [x, y, z] in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
            for mirror in 0..8_usize {
                let from = |k: usize| ((k & 1) << x | (k >> 1 & 1) << y | (k >> 2) << z) ^ mirror;
                let seen = super::tests::cell(std::array::from_fn(|k| cell.values[from(k)]));
                let verdict = seen.verdict();
                assert_eq!((pieces(&seen, verdict), verdict.is_singular), expected, "{cell:?}");
            }
        }
        for scale in [1e-10_f64, 300.0_f64.exp2(), 0.5] {
            let exact = [scale.log2().round().exp2(), 2.0];
            for scale in exact {
                let seen = super::tests::cell(cell.values.map(|value| value * scale));
                if seen.values.iter().zip(cell.values).all(|(s, v)| s / scale == v) {
                    assert_eq!(seen.verdict(), verdict, "{cell:?} times {scale:e}");
                }
            }
        }
    }
}

/// The sign of a tie is that of values raised by the least that there is.
#[test]
fn a_tie_is_decided_as_if_all_values_were_a_little_greater() {
    let mut random = Chance(11);
    let mut singular = 0;
    for _ in 0..60_000 {
        let tied = chance(&mut random, 0);
        if is_simple(tied.code) {
            continue;
        }
        // Less than any difference that small integers can make in four factors.
        let raised = cell(tied.values.map(|value| value * f64::from(1 << 26) + 1.0));
        assert_eq!(raised.code, tied.code);
        let (verdict, expected) = (tied.verdict(), raised.verdict());
        assert!(!expected.is_singular, "{tied:?}");
        assert_eq!(verdict.joined, expected.joined, "{tied:?}");
        assert_eq!(verdict.tunnel.is_some(), expected.tunnel.is_some(), "{tied:?}");
        singular += usize::from(verdict.is_singular);
    }
    assert!(singular > 1000, "{singular} singular cells");
}

#[test]
fn a_corner_without_a_finite_value_keeps_apart_and_an_infinite_one_joins() {
    let mut found = cell([5.0, -1.0, -1.0, 5.0, -1.0, -1.0, -1.0, -1.0]);
    assert_eq!(found.verdict().joined, 1 << 4, "the low face across z");
    found.known &= !(1 << 1);
    assert_eq!(found.verdict().joined, 0);
    let mut found = cell([1.0, -5.0, -5.0, 1.0, -1.0, -1.0, -1.0, -1.0]);
    assert_eq!(found.verdict().joined, 0);
    found.known &= !1;
    assert_eq!(found.verdict().joined, 1 << 4);
    found.known &= !(1 << 2);
    assert_eq!(found.verdict().joined, 0, "what is outside has the last word");
}
