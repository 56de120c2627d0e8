//! What steps make in a box: ranges of numbers.
//!
//! The bounds of a sum, difference, product, quotient or root are made with the same rounding as the numbers between
//! them. Rounding keeps order, so they hold for numbers *as computed*, with no margin. Functions of `libm` are within a
//! unit in the last place of what they stand for, but need not keep order between neighbours: their bounds are a few
//! units wider.

use super::{Binary, Unary};
use std::f64::consts::{FRAC_PI_2, PI};

/// All numbers from `low` to `high`, and NaN if `none` says so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Whether a number may be NaN.
    pub(crate) none: bool,
}

impl Range {
    const ALL: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY, none: true };

    pub(crate) fn new(low: f64, high: f64) -> Self {
        // Also where one of them is NaN.
        if low <= high { Self { low, high, none: false } } else { Self::ALL }
    }

    pub(super) fn constant(value: f64) -> Self {
        Self::new(value, value)
    }

    fn is_finite(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    fn or_none(self, none: bool) -> Self {
        Self { none: self.none || none, ..self }
    }

    /// A little wider: for functions that are not rounded to the nearest.
    fn wider(self) -> Self {
        let margin = |x: f64| match x.is_finite() {
            true => x.abs() * (8.0 * f64::EPSILON) + f64::MIN_POSITIVE,
            false => 0.0,
        };
        Self { low: self.low - margin(self.low), high: self.high + margin(self.high), ..self }
    }

    fn within(self, low: f64, high: f64) -> Self {
        Self { low: self.low.max(low), high: self.high.min(high), ..self }
    }

    /// Of a function that rises.
    fn rising(self, of: impl Fn(f64) -> f64) -> Self {
        Self::new(of(self.low), of(self.high))
    }

    /// Whether of a maximum or minimum the first operand is chosen everywhere, or the second; or now one and now the
    /// other.
    pub(super) fn wins(self, code: Binary, other: Self) -> Option<bool> {
        let (always, never) = match code {
            Binary::Max => (self.low > other.high, self.high <= other.low),
            _ => (self.high < other.low, self.low >= other.high),
        };
        // The second is chosen wherever one is NaN, too.
        match (always && !self.none && !other.none, never) {
            (true, _) => Some(true),
            (_, true) => Some(false),
            _ => None,
        }
    }

    pub(super) fn unary(self, code: Unary) -> Self {
        let Self { low, high, none } = self;
        let found = match code {
            Unary::Neg => Self::new(-high, -low),
            Unary::Abs | Unary::Square => {
                let (a, b) = (code.of(low), code.of(high));
                let least = if low <= 0.0 && high >= 0.0 { 0.0 } else { a.min(b) };
                Self::new(least, a.max(b))
            }
            Unary::Sqrt if high < 0.0 => Self::ALL,
            Unary::Sqrt => Self::new(low.max(0.0).sqrt(), high.sqrt()).or_none(low < 0.0),
            Unary::Floor => self.rising(f64::floor),
            Unary::Sin => self.wave(-FRAC_PI_2),
            Unary::Cos => self.wave(0.0),
            Unary::Tan => self.tangent(),
            Unary::Asin | Unary::Acos if high < -1.0 || low > 1.0 => Self::ALL,
            Unary::Asin | Unary::Acos => {
                let [a, b] = [low, high].map(|x| code.of(x.clamp(-1.0, 1.0)));
                Self::new(a.min(b), a.max(b)).wider().or_none(low < -1.0 || high > 1.0)
            }
            Unary::Atan => self.rising(libm::atan).wider(),
            Unary::Exp => self.rising(libm::exp).wider().within(0.0, f64::INFINITY),
            Unary::Ln if high < 0.0 => Self::ALL,
            Unary::Ln => {
                self.within(0.0, f64::INFINITY).rising(libm::log).wider().or_none(low < 0.0)
            }
        };
        found.or_none(none)
    }

    /// Of a wave that is −1 where sin is for `shift` −π/2, and 1 where cos is for 0: greatest at every 2π from `-shift`.
    fn wave(self, shift: f64) -> Self {
        let Self { low, high, .. } = self;
        if !self.is_finite() {
            return Self::new(-1.0, 1.0).or_none(true);
        }
        // So far from 0 that neighbours are farther from each other than this tells apart.
        if high - low >= 2.0 * PI || low.abs().max(high.abs()) > 1e8 {
            return Self::new(-1.0, 1.0);
        }
        let of = |x: f64| if shift == 0.0 { libm::cos(x) } else { libm::sin(x) };
        let (a, b) = (of(low), of(high));
        // Whether some number is a whole number of turns from `place`, give or take a little.
        let meets = |place: f64| {
            let turns = |x: f64| (x - place) / (2.0 * PI);
            (turns(high) + 1e-7).floor() >= (turns(low) - 1e-7).ceil()
        };
        let high = if meets(-shift) { 1.0 } else { a.max(b) };
        let low = if meets(PI - shift) { -1.0 } else { a.min(b) };
        Self::new(low, high).wider().within(-1.0, 1.0)
    }

    /// Rises between poles at odd multiples of π/2.
    fn tangent(self) -> Self {
        let branch = |x: f64| (x / PI + 0.5).floor();
        let [a, b] = [branch(self.low - 1e-7), branch(self.high + 1e-7)];
        match self.is_finite() && a == b && self.low.abs().max(self.high.abs()) < 1e8 {
            true => self.rising(libm::tan).wider(),
            false => Self::ALL,
        }
    }

    pub(super) fn binary(self, code: Binary, other: Self) -> Self {
        let (a, b) = (self, other);
        // Infinite numbers may add up to none.
        let endless = !(a.is_finite() && b.is_finite());
        let found = match code {
            Binary::Add => Self::new(a.low + b.low, a.high + b.high).or_none(endless),
            Binary::Sub => Self::new(a.low - b.high, a.high - b.low).or_none(endless),
            Binary::Mul => a.corners(b, |a, b| a * b).or_none(endless),
            Binary::Div if b.low > 0.0 || b.high < 0.0 => {
                a.corners(b, |a, b| a / b).or_none(endless)
            }
            Binary::Div => Self::ALL,
            Binary::Min | Binary::Max => return a.chosen(code, b),
            Binary::Pow => a.power(b),
            Binary::Atan2 if b.low > 0.0 && !endless => {
                a.corners(b, libm::atan2).wider().within(-PI, PI)
            }
            Binary::Atan2 => Self::new(-PI, PI).wider(),
            Binary::Signed => {
                let size = a.unary(Unary::Abs);
                match (b.low > 0.0, b.high < 0.0) {
                    _ if b.none => Self::new(-size.high, size.high),
                    (true, _) => size,
                    (_, true) => Self::new(-size.high, -size.low),
                    _ => Self::new(-size.high, size.high),
                }
            }
        };
        found.or_none(a.none || b.none)
    }

    /// Of a function that along each of its two numbers rises or falls.
    fn corners(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let all = [
            of(self.low, other.low),
            of(self.low, other.high),
            of(self.high, other.low),
            of(self.high, other.high),
        ];
        if all.iter().any(|x| x.is_nan()) {
            return Self::ALL;
        }
        let least = all.into_iter().fold(f64::INFINITY, f64::min);
        Self::new(least, all.into_iter().fold(f64::NEG_INFINITY, f64::max))
    }

    /// Of a maximum or minimum. Where one is NaN it is the second.
    fn chosen(self, code: Binary, other: Self) -> Self {
        let (a, b) = (self, other);
        let (low, high) = match code {
            Binary::Max => (a.low.max(b.low), a.high.max(b.high)),
            _ => (a.low.min(b.low), a.high.min(b.high)),
        };
        let found = Self::new(low, high);
        match a.none || b.none {
            // The second by itself, too.
            true => Self::new(found.low.min(b.low), found.high.max(b.high)).or_none(b.none),
            false => found,
        }
    }

    fn power(self, other: Self) -> Self {
        let exponent = (other.low == other.high).then_some(other.low);
        let whole = exponent.filter(|n| n.fract() == 0.0 && *n >= 0.0 && n.abs() < 1e9);
        match whole {
            _ if !(self.is_finite() && other.is_finite()) => Self::ALL,
            Some(n) => {
                let (a, b) = (libm::pow(self.low, n), libm::pow(self.high, n));
                let meets_0 = self.low <= 0.0 && self.high >= 0.0;
                let least = if n % 2.0 == 0.0 && meets_0 && n > 0.0 { 0.0 } else { a.min(b) };
                Self::new(least, a.max(b)).wider()
            }
            None if self.low > 0.0 => self.corners(other, libm::pow).wider(),
            None if self.low == 0.0 && other.low > 0.0 => self.corners(other, libm::pow).wider(),
            None => Self::ALL,
        }
    }
}
