//! By how much triangles may leave their surface, from the second derivatives of the field.
//!
//! With F the field less the isovalue, and h the greatest |eᵀ H e| of the three sides e of a triangle, F on the
//! triangle differs from what is linear between its corners by at most
//!
//! ```text
//! ½ (λ₀λ₁ + λ₁λ₂ + λ₂λ₀) h  ≤  h / 6
//! ```
//!
//! and the distance to the surface is that over |∇F|, to first order. To it comes what the corners themselves
//! are off. H and ∇F are looked at in both ends of a side and in its middle.
//!
//! An edge is divided for what it is itself, so both triangles at it agree. An edge on a rim counts in the
//! plane of the border; caps are flat and count nothing.

use crate::{RefineError, edges::Edges, ground::Ground, split::middle};
use isokit_geom::vector::{Vector, sub};
use isokit_job::{Job, in_chunks};
use isokit_mesh::TriMesh;

/// What is known of edges and vertices of a mesh. Infinite where nothing is.
pub(crate) struct Sagitta {
    /// What each edge adds to a triangle's bound at most, in world units.
    edges: Vec<f64>,
    /// How far each vertex is from the surface.
    vertices: Vec<f64>,
    /// Whether an edge is to be divided.
    too_long: Vec<bool>,
    error: f64,
}

impl Sagitta {
    /// Edges are divided so often at most: each into 1024.
    pub(crate) const ROUNDS: u32 = 10;

    /// The part of the error that is left to vertices.
    const VERTICES: f64 = 0.25;

    pub(crate) fn of(
        (mesh, edges): (&TriMesh, &Edges),
        ground: &Ground<'_>,
        error: f64,
        job: &Job,
    ) -> Result<Self, RefineError> {
        const WHAT: &str = "the errors of the surface";
        let (count, vertices) = (edges.len(), mesh.positions.len());
        job.limits.probe(WHAT, Some((2 * count + vertices) as u64), 2 * size_of::<f64>())?;
        job.progress.begin("measure", (count + vertices) as u64);
        let of_vertices = in_chunks(vertices, job, |range| {
            range.map(|v| distance(mesh.positions.get(v), ground)).collect::<Vec<_>>()
        })?;
        let of_edges = in_chunks(count, job, |range| {
            range.map(|edge| sagitta(mesh, edges.ends[edge], ground)).collect::<Vec<_>>()
        })?;
        let (of_edges, vertices) = (of_edges.concat(), of_vertices.concat());
        let too_long = (0..count).map(|edge| {
            let is_on = |v: u32| vertices[v as usize] <= Self::VERTICES * error;
            let own = of_edges[edge];
            own.is_finite()
                && own > (1.0 - Self::VERTICES) * error
                && edges.ends[edge].into_iter().all(is_on)
        });
        Ok(Self { too_long: too_long.collect(), edges: of_edges, vertices, error })
    }

    /// Whether an edge is to be divided: it is longer than its surface allows, and dividing helps.
    pub(crate) fn is_too_long(&self, edge: usize) -> bool {
        self.too_long[edge]
    }

    /// The greatest bound within the error, and how many triangles have none.
    pub(crate) fn bound(
        &self,
        mesh: &TriMesh,
        edges: &Edges,
        job: &Job,
    ) -> Result<(Option<f64>, u64), RefineError> {
        let found = in_chunks(mesh.triangles.len(), &job.unwatched(), |range| {
            let (mut greatest, mut without) = (0.0_f64, 0);
            for t in range {
                let side =
                    edges.sides[t].iter().fold(0.0, |m: f64, &e| m.max(self.edges[e as usize]));
                let corners = mesh.triangles[t].iter().map(|&v| self.vertices[v as usize]);
                let own = side + corners.fold(0.0, f64::max);
                match own <= self.error {
                    true => greatest = greatest.max(own),
                    false => without += 1,
                }
            }
            (greatest, without)
        })?;
        let greatest = found.iter().fold(0.0, |most: f64, chunk| most.max(chunk.0));
        Ok((Some(greatest), found.iter().map(|chunk| chunk.1).sum()))
    }
}

/// How far a vertex is from the surface, to first order; one of a cap is where it should be.
fn distance(place: Vector, ground: &Ground<'_>) -> f64 {
    let spot = ground.spot(place);
    if spot.is_beyond {
        return 0.0;
    }
    let slope = ground.field().slope(spot.ijk);
    let ascent = ground.ascent(slope.gradient, spot.held());
    let found = ascent.map(|ascent| (slope.value - ground.iso()).abs() / ascent.steepness);
    found.filter(|found| found.is_finite()).unwrap_or(f64::INFINITY)
}

/// A sixth of the greatest second derivative along an edge over the least gradient.
fn sagitta(mesh: &TriMesh, ends: [u32; 2], ground: &Ground<'_>) -> f64 {
    let [a, b] = ends.map(|vertex| mesh.positions.get(vertex as usize));
    let [from, to] = [a, b].map(|place| ground.spot(place));
    if from.is_beyond || to.is_beyond {
        return 0.0;
    }
    let (held, along) = (from.held_with(&to), ground.displacement_ijk(sub(b, a)));
    let (mut bend, mut steepness) = (0.0_f64, f64::INFINITY);
    for ijk in [from.ijk, to.ijk, ground.spot(middle(mesh, ends)).ijk] {
        let jet = ground.field().jet(ijk);
        let Some(ascent) = ground.ascent(jet.gradient, held) else { return f64::INFINITY };
        steepness = steepness.min(ascent.steepness);
        bend = bend.max(jet.bend(along).abs());
        if !jet.bend(along).is_finite() {
            return f64::INFINITY;
        }
    }
    bend / steepness / 6.0
}
