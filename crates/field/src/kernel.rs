//! Cubics of four samples in line, as weights of samples at a place, with two derivatives.
//!
//! A stencil that leads over the border is one-sided there, and on a line of fewer samples a polynomial
//! through all of them takes the place of what is missing: [`line::values`] says what a missing sample is of
//! those that are there, and so whose weight its weight becomes.

use isokit_volume::line;
use std::ops::Range;

/// Samples of a stencil.
pub(crate) const WIDTH: usize = 4;

/// A cubic between the inner two of four samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cubic {
    /// Through all four (Lagrange).
    Lagrange,
    /// Through the inner two, rising there as from one neighbour to the other (Catmull & Rom 1974, "A class of local
    /// interpolating splines").
    CatmullRom,
}

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
    pub(crate) fn at(cubic: Cubic, x: f64, size: usize) -> Self {
        // What is no number falls into the first cell, and makes weights that are none.
        let cell = cell(x, size);
        Self::within(cubic, cell, x - cell as f64 - 0.5, size)
    }

    /// At `s` from the middle of a cell.
    #[inline]
    fn within(cubic: Cubic, cell: usize, s: f64, size: usize) -> Self {
        let weights = match cubic {
            Cubic::Lagrange => lagrange(s),
            Cubic::CatmullRom => catmull_rom(s),
        };
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

    /// The samples of a cell, and the weights that they have in each of the four numbers that the cubic is made of in it by
    /// Bernstein's polynomials: it is where they are, and no further from them than they are from each other.
    pub(crate) fn control(
        cubic: Cubic,
        cell: usize,
        size: usize,
    ) -> (Range<usize>, [[f64; WIDTH]; 4]) {
        let [low, high] = [-0.5, 0.5].map(|s| Self::within(cubic, cell, s, size));
        let ([from, leaves, _], [to, comes, _]) = (low.weights, high.weights);
        let third = |ends: &[f64; WIDTH], slope: &[f64; WIDTH], side: f64| {
            std::array::from_fn(|n| ends[n] + side * slope[n] / 3.0)
        };
        (low.samples(), [from, third(&from, &leaves, 1.0), third(&to, &comes, -1.0), to])
    }

    /// The samples.
    #[inline]
    pub(crate) fn samples(&self) -> Range<usize> {
        self.first..self.first + self.held
    }
}

/// How far the cubic may be from the middle of the samples' range, where half of the range is 1: in a cell that is at the
/// border, or in another.
pub(crate) const fn stretch(is_border: bool) -> f64 {
    if is_border { 1.68 } else { 1.25 }
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
pub(crate) fn around_cell(cell: usize, size: usize) -> Range<usize> {
    let held = WIDTH.min(size);
    let first = cell.saturating_sub(1).min(size - held);
    first..first + held
}

/// The weights of four samples at `s` from the middle of the inner two, of each derivative (Lagrange).
fn lagrange(s: f64) -> [[f64; WIDTH]; 3] {
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

/// The same of Catmull & Rom's cubic.
fn catmull_rom(s: f64) -> [[f64; WIDTH]; 3] {
    let far = |s: f64| {
        let t = s + 0.5;
        [0.5 * t * t * (t - 1.0), t * (1.5 * t - 1.0), 3.0 * t - 1.0]
    };
    let near = |s: f64| {
        let t = s + 0.5;
        [0.5 * t * (1.0 + t * (4.0 - 3.0 * t)), 0.5 + t * (4.0 - 4.5 * t), 4.0 - 9.0 * t]
    };
    let ([a, b], [c, d]) = ([far(-s), near(-s)], [near(s), far(s)]);
    // What is mirrored falls where the other rises.
    std::array::from_fn(|order| {
        let side = if order == 1 { -1.0 } else { 1.0 };
        [side * a[order], side * b[order], c[order], d[order]]
    })
}

#[cfg(test)]
mod tests {
    use super::{Cubic, Stencil};

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
                let stencil = Stencil::at(Cubic::Lagrange, x, size);
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
                for cubic in [Cubic::Lagrange, Cubic::CatmullRom] {
                    assert!(Stencil::at(cubic, x, size).samples().end <= size, "{x}");
                }
            }
        }
    }

    #[test]
    fn splines_are_exact_for_parabolas_and_keep_their_slope_from_cell_to_cell() {
        let parabola = |x: f64| 0.7 + x * (0.4 * x - 1.3);
        let line = |x: f64, f: &dyn Fn(f64) -> f64| -> [f64; 3] {
            let stencil = Stencil::at(Cubic::CatmullRom, x, 9);
            stencil.weights.map(|weights| {
                weights.iter().zip(stencil.samples()).map(|(w, i)| w * f(i as f64)).sum()
            })
        };
        for n in 0..=80 {
            let x = f64::from(n) / 10.0;
            let found = line(x, &parabola);
            for (found, expected) in found.into_iter().zip([parabola(x), 0.8 * x - 1.3, 0.8]) {
                assert!((found - expected).abs() < 1e-12, "{x}: {found} for {expected}");
            }
        }
        let waves = |x: f64| (2.3 * x).sin();
        for x in 1..8 {
            let [before, after] = [-1e-9, 1e-9].map(|offset| line(f64::from(x) + offset, &waves));
            assert!((after[0] - waves(x.into())).abs() < 1e-8, "{x}");
            assert!((before[1] - after[1]).abs() < 1e-7, "{x}: {before:?}, {after:?}");
        }
        // The derivatives are those of the value.
        for n in 5..75 {
            let x = f64::from(n) / 10.0 + 0.013;
            let [low, here, high] = [x - 1e-4, x, x + 1e-4].map(|x| line(x, &waves));
            assert!((here[1] - (high[0] - low[0]) / 2e-4).abs() < 1e-6, "{x}");
            assert!((here[2] - (high[1] - low[1]) / 2e-4).abs() < 1e-6, "{x}");
        }
    }

    #[test]
    fn weights_are_no_greater_together_than_said() {
        for cubic in [Cubic::Lagrange, Cubic::CatmullRom] {
            for size in 2..9_usize {
                for n in 0..=1000 * (size - 1) {
                    let x = n as f64 / 1000.0;
                    let stencil = Stencil::at(cubic, x, size);
                    let sum: f64 = stencil.weights[0].iter().map(|weight| weight.abs()).sum();
                    let is_inner = x >= 1.0 && x < size as f64 - 2.0;
                    assert!(sum <= super::stretch(!is_inner), "{cubic:?}, {size}, {x}: {sum}");
                }
            }
        }
    }
}
