//! What `render` will do.

mod model;
mod viewpoint;

pub(crate) use model::{FadePlan, ModelPlan};

use super::{Stream, TextTarget, palette, places::Places, target::mesh_format};
use crate::{
    args::{LevelArg, RenderArgs},
    fault::UsageError,
    scene_file::{
        CapWord, ClipTable, Color, Ground, ModeWord, PatternWord, SceneFile, SurfaceTable,
        TextureTable,
    },
};
use anyhow::Result;
use isokit::{
    geom::HalfSpace,
    io::VolumeOptions,
    mesh::Rgba,
    pipeline::IsoChoice,
    render::{
        Background, Channel, Depth, Pattern, RasterOptions, RaycastOptions, Size, SolidTexture,
    },
    scene::{CapStyle, Clip, Viewpoint},
};
use std::{
    num::NonZeroU32,
    path::{Path, PathBuf},
};

/// Everything that `render` needs to know.
#[derive(Debug)]
pub(crate) struct RenderPlan {
    pub(crate) subject: Subject,
    pub(crate) mode: ModeWord,
    pub(crate) surfaces: Vec<LookPlan>,
    pub(crate) clips: Vec<Clip>,
    pub(crate) model: ModelPlan,
    /// Where each picture is taken from.
    pub(crate) viewpoints: Vec<Viewpoint>,
    pub(crate) raster: RasterOptions,
    pub(crate) raycast: RaycastOptions,
    pub(crate) size: Size,
    pub(crate) background: Background,
    pub(crate) depth: Depth,
    /// Whether it is only to be said what would be done.
    pub(crate) is_plan: bool,
    /// One picture of each surface alone, side by side.
    pub(crate) is_sheet: bool,
    /// What else surfaces have, and where that goes.
    pub(crate) channels: Vec<(Channel, PathBuf)>,
    /// Where the chart of what values look like goes.
    pub(crate) plot: Option<PathBuf>,
    /// Where the pictures go: none if only something else is wanted.
    pub(crate) targets: Vec<Stream>,
    pub(crate) report: Option<TextTarget>,
}

/// What is looked at.
#[derive(Debug)]
pub(crate) enum Subject {
    Volume(PathBuf, VolumeOptions),
    Mesh(PathBuf),
}

/// One surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LookPlan {
    pub(crate) iso: IsoChoice,
    /// If there is none, the surface is named by its isovalue.
    pub(crate) name: Option<String>,
    pub(crate) color: Rgba,
    pub(crate) opacity: f32,
    pub(crate) texture: Option<SolidTexture>,
}

/// What a picture is without other words.
const SIZE: [u32; 2] = [1024, 1024];
const WHITE: Rgba = Rgba([u8::MAX; 4]);

impl RenderPlan {
    pub(crate) fn new(args: RenderArgs) -> Result<Self> {
        let ending = args.input.extension();
        let is_scene = ending.is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
        let file = is_scene.then(|| SceneFile::read(&args.input)).transpose()?;
        let subject = subject(&args, file.as_ref())?;
        let file = file.unwrap_or_default();
        let surfaces = surfaces(&args.iso, &file.surface)?;
        let is_mesh = matches!(subject, Subject::Mesh(_));
        let default = match surfaces.is_empty() && !is_mesh {
            true => ModeWord::Raycast,
            false => ModeWord::Surfaces,
        };
        let mode = args.mode.or(file.output.mode).unwrap_or(default);
        check_subject(&subject, mode, &surfaces)?;
        let clips: Vec<Clip> = file.clip.iter().map(clip).collect::<Result<_, _>>()?;
        check_use(&args, mode, &clips)?;
        let viewpoint = viewpoint::of(&args, &file.camera)?;
        let [width, height] = file.output.size.unwrap_or(SIZE);
        let sides = NonZeroU32::new(width).zip(NonZeroU32::new(height));
        let size = sides.map(|(width, height)| Size { width, height });
        let size = args
            .size
            .or(size)
            .ok_or_else(|| UsageError("[output] size: expected two numbers above 0".into()))?;
        let model = model::of(args.preset, &file, mode)?;
        let (targets, report) = targets(&args, &subject)?;
        Ok(Self {
            mode,
            surfaces,
            clips,
            model,
            viewpoints: viewpoint::around(viewpoint, args.frames.map_or(1, usize::from))?,
            raster: model::raster(&file.light, mode)?
                .with_smoothing(args.smoothing.unwrap_or_default().into()),
            raycast: model::raycast(&file, mode)?,
            size,
            background: background(args.background.or(file.output.background)),
            depth: args.bits.into(),
            is_plan: args.plan,
            is_sheet: args.sheet,
            channels: channels(&args, mode)?,
            plot: plot(&args, &subject)?,
            subject,
            targets,
            report,
        })
    }
}

