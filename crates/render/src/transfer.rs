//! From values to colours and opacities.
//!
//! A transfer function is given by points: at each a value, a colour and an opacity, and between two of them
//! both change linearly. An opacity is what a ray gathers over a reference length; over any other it is
//! corrected (`gather.rs`). `Lookup` has a function ready for many values and one length of step.

use crate::gather::opacity_over;
use isokit_mesh::Rgba;

/// What values look like.
///
/// # Guarantees
///
/// There is a point or more, values are finite and never fall from point to point.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    points: Vec<ControlPoint>,
}

/// What one value looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlPoint {
    /// The value.
    pub value: f64,
    /// Its colour in linear light, not multiplied by its opacity.
    pub color: [f32; 3],
    /// What a ray gathers of it over the reference length, from 0 to 1.
    pub opacity: f32,
}

impl ControlPoint {
    /// A value with a colour and an opacity as files write them.
    pub fn new(value: f64, rgba: Rgba) -> Self {
        let [r, g, b, opacity] = rgba.to_linear();
        Self { value, color: [r, g, b], opacity }
    }
}

/// Why points are no transfer function.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransferError {
    /// There is none.
    #[error("a transfer function has a point at least")]
    Empty,
    /// A value, colour or opacity is out of its range.
    #[error("point {number} of the transfer function is not finite, or not from 0 to 1")]
    OutOfRange {
        /// Counted from 1.
        number: usize,
    },
    /// Values fall.
    #[error("point {number} of the transfer function has value {value}, after {before}")]
    Falls {
        /// Counted from 1.
        number: usize,
        /// Its value.
        value: f64,
        /// That of the point before.
        before: f64,
    },
}

impl TransferFunction {
    /// The function through `points`. Two of the same value make a step: the value itself looks like the
    /// second.
    ///
    /// # Errors
    ///
    /// If there is no point, if a value falls, or if a number is out of its range.
    pub fn new(points: Vec<ControlPoint>) -> Result<Self, TransferError> {
        if points.is_empty() {
            return Err(TransferError::Empty);
        }
        let mut before = f64::NEG_INFINITY;
        for (number, point) in (1..).zip(&points) {
            let mut shares = point.color.iter().chain([&point.opacity]);
            let are_shares = shares.all(|share| (0.0..=1.0).contains(share));
            if !(point.value.is_finite() && are_shares) {
                return Err(TransferError::OutOfRange { number });
            }
            if point.value < before {
                return Err(TransferError::Falls { number, value: point.value, before });
            }
            before = point.value;
        }
        Ok(Self { points })
    }

    /// Its points.
    pub fn points(&self) -> &[ControlPoint] {
        &self.points
    }

    /// What a value looks like. Beyond the points it is as at the nearest; what is NaN is not seen.
    pub fn at(&self, value: f64) -> ControlPoint {
        let after = self.points.partition_point(|point| point.value <= value);
        let [low, high] = [after.saturating_sub(1), after.min(self.points.len() - 1)];
        let (low, high) = (&self.points[low], &self.points[high]);
        if value.is_nan() {
            return ControlPoint { opacity: 0.0, value, ..*low };
        }
        let width = high.value - low.value;
        let share = if width > 0.0 { (value - low.value) / width } else { 0.0 };
        let mix = |a: f32, b: f32| (f64::from(a) * (1.0 - share) + f64::from(b) * share) as f32;
        let color = std::array::from_fn(|n| mix(low.color[n], high.color[n]));
        ControlPoint { value, color, opacity: mix(low.opacity, high.opacity) }
    }

    /// The greatest opacity of any value from `least` to `greatest`.
    pub fn greatest_opacity(&self, [least, greatest]: [f64; 2]) -> f32 {
        let within = self.points.iter().filter(|point| (least..=greatest).contains(&point.value));
        let ends = [least, greatest].map(|value| self.at(value).opacity);
        within.map(|point| point.opacity).chain(ends).fold(0.0, f32::max)
    }

    /// The values from and to which anything can be seen; none if nothing can.
    pub fn visible(&self) -> Option<[f64; 2]> {
        let first = self.points.iter().position(|point| point.opacity > 0.0)?;
        let last = self.points.iter().rposition(|point| point.opacity > 0.0)?;
        // An opacity above 0 at an end goes on beyond it.
        let least = first.checked_sub(1).map_or(f64::NEG_INFINITY, |n| self.points[n].value);
        let greatest = self.points.get(last + 1).map_or(f64::INFINITY, |point| point.value);
        Some([least, greatest])
    }
}

