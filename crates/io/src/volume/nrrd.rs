//! NRRD, versions 1 to 5, after the definition of the format by teem.
//!
//! Header and samples in one file, or samples in others that the header names. Encodings raw, gzip,
//! bzip2 and text. Fields that say nothing of samples or their place are ignored, as are key/value
//! pairs. LAS is reflected into RAS, and a left-handed space into a right-handed one, with a note: a
//! head keeps its left ear on its left. A multi-byte type without `endian` counts as little-endian,
//! absent units as millimetres.

mod axes;
mod header;
mod write;

pub(super) use write::{write, write_detached};

use super::{
    Described, sample_feature,
    stored::{Coding, Order, Skip, Stored},
};
use crate::{Endian, Format, ReadError, ReadFault, bytes::Bytes, text::Field};
use header::Header;
use isokit_geom::Unit;
use isokit_volume::{Dtype, Scaling};
use std::path::Path;

pub(super) fn describe(path: &Path) -> Result<Described, ReadError> {
    let bytes = Bytes::open(path)?;
    let described = Header::read(bytes, path).and_then(|header| described(&header, path));
    described.map_err(|fault| fault.at(path))
}

fn described(header: &Header, path: &Path) -> Result<Described, ReadFault> {
    let mut notes = vec![];
    let axes = axes::read(header)?;
    let dtype = dtype(header.need("type")?)?;
    let lattice = axes::lattice(header, &axes, dtype)?;
    let (affine, space, factors) = axes::place(header, &axes, &lattice, &mut notes)?;
    let stored = stored(header, path, dtype, &mut notes)?;
    if let Some((files, field, per_file)) = &header.files {
        let sizes: Vec<u64> = axes.iter().map(|axis| axis.size).collect();
        files.fit(field, &sizes, *per_file)?;
    }
    Ok(Described {
        dims: lattice.dims,
        volumes: lattice.volumes,
        affine,
        has_geometry: true,
        unit: unit(header, &lattice, &mut notes)?,
        space,
        scaling: Scaling::IDENTITY,
        stored,
        to_world: axes::vectors_to_world(header, factors),
        triples: lattice.triples,
        colored: lattice.colored,
        sample_unit: sample_unit(header)?,
        notes,
    })
}

fn dtype(field: &Field) -> Result<Dtype, ReadFault> {
    let name = field.value.to_ascii_lowercase();
    let name = name.split_whitespace().collect::<Vec<_>>().join(" ");
    let refused = match name.as_str() {
        "signed char" | "int8" | "int8_t" => return Ok(Dtype::I8),
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => return Ok(Dtype::U8),
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            return Ok(Dtype::I16);
        }
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => {
            return Ok(Dtype::U16);
        }
        "int" | "signed int" | "int32" | "int32_t" => return Ok(Dtype::I32),
        "uint" | "unsigned int" | "uint32" | "uint32_t" => return Ok(Dtype::U32),
        "float" => return Ok(Dtype::F32),
        "double" => return Ok(Dtype::F64),
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => "int64",
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => {
            "uint64"
        }
        "block" => "block",
        _ => return Err(field.broken("a type like short or float")),
    };
    Err(field.unsupported(sample_feature(refused)))
}

fn coding(field: &Field) -> Result<Coding, ReadFault> {
    match field.value.to_ascii_lowercase().as_str() {
        "raw" => Ok(Coding::Raw),
        "txt" | "text" | "ascii" => Ok(Coding::Text),
        "gz" | "gzip" => Ok(Coding::Gzip),
        "bz2" | "bzip2" => Ok(Coding::Bzip2),
        "hex" | "zrl" => Err(field.unsupported(format!("encoding {}", field.value))),
        _ => Err(field.broken("an encoding: raw, text, gzip or bzip2")),
    }
}

fn stored(
    header: &Header,
    path: &Path,
    dtype: Dtype,
    notes: &mut Vec<String>,
) -> Result<Stored, ReadFault> {
    let coding = coding(header.need("encoding")?)?;
    let lines = match header.get("line skip") {
        Some(field) => field.number("a number of lines")?,
        None => 0,
    };
    let skip = match header.get("byte skip") {
        Some(field) => match field.number::<i64>("a number of bytes, or -1")? {
            -1 => Skip::AllButSamples,
            skip => Skip::Bytes(
                u64::try_from(skip).map_err(|_| field.broken("a number of bytes, or -1"))?,
            ),
        },
        None => Skip::Bytes(0),
    };
    let endian = endian(header, dtype, coding, notes)?;
    let stored = Stored::attached(Format::Nrrd, path, header.bytes, dtype);
    let stored = Stored { lines, coding, skip, endian, order: Order::XFastest, ..stored };
    Ok(match &header.files {
        Some((files, ..)) => {
            let named_by = Some(path.to_owned());
            Stored { files: files.clone(), named_by, header: 0, ..stored }
        }
        None => stored,
    })
}

fn endian(
    header: &Header,
    dtype: Dtype,
    coding: Coding,
    notes: &mut Vec<String>,
) -> Result<Endian, ReadFault> {
    match header.get("endian") {
        Some(field) => match field.value.to_ascii_lowercase().as_str() {
            "little" => Ok(Endian::Little),
            "big" => Ok(Endian::Big),
            _ => Err(field.broken("endian little or big")),
        },
        None => {
            if dtype.bytes() > 1 && coding != Coding::Text {
                notes.push("no endian given; little is assumed".into());
            }
            Ok(Endian::Little)
        }
    }
}

/// What values are in: any word, in quotes or not.
fn sample_unit(header: &Header) -> Result<Option<String>, ReadFault> {
    let Some(field) = header.get("sample units") else { return Ok(None) };
    let word = match field.value.trim().starts_with('"') {
        true => header::quoted(field)?.concat(),
        false => field.value.trim().to_owned(),
    };
    Ok(Some(word).filter(|word| !word.is_empty() && word != "???"))
}

/// The unit of the space, or else of the axes; several at once are none.
fn unit(
    header: &Header,
    lattice: &axes::Lattice,
    notes: &mut Vec<String>,
) -> Result<Unit, ReadFault> {
    let of_space = header.get("space units").map(header::quoted).transpose()?;
    let of_axes = header.get("units").map(header::quoted).transpose()?.map(|units| {
        let spatial = lattice.spatial.iter().filter_map(|&axis| units.get(axis).cloned());
        spatial.collect::<Vec<_>>()
    });
    let mut units = of_space.or(of_axes).unwrap_or_default();
    units.retain(|unit| !unit.is_empty() && unit != "???");
    units.dedup();
    Ok(match units.as_slice() {
        [] => {
            notes.push("no unit given; millimetres are assumed".into());
            Unit::Millimetre
        }
        [unit] => Unit::from_symbol(unit).unwrap_or_else(|| {
            notes.push(format!("the unit {unit:?} is not known"));
            Unit::Unknown
        }),
        several => {
            notes.push(format!("axes in different units ({}); none is used", several.join(", ")));
            Unit::Unknown
        }
    })
}

#[cfg(test)]
mod tests;
