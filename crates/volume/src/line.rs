//! Samples on a line of the lattice, and derivatives on it, to a high order.
//!
//! A stencil that leads over the border is one-sided there. That is done by going on: the missing samples
//! are those of the polynomial through the nearest ones, as many as the stencil has, or all where a line
//! has fewer. What is made of them is then what the one-sided stencil of the same order gives, or of the
//! highest order that the line allows. `curves/beyond.rs` of `lanes` does the same for sixteen lines at once, to the same
//! bits, and has the factors. From either border it is the same sum in the same order, so that
//! mirrored volumes keep mirrored bits.

use isokit_lanes::ONE_BEFORE;

/// The most samples of a stencil: those of a difference of order six.
const MOST: usize = 7;

/// The values on a line from index `first` on, as many as there is room for, seven at most. `value` tells
/// them from 0 to `size`; beyond, the line is continued from as many of the nearest, or from all if it has fewer.
#[inline(always)]
pub fn values(out: &mut [f64], first: isize, size: usize, value: impl Fn(usize) -> f64) {
    if first >= 0 && first as usize + out.len() <= size {
        for (n, out) in out.iter_mut().enumerate() {
            *out = value(first as usize + n);
        }
        return;
    }
    continued(out, first, size, value);
}

/// The same where some of the values are beyond the line.
#[cold]
fn continued(out: &mut [f64], first: isize, size: usize, value: impl Fn(usize) -> f64) {
    let held = out.len().min(size);
    // The samples nearest to the stencil, which hold all of it that the line has, and the stencil.
    let base = first.clamp(0, (size - held) as isize);
    let start = first.min(base);
    let mut line = [0.0; 2 * MOST];
    let (low, own) = ((base - start) as usize, (first - start) as usize);
    let (high, end) = (low + held, own + out.len());
    for (n, value_there) in line[low..high].iter_mut().enumerate() {
        *value_there = value(base as usize + n);
    }
    for n in (0..low).rev() {
        line[n] = before(&ONE_BEFORE[held], line[n + 1..=n + held].iter());
    }
    for n in high..end {
        line[n] = before(&ONE_BEFORE[held], line[n - held..n].iter().rev());
    }
    out.copy_from_slice(&line[own..end]);
}

/// The value one step before the first of the polynomial through some, be they samples or told so themselves.
#[inline(always)]
fn before<'v>(factors: &[f64; MOST], values: impl Iterator<Item = &'v f64>) -> f64 {
    factors.iter().zip(values).fold(0.0, |sum, (factor, value)| sum + factor * value)
}

/// The weights of an even number of values around an edge in what the polynomial through all of them is at
/// `s` steps from its middle (Lagrange): of the nearest pair, lower and upper, then of the next.
#[inline(always)]
pub fn weights<const PAIRS: usize>(s: f64) -> [[f64; 2]; PAIRS] {
    let place = |pair: usize| pair as f64 + 0.5;
    std::array::from_fn(|pair| {
        let mut weight = 0.5 / place(pair);
        for other in (0..PAIRS).filter(|&other| other != pair) {
            let (own, other) = (place(pair) * place(pair), place(other) * place(other));
            weight *= (s * s - other) * (1.0 / (own - other));
        }
        [weight * (place(pair) - s), weight * (place(pair) + s)]
    })
}

/// The weights of differences in the derivative `s` steps from the middle of an edge, along any axis: times 12, to
/// order four, from two pairs of samples around the edge; times 60, to order six, from three.
///
/// Central differences to a high order are sums of differences over two steps, four and so on (Fornberg 1988), of
/// which each brings a correction that is smaller by the square of a step. So it need not be known as well between
/// samples: it is interpolated from a pair less than the one before. `[n][pair]` are the weights of the difference
/// from n + 1 steps below to as many above, at the lower and at the upper sample of a pair; a pair less has one for
/// each n more.
#[inline(always)]
pub fn slope_weights<const PAIRS: usize>(s: f64) -> [[[f64; 2]; PAIRS]; PAIRS] {
    const { assert!(PAIRS == 2 || PAIRS == 3, "two pairs or three") };
    let mut sums = [[[0.0; 2]; PAIRS]; PAIRS];
    for (level, shares) in SLOPES[PAIRS - 2][..PAIRS].iter().enumerate() {
        let weights = match PAIRS - level {
            1 => padded(weights::<1>(s)),
            2 => padded(weights::<2>(s)),
            _ => padded(weights::<3>(s)),
        };
        for (sums, share) in sums.iter_mut().zip(shares).take(level + 1) {
            for (sum, weights) in sums.iter_mut().zip(weights).take(PAIRS - level) {
                *sum = [0, 1].map(|side| sum[side] + share * weights[side]);
            }
        }
    }
    sums
}

/// By pairs, less two: of the derivative times 12 or 60 the leading part and each correction, as shares of the
/// differences over two steps, four and six.
const SLOPES: [[[f64; 3]; 3]; 2] = [
    [[6.0, 0.0, 0.0], [2.0, -1.0, 0.0], [0.0; 3]],
    [[30.0, 0.0, 0.0], [10.0, -5.0, 0.0], [5.0, -4.0, 1.0]],
];

