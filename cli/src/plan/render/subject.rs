//! What is looked at.

use super::{LookPlan, Subject};
use crate::{
    args::{RenderArgs, SampleType},
    fault::UsageError,
    plan::target::mesh_format,
    scene_file::{ModeWord, SceneFile, VolumeTable},
};
use isokit::io::{RawLayout, VolumeOptions};
use std::path::Path;

/// What is looked at: what the scene names, or what was typed.
pub(super) fn of(args: &RenderArgs, file: Option<&SceneFile>) -> Result<Subject, UsageError> {
    let Some(file) = file else {
        return match mesh_format(&args.input) {
            Some(_) if !args.volume.is_empty() => {
                let says = "a mesh has no samples: leave out --quantity, --spacing and what else says how a volume is read";
                Err(UsageError(says.into()))
            }
            Some(_) if args.part.region().is_some() => Err(UsageError(
                "--roi is of the samples of a volume, which a mesh has not: leave it out".into(),
            )),
            Some(_) => Ok(Subject::Mesh(args.input.clone(), args.color)),
            None => {
                let region = args.part.region().unwrap_or_default();
                Ok(Subject::Volume(args.input.clone(), args.volume.options().into(), region))
            }
        };
    };
    let Some(volume) = &file.volume else {
        let says = "the scene names no volume: [volume] with path = \"…\" does";
        return Err(UsageError(format!("{}: {says}", args.input.display())));
    };
    let folder = args.input.parent().unwrap_or(Path::new(""));
    if volume.roi.is_some() && volume.roi_mm.is_some() {
        return Err(UsageError("[volume]: expected either roi or roi_mm, found both".into()));
    }
    let region = args.part.region().or(volume.roi).or(volume.roi_mm).unwrap_or_default();
    let options = described(volume, args.volume.options())?;
    Ok(Subject::Volume(folder.join(&volume.path), options.into(), region))
}

/// What was typed of a volume, or else what the scene says.
fn described(table: &VolumeTable, typed: VolumeOptions) -> Result<VolumeOptions, UsageError> {
    let raw = match (table.dims, table.dtype) {
        (Some(dims), Some(SampleType { dtype, endian })) => {
            Some(RawLayout { dims, dtype, endian, skip: table.skip.unwrap_or(0) })
        }
        (None, None) if table.skip.is_none() => None,
        _ => {
            let says = "[volume]: expected dims and dtype together, and skip with them or not";
            return Err(UsageError(says.into()));
        }
    };
    let mut options = typed;
    options.raw = options.raw.or(raw);
    options.spacing = options.spacing.or(table.spacing);
    options.origin = options.origin.or(table.origin);
    options.volume_index = options.volume_index.or(table.index);
    options.quantity = options.quantity.or(table.quantity);
    Ok(options)
}

pub(super) fn check(
    subject: &Subject,
    mode: ModeWord,
    surfaces: &[LookPlan],
) -> Result<(), UsageError> {
    let says = match (subject, mode) {
        (Subject::Mesh(..), ModeWord::Raycast | ModeWord::IsoRaycast | ModeWord::Splat) => {
            "a mesh has no values for rays to go through: leave out --mode"
        }
        (Subject::Mesh(..), _) if !surfaces.is_empty() => "a mesh has no values: leave out --iso",
        (Subject::Volume(..), ModeWord::Surfaces | ModeWord::IsoRaycast) if surfaces.is_empty() => {
            "no surface is named: give --iso, or [[surface]] in the scene"
        }
        _ => return Ok(()),
    };
    Err(UsageError(says.into()))
}
