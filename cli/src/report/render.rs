//! What `render` computed, and what not.

use super::{VolumeFacts, peak_rss_bytes, simd};
use crate::scene_file::ModeWord;
use isokit::{
    pipeline::Lattice,
    render::{Cast, Drawn, Splatted, Traced},
    scene::{Needs, SurfaceLook, SurfaceNeed, Unneeded},
};
use serde::Serialize;
use std::{ops::Range, path::PathBuf};

/// What `render --report` writes.
#[derive(Debug, Serialize)]
pub(crate) struct RenderReport<'a> {
    pub(crate) schema: &'static str,
    pub(crate) command: &'a str,
    pub(crate) input: RenderInput,
    pub(crate) mode: &'static str,
    pub(crate) size: [u32; 2],
    pub(crate) surfaces: Vec<DrawnSurface>,
    pub(crate) outputs: Vec<PathBuf>,
    pub(crate) samples: Option<ReadSamples>,
    pub(crate) skipped: RenderSkipped,
    pub(crate) timings_s: RenderTimings,
    pub(crate) threads: usize,
    pub(crate) simd: &'static str,
    pub(crate) peak_rss_bytes: Option<u64>,
    pub(crate) version: &'static str,
}

/// What was looked at.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(crate) enum RenderInput {
    Volume(Box<VolumeFacts>),
    Mesh { path: String },
}

/// Which samples are read.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ReadSamples {
    /// Of the file.
    pub(crate) all: u64,
    /// Of the part that is looked at.
    pub(crate) of_part: u64,
    pub(crate) read: u64,
    /// First one and one after the last along x, y, z.
    pub(crate) ranges: [[u64; 2]; 3],
    /// Why no fewer are, if that is not because the picture shows them.
    pub(crate) why: Option<&'static str>,
}

/// One surface.
#[derive(Debug, Serialize)]
pub(crate) struct DrawnSurface {
    pub(crate) name: String,
    pub(crate) iso: Option<f64>,
    pub(crate) opacity: f32,
    /// As many as were extracted or read.
    pub(crate) triangles: u64,
}

/// What was not computed, of all pictures together.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct RenderSkipped {
    /// Bricks of the volume.
    pub(crate) bricks: u64,
    /// Those that hold no surface that can be seen, or nothing that rays can show.
    pub(crate) bricks_skipped: u64,
    /// Samples of the volume; for splats once for each picture.
    pub(crate) samples: u64,
    /// Those that planes cut away from all surfaces, that no picture shows, or that give nothing to a picture of splats.
    pub(crate) samples_skipped: u64,
    /// How often samples were halved along x, y, z because pixels do not show them.
    pub(crate) halvings: [u32; 3],
    /// Bricks in which surfaces were lost by that.
    pub(crate) bricks_lost: u64,
    /// Surfaces that were not made, and why.
    pub(crate) surfaces: Vec<SkippedSurface>,
    /// Triangles that were put into the picture.
    pub(crate) triangles: u64,
    /// Triangles beside it, cut away or invisible.
    pub(crate) triangles_skipped: u64,
    /// How often a triangle was not looked at in a part of a picture, behind all that is opaque there.
    pub(crate) triangles_hidden: u64,
    /// Points of other translucent triangles behind what is opaque.
    pub(crate) points_hidden: u64,
    /// Steps of rays at which a value was looked at.
    pub(crate) steps: u64,
    /// Steps through bricks of which nothing can be seen.
    pub(crate) steps_leapt: u64,
    /// Steps behind what is opaque.
    pub(crate) steps_hidden: u64,
    /// How often a pixel was cast again with shorter steps.
    pub(crate) pixels_refined: u64,
    /// How often a sample was laid on a sheet.
    pub(crate) splats: u64,
    /// Sheets behind what is opaque, once for each part of a picture.
    pub(crate) sheets_hidden: u64,
    /// Cells in which rays looked for surfaces.
    pub(crate) cells: u64,
    /// How often a ray passed a brick that no surface goes through.
    pub(crate) bricks_passed: u64,
}

