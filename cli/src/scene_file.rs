//! The scene file: what is to be seen, as TOML. Unknown words are refused with their line.

use crate::{args::SampleType, fault::CallerError};
use anyhow::{Context, Result};
use isokit::{
    mesh::Rgba,
    pipeline::{IsoChoice, Region},
    volume::Quantity,
};
use serde::{Deserialize, Deserializer, de::Error};
use std::{fmt::Display, fs, path::Path, str::FromStr};

/// All that a file may say.
#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct SceneFile {
    pub(crate) volume: Option<VolumeTable>,
    #[serde(default)]
    pub(crate) surface: Vec<SurfaceTable>,
    #[serde(default)]
    pub(crate) clip: Vec<ClipTable>,
    #[serde(default)]
    pub(crate) material: Vec<MaterialTable>,
    pub(crate) transfer: Option<TransferTable>,
    #[serde(default)]
    pub(crate) camera: CameraTable,
    #[serde(default)]
    pub(crate) light: LightTable,
    #[serde(default)]
    pub(crate) sampling: SamplingTable,
    #[serde(default)]
    pub(crate) output: OutputTable,
}

#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct VolumeTable {
    /// Beside the scene file, unless it is absolute.
    pub(crate) path: String,
    /// What the file does not say, or says wrongly, as on the command line.
    pub(crate) dims: Option<[u64; 3]>,
    #[serde(default, deserialize_with = "parsed")]
    pub(crate) dtype: Option<SampleType>,
    pub(crate) skip: Option<u64>,
    pub(crate) spacing: Option<[f64; 3]>,
    pub(crate) origin: Option<[f64; 3]>,
    /// Which one of a file that holds several.
    pub(crate) index: Option<u64>,
    /// What is read of one of vectors.
    #[serde(default, deserialize_with = "parsed")]
    pub(crate) quantity: Option<Quantity>,
    /// The part that is looked at, in samples or in world units, as on the command line.
    #[serde(default, deserialize_with = "samples")]
    pub(crate) roi: Option<Region>,
    #[serde(default, deserialize_with = "world")]
    pub(crate) roi_mm: Option<Region>,
}

#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct SurfaceTable {
    pub(crate) name: Option<String>,
    #[serde(deserialize_with = "iso")]
    pub(crate) iso: IsoChoice,
    pub(crate) color: Option<Color>,
    pub(crate) opacity: Option<f32>,
    pub(crate) texture: Option<TextureTable>,
}

#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct TextureTable {
    pub(crate) pattern: PatternWord,
    /// In world units.
    pub(crate) size: f64,
    /// If there is one, the other is the surface's.
    pub(crate) colors: Vec<Color>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(crate) enum PatternWord {
    Checker,
    Marble,
    Wood,
    Granite,
}

#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct MaterialTable {
    /// For those who read the file.
    #[serde(rename = "name")]
    pub(crate) _name: Option<String>,
    /// Pure from one value to the other.
    pub(crate) values: [f64; 2],
    pub(crate) color: Color,
    pub(crate) density: Option<f64>,
}

#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct ClipTable {
    /// A normal n and a number d: kept is n · x <= d.
    pub(crate) plane: [f64; 4],
    pub(crate) surfaces: Option<Vec<String>>,
    #[serde(default)]
    pub(crate) cap: CapWord,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(crate) enum CapWord {
    #[default]
    None,
    Solid,
    Slice,
}

#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct TransferTable {
    pub(crate) points: Option<Vec<(f64, Color)>>,
    /// Values that are seen among others that are not.
    pub(crate) peaks: Option<Vec<PeakTable>>,
    pub(crate) preset: Option<PresetWord>,
    /// Functions of values at slopes.
    pub(crate) rows: Option<Vec<RowTable>>,
    pub(crate) gradient: Option<Fade>,
    pub(crate) unit: Option<f64>,
}

#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct PeakTable {
    pub(crate) value: f64,
    pub(crate) width: f64,
    pub(crate) color: Color,
}

#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct RowTable {
    /// In values per world unit.
    pub(crate) gradient: f64,
    pub(crate) points: Vec<(f64, Color)>,
}

