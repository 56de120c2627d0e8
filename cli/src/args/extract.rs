//! The options of `extract`.

use super::{
    BoundaryArg, ClipArg, ColorArgs, DegenerateArg, DiagonalsArg, LevelArg, MeshOutputArgs, NanArg,
    NormalsArg, PlacementArg, SpaceArg, TopologyArg, VolumeArgs, memory, values,
};
use clap::Args;
use isokit::pipeline::Region;
use std::{num::NonZeroUsize, path::PathBuf};

/// What does not go with surfaces that are cut.
const NOT_WITH_CUTS: [&str; 7] =
    ["max_memory", "refine", "max_error", "balance", "repeat", "repeat_warm", "placement"];

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  isokit extract ct.nii.gz --iso 300 -o bone.glb
  isokit extract ct.nii.gz --iso -300:skin:#d8a58080 --iso 300:bone:#e8dcc0 -o head.glb
  isokit extract scan.raw --dims 256,256,128 --dtype u16be --spacing 0.7,0.7,1.2 \\
      --iso 900 -o tooth.ply
  isokit extract ct.nii.gz --iso auto -o bone.stl --report bone.json
  isokit extract ct.nii.gz --iso 300 --refine 1 --balance -o smooth.ply
  isokit extract ct.nii.gz --iso 300 --clip 1,0,0,12.5 -o half.stl
  isokit extract ct.nii.gz --iso -300:skin --iso 300:bone --clip 1,0,0,12.5:skin -o open.glb
  isokit extract ct.nii.gz --iso 150 --mask organs.nii.gz --mask-values 3,4 -o vessels.stl
  isokit extract ct.nii.gz --iso 300 --clip 1,0,0,12.5 --attribute ct.nii.gz -o slice.glb
  isokit extract t1.nii.gz --iso 80 --attribute pet.nii.gz --colormap magma -o hot.glb
  isokit extract large.nrrd --iso 300 --max-memory 2GiB -o large.ply
  isokit extract bracket.toml --spacing 0.1 -o bracket.stl

