//! What was typed. Every option is defined here or below, once: help, completions and man pages are made
//! from the same definition.
//!
//! Parsing a word needs nothing but the word. Whether words fit together is for [`plan`](crate::plan) to
//! say.

mod choices;
mod clip;
mod color;
mod extract;
mod memory;
mod output;
mod render;
mod sample;
mod shades;
mod values;
mod volume;
mod voxelize;

pub(crate) use choices::{
    BetweenArg, BoundaryArg, DegenerateArg, DiagonalsArg, MeshFormat, NanArg, NormalsArg,
    PlacementArg, ProgressArg, SpaceArg, TopologyArg,
};
pub(crate) use clip::ClipArg;
pub(crate) use color::ColorArgs;
pub(crate) use extract::ExtractArgs;
pub(crate) use output::MeshOutputArgs;
pub(crate) use render::{LodWord, RenderArgs};
pub(crate) use sample::{FloatArg, SampleArgs};
pub(crate) use shades::{ColorMapArg, TextureArg};
pub(crate) use values::{LevelArg, SampleType, Triple};
pub(crate) use volume::{FileArgs, VolumeArgs};
pub(crate) use voxelize::{ModeArg, VoxelizeArgs};

use clap::{Args, Parser, Subcommand};
use isokit::field::Filter;
use std::{num::NonZeroUsize, path::PathBuf};

/// Turns scans and other volumes into meshes that are closed, oriented and in the right place.
#[derive(Debug, Parser)]
#[command(name = "isokit", version, max_term_width = 100, infer_long_args = false)]
#[command(after_help = "\
Example:
  isokit extract ct.nii.gz --iso 300 -o bone.glb

Exit status: 0 done, 1 it failed (the message says whose fault it is), 2 wrong usage,
3 `check` found a shortfall, 130 interrupted.")]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) common: CommonArgs,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// What every command takes.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Every command")]
pub(crate) struct CommonArgs {
    /// Threads to use [default: all]. The result does not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = values::count)]
    pub(crate) threads: Option<NonZeroUsize>,
    /// Whether to show on stderr how far the work is; auto: if that is a terminal
    #[arg(long, global = true, value_enum, default_value_t, value_name = "WHEN")]
    pub(crate) progress: ProgressArg,
    /// Say nothing but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    /// Say more: how long steps took, and what the mesh is as a surface
    #[arg(short, long, global = true)]
    pub(crate) verbose: bool,
    /// Write messages as JSON, one object a line, to stderr
    #[arg(long, global = true)]
    pub(crate) log_json: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Say what a volume or mesh file holds
    ///
    /// Of a volume: sizes, sample type, place in the world, range, NaN, a histogram, and a first isovalue
    /// to try. Of a mesh: its surfaces and their bounds.
    #[command(after_help = "\
Example:
  isokit info ct.nii.gz")]
    Info(InfoArgs),
    /// Say which isovalues of a volume are worth a look, and why
    ///
    /// Those that part the samples into classes, and those where much of a boundary runs, or a sharp one.
    #[command(after_help = "\
Examples:
  isokit suggest ct.nii.gz
  isokit suggest ct.nii.gz --plot values.png")]
    Suggest(SuggestArgs),
    /// Turn a volume into a mesh: the surface where the samples have a value
    Extract(Box<ExtractArgs>),
    /// Find out whether a mesh is closed, manifold, oriented and free of bad triangles
    ///
    /// Exit status 3 if it falls short of any; each shortfall is counted apart.
    #[command(after_help = "\
Example:
  isokit check bone.glb")]
    Check(CheckArgs),
    /// Write a volume or a mesh in another format, chosen by the output's extension
    #[command(after_help = "\
Examples:
  isokit convert scan.mha -o scan.nii.gz
  isokit convert bone.stl -o bone.glb --gltf-unit mm
  isokit convert flow.nrrd --quantity q-criterion -o vortices.nrrd

Volumes become .nrrd .nhdr .nii .nii.gz .npy .raw; meshes become .glb .gltf .obj .ply .stl.")]
    Convert(ConvertArgs),
    /// Write a volume with samples farther from each other, or nearer
    ///
    /// The first sample stays where it is, the last ones are no farther than the old ones. Where samples come
    /// farther from each other the kernel is as much wider, so that nothing takes the place of what they
    /// cannot hold.
    #[command(after_help = "\
Examples:
  isokit resample scan.nii.gz --spacing 1 -o even.nii.gz
  isokit resample stack.nrrd --spacing 0.2,0.2,0.5 --kernel lanczos3 -o fine.nrrd
  isokit resample labels.nii.gz --spacing 2 --kernel nearest -o small.nii.gz

Volumes become .nrrd .nhdr .nii .nii.gz .npy .raw, of f32 (nearest: of the type they had; of i32, u32 and f64: f64).")]
    Resample(ResampleArgs),
    Sample(SampleArgs),
    /// Turn a mesh into a volume: how far the surface is, or whether a sample is inside
    ///
    /// Distances are in the mesh's unit and positive inside, so that `isokit extract OUT --iso 0` gives the mesh back. Inside
    /// is where the surface winds around a sample half a time or more, either way round: meshes with holes, with faces that
    /// are twice there, turned over or go through each other have an inside too.
    #[command(after_help = "\
Examples:
  isokit voxelize part.stl --spacing 0.5 -o part.nrrd
  isokit voxelize part.stl --spacing 0.5 --band 2 -o part.nrrd
  isokit voxelize shell.ply --spacing 1 --mode occupancy --conservative -o shell.nii.gz
  isokit voxelize painted.ply --spacing 0.5 -o part.nrrd --colors paint.nrrd

Volumes become .nrrd .nhdr .nii .nii.gz .npy .raw; distances f32, occupancy u8. Colours are sRGB in bytes.")]
    Voxelize(VoxelizeArgs),
    /// Make a picture of surfaces, or of the values of a volume
    Render(Box<RenderArgs>),
    /// Print a script that completes isokit's commands and options in a shell
    #[command(after_help = "\
Example:
  isokit completions bash > ~/.local/share/bash-completion/completions/isokit")]
    Completions(CompletionsArgs),
    /// Print the manual page, or write one page per command into a folder
    #[command(after_help = "\
Example:
  isokit man ~/.local/share/man/man1")]
    Man(ManArgs),
}

