//! The laws that every [`ScalarField`] keeps, as a suite for its tests.
//!
//! Places and boxes are taken by chance from a seed, the same ones every time, within the lattice and a little beyond; some
//! are lattice points, some boxes are points, some lie in others. Of each is asked:
//!
//! - Value, gradient and Hessian are the same in all answers, to 2⁻³⁰ of the greatest of them.
//! - The gradient is that of differences of values h = 2⁻¹² apart. It lies between the slopes on either side of a place,
//!   (f(x) − f(x − h))/h and (f(x + h) − f(x))/h, which of a smooth function differ by about h f″, and where it has an edge by how
//!   much it turns there; but for four times what these slopes change by with half the step, which is h/4 of the second derivatives
//!   on both sides, for h² of the gradient and the values, and for rounding, 2⁻⁴⁸ of the greatest value or derivative over h.
//! - The Hessian is symmetric, and is to differences of gradients as gradients are to those of values. One that is not finite is not
//!   looked at: there is none.
//! - No value in a box is without its bounds. Where one is NaN nothing is known.
//! - What is asked within a box and what is filled are the same bits.
//! - A value is known where it is finite.
//! - No place and no box makes anything panic, be it infinite or no number.

use crate::{Interval, Jet, ScalarField};
use isokit_geom::Aabb;

/// What is asked: how often, and of which chance.
#[derive(Clone, Copy, Debug)]
pub struct Suite {
    /// Places.
    pub places: usize,
    /// Boxes.
    pub boxes: usize,
    /// Points in each box.
    pub points: usize,
    /// What chance begins with.
    pub seed: u64,
}

impl Default for Suite {
    fn default() -> Self {
        Self { places: 400, boxes: 150, points: 40, seed: 1 }
    }
}

/// How far apart values are whose differences are slopes.
const STEP: f64 = 1.0 / 4096.0;

/// How much answers to the same question may differ, of the greatest.
const SAME: f64 = 1.0 / (1 << 30) as f64;

/// What rounding makes of values, of the greatest.
const ROUNDING: f64 = 1.0 / (1_u64 << 48) as f64;

/// Puts a field to all laws, as often as is usual.
///
/// # Panics
///
/// If it breaks one, saying which, and where.
pub fn check(field: &dyn ScalarField) {
    Suite::default().check(field);
}

impl Suite {
    /// Puts a field to all laws.
    ///
    /// # Panics
    ///
    /// If it breaks one, saying which, and where.
    pub fn check(self, field: &dyn ScalarField) {
        let mut chance = Chance { state: self.seed };
        for _ in 0..self.places {
            let ijk = chance.place(field.dims());
            answers_agree(field, ijk);
            derivatives_are_those_of_differences(field, ijk);
        }
        for _ in 0..self.boxes {
            let whole = chance.box_in(everywhere(field.dims()));
            for ijk in [whole, chance.box_in(whole)] {
                self.a_box_holds_its_values(field, ijk, &mut chance);
            }
            self.what_is_filled_are_the_values(field, &mut chance);
        }
        nothing_panics(field);
    }

    fn a_box_holds_its_values(self, field: &dyn ScalarField, ijk: Aabb, chance: &mut Chance) {
        let bounds = field.bounds(ijk);
        let near = field.within(ijk);
        let inner = chance.box_in(ijk);
        let nearer = near.as_ref().and_then(|near| near.within(inner));
        let corners = ijk.corners().into_iter().chain(inner.corners());
        let points: Vec<_> = corners.chain((0..self.points).map(|_| chance.point(ijk))).collect();
        for (n, point) in points.into_iter().enumerate() {
            let value = field.value(point);
            let is_told = match value.is_nan() {
                true => bounds == Interval::EVERYTHING,
                false => bounds.contains(value),
            };
            assert!(is_told, "{value} at {point:?} is not within {bounds:?} of {ijk:?}");
            let Some(near) = &near else { continue };
            same_bits(field, &**near, point);
            let is_inner = (8..16).contains(&n);
            if let (Some(nearer), true) = (&nearer, is_inner) {
                same_bits(field, &**nearer, point);
            }
            if is_inner && !value.is_nan() {
                let bounds = near.bounds(inner);
                assert!(
                    bounds.contains(value),
                    "{value} at {point:?} is not within {bounds:?} of {inner:?}"
                );
            }
        }
    }

