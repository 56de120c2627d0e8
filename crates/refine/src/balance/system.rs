//! By how far vertices are to move along their normals.
//!
//! With its corners on the surface, a triangle lies below it by s = ½ Σ λᵢλⱼ hᵢⱼ, summed over its sides: λ are
//! barycentric coordinates, and hᵢⱼ is the second fundamental form along side ij, which on a ball of
//! radius R is its squared length over R. That is exact where the surface is of degree two. By how much the
//! normal turns along a side tells it: hᵢⱼ = (nⱼ − nᵢ) · (pⱼ − pᵢ) (Rusinkiewicz 2004, "Estimating curvatures
//! and their derivatives on triangle meshes"). It needs no second derivative, is right to O(L⁴), and in noise
//! never exceeds twice the side.
//!
//! Offsets d of the vertices along their normals raise the triangle by Σ λᵢdᵢ. Those by which the square of
//! what remains, over the whole surface, is least solve M d = b, where a triangle of area A adds
//!
//! ```text
//! A/6 to Mᵢᵢ,  A/12 to Mᵢⱼ,  A (2hᵢⱼ + 2hᵢₖ + hⱼₖ) / 120 to bᵢ
//! ```
//!
//! With L the sums of the rows, a third of the areas around each vertex, all eigenvalues of L⁻¹M are between ¼
//! and 1, in any mesh (after Wathen 1987). So a few steps d ← d + L⁻¹(b − M d) / r do: each takes what is left
//! of an eigenvector with the eigenvalue λ times 1 − λ/r, and with the roots of a Chebyshev polynomial for r, all
//! that is left at last is small alike. The last root is 1. Then the sums of M d and of b are the same,
//! whatever is left, all around: what remains has the mean 0, and the volume inside is right to the same
//! order as the offsets.
//!
//! # The order of sums
//!
//! Vertices gather what triangles add, triangle after triangle, so the sums are the same for any number of
//! threads: each owns a range of vertices, walks all triangles that have one of those, and adds to its own.
//! Everything is in f32, in units in which a cell is about 1 long: the offsets are small beside that.

use super::{Coordinate, Vertices};
use crate::exact::in_chunks;
use isokit_job::{CHUNK, Cancelled, Job};
use isokit_lanes::exactly;
use rayon::prelude::*;
use std::ops::Range;

/// The roots of the Chebyshev polynomial of degree two for an interval that begins at ¼, so long that the greater
/// is 1; one for each step: ¼ + ¾ (3 − 2√2), and 1. The first step, from 0, asks no triangle.
///
/// On a ball and a ring of 32³ to 128³ samples one step leaves 1.028 times the root mean square that the solution
/// leaves, two 1.005, three 1.0006.
pub(super) const ROOTS: [f32; 2] = [0.378_679_66, 1.0];

/// An area beyond which sums may overflow.
const LARGEST: f32 = 1e20;

/// The equations of all offsets.
pub(super) struct System {
    parts: Vec<Part>,
    /// Vertices of each part but the last.
    range: usize,
    vertices: usize,
}

/// The equations of a range of vertices.
struct Part {
    first: usize,
    /// The triangles that have one of the vertices, no run longer than a chunk.
    runs: Vec<Range<usize>>,
    /// Of each of these a twelfth of the area; 0 where a corner has no normal.
    weights: Vec<f32>,
    /// The square of the longest side.
    longest: f32,
    /// Of each vertex the right-hand side over the sum of the row, and one over that sum, both 0 where there
    /// is no equation. On the way there, sums over triangles.
    rows: Vec<[f32; 2]>,
    /// Sums over triangles of weights times the sum of the offsets of all corners.
    spread: Vec<f32>,
}

