//! Where the polynomial through four or six samples in a line crosses the edge in their middle.
//!
//! With `s` from −½ to ½ along the edge, u = s² and `straight` where linear interpolation crosses it, the
//! polynomial less the isovalue, over the difference of the ends, is
//!
//! ```text
//! F(s) = (s − straight) + (u − ¼) (A(u) + s B(u))
//! ```
//!
//! where A comes from the even parts of the samples and B from the odd ones, both by Newton's divided
//! differences in u. So the ends are kept exactly: F has there the signs that the samples have, and a
//! root is between them. Samples on a straight line give A = B = 0 and the crossing of linear
//! interpolation, to 10⁻¹³ of the edge (for f32 coordinates, 2⁻²²). From the other end s and A change their signs and nothing else, and so
//! does the root, bit for bit.
//!
//! Between samples of noise or of a step a polynomial rings: it turns, and bends back. It is taken only
//! where it rises or falls all along the edge, or bends one way all along it, as a smooth field does that
//! the edge touches. Either has one root there. Elsewhere there is no curve, and the caller keeps to the
//! straight line. To ask for the first alone would cost an order: of the vertices of a smooth surface so
//! many lie on edges along it that their errors, O(h²), would make O(h³) of the root mean square.
//!
//! Nearly all roots are found the short way (`short.rs`), which `lanes` goes with many edges at once. It knows when it
//! fails; then there is the sure way, which is here.

mod short;

use isokit_lanes::Coordinate;
use short::short;

/// Steps after which a root is taken as it is. Before, the bracket is down to nothing.
const STEPS: usize = 96;

/// A step of Halley's so short ends the search: 2⁻²⁰ of an edge. What is left falls with its cube, to
/// nothing; also where the slope is small beside the bend, and the factor before the cube is large.
const SHORT: f64 = 1.0 / (1_u64 << 20) as f64;

/// And one so short if it halves the bracket.
const SHORTEST: f64 = 1.0 / (1_u64 << 42) as f64;

/// Where the polynomial through four or six values, less the isovalue and one step apart, crosses the edge between
/// the two in the middle; where it rings there, where the straight line does. None if the short way does not lead
/// there and there is no curve. At a sample that is the isovalue that is the sample. `straight` is where linear
/// interpolation crosses.
pub(super) fn crossing<C: Coordinate>(values: &[f64], straight: f64) -> Option<f64> {
    let found = match values.len() {
        4 => short::<C, 2>(values),
        _ => short::<C, 3>(values),
    };
    found.or_else(|| Some(Curve::through(values)?.crossing(straight)))
}

/// A polynomial of degree three or five that does not ring on the edge.
#[derive(Clone, Copy, Debug)]
struct Curve {
    /// The coefficients of A: constant, and of u − 9/4.
    even: [f64; 2],
    /// Those of B.
    odd: [f64; 2],
}

impl Curve {
    /// Through four or six values one step apart, where the edge is between the two in the middle. None
    /// where it rings there, or is not finite.
    fn through(values: &[f64]) -> Option<Self> {
        let pairs = values.len() / 2;
        let low = |pair: usize| values[pairs - 1 - pair];
        let high = |pair: usize| values[pairs + pair];
        // Twice the divided differences of the even parts, and of the odd parts over s, at u = 1/4, 9/4 and
        // 25/4, where the even parts are twice themselves too. Three or five times a number by a third or a
        // fifth is the number.
        let even = |pair: usize| low(pair) + high(pair);
        let odd = |pair: usize| (high(pair) - low(pair)) * (1.0 / (2 * pair + 1) as f64);
        let scale = 0.25 / odd(0);
        let divided = |part: &dyn Fn(usize) -> f64, scale: f64| {
            let first = part(1) - part(0);
            let second = match pairs {
                2 => 0.0,
                _ => ((part(2) - part(1)) * 0.5 - first) / 6.0,
            };
            [first * scale, second * scale]
        };
        let curve = Self { even: divided(&even, scale), odd: divided(&odd, scale + scale) };
        curve.is_plain().then_some(curve)
    }

