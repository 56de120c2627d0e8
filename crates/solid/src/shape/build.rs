//! From a tree of shapes to the steps of a tape. What cannot be is refused with its place in the tree.

mod placing;
mod primitives;

pub(super) use placing::{IDENTITY, least, reflection, rotation};

use super::{Array, Combination, Shape};
use crate::tape::{Binary, Builder, Full, Step, Unary};
use isokit_geom::vector;
use placing::transposed;
use std::collections::BTreeMap;

/// A tree that is no solid, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{place}: {fault}")]
pub struct ShapeError {
    /// As in a file: `shape.difference[1].cylinder.radius`.
    pub place: String,
    /// What is wrong there.
    pub fault: ShapeFault,
}

/// What may be wrong with a tree of shapes. All of it is the caller's, or the file's.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeFault {
    /// A number is out of range.
    #[error("expected {expected}, found {found}")]
    Number {
        /// What it may be.
        expected: String,
        /// What it is.
        found: String,
    },
    /// A part is named that is not there.
    #[error("there is no part {0:?}")]
    NoPart(String),
    /// A part is made of itself.
    #[error("a part is made of itself: {0}")]
    Circle(String),
    /// Shapes are nested too deep.
    #[error("more than {} shapes within each other", MOST_DEEP)]
    TooDeep,
    /// A solid is made of too many steps.
    #[error("this takes more than {} steps: use smaller arrays", Builder::MOST)]
    TooLarge,
    /// A solid goes on without an end, and no bounds were given.
    #[error(
        "it has no end along {axis}: intersect it with a shape, or say what part is meant, with \
         bounds"
    )]
    Endless {
        /// `x`, `y` or `z`.
        axis: char,
    },
    /// Nothing is left of it.
    #[error("nothing is left of it")]
    Empty,
}

/// Shapes within each other.
pub(super) const MOST_DEEP: usize = 200;

/// Shapes and copies of them that are looked at: so many that all steps that may be are made, and then it has an end.
pub(super) const MOST_LOOKS: usize = 1 << 21;

/// Copies in one array.
const MOST_COPIES: u64 = 100_000;

/// What a tree becomes, and how it is on the way there.
pub(super) struct Build<'m> {
    pub(super) builder: Builder,
    parts: &'m BTreeMap<String, Shape>,
    /// Parts that were made, each for the point that three steps make.
    made: BTreeMap<(&'m str, [u32; 3]), u32>,
    /// Parts that are being made.
    open: Vec<&'m str>,
    place: Vec<String>,
    depth: usize,
    looks: usize,
}

type Point = [u32; 3];

impl<'m> Build<'m> {
    pub(super) fn new(parts: &'m BTreeMap<String, Shape>) -> Self {
        let place = vec!["shape".to_owned()];
        let (builder, made) = (Builder::default(), BTreeMap::new());
        Self { builder, parts, made, open: vec![], place, depth: 0, looks: 0 }
    }

    pub(super) fn axis(&mut self, axis: u8) -> Result<u32, ShapeError> {
        let made = self.builder.step(Step::Axis(axis));
        self.full(made)
    }

    /// Looks whether a part that may not be used is sound.
    pub(super) fn unused(&mut self, name: &'m str, p: Point) -> Result<(), ShapeError> {
        self.part(name, p).map(drop)
    }

    pub(super) fn refused(&self, fault: ShapeFault) -> ShapeError {
        ShapeError { place: self.place.join("."), fault }
    }

    fn number(
        &self,
        name: &str,
        value: f64,
        fits: bool,
        expected: &str,
    ) -> Result<f64, ShapeError> {
        if !fits || !value.is_finite() {
            return Err(self.off(name, expected, value));
        }
        // So that no product of a few overflows, and none that is not 0 vanishes.
        if value != 0.0 && !(1e-100..=1e100).contains(&value.abs()) {
            return Err(self.off(name, "a size from 1e-100 to 1e100", value));
        }
        Ok(value)
    }

    fn off(&self, name: &str, expected: &str, value: f64) -> ShapeError {
        let mut error = self
            .refused(ShapeFault::Number { expected: expected.into(), found: value.to_string() });
        error.place = format!("{}.{name}", error.place);
        error
    }

    fn above_0(&self, name: &str, value: f64) -> Result<f64, ShapeError> {
        self.number(name, value, value > 0.0, "a finite number above 0")
    }

