//! What `voxelize` will do.

use super::{
    Stream,
    places::Places,
    target::{is_color_volume, is_volume, no_color_volume, no_volume},
};
use crate::{
    args::{ModeArg, VoxelizeArgs},
    fault::UsageError,
};
use anyhow::Result;
use isokit::{
    io::volume_files,
    solid::{VoxelMode, VoxelOptions, Walls},
};
use std::path::PathBuf;

/// Everything that `voxelize` needs to know.
#[derive(Debug)]
pub(crate) struct VoxelizePlan {
    pub(crate) input: PathBuf,
    pub(crate) spacing: [f64; 3],
    pub(crate) margin: u32,
    pub(crate) options: VoxelOptions,
    pub(crate) output: PathBuf,
    /// Where colours go.
    pub(crate) colors: Option<PathBuf>,
}

impl VoxelizePlan {
    pub(crate) fn new(args: VoxelizeArgs) -> Result<Self> {
        let VoxelizeArgs { mesh, spacing, mode, band, conservative, margin, output, colors } = args;
        Stream::named(&output)?;
        if !is_volume(&output) {
            return Err(no_volume(&output).into());
        }
        let mut places = Places::of_input(&mesh);
        volume_files(&output).iter().try_for_each(|file| places.add("--output", file))?;
        if let Some(colors) = &colors {
            Stream::named(colors)?;
            if !is_color_volume(colors) {
                return Err(no_color_volume(colors).into());
            }
            volume_files(colors).iter().try_for_each(|file| places.add("--colors", file))?;
        }
        if band.is_some() && mode == ModeArg::Occupancy {
            let says = "--band is for distances: leave it out with --mode occupancy";
            return Err(UsageError(says.into()).into());
        }
        let mut options = VoxelOptions::default();
        options.mode = match mode {
            ModeArg::Distance => VoxelMode::Distance,
            ModeArg::Occupancy => VoxelMode::Occupancy,
        };
        options.band = band;
        options.walls = if conservative { Walls::Kept } else { Walls::AsTheyAre };
        Ok(Self { input: mesh, spacing: spacing.0, margin, options, output, colors })
    }
}