    fn what_is_filled_are_the_values(self, field: &dyn ScalarField, chance: &mut Chance) {
        let dims = field.dims();
        let points = [0, 1, 2].map(|axis| {
            let size = 1 + chance.below(dims[axis].min(9));
            let first = chance.below(dims[axis] - size + 1);
            first..first + size
        });
        let [x, y, z] = points.clone();
        let mut values = vec![0.0; x.len() * y.len() * z.len()];
        field.fill(points.clone(), &mut values);
        let check = |values: &[f64], who: &str| {
            for (n, value) in values.iter().enumerate() {
                let row = n / x.len();
                let ijk = [x.start + n % x.len(), y.start + row % y.len(), z.start + row / y.len()];
                let expected = field.value(ijk.map(|i| i as f64));
                assert_eq!(
                    value.to_bits(),
                    expected.to_bits(),
                    "{who} at {ijk:?} is {value}, not {expected}"
                );
            }
        };
        check(&values, "what is filled");
        let ijk = Aabb {
            min: [&x, &y, &z].map(|range| range.start as f64),
            max: [&x, &y, &z].map(|range| (range.end - 1) as f64),
        };
        if let Some(near) = field.within(ijk) {
            near.fill(points, &mut values);
            check(&values, "what is filled within a box");
        }
    }
}

fn answers_agree(field: &dyn ScalarField, ijk: [f64; 3]) {
    let (value, slope, jet) = (field.value(ijk), field.slope(ijk), field.jet(ijk));
    let agree = |a: f64, b: f64, scale: f64| {
        (a.is_nan() && b.is_nan()) || a == b || (a - b).abs() <= SAME * scale
    };
    let scale = value.abs();
    for told in [slope.value, jet.value] {
        assert!(agree(value, told, scale), "the value at {ijk:?} is {value}, and also {told}");
    }
    let scale = slope.gradient.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
    for (a, b) in slope.gradient.into_iter().zip(jet.gradient) {
        assert!(agree(a, b, scale), "a part of the gradient at {ijk:?} is {a}, and also {b}");
        assert!(
            !value.is_nan() || !a.is_finite(),
            "at {ijk:?} there is no value, but a gradient of {a}"
        );
    }
    let scale = jet.hessian.as_flattened().iter().fold(0.0_f64, |most, part| most.max(part.abs()));
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        let [one, other] = [jet.hessian[a][b], jet.hessian[b][a]];
        assert!(
            agree(one, other, scale),
            "the Hessian at {ijk:?} is not symmetric: {one}, {other}"
        );
    }
    assert_eq!(field.is_known(ijk), value.is_finite(), "whether {value} at {ijk:?} is known");
}

fn derivatives_are_those_of_differences(field: &dyn ScalarField, ijk: [f64; 3]) {
    let jet = field.jet(ijk);
    let parts = jet.gradient.iter().chain(jet.hessian.as_flattened());
    let greatest = parts.fold(jet.value.abs(), |most, part| most.max(part.abs()));
    for axis in 0..3 {
        let around = [-1.0, -0.5, 0.5, 1.0].map(|steps| {
            let mut place = ijk;
            place[axis] += steps * STEP;
            field.jet(place)
        });
        let far = |of: &dyn Fn(&Jet) -> f64, slope: f64, what: &str| {
            let found = is_slope(of(&jet), around.each_ref().map(of), slope, greatest);
            assert!(
                found.is_none(),
                "{what} along axis {axis} at {ijk:?} is {slope}, but differences are {found:?}"
            );
        };
        far(&|jet| jet.value, jet.gradient[axis], "the gradient");
        for part in 0..3 {
            far(&|jet| jet.gradient[part], jet.hessian[part][axis], "the Hessian");
        }
    }
}

