//! What can be said of a volume.

use isokit::{
    io::{ColorFile, Format},
    pipeline::{Scan, ScanFile, SlabScan},
    volume::{Dtype, Grid, Scaling, Statistics},
};
use serde::Serialize;
use std::{ops::Range, path::Path};

/// A volume in a report.
#[derive(Debug, Serialize)]
pub(crate) struct VolumeFacts {
    pub(crate) path: String,
    pub(crate) format: &'static str,
    pub(crate) dims: [u64; 3],
    pub(crate) dtype: &'static str,
    /// What a stored sample means: value = stored · slope + intercept.
    pub(crate) slope: f64,
    pub(crate) intercept: f64,
    pub(crate) spacing: [f64; 3],
    pub(crate) index_to_world: [[f64; 4]; 4],
    pub(crate) unit: String,
    pub(crate) space: String,
    /// First sample and one after the last along x, y, z, where only a part was looked at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) roi: Option<[[u64; 2]; 3]>,
    /// The same of the samples that were read, where a picture needs no others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) read: Option<[[u64; 2]; 3]>,
    /// Of the part, like all that follows, as far as it was read; null if it has no value.
    pub(crate) range: Option<[f64; 2]>,
    pub(crate) nan: u64,
    pub(crate) infinite: u64,
    /// What was assumed, overridden or ignored on reading.
    pub(crate) notes: Vec<String>,
}

/// What `info --json` prints of a volume.
#[derive(Debug, Serialize)]
pub(crate) struct VolumeReport<'a> {
    pub(crate) schema: &'static str,
    pub(crate) kind: &'static str,
    #[serde(flatten)]
    pub(crate) facts: VolumeFacts,
    /// What values are in, in the file's own words; null if it does not say.
    pub(crate) sample_unit: Option<&'a str>,
    /// Otsu's; null if all samples have one value.
    pub(crate) suggested_iso: Option<f64>,
}

/// What `info --json` prints of a volume of colours.
#[derive(Debug, Serialize)]
pub(crate) struct ColorVolumeReport {
    pub(crate) schema: &'static str,
    pub(crate) kind: &'static str,
    path: String,
    format: &'static str,
    dims: [u64; 3],
    dtype: &'static str,
    /// How many numbers a colour has; the fourth is its opacity.
    channels: usize,
    spacing: [f64; 3],
    index_to_world: [[f64; 4]; 4],
    unit: String,
    space: String,
    notes: Vec<String>,
}

impl ColorVolumeReport {
    pub(crate) fn of(path: &Path, file: &ColorFile) -> Self {
        let grid = file.grid();
        let affine = grid.frame.index_to_world;
        Self {
            schema: "isokit.info/1",
            kind: "volume of colors",
            path: path.display().to_string(),
            format: file.format().name(),
            dims: grid.dims(),
            dtype: Dtype::U8.name(),
            channels: file.channels().count(),
            spacing: affine.spacing(),
            index_to_world: affine.rows(),
            unit: grid.frame.unit.to_string(),
            space: grid.frame.space.to_string(),
            notes: file.notes().to_vec(),
        }
    }
}

impl VolumeFacts {
    pub(crate) fn of(path: &Path, scan: &Scan, statistics: &Statistics) -> Self {
        let volume = scan.volume();
        let format = scan.format().map_or("memory", Format::name);
        let lattice = (scan.lattice().whole(), volume.scaling(), volume.dtype());
        let part = scan.is_cropped().then(|| scan.part());
        let read = scan.is_read_in_part().then(|| scan.samples_read().map(ends));
        let notes = scan.notes().to_vec();
        Self { notes, read, ..Self::of_part(path, format, lattice, part, statistics) }
    }

    /// The same of a scan of which no sample was read.
    pub(crate) fn of_file(path: &Path, file: &ScanFile) -> Self {
        let lattice = file.lattice();
        let part = lattice.is_cropped().then(|| lattice.part());
        let of = (lattice.whole(), file.scaling(), file.dtype());
        let (notes, read) = (file.notes().to_vec(), Some([[0, 0]; 3]));
        let nothing = Statistics { range: None, nan: 0, first_nan: None, infinite: 0 };
        Self { notes, read, ..Self::of_part(path, file.format().name(), of, part, &nothing) }
    }

    /// The same of a scan that stays in its file.
    pub(crate) fn of_slabs(path: &Path, scan: &SlabScan, statistics: &Statistics) -> Self {
        let lattice = (scan.grid(), scan.scaling(), scan.dtype());
        let part = scan.is_cropped().then(|| scan.part());
        let notes = scan.notes().to_vec();
        Self { notes, ..Self::of_part(path, scan.format().name(), lattice, part, statistics) }
    }

    /// The same of a shape, of which only some samples are made.
    pub(crate) fn of_shape(path: &Path, grid: &Grid) -> Self {
        let statistics = Statistics { range: None, nan: 0, first_nan: None, infinite: 0 };
        let lattice = (grid, Scaling::IDENTITY, Dtype::F32);
        Self::of_part(path, "shape", lattice, None, &statistics)
    }

    fn of_part(
        path: &Path,
        format: &'static str,
        (grid, scaling, dtype): (&Grid, Scaling, Dtype),
        part: Option<[Range<usize>; 3]>,
        statistics: &Statistics,
    ) -> Self {
        let affine = grid.frame.index_to_world;
        Self {
            path: path.display().to_string(),
            format,
            dims: grid.dims(),
            dtype: dtype.name(),
            slope: scaling.slope(),
            intercept: scaling.intercept(),
            spacing: affine.spacing(),
            index_to_world: affine.rows(),
            unit: grid.frame.unit.to_string(),
            space: grid.frame.space.to_string(),
            roi: part.map(|part| part.map(ends)),
            read: None,
            range: statistics.range,
            nan: statistics.nan,
            infinite: statistics.infinite,
            notes: vec![],
        }
    }
}

fn ends(range: Range<usize>) -> [u64; 2] {
    [range.start as u64, range.end as u64]
}
