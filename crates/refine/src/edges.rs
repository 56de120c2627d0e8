//! The edges of a mesh, numbered; and those of the mesh that cutting some of them makes.
//!
//! New vertices have greater numbers than old ones. So the edges between old vertices stay in their order, and
//! every other edge has a new vertex as its greater end: where few are cut, few are to be sorted in among the
//! rest.

use crate::{
    RefineError,
    exact::in_chunks,
    split::{Corner, Split, WHOLE},
};
use isokit_job::{Job, Stopped};
use isokit_mesh::{Stars, TriMesh};
use rayon::prelude::*;

/// In place of the number of an edge: it was none before.
pub(crate) const NEW: u32 = u32::MAX;

const WHAT: &str = "the edges of the surface";

/// Every edge once, in the order of its lesser end and then of its greater one.
#[derive(Debug, PartialEq)]
pub(crate) struct Edges {
    /// The two ends of each, the lesser first.
    pub(crate) ends: Vec<[u32; 2]>,
    /// The edges of each triangle: side `k` leads from corner `k` to the next.
    pub(crate) sides: Vec<[u32; 3]>,
}

impl Edges {
    /// Finds the edges of a mesh of sound triangles.
    pub(crate) fn new(mesh: &TriMesh, job: &Job) -> Result<Self, RefineError> {
        let (job, vertices) = (&job.unwatched(), mesh.positions.len());
        let stars = Stars::new(vertices, &mesh.triangles, job)?;
        // At most three for each triangle; half of that where the surface is closed. Held twice for a while.
        let most = (mesh.triangles.len() as u64).checked_mul(3);
        job.limits.probe(WHAT, most, size_of::<[u32; 2]>() + size_of::<u32>())?;
        let chunks = in_chunks(vertices, job, |range| {
            let (mut ends, mut counts) = (vec![], vec![]);
            for vertex in range {
                let (before, own) = (ends.len(), vertex as u32);
                for &t in stars.of(vertex) {
                    let others = mesh.triangles[t as usize].into_iter().filter(|&v| v > own);
                    ends.extend(others.map(|other| [own, other]));
                }
                ends[before..].sort_unstable();
                let mut kept = before;
                for n in before..ends.len() {
                    if kept == before || ends[kept - 1] != ends[n] {
                        ends[kept] = ends[n];
                        kept += 1;
                    }
                }
                ends.truncate(kept);
                counts.push((kept - before) as u32);
            }
            (ends, counts)
        })?;
        drop(stars);
        let count: usize = chunks.iter().map(|(ends, _)| ends.len()).sum();
        check(count, mesh)?;
        let mut ends = job.limits.vec(WHAT, Some(count as u64))?;
        let mut first = job.limits.vec(WHAT, Some(vertices as u64 + 1))?;
        first.push(0_u32);
        for (of_chunk, counts) in chunks {
            ends.extend(of_chunk);
            counts.into_iter().for_each(|n| first.push(first.last().map_or(n, |sum| sum + n)));
        }
        let sides = in_chunks(mesh.triangles.len(), job, |range| {
            let sides = |corners: &[u32; 3]| sides(*corners, &ends, &first);
            mesh.triangles[range].iter().map(sides).collect::<Vec<_>>()
        })?;
        Ok(Self { sides: sides.concat(), ends })
    }

