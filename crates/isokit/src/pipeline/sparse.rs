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
    let one = |(&iso, mesh): (&f64, &mut TriMesh)| {
        options.prepare(mesh);
        let extracted = extract_sparse(source, iso, &options.extract, &mut mesh.refill(), job)?;
        options.finish(mesh, job)?;
        Ok(extracted)
    };
    isos.iter().zip(meshes).map(one).collect()
}
