//! Samples without a header, as the caller describes them.
//!
//! The size of the file must be just that of the samples: it is all there is to check a description by.

use super::{
    Described, RawLayout,
    stored::{Skip, Stored},
    vectors::ALONG_AXES,
};
use crate::{Format, ReadError, ReadFault};
use isokit_geom::{Affine, Space, Unit};
use isokit_volume::Scaling;
use std::path::Path;

pub(super) fn describe(path: &Path, layout: RawLayout) -> Result<Described, ReadError> {
    let stored = Stored::attached(Format::Raw, path, 0, layout.dtype);
    let skip = Skip::Bytes(layout.skip);
    Ok(Described {
        dims: layout.dims,
        volumes: 1,
        affine: Ok(Affine::IDENTITY),
        has_geometry: false,
        unit: Unit::Unknown,
        space: Space::Unknown,
        scaling: Scaling::IDENTITY,
        stored: Stored { skip, endian: layout.endian, ends: true, ..stored },
        colored: None,
        triples: None,
        to_world: Ok(ALONG_AXES),
        sample_unit: None,
        notes: vec![],
    })
}

/// More bytes than the samples need.
pub(super) fn too_long(stored: &Stored, more: u64) -> ReadFault {
    let needed = stored.least_bytes(stored.per_file);
    let found = needed.saturating_add(more);
    let fault = format!("sizes and sample type describe {needed} bytes, the file has {found}");
    ReadFault::Caller(fault.into())
}

/// Fewer bytes than the samples need.
pub(super) fn too_short(needed: u64, held: u64, skip: Skip) -> ReadFault {
    let after = match skip {
        Skip::Bytes(skip) if skip > 0 => format!(" after {skip} that are skipped"),
        _ => String::new(),
    };
    let fault =
        format!("sizes and sample type describe {needed} bytes, the file has {held}{after}");
    ReadFault::Caller(fault.into())
}

/// A name ends in `.raw`, and nobody said what is in the file.
pub(super) fn needs_layout(path: &Path) -> ReadError {
    let fault = "a file without header: give its sizes and sample type (--dims, --dtype)";
    ReadFault::Caller(fault.into()).at(path)
}