/// What is looked at: what the scene names, or what was typed.
fn subject(args: &RenderArgs, file: Option<&SceneFile>) -> Result<Subject, UsageError> {
    let Some(file) = file else {
        let options = args.volume.options();
        let VolumeOptions { volume_index, raw, spacing, origin, .. } = &options;
        let describes =
            volume_index.is_some() || raw.is_some() || spacing.is_some() || origin.is_some();
        return match mesh_format(&args.input) {
            Some(_) if describes => {
                let says = "a mesh has no samples: leave out what describes those of a volume";
                Err(UsageError(says.into()))
            }
            Some(_) => Ok(Subject::Mesh(args.input.clone())),
            None => Ok(Subject::Volume(args.input.clone(), options)),
        };
    };
    let Some(volume) = &file.volume else {
        let says = "the scene names no volume: [volume] with path = \"…\" does";
        return Err(UsageError(format!("{}: {says}", args.input.display())));
    };
    let folder = args.input.parent().unwrap_or(Path::new(""));
    Ok(Subject::Volume(folder.join(&volume.path), args.volume.options()))
}

fn check_subject(
    subject: &Subject,
    mode: ModeWord,
    surfaces: &[LookPlan],
) -> Result<(), UsageError> {
    let says = match (subject, mode) {
        (Subject::Mesh(_), ModeWord::Raycast | ModeWord::IsoRaycast | ModeWord::Splat) => {
            "a mesh has no values for rays to go through: leave out --mode"
        }
        (Subject::Mesh(_), _) if !surfaces.is_empty() => "a mesh has no values: leave out --iso",
        (Subject::Volume(..), ModeWord::Surfaces | ModeWord::IsoRaycast) if surfaces.is_empty() => {
            "no surface is named: give --iso, or [[surface]] in the scene"
        }
        _ => return Ok(()),
    };
    Err(UsageError(says.into()))
}

/// That what was typed is of use for what is shown.
fn check_use(args: &RenderArgs, mode: ModeWord, clips: &[Clip]) -> Result<(), UsageError> {
    let shows_values = mode.shows_values() || clips.iter().any(|clip| clip.cap == CapStyle::Slice);
    if args.sheet && mode.shows_values() {
        let says = "--sheet is of isovalues: add --iso, or leave it out";
        return Err(UsageError(says.into()));
    }
    let says = match (args.preset, args.smoothing) {
        (Some(_), _) if !shows_values && args.plot.is_none() => {
            "--preset is for values and slices of them: add --mode raycast, or leave it out"
        }
        (_, Some(_)) if mode.shows_values() => "--smoothing is for surfaces: leave it out",
        _ => return Ok(()),
    };
    Err(UsageError(says.into()))
}

/// The surfaces that were typed, or else those of the file.
fn surfaces(typed: &[LevelArg], file: &[SurfaceTable]) -> Result<Vec<LookPlan>, UsageError> {
    let of_typed = |(n, level): (usize, &LevelArg)| {
        let color = level.color.unwrap_or(palette::color(n));
        let opacity = f32::from(color.0[3]) / 255.0;
        LookPlan { iso: level.iso, name: level.name.clone(), color, opacity, texture: None }
    };
    if !typed.is_empty() {
        return Ok(typed.iter().enumerate().map(of_typed).collect());
    }
    let of_file = |(n, surface): (usize, &SurfaceTable)| {
        let color = surface.color.map_or(palette::color(n), |Color(color)| color);
        let opacity = surface.opacity.unwrap_or(f32::from(color.0[3]) / 255.0);
        let number = n + 1;
        if !(0.0..=1.0).contains(&opacity) {
            let says = format!("expected an opacity from 0 to 1, found {opacity}");
            return Err(UsageError(format!("[[surface]] {number}: {says}")));
        }
        let texture = surface.texture.as_ref().map(|table| texture(table, color));
        let texture = texture
            .transpose()
            .map_err(|says| UsageError(format!("[[surface]] {number}, texture: {says}")))?;
        Ok(LookPlan { iso: surface.iso, name: surface.name.clone(), color, opacity, texture })
    };
    file.iter().enumerate().map(of_file).collect()
}