#[derive(Args, Debug)]
pub(crate) struct InfoArgs {
    /// The volume or mesh
    pub(crate) file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) volume: VolumeArgs,
}

#[derive(Args, Debug)]
pub(crate) struct SuggestArgs {
    /// The volume
    pub(crate) file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Draw how often values occur, how much surface there is at each, and how steep: a .png
    #[arg(long, value_name = "PNG")]
    pub(crate) plot: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) volume: VolumeArgs,
}

#[derive(Args, Debug)]
pub(crate) struct CheckArgs {
    /// The mesh
    pub(crate) mesh: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) weld: WeldArgs,
}

#[derive(Args, Debug)]
pub(crate) struct ConvertArgs {
    /// The volume or mesh
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) output: MeshOutputArgs,
    /// Axes of the world to write coordinates in; source: the file's own
    #[arg(long, value_enum, default_value_t)]
    pub(crate) space: SpaceArg,
    #[command(flatten)]
    pub(crate) weld: WeldArgs,
    #[command(flatten)]
    pub(crate) volume: VolumeArgs,
}

#[derive(Args, Debug)]
pub(crate) struct ResampleArgs {
    /// The volume
    pub(crate) file: PathBuf,
    /// How far samples are to be from each other along x, y, z, or along all three, in the volume's unit
    #[arg(long, value_name = "X[,Y,Z]", value_parser = values::spacing, allow_hyphen_values = true)]
    pub(crate) spacing: Triple<f64>,
    /// What lies between samples: nearest, linear, quadratic-bspline, cubic-bspline, catmull-rom, mitchell, bc:B,C,
    /// or a sine over its distance in a window: lanczosN, hannN, blackmanN with N samples to each side, 2 to 8
    #[arg(long, default_value = "cubic-bspline", value_name = "KERNEL", value_parser = values::filter)]
    pub(crate) kernel: Filter,
    /// Take a B-spline as it is: not through the samples, but smooth
    #[arg(long)]
    pub(crate) smoothing: bool,
    /// The file to write; its extension decides the format
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Distances between samples along x, y, z, where the file gives none or wrong ones
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "Input volume")]
    pub(crate) input_spacing: Option<Triple<f64>>,
    #[command(flatten)]
    pub(crate) volume: FileArgs,
}

/// What is done about vertices that a file repeats.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct WeldArgs {
    /// Make one vertex of those no further apart than this, in the file's unit; 0: of those at exactly
    /// the same place. STL, which repeats every vertex, is read as with 0
    #[arg(long, value_name = "DISTANCE", value_parser = values::distance)]
    pub(crate) weld: Option<f64>,
}

#[derive(Args, Debug)]
pub(crate) struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
}

#[derive(Args, Debug)]
pub(crate) struct ManArgs {
    /// Folder for isokit.1, isokit-extract.1, …; without it the main page is printed
    pub(crate) dir: Option<PathBuf>,
}

#[cfg(test)]
mod tests;
