//! Samples on a line of the lattice, and derivatives on it, to a high order.
//!
//! A stencil that leads over the border is one-sided there. That is done by going on: the missing samples
//! are those of the polynomial through the nearest ones, as many as the stencil has, or all where a line
//! has fewer. What is made of them is then what the one-sided stencil of the same order gives, or of the
//! highest order that the line allows. From either border it is the same sum in the same order, so that
//! mirrored volumes keep mirrored bits.

use std::ops::{Add, Mul, Sub};

/// The most samples of a stencil: those of a difference of order six.
const MOST: usize = 7;

/// The values on a line from index `first` on, as many as there is room for, seven at most. `value` tells
/// them from 0 to `size`; beyond, the line is continued.
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
        line[n] = before(&BEFORE[held], line[n + 1..=n + held].iter());
    }
    for n in high..end {
        line[n] = before(&BEFORE[held], line[n - held..n].iter().rev());
    }
    out.copy_from_slice(&line[own..end]);
}

/// The value one step before the first of the polynomial through some, be they samples or told so themselves.
#[inline(always)]
fn before<'v>(factors: &[f64; MOST], values: impl Iterator<Item = &'v f64>) -> f64 {
    factors.iter().zip(values).fold(0.0, |sum, (factor, value)| sum + factor * value)
}

/// For each number of values the factors of all of them in the value before the first: the difference of as high
/// an order as there are values is 0.
const BEFORE: [[f64; MOST]; MOST + 1] = {
    let mut factors = [[0.0; MOST]; MOST + 1];
    let mut held = 1;
    while held <= MOST {
        let (mut n, mut factor) = (0, -1.0);
        while n < held {
            factor = -factor * (held - n) as f64 / (n + 1) as f64;
            factors[held][n] = factor;
            n += 1;
        }
        held += 1;
    }
    factors
};

/// The derivative in the middle of an odd number of values, per step, to the order of the steps between
/// the outermost: central differences (Fornberg 1988). Times 12 for five values, times 60 for seven, which
/// no direction minds.
#[inline(always)]
pub fn slope<F>(values: &[F]) -> F
where
    F: Copy + From<f32> + Add<Output = F> + Sub<Output = F> + Mul<Output = F>,
{
    let middle = values.len() / 2;
    let weights: &[f32] = if middle == 2 { &[8.0, -1.0] } else { &[45.0, -9.0, 1.0] };
    (1..).zip(weights).fold(F::from(0.0), |sum, (steps, &weight)| {
        sum + F::from(weight) * (values[middle + steps] - values[middle - steps])
    })
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

/// The sum of values around an edge by their weights, in pairs, so that a mirror changes no bit.
#[inline(always)]
pub fn mean<const PAIRS: usize>(values: &[f64], weights: &[[f64; 2]; PAIRS]) -> f64 {
    let pair = |n: usize| values[PAIRS - 1 - n] * weights[n][0] + values[PAIRS + n] * weights[n][1];
    (1..PAIRS).fold(pair(0), |sum, n| sum + pair(n))
}

/// What the polynomial through four or six values around an edge is at `s` steps from its middle.
pub fn between(values: &[f64], s: f64) -> f64 {
    match values.len() {
        4 => mean::<2>(values, &weights(s)),
        _ => mean::<3>(values, &weights(s)),
    }
}

#[cfg(test)]
mod tests {
    use super::{between, slope, values};

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
                match count % 2 {
                    1 => {
                        let times = if count == 5 { 12.0 } else { 60.0 };
                        check(slope(found) / times, polynomial(degree, middle)[1] / 2.0);
                    }
                    _ => [-0.5, -0.2, 0.3, 0.5].into_iter().for_each(|s| {
                        check(between(found, s), polynomial(degree, middle + s / 2.0)[0]);
                    }),
                }
            }
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
                match count % 2 {
                    0 => assert_eq!(between(there, 0.3).to_bits(), between(other, -0.3).to_bits()),
                    _ => assert_eq!(slope(there), -slope(other)),
                }
                other.reverse();
                assert_eq!(there, other);
            }
        }
    }
}
