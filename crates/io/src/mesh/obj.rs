//! Wavefront OBJ, with its materials in an MTL beside it.
//!
//! Source: Wavefront's *Advanced Visualizer Manual*, appendix B1 (Object Files) and B5 (MTL). OBJ has no
//! unit and no axes. We write y up, as Blender and most others assume, in the mesh's own unit, numbers with
//! as many digits as it takes to read the same number again. A surface is an object (`o`) with a material
//! of the same name.

mod material;
mod object;
mod read;
mod spool;
mod write;

pub(super) use read::read;
pub(super) use spool::{Spool, finish};
pub(super) use write::{write, write_with_materials};

#[cfg(test)]
mod tests;
