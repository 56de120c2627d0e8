//! Moves vertices along their normals so that triangles lie as much outside of a surface as inside.
//!
//! How far is said in `balance/system.rs`, and here along what: the normals of the mesh, or, if it has none,
//! those of the field. A vertex on the border of the volume stays on it. One of a cap stays where it is, and
//! so does one where the field has no value: there is no surface, whatever its normal says.
//!
//! Most triangles are large beside the ways of their corners, and nothing can turn those over. The others
//! are looked at, and corners go back until none is spoiled. So do vertices that meet in one place.
//!
//! Tried and slower: the gradient of the field in place of normals that are there, and sums by lists of the
//! neighbours of each vertex.

mod system;

use crate::{
    RefineError,
    exact::in_chunks,
    ground::{FLATTEST, Ground},
    settle::{Rules, settle},
};
use isokit_geom::vector::{Vector, length, normal, sub};
use isokit_job::{CHUNK, Cancelled, Job};
use isokit_lanes::exactly;
use isokit_mesh::{Positions, TriMesh};
use rayon::prelude::*;
use system::System;

/// Balances a mesh whose vertices are on the surface. How many vertices moved, and how many did not though
/// they are no cap's.
pub(crate) fn balance(
    mesh: &mut TriMesh,
    ground: &Ground<'_>,
    job: &Job,
) -> Result<(u64, u64), RefineError> {
    const WHAT: &str = "the balance of the surface";
    let counts = mesh.counts();
    let place = match mesh.positions {
        Positions::F32(_) => size_of::<[f32; 3]>(),
        Positions::F64(_) => size_of::<[f64; 3]>(),
    };
    let normal = if mesh.normals.is_some() { 0 } else { 2 * size_of::<[f32; 3]>() };
    let per_vertex = place + normal + size_of::<(Kind, u8)>() + 4 * size_of::<f32>();
    // Threads that own corners of the same triangle each weigh it.
    let per_triangle = size_of::<f32>() * job.threads.count().min(3);
    let needed = counts.vertices.checked_mul(per_vertex as u64);
    let weights = counts.triangles.checked_mul(per_triangle as u64);
    let needed = needed.zip(weights).and_then(|(all, weights)| all.checked_add(weights));
    job.limits.probe(WHAT, needed, 1)?;
    job.progress.begin("balance", 3 * counts.vertices + counts.triangles);
    let TriMesh { positions, normals, triangles, .. } = mesh;
    let normals = match normals {
        Some(normals) => &normals[..],
        None => &normals_of_field(positions, ground, job)?,
    };
    match positions {
        Positions::F32(places) => balanced(places, (normals, triangles), ground, job),
        Positions::F64(places) => balanced(places, (normals, triangles), ground, job),
    }
}

/// Outward unit normals; 0 where the field has none.
fn normals_of_field(
    positions: &Positions,
    ground: &Ground<'_>,
    job: &Job,
) -> Result<Vec<[f32; 3]>, Cancelled> {
    let chunks = in_chunks(positions.len(), &job.unwatched(), |range| {
        let normal = |v: usize| {
            let spot = ground.spot(positions.get(v));
            let field = || ground.ascent(ground.field().slope(spot.ijk).gradient, [false; 3]);
            let ascent = if spot.is_beyond { None } else { field() };
            ascent.map_or([0.0; 3], |ascent| ascent.direction.map(|c| -c as f32))
        };
        range.map(normal).collect::<Vec<_>>()
    })?;
    Ok(chunks.concat())
}

fn balanced<C: Coordinate>(
    places: &mut [[C; 3]],
    (normals, triangles): (&[[f32; 3]], &[[u32; 3]]),
    ground: &Ground<'_>,
    job: &Job,
) -> Result<(u64, u64), RefineError> {
    let vertices = Vertices::new((places, normals), ground, job)?;
    let mut system = System::new(&vertices, triangles, job)?;
    let offsets = system.solved(triangles, job)?;
    let Moved { places: moved, mut states, ways } = vertices.moved(offsets, ground, job)?;
    let doubted = system.doubted(triangles, (&ways, ground.way_in_file()), job)?;
    let place = |v: usize, states: &[u8]| -> Vector {
        let place = if states[v] == 0 { places[v] } else { moved[v] };
        place.map(C::into)
    };
    let rules = Rules {
        parts: &doubted,
        is_bad: |n: usize, states: &[u8]| {
            let before = doubted[n].map(|v| places[v as usize].map(C::into));
            ground.is_spoiled(doubted[n].map(|v| place(v as usize, states)), normal(before))
        },
        count: places.len(),
        place: |v: usize, states: &[u8]| Some(ground.in_file(place(v, states))),
    };
    settle(&mut states, &rules, job)?;
    let kinds = vertices.kinds;
    let (mut balanced, mut kept) = (0, 0);
    for (v, place) in places.iter_mut().enumerate() {
        match states[v] {
            0 => kept += u64::from(kinds[v] != Kind::Cap),
            _ => (*place, balanced) = (moved[v], balanced + 1),
        }
    }
    Ok((balanced, kept))
}

/// A coordinate as a mesh keeps it.
trait Coordinate: Copy + Default + Into<f64> + Send + Sync {
    /// The nearest that can be kept.
    fn rounded(value: f64) -> Self;

    /// How far it is from `other` in units of `1 / scale`, a power of two.
    fn minus(self, other: Self, scale: f64) -> f32;
}

impl Coordinate for f32 {
    fn rounded(value: f64) -> Self {
        value as Self
    }

    #[inline]
    fn minus(self, other: Self, scale: f64) -> f32 {
        (self - other) * scale as Self
    }
}

impl Coordinate for f64 {
    fn rounded(value: f64) -> Self {
        value
    }

