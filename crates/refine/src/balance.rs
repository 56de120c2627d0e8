//! Moves vertices along their normals so that triangles lie as much outside of a surface as inside.
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
//! Summed over all i the equations say that what remains has the mean 0: the volume inside is right to the
//! same order. M is as tame as a matrix can be: with L the sums of its rows, all eigenvalues of L⁻¹M are
//! between ¼ and 1, in any mesh (after Wathen 1987). So a few steps of Chebyshev's iteration do, each of which
//! looks at the neighbours of a vertex only; and a last plain step keeps the sum, whatever is left.

use crate::{
    RefineError,
    ground::Ground,
    settle::settle,
    split::{is_spoiled, rounded},
};
use isokit_geom::vector::{Vector, dot, length, normal, sub};
use isokit_job::{CHUNK, Cancelled, Job, in_chunks};
use isokit_mesh::{Positions, Stars, TriMesh, others};
use rayon::prelude::*;

/// Steps of Chebyshev's iteration, each of which divides what is left by three.
const STEPS: u32 = 6;

/// A rim that its surface leaves flatter than this, as a cosine, stays: along the border the surface is too
/// far away.
const FLATTEST: f64 = 0.25;

/// Balances a mesh whose vertices are on the surface. How many vertices moved, and how many did not though
/// they are no cap's.
pub(crate) fn balance(
    mesh: &mut TriMesh,
    ground: &Ground<'_>,
    job: &Job,
) -> Result<(u64, u64), RefineError> {
    const WHAT: &str = "the balance of the surface";
    let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
    let needed = (vertices as u64)
        .checked_mul(2 * size_of::<Vector>() as u64 + 4 * size_of::<f64>() as u64)
        .and_then(|bytes| bytes.checked_add(triangles as u64 * size_of::<f64>() as u64));
    job.limits.probe(WHAT, needed, 1)?;
    job.progress.begin("balance", (3 * vertices + triangles) as u64);
    let stars = Stars::new(vertices, &mesh.triangles, job)?;
    let system = System::new(mesh, &stars, ground, job)?;
    let offsets = system.solved(job)?;
    let chunks = in_chunks(vertices, job, |range| {
        range.map(|v| system.moved(v, offsets[v], ground)).collect::<Vec<_>>()
    })?;
    let moved = chunks.concat();
    let mut states: Vec<u8> = moved.iter().map(|place| u8::from(place.is_some())).collect();
    let place = |v: u32, states: &[u8]| match (states[v as usize], moved[v as usize]) {
        (1, Some(place)) => place,
        _ => mesh.positions.get(v as usize),
    };
    let spoils = |t: usize, states: &[u8]| {
        let before = normal(mesh.corners(mesh.triangles[t]));
        is_spoiled(mesh.triangles[t].map(|v| place(v, states)), before)
    };
    settle(&mut states, &mesh.triangles, spoils, job)?;
    let is_cap = |v: usize| ground.spot(mesh.positions.get(v)).is_beyond;
    let kept = (0..vertices).filter(|&v| states[v] == 0 && !is_cap(v)).count();
    let balanced = states.iter().filter(|&&state| state == 1).count();
    drop(system);
    drop(stars);
    let to = |v: usize| moved[v].filter(|_| states[v] == 1);
    match &mut mesh.positions {
        Positions::F32(all) => (0..vertices).for_each(|v| {
            all[v] = to(v).map_or(all[v], |place| place.map(|c| c as f32));
        }),
        Positions::F64(all) => (0..vertices).for_each(|v| all[v] = to(v).unwrap_or(all[v])),
    }
    Ok((balanced as u64, kept as u64))
}

/// The equations of all offsets.
struct System<'a> {
    mesh: &'a TriMesh,
    stars: &'a Stars,
    /// Outward unit normals; 0 where there is none.
    normals: Vec<Vector>,
    /// Of triangles whose corners all have a normal; of others 0.
    areas: Vec<f64>,
    /// The right-hand side.
    b: Vec<f64>,
    /// The sums of the rows.
    sums: Vec<f64>,
}

impl<'a> System<'a> {
    fn new(
        mesh: &'a TriMesh,
        stars: &'a Stars,
        ground: &Ground<'_>,
        job: &Job,
    ) -> Result<Self, Cancelled> {
        let vertices = mesh.positions.len();
        let normals = in_chunks(vertices, job, |range| {
            let normal = |v: usize| {
                let spot = ground.spot(mesh.positions.get(v));
                let field = || ground.ascent(ground.field().slope(spot.ijk).gradient, [false; 3]);
                let ascent = if spot.is_beyond { None } else { field() };
                ascent.map_or([0.0; 3], |ascent| ascent.direction.map(|c| -c))
            };
            range.map(normal).collect::<Vec<_>>()
        })?;
        let normals = normals.concat();
        let areas = in_chunks(mesh.triangles.len(), job, |range| {
            let area = |t: usize| {
                let corners = mesh.triangles[t];
                let are_known = corners.iter().all(|&v| normals[v as usize] != [0.0; 3]);
                if are_known { 0.5 * length(normal(mesh.corners(corners))) } else { 0.0 }
            };
            range.map(area).collect::<Vec<_>>()
        })?;
        let mut system =
            Self { mesh, stars, normals, areas: areas.concat(), b: vec![], sums: vec![] };
        let unwatched = job.unwatched();
        let each = in_chunks(vertices, &unwatched, |range| {
            range.map(|v| system.row(v as u32)).unzip::<_, _, Vec<_>, Vec<_>>()
        })?;
        let (b, sums): (Vec<_>, Vec<_>) = each.into_iter().unzip();
        (system.b, system.sums) = (b.concat(), sums.concat());
        Ok(system)
    }

