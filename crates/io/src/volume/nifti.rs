//! NIfTI-1 and NIfTI-2, one file or a pair; Analyze 7.5, from which they come.
//!
//! After `nifti1.h` (Cox et al. 2004) and `nifti2.h`. Read here, not by the crate `nifti`: a header is
//! 348 or 540 bytes, and the place in the world, the streaming and the checks would be ours anyway.
//!
//! The world is RAS. `sform_code` above 0 wins over `qform_code` above 0; with both 0 there is a spacing,
//! no origin, and nobody knows which way the axes point. Units that are not given count as
//! millimetres. Axes 4 to 7 count volumes.

mod affine;
mod header;
mod write;

pub(super) use write::write;

use super::{
    Described, sample_feature,
    stored::{Skip, Stored},
    vectors::{ADVICE, ALONG_AXES, Layout, Triples},
};
use crate::{Format, Place, ReadError, ReadFault, bytes::Bytes};
use header::{Header, Kind, TWO};
use isokit_geom::{Space, Unit};
use isokit_volume::{Dtype, Scaling};
use std::path::{Path, PathBuf};

pub(super) fn describe(path: &Path) -> Result<Described, ReadError> {
    let path = header_of(path);
    let bytes = read_header(&path)?;
    let found = Header::parse(&bytes).and_then(|header| described(&header, &path));
    found.map_err(|fault| fault.at(&path))
}

/// The header of an image; any other file is its own.
fn header_of(path: &Path) -> PathBuf {
    match sibling(path, "img", "hdr") {
        Some(header) => header,
        None => path.to_owned(),
    }
}

/// The other file of a pair: packed the same way if there is one such, else the other way.
fn sibling(path: &Path, from: &str, to: &str) -> Option<PathBuf> {
    let packed = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("gz"));
    let name = if packed { path.with_extension("") } else { path.to_owned() };
    let end = name.extension()?.to_str()?;
    if !end.eq_ignore_ascii_case(from) {
        return None;
    }
    let upper = end.chars().all(char::is_uppercase);
    let end = if upper { to.to_uppercase() } else { to.to_owned() };
    let plain = name.with_extension(&end);
    let gzip = name.with_extension(end + ".gz");
    let (first, second) = if packed { (gzip, plain) } else { (plain, gzip) };
    Some(if !first.exists() && second.exists() { second } else { first })
}

/// As many bytes as the header has; fewer if the file ends.
fn read_header(path: &Path) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Bytes::open(path)?;
    let mut header = vec![0; TWO.size];
    let read = bytes.read_up_to(&mut header);
    let held = read.map_err(|error| bytes.fault(Format::Nifti, error).at(path))?;
    header.truncate(held);
    Ok(header)
}

fn described(header: &Header<'_>, path: &Path) -> Result<Described, ReadFault> {
    let mut notes = vec![];
    if header.kind == Kind::Analyze {
        notes.push("Analyze 7.5: no origin, and nobody knows which way the axes point".into());
    }
    let (dims, volumes) = header.sizes()?;
    let unit = unit(header, &mut notes);
    let dtype = dtype(header)?;
    let (affine, space) = match affine::of(header) {
        Ok((affine, space)) => (Ok(affine), space),
        Err(fault) => (Err(fault), Space::Ras),
    };
    let triples = (header.is_of_vectors() && volumes == 3).then(|| {
        let says = format!("vectors of 3 numbers (intent_code): {ADVICE}");
        let (layout, fault) = (Layout::Apart, Some(ReadFault::Caller(says.into())));
        Triples { layout, dims, fault, are_volumes: true }
    });
    Ok(Described {
        dims,
        volumes,
        affine,
        has_geometry: true,
        unit,
        space,
        scaling: scaling(header, &mut notes),
        stored: stored(header, path, dtype, &mut notes)?,
        triples,
        colored: None,
        to_world: Ok(ALONG_AXES),
        sample_unit: None,
        notes,
    })
}

