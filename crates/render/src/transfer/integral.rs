//! What a function shows of a step from one value to another, with all values between them.
//!
//! Colours and what hides light are summed up over values once; of any two values it is a difference of two sums, if
//! values change evenly on the way (Engel, Kraus & Ertl 2001, "High-quality pre-integrated volume rendering using
//! hardware-accelerated pixel shading", section 4.3). What a step hides of itself is shared out evenly among its colours.

use super::{ControlPoint, TransferFunction, slopes::extinction};
use crate::Gathered;

/// Sums over values, from the first on.
#[derive(Clone, Debug)]
pub(super) struct Integrals {
    base: f64,
    /// Parts per value.
    scale: f64,
    /// At the ends of parts: colours multiplied by what hides light in a reference length, and that, times parts.
    sums: Vec<[f64; 4]>,
}

/// Where and with what weights a polynomial of degree 5 is asked for its mean over −1 to 1 (Gauss).
const NODES: [(f64, f64); 3] = [
    (-0.774_596_669_241_483_4, 5.0 / 18.0),
    (0.0, 8.0 / 18.0),
    (0.774_596_669_241_483_4, 5.0 / 18.0),
];

/// What is opaque hides in a reference length: in a hundredth of a percent of one it lets nothing through that 8 or 16
/// bits show.
const OPAQUE: f64 = 2e5;

/// Where opacities change evenly from one end to the other, the means of colours multiplied by what hides light in a
/// reference length, and of that; the latter in closed form, as it is endless next to opacity 1.
fn mean(nodes: [ControlPoint; 3]) -> [f64; 4] {
    let [first, middle, last] = nodes.map(|node| 1.0 - f64::from(node.opacity));
    let half = 0.5 * (last - first) / NODES[2].0;
    let ends = [middle - half, middle + half].map(|passes| passes.clamp(0.0, 1.0));
    let difference = ends[1] - ends[0];
    let all = if difference.abs() > 1e-3 * ends[0].max(ends[1]) {
        let [a, b] = ends.map(|passes| if passes > 0.0 { passes * passes.ln() } else { 0.0 });
        1.0 - (b - a) / difference
    } else {
        (-middle.ln()).min(OPAQUE)
    };
    let weights: [f64; 3] = std::array::from_fn(|n| NODES[n].1 * extinction(nodes[n].opacity));
    let sum: f64 = weights.iter().sum();
    let part = |k: usize| {
        let of = |n: usize| f64::from(nodes[n].color[k]) * weights[n];
        if sum > 0.0 { (of(0) + of(1) + of(2)) / sum * all } else { 0.0 }
    };
    [part(0), part(1), part(2), all]
}

/// Farther away, in parts, nobody asks.
const FAR: f64 = 1e15;

impl Integrals {
    /// Over so many parts from a value on that are `width` wide together.
    pub(super) fn new(
        function: &TransferFunction,
        (base, width): (f64, f64),
        parts: usize,
    ) -> Self {
        let value = |n: usize| base + width * (n as f64 / parts as f64);
        let mut kinks = function.points().iter().map(|point| point.value).peekable();
        let mut sums = vec![[0.0; 4]];
        let mut sum = [0.0; 4];
        for part in 0..parts {
            let (mut from, end) = (value(part), value(part + 1));
            while from < end {
                while kinks.next_if(|kink| *kink <= from).is_some() {}
                let to = kinks.peek().map_or(end, |kink| kink.min(end));
                let share = (to - from) / width * parts as f64;
                let (middle, half) = (from.midpoint(to), 0.5 * (to - from));
                let mean = mean(NODES.map(|(at, _)| function.at(middle + half * at)));
                for (sum, mean) in sum.iter_mut().zip(mean) {
                    *sum += mean * share;
                }
                from = to;
            }
            sums.push(sum);
        }
        Self { base, scale: parts as f64 / width, sums }
    }

    /// What is seen of so many reference lengths in which values change evenly from one end to the other.
    pub(super) fn between(&self, ends: [f64; 2], length: f64) -> Gathered {
        let [a, b] = ends.map(|value| ((value - self.base) * self.scale).clamp(-FAR, FAR));
        // Of less than a part the mean is rounding: that of a whole one is as good. Beyond an end all are alike.
        let last = self.sums.len() as f64 - 1.0;
        let (a, b) = match (a.max(b) < 0.0, a.min(b) > last) {
            (true, _) => (-0.5, -0.5),
            (_, true) => (last + 0.5, last + 0.5),
            _ => (a, b),
        };
        let (middle, half) = (a.midpoint(b), (0.5 * (b - a)).abs().max(0.5));
        let (low, high) = (self.sum(middle - half), self.sum(middle + half));
        let mean: [f64; 4] = std::array::from_fn(|n| (high[n] - low[n]) / (2.0 * half));
        if mean[3] <= 0.0 {
            return Gathered::NOTHING;
        }
        let opacity = -(-mean[3] * length).exp_m1();
        let color = std::array::from_fn(|n| (mean[n] / mean[3] * opacity) as f32);
        Gathered { color, opacity: opacity as f32 }
    }