    /// The right-hand side of a vertex, and the sum of its row.
    fn row(&self, v: u32) -> (f64, f64) {
        let (mut b, mut sum) = (0.0, 0.0);
        for &t in self.stars.of(v as usize) {
            let [j, k] = others(self.mesh.triangles[t as usize], v);
            let area = self.areas[t as usize];
            if area > 0.0 {
                let bends = 2.0 * (self.bend(v, j) + self.bend(v, k)) + self.bend(j, k);
                b += area * bends / 120.0;
                sum += area / 3.0;
            }
        }
        (b, sum)
    }

    /// The second fundamental form along a side.
    fn bend(&self, i: u32, j: u32) -> f64 {
        let turn = sub(self.normals[j as usize], self.normals[i as usize]);
        let [from, to] = [i, j].map(|v| self.mesh.positions.get(v as usize));
        dot(turn, sub(to, from))
    }

    /// What is wrong with the equation of a vertex, over the sum of its row; 0 where it has none.
    fn rest(&self, d: &[f64], v: usize) -> f64 {
        if !(self.sums[v] > 0.0 && self.b[v].is_finite()) {
            return 0.0;
        }
        let mut rest = self.b[v];
        for &t in self.stars.of(v) {
            let [j, k] = others(self.mesh.triangles[t as usize], v as u32);
            let sum = 2.0 * d[v] + (d[j as usize] + d[k as usize]);
            rest -= self.areas[t as usize] * sum / 12.0;
        }
        rest / self.sums[v]
    }

    /// The offsets, in world units (Saad 2003, "Iterative methods for sparse linear systems", algorithm 12.1).
    fn solved(&self, job: &Job) -> Result<Vec<f64>, Cancelled> {
        /// The middle of the eigenvalues, and how far they are from it.
        const MIDDLE: f64 = 0.625;
        const HALF: f64 = 0.375;
        let vertices = self.b.len();
        let (mut d, mut step) = (vec![0.0; vertices], vec![0.0; vertices]);
        let go = |d: &mut [f64], step: &mut [f64], [old, new]: [f64; 2]| {
            job.check()?;
            job.threads.run(|| {
                let known = &*d;
                step.par_chunks_mut(CHUNK).enumerate().for_each(|(n, steps)| {
                    for (v, step) in (n * CHUNK..).zip(steps) {
                        *step = old * *step + new * self.rest(known, v);
                    }
                });
                let both = d.par_chunks_mut(CHUNK).zip(step.par_chunks(CHUNK));
                both.for_each(|(d, step)| d.iter_mut().zip(step).for_each(|(d, s)| *d += s));
            });
            Ok::<(), Cancelled>(())
        };
        go(&mut d, &mut step, [0.0, 1.0])?;
        go(&mut d, &mut step, [0.0, 1.0 / MIDDLE])?;
        let mut ratio = HALF / MIDDLE;
        for _ in 1..STEPS {
            let next = 1.0 / (2.0 * MIDDLE / HALF - ratio);
            go(&mut d, &mut step, [next * ratio, 2.0 * next / HALF])?;
            ratio = next;
        }
        go(&mut d, &mut step, [0.0, 1.0])?;
        Ok(d)
    }

    /// Where a vertex goes; none where it has no normal, or along the border none that helps.
    fn moved(&self, v: usize, offset: f64, ground: &Ground<'_>) -> Option<Vector> {
        let (from, normal) = (self.mesh.positions.get(v), self.normals[v]);
        if !(self.sums[v] > 0.0 && offset.is_finite()) {
            return None;
        }
        let spot = ground.spot(from);
        let mut along = normal;
        let mut share = 1.0;
        if spot.held() != [false; 3] {
            let gradient = ground.field().slope(spot.ijk).gradient;
            along = ground.ascent(gradient, spot.held())?.direction.map(|c| -c);
            share = dot(along, normal);
        }
        if share < FLATTEST {
            return None;
        }
        let to: Vector = std::array::from_fn(|k| from[k] + along[k] * (offset / share));
        let is_finite = to.iter().all(|c| c.is_finite());
        (is_finite && ground.is_within(to, spot.held())).then(|| rounded(to, self.mesh))
    }
}
