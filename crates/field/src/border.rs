//! How a line of samples goes on beyond its ends.
//!
//! For kernels of a few samples as the cubic through the last four, so that near the border they are as exact as elsewhere;
//! for wider ones, which would make much of the noise of those four, turned around the last sample, so that what rises
//! evenly goes on.

use std::ops::Range;

/// Kernels up to here go on as a cubic.
const NARROW: f64 = 2.0;

/// Samples that a cubic goes through.
pub(crate) const FOUR: i64 = 4;

/// The ends of a line of samples, for a kernel that reaches so far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Border {
    last: i64,
    is_narrow: bool,
}

impl Border {
    /// Of a line of one sample or more.
    pub(crate) fn new(size: usize, radius: f64) -> Self {
        Self { last: size as i64 - 1, is_narrow: radius <= NARROW }
    }

    /// The samples that are there among those that count, or by which those are told that are not.
    pub(crate) fn held(&self, low: i64, high: i64) -> Range<i64> {
        let last = self.last;
        let beyond = if self.is_narrow { 0 } else { (-low).max(high - last).max(0) };
        let reach = beyond.max(FOUR - 1);
        let first = low.max(0).min(if high > last { (last - reach).max(0) } else { last });
        let end = high.min(last).max(if low < 0 { reach.min(last) } else { 0 });
        first..end + 1
    }

    /// What counts of samples that are there where one counts that may be beyond the border.
    pub(crate) fn add(&self, (i, weight): (i64, f64), mut add: impl FnMut(i64, f64)) {
        let last = self.last;
        if (0..=last).contains(&i) {
            return add(i, weight);
        }
        // From the border inwards.
        let (beyond, inwards): (i64, fn(i64, i64) -> i64) = match i < 0 {
            true => (-i, |n, _| n),
            false => (i - last, |n, last| last - n),
        };
        if !self.is_narrow {
            add(inwards(0, last), 2.0 * weight);
            return add(inwards(beyond.min(last), last), -weight);
        }
        let nodes = FOUR.min(last + 1);
        for node in 0..nodes {
            add(inwards(node, last), weight * before(beyond, node, nodes));
        }
    }
}

/// How much one of the first numbers of a line is of one so far before the first: of the polynomial through them.
pub(crate) fn before(beyond: i64, node: i64, nodes: i64) -> f64 {
    let others = (0..nodes).filter(|&other| other != node);
    others.map(|other| (-beyond - other) as f64 / (node - other) as f64).product()
}
