//! From letters to steps.

use super::FormulaError;
use crate::tape::{Binary, Step, Unary};

/// Parentheses within each other, signs and powers; more are taken for a mistake.
const DEEPEST: usize = 64;

/// More letters than this too.
const LONGEST: usize = 1 << 16;

const OPERAND: &str = "a number, x, y, z, a function or (";

#[derive(Clone, Copy, Debug, PartialEq)]
enum Token<'t> {
    Number(f64),
    Word(&'t str),
    Sign(char),
    End,
}

struct Parser<'t> {
    text: &'t str,
    /// Where the token that comes next begins and ends, in bytes.
    start: usize,
    end: usize,
    token: Token<'t>,
    steps: Vec<Step>,
    depth: usize,
}

pub(super) fn steps(text: &str) -> Result<Vec<Step>, FormulaError> {
    let mut parser = Parser { text, start: 0, end: 0, token: Token::End, steps: vec![], depth: 0 };
    if text.len() > LONGEST {
        return Err(parser.refused(&format!("at most {LONGEST} letters")));
    }
    parser.next()?;
    let last = parser.expression(0)?;
    match parser.token {
        Token::End => {}
        _ => return Err(parser.refused("an operator or the end")),
    }
    debug_assert_eq!(last as usize + 1, parser.steps.len());
    Ok(parser.steps)
}

impl<'t> Parser<'t> {
    fn refused(&self, expected: &str) -> FormulaError {
        let found = match self.token {
            Token::End if self.text.len() > LONGEST => "more".into(),
            Token::End if self.start >= self.text.len() => "the end".into(),
            _ => format!("\"{}\"", &self.text[self.start..self.end]),
        };
        let column = self.text[..self.start].chars().count() + 1;
        let text = if self.text.len() > 200 {
            String::new()
        } else {
            self.text.replace(['\n', '\t'], " ")
        };
        FormulaError { column, expected: expected.into(), found, text }
    }

    /// Goes to the token that comes next.
    fn next(&mut self) -> Result<(), FormulaError> {
        let rest = &self.text[self.end..];
        let rest_trimmed = rest.trim_start();
        self.start = self.text.len() - rest_trimmed.len();
        self.end = self.start;
        let Some(first) = rest_trimmed.chars().next() else {
            self.token = Token::End;
            return Ok(());
        };
        let while_is =
            |is: fn(char) -> bool| rest_trimmed.find(|c| !is(c)).unwrap_or(rest_trimmed.len());
        if first.is_ascii_digit() || first == '.' {
            let mut length = while_is(|c| c.is_ascii_digit() || c == '.');
            length += exponent(&rest_trimmed[length..]);
            self.end = self.start + length;
            let number = rest_trimmed[..length].parse();
            let Ok(number) = number else {
                return Err(self.refused("a number such as 2.5 or 1e-3"));
            };
            self.token = Token::Number(number);
        } else if first.is_ascii_alphabetic() {
            let length = while_is(|c| c.is_ascii_alphanumeric() || c == '_');
            self.end = self.start + length;
            self.token = Token::Word(&rest_trimmed[..length]);
        } else {
            self.end = self.start + first.len_utf8();
            self.token = Token::Sign(first);
            if !"+-*/^(),".contains(first) {
                return Err(self.refused("+ - * / ^ ( ) a comma, a number or a word"));
            }
        }
        Ok(())
    }

    fn push(&mut self, step: Step) -> u32 {
        self.steps.push(step);
        self.steps.len() as u32 - 1
    }

    fn unary(&mut self, code: Unary, a: u32) -> u32 {
        self.push(Step::Unary(code, a))
    }

    fn binary(&mut self, code: Binary, a: u32, b: u32) -> u32 {
        self.push(Step::Binary(code, a, b))
    }

    fn expect(&mut self, sign: char) -> Result<(), FormulaError> {
        match self.token == Token::Sign(sign) {
            true => self.next(),
            false => Err(self.refused(&format!("\"{sign}\""))),
        }
    }