impl System {
    pub(super) fn new<C: Coordinate>(
        vertices: &Vertices<'_, C>,
        triangles: &[[u32; 3]],
        job: &Job,
    ) -> Result<Self, Cancelled> {
        let count = vertices.places.len();
        let range = count.div_ceil(job.threads.count()).max(1);
        // The least and the greatest vertex of each chunk of triangles, so that parts skip those of others.
        let is_one = range >= count;
        let bounds = in_chunks(triangles.len(), &job.unwatched(), |chunk| match is_one {
            true => (0, 0),
            false => bounds(&triangles[chunk]),
        })?;
        let new = |first: usize| {
            let own = first..count.min(first + range);
            let runs = runs(&own, &bounds, triangles);
            let mut part = Part {
                first,
                weights: Vec::with_capacity(runs.iter().map(Range::len).sum()),
                runs,
                longest: 0.0,
                rows: vec![[0.0; 2]; own.len()],
                spread: vec![0.0; own.len()],
            };
            exactly(|| part.fill(vertices, triangles, job))?;
            Ok(part)
        };
        let firsts: Vec<_> = (0..count).step_by(range).collect();
        let parts = job.threads.run(|| firsts.into_par_iter().map(new).collect::<Result<_, _>>());
        Ok(Self { parts: parts?, range, vertices: count })
    }

    /// The offsets; not a number where there is no equation.
    pub(super) fn solved(
        &mut self,
        triangles: &[[u32; 3]],
        job: &Job,
    ) -> Result<Vec<f32>, Cancelled> {
        let mut offsets = vec![0.0; self.vertices];
        for (step, root) in ROOTS.into_iter().enumerate() {
            job.check()?;
            let (range, parts) = (self.range, &mut self.parts);
            job.threads.run(|| {
                if step > 0 {
                    let known = &offsets[..];
                    let spread = |part: &mut Part| exactly(|| part.spread(triangles, known));
                    parts.par_iter_mut().for_each(spread);
                }
                let own = parts.par_iter_mut().zip(offsets.par_chunks_mut(range));
                own.for_each(|(part, offsets)| {
                    exactly(|| part.step(offsets, 1.0 / root, step + 1 == ROOTS.len()));
                });
            });
        }
        job.progress.advance(self.vertices as u64);
        Ok(offsets)
    }

    /// The triangles that may be spoiled if their corners go such ways, and in a file so much farther, in order, some of
    /// them twice.
    pub(super) fn doubted(
        &self,
        triangles: &[[u32; 3]],
        (ways, in_file): (&[f32], f32),
        job: &Job,
    ) -> Result<Vec<[u32; 3]>, Cancelled> {
        job.check()?;
        let doubted = |part: &Part| exactly(|| part.doubted(triangles, (ways, in_file)));
        let each: Vec<_> = job.threads.run(|| self.parts.par_iter().map(doubted).collect());
        Ok(each.concat())
    }
}

/// The least and the greatest vertex.
fn bounds(triangles: &[[u32; 3]]) -> (u32, u32) {
    let wider = |(low, high): (u32, u32), [a, b, c]: &[u32; 3]| {
        (low.min(*a.min(b).min(c)), high.max(*a.max(b).max(c)))
    };
    triangles.iter().fold((u32::MAX, 0), wider)
}

/// The triangles that have one of a range of vertices.
fn runs(own: &Range<usize>, bounds: &[(u32, u32)], triangles: &[[u32; 3]]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = vec![];
    for (n, &(low, high)) in bounds.iter().enumerate() {
        let chunk = n * CHUNK..triangles.len().min((n + 1) * CHUNK);
        let (low, high) = (low as usize, high as usize);
        if own.contains(&low) && own.contains(&high) {
            runs.push(chunk);
        } else if low < own.end && own.start <= high {
            let is_own = |t: &usize| triangles[*t].iter().any(|&v| own.contains(&(v as usize)));
            let before = runs.len(); // runs do not go on from chunk to chunk
            for t in chunk.filter(is_own) {
                match runs[before..].last_mut() {
                    Some(run) if run.end == t => run.end = t + 1,
                    _ => runs.push(t..t + 1),
                }
            }
        }
    }
    runs
}

