//! Solids that are put together: a tree of simple ones.
//!
//! A shape gives every point of the world a number: inside it is positive, on the surface 0. The numbers are lengths in
//! world units: no shape but a formula, or one made with one, says more than the distance to its surface. Primitives say
//! just that distance, but for the periodic surfaces. A union of such says it outside, an intersection or difference
//! inside at least near its faces; elsewhere, and in blends, it is a bound of it.

mod build;
mod extent;
mod model;
mod table;

pub use build::{ShapeError, ShapeFault};
pub use model::{Model, Region, Solid};

use crate::Formula;
use serde::Deserialize;

/// A solid. In a file it is a table: one key says what it is, others what is done with it (`Table`).
///
/// Primitives are about the origin, and along z. Lengths are above 0 unless something else is said.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "table::Table")]
#[non_exhaustive]
pub enum Shape {
    /// A ball. Its value is the signed distance.
    Sphere {
        /// From the middle to the surface.
        radius: f64,
    },
    /// A box with faces across the axes. Its value is the signed distance.
    Box {
        /// From face to face along x, y, z.
        size: [f64; 3],
        /// Radius of edges and corners: from 0 to half the least size.
        round: f64,
    },
    /// A cylinder along z. Its value is the signed distance.
    Cylinder {
        /// Across z.
        radius: f64,
        /// Along z, the middle at 0.
        height: f64,
        /// Radius of both edges: from 0 to the radius and to half the height.
        round: f64,
    },
    /// A cone along z, or what is left of one when its tip is cut off. Its value is the signed distance.
    Cone {
        /// At the lower end, 0 or more.
        radius: f64,
        /// At the upper end, 0 or more; not both are 0.
        top: f64,
        /// Along z, the middle at 0.
        height: f64,
    },
    /// A ring about z. Its value is the signed distance.
    Torus {
        /// From the axis to the middle of the tube.
        radius: f64,
        /// Radius of the tube, at most the other.
        tube: f64,
    },
    /// All that is so near to a line from one point to another. Its value is the signed distance.
    Capsule {
        /// Where the line begins.
        from: [f64; 3],
        /// Where it ends.
        to: [f64; 3],
        /// How near.
        radius: f64,
    },
    /// All on one side of a plane. Its value is the signed distance.
    Plane {
        /// Points out of the solid; of any length but 0.
        normal: [f64; 3],
        /// How far from the origin the plane is, along the normal. May be negative.
        at: f64,
    },
    /// What a triply periodic surface bounds, everywhere. Its value is at most the distance: its slope is never above 1.
    Periodic {
        /// Which one.
        surface: PeriodicSurface,
        /// After how far along each axis it repeats.
        cell: f64,
        /// A wall about the surface, no thinner than this, and thicker where the sum is less steep than at its steepest: of a
        /// gyroid by a fifth at most, of Neovius' surface up to seven times. If none is given, one side of the surface.
        thickness: Option<f64>,
    },
    /// Where a formula is positive. Its value is the formula's, whatever that is.
    Formula(Formula),
    /// A part of a [`Model`], by its name.
    Part(String),
    /// Several shapes as one.
    Combined {
        /// How.
        how: Combination,
        /// At least one. The others are cut from the first if it is a difference.
        of: Vec<Shape>,
        /// Surfaces that are so near to each other, in value, run into each other; 0: they meet at an edge. The quadratic
        /// blend, of one after the other in the order in which they stand: each after the first adds a quarter of this at most.
        blend: f64,
    },
    /// All that is so much farther out, or in.
    Offset {
        /// What grows.
        of: Box<Shape>,
        /// How far. May be negative.
        by: f64,
    },
    /// A hollow shape: a wall inside of its surface.
    Shell {
        /// What is hollowed.
        of: Box<Shape>,
        /// Of the wall.
        thickness: f64,
    },
    /// Larger along x, y, z by factors. If they differ, values are those for the least: a bound.
    Scaled {
        /// What is scaled.
        of: Box<Shape>,
        /// Each above 0.
        by: [f64; 3],
    },
    /// The mirror image in a plane through the origin.
    Mirrored {
        /// What is mirrored.
        of: Box<Shape>,
        /// Across the plane; of any length but 0.
        normal: [f64; 3],
    },
    /// Turned about x, then about y, then about z, counter-clockwise seen from the axis' tip.
    Rotated {
        /// What is turned.
        of: Box<Shape>,
        /// About x, y, z.
        degrees: [f64; 3],
    },
    /// Elsewhere.
    Moved {
        /// What is moved.
        of: Box<Shape>,
        /// Along x, y, z.
        by: [f64; 3],
    },
    /// The union of copies.
    Repeated {
        /// What is copied.
        of: Box<Shape>,
        /// Where to.
        array: Array,
    },
}

