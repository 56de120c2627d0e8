//! Volumes in files.
//!
//! A reader turns a header into a [`Described`]: sizes, sample type, place in the world, and where the
//! samples lie. One piece of code, [`FileSlices`], then fetches samples for all formats, slice by
//! slice, straight into their own type. Sizes are checked against the file, and against the job's
//! limit, before memory is taken for samples.
//!
//! | format | read | written |
//! | --- | --- | --- |
//! | NIfTI-1, NIfTI-2, Analyze 7.5 | `.nii`, `.hdr` + `.img` | `.nii`, `.nii.gz` |
//! | NRRD | `.nrrd`, `.nhdr` + data; raw, gzip, bzip2, text | `.nrrd`, `.nhdr` + `.raw` |
//! | MetaImage | `.mha`, `.mhd` + data; raw, zlib, text | |
//! | NPY | versions 1 to 3, C and Fortran order | version 1, C order |
//! | raw | as described by [`RawLayout`] | samples, x fastest |
//!
//! One layer of gzip or bzip2 around any of them is taken off. Of vectors of three numbers a
//! [`Quantity`] is read, if one is asked for; three or four bytes per sample, of NRRD and MetaImage, are read as colours
//! by [`open_colors`], and written as NRRD. Samples of 64-bit integers, half floats, complex numbers, other
//! colours and other vectors are refused by name.

mod bricks;
mod colors;
mod files;
mod metaimage;
mod nifti;
mod npy;
mod nrrd;
mod open;
mod place;
mod raw;
mod slices;
mod stored;
mod vectors;
mod write;

pub use bricks::{BrickFile, NoBricks};
pub use colors::{ColorFile, open_colors};
pub use open::{VolumeFile, open_volume, read_volume};
pub use slices::{FileSlices, PartSlices};
pub use write::{
    Prepared, prepare_colors, prepare_volume, volume_files, write_colors, write_volume,
};

use crate::{Endian, Format, ReadFault};
use colors::Colored;
use isokit_geom::vector::Vector;
use isokit_geom::{Affine, Space, Unit};
use isokit_volume::{AnyVolume, Dtype, Quantity, Scaling};
use stored::Stored;
use vectors::Triples;

/// What a headerless file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RawLayout {
    /// Samples along x, y, z; x is fastest.
    pub dims: [u64; 3],
    /// The type of a sample.
    pub dtype: Dtype,
    /// The order of a sample's bytes.
    pub endian: Endian,
    /// Bytes before the first sample.
    pub skip: u64,
}

/// What the caller knows better than the file, or what the file does not say.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct VolumeOptions {
    /// Which volume of a file that holds several. Default: the first, and a note says so.
    pub volume_index: Option<u64>,
    /// Reads the file as samples without a header. Default: the file has one.
    pub raw: Option<RawLayout>,
    /// Distance between samples along x, y, z. Default: as the file says, or 1. Keeps the directions
    /// of the axes; a note names what it overrides.
    pub spacing: Option<[f64; 3]>,
    /// Place of the first sample. Default: as the file says, or 0. A note names what it overrides.
    pub origin: Option<[f64; 3]>,
    /// What is read of a file of vectors, three numbers per sample. Default: nothing; such a file is refused.
    pub quantity: Option<Quantity>,
}

/// A volume read from a file.
#[derive(Clone, Debug)]
pub struct VolumeInput {
    /// Samples in the file's own type, with their place and meaning.
    pub volume: AnyVolume,
    /// What the file is.
    pub format: Format,
    /// What was assumed, overridden or ignored, each a sentence for the user.
    pub notes: Vec<String>,
}

/// What a header says.
struct Described {
    dims: [u64; 3],
    /// How many volumes follow each other.
    volumes: u64,
    /// From samples to the world. A fault in it counts only if the caller gives no spacing.
    affine: Result<Affine, ReadFault>,
    /// Whether the format can say where samples are.
    has_geometry: bool,
    unit: Unit,
    space: Space,
    scaling: Scaling,
    stored: Stored,
    /// What values are in, in the file's own words, where it says so.
    sample_unit: Option<String>,
    /// Samples of three numbers, where the header says so.
    triples: Option<Triples>,
    /// Samples of three or four bytes, where the header says so: colours, or bytes that may be some.
    colored: Option<Colored>,
    /// What takes vectors as they are stored to the world, as columns; a fault only for who asks for vectors.
    to_world: Result<[Vector; 3], ReadFault>,
    notes: Vec<String>,
}

/// How messages name several volumes, of each of which the samples are several numbers; none if they are not so.
fn several(
    volumes: u64,
    triples: Option<&Triples>,
    colored: Option<&Colored>,
) -> Option<&'static str> {
    let says = match (triples, colored) {
        (Some(_), Some(_)) => "several volumes of vectors or colours",
        (Some(_), None) => "several volumes of vectors",
        (None, Some(_)) => "several volumes of colours",
        (None, None) => return None,
    };
    (volumes > 1).then_some(says)
}

/// How messages name samples that have a lawful type, but none of ours.
fn sample_feature(name: &str) -> String {
    match name {
        "int64" | "uint64" => {
            format!("sample type {name} (64-bit integers; convert to i32 or f64)")
        }
        _ => format!("sample type {name}"),
    }
}
