//! The options of `render`.

use super::{ClipArg, LevelArg, VolumeArgs, values};
use crate::scene_file::{Ground, ModeWord, PresetWord, SideWord};
use clap::{Args, ValueEnum};
use isokit::{
    mesh::Rgba,
    pipeline::Region,
    render::{Depth, Size, Smoothing},
};
use std::{num::NonZeroUsize, path::PathBuf};

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  isokit render ct.nii.gz --iso -300:skin:#d8a58080 --iso 300:bone -o head.png
  isokit render ct.nii.gz --preset ct-bone --view left -o bone.png
  isokit render bone.stl --frames 36 -o turn.png
  isokit render bone.stl --clip 1,0,0,12.5 -o half.png
  isokit render painted.ply --color '#e8dcc0' -o plain.png
  isokit render ct.nii.gz --iso -300 --iso 300 --iso 1500 --sheet -o sheet.png
  isokit render ct.nii.gz --preset ct-skin --plot preset.png
  isokit render ct.nii.gz --roi-mm :,-40:40,: --preset ct-bone -o slab.png
  isokit render scene.toml --plan

A scene file says more than options; each option, where given, comes before what the file says:

  [volume]
  path = \"ct.nii.gz\"           # beside the scene file
  spacing = [0.5, 0.5, 1]      # or origin, index, quantity, and dims, dtype, skip, as on the command line
  roi = \"20:200,:,10:90\"      # or roi_mm, as --roi and --roi-mm: no more is read
  [[surface]]                  # any number, or none
  name = \"skin\"
  iso = -300
  color = \"#d8a580\"
  opacity = 0.35
  texture = { pattern = \"wood\", size = 5, colors = [\"#804818\"] }   # checker, marble, granite
  [[clip]]                     # keeps n . x <= d, in world units
  plane = [0, 1, 0, 12.5]      # n and d
  surfaces = [\"skin\"]          # default: all, and rays
  cap = \"slice\"                # none, solid, slice: the values there
  [transfer]                   # for mode = \"raycast\", \"splat\" and slices
  points = [[-1000, \"#00000000\"], [300, \"#e8dcc0c0\"]]   # or preset, peaks, rows = [{ gradient, points }]
  # peaks = [{ value = 300, width = 60, color = \"#e8dcc0ff\" }]   # these values, and next to nothing else
  gradient = true              # what is even fades; or the slope from which on nothing does
  unit = 1.0                   # opacities are those over so many world units
  [[material]]                 # for shading = \"mixture\", instead of [transfer] points
  values = [-80, 80]           # pure from one to the other, and mixed up to the next material
  color = \"#d0806004\"
  density = 1                  # surfaces are where it changes
  [camera]                     # or: view = \"left\", orbit = 30
  projection = \"perspective\"   # parallel: height = world units in the picture
  from = [300, -400, 120]
  at = \"center\"
  up = [0, 0, 1]
  fov = 30
  [light]                      # ambient, diffuse, specular, shininess
  shading = \"gradient\"         # none: colours as they are; mixture
  from = [1, 1, 2]             # where light comes from: default the eye
  shadows = true               # of surfaces, as the next
  occlusion = 0.7              # how dark it is where little light comes to
  scatter = 1.0                # of values: what particles scatter of it; ahead = 0.3: to where it goes
  [sampling]
  step = 0.5                   # of the smallest spacing
  kernel = \"catmull-rom\"       # smooth between samples; default linear
  jitter = true                # grain instead of rings
  integrated = true            # with all values between those at a step's ends: no rings
  error = 0.004                # shorter steps where a colour differs by more
  [output]
  size = [1024, 1024]
  mode = \"surfaces\"            # iso-raycast, raycast, splat
  background = \"#ffffff\"       # transparent")]
pub(crate) struct RenderArgs {
    /// A scene (.toml), a volume or a mesh
    pub(crate) input: PathBuf,
    /// The picture to write, as PNG. - writes to stdout
    #[arg(short, long, value_name = "FILE", required_unless_present_any = ["plan", "plot", "depth", "normals"])]
    pub(crate) output: Option<PathBuf>,
    /// Say what would be computed, and what not because the picture does not need it; then stop
    #[arg(long)]
    pub(crate) plan: bool,
    /// Show the surface of this value: as in `extract`; an opacity in the colour lets one look through it.
    /// Repeat it for several
    #[arg(
        long,
        value_name = "V[:NAME][:COLOR]",
        allow_hyphen_values = true,
        help_heading = "Scene"
    )]
    pub(crate) iso: Vec<LevelArg>,
    /// Draw a mesh in this colour, #rrggbb or #rrggbbaa [default: the colours of its vertices, else those of its
    /// surfaces, else one for each]
    #[arg(long, value_name = "COLOR", help_heading = "Scene")]
    pub(crate) color: Option<Rgba>,
    /// Cut away what is beyond a plane, NX*x + NY*y + NZ*z > D in world units, besides what planes of the scene do; of the
    /// surfaces that are named, or else of all, and of rays. Surfaces of a volume are closed there in their colour; of a
    /// mesh nobody knows what is inside. Repeat it for several planes
    #[arg(long, value_name = "NX,NY,NZ,D[:NAME...]", allow_hyphen_values = true)]
    #[arg(help_heading = "Scene")]
    pub(crate) clip: Vec<ClipArg>,
    /// What is shown [default: surfaces with --iso or of a mesh, else raycast]
    #[arg(long, value_enum, help_heading = "Scene")]
    pub(crate) mode: Option<ModeWord>,
    /// What values look like to rays and on slices [default: auto]
    #[arg(long, value_enum, help_heading = "Scene")]
    pub(crate) preset: Option<PresetWord>,
    /// The side from which all of it is seen [default: anterior]
    #[arg(long, value_enum, help_heading = "Camera")]
    pub(crate) view: Option<SideWord>,
    /// Go around it by so many degrees, seen from above counter-clockwise
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = values::angle)]
    #[arg(help_heading = "Camera")]
    pub(crate) orbit: Option<f64>,
    /// Angle of the perspective [default: 30]
    #[arg(long, value_name = "DEGREES", value_parser = values::fov, help_heading = "Camera")]
    pub(crate) fov: Option<f64>,
    /// What is far away is no smaller
    #[arg(long, conflicts_with = "fov", help_heading = "Camera")]
    pub(crate) parallel: bool,
    /// Make N pictures on the way around it, FILE_001.png and so on
    #[arg(long, value_name = "N", value_parser = values::frames, help_heading = "Camera")]
    pub(crate) frames: Option<NonZeroUsize>,
    /// One picture of each isovalue alone, side by side
    #[arg(long, conflicts_with = "frames", help_heading = "Picture")]
    pub(crate) sheet: bool,
    /// How much detail of a volume is looked at
    #[arg(long, value_enum, default_value_t, value_name = "LEVEL", help_heading = "Picture")]
    pub(crate) lod: LodWord,
    /// Pixels [default: 1024x1024]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = values::size, help_heading = "Picture")]
    pub(crate) size: Option<Size>,
    /// What is behind everything: #rrggbb or transparent [default: #ffffff]
    #[arg(long, value_name = "COLOR", help_heading = "Picture")]
    pub(crate) background: Option<Ground>,
    /// Points of each pixel at which surfaces are looked at [default: 4]
    #[arg(long, value_enum, value_name = "N", help_heading = "Picture")]
    pub(crate) smoothing: Option<SmoothingArg>,
    /// Bits of each part of a colour
    #[arg(long, value_enum, default_value_t, value_name = "N", help_heading = "Picture")]
    pub(crate) bits: BitsArg,
    /// How far ahead surfaces are: a .png with 16 bits from the nearest to the farthest, or as a volume of
    /// one slice in world units (.npy, .nrrd)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["frames", "sheet"], help_heading = "Picture")]
    pub(crate) depth: Option<PathBuf>,
    /// Where surfaces face, as a .png with 16 bits: right, up and to the eye from 0 to 1
    #[arg(long, value_name = "FILE", conflicts_with_all = ["frames", "sheet"], help_heading = "Picture")]
    pub(crate) normals: Option<PathBuf>,
    /// What values look like, over how often they occur, as a .png
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    pub(crate) plot: Option<PathBuf>,
    /// Write a report as JSON, to a file or to - for stdout
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    pub(crate) report: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) part: PartArgs,
    #[command(flatten)]
    pub(crate) volume: VolumeArgs,
}

