//! Numbers of which a sign is asked: quick ones that may not know it, and exact ones that always do.
//!
//! A question about a cell is a few sums and products of its values. It is written once, for any
//! [`Number`], and asked of [`Near`] first, which carries a bound of its error. Where that leaves a sign
//! open it is asked again of exact integers: the values are whole multiples of a power of two, and every
//! question is homogeneous, so the power may be left out. Where 29 bits hold them `i128` holds all that
//! can come of them, up to the fourth degree; else [`Long`] does, of any length. Samples that are integers
//! are asked of `i64` at once, where 13 bits hold them.

use super::long::Long;
use isokit_volume::{Sample, View};
use std::cmp::Ordering;

/// What can be added, subtracted, multiplied, and at last compared with 0.
pub(super) trait Number: Clone {
    fn plus(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;

    /// How it compares with 0. `None` if that is not certain.
    fn sign(&self) -> Option<Ordering>;
}

/// A question about `N` values, homogeneous in them and of the fourth degree at most.
pub(super) trait Question<const N: usize> {
    type Answer;

    /// `None` where a sign is not certain.
    fn answer<T: Number>(&self, values: [T; N]) -> Option<Self::Answer>;
}

/// How many of the values make 1, if it is known that all are whole then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit(Option<f64>);

impl Unit {
    /// Nothing is known.
    #[cfg(test)]
    pub(super) const UNKNOWN: Self = Self(None);

    /// All are whole.
    #[cfg(test)]
    pub(super) const ONE: Self = Self(Some(1.0));

    /// The greatest count with which `i64` holds a fourth degree: no sum on the way exceeds 128 times its
    /// fourth power.
    const GREATEST: f64 = (1 << 13) as f64;

    /// So great that the last digit of a sum with it stands for 1; its own lower 32 digits are 0.
    const UNITS: f64 = 1.5 * (1_u64 << 52) as f64;

    /// Integers whose scaling and isovalue are integers or halves make integers or halves.
    pub(super) fn of<T: Sample>(view: &View<'_, T>, iso: f64) -> Self {
        let scaling = view.scaling();
        let numbers = [scaling.slope(), scaling.intercept(), iso];
        // Numbers so small are far from where the differences of their multiples are rounded.
        let is_small = T::DTYPE.is_integer() && numbers.iter().all(|n| n.abs() < 65536.0);
        let is_whole = |unit: &f64| numbers.iter().all(|n| (n * unit).fract() == 0.0);
        Self(is_small.then(|| [1.0, 2.0].into_iter().find(is_whole)).flatten())
    }

    /// Whether that is known. All values are finite then.
    #[inline(always)]
    pub(super) fn is_known(self) -> bool {
        self.0.is_some()
    }

    /// The values in this unit, where they are short.
    #[inline(always)]
    pub(super) fn short<const N: usize>(self, values: [f64; N]) -> Option<[i64; N]> {
        let unit = self.0?;
        let values = values.map(|value| value * unit);
        let is_short = values.iter().all(|value| value.abs() < Self::GREATEST);
        // The last digits of the sum are those of the whole number. A cast would ask for NaN and for what is too great, too.
        let whole = |value: f64| i64::from((value + Self::UNITS).to_bits() as i32);
        is_short.then(|| values.map(whole))
    }
}

/// The answer, which no rounding has part in. All values must be finite, and `short` those that a
/// [`Unit`] makes of them.
#[inline]
pub(super) fn ask<const N: usize, Q: Question<N>>(
    question: &Q,
    values: [f64; N],
    short: Option<[i64; N]>,
) -> Q::Answer {
    if let Some(answer) = short.and_then(|short| question.answer(short)) {
        return answer;
    }
    let near = values.map(|value| Near { value, error: 0.0 });
    question.answer(near).unwrap_or_else(|| ask_exactly(question, values))
}

#[cold]
fn ask_exactly<const N: usize, Q: Question<N>>(question: &Q, values: [f64; N]) -> Q::Answer {
    let answer = match whole(values) {
        Some(whole) => question.answer(whole),
        None => question.answer(long(values)),
    };
    answer.expect("an exact number knows its sign")
}

/// A number and how far it may be from the exact one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    value: f64,
    error: f64,
}

impl Near {
    /// Four times what one rounding does, so that the bound's own roundings are covered too.
    const ROUNDING: f64 = 2.0 * f64::EPSILON;

    /// `value` is the rounded result of numbers whose own errors make for `error`.
    #[inline(always)]
    fn rounded(value: f64, error: f64) -> Self {
        Self { value, error: error + value.abs() * Self::ROUNDING }
    }
}

