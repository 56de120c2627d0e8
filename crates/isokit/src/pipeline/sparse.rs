//! From samples that are made where they are asked for to meshes.

use crate::pipeline::{PipelineError, SurfaceOptions};
use isokit_job::Job;
use isokit_marching_cubes::{Extracted, extract_sparse};
use isokit_mesh::TriMesh;
use isokit_volume::{Sample, SampleSource};

/// The surfaces of several isovalues of samples that are made only near them, such as those of a shape
/// ([`FieldSamples`](crate::field::FieldSamples)): the same as of all samples, byte for byte. Each mesh is made in the memory of
/// the mesh that was there.
///
/// # Errors
///
/// If an isovalue is not finite, a surface is too large to be numbered, or the job is cancelled or allows less memory.
///
/// # Panics
///
/// If there are not as many meshes as isovalues.
pub fn sparse_meshes_into<T: Sample>(
    source: &dyn SampleSource<T>,
    isos: &[f64],
    options: &SurfaceOptions,
    meshes: &mut [TriMesh],
    job: &Job,
) -> Result<Vec<Extracted>, PipelineError> {
    assert_eq!(isos.len(), meshes.len(), "one mesh per isovalue");
    options.fill(meshes, job, |sinks| {
        let one = |(&iso, sink)| extract_sparse(source, iso, &options.extract, sink, job);
        Ok(isos.iter().zip(sinks).map(one).collect::<Result<_, _>>()?)
    })
}
