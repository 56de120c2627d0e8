//! Brings a surface nearer to the field that it was extracted from.
//!
//! Vertices of marching cubes lie on the surface of a field, and the triangles between them inside it where
//! it bulges: a chord of length L leaves a surface of radius R by L²/8R. That error, O(h²), remains however
//! well vertices are placed, and where faces meet at an angle it is O(h). Three ways lead out, and all may be gone:
//!
//! - [`Subdivision`] puts new vertices on edges, and those on the field: every level divides the error by
//!   four and multiplies the triangles by as much, or an error is named and only what curves is divided.
//! - *Balance* moves each vertex along its normal, outwards where the surface bulges, so that triangles
//!   cut through the surface in place of staying within. No triangle is added; the volume inside is right
//!   to a higher order, and where it bulges one way the error of the surface is close to the least that moves along normals
//!   leave these triangles.
//!
//! - *Creases* of fields that have some, such as those of solids with edges, get vertices: no triangle cuts them off.
//!
//! None changes what is connected: closed stays closed, manifold stays manifold. A triangle that would
//! become flat or turn over, in the precision in which positions are kept or a file will have them
//! ([`RefineOptions::file_scale`]), is not made, and no vertex gets to where another one is: such vertices stay where they
//! were, and are counted. A triangle may look along the surface, as thin ones do: when it is divided, and all that
//! comes of it looks outward by the field, that counts as not turned over.
//!
//! The result is the same, byte for byte, for any number of threads.

mod balance;
mod build;
mod crease;
mod edges;
mod error;
mod exact;
mod ground;
#[cfg(test)]
mod kit;
mod known;
mod options;
mod places;
mod refine;
mod root;
mod sagitta;
mod settle;
mod split;

pub use error::RefineError;
pub use ground::Isosurface;
pub use options::{RefineOptions, Subdivision};
pub use refine::{Refined, refine};
