//! What `extract` will do.

use super::{MeshTarget, Stream, TextTarget, palette};
use crate::{
    args::{ExtractArgs, LevelArg},
    fault::UsageError,
};
use anyhow::Result;
use isokit::{
    io::VolumeOptions,
    marching_cubes::ExtractOptions,
    mesh::Rgba,
    pipeline::{IsoChoice, Normals, Region, SurfaceOptions, TargetSpace},
};
use std::{num::NonZeroUsize, path::PathBuf};

/// Everything that `extract` needs to know.
#[derive(Debug)]
pub(crate) struct ExtractPlan {
    pub(crate) input: PathBuf,
    pub(crate) volume: VolumeOptions,
    pub(crate) region: Region,
    pub(crate) space: TargetSpace,
    pub(crate) levels: Vec<LevelPlan>,
    pub(crate) surface: SurfaceOptions,
    pub(crate) target: MeshTarget,
    pub(crate) index: bool,
    pub(crate) report: Option<TextTarget>,
    pub(crate) repeat: Repeat,
    /// Bytes that the process may hold; then it works slice by slice.
    pub(crate) max_memory: Option<u64>,
}

/// One surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LevelPlan {
    pub(crate) iso: IsoChoice,
    /// If there is none, the surface is named by its isovalue.
    pub(crate) name: Option<String>,
    pub(crate) color: Option<Rgba>,
}

/// How often the same is extracted, for its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Repeat {
    Once,
    /// Each time into fresh memory.
    Cold(NonZeroUsize),
    /// Each time into used memory.
    Warm(NonZeroUsize),
}

impl ExtractPlan {
    pub(crate) fn new(args: ExtractArgs) -> Result<Self> {
        let target = MeshTarget::new(&args.output, args.iso.len())?;
        let report = args.report.as_deref().map(Stream::named).transpose()?;
        if report == Some(Stream::Stdout) && target.stream == Stream::Stdout {
            let says = "mesh and report cannot both go to stdout: name a file for one of them";
            return Err(UsageError(says.into()).into());
        }
        // One answer, so far: a new one must be handed on here.
        let extract = ExtractOptions::DEFAULT
            .with_boundary(args.boundary.into())
            .with_topology(args.topology.into())
            .with_degenerate(args.degenerate.into())
            .with_placement(args.placement.into())
            .with_nan(args.nan.into());
        let surface =
            SurfaceOptions::default().with_extract(extract).with_normals(args.normals.into());
        let repeat = match (args.repeat, args.repeat_warm) {
            (_, Some(times)) => Repeat::Warm(times),
            (Some(times), None) => Repeat::Cold(times),
            (None, None) => Repeat::Once,
        };
        if args.max_memory.is_some() {
            check_slabs(&target, &surface, repeat)?;
        }
        Ok(Self {
            volume: args.volume.options(),
            input: args.volume_file,
            region: args.roi.or(args.roi_mm).unwrap_or_default(),
            space: args.space.into(),
            levels: levels(args.iso),
            surface,
            target,
            index: args.index,
            report,
            repeat,
            max_memory: args.max_memory,
        })
    }
}

/// What does not fit together with slices that pass by.
fn check_slabs(
    target: &MeshTarget,
    surface: &SurfaceOptions,
    repeat: Repeat,
) -> Result<(), UsageError> {
    let says = match (&target.stream, surface.normals, repeat) {
        (Stream::Stdout, ..) => {
            "--max-memory needs a file, whose beginning is written last: name one with -o"
        }
        (_, Normals::Area, _) => {
            "--normals area needs the whole mesh in memory: leave out either it or --max-memory"
        }
        (.., Repeat::Cold(_) | Repeat::Warm(_)) => {
            "--repeat times an extraction in memory: leave out either it or --max-memory"
        }
        _ => return Ok(()),
    };
    Err(UsageError(says.into()))
}

/// Of several surfaces each gets a colour. A single one is left to the viewer.
fn levels(args: Vec<LevelArg>) -> Vec<LevelPlan> {
    let is_one = args.len() == 1;
    let plan = |(n, LevelArg { iso, name, color }): (usize, LevelArg)| {
        let default = (!is_one).then(|| palette::color(n));
        LevelPlan { iso, name, color: color.or(default) }
    };
    args.into_iter().enumerate().map(plan).collect()
}