    fn not_below_0(&self, name: &str, value: f64) -> Result<f64, ShapeError> {
        self.number(name, value, value >= 0.0, "a finite number, 0 or more")
    }

    fn finite<const N: usize>(&self, name: &str, values: [f64; N]) -> Result<(), ShapeError> {
        let check = |&value: &f64| self.number(name, value, true, "a finite number").map(drop);
        values.iter().try_for_each(check)
    }

    /// A direction one long.
    fn direction(&self, name: &str, vector: [f64; 3]) -> Result<[f64; 3], ShapeError> {
        self.finite(name, vector)?;
        let found = format!("{vector:?}");
        vector::unit(vector).ok_or_else(|| {
            let mut error =
                self.refused(ShapeFault::Number { expected: "a direction".into(), found });
            error.place = format!("{}.{name}", error.place);
            error
        })
    }

    /// Does `work` at a place within this one.
    fn at<R>(
        &mut self,
        name: String,
        work: impl FnOnce(&mut Self) -> Result<R, ShapeError>,
    ) -> Result<R, ShapeError> {
        self.place.push(name);
        let done = work(self)?;
        self.place.pop();
        Ok(done)
    }

    fn full<R>(&self, made: Result<R, Full>) -> Result<R, ShapeError> {
        made.map_err(|Full| self.refused(ShapeFault::TooLarge))
    }

    /// The step that makes the value of a shape at a point.
    pub(super) fn shape(&mut self, shape: &'m Shape, p: Point) -> Result<u32, ShapeError> {
        self.depth += 1;
        if self.depth > MOST_DEEP {
            return Err(self.refused(ShapeFault::TooDeep));
        }
        self.looks += 1;
        if self.looks > MOST_LOOKS {
            return Err(self.refused(ShapeFault::TooLarge));
        }
        let value = match shape {
            Shape::Part(name) => self.part(name, p)?,
            Shape::Combined { how, of, blend } => self.combined(*how, of, *blend, p)?,
            Shape::Offset { of, by } => {
                self.finite("offset", [*by])?;
                let value = self.shape(of, p)?;
                let made = self.builder.with(Binary::Add, value, *by);
                self.full(made)?
            }
            Shape::Shell { of, thickness } => {
                self.above_0("shell", *thickness)?;
                let value = self.shape(of, p)?;
                let made = self.shelled(value, *thickness);
                self.full(made)?
            }
            Shape::Scaled { of, by } => {
                for &factor in by {
                    self.above_0("scale", factor)?;
                }
                let made = self.divided(p, *by);
                let p = self.full(made)?;
                let value = self.shape(of, p)?;
                let made = self.builder.with(Binary::Mul, value, least(*by));
                self.full(made)?
            }
            Shape::Mirrored { of, normal } => {
                let n = self.direction("mirror", *normal)?;
                let p = self.mapped(reflection(n), [0.0; 3], p)?;
                self.shape(of, p)?
            }
            Shape::Rotated { of, degrees } => {
                self.finite("rotate", *degrees)?;
                // The way back.
                let p = self.mapped(transposed(rotation(*degrees)), [0.0; 3], p)?;
                self.shape(of, p)?
            }
            Shape::Moved { of, by } => {
                self.finite("move", *by)?;
                let p = self.mapped(IDENTITY, by.map(|c| -c), p)?;
                self.shape(of, p)?
            }
            Shape::Repeated { of, array } => self.repeated(of, array, p)?,
            primitive => self.primitive(primitive, p)?,
        };
        self.depth -= 1;
        Ok(value)
    }

    fn part(&mut self, name: &'m str, p: Point) -> Result<u32, ShapeError> {
        let Some((name, shape)) = self.parts.get_key_value(name) else {
            return Err(self.refused(ShapeFault::NoPart(name.to_owned())));
        };
        if let Some(&value) = self.made.get(&(name.as_str(), p)) {
            return Ok(value);
        }
        if let Some(at) = self.open.iter().position(|open| open == name) {
            let circle = [&self.open[at..], &[name.as_str()]].concat().join(" of ");
            return Err(self.refused(ShapeFault::Circle(circle)));
        }
        self.open.push(name);
        let place = std::mem::replace(&mut self.place, vec!["part".into(), name.clone()]);
        let value = self.shape(shape, p)?;
        self.place = place;
        self.open.pop();
        self.made.insert((name, p), value);
        Ok(value)
    }

