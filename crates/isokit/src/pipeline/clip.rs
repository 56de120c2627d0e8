//! Surfaces that planes cut, closed where they do.
//!
//! What is inside of the surface and on the kept side of all planes is a solid again: its samples are those whose values are
//! at the isovalue or above, and that no plane cuts away. Its surface is extracted like any other, so it is closed and
//! manifold however planes and samples lie. Each vertex then goes, on its edge of the lattice, to where the edge leaves the
//! solid: where linear interpolation has the isovalue, or through a plane, whichever comes first. So the cut is flat, and
//! only its rim is cut off within a cell.

mod samples;

use crate::pipeline::{Normals, PipelineError, Scan, SurfaceOptions, error::of_slabs};
use isokit_field::{Sampled, ScalarField};
use isokit_geom::{
    HalfSpace,
    vector::{Vector, length},
};
use isokit_job::{CHUNK, Cancelled, Job};
use isokit_lanes::exactly;
use isokit_marching_cubes::{Diagonals, Extracted, Placement};
use isokit_mesh::{Positions, TriMesh, area_normals};
use isokit_volume::{Sample, View, for_any};
use rayon::prelude::*;
use samples::{Clipped, Cut, cuts, steep};

/// As near as vertices come to samples, in parts of an edge.
const NEAR: f64 = 1e-3;

impl Scan {
    /// The surface where the value is `iso`, of what all planes keep, closed where they cut.
    ///
    /// Where there are planes vertices are placed linearly and diagonals are the table's, whatever the
    /// options say. What planes leave of the samples is held a few slices at a time; with an [index](Self::index) only near
    /// the surface, if that goes through an eighth of the bricks at the most. Without a plane it is the surface as it is.
    ///
    /// # Errors
    ///
    /// As [`mesh`](Self::mesh).
    pub fn clipped_mesh(
        &self,
        iso: f64,
        planes: &[HalfSpace],
        options: &SurfaceOptions,
        job: &Job,
    ) -> Result<(TriMesh, Extracted), PipelineError> {
        let mut meshes = [TriMesh::default()];
        let extracted = match planes {
            [] => self.meshes_into(&[iso], options, &mut meshes, job)?,
            _ => self.clip_into(iso, planes, options, (&mut meshes[0], job))?,
        };
        let [mesh] = meshes;
        Ok((mesh, extracted.into_iter().next().expect("one isovalue has one surface")))
    }

    /// The same where there are planes, into a mesh.
    fn clip_into(
        &self,
        iso: f64,
        planes: &[HalfSpace],
        options: &SurfaceOptions,
        (mesh, job): (&mut TriMesh, &Job),
    ) -> Result<Vec<Extracted>, PipelineError> {
        let range = self.statistics(job)?.range.unwrap_or([iso, iso]);
        let linear = options.extract.clone().with_placement(Placement::Linear);
        let linear = linear.with_diagonals(Diagonals::Table); // vertices are still to be moved
        let options = options.clone().with_extract(linear);
        let extracted = for_any!(self.volume(), volume => {
            let view = self.view(volume);
            let cuts = cuts(&view.frame().index_to_world, planes);
            let known = self.known(volume, &self.part(), &[iso]);
            let clipped = Clipped { view, iso, steep: steep(&view, range), cuts: &cuts, known };
            let extracted = clipped.mesh_into(&options, mesh, job);
            let extracted = extracted.map_err(|error| of_slabs(error, &self.part()))?;
            settle(mesh, &view, (iso, &cuts), job)?;
            extracted
        });
        if options.normals == Normals::Area {
            area_normals(mesh, job)?;
        }
        Ok(extracted)
    }
}

