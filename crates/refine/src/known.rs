//! What the field says of the vertices and the edges of a mesh.
//!
//! Most edges of a mesh that is divided again and again are divided once or never. What is known of a vertex
//! holds as long as it stays where it is, and what is known of an edge as long as nothing cuts it, so both are
//! asked for once and carried on from round to round.

use crate::{
    RefineError,
    edges::{Edges, NEW},
    exact::in_chunks,
    ground::Ground,
    split::middle,
};
use isokit_field::Jet;
use isokit_geom::vector::{Vector, sub};
use isokit_job::{Cancelled, Job};
use isokit_mesh::TriMesh;

/// A vertex as the field sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Look {
    /// How fast the value rises, per world unit; NaN where it rises nowhere, or nobody knows.
    steepness: f64,
    jet: Jet,
}

/// Of vertices of caps, at which nobody looks.
const NO_JET: Jet = Jet { value: f64::NAN, gradient: [f64::NAN; 3], hessian: [[f64::NAN; 3]; 3] };

/// What is known of a mesh.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Known {
    looks: Vec<Look>,
    /// How far each vertex is from the surface in world units, to first order; one of a cap is where it
    /// should be.
    pub(crate) offs: Vec<f64>,
    /// Of each edge the greatest second derivative along it over the least gradient, in world units: eight
    /// times what it may leave its surface by. Not finite where that is not known.
    pub(crate) bends: Vec<f64>,
}

impl Known {
    /// The same for another mesh, whose first vertices are those known before, and whose edge `n` is the
    /// edge `from[n]` of before, or [`NEW`]. With [`Known::default`] everything is asked for.
    pub(crate) fn carried(
        mut self,
        (mesh, edges): (&TriMesh, &Edges),
        from: &[u32],
        ground: &Ground<'_>,
        job: &Job,
    ) -> Result<Self, RefineError> {
        const WHAT: &str = "the errors of the surface";
        let (vertices, held) = (mesh.positions.len(), self.looks.len());
        let bytes = (vertices as u64).checked_mul(size_of::<(Look, f64)>() as u64);
        let bytes = bytes.and_then(|b| b.checked_add((2 * size_of::<f64>() * edges.len()) as u64));
        job.limits.probe(WHAT, bytes, 1)?;
        let new = from.iter().filter(|&&old| old == NEW).count();
        job.progress.begin("measure", (vertices - held + new) as u64);
        let looks = in_chunks(vertices - held, job, |range| {
            let look = |n: usize| look(mesh.positions.get(held + n), ground);
            range.map(look).unzip::<_, _, Vec<_>, Vec<_>>()
        })?;
        self.looks.reserve_exact(vertices - held);
        self.offs.reserve_exact(vertices - held);
        for (looks, offs) in looks {
            self.looks.extend(looks);
            self.offs.extend(offs);
        }
        self.bends = self.bends_of((mesh, edges), from, ground, job)?;
        Ok(self)
    }

    fn bends_of(
        &self,
        (mesh, edges): (&TriMesh, &Edges),
        from: &[u32],
        ground: &Ground<'_>,
        job: &Job,
    ) -> Result<Vec<f64>, Cancelled> {
        let chunks = in_chunks(from.len(), &job.unwatched(), |range| {
            let mut new = 0;
            let bends = range.map(|edge| match from[edge] {
                NEW => {
                    new += 1;
                    self.bend(mesh, edges.ends[edge], ground)
                }
                old => self.bends[old as usize],
            });
            let bends: Vec<_> = bends.collect();
            job.progress.advance(new);
            bends
        })?;
        Ok(chunks.concat())
    }

    /// The bend of a new edge. H and ∇F are looked at in both ends and in the middle.
    fn bend(&self, mesh: &TriMesh, ends: [u32; 2], ground: &Ground<'_>) -> f64 {
        let [a, b] = ends.map(|vertex| mesh.positions.get(vertex as usize));
        let [from, to] = [a, b].map(|place| ground.spot(place));
        if from.is_beyond || to.is_beyond {
            return 0.0;
        }
        let (held, along) = (from.held_with(&to), ground.displacement_ijk(sub(b, a)));
        let at_end = |vertex: u32| {
            let look = &self.looks[vertex as usize];
            // A rim counts in the plane of the border.
            let is_free = held == [false; 3];
            (look.jet, if is_free { look.steepness } else { steepness(&look.jet, held, ground) })
        };
        let jet = ground.field().jet(ground.spot(middle(mesh, ends)).ijk);
        let middle = (jet, steepness(&jet, held, ground));
        let (mut greatest, mut least) = (0.0_f64, f64::INFINITY);
        for (jet, steepness) in [at_end(ends[0]), at_end(ends[1]), middle] {
            let bend = jet.bend(along).abs();
            if steepness.is_nan() || !bend.is_finite() {
                return f64::INFINITY;
            }
            least = least.min(steepness);
            greatest = greatest.max(bend);
        }
        greatest / least
    }
}

/// What the field says of a vertex, and how far it is off.
fn look(place: Vector, ground: &Ground<'_>) -> (Look, f64) {
    let spot = ground.spot(place);
    if spot.is_beyond {
        return (Look { steepness: f64::NAN, jet: NO_JET }, 0.0);
    }
    let jet = ground.field().jet(spot.ijk);
    let free = steepness(&jet, [false; 3], ground);
    let held = spot.held();
    let own = if held == [false; 3] { free } else { steepness(&jet, held, ground) };
    let off = (jet.value - ground.iso()).abs() / own;
    (Look { steepness: free, jet }, if off.is_finite() { off } else { f64::INFINITY })
}

/// How fast the value rises along the borders that are held; NaN where it rises nowhere.
fn steepness(jet: &Jet, held: [bool; 3], ground: &Ground<'_>) -> f64 {
    ground.ascent(jet.gradient, held).map_or(f64::NAN, |ascent| ascent.steepness)
}
