//! Surfaces of a volume whose index is kept: of the samples only rows around them are read.

use super::{report, surfaces, tell, tell_index, tell_singular, tell_written, write};
use crate::{
    Session,
    plan::{ExtractPlan, LevelPlan, Repeat},
    report::{Timings, VolumeFacts, timed},
};
use anyhow::Result;
use isokit::{
    mesh::TriMesh,
    pipeline::{ScanFile, SlabScan},
    refine::Refined,
};
use std::time::Instant;

/// A scan in its file with the index that is kept of it, and the isovalues.
pub(super) type Near = (SlabScan, Vec<f64>);

/// What only rows around surfaces are needed of: none where something looks at other samples too, as to find an isovalue, to
/// divide triangles or to fill the holes of cuts, nor where no index is kept, or the surfaces go through too much of the
/// volume.
pub(super) fn open(
    plan: &ExtractPlan,
    timings: &mut Timings,
    session: &Session<'_, '_>,
) -> Result<Option<Near>> {
    let isos: Option<Vec<f64>> = plan.levels.iter().map(LevelPlan::value).collect();
    let looks_elsewhere = plan.cuts()
        || !plan.refine.do_nothing()
        || !plan.color.is_empty()
        || plan.repeat != Repeat::Once;
    let (Some(isos), true, false) = (isos, plan.index, looks_elsewhere) else { return Ok(None) };
    let file = timed(&mut timings.read, || {
        ScanFile::open(&plan.input, &plan.volume, plan.space, &plan.region, &session.job)
    })?;
    let scan = if file.has_index() { file.into_slabs() } else { None };
    let Some(mut scan) = scan else { return Ok(None) };
    let index = timed(&mut timings.index, || scan.index(&session.job))?;
    // What a report says of all samples is looked for with them in memory.
    let is_told = plan.report.is_some() || session.console.is_verbose();
    if !scan.is_sparse(&isos) || is_told && !scan.has_statistics() {
        return Ok(None);
    }
    scan.notes().iter().for_each(|note| session.console.note(note));
    tell_index(&index, session);
    Ok(Some((scan, isos)))
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
    for ((surface, extracted), &iso) in surfaces.iter().zip(&extracted).zip(&isos) {
        let remark = scan.remark(iso, extracted.counts, &plan.surface, &session.job)?;
        tell(plan, surface, remark, session);
        tell_singular(extracted, &surface.name, session);
    }
    let context = scan.context(session.command.as_str());
    let written = timed(&mut timings.write, || write(plan, context, &surfaces, session))?;
    timings.total = start.elapsed().as_secs_f64();
    tell_written(&written, &timings, session);
    super::dump_scene(plan, &isos, session)?;
    if plan.report.is_none() && !session.console.is_verbose() {
        return Ok(String::new());
    }
    let found: Vec<_> = extracted.into_iter().map(|one| (one, Refined::default())).collect();
    let input = VolumeFacts::of_slabs(&plan.input, &scan, &scan.statistics(&session.job)?);
    report(plan, input, &surfaces, &written, (&found, None, timings), session)
}
