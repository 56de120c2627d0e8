//! From values to colours and opacities.
//!
//! A transfer function is given by points: at each a value, a colour and an opacity, and between two of them
//! both change linearly. An opacity is what a ray gathers over a reference length; over any other it is
//! corrected (`gather.rs`).
//!
//! What a place looks like may depend on more than its value (`model.rs`): on how steep values are there (`slopes.rs`),
//! or on what it is made of (`mixture.rs`). `lookup.rs` has all that ready for many values and one length of step.

mod integral;
mod lookup;
mod mixture;
mod model;
mod slopes;
mod steep;

pub(crate) use lookup::{Lookup, Place, Scale};
pub use mixture::{Material, Mixture, MixtureError};
pub use model::OpticalModel;
pub use slopes::{SlopeError, SlopeFunction};
pub use steep::full_slope;
pub(crate) use steep::slope_at;

use isokit_mesh::Rgba;

/// What values look like.
///
/// # Guarantees
///
/// There is a point or more. Values are from −10³⁷ to 10³⁷, which f32 can tell apart, and never fall from point to
/// point.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    points: Vec<ControlPoint>,
    /// Whether colours between points count as much as they hide: what changes linearly is colour times opacity.
    is_weighted: bool,
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

/// A value that is to be seen among others that are not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// The value, where most is seen; its ends are from −10³⁷ to 10³⁷.
    pub value: f64,
    /// Half as much below it and half as much above it nothing is seen any more; above 0, in the unit of values, and not so
    /// little that the ends cannot be told from the value.
    pub width: f64,
    /// Its colour in linear light, not multiplied by its opacity.
    pub color: [f32; 3],
    /// What a ray gathers of the value over the reference length, from 0 to 1.
    pub opacity: f32,
}