    #[inline]
    fn minus(self, other: Self, scale: f64) -> f32 {
        ((self - other) * scale) as f32
    }
}

/// What a vertex is to balance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Kind {
    /// It stays, for nobody knows its normal.
    #[default]
    Unknown,
    /// It stays, for it is beyond the border.
    Cap,
    /// It is on a border, and stays on it.
    Rim,
    /// It is nearer than a sample to a border.
    Outer,
    /// It is anywhere else.
    Inner,
}

impl Kind {
    fn of(place: Vector, normal: [f32; 3], ground: &Ground<'_>) -> Self {
        let spot = ground.spot(place);
        let square: f32 = normal.iter().map(|c| c * c).sum();
        // No number is in no range.
        let has_normal = || (0.5..2.0).contains(&square) && ground.field().is_known(spot.ijk);
        match () {
            () if spot.is_beyond => Self::Cap,
            () if !has_normal() => Self::Unknown,
            () if spot.held() != [false; 3] => Self::Rim,
            () if ground.is_inner(&spot) => Self::Inner,
            () => Self::Outer,
        }
    }
}

/// The vertices of a mesh.
struct Vertices<'a, C> {
    places: &'a [[C; 3]],
    /// Outward unit vectors.
    normals: &'a [[f32; 3]],
    kinds: Vec<Kind>,
    /// A power of two, about as long as a cell.
    unit: f64,
}

/// Where vertices may go.
struct Moved<C> {
    places: Vec<[C; 3]>,
    /// Of each vertex 1 if it moves, else 0.
    states: Vec<u8>,
    /// How far each moves, in units of the system; 0 only if it stays.
    ways: Vec<f32>,
}

impl<'a, C: Coordinate> Vertices<'a, C> {
    fn new(
        (places, normals): (&'a [[C; 3]], &'a [[f32; 3]]),
        ground: &Ground<'_>,
        job: &Job,
    ) -> Result<Self, Cancelled> {
        let mut kinds = vec![Kind::default(); places.len()];
        let chunks = kinds.par_chunks_mut(CHUNK).enumerate();
        let fill = |(n, kinds): (usize, &mut [Kind])| {
            job.check()?;
            exactly(|| {
                for (v, kind) in (n * CHUNK..).zip(&mut *kinds) {
                    *kind = Kind::of(places[v].map(C::into), normals[v], ground);
                }
            });
            job.progress.advance(kinds.len() as u64);
            Ok(())
        };
        job.threads.run(|| chunks.try_for_each(fill))?;
        Ok(Self { places, normals, kinds, unit: ground.unit() })
    }

    /// Whether all three have a normal.
    #[inline]
    fn have_normals(&self, triangle: [u32; 3]) -> bool {
        triangle.iter().all(|&v| self.kinds[v as usize] as u8 > Kind::Cap as u8)
    }

    /// How far `to` is from `from`, in units of the system.
    #[inline]
    fn between(&self, from: u32, to: u32) -> [f32; 3] {
        let (from, to) = (self.places[from as usize], self.places[to as usize]);
        let along = |k: usize| to[k].minus(from[k], 1.0 / self.unit);
        [along(0), along(1), along(2)]
    }

    /// Moves them by offsets along their normals, in units of the system, which become the ways.
    fn moved(
        &self,
        mut ways: Vec<f32>,
        ground: &Ground<'_>,
        job: &Job,
    ) -> Result<Moved<C>, Cancelled> {
        let (mut places, mut states) = (self.places.to_vec(), vec![0; self.places.len()]);
        let chunks = places.par_chunks_mut(CHUNK).zip(states.par_chunks_mut(CHUNK));
        let chunks = chunks.zip(ways.par_chunks_mut(CHUNK)).enumerate();
        job.threads.run(|| {
            chunks.try_for_each(|(n, ((places, states), ways))| {
                job.check()?;
                let each = places.iter_mut().zip(states).zip(&mut *ways);
                exactly(|| {
                    for (v, ((place, state), way)) in (n * CHUNK..).zip(each) {
                        let from: Vector = place.map(C::into);
                        let to = self.target((v, from), f64::from(*way) * self.unit, ground);
                        (*way, *state) = (0.0, u8::from(to.is_some()));
                        if let Some(to) = to {
                            *place = to.map(C::rounded);
                            let moved = length(sub(place.map(C::into), from)) / self.unit;
                            *way = (moved as f32).max(f32::MIN_POSITIVE);
                        }
                    }
                });
                job.progress.advance(ways.len() as u64);
                Ok::<(), Cancelled>(())
            })
        })?;
        Ok(Moved { places, states, ways })
    }

    /// Where a vertex goes; none where it has no normal, or along the border none that helps.
    #[inline]
    fn target(
        &self,
        (v, from): (usize, Vector),
        offset: f64,
        ground: &Ground<'_>,
    ) -> Option<Vector> {
        let (kind, normal) = (self.kinds[v], self.normals[v].map(f64::from));
        let go = |along: Vector, way: f64| -> Vector {
            std::array::from_fn(|k| from[k] + along[k] * way)
        };
        match kind {
            Kind::Unknown | Kind::Cap => None,
            _ if offset.is_nan() => None,
            Kind::Inner if ground.is_short(offset) => Some(go(normal, offset)),
            Kind::Inner | Kind::Outer => {
                Some(go(normal, offset)).filter(|&to| ground.is_within(to, [false; 3]))
            }
            Kind::Rim => {
                let held = ground.spot(from).held();
                let along = ground.within_borders(normal, held);
                // Its length is the cosine, and along it the surface is that much farther away.
                let cosine = length(along);
                let to = go(along, offset / (cosine * cosine));
                (cosine >= FLATTEST && ground.is_within(to, held)).then_some(to)
            }
        }
    }
}

#[cfg(test)]
mod tests;