    /// Whether it is monotone on the edge, or convex or concave. For a cubic the answer is exact but for
    /// rounding to f32; else Bernstein coefficients on both halves of the edge give it, or say no.
    fn is_plain(&self) -> bool {
        let ([a, a_u], [b, b_u]) = (self.even, self.odd);
        if !(a.is_finite() && a_u.is_finite() && b.is_finite() && b_u.is_finite()) {
            return false;
        }
        if a_u == 0.0 && b_u == 0.0 {
            // The derivative is (1 − b/4) + 2a s + 3b s². If that turns on the edge, at its least or
            // greatest, both it and the ends count.
            let (a, b) = (a as f32, b as f32);
            let turns = 2.0 * a.abs() < 3.0 * b.abs();
            let rises =
                a.abs() <= 1.0 + 0.5 * b && (b < 0.0 || a * a <= 3.0 * b * (1.0 - 0.25 * b));
            return a.is_finite() && b.is_finite() && (!turns || rises);
        }
        // The derivative's coefficients at s = x/2, from those of u in place of u − 9/4.
        let (a, b) = (a - 2.25 * a_u, b - 2.25 * b_u);
        let (c0, c1) = (1.0 - 0.25 * b, a - 0.25 * a_u);
        let (c2, c3, c4) = (0.75 * (b - 0.25 * b_u), 0.5 * a_u, 0.3125 * b_u);
        // Odd powers change their sign from one half to the other.
        let rises = [1.0, -1.0].into_iter().all(|side| {
            let (c1, c3) = (side * c1, side * c3);
            let all = [
                c0,
                c0 + 0.25 * c1,
                c0 + (0.5 * c1 + c2 / 6.0),
                c0 + (0.75 * c1 + (0.5 * c2 + 0.25 * c3)),
                c0 + (c1 + c2 + c3 + c4),
            ];
            all.into_iter().all(|coefficient| coefficient >= 0.0)
        });
        let bends = |way: f64| {
            [1.0, -1.0].into_iter().all(|side| {
                let (c1, c2, c3, c4) = (way * c1, way * side * c2, way * c3, way * side * c4);
                let second = c1 + (4.0 / 3.0 * c2 + c3);
                let all = [c1, c1 + 2.0 / 3.0 * c2, second, c1 + (2.0 * c2 + 3.0 * c3 + 4.0 * c4)];
                all.into_iter().all(|coefficient| coefficient >= 0.0)
            })
        };
        rises || bends(1.0) || bends(-1.0)
    }

    /// F, its derivative, and half of its second derivative.
    fn at(&self, s: f64, straight: f64) -> [f64; 3] {
        let u = s * s;
        let (v, edge, twice) = (u - 2.25, u - 0.25, 2.0 * s);
        let ([a, a_u], [b, b_u]) = (self.even, self.odd);
        let (even, odd) = (a + v * a_u, b + v * b_u);
        let both = even + s * odd;
        // The derivative of A + s B, and half of its second.
        let (steep, bend) = (odd + twice * (a_u + s * b_u), a_u + 3.0 * s * b_u);
        [
            (s - straight) + edge * both,
            1.0 + twice * both + edge * steep,
            both + twice * steep + edge * bend,
        ]
    }

    /// Where it is 0.
    fn crossing(&self, straight: f64) -> f64 {
        if straight.abs() >= 0.5 { straight } else { self.search(straight) }
    }

    /// The sure way: Halley's method in a bracket, which is halved where a step would leave it, is no eighth
    /// of the step before (Press et al. 2007, sections 9.2 and 9.4), or is short since the slope is small, far
    /// from a root.
    fn search(&self, straight: f64) -> f64 {
        let (mut low, mut high) = (-0.5_f64, 0.5_f64);
        let (mut s, mut last) = (straight, 4.0_f64);
        for _ in 0..STEPS {
            let [value, slope, bend] = self.at(s, straight);
            low = if value <= 0.0 { s } else { low };
            high = if value >= 0.0 { s } else { high };
            let (steep, pull) = (slope * slope, value * bend);
            let next = s - value * slope / (steep - pull);
            let is_good = next >= low
                && next <= high
                && 8.0 * (next - s).abs() <= last
                && pull.abs() <= 0.5 * steep;
            let next = if is_good { next } else { (low + high) * 0.5 };
            last = (next - s).abs();
            s = next;
            if last <= if is_good { SHORT } else { SHORTEST } {
                break;
            }
        }
        s
    }
}

#[cfg(test)]
mod tests {
    use super::{Curve, crossing, short};
    use crate::vertex::delta;
    use isokit_volume::line;
    use proptest::prelude::*;

    /// The two in the middle, less the isovalue, and where linear interpolation crosses.
    fn straight(values: &[f64]) -> f64 {
        let middle = values.len() / 2;
        delta([Some(values[middle - 1]), Some(values[middle])], 0.0)
    }

    fn is_cut(values: &[f64]) -> bool {
        let middle = values.len() / 2;
        (values[middle - 1] >= 0.0) != (values[middle] >= 0.0)
    }