/// The texture of a surface of such a colour.
fn texture(table: &TextureTable, own: Rgba) -> Result<SolidTexture, String> {
    let color = |rgba: Rgba| {
        let [r, g, b, _] = rgba.to_linear();
        [r, g, b]
    };
    let colors = match table.colors[..] {
        [Color(second)] => [own, second],
        [Color(first), Color(second)] => [first, second],
        _ => return Err(format!("expected one or two colors, found {}", table.colors.len())),
    };
    let pattern = match table.pattern {
        PatternWord::Checker => Pattern::Checker,
        PatternWord::Marble => Pattern::Marble,
        PatternWord::Wood => Pattern::Wood,
        PatternWord::Granite => Pattern::Granite,
    };
    SolidTexture::new(pattern, colors.map(color), table.size).map_err(|error| error.to_string())
}

fn clip(table: &ClipTable) -> Result<Clip, UsageError> {
    let [x, y, z, offset] = table.plane;
    let half = HalfSpace::new([x, y, z], offset)
        .map_err(|error| UsageError(format!("[[clip]] plane = {:?}: {error}", table.plane)))?;
    let cap = match table.cap {
        CapWord::None => CapStyle::None,
        CapWord::Solid => CapStyle::Solid,
        CapWord::Slice => CapStyle::Slice,
    };
    Ok(Clip { half, surfaces: table.surfaces.clone(), cap })
}

fn background(ground: Option<Ground>) -> Background {
    match ground.unwrap_or(Ground::Color(WHITE)) {
        Ground::Transparent => Background::Transparent,
        Ground::Color(color) => {
            let [r, g, b, _] = color.to_linear();
            Background::Color([r, g, b])
        }
    }
}

/// What else surfaces have.
fn channels(args: &RenderArgs, mode: ModeWord) -> Result<Vec<(Channel, PathBuf)>, UsageError> {
    let depth = args.depth.as_ref().map(|path| (Channel::Depth, path.clone()));
    let normals = args.normals.as_ref().map(|path| (Channel::Normal, path.clone()));
    if args.normals.as_ref().is_some_and(|path| !is_png(path)) {
        let says = "--normals: expected a name that ends in .png";
        return Err(UsageError(says.into()));
    }
    let channels: Vec<_> = depth.into_iter().chain(normals).collect();
    if !channels.is_empty() && mode.shows_values() {
        let says = "--depth and --normals are of surfaces: add --iso, or leave them out";
        return Err(UsageError(says.into()));
    }
    Ok(channels)
}

fn plot(args: &RenderArgs, subject: &Subject) -> Result<Option<PathBuf>, UsageError> {
    match (&args.plot, subject) {
        (Some(_), Subject::Mesh(_)) => {
            Err(UsageError("a mesh has no values: leave out --plot".into()))
        }
        (Some(path), _) if !is_png(path) => {
            let says = "--plot: expected a name that ends in .png";
            Err(UsageError(says.into()))
        }
        (path, _) => Ok(path.clone()),
    }
}

fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"))
}

/// Where pictures and report go.
fn targets(args: &RenderArgs, subject: &Subject) -> Result<(Vec<Stream>, Option<TextTarget>)> {
    let report = args.report.as_deref().map(Stream::named).transpose()?;
    let output = args.output.as_deref().filter(|_| !args.plan);
    let Some(output) = output else { return Ok((vec![], report)) };
    let frames = args.frames.map_or(1, usize::from);
    let targets = match Stream::named(output)? {
        Stream::Stdout if frames > 1 => {
            return Err(
                UsageError("several pictures do not fit into stdout: name a file".into()).into()
            );
        }
        Stream::Stdout if report == Some(Stream::Stdout) => {
            let says = "picture and report cannot both go to stdout: name a file for one of them";
            return Err(UsageError(says.into()).into());
        }
        Stream::File(path) if !is_png(&path) => {
            let says = format!("{}: expected a name that ends in .png", path.display());
            return Err(UsageError(says).into());
        }
        Stream::File(path) if frames > 1 => {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let digits = frames.to_string().len().max(3);
            let frame = |n: usize| path.with_file_name(format!("{stem}_{n:0digits$}.png"));
            (1..=frames).map(|n| Stream::File(frame(n))).collect()
        }
        one => vec![one],
    };
    let (Subject::Volume(input, _) | Subject::Mesh(input)) = subject;
    let mut places = Places::of_input(input);
    if *input != args.input {
        places.add("the scene", &args.input)?;
    }
    let others = [("--depth", &args.depth), ("--normals", &args.normals), ("--plot", &args.plot)];
    for (by, path) in others {
        path.iter().try_for_each(|path| places.add(by, path))?;
    }
    let files = targets.iter().map(|target| ("--output", target));
    for (by, stream) in files.chain(report.as_ref().map(|report| ("--report", report))) {
        if let Stream::File(path) = stream {
            places.add(by, path)?;
        }
    }
    Ok((targets, report))
}