/// How shapes become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Combination {
    /// What is in any of them: the greatest value.
    Union,
    /// What is in all of them: the least value.
    Intersection,
    /// What is in the first and in none of the others.
    Difference,
}

/// A triply periodic minimal surface, by the leading term of its Fourier series: with X = 2πx / cell, and so on,
/// inside is where the sum is positive. Schoen, "Infinite periodic minimal surfaces without self-intersections", NASA TN
/// D-5541, 1970; the sums as in von Schnering & Nesper, "Nodal surfaces of Fourier series", 1991.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PeriodicSurface {
    /// sin X cos Y + sin Y cos Z + sin Z cos X.
    Gyroid,
    /// cos X + cos Y + cos Z.
    SchwarzP,
    /// cos X cos Y cos Z − sin X sin Y sin Z.
    SchwarzD,
    /// 3 (cos X + cos Y + cos Z) + 4 cos X cos Y cos Z.
    Neovius,
    /// 2 (cos X cos Y + cos Y cos Z + cos Z cos X) − (cos 2X + cos 2Y + cos 2Z).
    Iwp,
}

/// Where copies are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Array {
    /// In rows along x, y, z. One of `[5, 1, 1]` is a row.
    Grid {
        /// Copies along each axis, at least 1.
        count: [u32; 3],
        /// From one to the next along each axis.
        step: [f64; 3],
        /// Whether the shape is in the middle of its copies; otherwise it is the first.
        center: bool,
    },
    /// Along a line.
    Linear {
        /// Copies, at least 1.
        count: u32,
        /// From one to the next.
        step: [f64; 3],
        /// Whether the shape is in the middle of its copies; otherwise it is the first.
        center: bool,
    },
    /// About an axis of the world.
    Polar {
        /// Copies, at least 1.
        count: u32,
        /// 0, 1, 2 for x, y, z.
        axis: u8,
        /// Degrees from one to the next. Default in files: evenly all around.
        turn: f64,
    },
}

impl Shape {
    /// This and another one.
    pub fn union(self, other: Self) -> Self {
        self.combined(Combination::Union, other, 0.0)
    }

    /// What is in both.
    pub fn intersection(self, other: Self) -> Self {
        self.combined(Combination::Intersection, other, 0.0)
    }

    /// What the other one leaves of this.
    pub fn difference(self, other: Self) -> Self {
        self.combined(Combination::Difference, other, 0.0)
    }

    /// Both in one, with a blend where they meet.
    pub fn combined(self, how: Combination, other: Self, blend: f64) -> Self {
        Self::Combined { how, of: vec![self, other], blend }
    }

    /// The same elsewhere.
    pub fn moved(self, by: [f64; 3]) -> Self {
        Self::Moved { of: self.into(), by }
    }

    /// The same, turned about x, then y, then z.
    pub fn rotated(self, degrees: [f64; 3]) -> Self {
        Self::Rotated { of: self.into(), degrees }
    }

    /// The same, so many times as large.
    pub fn scaled(self, by: f64) -> Self {
        Self::Scaled { of: self.into(), by: [by; 3] }
    }

    /// Copies of it.
    pub fn repeated(self, array: Array) -> Self {
        Self::Repeated { of: self.into(), array }
    }
}

#[cfg(test)]
mod tests;
