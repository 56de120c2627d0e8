//! What a stored sample means.

use crate::Sample;
use isokit_lanes::Threshold;

/// `value = stored · slope + intercept`, in f64. The identity for most files.
///
/// # Guarantees
///
/// Both numbers are finite and the slope is not 0, so a value rises or falls strictly with the stored
/// sample (as far as f64 can tell neighbours apart).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    slope: f64,
    intercept: f64,
}

impl Default for Scaling {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Scaling {
    /// A sample means itself.
    pub const IDENTITY: Self = Self { slope: 1.0, intercept: 0.0 };

    /// `None` if `slope` is 0 or either number is not finite.
    pub fn new(slope: f64, intercept: f64) -> Option<Self> {
        let sound = slope.is_finite() && slope != 0.0 && intercept.is_finite();
        sound.then_some(Self { slope, intercept })
    }

    /// Factor from stored sample to value.
    pub fn slope(self) -> f64 {
        self.slope
    }

    /// The value of a stored 0.
    pub fn intercept(self) -> f64 {
        self.intercept
    }

    /// Whether a sample means itself.
    pub fn is_identity(self) -> bool {
        self == Self::IDENTITY
    }

    /// What a stored sample means.
    #[inline(always)]
    pub fn value(self, stored: f64) -> f64 {
        // Two roundings, never a fused one: the same bits on every machine.
        stored * self.slope + self.intercept
    }

    /// What a stored sample must be for its value to be at least `iso`.
    ///
    /// Rounding keeps order, so the values of all samples of a type, taken in order, are in order
    /// too, and the first (or last) that reaches `iso` is found by bisection. The comparison of a
    /// stored sample with that one is exactly the comparison of its value with `iso`: no converted
    /// copy, no rounded isovalue.
    pub fn threshold<T: Sample>(self, iso: f64) -> Threshold<T> {
        let rising = self.slope > 0.0;
        let nth = |n: u64| T::at_rank(if rising { n } else { T::LAST_RANK - n });
        let inside = |n: u64| self.value(nth(n).to_f64()) >= iso;
        if !inside(T::LAST_RANK) {
            return Threshold::Never;
        }
        let (mut outside, mut first) = (None, T::LAST_RANK);
        while first > outside.map_or(0, |n: u64| n + 1) {
            let middle = outside.map_or(0, |n| n + 1).midpoint(first);
            if inside(middle) { first = middle } else { outside = Some(middle) }
        }
        if rising { Threshold::AtLeast(nth(first)) } else { Threshold::AtMost(nth(first)) }
    }
}

#[cfg(test)]
mod tests {
    use super::Scaling;
    use crate::Sample;
    use isokit_lanes::Threshold;

    /// The definition, sample by sample.
    fn check<T: Sample>(scaling: Scaling, iso: f64, samples: impl Iterator<Item = T>) {
        let threshold = scaling.threshold::<T>(iso);
        for sample in samples {
            let expected = scaling.value(sample.to_f64()) >= iso;
            assert_eq!(threshold.is_inside(sample), expected, "{sample:?}, {iso}, {threshold:?}");
        }
    }

    #[test]
    fn a_threshold_compares_as_the_values_would_for_every_short_sample() {
        let scalings = [(1.0, 0.0), (7.1098, -1024.0), (-0.5, 3.0), (1e300, -1e300), (1e-30, 1.0)];
        for (slope, intercept) in scalings {
            let scaling = Scaling::new(slope, intercept).unwrap();
            for stored in [-1.0, 0.0, 0.5, 126.99, 127.0, 127.5, 254.0, 255.0, 256.0, 1e9] {
                let iso = scaling.value(stored);
                check(scaling, iso, u8::MIN..=u8::MAX);
                check(scaling, iso, i8::MIN..=i8::MAX);
                check(scaling, iso, i16::MIN..=i16::MAX);
            }
        }
    }

    #[test]
    fn a_threshold_compares_as_the_values_would_for_floats_around_it() {
        for (slope, intercept) in [(1.0, 0.0), (0.1, 0.3), (-3.0, 1e-3)] {
            let scaling = Scaling::new(slope, intercept).unwrap();
            for iso in [0.1, -0.1, 0.0, 1e-45, 3.4e38, -3.4e38, 1e300] {
                let near = ((iso - intercept) / slope) as f32;
                let rank = near.rank().clamp(9, f32::LAST_RANK - 9);
                let around = (rank - 9..=rank + 9).map(f32::at_rank);
                let ends = [f32::NEG_INFINITY, f32::MIN, -0.0, 0.0, f32::MAX, f32::INFINITY];
                check(scaling, iso, around.chain(ends).chain([f32::NAN]));
            }
        }
    }

    #[test]
    fn an_isovalue_between_two_floats_is_rounded_up_not_to_the_nearest() {
        let above = f32::from_bits(0.1_f32.to_bits() - 1).to_f64().midpoint(0.1_f32.to_f64());
        let threshold = Scaling::IDENTITY.threshold::<f32>(above.next_down());
        assert_eq!(threshold, Threshold::AtLeast(0.1));
    }

    #[test]
    fn out_of_range_is_never_or_always() {
        assert_eq!(Scaling::IDENTITY.threshold::<u8>(255.5), Threshold::Never);
        assert_eq!(Scaling::IDENTITY.threshold::<u8>(-7.0), Threshold::AtLeast(0));
        assert_eq!(
            Scaling::new(-1.0, 0.0).unwrap().threshold::<u8>(-300.0),
            Threshold::AtMost(255)
        );
    }
}
