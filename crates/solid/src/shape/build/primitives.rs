//! The steps of shapes that are not made of others.
//!
//! Distances as in Quílez, "Distance functions" (2008 and later), here all with the inside positive.

use super::{
    super::{PeriodicSurface, Shape},
    Build, Point, ShapeError,
};
use crate::tape::{Binary, Full, Unary};
use std::f64::consts::TAU;

impl Build<'_> {
    pub(super) fn primitive(&mut self, shape: &Shape, p: Point) -> Result<u32, ShapeError> {
        self.place.push(word(shape).to_owned());
        self.check(shape)?;
        let made = match *shape {
            Shape::Plane { normal, at } => {
                let normal = self.direction("normal", normal)?;
                let terms = [0, 1, 2].map(|k| (-normal[k], p[k]));
                self.builder.affine(&terms, at)
            }
            _ => self.steps(shape, p),
        };
        let value = self.full(made)?;
        self.place.pop();
        Ok(value)
    }

    fn check(&self, shape: &Shape) -> Result<(), ShapeError> {
        let at_most = |name: &str, value: f64, most: f64| {
            let expected = format!("a number from 0 to {most}");
            self.number(name, value, (0.0..=most).contains(&value), &expected)
        };
        match *shape {
            Shape::Sphere { radius } => self.above_0("radius", radius)?,
            Shape::Box { size, round } => {
                let [x, y, z] = [
                    self.above_0("size", size[0])?,
                    self.above_0("size", size[1])?,
                    self.above_0("size", size[2])?,
                ];
                at_most("round", round, 0.5 * x.min(y).min(z))?
            }
            Shape::Cylinder { radius, height, round } => {
                self.above_0("radius", radius)?;
                self.above_0("height", height)?;
                at_most("round", round, radius.min(0.5 * height))?
            }
            Shape::Cone { radius, top, height } => {
                self.not_below_0("radius", radius)?;
                self.not_below_0("top", top)?;
                self.above_0("height", height)?;
                let expected = "one of radius and top above 0";
                self.number("radius", radius, radius + top > 0.0, expected)?
            }
            Shape::Torus { radius, tube } => {
                self.above_0("radius", radius)?;
                let expected = format!("a number above 0, at most {radius}");
                self.number("tube", tube, tube > 0.0 && tube <= radius, &expected)?
            }
            Shape::Capsule { from, to, radius } => {
                self.finite("from", from)?;
                self.finite("to", to)?;
                self.above_0("radius", radius)?
            }
            Shape::Plane { at, .. } => self.number("at", at, true, "a finite number")?,
            Shape::Periodic { cell, thickness, .. } => {
                self.above_0("cell", cell)?;
                self.above_0("thickness", thickness.unwrap_or(1.0))?
            }
            _ => 0.0,
        };
        Ok(())
    }

    fn steps(&mut self, shape: &Shape, p: Point) -> Result<u32, Full> {
        let [x, y, z] = p;
        match *shape {
            Shape::Sphere { radius } => {
                let far = self.builder.length(&p)?;
                self.less(radius, far)
            }
            Shape::Box { size, round } => {
                let mut over = p;
                for axis in 0..3 {
                    let side = self.builder.unary(Unary::Abs, p[axis])?;
                    over[axis] = self.builder.with(Binary::Sub, side, 0.5 * size[axis] - round)?;
                }
                self.cornered(&over, round)
            }
            Shape::Cylinder { radius, height, round } => {
                let across = self.builder.length(&[x, y])?;
                let across = self.builder.with(Binary::Sub, across, radius - round)?;
                let along = self.builder.unary(Unary::Abs, z)?;
                let along = self.builder.with(Binary::Sub, along, 0.5 * height - round)?;
                self.cornered(&[across, along], round)
            }
            Shape::Cone { radius, top, height } => self.cone([radius, top], height, p),
            Shape::Torus { radius, tube } => {
                let across = self.builder.length(&[x, y])?;
                let across = self.builder.with(Binary::Sub, across, radius)?;
                let far = self.builder.length(&[across, z])?;
                self.less(tube, far)
            }
            Shape::Capsule { from, to, radius } => {
                let way: [f64; 3] = std::array::from_fn(|k| to[k] - from[k]);
                let square = way.iter().map(|c| c * c).sum::<f64>();
                let mut apart = p;
                for axis in 0..3 {
                    apart[axis] = self.builder.with(Binary::Sub, p[axis], from[axis])?;
                }
                if square > 0.0 {
                    let terms = [0, 1, 2].map(|k| (way[k] / square, apart[k]));
                    let share = self.builder.affine(&terms, 0.0)?;
                    let share = self.builder.with(Binary::Max, share, 0.0)?;
                    let share = self.builder.with(Binary::Min, share, 1.0)?;
                    for axis in 0..3 {
                        let terms = [(1.0, apart[axis]), (-way[axis], share)];
                        apart[axis] = self.builder.affine(&terms, 0.0)?;
                    }
                }
                let far = self.builder.length(&apart)?;
                self.less(radius, far)
            }
            Shape::Periodic { surface, cell, thickness } => {
                let value = self.periodic(surface, cell, p)?;
                match thickness {
                    Some(thickness) => {
                        let far = self.builder.unary(Unary::Abs, value)?;
                        self.less(0.5 * thickness, far)
                    }
                    None => Ok(value),
                }
            }
            // What is no number is outside: the first operand of a maximum is chosen only if it is greater.
            Shape::Formula(ref formula) => {
                let value = formula.build(&mut self.builder, p)?;
                self.builder.with(Binary::Max, value, f64::NEG_INFINITY)
            }
            _ => unreachable!("shapes of others are made elsewhere, and planes"),
        }
    }

    /// A number less a step.
    fn less(&mut self, number: f64, step: u32) -> Result<u32, Full> {
        let number = self.builder.constant(number)?;
        self.builder.binary(Binary::Sub, number, step)
    }

    /// Of how far a point is over each face of a corner: how far in it is, and outside how far from the corner.
    fn cornered(&mut self, over: &[u32], round: f64) -> Result<u32, Full> {
        let mut beyond = over.to_vec();
        for step in &mut beyond {
            *step = self.builder.with(Binary::Max, *step, 0.0)?;
        }
        let outside = self.builder.length(&beyond)?;
        let mut most = over[0];
        for &step in &over[1..] {
            most = self.builder.binary(Binary::Max, most, step)?;
        }
        // Of two that are equal the second has its slope in the sum: on a face it is that of the face.
        let zero = self.builder.constant(0.0)?;
        let inside = self.builder.binary(Binary::Min, zero, most)?;
        let distance = self.builder.binary(Binary::Add, outside, inside)?;
        self.less(round, distance)
    }

    /// In the half-plane of z and the distance from it: how far from both ends and from the slant, with the sign of how far
    /// over the outermost of the three.
    fn cone(&mut self, [low, top]: [f64; 2], height: f64, [x, y, z]: Point) -> Result<u32, Full> {
        let half = 0.5 * height;
        let slant = libm::sqrt((top - low) * (top - low) + height * height);
        let (along_r, along_z) = ((top - low) / slant, height / slant);
        let builder = &mut self.builder;
        let across = builder.length(&[x, y])?;
        // From the lower rim.
        let r = builder.with(Binary::Sub, across, low)?;
        let h = builder.with(Binary::Add, z, half)?;
        // Along the slant and over it: within its ends nothing but the latter counts, and has a slope down to the surface.
        let along = builder.affine(&[(along_r, r), (along_z, h)], 0.0)?;
        let within = builder.with(Binary::Max, along, 0.0)?;
        let within = builder.with(Binary::Min, within, slant)?;
        let beyond = builder.binary(Binary::Sub, along, within)?;
        let over_slant = builder.affine(&[(along_z, r), (-along_r, h)], 0.0)?;
        let mut nearest = builder.length(&[over_slant, beyond])?;
        for (radius, end) in [(low, -half), (top, half)] {
            let beyond = builder.with(Binary::Sub, across, radius)?;
            let beyond = builder.with(Binary::Max, beyond, 0.0)?;
            let off = builder.with(Binary::Sub, z, end)?;
            let distance = builder.length(&[beyond, off])?;
            nearest = builder.binary(Binary::Min, nearest, distance)?;
        }
        let over_ends = builder.unary(Unary::Abs, z)?;
        let over_ends = builder.with(Binary::Sub, over_ends, half)?;
        let over = builder.binary(Binary::Max, over_slant, over_ends)?;
        let out = builder.binary(Binary::Signed, nearest, over)?;
        // Inside both are the same; on the surface the second has a slope.
        let out = builder.binary(Binary::Max, out, over)?;
        builder.unary(Unary::Neg, out)
    }

    /// The sum, divided by its greatest slope.
    fn periodic(&mut self, surface: PeriodicSurface, cell: f64, p: Point) -> Result<u32, Full> {
        let builder = &mut self.builder;
        let (mut sin, mut cos) = (p, p);
        let mut turned = p;
        for axis in 0..3 {
            turned[axis] = builder.with(Binary::Mul, p[axis], TAU / cell)?;
            sin[axis] = builder.unary(Unary::Sin, turned[axis])?;
            cos[axis] = builder.unary(Unary::Cos, turned[axis])?;
        }
        let ([sx, sy, sz], [cx, cy, cz]) = (sin, cos);
        let mut product = |parts: &[u32]| {
            let (&first, rest) = parts.split_first().expect("a factor");
            rest.iter().try_fold(first, |all, &next| builder.binary(Binary::Mul, all, next))
        };
        let (terms, slope) = match surface {
            PeriodicSurface::Gyroid => {
                let terms = [product(&[sx, cy])?, product(&[sy, cz])?, product(&[sz, cx])?];
                (terms.map(|term| (1.0, term)).to_vec(), 3.0_f64)
            }
            PeriodicSurface::SchwarzP => ([cx, cy, cz].map(|term| (1.0, term)).to_vec(), 3.0),
            PeriodicSurface::SchwarzD => {
                (vec![(1.0, product(&[cx, cy, cz])?), (-1.0, product(&[sx, sy, sz])?)], 1.5)
            }
            PeriodicSurface::Neovius => {
                let all = product(&[cx, cy, cz])?;
                (vec![(3.0, cx), (3.0, cy), (3.0, cz), (4.0, all)], 49.0)
            }
            PeriodicSurface::Iwp => {
                let pairs = [product(&[cx, cy])?, product(&[cy, cz])?, product(&[cz, cx])?];
                let mut terms = pairs.map(|term| (2.0, term)).to_vec();
                for axis in turned {
                    let double = self.builder.with(Binary::Mul, axis, 2.0)?;
                    terms.push((-1.0, self.builder.unary(Unary::Cos, double)?));
                }
                (terms, 27.0)
            }
        };
        let sum = self.builder.affine(&terms, 0.0)?;
        self.builder.with(Binary::Mul, sum, cell / (TAU * slope.sqrt()))
    }
}

/// What a file calls a primitive.
fn word(shape: &Shape) -> &'static str {
    match shape {
        Shape::Sphere { .. } => "sphere",
        Shape::Box { .. } => "box",
        Shape::Cylinder { .. } => "cylinder",
        Shape::Cone { .. } => "cone",
        Shape::Torus { .. } => "torus",
        Shape::Capsule { .. } => "capsule",
        Shape::Plane { .. } => "plane",
        Shape::Periodic { surface, .. } => match surface {
            PeriodicSurface::Gyroid => "gyroid",
            PeriodicSurface::SchwarzP => "schwarz_p",
            PeriodicSurface::SchwarzD => "schwarz_d",
            PeriodicSurface::Neovius => "neovius",
            PeriodicSurface::Iwp => "iwp",
        },
        Shape::Formula(_) => "formula",
        _ => "shape",
    }
}
