//! Brings a mesh nearer to the field that it was extracted from.

use crate::pipeline::{Normals, PipelineError, Scan, SurfaceOptions};
use isokit_field::Sampled;
use isokit_job::Job;
use isokit_marching_cubes::Degenerate;
use isokit_mesh::TriMesh;
use isokit_refine::{Isosurface, RefineError, RefineOptions, Refined, refine};
use isokit_volume::for_any;

impl Scan {
    /// Brings the surface where the value is `iso`, as [`mesh`](Self::mesh) made it with
    /// [`surface.before(options)`](SurfaceOptions::before), nearer to the cubic field through the samples: between
    /// vertices, in area and in volume. In the end it has normals of the kind that `surface` asks for; those of the
    /// gradient are [`Matching`](isokit_marching_cubes::Gradient::Matching) ones in any case.
    ///
    /// Vertices that are there stay or are balanced where they are, so they should be of
    /// [`Placement::Cubic`](isokit_marching_cubes::Placement::Cubic) or better. For a mesh that is written as glTF,
    /// [`RefineOptions::file_scale`] should be what [`MeshContext::file_scale`](isokit_io::MeshContext::file_scale) of
    /// [`context`](Self::context) says.
    ///
    /// # Errors
    ///
    /// If the options mean nothing; if they are for a surface of [`Degenerate::Exact`], whose triangles
    /// without area cannot be divided; if 32 bits cannot number the vertices; or if the job is cancelled or
    /// allows less memory. The mesh is then sound, and as far as it was.
    pub fn refine(
        &self,
        iso: f64,
        mesh: &mut TriMesh,
        options: (&RefineOptions, &SurfaceOptions),
        job: &Job,
    ) -> Result<Refined, PipelineError> {
        for_any!(self.volume(), volume => {
            let field = Sampled::new(self.view(volume));
            refine_on(&Isosurface { field: &field, iso }, mesh, options, job)
        })
    }
}

/// Brings a surface that was made with [`surface.before(options)`](SurfaceOptions::before) nearer to a field that knows more
/// than its samples, such as that of a shape: as [`Scan::refine`], and with vertices on creases, which only such a field has.
///
/// # Errors
///
/// As of [`Scan::refine`].
pub fn refine_on(
    isosurface: &Isosurface<'_>,
    mesh: &mut TriMesh,
    options: (&RefineOptions, &SurfaceOptions),
    job: &Job,
) -> Result<Refined, PipelineError> {
    let (options, surface) = options;
    if options.do_nothing() {
        return Ok(Refined::default());
    }
    if surface.extract.degenerate == Degenerate::Exact {
        let says = "a surface whose triangles may have no area: Degenerate::Exact made it";
        return Err(RefineError::Options(says).into());
    }
    if surface.normals == Normals::Area && !options.balance {
        mesh.normals = None; // new ones are made in any case
    }
    let refined = refine(mesh, isosurface, options, job)?;
    surface.finish(mesh, job)?;
    Ok(refined)
}