    fn combined(
        &mut self,
        how: Combination,
        of: &'m [Shape],
        blend: f64,
        p: Point,
    ) -> Result<u32, ShapeError> {
        self.not_below_0("blend", blend)?;
        let word = how.word();
        let mut all = None;
        for (n, shape) in of.iter().enumerate() {
            let value = self.at(format!("{word}[{n}]"), |build| build.shape(shape, p))?;
            all = Some(match all {
                None => value,
                Some(all) => {
                    let made = self.joined(how, all, value, blend);
                    self.full(made)?
                }
            });
        }
        all.ok_or_else(|| {
            let (expected, found) = ("at least one shape".into(), "none".into());
            let mut error = self.refused(ShapeFault::Number { expected, found });
            error.place = format!("{}.{word}", error.place);
            error
        })
    }

    /// The greater or the less of two values, and where they are near to each other a little more, or less.
    ///
    /// With h = max(width − |a − b|, 0) that is h² / (4 width), the quadratic blend.
    fn joined(&mut self, how: Combination, a: u32, b: u32, width: f64) -> Result<u32, Full> {
        let builder = &mut self.builder;
        let b = if how == Combination::Difference { builder.unary(Unary::Neg, b)? } else { b };
        let (chosen, more) = match how {
            Combination::Union => (Binary::Max, Binary::Add),
            Combination::Intersection | Combination::Difference => (Binary::Min, Binary::Sub),
        };
        let sharp = builder.binary(chosen, a, b)?;
        if width == 0.0 {
            return Ok(sharp);
        }
        let apart = builder.binary(Binary::Sub, a, b)?;
        let apart = builder.unary(Unary::Abs, apart)?;
        let width_step = builder.constant(width)?;
        let near = builder.binary(Binary::Sub, width_step, apart)?;
        let near = builder.with(Binary::Max, near, 0.0)?;
        let near = builder.unary(Unary::Square, near)?;
        let bulge = builder.with(Binary::Mul, near, 0.25 / width)?;
        builder.binary(more, sharp, bulge)
    }

    fn shelled(&mut self, value: u32, thickness: f64) -> Result<u32, Full> {
        let thickness = self.builder.constant(thickness)?;
        let inner = self.builder.binary(Binary::Sub, thickness, value)?;
        self.builder.binary(Binary::Min, value, inner)
    }

    fn divided(&mut self, p: Point, by: [f64; 3]) -> Result<Point, Full> {
        let mut out = p;
        for axis in 0..3 {
            out[axis] = self.builder.with(Binary::Div, p[axis], by[axis])?;
        }
        Ok(out)
    }

    /// The point that a matrix, row by row, and a shift make of another.
    fn mapped(&mut self, rows: [[f64; 3]; 3], by: [f64; 3], p: Point) -> Result<Point, ShapeError> {
        let mut out = p;
        for axis in 0..3 {
            let terms = [0, 1, 2].map(|k| (rows[axis][k], p[k]));
            let made = self.builder.affine(&terms, by[axis]);
            out[axis] = self.full(made)?;
        }
        Ok(out)
    }

    fn repeated(&mut self, of: &'m Shape, array: &Array, p: Point) -> Result<u32, ShapeError> {
        if let Array::Grid { step, .. } | Array::Linear { step, .. } = array {
            self.finite("array.step", *step)?;
        }
        if let Array::Polar { turn, axis, .. } = array {
            self.finite("array.turn", [*turn])?;
            self.number("array.about", (*axis).into(), *axis < 3, "axis 0, 1 or 2")?;
        }
        let count = array.count();
        if count == 0 || count > MOST_COPIES {
            let expected = format!("1 to {MOST_COPIES} copies");
            let mut error = self.refused(ShapeFault::Number { expected, found: count.to_string() });
            error.place += ".array.count";
            return Err(error);
        }
        let mut all = None;
        for (rows, by) in array.copies() {
            // The way back: first the shift, then the turn.
            let shifted = self.mapped(IDENTITY, by.map(|c| -c), p)?;
            let p = self.mapped(transposed(rows), [0.0; 3], shifted)?;
            let value = self.shape(of, p)?;
            all = Some(match all {
                None => value,
                Some(all) => {
                    let made = self.joined(Combination::Union, all, value, 0.0);
                    self.full(made)?
                }
            });
        }
        Ok(all.expect("at least one copy, which was asked above"))
    }
}

impl Combination {
    fn word(self) -> &'static str {
        match self {
            Self::Union => "union",
            Self::Intersection => "intersection",
            Self::Difference => "difference",
        }
    }
}
