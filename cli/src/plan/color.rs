//! How the vertices of a mesh will be coloured.

use super::MeshTarget;
use crate::{args::ColorArgs, fault::UsageError};
use isokit::{
    field::Between,
    io::Format,
    render::{ColorMap, Pattern},
};
use std::path::PathBuf;

/// What vertices get.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ColorPlan {
    /// The volume whose values they get, and what is between its samples.
    pub(crate) attribute: Option<(PathBuf, Between)>,
    /// By which map values become colours, and where that begins and ends if not at the values found.
    pub(crate) map: Option<(ColorMap, Option<[f64; 2]>)>,
    /// A pattern, and how large if that was said.
    pub(crate) texture: Option<(Pattern, Option<f64>)>,
}

impl ColorPlan {
    pub(crate) fn new(args: ColorArgs, target: &MeshTarget) -> Result<Self, UsageError> {
        let plan = Self {
            attribute: args.attribute.map(|path| (path, args.attribute_kernel.into())),
            map: args.colormap.map(|arg| (arg.map, arg.range)),
            texture: args.texture.map(|arg| (arg.pattern, arg.size)),
        };
        if target.format == Format::Stl && !plan.is_empty() {
            let says = "STL holds neither values nor colours of vertices: write .ply or .glb";
            return Err(UsageError(says.into()));
        }
        Ok(plan)
    }

    /// Whether they get nothing.
    pub(crate) fn is_empty(&self) -> bool {
        self.attribute.is_none() && self.texture.is_none()
    }
}
