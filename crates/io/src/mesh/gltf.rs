//! glTF 2.0 by Khronos, as one GLB file or as `.gltf` with a `.bin` beside it.
//!
//! Source: <https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html>. The types of the document are those
//! of the crate `gltf-json`; container and buffers are written and read here, for sizes beyond 4 GiB must
//! fail before the first byte, and a broken file must never panic.
//!
//! glTF is metres, y up. Axes and unit are put into the positions themselves, in f64 and rounded once, for
//! some programs read nodes without their transforms. `asset.extras` says what was done:
//! `metres_per_unit`, `unit`, `space`, `axes`, `command`.

mod accessor;
mod base64;
mod buffers;
mod container;
mod content;
mod document;
mod layout;
mod plan;
mod read;
mod scene;
mod spool;
mod transform;
mod write;

pub(super) use plan::check;
pub(super) use read::read;
pub(super) use spool::{Spool, finish_glb, finish_gltf};
pub(super) use write::{write_glb, write_gltf};

use super::MeshContext;
use super::axes::{y_up, z_up};
use isokit_geom::Unit;

/// How many metres one unit of a mesh is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale(pub(super) f64);

impl Scale {
    /// Of a unit that nobody knows, one is one metre.
    pub(super) fn of(context: &MeshContext) -> Self {
        let unit: Unit = context.gltf_unit.unwrap_or(context.unit);
        Self(unit.metres().unwrap_or(1.0))
    }

    /// From z up and the mesh's unit to y up and metres.
    fn store(self, xyz: [f64; 3]) -> [f32; 3] {
        y_up(xyz).map(|c| (c * self.0) as f32)
    }

    /// From y up and metres to z up and the mesh's unit.
    fn restore(self, xyz: [f64; 3]) -> [f64; 3] {
        z_up(xyz).map(|c| c / self.0)
    }
}

/// The marks of the binary container.
mod mark {
    pub(super) const MAGIC: u32 = u32::from_le_bytes(*b"glTF");
    pub(super) const VERSION: u32 = 2;
    pub(super) const JSON: u32 = u32::from_le_bytes(*b"JSON");
    pub(super) const BIN: u32 = u32::from_le_bytes(*b"BIN\0");
    /// Bytes before the first chunk.
    pub(super) const HEADER: u64 = 12;
    /// Bytes before the content of a chunk.
    pub(super) const CHUNK: u64 = 8;
}

#[cfg(test)]
mod tests;