/// Whether what is even fades.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(untagged, expecting = "expected true, false or a slope in values per world unit")]
pub(crate) enum Fade {
    Word(bool),
    /// What is as steep as that, or more, does not.
    Slope(f64),
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum PresetWord {
    /// What is above Otsu's threshold, lighter the higher it is
    Auto,
    /// Bone in Hounsfield units
    CtBone,
    /// Translucent skin with bone behind it, in Hounsfield units
    CtSkin,
    /// Tissue of a magnetic resonance image, dark parts as a veil
    Mr,
    /// Peaks of a density map, by standard deviations above the mean
    Density,
}

#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraTable {
    pub(crate) projection: Option<ProjectionWord>,
    pub(crate) from: Option<[f64; 3]>,
    pub(crate) at: Option<At>,
    pub(crate) up: Option<[f64; 3]>,
    pub(crate) fov: Option<f64>,
    pub(crate) height: Option<f64>,
    pub(crate) view: Option<SideWord>,
    pub(crate) orbit: Option<f64>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ProjectionWord {
    Perspective,
    Parallel,
}

#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(untagged, expecting = "expected \"center\" or three numbers")]
pub(crate) enum At {
    Center(Center),
    Place([f64; 3]),
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
pub(crate) enum Center {
    #[serde(rename = "center")]
    Center,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub(crate) enum SideWord {
    /// From the front
    #[default]
    Anterior,
    /// From behind
    Posterior,
    /// From the body's left
    Left,
    /// From the body's right
    Right,
    /// From above the head
    Superior,
    /// From below the feet
    Inferior,
}

#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct LightTable {
    #[serde(default)]
    pub(crate) shading: ShadingWord,
    pub(crate) ambient: Option<f32>,
    pub(crate) diffuse: Option<f32>,
    pub(crate) specular: Option<f32>,
    pub(crate) shininess: Option<u16>,
    /// What the surface between two materials hides.
    pub(crate) surface: Option<f32>,
    /// Where light comes from.
    pub(crate) from: Option<[f64; 3]>,
    pub(crate) shadows: Option<bool>,
    pub(crate) occlusion: Option<f32>,
    /// How much of the light from `from` particles scatter, and how much ahead.
    pub(crate) scatter: Option<f32>,
    pub(crate) ahead: Option<f32>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ShadingWord {
    #[default]
    Gradient,
    None,
    Mixture,
}

#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct SamplingTable {
    pub(crate) step: Option<f64>,
    #[serde(default)]
    pub(crate) jitter: bool,
    #[serde(default)]
    pub(crate) integrated: bool,
    pub(crate) error: Option<f32>,
    #[serde(default)]
    pub(crate) kernel: KernelWord,
}

/// How values between samples are made of them.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum KernelWord {
    #[default]
    Linear,
    CatmullRom,
}

#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct OutputTable {
    pub(crate) size: Option<[u32; 2]>,
    pub(crate) mode: Option<ModeWord>,
    pub(crate) background: Option<Ground>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ModeWord {
    /// Isosurfaces, or the surfaces of a mesh
    Surfaces,
    /// Isosurfaces, found by rays without a mesh
    IsoRaycast,
    /// The values themselves, through a transfer function
    Raycast,
    /// The same by samples that are laid on each other: softer
    Splat,
}

impl ModeWord {
    /// Whether values are shown, and not surfaces.
    pub(crate) fn shows_values(self) -> bool {
        matches!(self, Self::Raycast | Self::Splat)
    }
}

/// A colour in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Color(pub(crate) Rgba);

/// A background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ground {
    Transparent,
    Color(Rgba),
}

impl SceneFile {
    /// The scene in a file.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let text = fs::read_to_string(path)
            .with_context(|| format!("{}: cannot read the scene", path.display()))?;
        toml::from_str(&text).map_err(|error| {
            let message = format!("{}: {}", path.display(), error.to_string().trim_end());
            let advice = "`isokit render --help` shows a scene file";
            CallerError { message, advice }.into()
        })
    }
}

impl FromStr for Ground {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("expected transparent or an opaque #rrggbb, found {text:?}");
        match text {
            "transparent" => Ok(Self::Transparent),
            color => match color.parse() {
                Ok(color @ Rgba([.., u8::MAX])) => Ok(Self::Color(color)),
                _ => Err(expected()),
            },
        }
    }
}

impl<'de> Deserialize<'de> for Ground {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map(Self).map_err(D::Error::custom)
    }
}

/// A word that means the same on the command line.
fn parsed<'de, T, D>(deserializer: D) -> Result<Option<T>, D::Error>
where
    T: FromStr<Err: Display>,
    D: Deserializer<'de>,
{
    String::deserialize(deserializer)?.parse().map(Some).map_err(D::Error::custom)
}

fn samples<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Region>, D::Error> {
    let text = String::deserialize(deserializer)?;
    Region::parse_samples(&text).map(Some).map_err(D::Error::custom)
}

fn world<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Region>, D::Error> {
    let text = String::deserialize(deserializer)?;
    Region::parse_world(&text).map(Some).map_err(D::Error::custom)
}

fn iso<'de, D: Deserializer<'de>>(deserializer: D) -> Result<IsoChoice, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "expected a number, \"auto\" or a percentage such as \"50%\"")]
    enum Iso {
        Value(f64),
        Word(String),
    }
    match Iso::deserialize(deserializer)? {
        Iso::Value(value) if value.is_finite() => Ok(IsoChoice::Value(value)),
        Iso::Value(value) => Err(D::Error::custom(format!("an isovalue is finite, found {value}"))),
        Iso::Word(word) => word.parse().map_err(D::Error::custom),
    }
}

#[cfg(test)]
mod tests;
