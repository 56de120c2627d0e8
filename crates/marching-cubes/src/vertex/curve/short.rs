//! The short way to where a polynomial crosses its edge: no loop ends sooner for one edge than for another.
//!
//! The polynomial is not made one of rise 1 in f64: that would take divisions of f64. In f32 it is; there its root is
//! found but for what f32 rounds, and in f64 it is corrected by what the polynomial of the values themselves is
//! there, over a slope in f32. That leaves as much of the error as the slope is wrong, a few millionths. That the
//! correction is small says that all went well; it is not for fewer than one in a thousand, near to where a
//! polynomial is flat at its root.
//!
//! From the other end the same numbers come out, with other signs.

use crate::vertex::{curved::MOST, to_unit};
use std::ops::Range;

/// If the correction is so small, a root is found.
const SMALL: f64 = 1.0 / (1_u64 << 21) as f64;

/// The rises of which no f32 that counts overflows or loses a digit: 2⁻⁶⁰ to 2⁶⁰.
const TAME: Range<f32> = 8.673_617_4e-19..1.152_921_5e18;

/// Where the polynomial through two times `PAIRS` values crosses the edge in their middle; where it rings there,
/// where the straight line does. None where that is not sure to be found.
pub(super) fn short<const PAIRS: usize>(values: &[f64]) -> Option<f64> {
    let low = |pair: usize| values[PAIRS - 1 - pair];
    let high = |pair: usize| values[PAIRS + pair];
    let (sum, rise) = (low(0) + high(0), high(0) - low(0));
    let narrow_rise = rise as f32;
    if !TAME.contains(&narrow_rise.abs()) {
        return tamed(values).and_then(|values| short::<PAIRS>(&values[..2 * PAIRS]));
    }
    let (mut even, mut odd) = parts::<PAIRS>(low, high);
    let scale = 1.0 / narrow_rise;
    let straight = sum as f32 * scale * -0.5;
    let scaled = |parts: [f64; 2]| parts.map(|part| part as f32 * scale);
    if low(0) * high(0) >= 0.0 {
        // At a sample that is the isovalue that is the sample.
        return Some(if straight < 0.0 { -0.5 } else { 0.5 });
    }
    let mut narrow = Narrow::new::<PAIRS>(straight, scaled(even), scaled(odd));
    if !narrow.is_plain::<PAIRS>() {
        (even, odd) = ([0.0; 2], [0.0; 2]);
        narrow = Narrow { fall: straight, c: [1.0, 0.0, 0.0, 0.0, 0.0] };
    }
    let (s, factor, is_good) = narrow.root::<PAIRS>();
    let (s, factor) = (f64::from(s), f64::from(factor * scale));
    let square = s * s;
    let (mut a, mut b) = (even[0], odd[0]);
    if PAIRS == 3 {
        let v = square - 2.25;
        (a, b) = (a + v * even[1], b + v * odd[1]);
    }
    let value = (s * rise + sum * 0.5) + (square - 0.25) * (a + s * b);
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
    let is_tame = TAME.contains(&((rise * scale) as f32));
    is_tame.then(|| std::array::from_fn(|n| values.get(n).map_or(0.0, |value| value * scale)))
}

/// What `Curve` has, times the rise.
fn parts<const PAIRS: usize>(
    low: impl Fn(usize) -> f64,
    high: impl Fn(usize) -> f64,
) -> ([f64; 2], [f64; 2]) {
    let even = |pair: usize| low(pair) + high(pair);
    let odd = |pair: usize| (high(pair) - low(pair)) * (1.0 / (2 * pair + 1) as f64);
    let (a, b) = (even(1) - even(0), odd(1) - (high(0) - low(0)));
    if PAIRS == 2 {
        return ([a * 0.25, 0.0], [b * 0.5, 0.0]);
    }
    let (a_u, b_u) = ((even(2) - even(1)) * 0.5 - a, (odd(2) - odd(1)) * 0.5 - b);
    ([a * 0.25, a_u * (1.0 / 24.0)], [b * 0.5, b_u * (1.0 / 12.0)])
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

    /// A place near to the root, one over the slope there, and whether that is fit to be used.
    fn root<const PAIRS: usize>(&self) -> (f32, f32, bool) {
        // Two steps of Halley's.
        let s = self.of_parabola::<PAIRS>();
        let [value, slope, bend] = self.at::<PAIRS>(s);
        let s = s - value * (slope / (slope * slope - value * bend));
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
