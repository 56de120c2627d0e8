//! What `extract` will do.

use super::{ColorPlan, MeshTarget, Stream, TextTarget, palette, places::Places};
use crate::{
    args::{ClipArg, ExtractArgs, LevelArg, PlacementArg, SpaceArg},
    fault::UsageError,
    shape_file::is_shape,
};
use anyhow::Result;
use isokit::{
    geom::HalfSpace,
    io::{VolumeOptions, mesh_files},
    marching_cubes::{Degenerate, Diagonals, ExtractOptions},
    mesh::Rgba,
    pipeline::{IsoChoice, Normals, Region, SurfaceOptions, TargetSpace},
    refine::{RefineOptions, Subdivision},
};
use std::{num::NonZeroUsize, path::PathBuf};

/// Everything that `extract` needs to know.
#[derive(Debug)]
pub(crate) struct ExtractPlan {
    pub(crate) input: PathBuf,
    pub(crate) volume: VolumeOptions,
    /// How far samples of a shape are from each other; none of a volume, which has samples.
    pub(crate) shape: Option<[f64; 3]>,
    pub(crate) region: Region,
    pub(crate) space: TargetSpace,
    pub(crate) levels: Vec<LevelPlan>,
    pub(crate) clips: Vec<ClipArg>,
    /// The volume that keeps a part of all surfaces, and by which of its values; by all but 0, if there are none.
    pub(crate) mask: Option<(PathBuf, Vec<f64>)>,
    pub(crate) surface: SurfaceOptions,
    /// What is done with surfaces after that.
    pub(crate) refine: RefineOptions,
    /// What vertices carry besides.
    pub(crate) color: ColorPlan,
    pub(crate) target: MeshTarget,
    pub(crate) index: bool,
    pub(crate) report: Option<TextTarget>,
    /// Where a scene of the surfaces goes.
    pub(crate) dump_scene: Option<PathBuf>,
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
    pub(crate) fn new(mut args: ExtractArgs) -> Result<Self> {
        let shape = match is_shape(&args.volume_file) {
            true => Some(shape(&args)?),
            false if args.iso.is_empty() => {
                return Err(UsageError(
                    "--iso is missing: say at which value the surface is".into(),
                )
                .into());
            }
            false => None,
        };
        if args.iso.is_empty() {
            args.iso.push(LevelArg {
                iso: IsoChoice::Value(0.0),
                name: Some("shape".into()),
                color: None,
            });
        }
        let target = MeshTarget::new(&args.output, args.iso.len())?;
        let report = args.report.as_deref().map(Stream::named).transpose()?;
        if report == Some(Stream::Stdout) && target.stream == Stream::Stdout {
            let says = "mesh and report cannot both go to stdout: name a file for one of them";
            return Err(UsageError(says.into()).into());
        }
        if args.creases.is_some() && shape.is_none() {
            let says = "--creases: only a shape says where its faces meet; between samples nothing is sharp";
            return Err(UsageError(says.into()).into());
        }
        let refine = refine(&args);
        let placement = args.placement.unwrap_or(match refine.do_nothing() {
            true => PlacementArg::default(),
            false => PlacementArg::Cubic, // what is refined stands on its vertices
        });
        let extract = ExtractOptions::DEFAULT
            .with_boundary(args.boundary.into())
            .with_topology(args.topology.into())
            .with_degenerate(args.degenerate.into())
            .with_placement(placement.into())
            .with_gradient(args.normals.into())
            .with_diagonals(args.diagonals.into())
            .with_nan(args.nan.into());
        let surface =
            SurfaceOptions::default().with_extract(extract).with_normals(args.normals.into());
        let repeat = match (args.repeat, args.repeat_warm) {
            (_, Some(times)) => Repeat::Warm(times),
            (Some(times), None) => Repeat::Cold(times),
            (None, None) => Repeat::Once,
        };
        check_refine(&refine, &surface)?;
        let volume = args.volume.options();
        check_scene(&args)?;
        let are_cut = args.mask.is_some() || args.clip.iter().any(|clip| clip.surfaces.is_none());
        check_cuts(&surface, are_cut)?;
        let color = ColorPlan::new(args.color, &target)?;
        if args.max_memory.is_some() {
            check_slabs(&target, &volume, (&surface, &refine, &color), repeat)?;
        }
        let plan = Self {
            volume,
            input: args.volume_file,
            shape,
            region: args.roi.or(args.roi_mm).unwrap_or_default(),
            space: args.space.into(),
            levels: levels(args.iso),
            clips: args.clip,
            mask: args.mask.map(|path| (path, args.mask_values)),
            surface,
            refine,
            color,
            target,
            index: args.index,
            report,
            dump_scene: args.dump_scene,
            repeat,
            max_memory: args.max_memory,
        };
        // An isovalue that is still to be found makes a name that is still to be checked.
        let isos: Vec<f64> = plan.levels.iter().filter_map(LevelPlan::value).collect();
        match isos.len() == plan.levels.len() {
            true => plan.check_names(&isos)?,
            false => plan.check_files(&[])?,
        }
        Ok(plan)
    }

