//! Solids as fields: shapes that are put together from others.
//!
//! A [`Model`] is a tree of [`Shape`]s, in Rust or in a file. Built, it is a [`Solid`], which knows the value at each point
//! of the world; on a lattice it is [`Placed`], a field like any other.
//!
//! ```
//! use isokit_solid::{Array, Model, Shape};
//!
//! let plate = Shape::Box { size: [40.0, 30.0, 4.0], round: 1.0 };
//! let hole = Shape::Cylinder { radius: 2.0, height: 10.0, round: 0.0 };
//! let holes = Array::Grid { count: [3, 2, 1], step: [12.0, 12.0, 0.0], center: true };
//! let solid = Model::from(plate.difference(hole.repeated(holes))).build()?;
//! assert!(solid.value([6.0, 0.0, 0.0]) > 0.0 && solid.value([0.0, 6.0, 0.0]) < 0.0);
//! # Ok::<(), isokit_solid::ShapeError>(())
//! ```

mod formula;
mod placed;
mod shape;
mod tape;

pub use formula::{Formula, FormulaError};
pub use placed::Placed;
pub use shape::{
    Array, Combination, Model, PeriodicSurface, Region, Shape, ShapeError, ShapeFault, Solid,
};

#[cfg(test)]
mod chance;
