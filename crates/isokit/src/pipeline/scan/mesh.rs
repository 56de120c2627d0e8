//! The surfaces of a scan.

use super::Scan;
use crate::pipeline::{PipelineError, Remark, SurfaceOptions, error::in_whole, index};
use isokit_job::Job;
use isokit_marching_cubes::{Extracted, Source, extract_many};
use isokit_mesh::{Counts, TriMesh};
use isokit_volume::for_any;
use std::{ops::Range, slice};

impl Scan {
    /// The surface where the value is `iso`.
    ///
    /// # Errors
    ///
    /// If the isovalue is not finite, if there is NaN and the options forbid it, if 32 bits cannot
    /// number the vertices, or if the job is cancelled or allows less memory.
    pub fn mesh(
        &self,
        iso: f64,
        options: &SurfaceOptions,
        job: &Job,
    ) -> Result<TriMesh, PipelineError> {
        let mut mesh = TriMesh::default();
        self.mesh_into(iso, options, &mut mesh, job)?;
        Ok(mesh)
    }

    /// The same in the memory of a used mesh.
    ///
    /// # Errors
    ///
    /// As [`mesh`](Self::mesh).
    pub fn mesh_into(
        &self,
        iso: f64,
        options: &SurfaceOptions,
        mesh: &mut TriMesh,
        job: &Job,
    ) -> Result<(), PipelineError> {
        self.meshes_into(&[iso], options, slice::from_mut(mesh), job).map(drop)
    }

    /// The surfaces of several isovalues, for which the samples are classified once, each in the memory
    /// of a used mesh. What comes back says too what an index told not to do; an index by which the
    /// surfaces go through more than an eighth of the part is left aside, for it saves little or nothing then.
    ///
    /// # Errors
    ///
    /// As [`mesh`](Self::mesh).
    ///
    /// # Panics
    ///
    /// If there are not as many meshes as isovalues.
    pub fn meshes_into(
        &self,
        isos: &[f64],
        options: &SurfaceOptions,
        meshes: &mut [TriMesh],
        job: &Job,
    ) -> Result<Vec<Extracted>, PipelineError> {
        self.meshes_of_part(&self.part(), isos, options, meshes, job)
    }

    /// The same in a part of the whole lattice, which must have it in memory.
    pub(crate) fn meshes_of_part(
        &self,
        part: &[Range<usize>; 3],
        isos: &[f64],
        options: &SurfaceOptions,
        meshes: &mut [TriMesh],
        job: &Job,
    ) -> Result<Vec<Extracted>, PipelineError> {
        let mut extracted = options.fill(meshes, job, |sinks| {
            let extracted = for_any!(&self.volume, volume => {
                let view = self.part_of(volume, part);
                let known = self.known(volume, part, isos);
                let source = known.as_deref().and_then(|bricks| Source::with_bricks(&view, bricks));
                let source = source.unwrap_or(Source::from(&view));
                extract_many(source, isos, &options.extract, sinks, job)
            });
            Ok(extracted.map_err(|error| in_whole(error, part))?)
        })?;
        if let Some(bricks) = &self.bricks {
            // Of an index that was left aside no brick is skipped.
            let bricks = index::bricks_of_part(bricks, &self.within(part));
            extracted.iter_mut().for_each(|one| one.skipped.bricks = bricks);
        }
        Ok(extracted)
    }

    /// What is peculiar about a surface of so many vertices and triangles, if anything. Looks at the
    /// samples only where the counts raise the question.
    ///
    /// # Errors
    ///
    /// If the job is cancelled.
    pub fn remark(
        &self,
        iso: f64,
        counts: Counts,
        options: &SurfaceOptions,
        job: &Job,
    ) -> Result<Option<Remark>, PipelineError> {
        let dims = self.part().map(|range| range.len());
        Remark::among(self, dims, (iso, counts), options, job)
    }
}
