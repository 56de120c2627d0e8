//! What `sample` will do.

use super::{
    Stream,
    places::Places,
    target::{is_volume, no_volume},
};
use crate::{
    args::{FloatArg, SampleArgs},
    fault::UsageError,
    shape_file::is_shape,
};
use anyhow::Result;
use isokit::io::volume_files;
use std::path::PathBuf;

/// Everything that `sample` needs to know.
#[derive(Debug)]
pub(crate) struct SamplePlan {
    pub(crate) input: PathBuf,
    pub(crate) spacing: [f64; 3],
    pub(crate) dtype: FloatArg,
    pub(crate) output: PathBuf,
}

impl SamplePlan {
    pub(crate) fn new(args: SampleArgs) -> Result<Self> {
        let SampleArgs { file, spacing, dtype, output } = args;
        if !is_shape(&file) {
            let says = format!("{}: a shape is a .toml or a .json", file.display());
            return Err(UsageError(says).into());
        }
        Stream::named(&output)?;
        if !is_volume(&output) {
            return Err(no_volume(&output).into());
        }
        let mut places = Places::of_input(&file);
        volume_files(&output).iter().try_for_each(|file| places.add("--output", file))?;
        Ok(Self { input: file, spacing: spacing.0, dtype, output })
    }
}