impl Number for Near {
    #[inline(always)]
    fn plus(&self, other: &Self) -> Self {
        Self::rounded(self.value + other.value, self.error + other.error)
    }

    #[inline(always)]
    fn minus(&self, other: &Self) -> Self {
        Self::rounded(self.value - other.value, self.error + other.error)
    }

    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        let error = self.value.abs() * other.error + other.value.abs() * self.error;
        // What is lost below the least normal number is not in proportion to anything.
        let error = error + self.error * other.error + f64::MIN_POSITIVE;
        Self::rounded(self.value * other.value, error)
    }

    #[inline(always)]
    fn sign(&self) -> Option<Ordering> {
        // An overflow makes the error infinite or NaN, and nothing exceeds that.
        match self.value.abs() > self.error {
            true => self.value.partial_cmp(&0.0),
            false => None,
        }
    }
}

/// Exact while nothing overflows.
macro_rules! integer {
    ($integer:ty) => {
        impl Number for $integer {
            #[inline(always)]
            fn plus(&self, other: &Self) -> Self {
                self + other
            }

            #[inline(always)]
            fn minus(&self, other: &Self) -> Self {
                self - other
            }

            #[inline(always)]
            fn times(&self, other: &Self) -> Self {
                self * other
            }

            #[inline(always)]
            fn sign(&self) -> Option<Ordering> {
                Some(self.cmp(&0))
            }
        }
    };
}

integer!(i64);
integer!(i128);

impl Number for Long {
    fn plus(&self, other: &Self) -> Self {
        self.sum(other)
    }

    fn minus(&self, other: &Self) -> Self {
        self.sum(&other.negative())
    }

    fn times(&self, other: &Self) -> Self {
        self.product(other)
    }

    fn sign(&self) -> Option<Ordering> {
        Some(self.compare_with_zero())
    }
}

/// A finite value as `odd · 2^exponent`; none for 0.
fn odd_and_exponent(value: f64) -> Option<(u64, i32)> {
    let (bits, field) = (value.to_bits(), value.to_bits() >> 52 & 0x7FF);
    let fraction = bits & ((1 << 52) - 1);
    let (mantissa, exponent) = match field {
        0 => (fraction, -1074),
        _ => (fraction | 1 << 52, field as i32 - 1075),
    };
    let shift = mantissa.trailing_zeros();
    (mantissa != 0).then(|| (mantissa >> shift, exponent + shift as i32))
}

/// The exponent of the power of two of which all values are whole multiples.
fn unit(values: &[f64]) -> i32 {
    let exponents = values.iter().filter_map(|&value| odd_and_exponent(value));
    exponents.map(|(_, exponent)| exponent).min().unwrap_or(0)
}

/// The most bits of a value with which `i128` holds a fourth degree: with values below 2ⁿ, no sum on the
/// way exceeds 128 · 2⁴ⁿ.
const BITS: u32 = 29;

/// The values in their common unit, where they are short.
fn whole<const N: usize>(values: [f64; N]) -> Option<[i128; N]> {
    let unit = unit(&values);
    let mut short = [0; N];
    for (short, value) in short.iter_mut().zip(values) {
        if let Some((odd, exponent)) = odd_and_exponent(value) {
            let shift = (exponent - unit) as u32;
            if shift >= BITS || odd >> (BITS - shift) != 0 {
                return None;
            }
            *short = if value < 0.0 { -i128::from(odd << shift) } else { (odd << shift).into() };
        }
    }
    Some(short)
}

/// The values in their common unit.
fn long<const N: usize>(values: [f64; N]) -> [Long; N] {
    let unit = unit(&values);
    values.map(|value| match odd_and_exponent(value) {
        Some((odd, exponent)) => Long::new(value < 0.0, odd, (exponent - unit) as usize),
        None => Long::ZERO,
    })
}

#[cfg(test)]
mod tests {
    use super::{Near, Number, Question, Unit, ask, long, whole};
    use crate::trilinear::decide::{Interior, Saddle};
    use isokit_volume::{Grid, Scaling, Volume};
    use proptest::prelude::*;
    use std::cmp::Ordering;

    /// The sign of a·d − b·c, and of its square less the same square.
    struct Determinant;

    impl Question<4> for Determinant {
        type Answer = [Ordering; 2];

        fn answer<T: Number>(&self, [a, b, c, d]: [T; 4]) -> Option<[Ordering; 2]> {
            let whole = a.times(&d).minus(&b.times(&c));
            let square = whole.times(&whole);
            Some([whole.sign()?, square.minus(&square).sign()?])
        }
    }

