//! A function of x, y, z as a list of steps, and what it can be asked.
//!
//! Each step makes one number of a point, of a constant, or of one or two numbers made before it; no number is made
//! twice (`tape/build.rs`). The same list is read with four kinds of numbers: plain ones, for many points at once
//! (`rows.rs`) or for one; numbers with derivatives (`jets.rs`); and ranges, which say what the steps make anywhere in a
//! box (`range.rs`). Where of two operands of a maximum or minimum one has the say all over a box, the list is cut short
//! for that box (`shorten.rs`): Keeter, "Massively parallel rendering of complex closed-form implicit surfaces", 2020,
//! sections 3 and 4. `fidget`, which goes back to that paper, computes values in f32; vertices to 10⁻⁶ of a diameter need f64.
//!
//! Everywhere a step is the same function of the same f64, so all ways to a value lead to the same bits. Sines, cosines,
//! logarithms and powers are those of the crate `libm`, which are the same on every machine.

mod build;
mod jets;
mod listing;
mod range;
mod rows;
mod shorten;

pub(crate) use build::{Builder, Full};
pub(crate) use range::Range;

use jets::{Dual, Steep};

/// A function of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Unary {
    Neg,
    Abs,
    Sqrt,
    Square,
    Floor,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Exp,
    Ln,
}

/// A function of two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    /// The first if it is less, otherwise the second; so the second where one of them is NaN.
    Min,
    /// The first if it is greater, otherwise the second.
    Max,
    Pow,
    Atan2,
    /// The size of the first with the sign of the second.
    Signed,
}

/// A step: a number, made of those of earlier steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    Constant(f64),
    /// The coordinate of the point along axis 0, 1 or 2.
    Axis(u8),
    Unary(Unary, u32),
    Binary(Binary, u32, u32),
}

impl Unary {
    #[inline(always)]
    pub(crate) fn of(self, a: f64) -> f64 {
        match self {
            Self::Neg => -a,
            Self::Abs => a.abs(),
            Self::Sqrt => a.sqrt(),
            Self::Square => a * a,
            Self::Floor => a.floor(),
            Self::Sin => libm::sin(a),
            Self::Cos => libm::cos(a),
            Self::Tan => libm::tan(a),
            Self::Asin => libm::asin(a),
            Self::Acos => libm::acos(a),
            Self::Atan => libm::atan(a),
            Self::Exp => libm::exp(a),
            Self::Ln => libm::log(a),
        }
    }
}

impl Binary {
    #[inline(always)]
    pub(crate) fn of(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Sub => a - b,
            Self::Mul => a * b,
            Self::Div => a / b,
            Self::Min => {
                if a < b {
                    a
                } else {
                    b
                }
            }
            Self::Max => {
                if a > b {
                    a
                } else {
                    b
                }
            }
            Self::Pow => libm::pow(a, b),
            Self::Atan2 => libm::atan2(a, b),
            Self::Signed => a.copysign(b),
        }
    }
}

impl Step {
    /// The steps that this one needs.
    pub(crate) fn needs(self) -> impl Iterator<Item = u32> {
        let (a, b) = match self {
            Self::Constant(_) | Self::Axis(_) => (None, None),
            Self::Unary(_, a) => (Some(a), None),
            Self::Binary(_, a, b) => (Some(a), Some(b)),
        };
        a.into_iter().chain(b)
    }

    /// The same step of others.
    pub(crate) fn renamed(self, name: impl Fn(u32) -> u32) -> Self {
        match self {
            Self::Unary(code, a) => Self::Unary(code, name(a)),
            Self::Binary(code, a, b) => Self::Binary(code, name(a), name(b)),
            other => other,
        }
    }
}

/// A function of x, y, z: the number that the last step makes.
///
/// # Guarantees
///
/// There is a step. Each needs earlier ones only, and is needed by a later one unless it is the last.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tape {
    steps: Vec<Step>,
}

/// Numbers of so many steps are kept without asking for memory.
const FEW: usize = 192;

impl Tape {
    /// How many steps there are.
    pub(crate) fn len(&self) -> usize {
        self.steps.len()
    }

    /// The value at a point.
    pub(crate) fn value(&self, point: [f64; 3]) -> f64 {
        if self.steps.len() <= FEW {
            let mut numbers = [0.0; FEW];
            self.values(point, &mut numbers)
        } else {
            self.values(point, &mut vec![0.0; self.steps.len()])
        }
    }

    fn values(&self, point: [f64; 3], numbers: &mut [f64]) -> f64 {
        let mut last = 0.0;
        for (n, step) in self.steps.iter().enumerate() {
            last = match *step {
                Step::Constant(value) => value,
                Step::Axis(axis) => point[usize::from(axis)],
                Step::Unary(code, a) => code.of(numbers[a as usize]),
                Step::Binary(code, a, b) => code.of(numbers[a as usize], numbers[b as usize]),
            };
            numbers[n] = last;
        }
        last
    }

    /// Value, gradient and second derivatives at a point.
    pub(crate) fn jet(&self, point: [f64; 3]) -> Dual {
        let mut numbers: Vec<Dual> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            let number = match *step {
                Step::Constant(value) => Dual::constant(value),
                Step::Axis(axis) => Dual::axis(axis, point[usize::from(axis)]),
                Step::Unary(code, a) => numbers[a as usize].unary(code),
                Step::Binary(code, a, b) => numbers[a as usize].binary(code, &numbers[b as usize]),
            };
            numbers.push(number);
        }
        *numbers.last().expect("a tape has a step")
    }

    /// Value and gradient at a point: those of [`jet`](Self::jet), to the bit.
    pub(crate) fn slope(&self, point: [f64; 3]) -> Steep {
        let mut numbers: Vec<Steep> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            // Put at its place by each arm: a number that is written in halves and read as a whole at once is waited for. So it takes
            // half the time (AMD EPYC of 2024, parts of `fixtures/shapes`, 2026-11).
            match *step {
                Step::Constant(value) => numbers.push(Steep::constant(value)),
                Step::Axis(axis) => numbers.push(Steep::axis(axis, point[usize::from(axis)])),
                Step::Unary(code, a) => numbers.push(numbers[a as usize].unary(code)),
                Step::Binary(code, a, b) => {
                    numbers.push(numbers[a as usize].binary(code, &numbers[b as usize]));
                }
            }
        }
        *numbers.last().expect("a tape has a step")
    }

    /// What each step makes somewhere in a box.
    fn ranges(&self, inside: [Range; 3]) -> Vec<Range> {
        let mut ranges: Vec<Range> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            let range = match *step {
                Step::Constant(value) => Range::constant(value),
                Step::Axis(axis) => inside[usize::from(axis)],
                Step::Unary(code, a) => ranges[a as usize].unary(code),
                // A number of both signs times itself has one.
                Step::Binary(Binary::Mul, a, b) if a == b => {
                    ranges[a as usize].unary(Unary::Square)
                }
                Step::Binary(code, a, b) => ranges[a as usize].binary(code, ranges[b as usize]),
            };
            ranges.push(range);
        }
        ranges
    }

    /// What the function is somewhere in a box.
    pub(crate) fn range(&self, inside: [Range; 3]) -> Range {
        *self.ranges(inside).last().expect("a tape has a step")
    }
}

#[cfg(test)]
mod tests;
