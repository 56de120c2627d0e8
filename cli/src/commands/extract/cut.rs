//! What planes and another volume leave of surfaces.

use super::tell_notes;
use crate::{
    Session,
    fault::CallerError,
    plan::{ExtractPlan, LevelPlan},
};
use anyhow::Result;
use isokit::{
    io::VolumeOptions,
    marching_cubes::Extracted,
    mesh::TriMesh,
    pipeline::{Mask, PipelineError, Region, Scan, ScanFile, SurfaceOptions, TargetSpace},
};

/// The volume that keeps something, if there is one. Looked for before anything else is read.
pub(super) fn open(plan: &ExtractPlan, session: &Session<'_, '_>) -> Result<Option<ScanFile>> {
    let Some((path, _)) = &plan.mask else { return Ok(None) };
    let (options, space) = (VolumeOptions::default(), TargetSpace::Source);
    let file = ScanFile::open(path, &options, space, &Region::Whole, &session.job)?;
    tell_notes(path, file.notes(), session);
    Ok(Some(file))
}

/// What it keeps of a scan. A volume that keeps nothing at all is not the one that was meant.
pub(super) fn mask(
    plan: &ExtractPlan,
    file: Option<ScanFile>,
    scan: &Scan,
    session: &Session<'_, '_>,
) -> Result<Option<Mask>> {
    let (Some((path, values)), Some(file)) = (&plan.mask, file) else { return Ok(None) };
    let other = file.read(&session.job)?;
    tell_notes(path, scan.differences(&other), session);
    let chosen = (!values.is_empty()).then_some(&values[..]);
    let mask = scan.mask(&other, chosen, &session.job).map_err(PipelineError::from)?;
    if mask.count() > 0 {
        return Ok(Some(mask));
    }
    let (expected, advice) = match chosen {
        Some(_) => ("one of --mask-values", "name values that occur there, or another volume"),
        None => ("a value other than 0", "take another volume"),
    };
    let found = match other.statistics(&session.job)?.range {
        Some([least, greatest]) => format!("the samples range from {least} to {greatest}"),
        None => "all are NaN".into(),
    };
    let message = format!("{}: no sample has {expected}: {found}", path.display());
    Err(CallerError { message, advice }.into())
}

/// A mesh for each isovalue, of what is kept of it.
pub(super) fn meshes(
    plan: &ExtractPlan,
    scan: &Scan,
    (isos, mask, options): (&[f64], Option<&Mask>, &SurfaceOptions),
    session: &Session<'_, '_>,
) -> Result<Vec<(TriMesh, Extracted)>, PipelineError> {
    let cut = |(level, &iso): (&LevelPlan, &f64)| {
        let halves = plan.halves_of(&level.name(iso));
        scan.clipped_mesh(iso, (&halves, mask), options, &session.job)
    };
    plan.levels.iter().zip(isos).map(cut).collect()
}
