//! How a surface is kept.

use crate::{Counts, MeshSink, Piece, PositionsMut};
use isokit_geom::Aabb;
use std::convert::Infallible;

/// How exactly positions are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// As f32, which all formats and viewers take.
    #[default]
    F32,
    /// As f64, for places so far from the origin that f32 would move them visibly.
    F64,
}

/// World-space positions in one of two precisions.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "each name is the type it holds")]
pub enum Positions {
    F32(Vec<[f32; 3]>),
    F64(Vec<[f64; 3]>),
}

impl Default for Positions {
    fn default() -> Self {
        Self::F32(vec![])
    }
}

impl Positions {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(positions) => positions.len(),
            Self::F64(positions) => positions.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Position number `vertex`.
    ///
    /// # Panics
    ///
    /// If there is no such vertex.
    #[inline]
    pub fn get(&self, vertex: usize) -> [f64; 3] {
        match self {
            Self::F32(positions) => positions[vertex].map(f64::from),
            Self::F64(positions) => positions[vertex],
        }
    }

    /// All positions in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = [f64; 3]> {
        (0..self.len()).map(|vertex| self.get(vertex))
    }

    /// In which precision they are kept.
    pub fn precision(&self) -> Precision {
        match self {
            Self::F32(_) => Precision::F32,
            Self::F64(_) => Precision::F64,
        }
    }
}

/// An indexed triangle mesh.
///
/// Made by an extractor, every index names a vertex and every vertex is used. Made by hand or read from
/// a file, neither need hold: `topology` finds out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Where the vertices are, in world space.
    pub positions: Positions,
    /// Unit normals, one per vertex, pointing outside.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Three vertices each, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// An empty mesh that, as a sink, takes normals too.
    pub fn with_normals() -> Self {
        Self { normals: Some(vec![]), ..Self::default() }
    }

    /// How many vertices and triangles there are.
    pub fn counts(&self) -> Counts {
        Counts { vertices: self.positions.len() as u64, triangles: self.triangles.len() as u64 }
    }

    /// The box around all vertices, used or not; none if there are none.
    pub fn bounds(&self) -> Option<Aabb> {
        Aabb::around(self.positions.iter())
    }

    /// The corners of a triangle.
    ///
    /// # Panics
    ///
    /// If the triangle names a vertex that is not there.
    #[inline]
    pub fn corners(&self, triangle: [u32; 3]) -> [[f64; 3]; 3] {
        triangle.map(|vertex| self.positions.get(vertex as usize))
    }
}

impl TriMesh {
    /// A sink that replaces what the mesh holds and uses its memory again. It takes normals if the mesh
    /// has some, be they none: see [`with_normals`](Self::with_normals).
    pub fn refill(&mut self) -> Refill<'_> {
        Refill { mesh: self, filled: Counts::default() }
    }

    /// Room for a new content in place of the old, in memory that is there or new. Normals as in
    /// [`refill`](Self::refill).
    pub fn renew(&mut self, counts: Counts, precision: Precision) -> Piece<'_> {
        self.truncate(counts);
        self.room(Counts::default(), counts, precision)
    }

    /// Room for `more` behind the first `held`, in memory that is there or new.
    pub(crate) fn room(&mut self, held: Counts, more: Counts, precision: Precision) -> Piece<'_> {
        if self.positions.precision() != precision {
            self.positions = match precision {
                Precision::F32 => Positions::F32(vec![]),
                Precision::F64 => Positions::F64(vec![]),
            };
        }
        let (vertices, more_vertices) = (held.vertices as usize, more.vertices as usize);
        Piece {
            positions: match &mut self.positions {
                Positions::F32(all) => PositionsMut::F32(room(all, vertices, more_vertices)),
                Positions::F64(all) => PositionsMut::F64(room(all, vertices, more_vertices)),
            },
            normals: self.normals.as_mut().map(|all| room(all, vertices, more_vertices)),
            triangles: room(&mut self.triangles, held.triangles as usize, more.triangles as usize),
        }
    }

    /// Forgets all but the first `held`.
    pub(crate) fn truncate(&mut self, held: Counts) {
        let vertices = held.vertices as usize;
        match &mut self.positions {
            Positions::F32(all) => all.truncate(vertices),
            Positions::F64(all) => all.truncate(vertices),
        }
        if let Some(normals) = &mut self.normals {
            normals.truncate(vertices);
        }
        self.triangles.truncate(held.triangles as usize);
    }
}

/// Replaces the content of a mesh, in the memory that it has. What is not filled is gone when this is
/// dropped.
#[derive(Debug)]
pub struct Refill<'a> {
    mesh: &'a mut TriMesh,
    filled: Counts,
}

impl MeshSink for Refill<'_> {
    type Error = Infallible;

    fn wants_normals(&self) -> bool {
        self.mesh.normals.is_some()
    }

    fn piece(&mut self, counts: Counts, precision: Precision) -> Result<Piece<'_>, Infallible> {
        let held = self.filled;
        self.filled.vertices += counts.vertices;
        self.filled.triangles += counts.triangles;
        Ok(self.mesh.room(held, counts, precision))
    }
}

impl Drop for Refill<'_> {
    fn drop(&mut self) {
        self.mesh.truncate(self.filled);
    }
}

/// The `more` items behind the first `held`. What is there already keeps its content, to be overwritten:
/// memory that was used before is not cleared, and new memory comes as zeros from the system, whose pages
/// are touched first by whoever fills them.
fn room<T: Copy + Default>(all: &mut Vec<T>, held: usize, more: usize) -> &mut [T] {
    if held == 0 && all.capacity() < more {
        *all = vec![T::default(); more];
    } else if all.len() < held + more {
        all.resize(held + more, T::default());
    }
    &mut all[held..held + more]
}

#[cfg(test)]
mod tests {
    use super::TriMesh;
    use crate::{Counts, MeshSink, PositionsMut, Precision};

    fn fill(sink: &mut impl MeshSink<Error: std::fmt::Debug>, vertices: u64, value: f32) {
        let counts = Counts { vertices, triangles: 2 * vertices };
        let piece = sink.piece(counts, Precision::F32).unwrap();
        let PositionsMut::F32(positions) = piece.positions else { panic!("asked for f32") };
        positions.fill([value; 3]);
        piece.triangles.fill([value as u32; 3]);
        assert_eq!(piece.triangles.len() as u64, 2 * vertices);
    }

    #[test]
    fn a_refilled_mesh_holds_the_new_content_alone_in_the_old_memory() {
        let mut mesh = TriMesh::with_normals();
        fill(&mut mesh.refill(), 9, 1.0);
        let memory = mesh.triangles.as_ptr();
        let mut refill = mesh.refill();
        fill(&mut refill, 2, 3.0);
        fill(&mut refill, 4, 5.0);
        drop(refill);
        assert_eq!(mesh.counts(), Counts { vertices: 6, triangles: 12 });
        assert_eq!((mesh.positions.get(1), mesh.positions.get(2)), ([3.0; 3], [5.0; 3]));
        assert_eq!(mesh.normals.as_ref().unwrap().len(), 6);
        assert_eq!(mesh.triangles.as_ptr(), memory);
        mesh.renew(Counts { vertices: 2, triangles: 12 }, Precision::F32);
        assert_eq!(mesh.counts(), Counts { vertices: 2, triangles: 12 });
        assert_eq!(mesh.triangles.as_ptr(), memory);
        drop(mesh.refill());
        assert_eq!(mesh.counts(), Counts::default());
    }
}
