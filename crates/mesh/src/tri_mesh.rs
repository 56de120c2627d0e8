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

    /// Removes everything and keeps the memory, for the next surface.
    pub fn clear(&mut self) {
        match &mut self.positions {
            Positions::F32(positions) => positions.clear(),
            Positions::F64(positions) => positions.clear(),
        }
        self.normals.iter_mut().for_each(Vec::clear);
        self.triangles.clear();
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

/// Keeps the surface, all pieces as one mesh, after what is there already: a used mesh is
/// [cleared](TriMesh::clear) first.
impl MeshSink for TriMesh {
    type Error = Infallible;

    fn wants_normals(&self) -> bool {
        self.normals.is_some()
    }

    fn piece(&mut self, counts: Counts, precision: Precision) -> Result<Piece<'_>, Infallible> {
        let vertices = counts.vertices as usize;
        let positions = match precision {
            Precision::F32 => {
                if !matches!(self.positions, Positions::F32(_)) {
                    self.positions = Positions::F32(vec![]);
                }
                match &mut self.positions {
                    Positions::F32(all) => PositionsMut::F32(grown(all, vertices)),
                    Positions::F64(_) => unreachable!("set above"),
                }
            }
            Precision::F64 => {
                if !matches!(self.positions, Positions::F64(_)) {
                    self.positions = Positions::F64(vec![]);
                }
                match &mut self.positions {
                    Positions::F64(all) => PositionsMut::F64(grown(all, vertices)),
                    Positions::F32(_) => unreachable!("set above"),
                }
            }
        };
        Ok(Piece {
            positions,
            normals: self.normals.as_mut().map(|all| grown(all, vertices)),
            triangles: grown(&mut self.triangles, counts.triangles as usize),
        })
    }
}

/// Makes a vector longer by `more` items and gives those.
fn grown<T: Copy + Default>(all: &mut Vec<T>, more: usize) -> &mut [T] {
    let old = all.len();
    if old == 0 && all.capacity() < more {
        // Zeroed memory straight from the system: each page is touched first by whoever fills it.
        *all = vec![T::default(); more];
    } else {
        all.resize(old + more, T::default());
    }
    &mut all[old..]
}
