//! Surfaces that planes and masks cut, closed where they do.
//!
//! What is inside of the surface, on the kept side of all planes and in the mask is a solid again: its samples are those whose
//! values are at the isovalue or above, and that neither cuts away. Its surface is extracted like any other, so it is closed
//! and manifold however planes, masks and samples lie. Each vertex then goes, on its edge of the lattice, to where the edge
//! leaves the solid: where linear interpolation has the isovalue, through a plane, or out of the mask, whichever comes first. Between two
//! samples a mask is taken to end once.
//! So the cut of a plane is flat, and only its rim is cut off within a cell. That of a mask has the steps of the mask's samples.

mod mask;
mod samples;

pub use mask::Mask;

use crate::pipeline::{Normals, PipelineError, Scan, SurfaceOptions, error::of_slabs};
use isokit_field::{Sampled, ScalarField};
use isokit_geom::{
    HalfSpace,
    vector::{Vector, unit},
};
use isokit_job::{CHUNK, Cancelled, Job};
use isokit_lanes::exactly;
use isokit_marching_cubes::{Degenerate, Diagonals, Extracted, Placement};
use isokit_mesh::{Positions, TriMesh, area_normals};
use isokit_volume::{Sample, for_any};
use rayon::prelude::*;
use samples::{Clipped, Fall, Through, cuts};

impl Scan {
    /// The surface where the value is `iso`, of what all planes and a [mask](Self::mask) keep, closed where they cut.
    ///
    /// Where there are any vertices are placed linearly, diagonals are the table's and triangles have an area, whatever the
    /// options say. What is left of the samples is held a few slices at a time; with an [index](Self::index) only near
    /// the surface, if that goes through an eighth of the bricks at the most. With neither it is the surface as it is.
    ///
    /// # Errors
    ///
    /// As [`mesh`](Self::mesh).
    ///
    /// # Panics
    ///
    /// If the mask is that of another part, or of the scan in another place.
    pub fn clipped_mesh(
        &self,
        iso: f64,
        (planes, mask): (&[HalfSpace], Option<&Mask>),
        options: &SurfaceOptions,
        job: &Job,
    ) -> Result<(TriMesh, Extracted), PipelineError> {
        let mut meshes = [TriMesh::default()];
        let extracted = match (planes, mask) {
            ([], None) => self.meshes_into(&[iso], options, &mut meshes, job)?,
            cuts => self.clip_into(iso, cuts, options, (&mut meshes[0], job))?,
        };
        let [mesh] = meshes;
        Ok((mesh, extracted.into_iter().next().expect("one isovalue has one surface")))
    }

    /// The same where something cuts, into a mesh.
    fn clip_into(
        &self,
        iso: f64,
        (planes, mask): (&[HalfSpace], Option<&Mask>),
        options: &SurfaceOptions,
        (mesh, job): (&mut TriMesh, &Job),
    ) -> Result<Vec<Extracted>, PipelineError> {
        let fits = mask.is_none_or(|mask| mask.is_of(self.lattice()));
        assert!(fits, "a mask of the same part in the same place");
        let range = self.statistics(job)?.range.unwrap_or([iso, iso]);
        let linear = options.extract.clone().with_placement(Placement::Linear);
        // Vertices are still to be moved, along an edge that is theirs alone.
        let linear = linear.with_diagonals(Diagonals::Table).with_degenerate(Degenerate::Never);
        let options = options.clone().with_extract(linear);
        let extracted = for_any!(self.volume(), volume => {
            let view = self.view(volume);
            let cuts = cuts(&view.frame().index_to_world, planes);
            let known = self.known(volume, &self.part(), &[iso]);
            let fall = Fall::of(&view, range);
            let clipped = Clipped { view, iso, fall, cuts: &cuts, mask, known };
            let extracted = clipped.mesh_into(&options, mesh, job);
            let extracted = extracted.map_err(|error| of_slabs(error, &self.part()))?;
            settle(mesh, &clipped, extracted[0].margin, job)?;
            extracted
        });
        if options.normals == Normals::Area {
            area_normals(mesh, job)?;
        }
        Ok(extracted)
    }
}

/// Moves vertices along their edges to where these leave the solid. There they get the normal of the field or the plane; on
/// the cut of a mask and the border of the volume they keep that of the samples that are left.
fn settle<T: Sample>(
    mesh: &mut TriMesh,
    clipped: &Clipped<'_, T>,
    margin: f64,
    job: &Job,
) -> Result<(), Cancelled> {
    let affine = clipped.view.frame().index_to_world;
    let columns = affine.covector_columns();
    let field = Sampled::new(clipped.view);
    let of_field = |ijk: Vector| {
        let falls = field.slope(ijk).gradient.map(|c| -c);
        [0, 1, 2].map(|k| (0..3).map(|axis| columns[axis][k] * falls[axis]).sum())
    };
    let one = |place: Vector, normal: Option<&mut [f32; 3]>| {
        let ijk = affine.inverse_point(place);
        let left = clipped.leaves(ijk, margin);
        if let Some(normal) = normal {
            let found = match &left {
                Some((ijk, Through::Field)) => Some(of_field(*ijk)),
                Some((_, Through::Plane(cut))) => Some(cut.normal),
                Some((_, Through::Mask)) | None => None,
            };
            // Where nothing is found, also where the field has no slope, what the extraction found stays.
            if let Some(found) = found.and_then(unit) {
                *normal = found.map(|c| c as f32);
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

#[cfg(test)]
mod tests;