Meshes: .glb .gltf .obj .ply .stl. Volumes: NIfTI, NRRD, MetaImage, NPY, raw; see `isokit info`. Shapes: .toml .json;
see `isokit sample`.")]
pub(crate) struct ExtractArgs {
    /// The volume; or a shape, of which samples are made only near its surface: it needs --spacing
    pub(crate) volume_file: PathBuf,
    /// Value of the surface: a number, auto (Otsu's; printed), or a percentage of the range such as 50%.
    /// A name and a colour may follow: V:name:#rrggbb[aa]. Repeat it for several surfaces in one file,
    /// or, in PLY and STL, in several files [default: 0 for a shape]
    #[arg(long, value_name = "V[:NAME][:COLOR]", allow_hyphen_values = true)]
    pub(crate) iso: Vec<LevelArg>,
    #[command(flatten)]
    pub(crate) output: MeshOutputArgs,
    /// What lies beyond the border of the volume
    #[arg(long, value_enum, default_value_t, help_heading = "Surface")]
    pub(crate) boundary: BoundaryArg,
    /// What is connected in a cell whose corners leave it open
    #[arg(long, value_enum, default_value_t, help_heading = "Surface")]
    pub(crate) topology: TopologyArg,
    /// Where between two samples a vertex lies, for samples h apart of a smooth field; the table's triangles are
    /// the same [default: quintic; cubic with --refine, --max-error or --balance]
    #[arg(long, value_enum, help_heading = "Surface")]
    pub(crate) placement: Option<PlacementArg>,
    /// Which normals the vertices get
    #[arg(long, value_enum, default_value_t, help_heading = "Surface")]
    pub(crate) normals: NormalsArg,
    /// Whether a vertex may coincide with a sample
    #[arg(long, value_enum, default_value_t, help_heading = "Surface")]
    pub(crate) degenerate: DegenerateArg,
    /// What to do about samples that are NaN
    #[arg(long, value_enum, default_value_t, help_heading = "Surface")]
    pub(crate) nan: NanArg,
    /// How the polygons in which the surface goes through cells are cut into triangles
    #[arg(long, value_enum, default_value_t, help_heading = "Accuracy")]
    pub(crate) diagonals: DiagonalsArg,
    /// Divide each triangle into four, N times, with new vertices on the cubic field through the samples:
    /// between vertices the error falls to a quarter each time, where the field is smooth and down to that of the cubic
    /// field; it takes a multiple of the time of the surface itself
    #[arg(long, value_name = "N", value_parser = values::levels, help_heading = "Accuracy")]
    pub(crate) refine: Option<u32>,
    /// Divide triangles, only where the field curves, until none leaves its surface by more than E, in world
    /// units, as far as second derivatives tell, in ten rounds at most. Those of which that cannot be said, as in noise,
    /// are counted; --balance may raise the greatest error again
    #[arg(long, value_name = "E", value_parser = values::length, help_heading = "Accuracy")]
    #[arg(conflicts_with = "refine")]
    pub(crate) max_error: Option<f64>,
    /// Move vertices along their normals so that triangles lie as much outside of the field's surface as
    /// inside: without a triangle more, the error between vertices falls to a half or third where the surface bulges one
    /// way, not as far where it is a saddle, and that of the enclosed volume to nearly nothing
    #[arg(long, help_heading = "Accuracy")]
    pub(crate) balance: bool,
    /// Of a shape: put vertices where faces meet whose normals are more than so many degrees apart, so that edges stay
    /// sharp; 30 is a good choice
    #[arg(long, value_name = "DEGREES", value_parser = values::angle_of_creases, help_heading = "Accuracy")]
    #[arg(allow_negative_numbers = true)]
    pub(crate) creases: Option<f64>,
    /// Part of the volume, in samples: x0:x1,y0:y1,z0:z1, upper ends not included; an end may be left
    /// out. What lies beyond is not looked at: near the part's border normals, and vertices that are not
    /// placed linearly, differ a little from those of the whole
    #[arg(long, value_name = "RANGES", value_parser = Region::parse_samples)]
    #[arg(conflicts_with = "roi_mm", help_heading = "Part and place")]
    pub(crate) roi: Option<Region>,
    /// Part of the volume, in coordinates of the output's world: the same with numbers; the samples
    /// around that box are taken, and none beyond
    #[arg(long, value_name = "RANGES", value_parser = Region::parse_world)]
    #[arg(allow_hyphen_values = true, help_heading = "Part and place")]
    pub(crate) roi_mm: Option<Region>,
    /// Cut away what is beyond a plane, NX*x + NY*y + NZ*z > D in coordinates of the output's world, and close the
    /// hole; of the surfaces that are named, or else of all. Vertices of what is cut are placed linearly, and diagonals are
    /// the table's. Repeat it for several planes. With --attribute of the volume itself the cut shows its values
    #[arg(long, value_name = "NX,NY,NZ,D[:NAME...]", allow_hyphen_values = true)]
    #[arg(conflicts_with_all = NOT_WITH_CUTS, help_heading = "Part and place")]
    pub(crate) clip: Vec<ClipArg>,
    /// Keep only what lies where another volume, such as a segmentation, has one of --mask-values at its nearest sample,
    /// and close the holes. It may have any lattice in the same world, but of what is thinner than the samples of the
    /// volume pieces are missed; beyond it nothing is kept. Vertices and diagonals are as with --clip
    #[arg(long, value_name = "VOLUME")]
    #[arg(conflicts_with_all = NOT_WITH_CUTS, help_heading = "Part and place")]
    pub(crate) mask: Option<PathBuf>,
    /// The values that keep something, as the labels of organs [default: all but 0]
    #[arg(long, value_name = "V,V...", value_parser = values::finite, value_delimiter = ',')]
    #[arg(allow_hyphen_values = true, requires = "mask", help_heading = "Part and place")]
    pub(crate) mask_values: Vec<f64>,
    /// Axes of the world to write coordinates in
    #[arg(long, value_enum, default_value_t, help_heading = "Part and place")]
    pub(crate) space: SpaceArg,
    #[command(flatten)]
    pub(crate) color: ColorArgs,
    /// Keep in FILE.bricks, beside the volume, where which values occur, and skip what has no surface. Once it is kept, rows
    /// far from surfaces that are in few bricks are not even read, unless other options look there: --clip, --mask,
    /// --refine, --max-error, --balance, --attribute, --texture, --repeat, an isovalue that is to be found, NaN that is not
    /// let outside, a report or -v on a part or on samples that are not all finite; with --max-memory always. Made when it
    /// is first asked for or the volume has changed, always of all of the volume; the mesh does not depend on it
    #[arg(long, conflicts_with = "quantity", help_heading = "Speed")]
    pub(crate) index: bool,
    /// Never hold more memory than this, such as 512MiB: the volume is read slice by slice. The mesh is
    /// the same. Not with --diagonals fitted, --normals area, --refine, --max-error, --balance, --attribute or --texture,
    /// nor for -o - or NPY in Fortran order
    #[arg(long, value_name = "SIZE", value_parser = memory::bytes)]
    pub(crate) max_memory: Option<u64>,
    /// Write a report as JSON, to a file or to - for stdout
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    pub(crate) report: Option<PathBuf>,
    /// Write the surfaces as a scene for `render`
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    pub(crate) dump_scene: Option<PathBuf>,
    /// Extract N times, each time into fresh memory, and report the median time and all times
    #[arg(long, value_name = "N", requires = "report", conflicts_with = "repeat_warm")]
    #[arg(value_parser = values::count, help_heading = "Report")]
    pub(crate) repeat: Option<NonZeroUsize>,
    /// The same in the memory of an extraction before, which is not timed
    #[arg(long, value_name = "N", requires = "report")]
    #[arg(value_parser = values::count, help_heading = "Report")]
    pub(crate) repeat_warm: Option<NonZeroUsize>,
    #[command(flatten)]
    pub(crate) volume: VolumeArgs,
}