    /// The sums at a place in parts; beyond both ends values look as they do there.
    fn sum(&self, place: f64) -> [f64; 4] {
        // What is below 0 becomes 0.
        let part = (place as usize).min(self.sums.len() - 2);
        let (low, share) = (&self.sums[part], place - part as f64);
        std::array::from_fn(|n| low[n] + (self.sums[part + 1][n] - low[n]) * share)
    }
}

#[cfg(test)]
mod tests {
    use super::Integrals;
    use crate::{ControlPoint, TransferFunction};

    fn function(points: &[(f64, f32, f32)]) -> TransferFunction {
        let point = |&(value, shade, opacity): &(f64, f32, f32)| ControlPoint {
            value,
            color: [shade, 0.5 * shade, 1.0],
            opacity,
        };
        TransferFunction::new(points.iter().map(point).collect()).unwrap()
    }

    #[test]
    fn what_is_between_two_values_is_what_many_short_steps_gather() {
        let hill = function(&[(0.0, 0.2, 0.1), (3.0, 1.0, 0.3), (3.0, 0.4, 0.05), (8.0, 0.0, 0.0)]);
        let integrals = Integrals::new(&hill, (-1.0, 10.0), 4096);
        for (ends, length) in [
            ([0.5, 2.5], 1.0),
            ([7.0, -0.5], 0.5),
            ([2.9, 3.1], 2.0),
            ([4.0, 4.0], 1.0),
            ([-60.0, 2.0], 1.0),
        ] {
            let (mut colors, mut all) = ([0.0; 3], 0.0);
            let count = 100_000;
            for n in 0..count {
                let share = (f64::from(n) + 0.5) / f64::from(count);
                let point = hill.at(ends[0] * (1.0 - share) + ends[1] * share);
                let hides = -(-f64::from(point.opacity)).ln_1p() * length / f64::from(count);
                all += hides;
                for (sum, part) in colors.iter_mut().zip(point.color) {
                    *sum += f64::from(part) * hides;
                }
            }
            let opacity = -(-all).exp_m1();
            let found = integrals.between(ends, length);
            assert!((f64::from(found.opacity) - opacity).abs() < 1e-5, "{ends:?}: {found:?}");
            for (part, sum) in found.color.into_iter().zip(colors) {
                let expected = sum / all * opacity;
                assert!((f64::from(part) - expected).abs() < 1e-5, "{ends:?}: {found:?}");
            }
        }
    }

    #[test]
    fn a_peak_between_two_values_is_seen_however_narrow_it_is() {
        let peak = function(&[(5.0, 1.0, 0.0), (5.00001, 1.0, 0.5), (5.00002, 1.0, 0.0)]);
        let integrals = Integrals::new(&peak, (4.0, 2.0), 4096);
        // The mean over opacities from 0 to a half and back of what hides light, for the length of the peak.
        let mean = 1.0 - 2.0_f64.ln();
        for wide in [0.1, 0.01, 0.002] {
            let found = f64::from(integrals.between([5.0 - wide, 5.0 + wide], 1.0).opacity);
            let expected = -(-mean * 1e-5 / wide).exp_m1();
            assert!((found / expected - 1.0).abs() < 1e-3, "{wide}: {found} for {expected}");
        }
    }

    #[test]
    fn opacities_up_to_1_hide_what_the_closed_form_says() {
        // Of opacities from 0 to 1 and back the mean of what hides light is 1.
        for wide in [0.00002, 0.02, 0.2] {
            let peak = function(&[(5.0 - wide, 1.0, 0.0), (5.0, 1.0, 1.0), (5.0 + wide, 1.0, 0.0)]);
            let integrals = Integrals::new(&peak, (4.0, 2.0), 4096);
            let found = f64::from(integrals.between([4.5, 5.5], 0.5).opacity);
            let expected = -(-wide).exp_m1();
            assert!((found / expected - 1.0).abs() < 1e-4, "{wide}: {found} for {expected}");
        }
    }

    #[test]
    fn what_is_opaque_is_so_in_a_small_part_of_the_reference_length() {
        let wall = function(&[(0.0, 0.5, 1.0), (1.0, 0.5, 1.0)]);
        let found = Integrals::new(&wall, (0.0, 1.0), 64).between([0.2, 0.7], 1e-4);
        assert!(found.opacity > 1.0 - 1e-6 && (found.color[0] - 0.5).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn what_cannot_be_seen_is_nothing_even_of_infinite_values() {
        let step = function(&[(5.0, 1.0, 0.0), (5.0, 1.0, 0.5)]);
        let integrals = Integrals::new(&step, (4.0, 2.0), 4096);
        assert_eq!(integrals.between([4.2, 4.9], 1.0).opacity, 0.0);
        assert_eq!(integrals.between([f64::NEG_INFINITY, 4.9], 1.0).opacity, 0.0);
        for high in [6.0, 1e9, 1e300, f64::INFINITY] {
            let found = integrals.between([high; 2], 1.0).opacity;
            assert!((found - 0.5).abs() < 1e-6, "{high}: {found}");
        }
        // As much of it as of the way to the step.
        let found = integrals.between([-1e6, 1e6 + 10.0], 1.0).opacity;
        assert!((found - (1.0 - 0.5_f32.sqrt())).abs() < 1e-6, "{found}");
    }
}
