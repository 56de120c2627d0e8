//! Numbers with first and second derivatives (forward mode).
//!
//! Where a derivative is infinite and what it is multiplied by is 0, the product counts as 0: inside of a box the root of
//! a square that is 0 all around has the slope 0, not none.

use super::{Binary, Unary};

/// A value with its derivatives along x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dual {
    pub(crate) value: f64,
    pub(crate) gradient: [f64; 3],
    pub(crate) hessian: [[f64; 3]; 3],
}

/// First and second derivatives of a function of two numbers: by a, by b, by a twice, by both, by b twice.
type Partials = [f64; 5];

/// A product in which 0 takes the upper hand.
#[inline]
fn times(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

impl Dual {
    pub(super) fn constant(value: f64) -> Self {
        Self { value, gradient: [0.0; 3], hessian: [[0.0; 3]; 3] }
    }

    pub(super) fn axis(axis: u8, value: f64) -> Self {
        let mut number = Self::constant(value);
        number.gradient[usize::from(axis)] = 1.0;
        number
    }

    pub(super) fn unary(&self, code: Unary) -> Self {
        let value = code.of(self.value);
        let [first, second] = slopes(code, self.value, value);
        self.chained(value, &Self::constant(0.0), [first, 0.0, second, 0.0, 0.0])
    }

    pub(super) fn binary(&self, code: Binary, other: &Self) -> Self {
        let value = code.of(self.value, other.value);
        match chosen(code, self.value, other.value) {
            Some(true) => *self,
            Some(false) => *other,
            None => self.chained(value, other, partials(code, self.value, other.value, value)),
        }
    }

    /// The chain rule.
    fn chained(&self, value: f64, other: &Self, [by_a, by_b, aa, ab, bb]: Partials) -> Self {
        if value.is_nan() {
            return Self { value, gradient: [f64::NAN; 3], hessian: [[f64::NAN; 3]; 3] };
        }
        let (p, q) = (self.gradient, other.gradient);
        let gradient = std::array::from_fn(|i| times(by_a, p[i]) + times(by_b, q[i]));
        let entry = |i: usize, j: usize| {
            let bent = times(by_a, self.hessian[i][j]) + times(by_b, other.hessian[i][j]);
            let mixed = times(p[i], q[j]) + times(q[i], p[j]);
            let own = times(aa, times(p[i], p[j])) + times(bb, times(q[i], q[j]));
            bent + (own + times(ab, mixed))
        };
        let hessian = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
        Self { value, gradient, hessian }
    }
}

/// A gradient, and its value last: as of [`Dual`], without what only second derivatives need. Four numbers in a row are
/// made and kept at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Steep(pub(crate) [f64; 4]);

impl Steep {
    #[inline]
    pub(super) fn constant(value: f64) -> Self {
        Self([0.0, 0.0, 0.0, value])
    }

    #[inline]
    pub(super) fn axis(axis: u8, value: f64) -> Self {
        let mut number = Self::constant(value);
        number.0[usize::from(axis)] = 1.0;
        number
    }

    #[inline(always)]
    pub(super) fn unary(&self, code: Unary) -> Self {
        let [.., own] = self.0;
        let value = code.of(own);
        let [first, _] = slopes(code, own, value);
        // Of an operand that is 0, as Dual adds it: so zeros have its sign.
        chained(value, self.0.map(|p| times(first, p) + 0.0))
    }

    #[inline(always)]
    pub(super) fn binary(&self, code: Binary, other: &Self) -> Self {
        let ([.., a], [.., b]) = (self.0, other.0);
        match chosen(code, a, b) {
            Some(true) => *self,
            Some(false) => *other,
            None => {
                let value = code.of(a, b);
                let [by_a, by_b, ..] = partials(code, a, b, value);
                let along = |k: usize| times(by_a, self.0[k]) + times(by_b, other.0[k]);
                chained(value, [along(0), along(1), along(2), along(3)])
            }
        }
    }
}

/// The chain rule's gradient, with its value.
#[inline(always)]
fn chained(value: f64, [x, y, z, _]: [f64; 4]) -> Steep {
    match value.is_nan() {
        true => Steep([f64::NAN, f64::NAN, f64::NAN, value]),
        false => Steep([x, y, z, value]),
    }
}

/// First and second derivative.
#[inline]
fn slopes(code: Unary, a: f64, value: f64) -> [f64; 2] {
    match code {
        Unary::Neg => [-1.0, 0.0],
        Unary::Abs => [1.0_f64.copysign(a), 0.0],
        Unary::Sqrt => [0.5 / value, -0.25 / (value * a)],
        Unary::Square => [2.0 * a, 2.0],
        Unary::Floor => [0.0, 0.0],
        Unary::Sin => [libm::cos(a), -value],
        Unary::Cos => [-libm::sin(a), -value],
        Unary::Tan => {
            let slope = 1.0 + value * value;
            [slope, 2.0 * value * slope]
        }
        Unary::Asin | Unary::Acos => {
            let sign = if code == Unary::Asin { 1.0 } else { -1.0 };
            let square = 1.0 - a * a;
            let slope = sign / square.sqrt();
            [slope, slope * a / square]
        }
        Unary::Atan => {
            let slope = 1.0 / (1.0 + a * a);
            [slope, -2.0 * a * slope * slope]
        }
        Unary::Exp => [value, value],
        Unary::Ln => [1.0 / a, -1.0 / (a * a)],
    }
}

/// Whether the number is the first one or the second.
#[inline]
fn chosen(code: Binary, a: f64, b: f64) -> Option<bool> {
    match code {
        Binary::Min => Some(a < b),
        Binary::Max => Some(a > b),
        _ => None,
    }
}

/// Of what is not chosen.
#[inline]
fn partials(code: Binary, a: f64, b: f64, value: f64) -> Partials {
    match code {
        Binary::Add => [1.0, 1.0, 0.0, 0.0, 0.0],
        Binary::Sub => [1.0, -1.0, 0.0, 0.0, 0.0],
        Binary::Mul => [b, a, 0.0, 1.0, 0.0],
        Binary::Div => {
            let over = 1.0 / b;
            [over, -value * over, 0.0, -over * over, 2.0 * value * over * over]
        }
        Binary::Min | Binary::Max => [0.0; 5],
        Binary::Pow => powers(a, b, value),
        Binary::Atan2 => {
            let square = a * a + b * b;
            let (p, q) = (b / square, a / square);
            [p, -q, -2.0 * p * q, q * q - p * p, 2.0 * p * q]
        }
        Binary::Signed => {
            let flips = a.is_sign_negative() != b.is_sign_negative();
            [if flips { -1.0 } else { 1.0 }, 0.0, 0.0, 0.0, 0.0]
        }
    }
}

/// Of aᵇ. Where the exponent does not change its logarithm does not matter, which a negative base has not.
fn powers(a: f64, b: f64, value: f64) -> Partials {
    let by_a = b * libm::pow(a, b - 1.0);
    let aa = b * (b - 1.0) * libm::pow(a, b - 2.0);
    match a > 0.0 {
        true => {
            let log = libm::log(a);
            let ab = libm::pow(a, b - 1.0) * (1.0 + b * log);
            [by_a, value * log, aa, ab, value * log * log]
        }
        false => [by_a, 0.0, aa, 0.0, 0.0],
    }
}
