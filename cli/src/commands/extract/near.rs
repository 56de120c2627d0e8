//! Surfaces of a volume whose index is kept: of the samples only rows around them are read.

use super::{Made, finish, surfaces, tell, tell_index, tell_singular};
use crate::{
    Session,
    plan::{ExtractPlan, LevelPlan, Repeat},
    report::{Timings, VolumeFacts, timed},
};
use anyhow::Result;
use isokit::{
    job::Job,
    mesh::TriMesh,
    pipeline::{ScanFile, SlabScan},
    refine::Refined,
};
use std::time::Instant;

/// A scan in its file with the index that is kept of it, and the isovalues.
pub(super) type Near = (SlabScan, Vec<f64>);

/// The scan in a file, if only rows around surfaces are needed of it: none where something looks at other samples too, as to
/// find an isovalue, to divide triangles or to fill the holes of cuts, nor where no index is kept, or the surfaces go through
/// too much of the volume.
pub(super) fn of(plan: &ExtractPlan, file: &ScanFile, session: &Session<'_, '_>) -> Option<Near> {
    let looks_elsewhere = plan.cuts()
        || !plan.refine.do_nothing()
        || !plan.color.is_empty()
        || plan.repeat != Repeat::Once;
    if !plan.index || looks_elsewhere {
        return None;
    }
    let isos: Vec<f64> = plan.levels.iter().map(LevelPlan::value).collect::<Option<_>>()?;
    let mut scan = file.clone().into_slabs()?;
    let index = scan.kept_index()?;
    // What a report says of all samples is looked for with them in memory.
    let is_told = plan.report.is_some() || session.console.is_verbose();
    if !scan.is_sparse(&isos) || is_told && !scan.has_statistics() {
        return None;
    }
    scan.notes().iter().for_each(|note| session.console.note(note));
    tell_index(&index, session);
    Some((scan, isos))
}

/// Makes and writes the mesh; the report comes back as text, empty if there is to be none.
pub(super) fn extract(
    plan: &ExtractPlan,
    (scan, isos): Near,
    (start, mut timings): (Instant, Timings),
    session: &mut Session<'_, '_>,
) -> Result<String> {
    let mut meshes = vec![TriMesh::default(); isos.len()];
    let extracted = timed(&mut timings.extract, || {
        scan.whole_meshes_into(&isos, &plan.surface, &mut meshes, &session.job)
    })?;
    let surfaces = surfaces(&plan.levels, &isos, meshes);
    let found = extracted.into_iter().map(|one| (one, Refined::default())).collect();
    let made = Made { surfaces, found, colors: None };
    for (surface, iso, (extracted, _)) in made.each() {
        let remark = scan.remark(iso, extracted.counts, &plan.surface, &session.job)?;
        tell(plan, surface, remark, session);
        tell_singular(extracted, &surface.name, session);
    }
    let context = scan.context(session.command.as_str());
    let input = |job: &Job| Ok(VolumeFacts::of_slabs(&plan.input, &scan, &scan.statistics(job)?));
    finish(plan, made, (context, input), (start, timings), session)
}
