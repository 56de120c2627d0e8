//! STL by 3D Systems (1988): triangles, and nothing else.
//!
//! Source: <http://www.fabbers.com/tech/STL_Format>. We write binary files: 80 bytes of which nobody asks
//! what they hold (ours name space, unit, name and command), a count, and 50 bytes for each triangle: its
//! normal, its corners and two bytes of nothing. Coordinates are those of the mesh, z up, in its own unit,
//! as f32. There are no shared vertices; the reader makes one of all corners at exactly the same place.

mod corners;
mod read;
mod spool;
mod text;
mod write;

pub(super) use read::read;
pub(super) use spool::Spool;
pub(super) use write::{check, write};

/// Bytes before the first triangle of a binary file.
const HEAD: usize = 84;
/// Bytes of a triangle in a binary file.
const FACET: usize = 50;

#[cfg(test)]
mod tests;
