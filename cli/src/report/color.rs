//! What vertices were given besides their place.

use serde::Serialize;

/// The values and colours of vertices, where there are any.
#[derive(Debug, Default, Serialize)]
pub(crate) struct ColorReport {
    /// The volume whose values they have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) attribute: Option<AttributeReport>,
    /// By which map they are coloured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) colormap: Option<ColorMapReport>,
    /// By which pattern.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) texture: Option<TextureReport>,
}

#[derive(Debug, Serialize)]
pub(crate) struct AttributeReport {
    pub(crate) path: String,
    pub(crate) kernel: &'static str,
    /// How many numbers a colour has, if the volume is of colours.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) channels: Option<usize>,
    /// Least and greatest at a vertex of any surface; null if none has a value, or they are colours.
    pub(crate) range: Option<[f64; 2]>,
    /// Vertices outside of the volume, or where it has no value.
    pub(crate) without_value: u64,
}

#[derive(Debug, Serialize)]
pub(crate) struct ColorMapReport {
    pub(crate) name: &'static str,
    /// The values of its first and last colour.
    pub(crate) range: [f64; 2],
}

#[derive(Debug, Serialize)]
pub(crate) struct TextureReport {
    pub(crate) pattern: String,
    /// In units of the mesh.
    pub(crate) size: f64,
}