#[inline(always)]
fn padded<const PAIRS: usize>(weights: [[f64; 2]; PAIRS]) -> [[f64; 2]; 3] {
    std::array::from_fn(|pair| weights.get(pair).copied().unwrap_or_default())
}

/// The sum of values around an edge by their weights, in pairs, so that a mirror changes no bit.
#[inline(always)]
pub fn mean(values: &[f64], weights: &[[f64; 2]]) -> f64 {
    let pairs = weights.len();
    let pair = |n: usize| values[pairs - 1 - n] * weights[n][0] + values[pairs + n] * weights[n][1];
    (1..pairs).fold(pair(0), |sum, n| sum + pair(n))
}

/// What the polynomial through four or six values around an edge is at `s` steps from its middle.
pub fn between(values: &[f64], s: f64) -> f64 {
    match values.len() {
        4 => mean(values, &weights::<2>(s)),
        _ => mean(values, &weights::<3>(s)),
    }
}

#[cfg(test)]
mod tests {
    use super::{between, slope_weights, values};

    /// A polynomial of a degree with coefficients that are no friends of each other.
    fn polynomial(degree: usize, x: f64) -> [f64; 2] {
        let coefficient = |n: usize| [0.7, -1.3, 0.45, 0.31, -0.17, 0.06, 0.02][n];
        let value = (0..=degree).map(|n| coefficient(n) * x.powi(n as i32)).sum();
        let slope = (1..=degree).map(|n| n as f64 * coefficient(n) * x.powi(n as i32 - 1)).sum();
        [value, slope]
    }

    #[track_caller]
    fn check(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-8 * (1.0 + expected.abs()), "{found}, {expected}");
    }

    #[test]
    fn what_a_stencil_holds_of_a_polynomial_is_exact_at_the_border_and_on_short_lines_too() {
        for (count, size) in [4, 5, 6, 7].into_iter().flat_map(|n| (1..9).map(move |s| (n, s))) {
            let degree = count.min(size) - 1;
            let place = |i: isize| (i as f64 - 1.5) / 2.0;
            for first in -(count as isize) / 2..=(size - 1) as isize - (count as isize - 1) / 2 {
                let mut found = [0.0; 7];
                let found = &mut found[..count];
                let value = |i: usize| polynomial(degree, place(i as isize))[0];
                values(found, first, size, value);
                for (n, &found) in found.iter().enumerate() {
                    check(found, polynomial(degree, place(first + n as isize))[0]);
                }
                let middle = place(first) + (count - 1) as f64 / 4.0;
                if count % 2 == 0 {
                    for s in [-0.5, -0.2, 0.3, 0.5] {
                        check(between(found, s), polynomial(degree, middle + s / 2.0)[0]);
                    }
                }
            }
        }
    }

    /// By the weights of differences, for values by how many steps they are above the lower end of an edge.
    fn slope<const PAIRS: usize>(value: impl Fn(isize) -> f64, s: f64) -> f64 {
        let mut sum = 0.0;
        for (n, weights) in (1..).zip(slope_weights::<PAIRS>(s)) {
            let difference = |at: isize| value(at + n) - value(at - n);
            for (pair, [low, high]) in (0..).zip(weights) {
                sum += difference(-pair) * low + difference(1 + pair) * high;
            }
        }
        sum
    }

    #[test]
    fn slopes_of_polynomials_of_as_high_a_degree_as_there_are_samples_are_exact() {
        for (degree, s) in (0..=6).flat_map(|d| [-0.5, -0.2, 0.0, 0.3, 0.5].map(|s| (d, s))) {
            let value = |at: isize| polynomial(degree, at as f64 / 2.0)[0];
            let [_, expected] = polynomial(degree, (s + 0.5) / 2.0);
            check(slope::<3>(value, s) / 60.0, expected / 2.0);
            if degree <= 4 {
                check(slope::<2>(value, s) / 12.0, expected / 2.0);
            }
        }
    }

    #[test]
    fn weights_of_slopes_seen_from_the_other_end_are_the_same_bits() {
        for s in [0.0, 0.1, 0.3, 0.5] {
            let turned = slope_weights::<3>(-s).map(|all| all.map(|[low, high]| [high, low]));
            assert_eq!(slope_weights::<3>(s), turned, "{s}");
        }
    }

    #[test]
    fn a_line_read_from_its_other_end_gives_the_same_bits() {
        let line = [0.3, 1.7, -2.9, 11.1, 0.7, 5.3, -8.1, 2.2];
        let back = |i: usize| line[line.len() - 1 - i];
        for count in 4..=7 {
            for first in -3..=(line.len() - count + 3) as isize {
                let (mut there, mut other) = ([0.0; 7], [0.0; 7]);
                let (there, other) = (&mut there[..count], &mut other[..count]);
                values(there, first, line.len(), |i| line[i]);
                values(other, line.len() as isize - first - count as isize, line.len(), back);
                if count % 2 == 0 {
                    assert_eq!(between(there, 0.3).to_bits(), between(other, -0.3).to_bits());
                }
                other.reverse();
                assert_eq!(there, other);
            }
        }
    }
}
