//! Solids as fields: shapes that are put together from others, and meshes.

mod around;
mod bvh;
mod distance;
#[cfg(test)]
mod kit;
mod mesh_solid;
mod repair;
mod voxelize;
mod winding;

pub use around::{AroundError, grid_around};
pub use distance::Part;
pub use mesh_solid::{Closest, Flaws, Inside, MeshSolid, SolidError, SolidOptions, Winding};
pub use voxelize::{VoxelError, VoxelMode, VoxelOptions, Walls, voxelize};
