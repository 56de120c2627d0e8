//! The facts, as the JSON that scripts read. Keys may be added, never renamed.
//!
//! A number that is not finite is `null`, since JSON has none.

mod color;
mod layout;
mod mesh;
mod refine;
mod render;
mod suggest;
mod system;
mod timings;
mod volume;

pub(crate) use color::{AttributeReport, ColorMapReport, ColorReport, TextureReport};
use layout::Layout;
pub(crate) use mesh::{
    CheckReport, MeshCounts, MeshReport, SlabCounts, SurfaceBrief, SurfaceReport, around,
};
pub(crate) use refine::RefineReport;
pub(crate) use render::{
    DrawnSurface, ReadSamples, RenderInput, RenderReport, RenderSkipped, RenderTimings,
};
pub(crate) use suggest::{PERCENTS, SuggestReport};
pub(crate) use system::{peak_rss_bytes, simd};
pub(crate) use timings::{Timings, median, timed};
pub(crate) use volume::{ColorVolumeReport, VolumeFacts, VolumeReport};

use isokit::marching_cubes::Skipped;
use serde::Serialize;
use std::path::PathBuf;

/// What `extract --report` writes.
#[derive(Debug, Serialize)]
pub(crate) struct ExtractReport<'a, C = MeshCounts> {
    pub(crate) schema: &'static str,
    pub(crate) command: &'a str,
    pub(crate) input: VolumeFacts,
    pub(crate) surfaces: Vec<SurfaceReport<C>>,
    /// What vertices carry besides their place, if anything.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) vertex_colors: Option<ColorReport>,
    pub(crate) outputs: &'a [PathBuf],
    pub(crate) warnings: &'a [String],
    /// Vertices that a reader will take for one, because the format rounds their places to the same.
    pub(crate) merged_vertices: u64,
    pub(crate) skipped: SkippedReport,
    pub(crate) timings_s: Timings,
    pub(crate) threads: usize,
    pub(crate) simd: &'static str,
    pub(crate) peak_rss_bytes: Option<u64>,
    pub(crate) version: &'static str,
}

/// What `extract --report` calls itself.
pub(crate) const EXTRACT_SCHEMA: &str = "isokit.extract/1";

/// What was not computed because no output needs it.
#[derive(Debug, Serialize)]
pub(crate) struct SkippedReport {
    /// With an index, bricks of the volume.
    bricks: u64,
    /// Those of which no sample was compared.
    bricks_skipped: u64,
    /// With an index, samples that were compared; without, all.
    samples_read: u64,
}

impl From<Skipped> for SkippedReport {
    fn from(Skipped { bricks, bricks_skipped, samples_read }: Skipped) -> Self {
        Self { bricks, bricks_skipped, samples_read }
    }
}

/// The object as text.
pub(crate) fn to_json(report: &impl Serialize) -> serde_json::Result<String> {
    let mut text = vec![];
    let mut serializer = serde_json::Serializer::with_formatter(&mut text, Layout::default());
    report.serialize(&mut serializer)?;
    text.push(b'\n');
    Ok(String::from_utf8_lossy(&text).into_owned())
}
