//! What `render` will do.

use super::{Stream, TextTarget, palette, places::Places, target::mesh_format};
use crate::{
    args::{LevelArg, RenderArgs},
    fault::UsageError,
    scene_file::{
        At, CameraTable, CapWord, ClipTable, Color, Ground, LightTable, ModeWord, PresetWord,
        ProjectionWord, SceneFile, ShadingWord, SideWord, SurfaceTable, TransferTable,
    },
};
use anyhow::Result;
use isokit::{
    geom::HalfSpace,
    io::VolumeOptions,
    mesh::Rgba,
    pipeline::IsoChoice,
    render::{
        Background, ControlPoint, Depth, Light, Projection, RasterOptions, RaycastOptions, Side,
        Size, TransferFunction,
    },
    scene::{CapStyle, Clip, Preset, Viewpoint},
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
    pub(crate) transfer: TransferPlan,
    /// Where each picture is taken from.
    pub(crate) viewpoints: Vec<Viewpoint>,
    pub(crate) raster: RasterOptions,
    pub(crate) raycast: RaycastOptions,
    pub(crate) size: Size,
    pub(crate) background: Background,
    pub(crate) depth: Depth,
    /// Where the pictures go: none if it is only to be said what would be done.
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
}

/// What values look like.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TransferPlan {
    Points(TransferFunction),
    Preset(Preset),
}

