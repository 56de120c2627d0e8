//! How a mesh is to be made.

use crate::pipeline::PipelineError;
use isokit_job::Job;
use isokit_marching_cubes::{Diagonals, ExtractOptions, Gradient};
use isokit_mesh::{Refill, TriMesh, area_normals};
use isokit_refine::RefineOptions;

/// Which normals the vertices get.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Normals {
    /// Those of the field: the direction in which the samples fall. Smooth where the field is.
    /// [`ExtractOptions::gradient`] says how exact they are.
    #[default]
    Gradient,
    /// Those of the triangles around a vertex, weighted by area.
    ///
    /// Not promised: an order of those of the field. They are those of flat triangles.
    Area,
    /// None. A viewer shades each triangle flat, or makes normals of its own.
    None,
}

/// How samples become a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SurfaceOptions {
    /// How samples become triangles. Default: [`ExtractOptions::DEFAULT`].
    pub extract: ExtractOptions,
    /// Which normals the vertices get. Positions and triangles do not depend on it. Default:
    /// [`Normals::Gradient`].
    pub normals: Normals,
}

impl SurfaceOptions {
    /// The same options with another `extract`.
    pub fn with_extract(self, extract: ExtractOptions) -> Self {
        Self { extract, ..self }
    }

    /// The same options with other `normals`.
    pub fn with_normals(self, normals: Normals) -> Self {
        Self { normals, ..self }
    }

    /// The options for a surface that [`Scan::refine`](crate::pipeline::Scan::refine) then gets, with these:
    /// where that does anything, with [`Gradient::Matching`], as exact as the normals of new vertices are, and
    /// where it is balanced, with gradient normals in any case, along which its vertices are moved. So
    /// positions do not depend on which normals are wanted in the end.
    pub fn before(&self, refine: &RefineOptions) -> Self {
        let mut options = self.clone();
        if !refine.do_nothing() {
            options.extract.gradient = Gradient::Matching;
        }
        if refine.balance {
            options.normals = Normals::Gradient;
        }
        options
    }

    /// Has an extraction make normals of the field, or not: where they are wanted, and where diagonals are fitted by them.
    pub(crate) fn prepare(&self, mesh: &mut TriMesh) {
        match self.normals {
            Normals::Area | Normals::None if self.extract.diagonals == Diagonals::Table => {
                mesh.normals = None;
            }
            _ => drop(mesh.normals.get_or_insert_default()),
        }
    }

    /// Fills meshes, each in its own memory, with what `extract` hands to their sinks, and the normals that are wanted.
    pub(crate) fn fill<R>(
        &self,
        meshes: &mut [TriMesh],
        job: &Job,
        extract: impl FnOnce(&mut Vec<Refill<'_>>) -> Result<R, PipelineError>,
    ) -> Result<R, PipelineError> {
        meshes.iter_mut().for_each(|mesh| self.prepare(mesh));
        let found = extract(&mut meshes.iter_mut().map(TriMesh::refill).collect())?;
        meshes.iter_mut().try_for_each(|mesh| self.finish(mesh, job))?;
        Ok(found)
    }

    /// Gives what was extracted the normals that are wanted.
    pub(crate) fn finish(&self, mesh: &mut TriMesh, job: &Job) -> Result<(), PipelineError> {
        match self.normals {
            Normals::Gradient => {}
            Normals::Area => area_normals(mesh, job)?,
            Normals::None => mesh.normals = None,
        }
        Ok(())
    }
}
