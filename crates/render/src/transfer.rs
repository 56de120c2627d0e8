//! From values to colours and opacities.
//!
//! A transfer function is given by points: at each a value, a colour and an opacity, and between two of them
//! both change linearly. An opacity is what a ray gathers over a reference length; over any other it is
//! corrected (`gather.rs`). `Lookup` has a function ready for many values and one length of step.

use crate::gather::opacity_over;
use isokit_lanes::Table;
use isokit_mesh::Rgba;
use isokit_volume::Scaling;

/// What values look like.
///
/// # Guarantees
///
/// There is a point or more. Values are from −10³⁷ to 10³⁷, which f32 can tell apart, and never fall from point to
/// point.
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
    #[error(
        "point {number} of the transfer function has a value beyond 1e37, or a colour or opacity that is not \
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

    /// Whether a value from `least` to `greatest` can be seen.
    pub fn shows_any(&self, [least, greatest]: [f64; 2]) -> bool {
        let within = self.points.iter().filter(|point| (least..=greatest).contains(&point.value));
        let ends = [least, greatest].map(|value| self.at(value).opacity);
        within.map(|point| point.opacity).chain(ends).any(|opacity| opacity > 0.0)
    }
}

/// A transfer function made ready for one length of step: colours, multiplied by the opacities of a step, at
/// values side by side, between which they change linearly. Where the function has a step, or a peak too narrow
/// for that, it is asked itself.
#[derive(Clone, Debug)]
pub(crate) struct Lookup<'a> {
    function: &'a TransferFunction,
    /// How many reference lengths a step has.
    step: f64,
    /// The value of the first entry.
    base: f32,
    /// Entries per value.
    scale: f32,
    /// One more than there are parts.
    entries: Box<[[f32; 4]; PARTS + 1]>,
    /// Whether something is seen in each part.
    seen: Box<[bool; PARTS]>,
    /// The first part from each on in which something is seen, or else how many there are.
    next_seen: Box<[u16; PARTS]>,
    /// Whether a part is not as good as linear.
    is_bent: Box<[bool; PARTS]>,
}

/// What a stored sample means, in f32.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    slope: f32,
    intercept: f32,
}

impl Scale {
    pub(crate) fn of(scaling: Scaling) -> Self {
        Self { slope: scaling.slope() as f32, intercept: scaling.intercept() as f32 }
    }

    /// The value of a stored sample. Rounding keeps order: it never falls where samples rise, or never rises.
    #[inline(always)]
    pub(crate) fn value(self, stored: f32) -> f32 {
        stored * self.slope + self.intercept
    }
}

/// Parts of a lookup: few enough for the second cache.
const PARTS: usize = 1 << 12;

/// By how much a colour or an opacity may be off between two entries: a quarter of what 10 bits tell apart.
const UNSEEN: f32 = 1.0 / 4096.0;

impl<'a> Lookup<'a> {
    /// For steps of so many reference lengths.
    pub(crate) fn new(function: &'a TransferFunction, step: f64) -> Self {
        let points = &function.points;
        let [least, greatest] = [&points[0], &points[points.len() - 1]].map(|point| point.value);
        // A little beyond both ends, where a step may be: what is farther out is as there.
        let reach = least.abs().max(greatest.abs());
        let beyond = ((greatest - least) / 1024.0).max(reach * 1e-6).max(1e-30);
        let base = (least - beyond) as f32;
        let width = greatest + beyond - f64::from(base);
        let scale = (PARTS as f64 / width) as f32;
        let entries = Box::new([[0.0; 4]; PARTS + 1]);
        let (seen, is_bent) = (Box::new([true; PARTS]), Box::new([false; PARTS]));
        let next_seen = Box::new([PARTS as u16; PARTS]);
        let mut lookup = Self { function, step, base, scale, entries, seen, next_seen, is_bent };
        let value = |n: usize| f64::from(base) + width * (n as f64 / PARTS as f64);
        lookup.entries = Box::new(std::array::from_fn(|n| lookup.over(value(n), 1.0)));
        for (seen, ends) in lookup.seen.iter_mut().zip(lookup.entries.windows(2)) {
            *seen = ends.iter().any(|entry| entry[3] > 0.0);
        }
        for point in points {
            let value = point.value as f32;
            if point.opacity > 0.0 {
                // However little of it, between entries too.
                let (part, _) = lookup.part(value);
                lookup.seen[part.saturating_sub(1)..(part + 2).min(PARTS)].fill(true);
            }
            // Of a step this side and the other.
            let is_off = [value, value.next_down()].into_iter().any(|value| {
                let (part, share) = lookup.part(value);
                let pairs =
                    lookup.between(part, share).into_iter().zip(lookup.over(value.into(), 1.0));
                pairs.into_iter().any(|(found, exact)| (found - exact).abs() > UNSEEN)
            });
            if is_off {
                let (part, _) = lookup.part(value);
                let near = part.saturating_sub(1)..(part + 2).min(PARTS);
                lookup.seen[near.clone()].fill(true);
                lookup.is_bent[near].fill(true);
            }
        }
        let mut next = PARTS as u16;
        for part in (0..PARTS).rev() {
            next = if lookup.seen[part] { part as u16 } else { next };
            lookup.next_seen[part] = next;
        }
        lookup
    }

