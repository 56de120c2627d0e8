//! Where results go, and in which format.

use crate::{
    args::MeshOutputArgs,
    fault::{CallerError, UsageError},
};
use anyhow::Result;
use isokit::{
    geom::Unit,
    io::{Format, MeshContext},
};
use std::path::{Path, PathBuf};

/// What a mesh file may be called.
const MESHES: [(&str, Format); 5] = [
    (".glb", Format::Glb),
    (".gltf", Format::Gltf),
    (".obj", Format::Obj),
    (".ply", Format::Ply),
    (".stl", Format::Stl),
];

/// What a volume file may be called.
const VOLUMES: [&str; 6] = [".nrrd", ".nhdr", ".nii", ".nii.gz", ".npy", ".raw"];

/// What a file of colours may be called.
const COLOR_VOLUMES: [&str; 2] = [".nrrd", ".nhdr"];

/// A file, or stdout.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Stream {
    File(PathBuf),
    Stdout,
}

/// Where a mesh goes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeshTarget {
    pub(crate) stream: Stream,
    pub(crate) format: Format,
    pub(crate) gltf_unit: Option<Unit>,
}

/// Where words go.
pub(crate) type TextTarget = Stream;

impl Stream {
    /// The stream that `-` or a path names. The folder of a file must be there.
    pub(crate) fn named(path: &Path) -> Result<Self> {
        if path == Path::new("-") {
            return Ok(Self::Stdout);
        }
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        let is_missing = folder.is_some_and(|folder| !folder.is_dir());
        match (folder, path.is_dir()) {
            (Some(folder), _) if is_missing => {
                let message =
                    format!("{}: there is no folder {}", path.display(), folder.display());
                let advice = "make the folder, or choose another place";
                Err(CallerError { message, advice }.into())
            }
            (_, true) => {
                let message = format!("{}: this is a folder", path.display());
                Err(CallerError { message, advice: "choose another name for the output" }.into())
            }
            _ => Ok(Self::File(path.to_owned())),
        }
    }
}

impl MeshTarget {
    /// Where `args` send `surfaces` many surfaces.
    pub(crate) fn new(args: &MeshOutputArgs, surfaces: usize) -> Result<Self> {
        let stream = Stream::named(&args.output)?;
        let format = match (&stream, args.format) {
            (Stream::Stdout, format) => format.map_or(Format::Ply, Format::from),
            (Stream::File(_), Some(_)) => {
                let says = "--format says what -o - writes; of a file the extension says it";
                return Err(UsageError(says.into()).into());
            }
            (Stream::File(path), None) => mesh_format(path).ok_or_else(|| {
                UsageError(unknown_ending(path, &MESHES.map(|(ending, _)| ending)))
            })?,
        };
        let target = Self { stream, format, gltf_unit: args.gltf_unit };
        target.check(surfaces)?;
        Ok(target)
    }

    /// What a mesh in some unit is multiplied by in the file, if by anything.
    pub(crate) fn file_scale(&self, unit: Unit) -> Option<f64> {
        let context = MeshContext { unit, gltf_unit: self.gltf_unit, ..MeshContext::default() };
        context.file_scale(self.format)
    }

    fn check(&self, surfaces: usize) -> Result<(), UsageError> {
        let is_gltf = matches!(self.format, Format::Glb | Format::Gltf);
        if self.gltf_unit.is_some() && !is_gltf {
            let says =
                format!("--gltf-unit is for .glb and .gltf; {} has no fixed unit", self.format);
            return Err(UsageError(says));
        }
        let is_single = matches!(self.format, Format::Ply | Format::Stl);
        if self.stream == Stream::Stdout && is_single && surfaces > 1 {
            let says = "holds one surface only: give -o - several as --format glb or obj";
            return Err(UsageError(format!("{} {says}", self.format)));
        }
        Ok(())
    }
}

/// The mesh format that a file name asks for.
pub(super) fn mesh_format(path: &Path) -> Option<Format> {
    MESHES.into_iter().find(|(ending, _)| has_ending(path, ending)).map(|(_, format)| format)
}

/// Whether a file name asks for a volume.
pub(super) fn is_volume(path: &Path) -> bool {
    VOLUMES.into_iter().any(|ending| has_ending(path, ending))
}

/// Whether a file name asks for a volume of a format that holds colours.
pub(super) fn is_color_volume(path: &Path) -> bool {
    COLOR_VOLUMES.into_iter().any(|ending| has_ending(path, ending))
}

/// Whether a file name asks for a picture.
pub(crate) fn is_png(path: &Path) -> bool {
    has_ending(path, ".png")
}

/// The refusal of a name that is not that of a volume.
pub(super) fn no_volume(path: &Path) -> UsageError {
    UsageError(unknown_ending(path, &VOLUMES))
}

/// The refusal of a name that is not that of a volume of colours.
pub(super) fn no_color_volume(path: &Path) -> UsageError {
    UsageError(unknown_ending(path, &COLOR_VOLUMES))
}

/// The refusal of a name that is neither.
pub(super) fn neither(path: &Path) -> UsageError {
    let meshes = MESHES.map(|(ending, _)| ending);
    UsageError(unknown_ending(path, &[&meshes[..], &VOLUMES[..]].concat()))
}

fn has_ending(path: &Path, ending: &str) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    name.len() > ending.len() && name.ends_with(ending)
}

fn unknown_ending(path: &Path, known: &[&str]) -> String {
    let found = match path.extension() {
        Some(ending) => format!(".{}", ending.display()),
        None => "none".to_owned(),
    };
    let known = known.join(" ");
    format!("{}: expected a name that ends in one of {known}, found {found}", path.display())
}
