//! How much of each number of a line a convolution is at a place, with two derivatives.
//!
//! Weights of samples are divided by their sum, as resampling does it, so that what is flat stays flat; so derivatives are
//! those of quotients. Weights of a spline's numbers add up to 1 by themselves.

use crate::{SeparableKernel, border::Border};
use std::ops::Range;

/// Places farther out than that have no value.
const FAR: f64 = (1_u64 << 32) as f64;

/// Steps in which a cell is looked at for how much weights are together. Pieces of kernels begin and end at some of them.
const STEPS: u32 = 64;

/// The numbers along an axis, and the kernel that weighs them.
#[derive(Debug)]
pub(super) struct Line<'a, K> {
    pub(super) kernel: &'a K,
    /// Samples.
    pub(super) size: usize,
    /// Whether the numbers are those of a spline, one more at each end than samples.
    pub(super) is_spline: bool,
}

/// Which numbers of a line say what it is at a place, and how much each.
#[derive(Clone, Debug)]
pub(super) struct Stencil {
    first: usize,
    /// For the value, and for the first and the second derivative per sample.
    weights: Vec<[f64; 3]>,
    /// Which of them count for each: there a number matters that is not finite.
    spans: [Range<usize>; 3],
}

impl<K: SeparableKernel> Line<'_, K> {
    /// At the place `x`, for the value and so many derivatives.
    pub(super) fn stencil(&self, x: f64, derivatives: usize) -> Stencil {
        if x.is_nan() || x.abs() > FAR {
            return Stencil::none();
        }
        let [low, high] = self.support(x, x);
        let mut own = self.own(x, derivatives);
        if own.is_empty() {
            return Stencil::none();
        }
        if !self.is_spline {
            normalise(&mut own);
        }
        let (border, shift) = (self.border(), self.shift());
        let held = border.held(low + shift, high + shift);
        let is_within = held == (low + shift..high + shift + 1);
        let weights = match is_within {
            true => own,
            false => {
                let mut weights = vec![[0.0; 3]; (held.end - held.start) as usize];
                for (i, own) in (low + shift..).zip(&own) {
                    for (order, weight) in own[..=derivatives].iter().enumerate() {
                        let add = |i, part| weights[(i - held.start) as usize][order] += part;
                        border.add((i, *weight), add);
                    }
                }
                weights
            }
        };
        Stencil::trimmed(held.start as usize, weights)
    }

    /// The numbers that values are made of at places from one to another.
    pub(super) fn held(&self, from: f64, to: f64) -> Range<usize> {
        let [mut low, mut high] = self.support(from, to);
        // What a kernel ends at counts for nothing, unless it ends with a jump.
        let counts =
            |distance: f64| distance.abs() < self.radius() || self.kernel.weight(distance) != 0.0;
        low += i64::from(!counts(from - low as f64));
        high -= i64::from(!counts(to - high as f64));
        let held = self.border().held(low + self.shift(), high + self.shift());
        held.start as usize..held.end.max(held.start) as usize
    }

    /// How many places along the line from its ends have stencils that lead over the border.
    pub(super) fn reach(&self) -> f64 {
        if self.is_spline { 0.0 } else { self.radius().ceil() }
    }

    /// How much the absolute values of a place's weights are together at most: of one whose stencil leads over no border, and
    /// of any in the line.
    ///
    /// They are looked at in steps h. Between two of them a weight is no farther from the straight line than h²/8 of the most that
    /// its second derivative is; that is taken to be no more than twice what is found at steps.
    pub(super) fn stretches(&self) -> [f64; 2] {
        let long = Line { size: 2 * self.reach() as usize + 2, ..*self };
        let inner = long.stretch(long.size / 2 - 1);
        let cells = self.size.saturating_sub(1).min(self.reach() as usize + 1);
        [inner, (0..cells.max(1)).map(|cell| self.stretch(cell)).fold(inner, greater)]
    }

    /// The same in one cell.
    fn stretch(&self, cell: usize) -> f64 {
        let (mut most, mut bent) = (0.0, 0.0);
        for n in 0..=STEPS {
            let stencil = self.stencil(cell as f64 + f64::from(n) / f64::from(STEPS), 2);
            let together = |order: usize| -> f64 {
                stencil.weights.iter().map(|weights| weights[order].abs()).sum()
            };
            (most, bent) = (greater(most, together(0)), greater(bent, together(2)));
        }
        let step = 1.0 / f64::from(STEPS);
        most + 2.0 * bent * step * step / 8.0
    }

    /// The samples that count from one place to another, some of which may be beyond the border.
    fn support(&self, from: f64, to: f64) -> [i64; 2] {
        let radius = self.radius();
        [(from - radius).ceil() as i64, (to + radius).floor() as i64]
    }

    /// Weights of these for the value and so many derivatives, as the kernel has them.
    fn own(&self, x: f64, derivatives: usize) -> Vec<[f64; 3]> {
        let [low, high] = self.support(x, x);
        let of = |i: i64| {
            let distance = x - i as f64;
            let mut weights = [self.kernel.weight(distance), 0.0, 0.0];
            if derivatives > 0 {
                weights[1] = self.kernel.slope(distance);
            }
            if derivatives > 1 {
                weights[2] = self.kernel.bend(distance);
            }
            weights
        };
        (low..=high).map(of).collect()
    }

    fn border(&self) -> Border {
        Border::new(self.size + 2 * self.shift() as usize, self.radius())
    }

    fn radius(&self) -> f64 {
        self.kernel.radius().max(0.0)
    }

    /// Numbers before that of the first sample.
    fn shift(&self) -> i64 {
        i64::from(self.is_spline)
    }
}