    /// Colour times opacity, and opacity, of a value that is not NaN.
    #[cfg(test)]
    fn at(&self, value: f32) -> [f32; 4] {
        let (part, share) = self.part(value);
        self.in_part(part, share, value)
    }

    /// Colour times opacity, and opacity, of a value that is not NaN, by the [`part`](Self::part) that it is in.
    #[inline(always)]
    pub(crate) fn in_part(&self, part: usize, share: f32, value: f32) -> [f32; 4] {
        match self.is_bent[part] {
            false => self.between(part, share),
            true => self.over(value.into(), 1.0),
        }
    }

    /// The parts, for samples that mean what `scale` says.
    pub(crate) fn table(&self, scale: Scale) -> Table<'_> {
        let Scale { slope, intercept } = scale;
        Table { slope, intercept, base: self.base, scale: self.scale, seen: &self.seen[..] }
    }

    /// The same over a part of a step, and as exact as the function is.
    #[inline(never)]
    pub(crate) fn over(&self, value: f64, part: f64) -> [f32; 4] {
        let point = self.function.at(value);
        let opacity = opacity_over(point.opacity.into(), part * self.step) as f32;
        let [r, g, b] = point.color.map(|part| part * opacity);
        [r, g, b, opacity]
    }

    /// Whether no value from one to another can be seen.
    pub(crate) fn is_clear(&self, ends: [f32; 2]) -> bool {
        let [first, last] = ends.map(|end| self.part(end).0);
        usize::from(self.next_seen[first]) > last
    }

    #[inline(always)]
    fn between(&self, part: usize, share: f32) -> [f32; 4] {
        let [low, high] = [self.entries[part], self.entries[part + 1]];
        std::array::from_fn(|n| low[n] + (high[n] - low[n]) * share)
    }

    /// The part that a value is in, and how far in it.
    fn part(&self, value: f32) -> (usize, f32) {
        let place = ((value - self.base) * self.scale).clamp(0.0, PARTS as f32);
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

    #[test]
    fn a_lookup_is_the_function_but_for_rounding() {
        for (factor, shift) in [(1.0, 0.0), (1e-6, 0.0), (1e30, -1e30), (1.0, 1e3)] {
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
    fn a_lookup_keeps_steps_to_the_value_and_peaks_however_narrow() {
        let of = |points: &[(f64, f32)]| {
            let points = points.iter().map(|&(value, opacity)| point(value, 1.0, opacity));
            TransferFunction::new(points.collect()).unwrap()
        };
        for function in [
            of(&[(100.0, 0.0), (100.0, 0.5)]),
            of(&[(0.0, 0.2), (0.0, 0.0), (255.0, 0.0), (255.0, 0.7)]),
            of(&[(0.0, 0.1), (128.0, 0.1), (128.0, 0.9), (255.0, 0.9)]),
            of(&[(0.0, 0.0), (63.995, 0.0), (64.0, 0.8), (64.005, 0.0), (255.0, 0.0)]),
        ] {
            let lookup = Lookup::new(&function, 1.0);
            for value in (-1..=256).flat_map(|n| [n as f32, (n as f32).next_down(), n as f32 + 0.5])
            {
                let (found, exact) = (lookup.at(value)[3], function.at(value.into()).opacity);
                assert!((found - exact).abs() < 1e-3, "{value}: {found} for {exact}");
            }
        }
        let peak = of(&[(0.0, 0.0), (6.9999, 0.0), (7.0, 0.8), (7.0001, 0.0), (31e3, 0.0)]);
        let lookup = Lookup::new(&peak, 1.0);
        // Parts beside that of the peak are taken for such.
        assert!(lookup.is_clear([40.0, 30e3]) && !lookup.is_clear([7.0, 7.0]));
        assert!(!lookup.is_clear([0.0, 8.0]));
    }
}