    /// The edges of the mesh `built` that `split` made of the one whose edges these are, in which edge `n`
    /// has the new vertex `numbers[n]`; and of each the number that it had, or [`NEW`]. The same as all of
    /// them found anew, in less time.
    pub(crate) fn after(
        &self,
        split: &Split<'_>,
        (built, numbers): (&TriMesh, &[u32]),
        job: &Job,
    ) -> Result<(Self, Vec<u32>), RefineError> {
        let (job, states) = (&job.unwatched(), &split.states[..]);
        let fresh = self.fresh(split, numbers, job)?;
        let kept = states.iter().filter(|&&state| state == WHOLE).count();
        let count = kept + fresh.len();
        check(count, built)?;
        let mut ends = job.limits.vec(WHAT, Some(count as u64))?;
        let mut from = job.limits.vec(WHAT, Some(count as u64))?;
        let mut renamed = job.limits.vec(WHAT, Some(states.len() as u64))?;
        let mut rest = fresh.into_iter().peekable();
        for (edge, &own) in self.ends.iter().enumerate() {
            renamed.push(NEW);
            if states[edge] == WHOLE {
                while let Some(new) = rest.next_if(|new| *new < own) {
                    ends.push(new);
                    from.push(NEW);
                }
                renamed[edge] = ends.len() as u32;
                ends.push(own);
                from.push(edge as u32);
            }
        }
        ends.extend(rest);
        from.resize(ends.len(), NEW);
        let mut first = job.limits.vec(WHAT, Some(built.positions.len() as u64 + 1))?;
        for (edge, [low, _]) in ends.iter().enumerate() {
            first.resize(first.len().max(*low as usize + 1), edge as u32);
        }
        first.resize(built.positions.len() + 1, count as u32);
        let sides = in_chunks(self.sides.len(), job, |range| {
            let mut found = Vec::with_capacity(range.len());
            for t in range {
                if split.is_whole(t, states) {
                    found.push(self.sides[t].map(|side| renamed[side as usize]));
                    continue;
                }
                let (children, count) = split.children(t, states);
                let number = |corner: Corner| corner.number(numbers);
                let children = children[..count].iter().map(|child| child.map(number));
                found.extend(children.map(|child| sides(child, &ends, &first)));
            }
            found
        })?;
        Ok((Self { sides: sides.concat(), ends }, from))
    }

    /// The ends of edges that are new, in order, each once.
    fn fresh(
        &self,
        split: &Split<'_>,
        numbers: &[u32],
        job: &Job,
    ) -> Result<Vec<[u32; 2]>, Stopped> {
        let states = &split.states[..];
        let halves = in_chunks(states.len(), job, |range| {
            let cut = range.filter(|&edge| states[edge] != WHOLE);
            cut.flat_map(|edge| self.ends[edge].map(|end| [end, numbers[edge]])).collect::<Vec<_>>()
        })?;
        let inner = in_chunks(self.sides.len(), job, |range| {
            let mut found = vec![];
            for t in range.filter(|&t| !split.is_whole(t, states)) {
                let (children, count) = split.children(t, states);
                for [a, b, c] in &children[..count] {
                    // Each is a side of two of them, once in either direction.
                    let sides = [[a, b], [b, c], [c, a]].into_iter();
                    let sides = sides.filter(|[from, to]| !self.is_outer(**from, **to));
                    let ends = sides.map(|side| side.map(|corner| corner.number(numbers)));
                    found.extend(ends.filter(|[from, to]| from < to));
                }
            }
            found
        })?;
        let mut fresh = halves.concat();
        inner.into_iter().for_each(|inner| fresh.extend(inner));
        job.threads.run(|| fresh.par_sort_unstable());
        // Two triangles of the same three vertices have the same edges within.
        fresh.dedup();
        Ok(fresh)
    }

    /// Whether a side of a new triangle is an old edge, or half of one.
    fn is_outer(&self, from: Corner, to: Corner) -> bool {
        match (from, to) {
            (Corner::Vertex(_), Corner::Vertex(_)) => true,
            (Corner::Edge(_), Corner::Edge(_)) => false,
            (Corner::Vertex(end), Corner::Edge(edge))
            | (Corner::Edge(edge), Corner::Vertex(end)) => self.ends[edge as usize].contains(&end),
        }
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }
}

/// Edges are numbered in 32 bits.
fn check(count: usize, mesh: &TriMesh) -> Result<(), RefineError> {
    let (vertices, triangles) = (mesh.positions.len() as u64, mesh.triangles.len() as u64);
    match u32::try_from(count) {
        Ok(_) => Ok(()),
        Err(_) => Err(RefineError::TooLarge { vertices: vertices + count as u64, triangles }),
    }
}

/// The edges of a triangle, found among all, of which `first[v]` is the first whose lesser end is `v`.
fn sides([a, b, c]: [u32; 3], ends: &[[u32; 2]], first: &[u32]) -> [u32; 3] {
    [[a, b], [b, c], [c, a]].map(|[from, to]| {
        let [low, high] = [from.min(to), from.max(to)];
        let [begin, end] = [low, low + 1].map(|vertex| first[vertex as usize] as usize);
        (begin + ends[begin..end].partition_point(|ends| ends[1] < high)) as u32
    })
}