/// The greater of two numbers, and what is none rather than any.
fn greater(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Divides weights by their sum s, by the rule for quotients: with v = w/s it is v′ = (w′ − v s′)/s, and
/// v″ = (w″ − 2 v′ s′ − v s″)/s.
fn normalise(weights: &mut [[f64; 3]]) {
    let [sum, slope, bend] =
        [0, 1, 2].map(|order| weights.iter().map(|weights| weights[order]).sum::<f64>());
    for weights in weights {
        let [w, first, second] = *weights;
        let value = w / sum;
        let first = (first - value * slope) / sum;
        *weights = [value, first, (second - 2.0 * first * slope - value * bend) / sum];
    }
}

impl Stencil {
    /// Of a place without a value.
    fn none() -> Self {
        Self { first: 0, weights: vec![[f64::NAN; 3]], spans: [0..1, 0..1, 0..1] }
    }

    /// Without what counts for nothing at both ends.
    fn trimmed(first: usize, mut weights: Vec<[f64; 3]>) -> Self {
        let span = |order: usize| {
            let counts = |weights: &[f64; 3]| weights[order] != 0.0;
            let end = weights.iter().rposition(counts).map_or(0, |n| n + 1);
            weights.iter().position(counts).unwrap_or(0)..end
        };
        let spans = [span(0), span(1), span(2)];
        let used = spans.iter().filter(|span| !span.is_empty());
        let start = used.clone().map(|span| span.start).min().unwrap_or(0);
        weights.truncate(used.map(|span| span.end).max().unwrap_or(0));
        weights.drain(..start.min(weights.len()));
        let spans = spans.map(|span| match span.is_empty() {
            true => 0..0,
            false => span.start - start..span.end - start,
        });
        Self { first: first + start, weights, spans }
    }

    /// The numbers.
    pub(super) fn numbers(&self) -> Range<usize> {
        self.first..self.first + self.weights.len()
    }

    /// How much the number at a place of the stencil counts for a derivative, if it does.
    #[inline]
    pub(super) fn weight(&self, derivative: usize, place: usize) -> Option<f64> {
        self.spans[derivative].contains(&place).then(|| self.weights[place][derivative])
    }

    /// The sum of the numbers of the stencil, weighed, from the first that counts on.
    #[inline]
    pub(super) fn sum(&self, derivative: usize, numbers: &[f64]) -> f64 {
        let span = self.spans[derivative].clone();
        let weighed = self.weights[span.clone()].iter().zip(&numbers[span]);
        // Nothing is added to the first: −0 takes no sign away.
        weighed.fold(-0.0, |sum, (weights, number)| sum + weights[derivative] * number)
    }
}