/// Why points are no transfer function.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransferError {
    /// There is none.
    #[error("a transfer function has a point at least")]
    Empty,
    /// A value, colour or opacity is out of its range.
    #[error(
        "point or peak {number} of the transfer function has a value beyond 1e37, or a colour or opacity that is not \
         from 0 to 1"
    )]
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
    /// There is no peak.
    #[error("expected a peak at least")]
    NoPeak,
    /// A peak has no ends that can be told from its value.
    #[error(
        "peak {number} of the transfer function, at {value}, is {width} wide: expected a finite width above 0, of which \
         f64 keeps the halves below and above the value"
    )]
    Width {
        /// Counted from 1.
        number: usize,
        /// Its value.
        value: f64,
        /// Its width.
        width: f64,
    },
    /// A peak begins before the one before it ends.
    #[error(
        "peak {number} of the transfer function begins at {begin}, before the one before it ends at {end}: expected \
         peaks in the order of their values, none in another"
    )]
    Overlap {
        /// Counted from 1.
        number: usize,
        /// Where it begins.
        begin: f64,
        /// Where the one before ends.
        end: f64,
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
            if !(point.value.abs() <= 1e37 && are_shares) {
                return Err(TransferError::OutOfRange { number });
            }
            if point.value < before {
                return Err(TransferError::Falls { number, value: point.value, before });
            }
            before = point.value;
        }
        Ok(Self { points, is_weighted: false })
    }

    /// The function that shows some values and what is next to them, in the order of the values, and nothing else: one
    /// peak emphasises one isosurface, three peaks three (Levoy 1988, "Display of surfaces from volume data", isovalue
    /// contours). Steps along a ray are longer than such surfaces are thick: see
    /// [`RaycastOptions::integrated`](crate::RaycastOptions::integrated).
    ///
    /// # Errors
    ///
    /// If there is no peak, if two overlap, or if a number is out of its range.
    pub fn of_peaks(peaks: &[Peak]) -> Result<Self, TransferError> {
        if peaks.is_empty() {
            return Err(TransferError::NoPeak);
        }
        let mut points = vec![];
        let mut end = f64::NEG_INFINITY;
        for (number, &Peak { value, width, color, opacity }) in (1..).zip(peaks) {
            let [begin, high] = [-0.5, 0.5].map(|share| value + share * width);
            let is_peak = begin < value && value < high && width.is_finite();
            if !is_peak {
                return Err(TransferError::Width { number, value, width });
            }
            // Decimals that touch, as 0.1 + 0.1 and 0.3 − 0.1, need not after rounding.
            let rounding = 4.0 * f64::EPSILON * (value.abs() + width);
            if begin < end - rounding {
                return Err(TransferError::Overlap { number, begin, end });
            }
            let low = begin.max(end);
            if low >= value {
                return Err(TransferError::Width { number, value, width });
            }
            let point = |value, opacity| ControlPoint { value, color, opacity };
            points.extend([point(low, 0.0), point(value, opacity), point(high, 0.0)]);
            end = high;
        }
        Self::new(points).map_err(|error| match error {
            TransferError::OutOfRange { number } => {
                TransferError::OutOfRange { number: (number - 1) / 3 + 1 }
            }
            other => other,
        })
    }

    /// The same, but that a colour between two points is theirs in the measure of their opacities: of a point that
    /// cannot be seen no colour is in it.
    #[must_use]
    pub fn weighted(self) -> Self {
        Self { is_weighted: true, ..self }
    }

    /// The same with nothing to be seen.
    pub(crate) fn hidden(&self) -> Self {
        let hidden = |point: &ControlPoint| ControlPoint { opacity: 0.0, ..*point };
        Self { points: self.points.iter().map(hidden).collect(), ..*self }
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
        let mix = |a: f32, b: f32, share: f64| {
            (f64::from(a) * (1.0 - share) + f64::from(b) * share) as f32
        };
        let opacity = mix(low.opacity, high.opacity, share);
        let weight = share * f64::from(high.opacity) / f64::from(opacity);
        let of_colors =
            if self.is_weighted && weight.is_finite() { weight.min(1.0) } else { share };
        let color = std::array::from_fn(|n| mix(low.color[n], high.color[n], of_colors));
        ControlPoint { value, color, opacity }
    }

    /// Whether a value from `least` to `greatest` can be seen.
    pub fn shows_any(&self, [least, greatest]: [f64; 2]) -> bool {
        let within = self.points.iter().filter(|point| (least..=greatest).contains(&point.value));
        let ends = [least, greatest].map(|value| self.at(value).opacity);
        within.map(|point| point.opacity).chain(ends).any(|opacity| opacity > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{ControlPoint, Peak, TransferError, TransferFunction};

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
    fn colours_in_the_measure_of_opacities_are_products_that_change_linearly() {
        let points = [point(0.0, 0.25, 0.2), point(1.0, 1.0, 0.8)];
        let product = |value: f64, function: &TransferFunction| {
            let found = function.at(value);
            found.color[0] * found.opacity
        };
        let weighted = TransferFunction::new(points.into()).unwrap().weighted();
        for value in [0.0, 0.3, 0.5, 0.9, 1.0] {
            let expected = 0.05 + 0.75 * value as f32;
            assert!((product(value, &weighted) - expected).abs() < 1e-6, "{value}");
        }
        let clear =
            TransferFunction::new(vec![point(0.0, 0.0, 0.0), point(1.0, 1.0, 0.5)]).unwrap();
        assert_eq!(clear.weighted().at(0.25).color[0], 1.0);
    }

    #[test]
    fn two_points_of_one_value_are_a_step() {
        let points = [point(0.0, 0.0, 0.2), point(5.0, 0.0, 0.2), point(5.0, 1.0, 0.9)];
        let step = TransferFunction::new(points.into()).unwrap();
        assert_eq!([4.999, 5.0, 6.0].map(|v| step.at(v).opacity), [0.2, 0.9, 0.9]);
    }

    #[test]
    fn a_range_shows_something_if_a_value_in_it_is_seen() {
        let points = [point(0.0, 0.0, 0.0), point(4.0, 1.0, 0.0), point(5.0, 1.0, 0.8)];
        let hill = points.into_iter().chain([point(6.0, 1.0, 0.0), point(9.0, 1.0, 0.0)]);
        let hill = TransferFunction::new(hill.collect()).unwrap();
        for (range, is_shown) in [
            ([-5.0, 4.0], false),
            ([3.0, 4.5], true),
            ([4.0, 6.0], true),
            ([5.5, 5.5], true),
            ([6.0, 20.0], false),
        ] {
            assert_eq!(hill.shows_any(range), is_shown, "{range:?}");
        }
    }

    #[test]
    fn of_peaks_nothing_is_seen_but_what_is_next_to_their_values() {
        let peak = |value, width, opacity| Peak { value, width, color: [0.5; 3], opacity };
        let [first, second] = [peak(10.0, 4.0, 0.8), peak(14.0, 4.0, 0.2)];
        let function = TransferFunction::of_peaks(&[first, second]).unwrap();
        let values = [7.9, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 16.0, 99.0];
        let expected = [0.0, 0.0, 0.4, 0.8, 0.4, 0.0, 0.1, 0.2, 0.0, 0.0];
        for (value, opacity) in values.into_iter().zip(expected) {
            assert!((function.at(value).opacity - opacity).abs() < 1e-6, "{value}");
        }
        let refused = |peaks: &[Peak]| TransferFunction::of_peaks(peaks).unwrap_err();
        assert_eq!(refused(&[]), TransferError::NoPeak);
        for (value, begin) in [(1.0, 0.0), (13.0, 12.0 - 1e-9)] {
            let found = refused(&[first, peak(value, 2.0 * (value - begin), 2.0)]);
            assert!(matches!(found, TransferError::Overlap { number: 2, .. }), "{found:?}");
        }
        assert_eq!(
            refused(&[first, peak(20.0, 2.0, 2.0)]),
            TransferError::OutOfRange { number: 2 }
        );
        let infinite = f64::INFINITY;
        for (value, width) in [
            (14.0, 0.0),
            (14.0, -1.0),
            (f64::NAN, 1.0),
            (14.0, f64::NAN),
            (14.0, infinite),
            (infinite, 1.0),
            (1e6, 1e-12),
        ] {
            let found = refused(&[first, peak(value, width, 0.5)]);
            assert!(matches!(found, TransferError::Width { number: 2, .. }), "{found:?}");
        }
    }

    #[test]
    fn peaks_of_decimals_may_touch() {
        let peak = |value, width| Peak { value, width, color: [0.5; 3], opacity: 0.5 };
        for n in 1..200 {
            let [a, b] = [0.1 * f64::from(n), 0.1 * f64::from(n + 2)];
            TransferFunction::of_peaks(&[peak(a, 0.2), peak(b, 0.2)]).unwrap();
        }
        TransferFunction::of_peaks(&[peak(1.1, 0.2), peak(1.3, 0.2)]).unwrap();
    }

    #[test]
    fn points_that_are_no_function_are_refused_by_number() {
        let new = |points: &[ControlPoint]| TransferFunction::new(points.to_vec()).unwrap_err();
        assert_eq!(new(&[]), TransferError::Empty);
        let falls = new(&[point(2.0, 0.0, 0.0), point(1.0, 0.0, 0.0)]);
        assert_eq!(falls, TransferError::Falls { number: 2, value: 1.0, before: 2.0 });
        for bad in [
            point(f64::NAN, 0.0, 0.0),
            point(-1e300, 0.0, 0.0),
            point(0.0, 1.5, 0.0),
            point(0.0, 0.0, f32::NAN),
        ] {
            let found = new(&[point(0.0, 0.0, 0.0), bad]);
            assert_eq!(found, TransferError::OutOfRange { number: 2 });
        }
    }
}
