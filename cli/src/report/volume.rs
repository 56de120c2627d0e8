//! What can be said of a volume.

use isokit::{
    io::Format,
    pipeline::Scan,
    volume::{AnyVolume, Statistics},
};
use serde::Serialize;
use std::path::Path;

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
    /// Of the part, like all that follows; null if it has no value.
    pub(crate) range: Option<[f64; 2]>,
    pub(crate) nan: u64,
    pub(crate) infinite: u64,
    /// What was assumed, overridden or ignored on reading.
    pub(crate) notes: Vec<String>,
}

/// What `info --json` prints of a volume.
#[derive(Debug, Serialize)]
pub(crate) struct VolumeReport {
    pub(crate) schema: &'static str,
    pub(crate) kind: &'static str,
    #[serde(flatten)]
    pub(crate) facts: VolumeFacts,
    /// Otsu's; null if all samples have one value.
    pub(crate) suggested_iso: Option<f64>,
}

impl VolumeFacts {
    pub(crate) fn of(path: &Path, scan: &Scan, statistics: &Statistics) -> Self {
        let format = scan.format().map_or("memory", Format::name);
        let part = scan.part().map(|range| [range.start as u64, range.end as u64]);
        Self {
            roi: scan.is_cropped().then_some(part),
            range: statistics.range,
            nan: statistics.nan,
            infinite: statistics.infinite,
            notes: scan.notes().to_vec(),
            ..Self::of_header(path, format, scan.volume())
        }
    }

    fn of_header(path: &Path, format: &'static str, volume: &AnyVolume) -> Self {
        let (grid, scaling) = (volume.grid(), volume.scaling());
        let affine = grid.frame.index_to_world;
        Self {
            path: path.display().to_string(),
            format,
            dims: grid.dims(),
            dtype: volume.dtype().name(),
            slope: scaling.slope(),
            intercept: scaling.intercept(),
            spacing: affine.spacing(),
            index_to_world: affine.rows(),
            unit: grid.frame.unit.to_string(),
            space: grid.frame.space.to_string(),
            roi: None,
            range: None,
            nan: 0,
            infinite: 0,
            notes: vec![],
        }
    }
}
