//! How a tape comes about: step by step, none twice, and none of constants only.

use super::{Binary, Step, Tape, Unary};
use std::collections::BTreeMap;

/// Steps so far. A step is named by its number.
#[derive(Debug)]
pub(crate) struct Builder {
    steps: Vec<Step>,
    known: BTreeMap<(u8, u64, u64), u32>,
    most: usize,
}

impl Default for Builder {
    fn default() -> Self {
        Self { steps: vec![], known: BTreeMap::new(), most: Self::MOST }
    }
}

/// There would be more steps than [`Builder::MOST`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Full;

impl Builder {
    /// More steps than this are taken for a mistake: an array of an array of an array.
    pub(crate) const MOST: usize = 1 << 17;

    /// The step that makes what `step` does; a new one if there is none.
    pub(crate) fn step(&mut self, step: Step) -> Result<u32, Full> {
        let step = self.simplified(step);
        let step = match step {
            Ok(step) => step,
            Err(known) => return Ok(known),
        };
        let key = match step {
            Step::Constant(value) => (0, value.to_bits(), 0),
            Step::Axis(axis) => (1, u64::from(axis), 0),
            Step::Unary(code, a) => (2 + code as u8, u64::from(a), 0),
            Step::Binary(code, a, b) => (64 + code as u8, u64::from(a), u64::from(b)),
        };
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        if self.steps.len() >= self.most {
            return Err(Full);
        }
        let name = self.steps.len() as u32;
        self.steps.push(step);
        self.known.insert(key, name);
        Ok(name)
    }

    /// The same number from less: a constant, or a step that is there. What is left out changes no number but the sign
    /// of a 0.
    fn simplified(&self, step: Step) -> Result<Step, u32> {
        let constant = |name: u32| match self.steps[name as usize] {
            Step::Constant(value) => Some(value),
            _ => None,
        };
        match step {
            Step::Unary(code, a) => match (constant(a), self.steps[a as usize]) {
                (Some(value), _) => Ok(Step::Constant(code.of(value))),
                (_, Step::Unary(Unary::Neg, b)) if code == Unary::Neg => Err(b),
                (_, Step::Unary(Unary::Neg, b)) if [Unary::Abs, Unary::Square].contains(&code) => {
                    Ok(Step::Unary(code, b))
                }
                _ => Ok(step),
            },
            Step::Binary(code, a, b) => match (code, constant(a), constant(b)) {
                (_, Some(a), Some(b)) => Ok(Step::Constant(code.of(a, b))),
                (Binary::Add, _, Some(0.0)) | (Binary::Sub, _, Some(0.0)) => Err(a),
                (Binary::Mul, _, Some(1.0)) | (Binary::Div, _, Some(1.0)) => Err(a),
                (Binary::Add, Some(0.0), _) | (Binary::Mul, Some(1.0), _) => Err(b),
                (Binary::Min | Binary::Max, ..) if a == b => Err(a),
                (Binary::Mul, ..) if a == b => Ok(Step::Unary(Unary::Square, a)),
                (Binary::Add | Binary::Mul, ..) if a > b => Ok(Step::Binary(code, b, a)),
                _ => Ok(step),
            },
            Step::Constant(_) | Step::Axis(_) => Ok(step),
        }
    }

    pub(crate) fn constant(&mut self, value: f64) -> Result<u32, Full> {
        self.step(Step::Constant(value))
    }

    pub(crate) fn unary(&mut self, code: Unary, a: u32) -> Result<u32, Full> {
        self.step(Step::Unary(code, a))
    }

    pub(crate) fn binary(&mut self, code: Binary, a: u32, b: u32) -> Result<u32, Full> {
        self.step(Step::Binary(code, a, b))
    }

    pub(crate) fn with(&mut self, code: Binary, a: u32, value: f64) -> Result<u32, Full> {
        let value = self.constant(value)?;
        self.binary(code, a, value)
    }

    /// √(a² + b² + …).
    pub(crate) fn length(&mut self, parts: &[u32]) -> Result<u32, Full> {
        let mut sum = self.constant(0.0)?;
        for &part in parts {
            let square = self.unary(Unary::Square, part)?;
            sum = self.binary(Binary::Add, sum, square)?;
        }
        self.unary(Unary::Sqrt, sum)
    }

    /// a·x + b·y + … + shift.
    pub(crate) fn affine(&mut self, terms: &[(f64, u32)], shift: f64) -> Result<u32, Full> {
        let mut sum = self.constant(0.0)?;
        for &(factor, term) in terms.iter().filter(|(factor, _)| *factor != 0.0) {
            let product = match factor == -1.0 {
                true => self.unary(Unary::Neg, term)?,
                false => self.with(Binary::Mul, term, factor)?,
            };
            sum = self.binary(Binary::Add, sum, product)?;
        }
        self.with(Binary::Add, sum, shift)
    }

    /// The steps that lead to `last`.
    pub(crate) fn tape(&self, last: u32) -> Tape {
        Tape::ending(self.steps[..=last as usize].to_vec())
    }
}

impl Tape {
    /// The same function of a point that a matrix, row by row, and a shift make of x, y, z.
    pub(crate) fn mapped(&self, rows: [[f64; 3]; 3], by: [f64; 3]) -> Self {
        let mut builder = Builder { most: usize::MAX, ..Builder::default() };
        let mut map = || {
            let mut axes = [0; 3];
            for (axis, step) in axes.iter_mut().enumerate() {
                *step = builder.step(Step::Axis(axis as u8))?;
            }
            let mut point = axes;
            for axis in 0..3 {
                let terms = [0, 1, 2].map(|k| (rows[axis][k], axes[k]));
                point[axis] = builder.affine(&terms, by[axis])?;
            }
            let mut names: Vec<u32> = Vec::with_capacity(self.steps.len());
            for step in &self.steps {
                names.push(match *step {
                    Step::Axis(axis) => point[usize::from(axis)],
                    step => builder.step(step.renamed(|a| names[a as usize]))?,
                });
            }
            Ok::<_, Full>(builder.tape(*names.last().expect("a tape has a step")))
        };
        map().expect("there is no limit")
    }
}
