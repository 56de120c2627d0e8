//! The pieces of a surface.
//!
//! Two triangles are in one piece if one can walk from one to the other across edges. Pieces that touch
//! in a vertex stay apart, as they do where trimesh or MeshLab count bodies; for a manifold surface this
//! makes no difference.
//!
//! All threads merge pieces at once, without locks: of two roots the greater is hung under the lesser, so
//! in the end each piece is named by its first triangle, whoever came first.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// One piece of a surface: all triangles that can be reached from one another across edges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Component {
    /// Triangles.
    pub triangles: u64,
    /// Vertices that these use. A vertex in which two pieces touch counts in both.
    pub vertices: u64,
    /// Edges, each counted once.
    pub edges: u64,
    /// Edges of one triangle only.
    pub boundary_edges: u64,
    /// Edges of more than two triangles.
    pub nonmanifold_edges: u64,
    /// Vertices around which the triangles *of this piece* are not one fan.
    pub nonmanifold_vertices: u64,
    /// Edges along which neighbours are wound against one another.
    pub inconsistent_edges: u64,
    /// Sum of the areas, in the squared unit of positions.
    pub area: f64,
    /// The volume inside, in the cubed unit of positions, if the piece is closed and consistently wound.
    /// That of a cavity is negative, and so is that of a piece wound inside out.
    pub volume: f64,
}

impl Component {
    /// Vertices − edges + triangles.
    pub fn euler(&self) -> i64 {
        self.vertices as i64 - self.edges as i64 + self.triangles as i64
    }

    /// How many handles it has: 0 for a sphere, 1 for a torus. `None` unless the piece is closed, manifold
    /// and consistently wound.
    pub fn genus(&self) -> Option<u64> {
        let flaws = [
            self.boundary_edges,
            self.nonmanifold_edges,
            self.nonmanifold_vertices,
            self.inconsistent_edges,
        ];
        if flaws != [0; 4] {
            return None;
        }
        u64::try_from(1 - self.euler() / 2).ok()
    }
}

/// Which triangles are known to be in one piece; all threads may add to it.
#[derive(Debug)]
pub(crate) struct Pieces(Vec<AtomicU32>);

impl Pieces {
    /// Each of `triangles` triangles is a piece of its own.
    pub(crate) fn new(triangles: u32) -> Self {
        Self((0..triangles).map(AtomicU32::new).collect())
    }

    /// Makes the pieces of two triangles one.
    #[inline]
    pub(crate) fn unite(&self, a: u32, b: u32) {
        let (mut a, mut b) = (a, b);
        loop {
            (a, b) = (self.root(a), self.root(b));
            if a == b {
                return;
            }
            let (low, high) = (a.min(b), a.max(b));
            // Fails if another thread was faster to hang `high` somewhere: then look again.
            if self.0[high as usize].compare_exchange(high, low, Relaxed, Relaxed).is_ok() {
                return;
            }
        }
    }

    /// A triangle's forebear without a parent. Shortens the way there: a triangle once hung never becomes
    /// a root again and only ever hangs under lesser ones, so it does no harm if this comes late.
    #[inline]
    fn root(&self, mut t: u32) -> u32 {
        loop {
            let parent = self.0[t as usize].load(Relaxed);
            if parent == t {
                return t;
            }
            let above = self.0[parent as usize].load(Relaxed);
            if above != parent {
                self.0[t as usize].store(above, Relaxed);
            }
            t = above;
        }
    }

    /// Whether no triangle before this one is in its piece.
    pub(crate) fn is_first(&self, t: u32) -> bool {
        self.0[t as usize].load(Relaxed) == t
    }

    /// The number of each triangle's piece, and how many pieces there are. Pieces are numbered in the
    /// order of their first triangles; a triangle for which `counts` is false has no piece, and the number
    /// [`NO_PIECE`].
    pub(crate) fn labels(self, counts: impl Fn(usize) -> bool) -> (Vec<u32>, usize) {
        let mut labels: Vec<u32> = self.0.into_iter().map(AtomicU32::into_inner).collect();
        let mut pieces = 0;
        for t in 0..labels.len() {
            // A parent comes before its children, so it has its label already.
            let parent = labels[t] as usize;
            labels[t] = if parent != t {
                labels[parent]
            } else if counts(t) {
                pieces += 1;
                pieces - 1
            } else {
                NO_PIECE
            };
        }
        (labels, pieces as usize)
    }
}

/// In place of a piece's number, for a triangle that is in none.
pub(crate) const NO_PIECE: u32 = u32::MAX;

#[cfg(test)]
mod tests {
    use super::{NO_PIECE, Pieces};
    use rayon::prelude::*;

    #[test]
    fn pieces_are_numbered_by_their_first_triangles() {
        let pieces = Pieces::new(6);
        pieces.unite(5, 1);
        pieces.unite(4, 3);
        pieces.unite(3, 5);
        assert_eq!(pieces.labels(|t| t != 2), (vec![0, 1, NO_PIECE, 1, 1, 1], 2));
    }

    #[test]
    fn many_threads_find_one_chain() {
        let pieces = Pieces::new(100_000);
        (0..99_999).into_par_iter().for_each(|t| pieces.unite(99_999 - t, 99_998 - t));
        let (labels, count) = pieces.labels(|_| true);
        assert!(count == 1 && labels.iter().all(|&label| label == 0));
    }
}
