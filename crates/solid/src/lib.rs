//! Solids as fields: shapes that are put together from others, and meshes.
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
//!
//! A [`MeshSolid`] is what a mesh bounds, however broken the mesh is: it knows the distance of its surface and on which
//! side a point is. [`voxelize`] makes a volume of it, [`voxelize_with_colors`] another one of the colours of the mesh; on a
//! lattice it is [`PlacedMesh`], a field too.

mod around;
mod bvh;
mod distance;
mod formula;
#[cfg(test)]
mod kit;
mod mesh_solid;
mod paint;
mod placed;
mod placed_mesh;
mod repair;
mod shape;
mod tape;
mod voxelize;
mod winding;

pub use around::{AroundError, grid_around};
pub use distance::Part;
pub use formula::{Formula, FormulaError};
pub use mesh_solid::{Closest, Flaws, Inside, MeshSolid, SolidError, SolidOptions, Winding};
pub use placed::Placed;
pub use placed_mesh::PlacedMesh;
pub use shape::{
    Array, Combination, Model, PeriodicSurface, Region, Shape, ShapeError, ShapeFault, Solid,
};
pub use voxelize::{VoxelError, VoxelMode, VoxelOptions, Walls, voxelize, voxelize_with_colors};

#[cfg(test)]
mod chance;
