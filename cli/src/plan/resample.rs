//! What `resample` will do.

use super::{
    Stream,
    places::Places,
    target::{is_volume, no_volume},
};
use crate::{args::ResampleArgs, fault::UsageError};
use anyhow::Result;
use isokit::{
    field::Filter,
    io::{VolumeOptions, volume_files},
};
use std::path::PathBuf;

/// Everything that `resample` needs to know.
#[derive(Debug)]
pub(crate) struct ResamplePlan {
    pub(crate) input: PathBuf,
    pub(crate) options: VolumeOptions,
    pub(crate) filter: Filter,
    pub(crate) spacing: [f64; 3],
    pub(crate) output: PathBuf,
}

impl ResamplePlan {
    pub(crate) fn new(args: ResampleArgs) -> Result<Self> {
        let ResampleArgs { file, spacing, kernel, smoothing, output, input_spacing, volume } = args;
        Stream::named(&output)?;
        if !is_volume(&output) {
            return Err(no_volume(&output).into());
        }
        let mut places = Places::of_input(&file);
        volume_files(&output).iter().try_for_each(|file| places.add("--output", file))?;
        let filter = match smoothing {
            true if kernel.smoothing() == kernel => {
                let says = "--smoothing is for quadratic-bspline and cubic-bspline: leave it out";
                return Err(UsageError(says.into()).into());
            }
            true => kernel.smoothing(),
            false => kernel,
        };
        let options = volume.options(input_spacing);
        Ok(Self { input: file, options, filter, spacing: spacing.0, output })
    }
}