    /// Whether files and surfaces are what their names say, with an isovalue for each level.
    pub(crate) fn check_names(&self, isos: &[f64]) -> Result<(), UsageError> {
        let names = self.levels.iter().zip(isos).map(|(level, &iso)| level.name(iso));
        let names: Vec<_> = names.collect();
        let mut cut = self.clips.iter().filter_map(|clip| clip.surfaces.as_ref()).flatten();
        match cut.find(|name| !names.contains(name)) {
            Some(name) => Err(UsageError(format!(
                "--clip: expected the name of a surface, {}, found {name:?}",
                names.join(" or ")
            ))),
            None => {
                check_cuts(&self.surface, names.iter().all(|name| self.is_cut(name)))?;
                self.check_files(isos)
            }
        }
    }

    /// Whether something is cut away.
    pub(crate) fn cuts(&self) -> bool {
        !self.clips.is_empty() || self.mask.is_some()
    }

    /// Whether something is cut away of a surface.
    pub(crate) fn is_cut(&self, name: &str) -> bool {
        self.mask.is_some() || !self.halves_of(name).is_empty()
    }

    /// What planes keep of a surface.
    pub(crate) fn halves_of(&self, name: &str) -> Vec<HalfSpace> {
        let cuts = |clip: &&ClipArg| {
            clip.surfaces.as_ref().is_none_or(|names| names.iter().any(|cut| cut == name))
        };
        self.clips.iter().filter(cuts).map(|clip| clip.half).collect()
    }

    /// Whether every file has a place of its own, with an isovalue for each level; without isovalues, as
    /// far as that can be told.
    fn check_files(&self, isos: &[f64]) -> Result<(), UsageError> {
        let mut places = Places::of_input(&self.input);
        if let Some((path, _)) = &self.color.attribute {
            places.read("--attribute", path);
        }
        if let Some((path, _)) = &self.mask {
            places.read("--mask", path);
        }
        if self.index {
            places.add("--index", &self.index_file())?;
        }
        if let Stream::File(path) = &self.target.stream {
            let names: Vec<String> =
                self.levels.iter().zip(isos).map(|(level, &iso)| level.name(iso)).collect();
            let names = names.iter().map(String::as_str);
            mesh_files(path, names).iter().try_for_each(|file| places.add("--output", file))?;
        }
        if let Some(path) = &self.dump_scene {
            places.add("--dump-scene", path)?;
        }
        match &self.report {
            Some(Stream::File(path)) => places.add("--report", path),
            _ => Ok(()),
        }
    }

    fn index_file(&self) -> PathBuf {
        let number = self.volume.volume_index.filter(|index| *index > 0);
        let number = number.map_or(String::new(), |index| format!(".{index}"));
        let mut name = self.input.clone().into_os_string();
        name.push(format!("{number}.bricks"));
        name.into()
    }
}

impl LevelPlan {
    /// The isovalue, where it was typed.
    pub(crate) fn value(&self) -> Option<f64> {
        match self.iso {
            IsoChoice::Value(iso) => Some(iso),
            _ => None,
        }
    }

    /// The name that was chosen, or one after the isovalue.
    pub(crate) fn name(&self, iso: f64) -> String {
        self.name.clone().unwrap_or_else(|| format!("iso_{iso}"))
    }
}

