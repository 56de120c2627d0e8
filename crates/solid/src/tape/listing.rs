//! A tape as text, for programs that read such.

use super::{Binary, Step, Tape, Unary};
use std::fmt::Write;

impl Tape {
    /// A line for each step: its name, what it does, and the names of those it needs. None if a step has no word in that
    /// language.
    pub(crate) fn listing(&self) -> Option<String> {
        let mut text = String::new();
        for (n, step) in self.steps.iter().enumerate() {
            let says = match *step {
                Step::Constant(value) => format!("const {value:?}"),
                Step::Axis(axis) => format!("var-{}", ["x", "y", "z"][usize::from(axis)]),
                Step::Unary(code, a) => format!("{} _{a:x}", of_one(code)),
                Step::Binary(Binary::Signed, a, b) => {
                    // A sign is that of a comparison, or else 1.
                    writeln!(text, "_{n:x}.0 const 0.0\n_{n:x}.1 compare _{b:x} _{n:x}.0").ok()?;
                    writeln!(text, "_{n:x}.2 const 1.0\n_{n:x}.3 or _{n:x}.1 _{n:x}.2").ok()?;
                    writeln!(text, "_{n:x}.4 abs _{a:x}").ok()?;
                    format!("mul _{n:x}.4 _{n:x}.3")
                }
                Step::Binary(code, a, b) => format!("{} _{a:x} _{b:x}", of_two(code)?),
            };
            writeln!(text, "_{n:x} {says}").ok()?;
        }
        Some(text)
    }
}

fn of_one(code: Unary) -> &'static str {
    match code {
        Unary::Neg => "neg",
        Unary::Abs => "abs",
        Unary::Sqrt => "sqrt",
        Unary::Square => "square",
        Unary::Floor => "floor",
        Unary::Sin => "sin",
        Unary::Cos => "cos",
        Unary::Tan => "tan",
        Unary::Asin => "asin",
        Unary::Acos => "acos",
        Unary::Atan => "atan",
        Unary::Exp => "exp",
        Unary::Ln => "ln",
    }
}

fn of_two(code: Binary) -> Option<&'static str> {
    Some(match code {
        Binary::Add => "add",
        Binary::Sub => "sub",
        Binary::Mul => "mul",
        Binary::Div => "div",
        Binary::Min => "min",
        Binary::Max => "max",
        Binary::Atan2 => "atan2",
        Binary::Pow | Binary::Signed => return None,
    })
}
