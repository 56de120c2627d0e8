//! How much of the old samples of a line each new one is.

use super::{AXES, MOST, ResampleError};
use crate::{
    SeparableKernel, Spline,
    border::{Border, FOUR, before},
};
use isokit_job::{Job, Stopped};
use isokit_lanes::{Real, Recursion, Taps};

/// What is done along an axis.
pub(super) struct Weights<F> {
    /// Old samples of a line, and new ones.
    pub(super) sizes: [usize; 2],
    /// What weighs how much for each new one, of a line with one number more at each end.
    pub(super) taps: Taps<F>,
    /// How numbers are found first that are weighed instead of the samples.
    pub(super) recursion: Option<Recursion<F>>,
    /// Whether all samples stay as they are.
    pub(super) is_same: bool,
}

/// So far away samples count in a spline for less than a billionth.
const SPLINE_REACH: f64 = 16.0;

impl<F: Real> Weights<F> {
    pub(super) fn new(
        kernel: &dyn SeparableKernel,
        sizes: [usize; 2],
        (axis, factor): (usize, f64),
        job: &Job,
    ) -> Result<Self, ResampleError> {
        let [size, count] = sizes;
        // Wider than the line it would look at what is not there.
        let line = Line { kernel, size, stretch: factor.min(size as f64).max(1.0) };
        let radius = line.radius();
        let needed = (count as u64).saturating_mul(2 * radius.ceil() as u64 + 2);
        if needed.max(size as u64) > MOST.into() {
            return Err(ResampleError::TooMany { axis: AXES[axis], needed, most: MOST.into() });
        }
        job.limits.allow("weights along an axis", Some(needed), 16).map_err(Stopped::from)?;
        let mut taps = Taps { firsts: vec![], ends: vec![], weights: vec![] };
        let mut dense = vec![];
        for n in 0..count {
            job.check().map_err(Stopped::from)?;
            let first = line.weights((n as f64 * factor).min((size - 1) as f64), &mut dense);
            taps.firsts.push(first as u32);
            taps.weights.extend(dense.iter().copied().map(F::nearest));
            taps.ends.push(taps.weights.len() as u32);
        }
        let is_own = |n: usize| {
            let start = if n == 0 { 0 } else { taps.ends[n - 1] as usize };
            let own = &taps.weights[start..taps.ends[n] as usize];
            taps.firsts[n] as usize == n + 1 && own.len() == 1 && own[0].into() == 1.0
        };
        let spline = line.spline();
        // A spline goes through the samples.
        let is_same =
            count == size && ((spline.is_some() && factor == 1.0) || (0..count).all(is_own));
        let recursion = spline.map(|spline| recursion(spline, size));
        Ok(Self { sizes, taps, recursion, is_same })
    }

    /// What makes of the samples of a line the numbers by which pieces of a spline are weighed so that they add up to the
    /// samples: one more at each end.
    pub(super) fn numbers(
        spline: Spline,
        size: usize,
        axis: usize,
        job: &Job,
    ) -> Result<Self, ResampleError> {
        let count = size.saturating_add(2);
        if count > MOST as usize {
            let needed = count as u64;
            return Err(ResampleError::TooMany { axis: AXES[axis], needed, most: MOST.into() });
        }
        let needed = Some(count as u64);
        job.limits.allow("weights along an axis", needed, 16).map_err(Stopped::from)?;
        let taps = Taps {
            firsts: (0..count as u32).collect(),
            ends: (1..=count as u32).collect(),
            // What is found is for pieces that are 1 beside their middle.
            weights: vec![F::nearest(1.0 / spline.beside); count],
        };
        let recursion = Some(recursion(spline, size));
        Ok(Self { sizes: [size, count], taps, recursion, is_same: false })
    }
}

/// A line of samples, and the kernel by which others are made of them.
struct Line<'a> {
    kernel: &'a dyn SeparableKernel,
    size: usize,
    /// How many times as wide the kernel is.
    stretch: f64,
}

impl Line<'_> {
    /// The spline, if numbers are found for it first: where new samples are no farther from each other than old ones.
    fn spline(&self) -> Option<Spline> {
        self.kernel.spline().filter(|_| self.stretch == 1.0)
    }

    /// How far samples count.
    fn radius(&self) -> f64 {
        let is_wide = self.kernel.spline().is_some() && self.stretch > 1.0;
        if is_wide { SPLINE_REACH * self.stretch } else { self.kernel.radius() * self.stretch }
    }

    /// How much of a sample, at a place so far above it.
    fn weight(&self, distance: f64) -> f64 {
        let distance = distance / self.stretch;
        match self.kernel.spline() {
            None => self.kernel.weight(distance),
            Some(spline) if self.stretch == 1.0 => self.kernel.weight(distance) / spline.beside,
            Some(spline) => {
                // What one sample makes of the spline through it and zeros.
                let pole = spline.pole();
                let reach = self.kernel.radius().ceil();
                let first = (distance - reach).floor() as i32;
                let numbers = first..=first + 2 * reach as i32 + 1;
                let parts = numbers
                    .map(|n| pole.powi(n.abs()) * self.kernel.weight(distance - f64::from(n)));
                spline.share() * parts.sum::<f64>()
            }
        }
    }

    /// What counts at a place, from which number on, of a line with one more at each end.
    fn weights(&self, place: f64, dense: &mut Vec<f64>) -> usize {
        let radius = self.radius();
        let [low, high] = [(place - radius).ceil(), (place + radius).floor()].map(|end| end as i64);
        let last = self.size as i64 - 1;
        let weighed = (low..=high).map(|i| (i, self.weight(place - i as f64)));
        if self.spline().is_some() {
            // Numbers one beyond the border are found with the others, and none farther away counts.
            let first = low.max(-1);
            dense.clear();
            dense.extend(weighed.filter(|(i, _)| (-1..=last + 1).contains(i)).map(|(_, w)| w));
            return trimmed(dense, (first + 1) as usize);
        }
        let sum: f64 = weighed.clone().map(|(_, weight)| weight).sum();
        let border = Border::new(self.size, radius);
        let held = border.held(low, high);
        dense.clear();
        dense.resize((held.end - held.start) as usize, 0.0);
        for (i, weight) in weighed {
            border.add((i, weight / sum), |i, weight| dense[(i - held.start) as usize] += weight);
        }
        trimmed(dense, held.start as usize + 1)
    }
}

/// Without what does not count at both ends; where it begins then.
fn trimmed(dense: &mut Vec<f64>, first: usize) -> usize {
    let counts = |weight: &f64| *weight != 0.0;
    dense.truncate(dense.iter().rposition(counts).map_or(0, |n| n + 1));
    let nothing = dense.iter().position(counts).unwrap_or(0);
    dense.drain(..nothing);
    first + nothing
}

/// How the numbers of a spline are found, on a line of so many samples.
fn recursion<F: Real>(spline: Spline, size: usize) -> Recursion<F> {
    let (pole, nodes) = (spline.pole(), FOUR.min(size as i64));
    // The sum of all before the first sample, each step by the pole, with the sample itself.
    let end = |node: i64| {
        let own = if node == 0 { 1.0 } else { 0.0 };
        let beyond = (1..=64).map(|n| pole.powi(n) * before(n.into(), node, nodes));
        F::nearest(own + beyond.sum::<f64>())
    };
    Recursion {
        pole: F::nearest(pole),
        share: F::nearest(spline.share() * spline.beside),
        middle: F::nearest(spline.middle / spline.beside),
        ends: (0..nodes).map(end).collect(),
    }
}