fn dtype(header: &Header<'_>) -> Result<Dtype, ReadFault> {
    let code = header.record.i16(header.layout.datatype);
    let name = match code {
        2 => return Ok(Dtype::U8),
        4 => return Ok(Dtype::I16),
        8 => return Ok(Dtype::I32),
        16 => return Ok(Dtype::F32),
        64 => return Ok(Dtype::F64),
        256 => return Ok(Dtype::I8),
        512 => return Ok(Dtype::U16),
        768 => return Ok(Dtype::U32),
        1 => "binary (one bit)",
        32 => "complex64",
        128 => "RGB24",
        1024 => "int64",
        1280 => "uint64",
        1536 => "float128",
        1792 => "complex128",
        2048 => "complex256",
        2304 => "RGBA32",
        _ => {
            return Err(header.broken(
                header.layout.datatype,
                "a code of a data type",
                code.to_string(),
            ));
        }
    };
    let place = Place::Byte(header.layout.datatype as u64);
    let feature = sample_feature(name).into();
    Err(ReadFault::Unsupported { format: Format::Nifti, place, feature })
}

fn unit(header: &Header<'_>, notes: &mut Vec<String>) -> Unit {
    match header.units() & 7 {
        1 => Unit::Metre,
        2 => Unit::Millimetre,
        3 => Unit::Micrometre,
        0 => {
            notes.push("no unit given; millimetres are assumed".into());
            Unit::Millimetre
        }
        code => {
            notes.push(format!("unit code {code} means nothing; millimetres are assumed"));
            Unit::Millimetre
        }
    }
}

/// A slope of 0 or without a value means that there is no scaling.
fn scaling(header: &Header<'_>, notes: &mut Vec<String>) -> Scaling {
    if header.kind == Kind::Analyze {
        return Scaling::IDENTITY;
    }
    let [slope, intercept] = [0, 1].map(|n| header.real(header.layout.scl, n));
    if slope == 0.0 || !slope.is_finite() {
        return Scaling::IDENTITY;
    }
    if !intercept.is_finite() {
        notes.push(format!("scl_inter is {intercept}; 0 is assumed"));
    }
    let intercept = if intercept.is_finite() { intercept } else { 0.0 };
    Scaling::new(slope, intercept).unwrap_or_default()
}

fn stored(
    header: &Header<'_>,
    path: &Path,
    dtype: Dtype,
    notes: &mut Vec<String>,
) -> Result<Stored, ReadFault> {
    let place = header.layout.vox_offset;
    let offset = header.vox_offset();
    // The least is the header with the four bytes that say whether extensions follow.
    let least = if header.kind == Kind::Single { header.layout.size as f64 + 4.0 } else { 0.0 };
    let unset = header.kind == Kind::Single && offset == 0.0;
    if unset {
        notes.push(format!("vox_offset is 0; {least} is assumed"));
    }
    let offset = if unset { least } else { offset };
    let is_whole = offset.fract() == 0.0 && (least..9e15).contains(&offset);
    if !is_whole {
        let expected = format!("vox_offset of at least {least}");
        return Err(header.broken(place, expected, offset.to_string()));
    }
    let stored = Stored::attached(Format::Nifti, path, offset as u64, dtype);
    let stored = Stored { endian: header.record.endian, ..stored };
    match (header.kind, sibling(path, "hdr", "img")) {
        (Kind::Single, _) => Ok(stored),
        (_, Some(image)) => Ok(Stored {
            files: super::files::DataFiles::One(image),
            named_by: Some(path.to_owned()),
            header: 0,
            skip: Skip::Bytes(offset as u64),
            ..stored
        }),
        (Kind::Pair, None) => {
            let found = "a header whose name does not end in .hdr".into();
            Err(header.broken(header.layout.magic, "the header of a pair, image in .img", found))
        }
        (Kind::Analyze, None) => {
            let magic = &header.record.bytes[header.layout.magic..header.layout.magic + 4];
            let found = format!("{:?}", String::from_utf8_lossy(magic));
            Err(header.broken(header.layout.magic, "\"n+1\" or \"ni1\"", found))
        }
    }
}

#[cfg(test)]
mod tests;
