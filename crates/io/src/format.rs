//! What a file is.

use std::fmt;

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// NIfTI-1 and NIfTI-2, one file or a pair.
    Nifti,
    /// Nearly Raw Raster Data, attached or detached header.
    Nrrd,
    /// MetaImage, one file or header and data.
    MetaImage,
    /// NumPy's array file.
    Npy,
    /// Samples and nothing else.
    Raw,
    /// glTF 2.0 in one binary file.
    Glb,
    /// glTF 2.0 as JSON with its buffers beside it.
    Gltf,
    /// Wavefront OBJ.
    Obj,
    /// The Stanford polygon format.
    Ply,
    /// Stereolithography.
    Stl,
}

impl Format {
    /// Short and lower-case, as reports name it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nifti => "nifti",
            Self::Nrrd => "nrrd",
            Self::MetaImage => "metaimage",
            Self::Npy => "npy",
            Self::Raw => "raw",
            Self::Glb => "glb",
            Self::Gltf => "gltf",
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Stl => "stl",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nifti => "NIfTI",
            Self::Nrrd => "NRRD",
            Self::MetaImage => "MetaImage",
            Self::Npy => "NPY",
            Self::Raw => "raw",
            Self::Glb => "GLB",
            Self::Gltf => "glTF",
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Stl => "STL",
        })
    }
}
