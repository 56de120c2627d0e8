//! The short way to where a polynomial crosses its edge: no loop ends sooner for one edge than for another.
//!
//! The polynomial is not made one of rise 1 in f64: that would take divisions of f64. In f32 it is; there its root is
//! found but for what f32 rounds, and in f64 it is corrected by what the polynomial of the values themselves is
//! there, over a slope in f32. That leaves as much of the error as the slope is wrong, a few millionths. That the
//! correction is small says that all went well; it is not for fewer than one in a thousand, near to where a
//! polynomial is flat at its root.
//!
//! For coordinates of f32 the values are rounded to it, and the root in f32 is the root: 2⁻¹⁸ of an edge from that for f64 at
//! the most, and 2⁻²⁴ in the root mean square on smooth lines; an f32 is itself rounded by up to 2⁻¹⁸ at 64 edges from the
//! origin. One in five hundred, at the most, is not sure to be found so. The two types may differ on whether a polynomial
//! rings that hardly does, or all but does.
//!
//! From the other end the same numbers come out, with other signs.

use crate::vertex::{curved::MOST, to_unit};
use isokit_lanes::Coordinate;
use std::ops::Range;

/// The rises of which no f32 that counts overflows or loses a digit: 2⁻⁶⁰ to 2⁶⁰.
const TAME: Range<f32> = 8.673_617_4e-19..1.152_921_5e18;

/// If the correction is so small, a root is found.
const SMALL: f64 = 1.0 / (1_u64 << 21) as f64;

/// Where no correction follows, the last step is no longer: with its cube, and a third derivative of 24 over that slope, what
/// is left falls to 2⁻²².
const SHORT: f32 = 1.0 / 512.0;

/// And no more of it is due to the bend, whose square counts: that leaves 2⁻²³.
const BENT: f32 = 1.0 / 128.0;

/// And the slope is no less, over the rise: what f32 rounds of the value, five halves of a unit at 1, moves the root less
/// than 2⁻¹⁹.
const STEEP: f32 = 1.0 / 8.0;

/// Where the polynomial through two times `PAIRS` values crosses the edge in their middle; where it rings there,
/// where the straight line does; for coordinates of a type. None where that is not sure to be found.
pub(super) fn short<C: Coordinate, const PAIRS: usize>(values: &[f64]) -> Option<f64> {
    if is_tame::<C>(values) {
        return of_tame::<C, PAIRS>(values);
    }
    let values = tamed(values)?;
    let values = &values[..2 * PAIRS];
    is_tame::<C>(values).then(|| of_tame::<C, PAIRS>(values))?
}

/// Whether the rise of the edge in the middle is tame.
fn is_tame<C: Coordinate>(values: &[f64]) -> bool {
    let middle = values.len() / 2;
    let rise: f64 = (C::round(values[middle]) - C::round(values[middle - 1])).into();
    TAME.contains(&(rise as f32).abs())
}

/// The same, of values whose rise is tame.
fn of_tame<C: Coordinate, const PAIRS: usize>(values: &[f64]) -> Option<f64> {
    let low = |pair: usize| C::round(values[PAIRS - 1 - pair]);
    let high = |pair: usize| C::round(values[PAIRS + pair]);
    let (sum, rise) = (low(0) + high(0), high(0) - low(0));
    let to_f32 = |number: C| number.into() as f32;
    let (even, odd) = parts::<C, PAIRS>(low, high);
    let scale = 1.0 / to_f32(rise);
    let straight = to_f32(sum) * scale * -0.5;
    let scaled = |parts: [C; 2]| parts.map(|part| to_f32(part) * scale);
    let (a, b, zero) = (low(0), high(0), C::default());
    if !(a < zero && zero < b || b < zero && zero < a) {
        // At a sample that is the isovalue that is the sample.
        return Some(if straight < 0.0 { -0.5 } else { 0.5 });
    }
    let mut narrow = Narrow::new::<PAIRS>(straight, scaled(even), scaled(odd));
    let is_plain = narrow.is_plain::<PAIRS>();
    if !is_plain {
        narrow = Narrow { fall: straight, c: [1.0, 0.0, 0.0, 0.0, 0.0] };
    }
    if !C::IS_DOUBLE {
        return narrow.root::<PAIRS>().map(f64::from);
    }
    let (s, factor, is_good) = narrow.near_root::<PAIRS>();
    let (s, factor) = (f64::from(s), f64::from(factor * scale));
    let square = s * s;
    let [a, a_u, b, b_u] = match is_plain {
        true => [even[0], even[1], odd[0], odd[1]].map(C::into),
        false => [0.0; 4],
    };
    let (mut a, mut b) = (a, b);
    if PAIRS == 3 {
        let v = square - 2.25;
        (a, b) = (a + v * a_u, b + v * b_u);
    }
    let value = (s * rise.into() + sum.into() * 0.5) + (square - 0.25) * (a + s * b);
    let step = value * factor;
    let s = s - step;
    (is_good && step.abs() < SMALL && s.abs() <= 0.5).then_some(s)
}

