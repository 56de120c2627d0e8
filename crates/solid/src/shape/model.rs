//! A shape with its parts, and what becomes of it: a function of the world, with a box around it.

use super::{Shape, ShapeError, ShapeFault, build::Build, extent::Extents};
use crate::{Placed, tape::Tape};
use isokit_geom::{Aabb, Affine, Frame, Space, Unit};
use isokit_volume::Grid;
use serde::{Deserialize, Deserializer, de::Error};
use std::collections::BTreeMap;

/// A shape, the parts that it names, and where it is looked at: what a file says.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Model {
    /// Of all lengths. Default: not known.
    #[serde(default, deserialize_with = "unit")]
    pub unit: Unit,
    /// What part of the world is looked at. Default: all of the shape, and a little around it.
    pub bounds: Option<Region>,
    /// What it is.
    pub shape: Shape,
    /// Shapes with names, of which others are made.
    #[serde(default)]
    pub part: BTreeMap<String, Shape>,
}

/// A box of the world.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Least coordinates.
    pub from: [f64; 3],
    /// Greatest coordinates.
    pub to: [f64; 3],
}

/// A solid that was built: it can be asked at any point of the world, and laid on a lattice.
#[derive(Clone, Debug)]
pub struct Solid {
    tape: Tape,
    /// May go on for ever.
    extent: Aabb,
    bounds: Option<Region>,
    unit: Unit,
}

/// Samples around a shape on each side.
const MARGIN: f64 = 2.0;

/// Samples along an axis; more cannot be numbered.
const MOST: f64 = 2_147_483_647.0;

fn unit<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Unit, D::Error> {
    let symbol = String::deserialize(deserializer)?;
    Unit::from_symbol(&symbol).ok_or_else(|| {
        let known = Unit::ALL.map(|(_, symbol)| symbol).join(" ");
        D::Error::custom(format!("expected one of {known}, found {symbol:?}"))
    })
}

impl From<Shape> for Model {
    fn from(shape: Shape) -> Self {
        Self { unit: Unit::Unknown, bounds: None, shape, part: BTreeMap::new() }
    }
}

impl Model {
    /// Makes the solid. Parts that are not used are looked at all the same.
    ///
    /// # Errors
    ///
    /// If a number is out of range, a part is missing or made of itself, or all of it is too large; with the place in the
    /// tree.
    pub fn build(&self) -> Result<Solid, ShapeError> {
        isokit_lanes::exactly(|| self.built())
    }

    fn built(&self) -> Result<Solid, ShapeError> {
        let mut build = Build::new(&self.part);
        let mut point = [0; 3];
        for (axis, step) in point.iter_mut().enumerate() {
            *step = build.axis(axis as u8)?;
        }
        let last = build.shape(&self.shape, point)?;
        let tape = build.builder.tape(last);
        for name in self.part.keys() {
            build.unused(name, point)?;
        }
        let extent = Extents::new(&self.part).of(&self.shape, 0.0);
        let extent = extent.map_err(|fault| ShapeError { place: "shape".into(), fault })?;
        if let Some(Region { from, to }) = self.bounds {
            let is_box = (0..3).all(|k| from[k] < to[k] && (to[k] - from[k]).is_finite());
            if !is_box {
                let found = format!("{from:?} and {to:?}");
                let expected = "from below to along x, y and z".into();
                let fault = ShapeFault::Number { expected, found };
                return Err(ShapeError { place: "bounds".into(), fault });
            }
        }
        Ok(Solid { tape, extent, bounds: self.bounds, unit: self.unit })
    }
}

impl Solid {
    /// The value at a point of the world: above 0 inside.
    pub fn value(&self, xyz: [f64; 3]) -> f64 {
        isokit_lanes::exactly(|| self.tape.value(xyz))
    }

    /// How many steps it takes to make a value.
    pub fn steps(&self) -> usize {
        self.tape.len()
    }

    /// The steps of a value as text, one in a line, such as `_2 add _0 _1`: what `fidget` reads, and what goes with
    /// Keeter, "Massively parallel rendering of complex closed-form implicit surfaces", 2020. There the inside is negative,
    /// here positive. None if there is a power in a formula other than a square, which has no
    /// word there.
    pub fn listing(&self) -> Option<String> {
        self.tape.listing()
    }

    #[cfg(test)]
    pub(crate) fn tape(&self) -> &Tape {
        &self.tape
    }

    /// A box of the world around it, or the one that was given; none if it has no end, or is empty.
    pub fn bounds(&self) -> Option<Aabb> {
        self.region().ok().map(|(region, _)| region)
    }

    /// The box, and whether a margin is wanted around it.
    fn region(&self) -> Result<(Aabb, bool), ShapeError> {
        if let Some(Region { from, to }) = self.bounds {
            return Ok((Aabb { min: from, max: to }, false));
        }
        let Aabb { min, max } = self.extent;
        let refused = |fault: ShapeFault| ShapeError { place: "shape".into(), fault };
        for axis in 0..3 {
            if min[axis] > max[axis] {
                return Err(refused(ShapeFault::Empty));
            }
            if !(max[axis] - min[axis]).is_finite() {
                return Err(refused(ShapeFault::Endless { axis: ['x', 'y', 'z'][axis] }));
            }
        }
        Ok((self.extent, true))
    }

    /// A lattice around it, with so much from one sample to the next along x, y, z. The shape is in its middle and two
    /// samples from its border, or nearly; a box that was given is kept to.
    ///
    /// # Errors
    ///
    /// If a distance is not above 0, if the shape has no end and no bounds were given, or if there would be more samples
    /// along an axis than are numbered.
    pub fn grid(&self, spacing: [f64; 3]) -> Result<Grid, ShapeError> {
        let (region, with_margin) = self.region()?;
        let refused = |expected: &str, found: String| ShapeError {
            place: "spacing".into(),
            fault: ShapeFault::Number { expected: expected.into(), found },
        };
        let (mut counts, mut first) = ([0_u64; 3], [0.0; 3]);
        for axis in 0..3 {
            let h = spacing[axis];
            if !(h > 0.0 && h.is_finite()) {
                return Err(refused("a finite number above 0", h.to_string()));
            }
            let steps = (region.max[axis] - region.min[axis]) / h;
            // Whole steps are whole whatever rounding did to them.
            let count = match with_margin {
                true => (steps * (1.0 - 1e-12)).ceil() + 2.0 * MARGIN,
                false => (steps * (1.0 + 1e-12)).floor() + 1.0,
            };
            if count > MOST {
                let axis = ['x', 'y', 'z'][axis];
                return Err(refused(
                    &format!("at most {MOST} samples along {axis}"),
                    format!("{h}, which makes {count:e}"),
                ));
            }
            counts[axis] = count as u64;
            let middle = 0.5 * (region.min[axis] + region.max[axis]);
            first[axis] = middle - 0.5 * (count - 1.0) * h;
        }
        let index_to_world = Affine::axis_aligned(spacing, first)
            .map_err(|error| refused("a lattice", error.to_string()))?;
        let frame = Frame { index_to_world, unit: self.unit, space: Space::Unknown };
        Grid::new(counts, frame).map_err(|error| refused("fewer samples", error.to_string()))
    }

    /// The solid in the index space of a lattice.
    pub fn placed(&self, grid: &Grid) -> Placed {
        isokit_lanes::exactly(|| {
            let affine = grid.frame.index_to_world;
            let (columns, origin) = (affine.columns(), affine.origin());
            let rows = [0, 1, 2].map(|row| [0, 1, 2].map(|k| columns[k][row]));
            Placed::new(self.tape.mapped(rows, origin), grid)
        })
    }
}
