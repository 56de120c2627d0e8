//! Who is next to whom: the triangles around each vertex, and the edges that leave it.
//!
//! Only *sound* triangles have neighbours: those of three different vertices that are there.
//!
//! The triangles around all vertices stand in one array, vertex after vertex. Each thread owns a range of
//! vertices and reads all triangles for them, so nothing is shared and the order never varies.

use isokit_job::{Job, OverLimit, Stopped};
use rayon::prelude::*;

/// Whether a triangle has three different vertices, all of them among the first `vertices`.
#[inline]
pub(crate) fn is_sound([a, b, c]: [u32; 3], vertices: usize) -> bool {
    a != b && b != c && c != a && (a.max(b).max(c) as usize) < vertices
}

/// The sound triangles around each vertex, in ascending order: those of three different vertices that are
/// there.
#[derive(Debug)]
pub struct Stars {
    /// Where the triangles of each vertex begin, and, last, how many there are in all.
    first: Vec<usize>,
    triangles: Vec<u32>,
}

impl Stars {
    /// Finds the triangles around each vertex. Advances by the vertices.
    ///
    /// # Errors
    ///
    /// If the job is cancelled or allows less memory than this takes: 8 bytes per vertex, 12 per triangle.
    pub fn new(vertices: usize, triangles: &[[u32; 3]], job: &Job) -> Result<Self, Stopped> {
        const WHAT: &str = "the triangles around each vertex";
        if u32::try_from(triangles.len()).is_err() {
            // Triangles are numbered in 32 bits; so many take 48 GiB themselves.
            return Err(OverLimit { what: WHAT, needed: u64::MAX, limit: job.limits.bytes }.into());
        }
        let mut first = job.limits.vec(WHAT, Some(vertices as u64 + 1))?;
        first.resize(vertices + 1, 0_usize);
        // One range of vertices for each thread; more would read all triangles more often.
        let range = vertices.div_ceil(job.threads.count()).max(1);
        let corners = |low: usize, high: usize| {
            let all = triangles.iter().enumerate().filter(move |(_, t)| is_sound(**t, vertices));
            let all =
                all.flat_map(|(t, corners)| corners.map(|vertex| (t as u32, vertex as usize)));
            all.filter(move |&(_, vertex)| low <= vertex && vertex < high)
        };

        job.check()?;
        job.threads.run(|| {
            first[1..].par_chunks_mut(range).enumerate().for_each(|(n, counts)| {
                let low = n * range;
                corners(low, low + counts.len()).for_each(|(_, vertex)| counts[vertex - low] += 1);
            });
        });
        let mut total = 0;
        for count in &mut first {
            total += *count;
            *count = total;
        }

        job.check()?;
        let mut around: Vec<u32> = job.limits.vec(WHAT, Some(total as u64))?;
        around.resize(total, 0);
        let (mut parts, mut rest) = (vec![], &mut around[..]);
        for low in (0..vertices).step_by(range) {
            let high = vertices.min(low + range);
            let (part, after) = rest.split_at_mut(first[high] - first[low]);
            parts.push((low, high, part));
            rest = after;
        }
        job.threads.run(|| {
            parts.into_par_iter().for_each(|(low, high, part)| {
                let mut next: Vec<usize> =
                    first[low..high].iter().map(|begin| begin - first[low]).collect();
                for (t, vertex) in corners(low, high) {
                    part[next[vertex - low]] = t;
                    next[vertex - low] += 1;
                }
            });
        });
        job.progress.advance(vertices as u64);
        Ok(Self { first, triangles: around })
    }

    /// The triangles around `vertex`.
    ///
    /// # Panics
    ///
    /// If there is no such vertex.
    #[inline]
    pub fn of(&self, vertex: usize) -> &[u32] {
        &self.triangles[self.first[vertex]..self.first[vertex + 1]]
    }
}

/// The two other corners of a triangle around `vertex`: the one after it and the one before it.
#[inline]
pub fn others([a, b, c]: [u32; 3], vertex: u32) -> [u32; 2] {
    match vertex {
        v if v == a => [b, c],
        v if v == b => [c, a],
        _ => [a, b],
    }
}

/// One side of a triangle, seen from the vertex that it leaves or reaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Spoke {
    /// The vertex at the other end.
    pub(crate) to: u32,
    /// The place of the triangle among those around the vertex.
    pub(crate) place: u32,
    /// Whether the triangle goes from the vertex to the other end, not back.
    pub(crate) leaves: bool,
}

/// Fills `spokes` with all sides that end at `vertex`; those of one edge stand together.
pub(crate) fn spokes(mesh: &[[u32; 3]], star: &[u32], vertex: usize, spokes: &mut Vec<Spoke>) {
    spokes.clear();
    for (place, &t) in (0..).zip(star) {
        let [next, before] = others(mesh[t as usize], vertex as u32);
        spokes.push(Spoke { to: next, place, leaves: true });
        spokes.push(Spoke { to: before, place, leaves: false });
    }
    spokes.sort_unstable();
}

/// The edges of a vertex, each as all the sides that lie in it.
pub(crate) fn edges(spokes: &[Spoke]) -> impl Iterator<Item = &[Spoke]> {
    spokes.chunk_by(|a, b| a.to == b.to)
}

#[cfg(test)]
mod tests {
    use super::{Spoke, Stars, edges, spokes};
    use crate::kit::threads;

    const FAN: [[u32; 3]; 5] = [[0, 1, 2], [3, 0, 2], [0, 0, 1], [0, 1, 9], [4, 2, 1]];

    #[test]
    fn stars_hold_sound_triangles_in_order() {
        for count in [1, 2, 3, 7] {
            let stars = Stars::new(6, &FAN, &threads(count)).unwrap();
            let all: Vec<&[u32]> = (0..6).map(|vertex| stars.of(vertex)).collect();
            assert_eq!(all, [&[0, 1][..], &[0, 4], &[0, 1, 4], &[1], &[4], &[]]);
        }
    }

    #[test]
    fn sides_of_an_edge_stand_together() {
        let (stars, mut found) = (Stars::new(6, &FAN, &threads(1)).unwrap(), vec![]);
        spokes(&FAN, stars.of(2), 2, &mut found);
        let uses: Vec<_> = edges(&found).map(|edge| (edge[0].to, edge.len())).collect();
        assert_eq!(uses, [(0, 2), (1, 2), (3, 1), (4, 1)]);
        assert_eq!(found[0], Spoke { to: 0, place: 0, leaves: true });
        assert_eq!(found[1], Spoke { to: 0, place: 1, leaves: false });
    }
}
