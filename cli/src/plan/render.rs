//! What `render` will do.

mod model;
mod outputs;
mod subject;
mod viewpoint;

pub(crate) use model::{FadePlan, ModelPlan};

use super::{Stream, TextTarget, palette};
use crate::{
    args::{ClipArg, LevelArg, LodWord, RenderArgs},
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
    pipeline::{IsoChoice, Region},
    render::{
        Background, Channel, Depth, Pattern, RasterOptions, RaycastOptions, Size, SolidTexture,
    },
    scene::{CapStyle, Clip, Scene, Viewpoint},
};
use std::{num::NonZeroU32, path::PathBuf};

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
    /// Whether samples that are nearer to each other than pixels are left out.
    pub(crate) is_on_screen: bool,
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
    Volume(PathBuf, Box<VolumeOptions>, Region),
    /// And the colour that it is drawn in whatever its file says.
    Mesh(PathBuf, Option<Rgba>),
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
        let subject = subject::of(&args, file.as_ref())?;
        let file = file.unwrap_or_default();
        let surfaces = surfaces(&args.iso, &file.surface)?;
        let is_mesh = matches!(subject, Subject::Mesh(..));
        let default = match surfaces.is_empty() && !is_mesh {
            true => ModeWord::Raycast,
            false => ModeWord::Surfaces,
        };
        let mode = args.mode.or(file.output.mode).unwrap_or(default);
        subject::check(&subject, mode, &surfaces)?;
        let mut clips: Vec<Clip> = file.clip.iter().map(clip).collect::<Result<_, _>>()?;
        let cap = if is_mesh { CapStyle::None } else { CapStyle::Solid };
        clips.extend(args.clip.iter().cloned().map(|ClipArg { half, surfaces }| Clip {
            half,
            surfaces,
            cap,
        }));
        check_use(&args, (mode, is_mesh), &clips)?;
        let viewpoint = viewpoint::of(&args, &file.camera)?;
        let [width, height] = file.output.size.unwrap_or(SIZE);
        let sides = NonZeroU32::new(width).zip(NonZeroU32::new(height));
        let size = sides.map(|(width, height)| Size { width, height });
        let size = args
            .size
            .or(size)
            .ok_or_else(|| UsageError("[output] size: expected two numbers above 0".into()))?;
        let model = model::of(args.preset, &file, mode)?;
        let channels = outputs::channels(&args, mode)?;
        let plot = outputs::plot(&args, &subject)?;
        let (targets, report) = outputs::targets(&args, &subject)?;
        Ok(Self {
            mode,
            surfaces,
            clips,
            viewpoints: viewpoint::around(viewpoint, args.frames.map_or(1, usize::from)),
            raster: model::raster(&file.light, mode)?
                .with_smoothing(args.smoothing.unwrap_or_default().into()),
            raycast: model::raycast(&file, &model, (mode, args.mode.is_some()))?,
            model,
            size,
            background: background(args.background.or(file.output.background)),
            depth: args.bits.into(),
            is_on_screen: args.lod == LodWord::Screen,
            is_plan: args.plan,
            is_sheet: args.sheet,
            channels,
            plot,
            subject,
            targets,
            report,
        })
    }

    /// The scene as that picture has it that needs most of surfaces.
    pub(crate) fn neediest(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        if self.channels.iter().any(|(channel, _)| *channel == Channel::Normal) {
            scene.raster = scene.raster.with_channel(Channel::Normal);
        }
        scene
    }
}

/// That what was typed is of use for what is shown.
fn check_use(
    args: &RenderArgs,
    (mode, is_mesh): (ModeWord, bool),
    clips: &[Clip],
) -> Result<(), UsageError> {
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
        _ if args.color.is_some() && !is_mesh => {
            "--color is of a mesh: a surface of a volume has its own, --iso V:COLOR or [[surface]]"
        }
        _ if args.lod != LodWord::Full && is_mesh => {
            "--lod is for the samples of a volume, which a mesh has not: leave it out"
        }
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
        let texture = surface.texture.as_ref().map(|table| texture(table, surface.color, color));
        let texture = texture
            .transpose()
            .map_err(|says| UsageError(format!("[[surface]] {number}, texture: {says}")))?;
        Ok(LookPlan { iso: surface.iso, name: surface.name.clone(), color, opacity, texture })
    };
    file.iter().enumerate().map(of_file).collect()
}

/// The texture of a surface: what is said of its colour, and which it has.
fn texture(table: &TextureTable, said: Option<Color>, own: Rgba) -> Result<SolidTexture, String> {
    let is_opaque = |Color(rgba): &Color| rgba.0[3] == u8::MAX;
    if !table.colors.iter().all(is_opaque) {
        return Err("expected colors as #rrggbb: the opacity is the surface's".into());
    }
    let color = |rgba: Rgba| {
        let [r, g, b, _] = rgba.to_linear();
        [r, g, b]
    };
    let colors = match table.colors[..] {
        [Color(second)] => [own, second],
        [Color(first), Color(second)] if said.is_none() => [first, second],
        [_, _] => return Err("expected one color, the other is the surface's, found two".into()),
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
