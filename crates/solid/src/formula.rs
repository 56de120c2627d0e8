//! A formula in x, y, z, as somebody writes it.
//!
//! A parser by binding powers (Pratt, "Top down operator precedence", 1973) that writes the steps of a tape. A crate that
//! takes operands of one's own (`exmex`) brings regular expressions and a tower of number types with it, for less than what
//! stands here.

mod parse;

use crate::tape::{Binary, Builder, Full, Step, Unary};
use serde::Deserialize;
use std::str::FromStr;

/// An expression in x, y and z.
///
/// Numbers, `x y z pi e`, `+ - * / ^` with parentheses, and `sqrt abs floor sin cos tan asin acos atan exp ln`,
/// `min max` of two or more, `atan2(a, b)`, `mod(a, b)` between 0 and b, `length` of one or more, `clamp(a, least, most)`,
/// `pow(a, b)`. `^` binds strongest and from the right, then a sign, then `* /`, then `+ -`: `-x^2` is −(x²). Angles are
/// in radians.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub struct Formula {
    text: String,
    /// Each names earlier ones; the last is the value.
    steps: Vec<Step>,
}

/// A formula that is none, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("column {column}: expected {expected}, found {found}{}", self.drawing())]
pub struct FormulaError {
    /// Counted in letters, from 1.
    pub column: usize,
    /// What may stand there.
    pub expected: String,
    /// What does.
    pub found: String,
    /// The formula.
    pub text: String,
}

impl FormulaError {
    /// The formula with a mark below the place.
    fn drawing(&self) -> String {
        match self.text.is_empty() {
            true => String::new(),
            false => format!("\n  {}\n  {:>width$}", self.text, '^', width = self.column),
        }
    }
}

impl FromStr for Formula {
    type Err = FormulaError;

    fn from_str(text: &str) -> Result<Self, FormulaError> {
        let steps = parse::steps(text)?;
        Ok(Self { text: text.to_owned(), steps })
    }
}

impl TryFrom<String> for Formula {
    type Error = FormulaError;

    fn try_from(text: String) -> Result<Self, FormulaError> {
        text.parse()
    }
}

impl Formula {
    /// The formula as it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Writes its steps for the point that three steps make.
    pub(crate) fn build(&self, builder: &mut Builder, point: [u32; 3]) -> Result<u32, Full> {
        let mut names: Vec<u32> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            let name = match *step {
                Step::Axis(axis) => point[usize::from(axis)],
                Step::Binary(Binary::Pow, a, b) => match self.steps[b as usize] {
                    Step::Constant(n) if n.fract() == 0.0 && (0.0..=64.0).contains(&n) => {
                        power(builder, names[a as usize], n as u32)?
                    }
                    _ => builder.binary(Binary::Pow, names[a as usize], names[b as usize])?,
                },
                step => builder.step(step.renamed(|a| names[a as usize]))?,
            };
            names.push(name);
        }
        Ok(*names.last().expect("a formula has a step"))
    }
}

/// By squares and products: faster than a logarithm, and with bounds that know the sign.
fn power(builder: &mut Builder, base: u32, exponent: u32) -> Result<u32, Full> {
    match exponent {
        0 => builder.constant(1.0),
        1 => Ok(base),
        n => {
            let half = power(builder, base, n / 2)?;
            let square = builder.unary(Unary::Square, half)?;
            if n % 2 == 0 { Ok(square) } else { builder.binary(Binary::Mul, square, base) }
        }
    }
}

#[cfg(test)]
mod tests;