/// A surface that was not made.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SkippedSurface {
    /// Which one of the scene's.
    #[serde(skip)]
    pub(crate) number: usize,
    pub(crate) name: String,
    pub(crate) why: String,
}

/// Seconds per step.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct RenderTimings {
    /// From the file to samples or triangles in memory.
    pub(crate) read: f64,
    /// From samples to surfaces.
    pub(crate) extract: f64,
    /// From there to pictures in memory.
    pub(crate) render: f64,
    /// From there to files.
    pub(crate) write: f64,
    /// All of it.
    pub(crate) total: f64,
}

impl RenderReport<'_> {
    /// What can be said of every run.
    pub(crate) fn new(command: &str, input: RenderInput) -> RenderReport<'_> {
        RenderReport {
            schema: "isokit.render/1",
            command,
            input,
            mode: "surfaces",
            size: [0; 2],
            surfaces: vec![],
            outputs: vec![],
            samples: None,
            skipped: RenderSkipped::default(),
            timings_s: RenderTimings::default(),
            threads: 0,
            simd: simd(),
            peak_rss_bytes: peak_rss_bytes(),
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

impl ReadSamples {
    /// What of a lattice is read.
    pub(crate) fn of(
        lattice: &Lattice,
        ranges: &[Range<usize>; 3],
        why: Option<&'static str>,
    ) -> Self {
        let read = ranges.iter().map(|range| range.len() as u64).product();
        let ranges = ranges.each_ref().map(|range| [range.start as u64, range.end as u64]);
        let all = lattice.whole().count();
        Self { all, of_part: lattice.count(), read, ranges, why }
    }
}

impl RenderSkipped {
    /// What is known before anything is drawn. Of splats it is known afterwards which samples are skipped.
    pub(crate) fn of(needs: &Needs, mode: ModeWord) -> Self {
        let skipped = |(number, need): (usize, &SurfaceNeed)| {
            let why = need.part.as_ref().err()?.to_string();
            Some(SkippedSurface { number, name: need.name.clone(), why })
        };
        Self {
            bricks: needs.bricks,
            bricks_skipped: needs.bricks_skipped,
            samples: if mode == ModeWord::Splat { 0 } else { needs.samples },
            samples_skipped: if mode == ModeWord::Splat { 0 } else { needs.samples_skipped },
            surfaces: needs.surfaces.iter().enumerate().filter_map(skipped).collect(),
            ..Self::default()
        }
    }

    /// Notes a surface that lies behind opaque ones, which is known once those are made.
    pub(crate) fn add_hidden(&mut self, number: usize, look: &SurfaceLook) {
        let (name, why) = (look.name.clone(), Unneeded::Hidden.to_string());
        self.surfaces.push(SkippedSurface { number, name, why });
    }

    pub(crate) fn add_drawn(&mut self, drawn: &Drawn) {
        self.triangles += drawn.triangles;
        self.triangles_skipped += drawn.triangles_skipped;
        self.triangles_hidden += drawn.triangles_hidden;
        self.points_hidden += drawn.hidden;
    }

    pub(crate) fn add_traced(&mut self, traced: &Traced) {
        self.cells += traced.cells;
        self.bricks_passed += traced.bricks_passed;
    }

    pub(crate) fn add_splatted(&mut self, splatted: &Splatted) {
        self.splats += splatted.splats;
        self.samples += splatted.samples;
        self.samples_skipped += splatted.samples_skipped;
        self.sheets_hidden += splatted.sheets_hidden;
    }

    pub(crate) fn add_cast(&mut self, cast: &Cast) {
        self.steps += cast.steps;
        self.steps_leapt += cast.steps_leapt;
        self.steps_hidden += cast.steps_hidden;
        self.pixels_refined += cast.pixels_refined;
    }
}