/// What a picture is without other words.
const SIZE: [u32; 2] = [1024, 1024];
const FOV: f64 = 30.0;
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
        let viewpoint = viewpoint(&args, &file.camera)?;
        let [width, height] = file.output.size.unwrap_or(SIZE);
        let sides = NonZeroU32::new(width).zip(NonZeroU32::new(height));
        let size = sides.map(|(width, height)| Size { width, height });
        let size = args
            .size
            .or(size)
            .ok_or_else(|| UsageError("[output] size: expected two numbers above 0".into()))?;
        let light = light(&file.light)?;
        let (transfer, unit) = transfer(args.preset, file.transfer.as_ref())?;
        let (targets, report) = targets(&args, &subject)?;
        let step = file.sampling.step.unwrap_or(RaycastOptions::DEFAULT.step);
        Ok(Self {
            subject,
            mode,
            surfaces,
            clips,
            transfer,
            viewpoints: around(viewpoint, args.frames.map_or(1, usize::from))?,
            raster: RasterOptions::DEFAULT
                .with_light(light)
                .with_smoothing(args.smoothing.unwrap_or_default().into()),
            raycast: RaycastOptions::DEFAULT.with_light(light).with_step(step).with_unit(unit),
            size,
            background: background(args.background.or(file.output.background)),
            depth: args.bits.into(),
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
        (Subject::Mesh(_), ModeWord::Raycast | ModeWord::IsoRaycast) => {
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
    let is_raycast = mode == ModeWord::Raycast;
    let shows_values = is_raycast || clips.iter().any(|clip| clip.cap == CapStyle::Slice);
    let says = match (args.preset, args.smoothing) {
        (Some(_), _) if !shows_values => {
            "--preset is for rays through values, and for slices: add --mode raycast, or leave it out"
        }
        (_, Some(_)) if is_raycast => "--smoothing is for surfaces: leave it out",
        _ => return Ok(()),
    };
    Err(UsageError(says.into()))
}

/// The surfaces that were typed, or else those of the file.
fn surfaces(typed: &[LevelArg], file: &[SurfaceTable]) -> Result<Vec<LookPlan>, UsageError> {
    let of_typed = |(n, level): (usize, &LevelArg)| {
        let color = level.color.unwrap_or(palette::color(n));
        let opacity = f32::from(color.0[3]) / 255.0;
        LookPlan { iso: level.iso, name: level.name.clone(), color, opacity }
    };
    if !typed.is_empty() {
        return Ok(typed.iter().enumerate().map(of_typed).collect());
    }
    let of_file = |(n, surface): (usize, &SurfaceTable)| {
        let color = surface.color.map_or(palette::color(n), |Color(color)| color);
        let opacity = surface.opacity.unwrap_or(f32::from(color.0[3]) / 255.0);
        match (0.0..=1.0).contains(&opacity) {
            true => Ok(LookPlan { iso: surface.iso, name: surface.name.clone(), color, opacity }),
            false => Err(UsageError(format!(
                "[[surface]] {}: expected an opacity from 0 to 1, found {opacity}",
                n + 1
            ))),
        }
    };
    file.iter().enumerate().map(of_file).collect()
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

/// What values look like, and over which length.
fn transfer(
    typed: Option<PresetWord>,
    table: Option<&TransferTable>,
) -> Result<(TransferPlan, Option<f64>), UsageError> {
    let unit = table.and_then(|table| table.unit);
    let points = table.and_then(|table| table.points.as_ref());
    let named = table.and_then(|table| table.preset);
    if points.is_some() && named.is_some() {
        let says = "[transfer]: expected either points or a preset, found both";
        return Err(UsageError(says.into()));
    }
    let plan = match (typed, points) {
        (None, Some(points)) => {
            let points = points.iter().map(|&(value, Color(rgba))| ControlPoint::new(value, rgba));
            let function = TransferFunction::new(points.collect());
            TransferPlan::Points(
                function.map_err(|error| UsageError(format!("[transfer] points: {error}")))?,
            )
        }
        _ => TransferPlan::Preset(match typed.or(named) {
            None | Some(PresetWord::Auto) => Preset::Auto,
            Some(PresetWord::CtBone) => Preset::CtBone,
            Some(PresetWord::CtSkin) => Preset::CtSkin,
        }),
    };
    Ok((plan, unit))
}

fn light(table: &LightTable) -> Result<Option<Light>, UsageError> {
    let LightTable { shading, ambient, diffuse, specular, shininess } = table.clone();
    let default = Light::DEFAULT;
    let light = Light {
        ambient: ambient.unwrap_or(default.ambient),
        diffuse: diffuse.unwrap_or(default.diffuse),
        specular: specular.unwrap_or(default.specular),
        shininess: shininess.unwrap_or(default.shininess),
    };
    let shares = [light.ambient, light.diffuse, light.specular];
    if !shares.iter().all(|share| (0.0..=1.0).contains(share)) {
        let says = "[light]: expected ambient, diffuse and specular from 0 to 1, found";
        return Err(UsageError(format!("{says} {shares:?}")));
    }
    Ok((shading == ShadingWord::Gradient).then_some(light))
}

/// From where it is seen: from a place if the file has one and no side was typed, else from a side.
fn viewpoint(args: &RenderArgs, table: &CameraTable) -> Result<Viewpoint, UsageError> {
    let refuse = |says: &str| Err(UsageError(format!("[camera]: {says}")));
    let is_parallel = match table.projection {
        _ if args.fov.is_some() => false,
        Some(projection) => args.parallel || projection == ProjectionWord::Parallel,
        None => args.parallel || table.height.is_some(),
    };
    let fov = args.fov.or(table.fov).unwrap_or(FOV);
    if table.fov.is_some() && table.height.is_some() {
        return refuse(
            "fov is for a perspective and height for a parallel projection: leave out one",
        );
    }
    match table.projection {
        Some(ProjectionWord::Perspective) if table.height.is_some() => {
            return refuse("height is for a parallel projection, not for a perspective");
        }
        Some(ProjectionWord::Parallel) if table.fov.is_some() => {
            return refuse("fov is for a perspective, not for a parallel projection");
        }
        _ => {}
    }
    if !table.orbit.is_none_or(f64::is_finite) {
        return refuse("orbit: expected degrees, a finite number");
    }
    if let (Some(from), None) = (table.from, args.view) {
        if table.view.is_some() || table.orbit.is_some() {
            return refuse("expected either from or view and orbit, found both");
        }
        if args.orbit.is_some() {
            let says = "--orbit goes around what is seen from a side: add --view";
            return Err(UsageError(says.into()));
        }
        let at = match table.at {
            None | Some(At::Center(_)) => None,
            Some(At::Place(place)) => Some(place),
        };
        let projection = match (is_parallel, table.height) {
            (true, Some(height)) => Projection::Parallel { height },
            (true, None) => return refuse("a parallel projection from a place needs a height"),
            (false, _) => Projection::Perspective { fov },
        };
        let up = table.up.unwrap_or([0.0, 0.0, 1.0]);
        return Ok(Viewpoint::At { from, at, up, projection });
    }
    if table.from.is_none() && (table.at.is_some() || table.up.is_some() || table.height.is_some())
    {
        return refuse("at, up and height are for a camera at a place: add from");
    }
    let side = match args.view.or(table.view).unwrap_or_default() {
        SideWord::Anterior => Side::Anterior,
        SideWord::Posterior => Side::Posterior,
        SideWord::Left => Side::Left,
        SideWord::Right => Side::Right,
        SideWord::Superior => Side::Superior,
        SideWord::Inferior => Side::Inferior,
    };
    let orbit = args.orbit.or(table.orbit).unwrap_or(0.0);
    Ok(Viewpoint::Framed { side, orbit, fov: (!is_parallel).then_some(fov) })
}

/// The way around, in as many steps.
fn around(viewpoint: Viewpoint, frames: usize) -> Result<Vec<Viewpoint>, UsageError> {
    match viewpoint {
        _ if frames == 1 => Ok(vec![viewpoint]),
        Viewpoint::Framed { side, orbit, fov } => {
            let step = 360.0 / frames as f64;
            let at = |n: usize| Viewpoint::Framed { side, orbit: orbit + step * n as f64, fov };
            Ok((0..frames).map(at).collect())
        }
        Viewpoint::At { .. } => {
            let says = "--frames goes around what is seen from a side: add --view";
            Err(UsageError(says.into()))
        }
    }
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

/// Where pictures and report go.
fn targets(args: &RenderArgs, subject: &Subject) -> Result<(Vec<Stream>, Option<TextTarget>)> {
    let report = args.report.as_deref().map(Stream::named).transpose()?;
    let output = args.output.as_deref().filter(|_| !args.plan);
    let Some(output) = output else { return Ok((vec![], report)) };
    let is_png = output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
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
        Stream::File(path) if !is_png => {
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
    let files = targets.iter().map(|target| ("--output", target));
    for (by, stream) in files.chain(report.as_ref().map(|report| ("--report", report))) {
        if let Stream::File(path) = stream {
            places.add(by, path)?;
        }
    }
    Ok((targets, report))
}