impl Part {
    /// Makes weights and rows.
    fn fill<C: Coordinate>(
        &mut self,
        vertices: &Vertices<'_, C>,
        triangles: &[[u32; 3]],
        job: &Job,
    ) -> Result<(), Cancelled> {
        for run in &self.runs {
            job.check()?;
            for &triangle in &triangles[run.clone()] {
                let (weight, bends) = vertices.bent(triangle, &mut self.longest);
                self.weights.push(weight);
                let all = 2.0 * (bends[0] + bends[1] + bends[2]);
                for (v, bend) in triangle.into_iter().zip(bends) {
                    if let Some(row) = self.rows.get_mut((v as usize).wrapping_sub(self.first)) {
                        row[0] += weight * (all - bend);
                        row[1] += weight;
                    }
                }
            }
        }
        for [b, sum] in &mut self.rows {
            // Twelfths of areas, where tenths of these are to be added and the sum is of thirds.
            let (right, row) = (*b / (40.0 * *sum), 1.0 / (4.0 * *sum));
            let is_known = right.is_finite() && row.is_finite();
            [*b, *sum] = if is_known { [right, row] } else { [0.0; 2] };
        }
        job.progress.advance(self.weights.len() as u64);
        Ok(())
    }

    /// Gathers what `offsets` add.
    fn spread(&mut self, triangles: &[[u32; 3]], offsets: &[f32]) {
        let mut weights = &self.weights[..];
        for run in &self.runs {
            let (own, rest) = weights.split_at(run.len());
            weights = rest;
            for (triangle, weight) in triangles[run.clone()].iter().zip(own) {
                let [a, b, c] = triangle.map(|v| v as usize);
                let sum = weight * (offsets[a] + offsets[b] + offsets[c]);
                for v in [a, b, c] {
                    if let Some(spread) = self.spread.get_mut(v.wrapping_sub(self.first)) {
                        *spread += sum;
                    }
                }
            }
        }
    }

    /// One step. M d is a quarter of L d, and what was gathered.
    fn step(&mut self, offsets: &mut [f32], length: f32, is_last: bool) {
        for ((offset, [right, row]), spread) in
            offsets.iter_mut().zip(&self.rows).zip(&mut self.spread)
        {
            *offset += length * (right - 0.25 * *offset - row * *spread);
            *spread = 0.0;
            if is_last && *row == 0.0 {
                *offset = f32::NAN;
            }
        }
    }

    /// The triangles that may be spoiled.
    ///
    /// If no corner goes farther than A / 4l, where A is the area and l the longest side, both sides at a
    /// corner change by less than A / 2l, and the normal, 2A long, by less than 2 l A / 2l + (A / 2l)² < 1.2 A.
    fn doubted(&self, triangles: &[[u32; 3]], (ways, in_file): (&[f32], f32)) -> Vec<[u32; 3]> {
        /// More than areas are off by rounding, over the square of the longest side.
        const ROUNDING: f32 = 1e-5;
        let (length, margin) = (4.001 * self.longest.sqrt(), ROUNDING * self.longest);
        let mut doubted = vec![];
        let runs = self.runs.iter().cloned().flatten();
        for (t, weight) in runs.zip(&self.weights) {
            let triangle = triangles[t];
            let [a, b, c] = triangle.map(|v| ways[v as usize]);
            let way = a.max(b).max(c);
            let is_safe = way == 0.0 || length * (way + in_file) + margin <= 12.0 * weight;
            if !is_safe {
                doubted.push(triangle);
            }
        }
        doubted
    }
}

impl<C: Coordinate> Vertices<'_, C> {
    /// A twelfth of the area of a triangle, and how much the surface bends along the sides opposite to its
    /// corners; all 0 where a corner has no normal. `longest` becomes the square of a longer side.
    #[inline]
    fn bent(&self, triangle: [u32; 3], longest: &mut f32) -> (f32, [f32; 3]) {
        let [a, b, c] = triangle;
        let sides = [self.between(b, c), self.between(c, a), self.between(a, b)];
        for side in sides {
            *longest = longest.max(dot(side, side)); // which takes no notice of what is no number
        }
        let ([p, q, r], [u, v, w]) = (sides[0], sides[1]);
        let normal = [q * w - r * v, r * u - p * w, p * v - q * u];
        let weight = dot(normal, normal).sqrt() / 24.0;
        if !(weight > 0.0 && weight < LARGEST && self.have_normals(triangle)) {
            return (0.0, [0.0; 3]);
        }
        let normal = |v: u32| self.normals[v as usize];
        let (l, m, n) = (normal(a), normal(b), normal(c));
        let bends = [dot(sub(n, m), sides[0]), dot(sub(l, n), sides[1]), dot(sub(m, l), sides[2])];
        (weight, bends)
    }
}

fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
