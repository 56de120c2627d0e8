//! How a surface is kept.

use crate::{Attributes, Counts, MeshSink, Piece, PositionsMut};
use isokit_geom::Aabb;
use std::{convert::Infallible, mem};

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
    /// What vertices carry besides. Whatever makes new vertices leaves none.
    pub attributes: Attributes,
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

    /// All triangles of several meshes, with their vertices in f64 one mesh after the other; without normals, values and
    /// colours. None if 32 bits cannot number the vertices.
    pub fn joined<'a>(meshes: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        let (mut positions, mut triangles) = (vec![], vec![]);
        for mesh in meshes {
            let base = u32::try_from(positions.len()).ok()?;
            base.checked_add(u32::try_from(mesh.positions.len()).ok()?)?;
            positions.extend(mesh.positions.iter());
            triangles.extend(mesh.triangles.iter().map(|t| t.map(|vertex| base + vertex)));
        }
        Some(Self { positions: Positions::F64(positions), triangles, ..Self::default() })
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
        self.attributes = Attributes::default();
        Refill { mesh: self, filled: Counts::default(), is_lent: false, is_guessed: false }
    }

    /// Room for a new content in place of the old, in memory that is there or new. Normals as in
    /// [`refill`](Self::refill).
    pub fn renew(&mut self, counts: Counts, precision: Precision) -> Piece<'_> {
        self.attributes = Attributes::default();
        self.truncate(counts);
        self.room(Counts::default(), counts, precision)
    }

    /// Room for `more` behind the first `held`, in memory that is there or new.
    pub(crate) fn room(&mut self, held: Counts, more: Counts, precision: Precision) -> Piece<'_> {
        self.make(precision);
        if held == Counts::default() {
            self.reserve(more, 0);
        }
        self.grown(held, more)
    }

    /// Positions of a precision. If they have another, they are forgotten.
    fn make(&mut self, precision: Precision) {
        if self.positions.precision() != precision {
            self.positions = match precision {
                Precision::F32 => Positions::F32(vec![]),
                Precision::F64 => Positions::F64(vec![]),
            };
        }
    }

    /// Takes new memory for `counts` where there is not enough; of the old content the first `kept` items of
    /// each list stay.
    fn reserve(&mut self, counts: Counts, kept: usize) {
        let (vertices, triangles) = (counts.vertices as usize, counts.triangles as usize);
        match &mut self.positions {
            Positions::F32(all) => reserve(all, vertices, kept),
            Positions::F64(all) => reserve(all, vertices, kept),
        }
        if let Some(normals) = &mut self.normals {
            reserve(normals, vertices, kept);
        }
        reserve(&mut self.triangles, triangles, kept);
    }

    /// What there is memory for behind the first `held` without much clearing of it.
    fn spare(&self, held: Counts) -> Counts {
        let positions = match &self.positions {
            Positions::F32(all) => spare(all),
            Positions::F64(all) => spare(all),
        };
        let vertices = self.normals.as_ref().map_or(positions, |all| positions.min(spare(all)));
        Counts {
            vertices: (vertices as u64).saturating_sub(held.vertices),
            triangles: (spare(&self.triangles) as u64).saturating_sub(held.triangles),
        }
    }

    /// Room for `more` behind the first `held`.
    fn grown(&mut self, held: Counts, more: Counts) -> Piece<'_> {
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

    /// Whether there is memory for some vertex or triangle.
    fn has_memory(&self) -> bool {
        let positions = match &self.positions {
            Positions::F32(all) => all.capacity(),
            Positions::F64(all) => all.capacity(),
        };
        let normals = self.normals.as_ref().map_or(0, Vec::capacity);
        positions + normals + self.triangles.capacity() > 0
    }

    /// Gives back the memory behind what it holds.
    fn shrink(&mut self) {
        match &mut self.positions {
            Positions::F32(all) => shrink(all),
            Positions::F64(all) => shrink(all),
        }
        if let Some(normals) = &mut self.normals {
            shrink(normals);
        }
        shrink(&mut self.triangles);
    }
}

/// Replaces the content of a mesh, in the memory that it has. What is not filled is gone when this is
/// dropped.
#[derive(Debug)]
pub struct Refill<'a> {
    mesh: &'a mut TriMesh,
    filled: Counts,
    /// Whether something may be written already behind what is filled.
    is_lent: bool,
    /// Whether there is memory for more than was known to come.
    is_guessed: bool,
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
        if mem::take(&mut self.is_lent) {
            self.mesh.reserve(self.filled, usize::MAX);
            return Ok(self.mesh.grown(held, counts));
        }
        Ok(self.mesh.room(held, counts, precision))
    }

    /// What the mesh held before, and a little more where there is memory. Without any, new memory, of which only
    /// what is written becomes real.
    fn spare(&mut self, likely: Counts, precision: Precision) -> Option<Piece<'_>> {
        self.mesh.make(precision);
        if likely != Counts::default() && !self.mesh.has_memory() {
            self.mesh.reserve(likely, 0);
            self.is_guessed = true;
        }
        let (held, more) = (self.filled, self.mesh.spare(self.filled));
        self.is_lent = more.vertices > 0 && more.triangles > 0;
        self.is_lent.then(|| self.mesh.grown(held, more))
    }

    fn held(&mut self) -> Option<Piece<'_>> {
        Some(self.mesh.grown(Counts::default(), self.filled))
    }
}

impl Drop for Refill<'_> {
    fn drop(&mut self) {
        self.mesh.truncate(self.filled);
        if self.is_guessed {
            self.mesh.shrink();
        }
    }
}

/// Takes new memory for `count` items if there is not enough, and copies the first `kept` that are there.
/// New memory comes as zeros from the system, whose pages are touched first by whoever fills them.
fn reserve<T: Copy + Default>(all: &mut Vec<T>, count: usize, kept: usize) {
    if all.capacity() < count {
        let kept = kept.min(all.len());
        let mut new = vec![T::default(); count];
        new[..kept].copy_from_slice(&all[..kept]);
        *all = new;
    }
}

/// Gives back the memory behind the items. Few are copied, so that nothing is left of the pages they were in, of
/// which the system may give large ones.
fn shrink<T: Copy>(all: &mut Vec<T>) {
    const FEW: usize = 1 << 20;
    match size_of_val(&all[..]) < FEW {
        true => *all = all.as_slice().into(),
        false => all.shrink_to_fit(),
    }
}

/// So many items there are, and an eighth more if there is memory: the next surface is seldom of the same size,
/// and what no item was in yet must be cleared.
fn spare<T>(all: &Vec<T>) -> usize {
    all.capacity().min(all.len() + all.len() / 8)
}

/// The `more` items behind the first `held`. What is there already keeps its content, to be overwritten:
/// memory that was used before is not cleared.
fn room<T: Copy + Default>(all: &mut Vec<T>, held: usize, more: usize) -> &mut [T] {
    if all.len() < held + more {
        all.resize(held + more, T::default());
    }
    &mut all[held..held + more]
}

#[cfg(test)]
mod tests;