/// Whether a number is the slope at a place: if not, what the slopes before and after it are, from numbers one step and half a
/// step away; `greatest` is that of all that is said of the place.
fn is_slope(here: f64, around: [f64; 4], slope: f64, greatest: f64) -> Option<[f64; 2]> {
    let [below, near_below, near_above, above] = around;
    if !around.iter().chain([&here, &slope]).all(|x| x.is_finite()) {
        return None;
    }
    let [before, after] = [(here - below) / STEP, (above - here) / STEP];
    let [near_before, near_after] = [here - near_below, near_above - here].map(|x| 2.0 * x / STEP);
    let bent = (near_before - before).abs() + (near_after - after).abs();
    let most = around.iter().fold(greatest, |most, x| most.max(x.abs()));
    let small = STEP * STEP * (slope.abs() + most) + ROUNDING * most / STEP;
    let far = 0.5 * (after - before).abs() + 4.0 * bent + small;
    ((slope - 0.5 * (before + after)).abs() > far).then_some([before, after])
}

/// The same answers, to the bit, of a field and of what it is within a box.
fn same_bits(field: &dyn ScalarField, near: &dyn ScalarField, ijk: [f64; 3]) {
    let of = |field: &dyn ScalarField| {
        let (slope, jet) = (field.slope(ijk), field.jet(ijk));
        let all = [field.value(ijk), slope.value, jet.value].into_iter();
        let all = all.chain(slope.gradient).chain(jet.gradient);
        let all: Vec<f64> = all.chain(jet.hessian.into_iter().flatten()).collect();
        (all.iter().map(|x| if x.is_nan() { 0 } else { x.to_bits() }).collect::<Vec<_>>(), all)
    };
    let ((whole, numbers), (part, others)) = (of(field), of(near));
    assert_eq!(whole, part, "within a box the field at {ijk:?} is {others:?}, not {numbers:?}");
    assert_eq!((field.dims(), field.is_known(ijk)), (near.dims(), near.is_known(ijk)));
}

fn nothing_panics(field: &dyn ScalarField) {
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1e300, 1e300, 1e-300, 0.0, 1.5];
    let places: Vec<_> = (0..odd.len().pow(3))
        .map(|n| {
            [n % odd.len(), n / odd.len() % odd.len(), n / odd.len() / odd.len()].map(|n| odd[n])
        })
        .collect();
    for (&ijk, &other) in places.iter().zip(places.iter().rev()) {
        // Far away what is finite may overflow on the way.
        let _ = (field.value(ijk), field.slope(ijk), field.jet(ijk), field.is_known(ijk));
        for ijk in [Aabb { min: ijk, max: other }, Aabb { min: ijk, max: ijk }] {
            let bounds = field.bounds(ijk);
            assert!(
                bounds.low <= bounds.high || bounds.low > bounds.high,
                "bounds of {ijk:?} are {bounds:?}"
            );
            if let Some(near) = field.within(ijk) {
                near.bounds(ijk);
            }
        }
    }
}

/// The lattice, and a little more.
fn everywhere(dims: [usize; 3]) -> Aabb {
    Aabb { min: [-0.25; 3], max: dims.map(|n| n as f64 - 0.75) }
}

/// Numbers by chance (Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators").
struct Chance {
    state: u64,
}

impl Chance {
    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.state ^ self.state >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn point(&mut self, Aabb { min, max }: Aabb) -> [f64; 3] {
        // Rounding may lead out of a box that is hardly one.
        std::array::from_fn(|k| (min[k] + self.unit() * (max[k] - min[k])).clamp(min[k], max[k]))
    }

    /// A place in the lattice or a little beyond; one in four on a face of a cell along each axis.
    fn place(&mut self, dims: [usize; 3]) -> [f64; 3] {
        let point = self.point(everywhere(dims));
        point.map(|c| if self.below(4) == 0 { c.round() } else { c })
    }

    /// A box in another, large or small; some sides are points.
    fn box_in(&mut self, whole: Aabb) -> Aabb {
        let [a, b] = [self.point(whole), self.point(whole)];
        let share = [1.0, 0.3, 0.01][self.below(3)];
        let mut found = Aabb { min: a, max: a };
        for k in 0..3 {
            let end = if self.below(6) == 0 { a[k] } else { a[k] + share * (b[k] - a[k]) };
            let end = end.clamp(whole.min[k], whole.max[k]);
            (found.min[k], found.max[k]) = (a[k].min(end), a[k].max(end));
        }
        found
    }
}

#[cfg(test)]
mod tests;
