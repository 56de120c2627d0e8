//! The cubic through four samples in line, as weights of samples at a place, with two derivatives.
//!
//! A stencil that leads over the border is one-sided there, and on a line of fewer samples the polynomial
//! through all of them takes the cubic's place: [`line::values`] says what a missing sample is of those
//! that are there, and so whose weight its weight becomes.

use isokit_volume::line;
use std::ops::Range;

/// Samples of a stencil.
pub(crate) const WIDTH: usize = 4;

/// Which samples of a line say what it is at a place, and how much each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stencil {
    first: usize,
    held: usize,
    /// For the value, and for the first and the second derivative per sample.
    pub(crate) weights: [[f64; WIDTH]; 3],
}

impl Stencil {
    /// At the place `x` of a line of `size` samples, one or more.
    #[inline]
    pub(crate) fn at(x: f64, size: usize) -> Self {
        // What is no number falls into the first cell, and makes weights that are none.
        let cell = cell(x, size);
        let weights = weights(x - cell as f64 - 0.5);
        if cell >= 1 && cell + 2 < size {
            return Self { first: cell - 1, held: WIDTH, weights };
        }
        Self::folded(cell, size, &weights)
    }

    /// The same where the stencil leads over the border.
    #[cold]
    fn folded(cell: usize, size: usize, around: &[[f64; WIDTH]; 3]) -> Self {
        let Range { start: first, end } = around_cell(cell, size);
        let held = end - first;
        let mut weights = [[0.0; WIDTH]; 3];
        for own in 0..held {
            // How much of each sample around the place is this one.
            let mut shares = [0.0; WIDTH];
            let is_own = |i: usize| if i == first + own { 1.0 } else { 0.0 };
            line::values(&mut shares, cell as isize - 1, size, is_own);
            for (weights, around) in weights.iter_mut().zip(around) {
                weights[own] = (0..WIDTH).map(|n| shares[n] * around[n]).sum();
            }
        }
        Self { first, held, weights }
    }

    /// The samples.
    #[inline]
    pub(crate) fn samples(&self) -> Range<usize> {
        self.first..self.first + self.held
    }
}

/// The samples of the stencil at the place `x` of a line of `size` samples, one or more.
#[inline]
pub(crate) fn samples(x: f64, size: usize) -> Range<usize> {
    around_cell(cell(x, size), size)
}

/// The cell that a place is in, or nearest to. What is no number is in the first.
#[inline]
fn cell(x: f64, size: usize) -> usize {
    (x as usize).min(size.saturating_sub(2))
}

/// The samples of the stencil of a cell.
#[inline]
fn around_cell(cell: usize, size: usize) -> Range<usize> {
    let held = WIDTH.min(size);
    let first = cell.saturating_sub(1).min(size - held);
    first..first + held
}

/// The weights of four samples at `s` from the middle of the inner two, of each derivative (Lagrange).
fn weights(s: f64) -> [[f64; WIDTH]; 3] {
    let [inner, outer] = line::weights::<2>(s);
    let value = [outer[0], inner[0], inner[1], outer[1]];
    // A weight is c (s² − o) (p ± s), with o the other pair's square place.
    let derived = |c: f64, o: f64, p: f64, side: f64| {
        let (square, own) = (s * s - o, p + side * s);
        [c * (2.0 * s * own + side * square), c * (2.0 * p + 6.0 * side * s)]
    };
    let far = |side: f64| derived(1.0 / 6.0, 0.25, 1.5, side);
    let near = |side: f64| derived(-0.5, 2.25, 0.5, side);
    let all = [far(-1.0), near(-1.0), near(1.0), far(1.0)];
    [value, all.map(|each| each[0]), all.map(|each| each[1])]
}

#[cfg(test)]
mod tests {
    use super::Stencil;

    /// A polynomial with two derivatives.
    fn polynomial(degree: usize, x: f64) -> [f64; 3] {
        let c = [0.7, -1.3, 0.45, 0.31];
        let term = |order: usize| {
            (order..=degree)
                .map(|n| {
                    let factor: usize = (n + 1 - order..=n).product();
                    factor as f64 * c[n] * x.powi((n - order) as i32)
                })
                .sum()
        };
        [term(0), term(1), term(2)]
    }

    #[test]
    fn cubics_are_exact_with_two_derivatives_everywhere_on_lines_of_any_length() {
        for size in 1..8_usize {
            let degree = size.min(4) - 1;
            for n in -4..=8 * size as i32 {
                let x = f64::from(n) / 8.0;
                let stencil = Stencil::at(x, size);
                for (order, expected) in polynomial(degree, x).into_iter().enumerate() {
                    let weights = stencil.weights[order].iter();
                    let values = stencil.samples().map(|i| polynomial(degree, i as f64)[0]);
                    let found: f64 = weights.zip(values).map(|(w, v)| w * v).sum();
                    let near = 1e-11 * (1.0 + expected.abs());
                    assert!((found - expected).abs() < near, "{size}, {x}, {order}: {found}");
                }
            }
        }
    }

    #[test]
    fn no_place_leads_out_of_the_line() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1e300, 1e300, -0.0] {
            for size in [1, 2, 3, 4, 9] {
                assert!(Stencil::at(x, size).samples().end <= size, "{x}");
            }
        }
    }
}