/// How far samples of a shape are to be from each other, if nothing is asked that needs a volume.
fn shape(args: &ExtractArgs) -> Result<[f64; 3], UsageError> {
    let needs_volume = [
        ("--roi", args.roi.is_some() || args.roi_mm.is_some()),
        ("--clip", !args.clip.is_empty()),
        ("--mask", args.mask.is_some()),
        ("--space", args.space != SpaceArg::Source),
        ("--attribute", args.color.attribute.is_some()),
        ("--index", args.index),
        ("--max-memory", args.max_memory.is_some()),
        ("--dump-scene", args.dump_scene.is_some()),
        ("--repeat", args.repeat.is_some() || args.repeat_warm.is_some()),
    ];
    if let Some((words, _)) = needs_volume.iter().find(|(_, is_asked)| *is_asked) {
        let says = format!("{words}: a shape has no volume for that; `isokit sample` makes one");
        return Err(UsageError(says));
    }
    if args.iso.iter().any(|level| !matches!(level.iso, IsoChoice::Value(_))) {
        let says = "--iso: expected a number, since a shape has no samples to choose one by";
        return Err(UsageError(says.into()));
    }
    args.volume.only_spacing().ok_or_else(|| {
        let says = "a shape needs --spacing, how far samples are from each other, and no other word on its samples";
        UsageError(says.into())
    })
}

/// What is to be done with surfaces once they are there.
fn refine(args: &ExtractArgs) -> RefineOptions {
    let subdivision = match (args.refine, args.max_error) {
        (Some(levels), _) => Subdivision::Levels(levels),
        (None, Some(error)) => Subdivision::MaxError(error),
        (None, None) => Subdivision::None,
    };
    let options = RefineOptions::default().with_subdivision(subdivision).with_balance(args.balance);
    args.creases.map_or(options, |degrees| options.with_creases(degrees))
}

/// What does not fit together with triangles that are changed.
fn check_refine(refine: &RefineOptions, surface: &SurfaceOptions) -> Result<(), UsageError> {
    match surface.extract.degenerate {
        Degenerate::Exact if !refine.do_nothing() => Err(UsageError(
            "--degenerate exact makes triangles without area, which can neither be divided nor \
             balanced: leave out either it or --creases, --refine, --max-error and --balance"
                .into(),
        )),
        _ => Ok(()),
    }
}

/// What has no effect on surfaces that are cut, if all are.
fn check_cuts(surface: &SurfaceOptions, are_cut: bool) -> Result<(), UsageError> {
    let says = match (surface.extract.diagonals, surface.extract.degenerate) {
        _ if !are_cut => return Ok(()),
        (Diagonals::Fitted, _) => {
            "--diagonals fitted: surfaces that are cut have the table's diagonals"
        }
        (_, Degenerate::Exact) => {
            "--degenerate exact: triangles of surfaces that are cut have an area"
        }
        _ => return Ok(()),
    };
    Err(UsageError(format!("{says}: leave out either it or --clip and --mask")))
}

/// What a scene cannot say.
fn check_scene(args: &ExtractArgs) -> Result<(), UsageError> {
    let Some(path) = &args.dump_scene else { return Ok(()) };
    let is_scene = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    let says = match () {
        () if !is_scene => "--dump-scene: expected a name that ends in .toml",
        () if args.color.attribute.is_some() || args.color.texture.is_some() => {
            "--dump-scene: a scene has no colours of vertices: leave out --attribute and --texture"
        }
        () if args.mask.is_some() => "--dump-scene: a scene has no mask: leave out --mask",
        () if (!args.clip.is_empty() || args.roi_mm.is_some())
            && args.space != SpaceArg::Source =>
        {
            "--dump-scene: planes and parts of a scene are in the file's own space: leave out --space"
        }
        () => return Ok(()),
    };
    Err(UsageError(says.into()))
}

/// What does not fit together with slices that pass by.
fn check_slabs(
    target: &MeshTarget,
    volume: &VolumeOptions,
    (surface, refine, color): (&SurfaceOptions, &RefineOptions, &ColorPlan),
    repeat: Repeat,
) -> Result<(), UsageError> {
    let says = match (&target.stream, surface.normals, repeat) {
        (Stream::Stdout, ..) => {
            "--max-memory needs a file, whose beginning is written last: name one with -o"
        }
        (_, Normals::Area, _) => {
            "--normals area needs the whole mesh in memory: leave out either it or --max-memory"
        }
        _ if surface.extract.diagonals == Diagonals::Fitted => {
            "--diagonals fitted needs the whole mesh in memory: leave out either it or --max-memory"
        }
        _ if !refine.do_nothing() => {
            "--refine, --max-error and --balance need the whole mesh and the whole volume in memory: \
             leave out either them or --max-memory"
        }
        _ if volume.quantity.is_some() => {
            "--quantity needs all vectors in memory: leave out either it or --max-memory, or convert them first"
        }
        _ if !color.is_empty() => {
            "--attribute and --texture need the whole mesh in memory: leave out either them or --max-memory"
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