    #[test]
    fn a_difference_that_vanishes_is_found_to_vanish_at_any_scale() {
        for scale in [1.0, 1e-300, 1e300, f64::from_bits(1), 0.1] {
            let [a, b] = [3.0 * scale, 5.0 * scale];
            let found = ask(&Determinant, [a, a, b, b], None);
            assert_eq!(found, [Ordering::Equal; 2], "{scale:e}");
            let found = ask(&Determinant, [a.next_up(), a, b, b], None);
            assert_eq!(found[0], Ordering::Greater, "{scale:e}");
            let found = ask(&Determinant, [-a.next_up(), -a, b, b], None);
            assert_eq!(found[0], Ordering::Less, "{scale:e}");
        }
    }

    #[test]
    fn the_greatest_and_the_least_number_there_are_can_meet() {
        let (huge, tiny) = (f64::MAX, f64::from_bits(1));
        assert_eq!(ask(&Determinant, [huge, tiny, tiny, huge], None)[0], Ordering::Greater);
        assert_eq!(ask(&Determinant, [huge, huge, tiny, tiny], None)[0], Ordering::Equal);
        assert_eq!(ask(&Determinant, [tiny, huge, tiny, tiny], None)[0], Ordering::Less);
    }

    #[test]
    fn values_of_29_bits_are_short_and_of_30_are_long() {
        let short = f64::from((1_u32 << 29) - 1);
        assert_eq!(whole([short, -1.0]), Some([(1 << 29) - 1, -1]));
        assert_eq!(whole([f64::from(1_u32 << 29), 1.0]), None);
        assert_eq!(whole([0.0, 1024.0]), Some([0, 1]));
    }

    #[test]
    fn integers_are_whole_in_ones_or_halves_as_scaling_and_isovalue_are() {
        let grid = Grid::new([2, 2, 2], Default::default()).unwrap();
        let (bytes, floats) = (vec![0_u8; 8], vec![0_f32; 8]);
        let (bytes, floats) =
            (Volume::new(grid, bytes).unwrap(), Volume::new(grid, floats).unwrap());
        for (slope, intercept, iso, expected) in [
            (1.0, 0.0, 80.0, Some(1.0)),
            (1.0, -1024.0, 80.5, Some(2.0)),
            (0.5, 0.0, 3.0, Some(2.0)),
            (1.0, 0.0, 80.25, None),
            (0.1, 0.0, 80.0, None),
            (1.0, 1e9, 80.0, None),
        ] {
            let scaling = Scaling::new(slope, intercept).unwrap();
            assert_eq!(Unit::of(&bytes.view().with_scaling(scaling), iso), Unit(expected));
            assert_eq!(Unit::of(&floats.view().with_scaling(scaling), iso), Unit::UNKNOWN);
        }
    }

    proptest! {
        #[test]
        fn short_values_get_the_answers_of_long_ones(
            values in any::<[i16; 8]>(), shift in 0..14_u32, axis in 0..3_usize, unit in 1..=2_u8
        ) {
            // The greatest are too long for the short way.
            let unit = f64::from(unit);
            let values = values.map(|value| f64::from(value >> shift) / unit);
            let both = |values| [Unit(Some(unit)), Unit::UNKNOWN].map(|unit| {
                ask(&Interior { axis }, values, unit.short(values))
            });
            let [short, long] = both(values);
            prop_assert_eq!(short, long);
            let [a, b, c, d, ..] = values;
            let both = |values| [Unit(Some(unit)), Unit::UNKNOWN].map(|unit| ask(&Saddle, values, unit.short(values)));
            let [short, long] = both([a, b, c, d]);
            prop_assert_eq!(short, long);
        }

        #[test]
        fn a_sign_that_is_certain_is_the_exact_one(bits in any::<[i16; 4]>(), shifts in any::<[u8; 4]>()) {
            let mut values = bits.map(f64::from);
            for (value, shift) in values.iter_mut().zip(shifts) {
                *value *= f64::from(i32::from(shift % 90) - 45).exp2();
            }
            let near = values.map(|value| Near { value, error: 0.0 });
            let [a, b, c, d] = &near;
            let found = a.times(d).minus(&b.times(c)).sign();
            let [a, b, c, d] = &long(values);
            let exact = a.times(d).minus(&b.times(c)).sign();
            prop_assert!(found.is_none() || found == exact);
            if let Some([a, b, c, d]) = whole(values) {
                prop_assert_eq!(a.times(&d).minus(&b.times(&c)).sign(), exact);
            }
        }
    }
}
