//! Interior vertices keep what they promise, and lie on the surface where that leaves them free to.

use super::{CLEARANCE, Interpolant, apart, centre, waist};
use crate::trilinear::{cell::Cell, number::Unit};

struct Chance(u64);

impl Chance {
    /// A number from −1 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        ((self.0 ^ self.0 >> 31) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn cell(values: [f64; 8]) -> Cell {
    let code = (0..8).fold(0, |code, k| code | u8::from(values[k] >= 0.0) << k);
    Cell { code, known: u8::MAX, values, unit: Unit::UNKNOWN }
}

/// Cells with a tunnel, wide or narrow, in the middle or near a face.
fn tunnels() -> Vec<(Cell, [u8; 2])> {
    let mut chance = Chance(3);
    let mut found = vec![];
    while found.len() < 2000 {
        let far = (found.len() % 4, 7 - found.len() % 4);
        let sign = if found.len() % 8 < 4 { 1.0 } else { -1.0 };
        let values = std::array::from_fn(|k| match k == far.0 || k == far.1 {
            true => sign * 4.0 * chance.next().abs(),
            false => -sign * chance.next().abs().powi(2),
        });
        let cell = cell(values);
        if let Some(ends) = cell.verdict().tunnel {
            found.push((cell, ends));
        }
    }
    found
}

#[test]
fn a_waist_keeps_clear_of_the_faces_and_its_sides_run_along_the_axes() {
    for (cell, ends) in tunnels() {
        let ring = waist(&Interpolant::new(&cell).unwrap(), ends);
        for (p, q) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            assert!(p.iter().all(|c| (CLEARANCE..=1.0 - CLEARANCE).contains(c)), "{ring:?}");
            let steps = [0, 1, 2].map(|axis| (p[axis] - q[axis]).abs());
            let long = steps.iter().filter(|step| **step > 0.0);
            assert!(long.clone().count() == 1 && long.sum::<f64>() > 0.99 * CLEARANCE, "{ring:?}");
        }
    }
}

#[test]
fn a_waist_within_the_clearance_lies_in_the_surface_with_all_its_sides() {
    let mut compared = 0;
    for (cell, ends) in tunnels() {
        let interpolant = Interpolant::new(&cell).unwrap();
        let ring = waist(&interpolant, ends);
        let is_free = |&c: &f64| c > CLEARANCE && c < 1.0 - CLEARANCE;
        let extent = |axis: usize| {
            let along = ring.map(|place| place[axis]);
            along.iter().fold(0.0, |most: f64, c| most.max((c - along[0]).abs()))
        };
        let is_wide = (0..3).all(|axis| extent(axis) > 1.01 * CLEARANCE);
        if !(is_wide && ring.as_flattened().iter().all(is_free)) {
            continue;
        }
        compared += 1;
        for (p, q) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            for share in [0.0, 0.3, 0.5, 0.9] {
                let place = std::array::from_fn(|k| p[k] * (1.0 - share) + q[k] * share);
                let (_, value) = interpolant.gradient(place);
                assert!(value.abs() < 1e-9, "{cell:?}: {value:e} at {place:?}");
            }
        }
    }
    assert!(compared > 300, "{compared}");
}

#[test]
fn two_numbers_keep_apart_whatever_they_are() {
    for p in [0.0, 0.01, 0.5, 0.97, 1.0, -3.0, f64::NAN, f64::INFINITY] {
        for q in [0.0, 0.02, 0.5, 0.51, 0.99, 7.0, f64::NAN] {
            let [low, high] = apart(p, q);
            assert!(low >= CLEARANCE && high <= 1.0 - CLEARANCE, "{p}, {q}: {low}, {high}");
            assert!(high - low > 0.99 * CLEARANCE, "{p}, {q}: {low}, {high}");
        }
    }
}

#[test]
fn a_centre_comes_nearer_to_the_surface_than_the_mean_of_its_loop() {
    let mut chance = Chance(5);
    for _ in 0..1000 {
        let cell = cell(std::array::from_fn(|_| chance.next()));
        let interpolant = Interpolant::new(&cell).unwrap();
        let place =
            || [0.5 + 0.4 * chance.next(), 0.5 + 0.4 * chance.next(), 0.5 + 0.4 * chance.next()];
        let ring: Vec<[f64; 3]> = std::iter::repeat_with(place).take(9).collect();
        let mean = centre(None, &ring);
        let found = centre(Some(&interpolant), &ring);
        let value = |place| interpolant.gradient(place).1.abs();
        assert!(value(found) <= value(mean), "{cell:?}");
        assert!(found.iter().all(|c| (CLEARANCE..=1.0 - CLEARANCE).contains(c)), "{found:?}");
    }
}

#[test]
fn the_gradient_is_that_of_the_interpolant() {
    let mut chance = Chance(7);
    for _ in 0..100 {
        let interpolant = Interpolant::new(&cell(std::array::from_fn(|_| chance.next()))).unwrap();
        let place = [0, 1, 2].map(|_| 0.5 + 0.5 * chance.next());
        let (gradient, value) = interpolant.gradient(place);
        let sum: f64 = (0..8)
            .map(|k| {
                let weight = |axis: usize| match k >> axis & 1 {
                    1 => place[axis],
                    _ => 1.0 - place[axis],
                };
                interpolant.values[k] * weight(0) * weight(1) * weight(2)
            })
            .sum();
        assert!((value - sum).abs() < 1e-12);
        for axis in 0..3 {
            let mut ends = [place; 2];
            (ends[0][axis], ends[1][axis]) = (0.0, 1.0);
            let [low, high] = ends.map(|end| interpolant.gradient(end).1);
            assert!((gradient[axis] - (high - low)).abs() < 1e-12, "axis {axis}");
        }
    }
}