/// A transfer function made ready for one length of step: colours, multiplied by the opacities of a step, at
/// values side by side, between which they change linearly.
#[derive(Clone, Debug)]
pub(crate) struct Lookup {
    /// The value of the first entry.
    base: f32,
    /// Entries per value.
    scale: f32,
    /// One more than there are parts.
    entries: Vec<[f32; 4]>,
}

/// Parts of a lookup: as many as a fine control point may ask for, few enough for the second cache.
const PARTS: usize = 1 << 12;

impl Lookup {
    /// For steps of so many reference lengths.
    pub(crate) fn new(function: &TransferFunction, step: f64) -> Self {
        let points = &function.points;
        let [least, greatest] = [&points[0], &points[points.len() - 1]].map(|point| point.value);
        // A little beyond both ends, where a step may be: what is farther out is as there.
        let reach = least.abs().max(greatest.abs());
        let beyond = ((greatest - least) / 1024.0).max(reach * 1e-7).max(1e-30);
        let base = (least - beyond) as f32;
        let width = greatest + beyond - f64::from(base);
        let entry = |n: usize| {
            let point = function.at(f64::from(base) + width * (n as f64 / PARTS as f64));
            let opacity = opacity_over(point.opacity.into(), step) as f32;
            let [r, g, b] = point.color.map(|part| part * opacity);
            [r, g, b, opacity]
        };
        let scale = (PARTS as f64 / width) as f32;
        Self { base, scale, entries: (0..=PARTS).map(entry).collect() }
    }

    /// Colour times opacity, and opacity, of a value. What is NaN is as the least value.
    #[inline(always)]
    pub(crate) fn at(&self, value: f32) -> [f32; 4] {
        let place = self.place(value);
        let (part, share) = self.part(place);
        let [low, high] = [self.entries[part], self.entries[part + 1]];
        std::array::from_fn(|n| low[n] + (high[n] - low[n]) * share)
    }

    /// Whether no value from one to another can be seen.
    pub(crate) fn is_clear(&self, ends: [f32; 2]) -> bool {
        // What lies between them may be rounded into the next part.
        let [first, last] = ends.map(|end| self.part(self.place(end)).0);
        let (first, last) = (first.saturating_sub(1), (last + 2).min(PARTS));
        self.entries[first..=last].iter().all(|entry| entry[3] == 0.0)
    }

    /// Where a value is among the entries.
    #[inline(always)]
    fn place(&self, value: f32) -> f32 {
        ((value - self.base) * self.scale).clamp(0.0, PARTS as f32)
    }

