//! How a surface is kept.

use crate::{Counts, MeshSink, Piece, PositionsMut};
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
        Refill { mesh: self, filled: Counts::default(), is_lent: false, is_guessed: false }
    }

    /// Room for a new content in place of the old, in memory that is there or new. Normals as in
    /// [`refill`](Self::refill).
    pub fn renew(&mut self, counts: Counts, precision: Precision) -> Piece<'_> {
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

    /// Gives back the memory behind what it holds.
    fn shrink(&mut self) {
        match &mut self.positions {
            Positions::F32(all) => all.shrink_to_fit(),
            Positions::F64(all) => all.shrink_to_fit(),
        }
        if let Some(normals) = &mut self.normals {
            normals.shrink_to_fit();
        }
        self.triangles.shrink_to_fit();
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

    /// What the mesh held before, and a little more where there is memory. If it never held anything, new memory,
    /// of which only what is written becomes real.
    fn spare(&mut self, likely: Counts, precision: Precision) -> Option<Piece<'_>> {
        self.mesh.make(precision);
        if self.mesh.counts() == Counts::default() && likely != Counts::default() {
            self.mesh.reserve(likely, 0);
            self.is_guessed = true;
        }
        let (held, more) = (self.filled, self.mesh.spare(self.filled));
        self.is_lent = more != Counts::default();
        self.is_lent.then(|| self.mesh.grown(held, more))
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
mod tests {
    use super::TriMesh;
    use crate::{Counts, MeshSink, Piece, PositionsMut, Precision};

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

    #[test]
    fn what_is_written_to_spare_memory_begins_the_next_piece_whatever_its_size() {
        for (before, after) in [(9, 4), (9, 9), (9, 700), (1, 100_000)] {
            let mut mesh = TriMesh::with_normals();
            let none = Counts::default();
            assert!(mesh.refill().spare(none, Precision::F32).is_none(), "it holds nothing");
            fill(&mut mesh.refill(), before, 1.0);
            let mut refill = mesh.refill();
            let spare = refill.spare(none, Precision::F32).unwrap();
            assert_eq!(spare.normals.map(|normals| normals.len() as u64), Some(before));
            spare.triangles[0] = [7; 3];
            let counts = Counts { vertices: after, triangles: 2 * after };
            let piece = refill.piece(counts, Precision::F32).unwrap();
            assert_eq!(piece.triangles[0], [7; 3]);
            let first = Counts { vertices: after - 1, triangles: 1 };
            let Piece { positions, triangles, .. } = piece.after(first);
            let PositionsMut::F32(positions) = positions else { panic!("asked for f32") };
            assert_eq!((positions.len(), triangles.len() as u64), (1, 2 * after - 1));
            drop(refill);
            assert_eq!(mesh.counts(), counts);
        }
        let mut other = TriMesh::with_normals();
        fill(&mut other.refill(), 5, 1.0);
        let mut refill = other.refill();
        let spare = refill.spare(Counts::default(), Precision::F64);
        assert!(spare.is_none_or(|spare| spare.triangles.len() == 10), "positions are forgotten");
    }

    #[test]
    fn of_new_memory_for_what_is_likely_a_mesh_keeps_what_it_holds() {
        let likely = Counts { vertices: 5_000_000, triangles: 9_000_000 };
        for vertices in [0, 3, 70_000, 6_000_000] {
            let mut mesh = TriMesh::with_normals();
            let mut refill = mesh.refill();
            let spare = refill.spare(likely, Precision::F32).unwrap();
            assert_eq!(spare.triangles.len() as u64, likely.triangles);
            spare.triangles[..2].fill([7; 3]);
            let counts = Counts { vertices, triangles: 2 * vertices };
            let piece = refill.piece(counts, Precision::F32).unwrap();
            assert!(piece.triangles.iter().take(2).all(|&triangle| triangle == [7; 3]));
            drop(refill);
            assert_eq!(mesh.counts(), counts);
            let capacities = [mesh.normals.unwrap().capacity(), mesh.triangles.capacity()];
            assert_eq!(capacities.map(|capacity| capacity as u64), [vertices, 2 * vertices]);
        }
    }
}
