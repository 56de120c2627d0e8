//! NRRD with raw samples, attached or beside the header.

use super::super::write::{Content, dtype};
use crate::{Output, WriteError, WriteFault};
use isokit_geom::{Space, Unit};
use isokit_job::Job;
use isokit_volume::{Channels, Dtype};
use std::{fmt::Write as _, io::Write, path::Path};

/// Header and samples in one file.
pub(in super::super) fn write(
    out: &mut Output,
    content: Content<'_>,
    job: &Job,
) -> Result<(), WriteFault> {
    out.write_all(header(content, None).as_bytes())?;
    content.put(out, job)
}

/// A header at `path` and samples in the `.raw` beside it, which is to get its name first.
pub(in super::super) fn write_detached(
    path: &Path,
    content: Content<'_>,
    job: &Job,
) -> Result<Vec<Output>, WriteError> {
    let data = path.with_extension("raw");
    let name = data.file_name().and_then(|name| name.to_str());
    let name = name.filter(|name| !name.contains(['\n', '\r']) && !name.contains('%'));
    let unnamed = "an NRRD header cannot hold this name (UTF-8, no line end, no %); use .nrrd";
    let name = name.ok_or_else(|| WriteFault::Caller(unnamed.into()).at(path))?;
    let mut samples = Output::create(&data)?;
    content.put(&mut samples, job).map_err(|fault| fault.at(&data))?;
    let mut out = Output::create(path)?;
    let header = header(content, Some(name));
    out.write_all(header.as_bytes()).map_err(|error| WriteFault::Io(error).at(path))?;
    Ok(vec![samples, out])
}

fn header(content: Content<'_>, data_file: Option<&str>) -> String {
    let frame = content.grid().frame;
    let affine = frame.index_to_world;
    let dtype = match content {
        Content::Values(volume) => dtype(volume),
        Content::Colors(_) => Dtype::U8,
    };
    let kind = match dtype {
        Dtype::U8 => "unsigned char",
        Dtype::I8 => "signed char",
        Dtype::U16 => "unsigned short",
        Dtype::I16 => "short",
        Dtype::U32 => "unsigned int",
        Dtype::I32 => "int",
        Dtype::F32 => "float",
        Dtype::F64 => "double",
    };
    let space = match frame.space {
        Space::Ras => "space: right-anterior-superior",
        Space::Lps => "space: left-posterior-superior",
        _ => "space dimension: 3",
    };
    // Of colours the first axis counts the numbers; it leads nowhere.
    let (axes, first) = match content {
        Content::Values(_) => (3, ["", "", ""]),
        Content::Colors(colors) => match colors.channels() {
            Channels::Rgb => (4, ["3 ", "none ", "RGB-color "]),
            Channels::Rgba => (4, ["4 ", "none ", "RGBA-color "]),
        },
    };
    let [size, nowhere, counted] = first;
    let [x, y, z] = content.grid().dims();
    let directions = affine.columns().map(listed).join(" ");
    // Absent units would be read as millimetres.
    let unit = if frame.unit == Unit::Unknown { "unknown".into() } else { frame.unit.to_string() };
    let origin = listed(affine.origin());
    let mut header = format!(
        "NRRD0004\ntype: {kind}\ndimension: {axes}\n{space}\nsizes: {size}{x} {y} {z}\n\
         space directions: {nowhere}{directions}\nkinds: {counted}domain domain domain\nendian: little\n\
         encoding: raw\nspace origin: {origin}\n\
         space units: \"{unit}\" \"{unit}\" \"{unit}\"\n"
    );
    match data_file {
        // Never a bare `LIST`.
        Some(name) => writeln!(header, "data file: ./{name}").expect("a string takes all"),
        None => header.push('\n'),
    }
    header
}

fn listed(vector: [f64; 3]) -> String {
    format!("({})", vector.map(|x| x.to_string()).join(","))
}
