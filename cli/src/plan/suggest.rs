//! What `suggest` will do.

use super::{Stream, is_png, places::Places};
use crate::{args::SuggestArgs, fault::UsageError};
use anyhow::Result;
use std::path::PathBuf;

/// What was typed, after a look at where the picture goes.
#[derive(Debug)]
pub(crate) struct SuggestPlan {
    pub(crate) args: SuggestArgs,
    pub(crate) plot: Option<PathBuf>,
}

impl SuggestPlan {
    pub(crate) fn new(mut args: SuggestArgs) -> Result<Self> {
        let plot = args.plot.take();
        if let Some(path) = &plot {
            if !is_png(path) {
                let says = "--plot: expected a name that ends in .png";
                return Err(UsageError(says.into()).into());
            }
            Stream::named(path)?;
            Places::of_input(&args.file).add("--plot", path)?;
        }
        Ok(Self { args, plot })
    }
}
