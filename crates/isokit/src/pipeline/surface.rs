//! How a mesh is to be made.

use isokit_marching_cubes::ExtractOptions;
use isokit_refine::RefineOptions;

/// Which normals the vertices get.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Normals {
    /// Those of the field: the direction in which the samples fall. Smooth where the field is.
    #[default]
    Gradient,
    /// Those of the triangles around a vertex, weighted by area.
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
    /// where it is balanced, with gradient normals, along which its vertices are moved. So positions do not
    /// depend on which normals are wanted in the end.
    pub fn before(&self, refine: &RefineOptions) -> Self {
        let normals = if refine.balance { Normals::Gradient } else { self.normals };
        self.clone().with_normals(normals)
    }
}
