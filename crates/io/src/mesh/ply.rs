//! PLY, the polygon format of Greg Turk (Stanford, 1994).
//!
//! Source: <http://paulbourke.net/dataformats/ply/>. A header in text names elements and their properties;
//! their values follow, in text or in either byte order. We write little-endian: vertices of float (or of
//! double, where a mesh needs that), with normals, colours and a number if there are any, and faces of three.
//! Coordinates are those of the mesh, z up, in its own unit, which a comment names. The number of a vertex is
//! called `quality`, which MeshLab takes for it; colours are sRGB.

mod header;
mod read;
mod values;
mod write;

pub(super) use read::read;
pub(super) use write::{Spool, write};

/// The properties of a vertex that are its colour, in eight bits each.
const COLORS: [&str; 4] = ["red", "green", "blue", "alpha"];
/// The property of a vertex that is its number.
const VALUE: &str = "quality";

#[cfg(test)]
mod tests;
