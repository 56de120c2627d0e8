//! The edges of a mesh, numbered.

use crate::RefineError;
use isokit_job::{Job, in_chunks};
use isokit_mesh::{Stars, TriMesh};

/// Every edge once, in the order of its lesser end and then of its greater one.
#[derive(Debug)]
pub(crate) struct Edges {
    /// The two ends of each, the lesser first.
    pub(crate) ends: Vec<[u32; 2]>,
    /// The edges of each triangle: side `k` leads from corner `k` to the next.
    pub(crate) sides: Vec<[u32; 3]>,
}

impl Edges {
    /// Finds the edges of a mesh of sound triangles.
    pub(crate) fn new(mesh: &TriMesh, stars: &Stars, job: &Job) -> Result<Self, RefineError> {
        const WHAT: &str = "the edges of the surface";
        let (job, vertices) = (&job.unwatched(), mesh.positions.len());
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
        let count: usize = chunks.iter().map(|(ends, _)| ends.len()).sum();
        if count > u32::MAX as usize {
            let (vertices, triangles) = (vertices as u64, mesh.triangles.len() as u64);
            return Err(RefineError::TooLarge { vertices: vertices + count as u64, triangles });
        }
        let mut ends = job.limits.vec(WHAT, Some(count as u64))?;
        let mut first = job.limits.vec(WHAT, Some(vertices as u64 + 1))?;
        first.push(0_u32);
        for (of_chunk, counts) in chunks {
            ends.extend(of_chunk);
            counts.into_iter().for_each(|n| first.push(first.last().map_or(n, |sum| sum + n)));
        }
        let side = |a: u32, b: u32| {
            let [low, high] = [a.min(b), a.max(b)];
            let own = first[low as usize] as usize..first[low as usize + 1] as usize;
            let place = ends[own.clone()].partition_point(|end: &[u32; 2]| end[1] < high);
            (own.start + place) as u32
        };
        let sides = in_chunks(mesh.triangles.len(), job, |range| {
            let sides = |&[a, b, c]: &[u32; 3]| [side(a, b), side(b, c), side(c, a)];
            mesh.triangles[range].iter().map(sides).collect::<Vec<_>>()
        })?;
        Ok(Self { sides: sides.concat(), ends })
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }
}