    fn found(values: &[f64]) -> f64 {
        crossing::<f64>(values, straight(values)).unwrap_or(straight(values))
    }

    /// On the edge, at a root or, if there may be no curve, where the straight line is crossed, and the same from
    /// the other end. Whether it is a curve's.
    fn check(values: &[f64]) -> bool {
        if !is_cut(values) {
            return false;
        }
        let mut back = values.to_vec();
        back.reverse();
        let (s, other) = (found(values), found(&back));
        assert!(s.abs() <= 0.5, "{values:?}: {s}");
        assert!(s.to_bits() == (-other).to_bits() || s == 0.0, "{values:?}: {s} and {other}");
        if values[values.len() / 2 - 1] == 0.0 || values[values.len() / 2] == 0.0 {
            assert_eq!(s, straight(values), "at the sample that is the isovalue");
            return true;
        }
        let is_straight = (s - straight(values)).abs() < 1e-13;
        let most = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        // Of a quintic the answer may hang on what is rounded.
        let is_plain = values.len() == 4
            && Curve::through(values).is_some()
            && is_seen_plain(values, 0.51, 1e-5 * most);
        if is_straight && !is_plain {
            return false;
        }
        // The sign changes around the root, as far as rounding lets one see.
        let middle = values.len() / 2;
        let sign = (values[middle] - values[middle - 1]).signum();
        let at = |s: f64| line::between(values, s.clamp(-0.5, 0.5)) * sign;
        let (before, after) = (at(s - 1e-11), at(s + 1e-11));
        let unseen = 64.0 * f64::EPSILON * most;
        assert!(before <= unseen && after >= -unseen, "{values:?}: {before:e}, {after:e} at {s}");
        true
    }

    /// Whether the polynomial, seen at many places as far from the middle as `reach`, only rises or falls, or
    /// bends one way only; clearly so, if `margin` is positive.
    fn is_seen_plain(values: &[f64], reach: f64, margin: f64) -> bool {
        let at = |n: i32| line::between(values, reach * (f64::from(n) / 128.0 - 1.0));
        let slopes: Vec<f64> = (0..256).map(|n| at(n + 1) - at(n)).collect();
        let bends: Vec<f64> = slopes.windows(2).map(|two| two[1] - two[0]).collect();
        let one_sign = |all: &[f64], margin: f64| {
            all.iter().all(|&part| part >= margin) || all.iter().all(|&part| part <= -margin)
        };
        one_sign(&slopes, margin) || one_sign(&bends, margin.min(0.0))
    }

    fn sample() -> impl Strategy<Value = f64> {
        prop_oneof![-1.0..1.0_f64, (-3..=3).prop_map(f64::from), (-300..300).prop_map(f64::from)]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]
        #[test]
        fn a_crossing_is_a_root_on_its_edge_and_the_same_from_both_ends(
            values in prop::collection::vec(sample(), 6), rise in 0.0..30.0_f64, curve in -0.4..0.4_f64
        ) {
            check(&values);
            check(&values[1..5]);
            // Along a slope more of it is monotone.
            let place = |n: usize| n as f64 - 2.3;
            let sloped: Vec<f64> = (0..6)
                .map(|n| values[n] / 300.0 + rise * place(n) + curve * rise * place(n).powi(2)).collect();
            check(&sloped);
            check(&sloped[1..5]);
        }

