//! What `voxelize` takes.

use super::{Triple, values};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

#[derive(Args, Debug)]
pub(crate) struct VoxelizeArgs {
    /// The mesh
    pub(crate) mesh: PathBuf,
    /// How far samples are to be from each other along x, y, z, or along all three, in the mesh's unit
    #[arg(long, value_name = "X[,Y,Z]", value_parser = values::spacing, allow_hyphen_values = true)]
    pub(crate) spacing: Triple<f64>,
    /// What samples say: distance to the surface, positive inside; or 1 inside and 0 outside
    #[arg(long, value_enum, default_value_t)]
    pub(crate) mode: ModeArg,
    /// How far from the surface distances are told, in the mesh's unit; farther out there is this one. Takes less time
    /// [default: everywhere]
    #[arg(long, value_name = "DISTANCE", value_parser = values::length, allow_negative_numbers = true)]
    pub(crate) band: Option<f64>,
    /// Keep walls that are thinner than samples are apart: what is no farther from the solid than half a cell's diagonal is
    /// inside too
    #[arg(long)]
    pub(crate) conservative: bool,
    /// Samples beyond the mesh, on each side
    #[arg(long, value_name = "N", default_value_t = 2, allow_negative_numbers = true)]
    pub(crate) margin: u32,
    /// The file to write; its extension decides the format
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Another file, .nrrd or .nhdr, for the colour of the nearest point of the mesh at each sample: three bytes, or four
    /// where something shows through. `isokit extract --attribute` gives them back to vertices. With --band, samples that
    /// are farther out than that and a cell's diagonal are black
    #[arg(long, value_name = "FILE")]
    pub(crate) colors: Option<PathBuf>,
}

/// What samples say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ModeArg {
    #[default]
    Distance,
    Occupancy,
}
