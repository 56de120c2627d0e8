//! Meshes in files.
//!
//! In memory every mesh is z up, in the unit and the space of its [`MeshContext`]. Each format has axes,
//! unit and precision of its own; what is done about that stands in the header of its module, and in the
//! header of every file that is written.
//!
//! A format's header and sections are encoded in one place each, for surfaces in memory and for those that
//! come in pieces.

mod axes;
mod facts;
mod gltf;
mod input;
mod name;
mod obj;
mod outline;
mod ply;
mod rounding;
mod section;
mod sinks;
mod sound;
mod spool;
mod stl;
mod stream;

pub use input::{MeshInput, read_mesh};
pub use outline::SurfaceHead;
pub use spool::{MeshSpool, SpoolSink};

use crate::{Format, Output, WriteError, WriteFault};
use isokit_geom::{Space, Unit};
use isokit_job::Job;
use isokit_mesh::{Attributes, Rgba, Surface};
use std::{
    io::Write,
    path::{Path, PathBuf},
};

/// What a file says of its world and of its making.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshContext {
    /// The unit of the coordinates in memory.
    pub unit: Unit,
    /// Which way the axes point.
    pub space: Space,
    /// The command that made it; empty if there was none.
    pub command: String,
    /// Instead of `unit`, what a coordinate is taken for when it becomes glTF's metres: a protein in
    /// ångström is too small to be seen there.
    pub gltf_unit: Option<Unit>,
}

impl MeshContext {
    /// What a format multiplies coordinates by before it rounds them to f32, if by anything: glTF is metres, whatever the
    /// unit; a unit that nobody knows counts as metres.
    pub fn file_scale(&self, format: Format) -> Option<f64> {
        let is_gltf = matches!(format, Format::Glb | Format::Gltf);
        let scale = is_gltf.then(|| gltf::Scale::of(self).0);
        scale.filter(|&scale| scale != 1.0)
    }
}

/// What was written, and what whoever reads it should know.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// The files, in the order in which they got their names. None if it was a stream.
    pub files: Vec<PathBuf>,
    /// A sentence each.
    pub warnings: Vec<String>,
    /// How many vertices that were apart fall on the place of another one, since the format holds f32. A
    /// reader that merges equal positions makes one of them.
    pub merged_vertices: u64,
}

/// What a surface without a colour of its own is written with, where a file wants one.
const NEUTRAL: Rgba = Rgba([204, 204, 204, 255]);

/// Writes surfaces in the format that the name of `path` ends in: `.glb`, `.gltf` with a `.bin` beside it,
/// `.obj` with a `.mtl` beside it, `.ply` or `.stl`.
///
/// PLY and STL hold one surface. Several become files of their own: `head_skin.ply` and `head_bone.ply` for
/// `head.ply`. All files appear when they are whole, and of two the one that refers to the other comes last.
///
/// # Errors
///
/// If the name has another ending, if the format cannot hold so much or such numbers, if a file cannot be
/// written, or if the job is cancelled.
pub fn write_mesh(
    path: &Path,
    surfaces: &[Surface],
    context: &MeshContext,
    job: &Job,
) -> Result<Written, WriteError> {
    let format = format_of(path).map_err(|fault| fault.at(path))?;
    sound::check(surfaces).map_err(|fault| fault.at(path))?;
    let mut written = Written::default();
    report_lost(format, surfaces, &mut written);
    match format {
        Format::Gltf => gltf::write_gltf(path, surfaces, context, job, &mut written)?,
        Format::Obj => obj::write_with_materials(path, surfaces, context, job, &mut written)?,
        _ => {
            let paths = paths(format, path, surfaces.iter().map(|surface| surface.name.as_str()));
            // Each file takes its share: one surface, or all of them.
            let share = |n: usize| match paths.len() {
                1 => surfaces,
                _ => std::slice::from_ref(&surfaces[n]),
            };
            let shares: Vec<_> = (0..paths.len()).map(share).collect();
            write_files(format, paths.into_iter().zip(shares), context, job, &mut written)?;
        }
    }
    Ok(written)
}

/// The files that [`write_mesh`] makes for surfaces of these names, those beside `path` included. A name that
/// it refuses comes back alone.
pub fn mesh_files<'a>(
    path: &Path,
    names: impl IntoIterator<Item = &'a str, IntoIter: ExactSizeIterator>,
) -> Vec<PathBuf> {
    let Ok(format) = format_of(path) else { return vec![path.to_owned()] };
    let beside = match format {
        Format::Gltf => Some(path.with_extension("bin")),
        Format::Obj => Some(path.with_extension("mtl")),
        _ => None,
    };
    let own = paths(format, path, names.into_iter());
    beside.into_iter().chain(own).collect()
}