/// Values times the power of two by which their rise is tame; a field has the same surface at any scale, to the last
/// bit. None if there is no such power.
fn tamed(values: &[f64]) -> Option<[f64; MOST]> {
    let middle = values.len() / 2;
    let rise = (values[middle] - values[middle - 1]).abs();
    let scale = to_unit(rise);
    let is_finite = (rise * scale).is_finite() && rise > 0.0;
    is_finite.then(|| std::array::from_fn(|n| values.get(n).map_or(0.0, |value| value * scale)))
}

/// What `Curve` has, times the rise.
fn parts<C: Coordinate, const PAIRS: usize>(
    low: impl Fn(usize) -> C,
    high: impl Fn(usize) -> C,
) -> ([C; 2], [C; 2]) {
    let (number, zero) = (|number: f64| C::round(number), C::default());
    let even = |pair: usize| low(pair) + high(pair);
    let odd = |pair: usize| (high(pair) - low(pair)) * number(1.0 / (2 * pair + 1) as f64);
    let (a, b) = (even(1) - even(0), odd(1) - (high(0) - low(0)));
    if PAIRS == 2 {
        return ([a * number(0.25), zero], [b * number(0.5), zero]);
    }
    let half = number(0.5);
    let (a_u, b_u) = ((even(2) - even(1)) * half - a, (odd(2) - odd(1)) * half - b);
    ([a * number(0.25), a_u * number(1.0 / 24.0)], [b * half, b_u * number(1.0 / 12.0)])
}

/// The polynomial over its rise, in f32: c₁s + c₂s² + … + c₅s⁵ − fall.
struct Narrow {
    fall: f32,
    c: [f32; 5],
}

impl Narrow {
    fn new<const PAIRS: usize>(straight: f32, [a, a_u]: [f32; 2], [b, b_u]: [f32; 2]) -> Self {
        if PAIRS == 2 {
            let c = [1.0 - 0.25 * b, a, b, 0.0, 0.0];
            return Self { fall: straight + 0.25 * a, c };
        }
        // From powers of u − 9/4 to those of u.
        let (a, b) = (a - 2.25 * a_u, b - 2.25 * b_u);
        let c = [1.0 - 0.25 * b, a - 0.25 * a_u, b - 0.25 * b_u, a_u, b_u];
        Self { fall: straight + 0.25 * a, c }
    }

    /// Whether it is monotone on the edge, or convex or concave: of a cubic exactly, but for rounding; of a quintic
    /// by Bernstein coefficients on both halves of the edge, which may also say no where it is.
    fn is_plain<const PAIRS: usize>(&self) -> bool {
        let [c1, c2, c3, c4, c5] = self.c;
        if PAIRS == 2 {
            // If the derivative turns on the edge, at its least or greatest, both it and the ends count.
            let (twice, thrice) = (c2 + c2, 3.0 * c3);
            let turns = twice.abs() < thrice.abs();
            let ends_rise = c2.abs() <= 1.0 + 0.5 * c3;
            let rises = c3 < 0.0 || c2 * c2 <= thrice * c1;
            return !turns || (ends_rise && rises);
        }
        // The derivative's coefficients at s = x/2; odd powers change their sign from one half to the other.
        let (d1, d2, d3, d4) = (c2, 0.75 * c3, 0.5 * c4, 0.3125 * c5);
        let third = 1.0 / 3.0;
        let both = |even: f32, odd: f32| (even - odd.abs(), even + odd.abs());
        let rising = [
            both(c1, 0.25 * d1).0,
            both(c1 + d2 * (1.0 / 6.0), 0.5 * d1).0,
            both(c1 + 0.5 * d2, 0.75 * d1 + 0.25 * d3).0,
            both(c1 + (d2 + d4), d1 + d3).0,
        ];
        let bending = [
            both(d1, (third + third) * d2),
            both(d1 + d3, (1.0 + third) * d2),
            both(d1 + 3.0 * d3, (d2 + d2) + 4.0 * d4),
        ];
        !rising.into_iter().any(|least| least < 0.0)
            || !bending.into_iter().any(|(least, _)| least < 0.0)
            || !bending.into_iter().any(|(_, most)| most > 0.0)
    }

    /// The root, by two steps of Halley's, as well as f32 lets it be found.
    fn root<const PAIRS: usize>(&self) -> Option<f32> {
        let s = self.after_a_step::<PAIRS>();
        let [value, slope, bend] = self.at::<PAIRS>(s);
        let (steep, pull) = (slope * slope, value * bend);
        let step = value * (slope / (steep - pull));
        let s = s - step;
        // What is left falls with the cube of the step, and with the square of how much it turned.
        let is_short = step.abs() < SHORT && pull.abs() < BENT * steep;
        (is_short && slope > STEEP && s.abs() <= 0.5).then_some(s)
    }