/// Moves vertices along their edges to where these leave the solid; on a cut they get the plane's normal, elsewhere that
/// of the field.
fn settle<T: Sample>(
    mesh: &mut TriMesh,
    view: &View<'_, T>,
    (iso, cuts): (f64, &[Cut]),
    job: &Job,
) -> Result<(), Cancelled> {
    let affine = view.frame().index_to_world;
    let columns = affine.covector_columns();
    let field = Sampled::new(*view);
    let one = |place: Vector, normal: Option<&mut [f32; 3]>| {
        let ijk = affine.inverse_point(place);
        let left = leaves(view, iso, cuts, ijk);
        let (ijk, cut) = left.unwrap_or((ijk, None));
        if let Some(normal) = normal {
            let found = match cut {
                Some(cut) => cut.normal,
                None => {
                    let falls = field.slope(ijk).gradient.map(|c| -c);
                    [0, 1, 2].map(|k| (0..3).map(|axis| columns[axis][k] * falls[axis]).sum())
                }
            };
            let long = length(found);
            // Where the field has none, what the extraction found stays.
            if long > 0.0 && long.is_finite() {
                *normal = found.map(|c| (c / long) as f32);
            }
        }
        left.map(|(place, _)| affine.point(place))
    };
    let TriMesh { positions, normals, .. } = mesh;
    job.progress.begin("cut", positions.len() as u64);
    match positions {
        Positions::F32(all) => each(all, normals, |c| c as f32, (&one, job)),
        Positions::F64(all) => each(all, normals, |c| c, (&one, job)),
    }
}

/// Where a vertex goes, if anywhere; its normal, if it has one, is set.
type Move<'a> = &'a (dyn Fn(Vector, Option<&mut [f32; 3]>) -> Option<Vector> + Sync);

/// Moves every vertex.
fn each<C: Copy + Send + Into<f64>>(
    places: &mut [[C; 3]],
    normals: &mut Option<Vec<[f32; 3]>>,
    round: fn(f64) -> C,
    (one, job): (Move<'_>, &Job),
) -> Result<(), Cancelled> {
    let normals: Vec<_> = match normals {
        Some(all) => all.chunks_mut(CHUNK).map(Some).collect(),
        None => (0..places.len().div_ceil(CHUNK)).map(|_| None).collect(),
    };
    let chunk = |(places, mut normals): (&mut [[C; 3]], Option<&mut [[f32; 3]]>)| {
        job.check()?;
        exactly(|| {
            for (n, place) in places.iter_mut().enumerate() {
                let normal = normals.as_mut().map(|all| &mut all[n]);
                if let Some(moved) = one(place.map(Into::into), normal) {
                    *place = moved.map(round);
                }
            }
        });
        job.progress.advance(places.len() as u64);
        Ok(())
    };
    job.threads.run(|| places.par_chunks_mut(CHUNK).zip(normals).try_for_each(chunk))
}

/// Where the edge of a vertex leaves the solid, and through which plane, if it is through one. None of a vertex that is on
/// no edge between two samples: on the border of the volume, or within a cell.
fn leaves<'a, T: Sample>(
    view: &View<'_, T>,
    iso: f64,
    cuts: &'a [Cut],
    ijk: Vector,
) -> Option<(Vector, Option<&'a Cut>)> {
    let nearest = ijk.map(f64::round);
    let away = [0, 1, 2].map(|k| (ijk[k] - nearest[k]).abs());
    let axis = (1..3).fold(0, |most, k| if away[k] > away[most] { k } else { most });
    // Rounding leaves less than half of what vertices keep from samples.
    let is_on_edge = (0..3).all(|k| (away[k] < 0.5 * NEAR) != (k == axis));
    let dims = view.dims();
    let (mut low, mut high) = (nearest, nearest);
    (low[axis], high[axis]) = (ijk[axis].floor(), ijk[axis].floor() + 1.0);
    let is_within = |end: Vector| (0..3).all(|k| end[k] >= 0.0 && end[k] < dims[k] as f64);
    if !(is_on_edge && is_within(low) && is_within(high)) {
        return None;
    }
    let value = |end: Vector| view.value(end.map(|c| c as usize));
    let is_inside =
        |end: Vector| value(end) >= iso && cuts.iter().all(|cut| cut.beyond(end) <= 0.0);
    let (from, to) = if is_inside(low) { (low, high) } else { (high, low) };
    let (inside, outside) = (value(from), value(to));
    let mut first = (f64::INFINITY, None);
    if outside < iso {
        first.0 = (inside - iso) / (inside - outside);
    }
    for cut in cuts {
        let [before, after] = [from, to].map(|end| cut.beyond(end));
        if after > 0.0 && -before / (after - before) < first.0 {
            first = (-before / (after - before), Some(cut));
        }
    }
    let (share, cut) = first;
    let share = if share.is_finite() { share.clamp(NEAR, 1.0 - NEAR) } else { return None };
    let place = std::array::from_fn(|k| from[k] + (to[k] - from[k]) * share);
    Some((place, cut))
}

#[cfg(test)]
mod tests;
