//! NumPy's array file, versions 1 to 3, after NEP 1 (`numpy.lib.format`).
//!
//! An array is indexed `[z, y, x]`. Fewer axes are the last of these; an axis before them counts
//! volumes. A fourth, last axis of size 3 may hold vectors. In Fortran order z lies fastest, and
//! samples are turned round while they are read. NPY has neither place nor unit.

use super::{
    Described, sample_feature,
    stored::{Order, Stored},
    vectors::{ADVICE, ALONG_AXES, Layout, Triples},
    write::{dtype, form, put_samples},
};
use crate::{
    Endian, Format, Place, ReadError, ReadFault, WriteFault,
    bytes::{Bytes, Record},
    text::shown,
};
use isokit_geom::{Affine, Space, Unit};
use isokit_job::Job;
use isokit_volume::{AnyVolume, Dtype, Scaling};
use std::{io::Read, io::Write, path::Path};

const MAGIC: &[u8] = b"\x93NUMPY";

/// Where the dictionary begins in version 1, and from version 2 on.
const DICTIONARY: [usize; 2] = [10, 12];

/// The longest dictionary; NumPy itself takes 10 000 bytes.
const MOST: usize = 1 << 16;

pub(super) fn describe(path: &Path) -> Result<Described, ReadError> {
    let mut bytes = Bytes::open(path)?;
    let header = Header::read(&mut bytes).and_then(|header| header.described(path));
    header.map_err(|fault| fault.at(path))
}

/// The dictionary as text, and where it begins.
struct Header {
    text: String,
    start: usize,
}

fn broken(at: usize, expected: &'static str, found: String) -> ReadFault {
    let (format, place) = (Format::Npy, Place::Byte(at as u64));
    ReadFault::Broken { format, place, expected: expected.into(), found }
}

impl Header {
    fn read(bytes: &mut Bytes) -> Result<Self, ReadFault> {
        let mut start = [0; DICTIONARY[1]];
        let fault = |bytes: &Bytes, error| bytes.fault(Format::Npy, error);
        let held = bytes.read_up_to(&mut start).map_err(|error| fault(bytes, error))?;
        if !start.starts_with(MAGIC) {
            let found = shown(&String::from_utf8_lossy(&start[..held.min(MAGIC.len())]));
            return Err(broken(0, "\"\\x93NUMPY\"", found));
        }
        let truncated = |announced: usize, held: usize| {
            let (announced, held) = (announced as u64, held as u64);
            ReadFault::Truncated { format: Format::Npy, what: "header", announced, held }
        };
        if held < start.len() {
            return Err(truncated(start.len(), held));
        }
        let record = Record { bytes: &start, endian: Endian::Little };
        // Both lengths are unsigned.
        let (first, length) = match start[6] {
            1 => (DICTIONARY[0], record.i16(8) as u16 as usize),
            2 | 3 => (DICTIONARY[1], record.i32(8) as u32 as usize),
            version => return Err(broken(6, "version 1, 2 or 3", version.to_string())),
        };
        if length > MOST {
            return Err(broken(8, "a header of at most 64 KiB", format!("{length} bytes")));
        }
        let mut text = start[first..].to_vec();
        let more = length.saturating_sub(text.len()) as u64;
        bytes.take(more).read_to_end(&mut text).map_err(|error| fault(bytes, error))?;
        if text.len() < length {
            return Err(truncated(first + length, first + text.len()));
        }
        text.truncate(length);
        Ok(Self { text: String::from_utf8_lossy(&text).into_owned(), start: first })
    }

    /// What stands after a key, and where.
    fn value(&self, key: &str, expected: &'static str) -> Result<(&str, usize), ReadFault> {
        let found = ["'", "\""].into_iter().find_map(|quote| {
            let key = format!("{quote}{key}{quote}");
            Some(self.text.find(&key)? + key.len())
        });
        let value = found.and_then(|end| {
            let rest = self.text[end..].trim_start().strip_prefix(':')?.trim_start();
            Some((rest, self.start + self.text.len() - rest.len()))
        });
        value.ok_or_else(|| broken(self.start, expected, shown(self.text.trim())))
    }

    fn described(&self, path: &Path) -> Result<Described, ReadFault> {
        let (dtype, endian) = self.sample_type()?;
        let (dims, volumes) = self.sizes()?;
        let header = (self.start + self.text.len()) as u64;
        let stored = Stored::attached(Format::Npy, path, header, dtype);
        Ok(Described {
            dims,
            volumes,
            affine: Ok(Affine::IDENTITY),
            has_geometry: false,
            unit: Unit::Unknown,
            space: Space::Unknown,
            scaling: Scaling::IDENTITY,
            stored: Stored { endian, order: self.order(dims, volumes)?, ..stored },
            colored: None,
            triples: self.triples(dims, volumes)?,
            to_world: Ok(ALONG_AXES),
            sample_unit: None,
            notes: vec![],
        })
    }