    /// Where one step of Halley's leads from the root of a parabola.
    fn after_a_step<const PAIRS: usize>(&self) -> f32 {
        let s = self.of_parabola::<PAIRS>();
        let [value, slope, bend] = self.at::<PAIRS>(s);
        s - value * (slope / (slope * slope - value * bend))
    }

    /// A place near to the root, by another, one over the slope there, and whether that is fit to be used.
    fn near_root<const PAIRS: usize>(&self) -> (f32, f32, bool) {
        let s = self.after_a_step::<PAIRS>();
        let [value, slope, bend] = self.at::<PAIRS>(s);
        let factor = slope / (slope * slope - value * bend);
        let s = s - value * factor;
        let [_, slope, _] = self.at::<PAIRS>(s);
        // At the root between the ends it rises, and on a short step it turns little.
        let is_good = slope > 0.0 && (1.0 - slope * factor).abs() < 1.0 / 32.0;
        (s, 1.0 / slope, is_good)
    }

    /// The root of a parabola that is near. With x from −1 to 1 on the edge, s³ is 3 s / 16 but for a 32nd, s⁴ is
    /// s²/4 − 1/128 but for as little, and s⁵ is 5 s / 128 (Chebyshev).
    fn of_parabola<const PAIRS: usize>(&self) -> f32 {
        let [c1, c2, c3, c4, c5] = self.c;
        let (mut fall, mut second, mut first) = (self.fall, c2, c1 + 0.1875 * c3);
        if PAIRS == 3 {
            fall += 0.0078125 * c4;
            second += 0.25 * c4;
            first += 0.0390625 * c5;
        }
        // The form of the quadratic formula in which nothing cancels. Any root will do where there is none.
        let square = first * first + 4.0 * second * fall;
        let square = if square > 0.0 { square } else { 0.0 };
        (fall + fall) / (first + square.sqrt())
    }

    /// The value, the slope, and half of the second derivative, by Horner's rule.
    fn at<const PAIRS: usize>(&self, s: f32) -> [f32; 3] {
        let [c1, c2, c3, c4, c5] = self.c;
        if PAIRS == 2 {
            let third = c3 * s;
            let first = third + c2;
            let second = first * s + c1;
            let steep = first + third;
            return [second * s - self.fall, steep * s + second, third + steep];
        }
        let fifth = c5 * s;
        let b4 = fifth + c4;
        let (b3, d3) = (b4 * s + c3, fifth + b4);
        let (b2, d2, e2) = (b3 * s + c2, d3 * s + b3, fifth + d3);
        let (b1, d1, e1) = (b2 * s + c1, d2 * s + b2, e2 * s + d2);
        [b1 * s - self.fall, d1 * s + b1, e1 * s + d1]
    }
}

#[cfg(test)]
mod tests {
    use super::short;
    use crate::vertex::{curve::Curve, delta};
    use proptest::prelude::*;

    /// Of smooth lines, of such as are flat near their root, of noise, and of whole numbers that tie.
    fn line() -> impl Strategy<Value = Vec<f64>> {
        let smooth = (-9.0..9.0_f64, -0.5..0.5_f64, prop::collection::vec(-1.0..1.0_f64, 6))
            .prop_map(|(rise, middle, noise)| {
                let place = |n: usize| n as f64 - 2.5 - middle;
                (0..6).map(|n| rise * place(n) + noise[n]).collect()
            });
        let flat = (-0.5..0.5_f64, -0.1..0.1_f64, 0.01..1.0_f64, -1.0..1.0_f64, 0.5..6.0_f64)
            .prop_map(|(root, off, slope, bend, third)| {
                let at = |x: f64| x * (slope + bend * off * x + third * x * x);
                let place = |n: usize| n as f64 - 2.5 - root;
                (0..6).map(|n| at(place(n)) - at(off)).collect::<Vec<f64>>()
            });
        let tied = prop::collection::vec((-4..=4).prop_map(f64::from), 6);
        prop_oneof![smooth, flat, tied, prop::collection::vec(-1.0..1.0_f64, 6)]
    }

    /// The root for f32, if both ways find one, and that for f64.
    fn both<const PAIRS: usize>(values: &[f64]) -> Option<[f64; 2]> {
        let is_cut = (values[PAIRS - 1] >= 0.0) != (values[PAIRS] >= 0.0);
        let rounded = short::<f32, PAIRS>(values)?;
        is_cut.then_some([rounded, short::<f64, PAIRS>(values)?])
    }