/// The part of a volume that is looked at.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Part")]
pub(crate) struct PartArgs {
    /// Part of the volume, in samples: x0:x1,y0:y1,z0:z1, upper ends not included; an end may be left out. What lies beyond
    /// is not read
    #[arg(long, value_name = "RANGES", value_parser = Region::parse_samples, conflicts_with = "roi_mm")]
    roi: Option<Region>,
    /// Part of the volume, in coordinates of its world: the same with numbers; the samples around that box are taken, and
    /// none beyond
    #[arg(long, value_name = "RANGES", value_parser = Region::parse_world, allow_hyphen_values = true)]
    roi_mm: Option<Region>,
}

impl PartArgs {
    /// The part, if one was typed.
    pub(crate) fn region(&self) -> Option<Region> {
        self.roi.or(self.roi_mm)
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum SmoothingArg {
    /// Edges are jagged
    #[value(name = "1")]
    One,
    /// For displays
    #[default]
    #[value(name = "4")]
    Four,
    /// For print
    #[value(name = "16")]
    Sixteen,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum BitsArg {
    /// What displays show
    #[default]
    #[value(name = "8")]
    Eight,
    /// For further work
    #[value(name = "16")]
    Sixteen,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum LodWord {
    /// All samples
    #[default]
    Full,
    /// As many as pixels show
    Screen,
}

impl From<SmoothingArg> for Smoothing {
    fn from(arg: SmoothingArg) -> Self {
        match arg {
            SmoothingArg::One => Self::None,
            SmoothingArg::Four => Self::Four,
            SmoothingArg::Sixteen => Self::Sixteen,
        }
    }
}

impl From<BitsArg> for Depth {
    fn from(arg: BitsArg) -> Self {
        match arg {
            BitsArg::Eight => Self::Eight,
            BitsArg::Sixteen => Self::Sixteen,
        }
    }
}