    /// Operands joined by operators that bind at least so strongly.
    fn expression(&mut self, least: u8) -> Result<u32, FormulaError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.refused(&format!("at most {DEEPEST} levels within each other")));
        }
        let mut left = self.operand()?;
        while let Token::Sign(sign) = self.token {
            let (code, own, right) = match sign {
                '+' => (Binary::Add, 1, 2),
                '-' => (Binary::Sub, 1, 2),
                '*' => (Binary::Mul, 3, 4),
                '/' => (Binary::Div, 3, 4),
                '^' => (Binary::Pow, 7, 6),
                _ => break,
            };
            if own < least {
                break;
            }
            self.next()?;
            let other = self.expression(right)?;
            left = self.binary(code, left, other);
        }
        self.depth -= 1;
        Ok(left)
    }

    fn operand(&mut self) -> Result<u32, FormulaError> {
        match self.token {
            Token::Number(number) => {
                self.next()?;
                Ok(self.push(Step::Constant(number)))
            }
            Token::Sign(sign @ ('-' | '+')) => {
                self.next()?;
                let operand = self.expression(5)?;
                Ok(if sign == '-' { self.unary(Unary::Neg, operand) } else { operand })
            }
            Token::Sign('(') => {
                self.next()?;
                let inner = self.expression(0)?;
                self.expect(')')?;
                Ok(inner)
            }
            Token::Word(word) => self.word(word),
            _ => Err(self.refused(OPERAND)),
        }
    }

    fn word(&mut self, word: &str) -> Result<u32, FormulaError> {
        let single = match word {
            "x" => Some(Step::Axis(0)),
            "y" => Some(Step::Axis(1)),
            "z" => Some(Step::Axis(2)),
            "pi" => Some(Step::Constant(std::f64::consts::PI)),
            "e" => Some(Step::Constant(std::f64::consts::E)),
            _ => None,
        };
        if let Some(step) = single {
            self.next()?;
            return Ok(self.push(step));
        }
        if !FUNCTIONS.iter().any(|(name, _)| *name == word) {
            let names: Vec<&str> = FUNCTIONS.iter().map(|(name, _)| *name).collect();
            return Err(self.refused(&format!("x, y, z, pi, e or one of {}", names.join(" "))));
        }
        let place = (self.start, self.end, self.token);
        self.next()?;
        self.expect('(')?;
        let mut arguments = vec![self.expression(0)?];
        while self.token == Token::Sign(',') {
            self.next()?;
            arguments.push(self.expression(0)?);
        }
        self.expect(')')?;
        match self.call(word, &arguments) {
            Some(step) => Ok(step),
            None => {
                (self.start, self.end, self.token) = place;
                let wanted = FUNCTIONS.iter().find(|(name, _)| *name == word);
                let wanted = wanted.map_or("", |(_, wanted)| wanted);
                let mut error = self.refused(&format!("{word} of {wanted}"));
                error.found = format!("{} of them", arguments.len());
                Err(error)
            }
        }
    }

    /// The value of a function; none if it does not take so many arguments.
    fn call(&mut self, word: &str, arguments: &[u32]) -> Option<u32> {
        let unary = match word {
            "sqrt" => Some(Unary::Sqrt),
            "abs" => Some(Unary::Abs),
            "floor" => Some(Unary::Floor),
            "sin" => Some(Unary::Sin),
            "cos" => Some(Unary::Cos),
            "tan" => Some(Unary::Tan),
            "asin" => Some(Unary::Asin),
            "acos" => Some(Unary::Acos),
            "atan" => Some(Unary::Atan),
            "exp" => Some(Unary::Exp),
            "ln" => Some(Unary::Ln),
            _ => None,
        };
        match (unary, word, arguments) {
            (Some(code), _, &[a]) => Some(self.unary(code, a)),
            (_, "atan2", &[a, b]) => Some(self.binary(Binary::Atan2, a, b)),
            (_, "pow", &[a, b]) => Some(self.binary(Binary::Pow, a, b)),
            (_, "mod", &[a, b]) => {
                let turns = self.binary(Binary::Div, a, b);
                let turns = self.unary(Unary::Floor, turns);
                let whole = self.binary(Binary::Mul, b, turns);
                Some(self.binary(Binary::Sub, a, whole))
            }
            (_, "clamp", &[a, least, most]) => {
                let raised = self.binary(Binary::Max, a, least);
                Some(self.binary(Binary::Min, raised, most))
            }
            (_, "min" | "max", &[first, ref rest @ ..]) if !rest.is_empty() => {
                let code = if word == "min" { Binary::Min } else { Binary::Max };
                Some(rest.iter().fold(first, |all, &next| self.binary(code, all, next)))
            }
            (_, "length", all) => {
                let mut sum = None;
                for &part in all {
                    let square = self.unary(Unary::Square, part);
                    sum = Some(sum.map_or(square, |sum| self.binary(Binary::Add, sum, square)));
                }
                sum.map(|sum| self.unary(Unary::Sqrt, sum))
            }
            _ => None,
        }
    }
}

/// The functions, and what they take.
const FUNCTIONS: [(&str, &str); 18] = [
    ("sqrt", ONE),
    ("abs", ONE),
    ("floor", ONE),
    ("sin", ONE),
    ("cos", ONE),
    ("tan", ONE),
    ("asin", ONE),
    ("acos", ONE),
    ("atan", ONE),
    ("exp", ONE),
    ("ln", ONE),
    ("atan2", "two numbers"),
    ("pow", "two numbers"),
    ("mod", "two numbers"),
    ("min", "two numbers or more"),
    ("max", "two numbers or more"),
    ("length", "one number or more"),
    ("clamp", "a number, the least and the most"),
];
const ONE: &str = "one number";

/// How long the exponent of a number is; 0 if there is none.
fn exponent(rest: &str) -> usize {
    let Some(after) = rest.strip_prefix(['e', 'E']) else { return 0 };
    let digits = after.strip_prefix(['-', '+']).unwrap_or(after);
    let count = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    if count == 0 { 0 } else { rest.len() - digits.len() + count }
}