        #[test]
        fn what_is_taken_does_not_ring_and_a_cubic_that_does_not_is_taken(
            values in prop::collection::vec(sample(), 6)
        ) {
            for values in [&values[..], &values[1..5]] {
                if !is_cut(values) {
                    continue;
                }
                let taken = Curve::through(values).is_some();
                prop_assert!(!taken || is_seen_plain(values, 0.5, -1e-11), "{values:?} rings");
                // What is so a little farther out, and not all but flat, is beyond a doubt.
                let most = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
                let is_plain = values.len() == 4 && is_seen_plain(values, 0.51, 1e-5 * most);
                prop_assert!(taken || !is_plain, "{values:?} does not");
            }
        }
    }

    #[test]
    fn a_straight_line_is_crossed_where_it_is_straight() {
        for first in -40..0 {
            for rise in [1.0, 7.0, 19.0, 40.0] {
                let values: Vec<f64> = (0..6).map(|n| f64::from(first) + rise * n as f64).collect();
                for values in [&values[..], &values[1..5]] {
                    if is_cut(values) {
                        assert!((found(values) - straight(values)).abs() < 1e-13);
                    }
                }
            }
        }
    }

    #[test]
    fn a_polynomial_of_its_degree_is_crossed_at_its_root() {
        for n in -49..=49 {
            let root = f64::from(n) / 100.0;
            let cubic = |x: f64| (x - root) * (3.0 + 0.4 * x + x * x);
            let quintic = |x: f64| (x - root) * (9.0 + 0.4 * x + x * x + 0.3 * x.powi(4));
            let four = [-1.5, -0.5, 0.5, 1.5].map(cubic);
            let six = [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5].map(quintic);
            for values in [&four[..], &six[..]] {
                assert!(check(values));
                let found = found(values);
                assert!((found - root).abs() < 1e-13, "{found}, {root}");
            }
        }
    }

    #[test]
    fn where_it_is_flat_at_its_root_the_bracket_finds_it() {
        // All but a cube of s: Newton alone comes nearer by a third at a time.
        for iso in [0.0, 1e-9, -1e-5, 1e-3, 0.9, -1.0 + 1e-12] {
            let cube = |x: f64| 8.0 * x.powi(3) + 1e-6 * x;
            let values = [-1.5, -0.5, 0.5, 1.5].map(|x| cube(x) - iso);
            let found = found(&values);
            assert!((cube(found) - iso).abs() < 1e-11, "{found} for {iso}");
        }
    }

    #[test]
    fn a_power_of_two_changes_no_bit() {
        let lines = [[-7.0, -5.5, -2.0, 1.25, 3.0, 9.5], [3.0, 1.0, -0.5, 4.0, 30.0, 31.0]];
        for values in lines.iter().flat_map(|line| [&line[..], &line[1..5]]) {
            let expected = found(values);
            for exponent in [-1000, -300, -140, -61, -60, -1, 1, 59, 60, 120, 140, 500, 1000] {
                let scaled: Vec<_> =
                    values.iter().map(|value| value * 2_f64.powi(exponent)).collect();
                assert_eq!(
                    found(&scaled).to_bits(),
                    expected.to_bits(),
                    "2^{exponent}: {values:?}"
                );
            }
        }
    }

    #[test]
    fn the_short_way_misses_few_of_smooth_lines_and_of_noise() {
        let mut state = 3_u64;
        let mut chance = || {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for roughness in [1.0, 0.1] {
            let (mut cut, mut missed) = (0, [0; 4]);
            while cut < 200_000 {
                let slope = 2.0 * chance() - 1.0;
                let shift = chance() - 0.5;
                let mut values = [0.0; 6];
                for (n, value) in values.iter_mut().enumerate() {
                    *value = slope * (n as f64 - 2.5 + shift) + roughness * (chance() - 0.5);
                }
                if is_cut(&values) {
                    cut += 1;
                    missed[0] += usize::from(short::<f64, 2>(&values[1..5]).is_none());
                    missed[1] += usize::from(short::<f64, 3>(&values).is_none());
                    missed[2] += usize::from(short::<f32, 2>(&values[1..5]).is_none());
                    missed[3] += usize::from(short::<f32, 3>(&values).is_none());
                }
            }
            // For f32, which no correction follows, more is asked of the last step.
            let most = [1000, 1000, 500, 500].map(|share| cut / share);
            assert!((0..4).all(|way| missed[way] < most[way]), "{missed:?} of {cut}");
        }
    }

    #[test]
    fn a_search_that_begins_where_the_slope_is_zero_goes_on() {
        assert!(check(&[-40.0, 2.0, -2.0, -148.0]));
        assert!(check(&[148.0, 2.0, -2.0, 40.0]));
    }

    #[test]
    fn an_edge_whose_curve_starts_steep_and_ends_gentle_is_crossed_as_exactly() {
        // A slope told from before the last step, in place of that at its end, is not good enough here.
        let (first, after) = (0.272_912_264_485_070_94, -0.228_746_377_004_066_75);
        assert!(check(&[212.0, first, 65.0, after, 117.0, 83.0]));
    }

    #[test]
    fn what_is_not_finite_or_rings_has_no_curve() {
        for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for n in 0..6 {
                let mut values = [-5.0, -3.0, -1.0, 1.0, 3.0, 5.0];
                values[n] = odd;
                assert!(Curve::through(&values).is_none());
            }
        }
        assert!(Curve::through(&[-f64::MAX, -f64::MAX, f64::MAX, f64::MAX]).is_none());
        assert!(Curve::through(&[9.0, -1.0, 1.0, -12.0]).is_none(), "it dips, rises and dips");
        assert!(Curve::through(&[9.0, -1.0, 1.0, 9.0]).is_some(), "it dips and bends up");
        assert!(Curve::through(&[0.0, 0.0, 255.0, 255.0]).is_some(), "a step");
    }
}
