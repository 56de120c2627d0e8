//! One vertex for all corners at exactly the same place.
//!
//! Unlike `isokit_mesh::weld_exact` this keeps triangles that name a vertex twice, for whoever checks a
//! file wants to hear of them, and never has all corners in memory.

use isokit_mesh::{Positions, TriMesh};
use std::{
    collections::HashMap,
    hash::{BuildHasherDefault, Hasher},
};

/// The vertices so far, and the triangles between them.
#[derive(Default)]
pub(super) struct Corners {
    vertices: HashMap<[u32; 3], u32, BuildHasherDefault<Mix>>,
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Corners {
    /// Adds a triangle; `false` if there is no number left for a vertex.
    pub(super) fn add(&mut self, corners: [[f32; 3]; 3]) -> bool {
        if self.positions.len() > u32::MAX as usize - 3 {
            return false;
        }
        let triangle = corners.map(|corner| self.vertex(corner));
        self.triangles.push(triangle);
        true
    }

    /// How many triangles there are.
    pub(super) fn count(&self) -> usize {
        self.triangles.len()
    }

    /// The mesh, and how many corners lie at the place of an earlier one.
    pub(super) fn finish(self) -> (TriMesh, u64) {
        let shared = 3 * self.triangles.len() - self.positions.len();
        let (positions, triangles) = (Positions::F32(self.positions), self.triangles);
        (TriMesh { positions, normals: None, triangles, ..TriMesh::default() }, shared as u64)
    }

    fn vertex(&mut self, xyz: [f32; 3]) -> u32 {
        let next = self.positions.len() as u32;
        // NaN is nowhere, so it is nobody's place.
        let vertex = match xyz.iter().any(|c| c.is_nan()) {
            true => next,
            // + 0.0 makes 0 of −0.
            false => *self.vertices.entry(xyz.map(|c| (c + 0.0).to_bits())).or_insert(next),
        };
        if vertex == next {
            self.positions.push(xyz);
        }
        vertex
    }
}

/// Odd multipliers with well spread bits; the upper bits of a product depend on all lower ones.
#[derive(Default)]
struct Mix(u64);

impl Hasher for Mix {
    fn write(&mut self, bytes: &[u8]) {
        for four in bytes.chunks(4) {
            let mut word = [0; 4];
            word[..four.len()].copy_from_slice(four);
            let word = u64::from(u32::from_le_bytes(word));
            self.0 = (self.0 ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
        }
    }

    fn finish(&self) -> u64 {
        self.0.wrapping_mul(0xd6e8_feb8_6659_fd93)
    }
}

#[cfg(test)]
mod tests {
    use super::Corners;

    #[test]
    fn equal_places_are_one_vertex_and_nan_is_none() {
        let mut corners = Corners::default();
        let nan = [f32::NAN, 0.0, 0.0];
        assert!(corners.add([[0.0; 3], [1.0, 0.0, 0.0], [-0.0; 3]]));
        assert!(corners.add([[1.0, 0.0, 0.0], nan, nan]));
        let (mesh, shared) = corners.finish();
        assert_eq!(mesh.triangles, [[0, 1, 0], [1, 2, 3]]);
        assert_eq!((mesh.positions.len(), shared), (4, 2));
    }
}