    /// The part that a place is in, and how far in it.
    #[inline(always)]
    fn part(&self, place: f32) -> (usize, f32) {
        let part = (place as usize).min(PARTS - 1);
        (part, place - part as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::{ControlPoint, Lookup, TransferError, TransferFunction};

    fn point(value: f64, shade: f32, opacity: f32) -> ControlPoint {
        ControlPoint { value, color: [shade, 0.5 * shade, 0.0], opacity }
    }

    fn hill() -> TransferFunction {
        let points = [point(0.0, 0.0, 0.0), point(10.0, 1.0, 0.8), point(30.0, 0.5, 0.0)];
        TransferFunction::new(points.into()).unwrap()
    }

    #[test]
    fn between_points_colour_and_opacity_change_linearly_and_beyond_they_stay() {
        let expect = |value: f64, shade: f32, opacity: f32| {
            let found = hill().at(value);
            assert!((found.color[0] - shade).abs() < 1e-6, "{value}: {found:?}");
            assert!((found.opacity - opacity).abs() < 1e-6, "{value}: {found:?}");
        };
        expect(-1e300, 0.0, 0.0);
        expect(2.5, 0.25, 0.2);
        expect(10.0, 1.0, 0.8);
        expect(25.0, 0.625, 0.2);
        expect(f64::INFINITY, 0.5, 0.0);
        assert_eq!(hill().at(f64::NAN).opacity, 0.0);
    }

    #[test]
    fn two_points_of_one_value_are_a_step() {
        let points = [point(0.0, 0.0, 0.2), point(5.0, 0.0, 0.2), point(5.0, 1.0, 0.9)];
        let step = TransferFunction::new(points.into()).unwrap();
        assert_eq!([4.999, 5.0, 6.0].map(|v| step.at(v).opacity), [0.2, 0.9, 0.9]);
    }

    #[test]
    fn the_greatest_opacity_of_a_range_is_that_of_some_value_in_it() {
        for (least, greatest) in [(-5.0, -1.0), (0.0, 4.0), (4.0, 12.0), (12.0, 40.0), (7.0, 7.0)] {
            let found = hill().greatest_opacity([least, greatest]);
            let at = |n: i32| hill().at(least + (greatest - least) * f64::from(n) / 1000.0).opacity;
            let most = (0..=1000).map(at).fold(0.0, f32::max);
            assert!((found - most).abs() < 1e-3 && found >= most, "{least} to {greatest}: {found}");
        }
    }

    #[test]
    fn what_can_be_seen_is_between_the_points_around_it() {
        assert_eq!(hill().visible(), Some([0.0, 30.0]));
        let rising = TransferFunction::new(vec![point(1.0, 1.0, 0.0), point(2.0, 1.0, 0.1)]);
        assert_eq!(rising.unwrap().visible(), Some([1.0, f64::INFINITY]));
        let nothing = TransferFunction::new(vec![point(1.0, 1.0, 0.0)]).unwrap();
        assert_eq!(nothing.visible(), None);
    }

    #[test]
    fn points_that_are_no_function_are_refused_by_number() {
        let new = |points: &[ControlPoint]| TransferFunction::new(points.to_vec()).unwrap_err();
        assert_eq!(new(&[]), TransferError::Empty);
        let falls = new(&[point(2.0, 0.0, 0.0), point(1.0, 0.0, 0.0)]);
        assert_eq!(falls, TransferError::Falls { number: 2, value: 1.0, before: 2.0 });
        for bad in [point(f64::NAN, 0.0, 0.0), point(0.0, 1.5, 0.0), point(0.0, 0.0, f32::NAN)] {
            let found = new(&[point(0.0, 0.0, 0.0), bad]);
            assert_eq!(found, TransferError::OutOfRange { number: 2 });
        }
    }

    #[test]
    fn a_lookup_is_the_function_but_for_rounding() {
        for (factor, shift) in [(1.0, 0.0), (1e-6, 0.0), (1e30, -1e30), (1.0, 1e4)] {
            let place = |value: f64| value * factor + shift;
            let points = hill().points.into_iter();
            let points = points.map(|point| ControlPoint { value: place(point.value), ..point });
            let hill = TransferFunction::new(points.collect()).unwrap();
            let lookup = Lookup::new(&hill, 0.5);
            for n in 0..1000 {
                let value = place(-5.0 + 45.0 * f64::from(n) / 999.0);
                let [r, _, _, opacity] = lookup.at(value as f32);
                let exact = hill.at(value);
                let expected = 1.0 - (1.0 - exact.opacity).sqrt();
                // Next to a point of the function a part has two slopes.
                let off = 3e-4;
                assert!(f64::from(opacity - expected).abs() <= off, "{value}: {opacity}");
                assert!(
                    f64::from(r - exact.color[0] * expected).abs() <= 2.0 * off,
                    "{value}: {r}"
                );
            }
        }
    }

    #[test]
    fn a_lookup_keeps_steps_at_both_ends_of_a_function() {
        let of = |points: &[ControlPoint]| TransferFunction::new(points.to_vec()).unwrap();
        let one = Lookup::new(&of(&[point(100.0, 1.0, 0.0), point(100.0, 1.0, 0.5)]), 1.0);
        assert_eq!([99.0, 100.5, f32::INFINITY].map(|value| one.at(value)[3]), [0.0, 0.5, 0.5]);
        let points = [(0.0, 0.2), (0.0, 0.0), (9.0, 0.0), (9.0, 0.7)];
        let both = Lookup::new(&of(&points.map(|(value, a)| point(value, 1.0, a))), 1.0);
        assert_eq!([-0.1, 5.0, 9.1].map(|value| both.at(value)[3]), [0.2, 0.0, 0.7]);
        assert!(
            both.is_clear([1.0, 8.0]) && !both.is_clear([1.0, 9.5]) && !both.is_clear([-1.0, 4.0])
        );
    }
}
