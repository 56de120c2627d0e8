//! What `sample` takes.

use super::values::{self, Triple};
use clap::Args;
use std::path::PathBuf;

/// Make a volume of a shape that a file describes
///
/// Samples are above 0 inside, 0 on the surface, and lengths in world units: `isokit extract VOLUME --iso 0` gives the
/// surface.
#[derive(Args, Debug)]
#[command(after_help = "\
Example:
  isokit sample bracket.toml --spacing 0.5 -o bracket.nrrd
  isokit extract bracket.nrrd --iso 0 -o bracket.stl

A shape file, here a plate with four holes:

  unit = \"mm\"

  [shape]
  difference = [\"plate\", \"holes\"]

  [part.plate]
  box = { size = [40, 30, 4], round = 1 }

  [part.holes]
  cylinder = { radius = 2, height = 10 }
  array = { count = [2, 2, 1], step = [28, 18, 0], center = true }

Shapes: sphere box cylinder cone torus capsule plane gyroid schwarz_p schwarz_d neovius iwp formula part, and union
intersection difference with blend. What is done with one, in this order: offset shell scale mirror rotate move array.
The guide has all of it. Volumes are .nrrd .nhdr .nii .nii.gz .npy .raw.")]
pub(crate) struct SampleArgs {
    /// The shape: .toml or .json
    pub(crate) file: PathBuf,
    /// How far samples are to be from each other along x, y, z, or along all three, in the shape's unit
    #[arg(long, value_name = "X[,Y,Z]", value_parser = values::spacing, allow_hyphen_values = true)]
    pub(crate) spacing: Triple<f64>,
    /// What samples are stored as
    #[arg(long, value_enum, default_value_t, value_name = "TYPE")]
    pub(crate) dtype: FloatArg,
    /// The file to write; its extension decides the format
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
}

/// A type of samples with a fraction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum FloatArg {
    /// 32 bits
    #[default]
    F32,
    /// 64 bits
    F64,
}
