//! What planes and another volume leave of surfaces.

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
    pipeline::{Mask, PipelineError, Region, Scan, SurfaceOptions, TargetSpace},
};

/// What the planned volume keeps of a scan; none if there is none. A volume that keeps nothing at all is not the one that was
/// meant.
pub(super) fn mask(
    plan: &ExtractPlan,
    scan: &Scan,
    session: &Session<'_, '_>,
) -> Result<Option<Mask>> {
    let Some((path, values)) = &plan.mask else { return Ok(None) };
    let (options, space) = (VolumeOptions::default(), TargetSpace::Source);
    let other = Scan::open(path, &options, space, &Region::Whole, &session.job)?;
    let name = path.display();
    let notes = other.notes().iter().cloned().chain(scan.differences(&other));
    notes.for_each(|note| session.console.note(&format!("{name}: {note}")));
    let chosen = (!values.is_empty()).then_some(&values[..]);
    let mask = scan.mask(&other, chosen, &session.job).map_err(PipelineError::from)?;
    if mask.count() > 0 {
        return Ok(Some(mask));
    }
    let found = match other.statistics(&session.job)?.range {
        Some([least, greatest]) => format!("they range from {least} to {greatest}"),
        None => "all are NaN".into(),
    };
    let expected = match chosen {
        Some(_) => "one of --mask-values",
        None => "a value other than 0",
    };
    let message = format!("{name}: no sample has {expected}, {found}");
    Err(CallerError { message, advice: "name values that occur there, or another volume" }.into())
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