    /// `descr`: a byte order and a type, as in `'<i2'`.
    fn sample_type(&self) -> Result<(Dtype, Endian), ReadFault> {
        const EXPECTED: &str = "'descr' with a sample type like '<i2'";
        let (value, at) = self.value("descr", EXPECTED)?;
        let unsupported = |feature: String| {
            let (format, place) = (Format::Npy, Place::Byte(at as u64));
            ReadFault::Unsupported { format, place, feature: feature.into() }
        };
        if value.starts_with('[') {
            return Err(unsupported("an array of records".into()));
        }
        let text = value
            .chars()
            .next()
            .filter(|quote| matches!(quote, '\'' | '"'))
            .and_then(|quote| value[1..].split_once(quote))
            .map(|(text, _)| text)
            .ok_or_else(|| broken(at, EXPECTED, shown(value)))?;
        let endian = match text.chars().next() {
            Some('<') => Endian::Little,
            Some('>') => Endian::Big,
            _ => Endian::NATIVE,
        };
        let dtype = match text.trim_start_matches(['<', '>', '|', '=']) {
            "u1" | "b1" | "?" | "B" => Dtype::U8,
            "i1" | "b" => Dtype::I8,
            "u2" => Dtype::U16,
            "i2" => Dtype::I16,
            "u4" => Dtype::U32,
            "i4" => Dtype::I32,
            "f4" => Dtype::F32,
            "f8" => Dtype::F64,
            "i8" => return Err(unsupported(sample_feature("int64"))),
            "u8" => return Err(unsupported(sample_feature("uint64"))),
            "f2" => return Err(unsupported(sample_feature("float16"))),
            "c8" => return Err(unsupported(sample_feature("complex64"))),
            "c16" => return Err(unsupported(sample_feature("complex128"))),
            other => return Err(unsupported(sample_feature(&shown(other)))),
        };
        Ok((dtype, endian))
    }

    /// `shape`: sizes along x, y, z, and how many volumes the axes before z make.
    fn sizes(&self) -> Result<([u64; 3], u64), ReadFault> {
        const EXPECTED: &str = "'shape' with one size or more, each above 0, as (z, y, x)";
        let (value, at) = self.value("shape", EXPECTED)?;
        let wrong = || broken(at, EXPECTED, shown(value));
        let list =
            value.strip_prefix('(').and_then(|rest| rest.split_once(')')).ok_or_else(wrong)?;
        let sizes = list.0.split(',').map(|size| size.trim().trim_end_matches('L'));
        let sizes: Result<Vec<u64>, _> =
            sizes.filter(|size| !size.is_empty()).map(str::parse).collect();
        let mut sizes = sizes.map_err(|_| wrong())?;
        if sizes.is_empty() || sizes.contains(&0) {
            return Err(wrong());
        }
        sizes.reverse();
        let size = |axis: usize| sizes.get(axis).copied().unwrap_or(1);
        let mut more = sizes.iter().skip(3);
        let volumes = more.try_fold(1_u64, |count, &n| count.checked_mul(n));
        Ok(([size(0), size(1), size(2)], volumes.ok_or_else(wrong)?))
    }

    /// A last axis of size 3 may hold vectors: in three axes if it is asked for, in four likely.
    fn triples(&self, dims: [u64; 3], volumes: u64) -> Result<Option<Triples>, ReadFault> {
        const EXPECTED: &str = "'shape'";
        let (value, _) = self.value("shape", EXPECTED)?;
        let list = value.split(')').next().unwrap_or_default();
        let axes = list.split(',').filter(|size| !size.trim_matches(['(', ' ']).is_empty()).count();
        if dims[0] != 3 || !(3..=4).contains(&axes) {
            return Ok(None);
        }
        let fault = (axes == 4).then(|| {
            let says = format!(
                "an array of four axes, the last of size 3: {ADVICE}; --volume-index takes it for a list of \
                 volumes"
            );
            ReadFault::Caller(says.into())
        });
        let (layout, dims) = (Layout::Together, [dims[1], dims[2], volumes]);
        Ok(Some(Triples { layout, dims, fault, are_volumes: true }))
    }

    fn order(&self, dims: [u64; 3], volumes: u64) -> Result<Order, ReadFault> {
        const EXPECTED: &str = "'fortran_order' with True or False";
        let (value, at) = self.value("fortran_order", EXPECTED)?;
        match value {
            _ if value.starts_with("False") => Ok(Order::XFastest),
            _ if !value.starts_with("True") => Err(broken(at, EXPECTED, shown(value))),
            _ if volumes > 1 => {
                let (format, place) = (Format::Npy, Place::Byte(at as u64));
                let feature = "Fortran order with more than three axes".into();
                Err(ReadFault::Unsupported { format, place, feature })
            }
            // Along a single axis there is only one order.
            _ if dims[1] == 1 && dims[2] == 1 => Ok(Order::XFastest),
            _ => Ok(Order::ZFastest),
        }
    }
}

/// Version 1, C order, the dictionary padded so that the samples are aligned.
pub(super) fn write(out: &mut impl Write, volume: &AnyVolume, job: &Job) -> Result<(), WriteFault> {
    let descr = match dtype(volume) {
        Dtype::U8 => "|u1",
        Dtype::I8 => "|i1",
        Dtype::U16 => "<u2",
        Dtype::I16 => "<i2",
        Dtype::U32 => "<u4",
        Dtype::I32 => "<i4",
        Dtype::F32 => "<f4",
        Dtype::F64 => "<f8",
    };
    let [x, y, z] = volume.grid().dims();
    let text =
        format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({z}, {y}, {x}), }}");
    let whole = (DICTIONARY[0] + text.len() + 1).next_multiple_of(64);
    let length = (whole - DICTIONARY[0]) as u16;
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(format!("{text:0$}\n", length as usize - 1).as_bytes())?;
    put_samples(out, volume, form(volume), job)
}

#[cfg(test)]
mod tests;