    /// Whether the smallest change of the outer values decides that there is a curve.
    fn is_on_the_edge<const PAIRS: usize>(values: &[f64]) -> bool {
        let changed = |n: usize, by: f64| {
            let mut changed = values.to_vec();
            changed[n] += by * (values[PAIRS] - values[PAIRS - 1]);
            Curve::through(&changed).is_some()
        };
        let others = (0..2 * PAIRS).filter(|&n| n + 1 < PAIRS || n > PAIRS);
        let all: Vec<bool> = others.flat_map(|n| [changed(n, 1e-6), changed(n, -1e-6)]).collect();
        all.iter().any(|&is_curve| is_curve != all[0])
    }

    fn check<const PAIRS: usize>(values: &[f64]) -> Result<(), TestCaseError> {
        let Some([rounded, exact]) = both::<PAIRS>(values) else { return Ok(()) };
        prop_assert!(rounded.abs() <= 0.5 && rounded == f64::from(rounded as f32));
        let is_near = |a: f64, b: f64| (a - b).abs() <= 1.0 / f64::from(1 << 18);
        // A curve that all but rings, or hardly, is taken for one type and may not be for the other.
        let straight = delta([Some(values[PAIRS - 1]), Some(values[PAIRS])], 0.0);
        let is_one_straight = is_near(rounded, straight) || is_near(exact, straight);
        prop_assert!(
            is_near(rounded, exact) || is_on_the_edge::<PAIRS>(values) && is_one_straight,
            "{values:?}: {rounded}, {exact}"
        );
        let back: Vec<f64> = values.iter().rev().copied().collect();
        let Some([other, _]) = both::<PAIRS>(&back) else {
            return Err(TestCaseError::fail("none from the other end"));
        };
        prop_assert!(other.to_bits() == (-rounded).to_bits() || rounded == 0.0);
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn a_root_for_f32_is_that_for_f64_to_a_small_part_of_the_edge_and_the_same_from_both_ends(
            values in line()
        ) {
            check::<2>(&values[1..5])?;
            check::<3>(&values)?;
        }
    }

    #[test]
    fn where_it_is_flat_near_its_root_a_root_for_f32_is_as_near_or_is_not_found() {
        for scale in [1.0, -3.0, 0.1] {
            let line = [-14.2063097, -0.7088809, 0.2908599, 10.5129128].map(|value| scale * value);
            check::<2>(&line).unwrap();
        }
    }

    #[test]
    fn a_power_of_two_changes_no_bit_for_f32() {
        let tiny = -2_f64.powi(-33);
        let lines = [[-7.0, -5.5, -2.0, 1.25, 3.0, 9.5], [3.0, 9.0, tiny, 1.0, 9.0, 20.0]];
        for (line, exponent) in lines.iter().flat_map(|line| (-1000..=1000).map(move |n| (line, n)))
        {
            let scaled = line.map(|value| value * 2_f64.powi(exponent));
            assert_eq!(
                short::<f32, 2>(&scaled[1..5]),
                short::<f32, 2>(&line[1..5]),
                "2^{exponent}"
            );
            assert_eq!(short::<f32, 3>(&scaled), short::<f32, 3>(line), "2^{exponent}");
        }
    }

    #[test]
    fn a_straight_line_is_crossed_where_it_is_straight_to_what_f32_tells_apart() {
        for (first, rise) in (1..400).flat_map(|n| (1..40).map(move |rise| (n, f64::from(rise)))) {
            let middle = f64::from(first % (rise as i32)) / rise - 0.5;
            let values: Vec<f64> = (0..6).map(|n| rise * (f64::from(n) - 2.5 - middle)).collect();
            let straight = delta([Some(values[2]), Some(values[3])], 0.0);
            for found in [short::<f32, 2>(&values[1..5]), short::<f32, 3>(&values)] {
                let found = found.expect("straight lines have roots");
                assert!(
                    (found - straight).abs() <= 1.0 / f64::from(1 << 22),
                    "{values:?}: {found}"
                );
            }
        }
    }

    #[test]
    fn roots_for_f32_are_mostly_as_near_as_f32_can_tell() {
        let (mut squares, mut count) = (0.0, 0);
        for n in 0..2_000 {
            let (root, bend) = (f64::from(n % 97) / 98.0 - 0.49, f64::from(n % 31) / 31.0 - 0.5);
            let at = |x: f64| (x - root) * (7.0 + bend * x + 0.3 * x * x);
            let values: Vec<f64> = (0..6).map(|n| at(f64::from(n) - 2.5)).collect();
            for found in [both::<2>(&values[1..5]), both::<3>(&values)] {
                let [rounded, exact] = found.expect("smooth lines have roots");
                squares += (rounded - exact).powi(2);
                count += 1;
            }
        }
        let error = (squares / f64::from(count)).sqrt();
        assert!(error < 0.5 * f64::from(f32::EPSILON), "{error:e}");
    }
}
