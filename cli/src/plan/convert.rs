//! What `convert` will do.

use super::{
    MeshTarget, Stream,
    places::Places,
    target::{is_volume, mesh_format, neither},
};
use crate::{
    args::{ConvertArgs, SpaceArg},
    fault::UsageError,
};
use anyhow::Result;
use isokit::{
    io::{VolumeOptions, mesh_files, volume_files},
    pipeline::TargetSpace,
};
use std::path::PathBuf;

/// Everything that `convert` needs to know.
#[derive(Debug)]
pub(crate) struct ConvertPlan {
    pub(crate) input: PathBuf,
    pub(crate) space: TargetSpace,
    pub(crate) to: ConvertTo,
}

/// What the input becomes.
#[derive(Debug)]
pub(crate) enum ConvertTo {
    Mesh { target: MeshTarget, weld: Option<f64> },
    Volume { path: PathBuf, options: VolumeOptions },
}

impl ConvertPlan {
    pub(crate) fn new(args: ConvertArgs) -> Result<Self> {
        let stream = Stream::named(&args.output.output)?;
        let to = match stream {
            Stream::File(path) if is_volume(&path) => to_volume(&args, path)?,
            Stream::File(path) if mesh_format(&path).is_none() => return Err(neither(&path).into()),
            Stream::File(_) | Stream::Stdout => to_mesh(&args)?,
        };
        let plan = Self { input: args.input, space: args.space.into(), to };
        plan.check_files(&[])?;
        Ok(plan)
    }

    /// Whether every file has a place of its own, if surfaces have these names.
    pub(crate) fn check_files(&self, names: &[&str]) -> Result<(), UsageError> {
        let files = match &self.to {
            ConvertTo::Volume { path, .. } => volume_files(path),
            ConvertTo::Mesh { target, .. } => match &target.stream {
                Stream::File(path) => mesh_files(path, names.iter().copied()),
                Stream::Stdout => vec![],
            },
        };
        let mut places = Places::of_input(&self.input);
        files.iter().try_for_each(|file| places.add("--output", file))
    }
}

fn to_mesh(args: &ConvertArgs) -> Result<ConvertTo> {
    if !args.volume.is_empty() {
        let says = "the output is a mesh: --dims --dtype --skip --spacing --origin --volume-index \
                    --quantity are for volumes";
        return Err(UsageError(says.into()).into());
    }
    if args.space == SpaceArg::Index {
        let says = "a mesh has no samples to number: --space index is for volumes";
        return Err(UsageError(says.into()).into());
    }
    let target = MeshTarget::new(&args.output, 1)?;
    Ok(ConvertTo::Mesh { target, weld: args.weld.weld })
}

fn to_volume(args: &ConvertArgs, path: PathBuf) -> Result<ConvertTo> {
    let output = &args.output;
    let is_of_mesh =
        output.format.is_some() || output.gltf_unit.is_some() || args.weld.weld.is_some();
    if is_of_mesh {
        let says = "the output is a volume: --format --gltf-unit --weld are for meshes";
        return Err(UsageError(says.into()).into());
    }
    Ok(ConvertTo::Volume { path, options: args.volume.options() })
}