/// Writes surfaces as one stream: GLB, OBJ without materials, or one surface as PLY or STL.
///
/// # Errors
///
/// As [`write_mesh`], and if the format needs several files for this.
pub fn write_mesh_to(
    out: &mut dyn Write,
    format: Format,
    surfaces: &[Surface],
    context: &MeshContext,
    job: &Job,
) -> Result<Written, WriteFault> {
    sound::check(surfaces)?;
    let mut written = Written::default();
    report_lost(format, surfaces, &mut written);
    put(out, format, surfaces, context, job, &mut written)?;
    Ok(written)
}

/// Says what vertices carry that the format has no place for.
fn report_lost(format: Format, surfaces: &[Surface], written: &mut Written) {
    let lost = |surface: &Surface| {
        let Attributes { values, colors } = &surface.mesh.attributes;
        match format {
            Format::Stl => [values.is_some(), colors.is_some()],
            Format::Obj => [values.is_some(), false],
            _ => [false, false],
        }
    };
    for surface in surfaces {
        let name = &surface.name;
        let lost = match lost(surface) {
            [false, false] => continue,
            [true, false] => "values",
            [false, true] => "colours",
            [true, true] => "values and colours",
        };
        let other = if format == Format::Stl { ".ply and .glb do" } else { ".ply does" };
        let says = format!("surface {name:?}: {format} holds no {lost} of vertices; {other}");
        written.warnings.push(says);
    }
}

/// The mesh format that a name ends in.
fn format_of(path: &Path) -> Result<Format, WriteFault> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let known = [Format::Glb, Format::Gltf, Format::Obj, Format::Ply, Format::Stl];
    known.into_iter().find(|format| format.name() == ending).ok_or_else(|| {
        WriteFault::Caller("a mesh is written as .glb, .gltf, .obj, .ply or .stl".into())
    })
}

/// Whether one file of a format can hold several surfaces.
fn holds_several(format: Format) -> bool {
    !matches!(format, Format::Ply | Format::Stl)
}

/// The files that hold surfaces of these names, one for each or one for all.
fn paths<'a>(
    format: Format,
    path: &Path,
    names: impl ExactSizeIterator<Item = &'a str>,
) -> Vec<PathBuf> {
    match names.len() {
        0 | 1 => vec![path.to_owned()],
        _ if holds_several(format) => vec![path.to_owned()],
        _ => name::beside(path, names),
    }
}

/// Writes one file for each path. They get their names when all are whole.
fn write_files<'a>(
    format: Format,
    files: impl Iterator<Item = (PathBuf, &'a [Surface])>,
    context: &MeshContext,
    job: &Job,
    written: &mut Written,
) -> Result<(), WriteError> {
    let whole = files.map(|(path, surfaces)| {
        let mut output = Output::create(&path)?;
        let done = put(&mut output, format, surfaces, context, job, written);
        done.map_err(|fault| fault.at(&path))?;
        Ok(output)
    });
    name_all(whole.collect::<Result<Vec<_>, WriteError>>()?, written)
}

/// Gives files that are whole their names.
fn name_all(mut files: Vec<Output>, written: &mut Written) -> Result<(), WriteError> {
    // All the way, so that none appears if there is no room for another one.
    for output in &mut files {
        output.flush().map_err(|error| WriteFault::Io(error).at(output.path()))?;
    }
    for output in files {
        let path = output.path().to_owned();
        output.finish()?;
        written.files.push(path);
    }
    Ok(())
}

fn put(
    out: &mut dyn Write,
    format: Format,
    surfaces: &[Surface],
    context: &MeshContext,
    job: &Job,
    written: &mut Written,
) -> Result<(), WriteFault> {
    let nothing = Surface::default();
    let one = || match surfaces {
        [] => Ok(&nothing),
        [surface] => Ok(surface),
        _ => Err(WriteFault::Caller(
            format!(
                "{format} holds one surface, not {}; .glb and .obj hold several",
                surfaces.len()
            )
            .into(),
        )),
    };
    match format {
        Format::Glb => gltf::write_glb(out, surfaces, context, job, written),
        Format::Obj => obj::write(out, surfaces, context, job),
        Format::Ply => ply::write(out, one()?, context, job),
        Format::Stl => stl::write(out, one()?, context, job, written),
        _ => Err(WriteFault::Caller(
            format!("{format} cannot be written as one stream; .glb, .obj, .ply and .stl can")
                .into(),
        )),
    }
}

#[cfg(test)]
mod kit;
#[cfg(test)]
mod tests;
