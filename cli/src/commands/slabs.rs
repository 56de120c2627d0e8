//! `extract --max-memory`: from a volume to a mesh, a few slices at a time.

use super::extract::{isos, tell_index, tell_singular};
use crate::{
    Session,
    fault::CallerError,
    plan::{ExtractPlan, LevelPlan, Stream},
    report::{
        EXTRACT_SCHEMA, ExtractReport, SlabCounts, SurfaceReport, Timings, VolumeFacts,
        peak_rss_bytes, simd, timed, to_json,
    },
    text::counted,
};
use anyhow::Result;
use isokit::{
    io::{MeshContext, MeshSpool, SurfaceHead, Written},
    job::{Job, OverLimit, Stopped},
    lanes::return_large_memory_when_freed,
    marching_cubes::{Budget, Extracted, Placement, Skipped},
    mesh::{Gauge, Gauged},
    pipeline::{PipelineError, SlabScan, SurfaceOptions},
};
use std::{path::Path, time::Instant};

/// What the process takes beside the extraction: the program itself, its threads, buffers of files.
const BASE: u64 = 40 << 20;

/// What writing takes of each surface, in pieces: one, and what is kept of those before.
const WRITTEN: u64 = 3;

/// The same with what finding out takes of each: one more, with its edges.
const GAUGED: u64 = 7;

/// Makes and writes the mesh; the report comes back as text, empty if there is to be none.
pub(super) fn extract(
    plan: &ExtractPlan,
    limit: u64,
    session: &mut Session<'_, '_>,
) -> Result<String> {
    let (start, mut timings) = (Instant::now(), Timings::default());
    return_large_memory_when_freed();
    let is_told = plan.report.is_some() || session.console.is_verbose();
    let mut scan = timed(&mut timings.read, || {
        SlabScan::open(&plan.input, &plan.volume, plan.space, &plan.region, &session.job)
    })?;
    if is_told {
        scan = scan.observed();
    }
    scan.notes().iter().for_each(|note| session.console.note(note));
    let budget = budget(plan, limit, &scan, if is_told { GAUGED } else { WRITTEN })?;
    if plan.index {
        let found = timed(&mut timings.index, || scan.index(&session.job))?;
        tell_index(&found, session);
    }
    let isos =
        timed(&mut timings.read, || isos(plan, |choice, job| scan.iso(choice, job), session))?;
    let heads = heads(&plan.levels, &isos);
    let Stream::File(path) = &plan.target.stream else {
        unreachable!("the plan has a file");
    };
    let spool = timed(&mut timings.write, || create(plan, path, &heads, &scan, session))?;
    let (spool, found, gauges) = timed(&mut timings.extract, || {
        pass(&scan, (&isos, &plan.surface, budget), (spool, is_told), &session.job)
    })?;
    for (head, extracted) in heads.iter().zip(&found) {
        tell(plan, &scan, (head, extracted), session)?;
        tell_singular(extracted, &head.name, session);
    }
    let written = timed(&mut timings.write, || spool.finish())?;
    timings.total = start.elapsed().as_secs_f64();
    super::extract::tell_written(&written, &timings, session);
    super::extract::dump_scene(plan, &isos, session)?;
    if !is_told {
        return Ok(String::new());
    }
    report(plan, &scan, (&heads, &found, &gauges), &written, timings, session)
}

/// Makes the surfaces; what they are is found out where it is told.
fn pass(
    scan: &SlabScan,
    (isos, surface, budget): (&[f64], &SurfaceOptions, Budget),
    (mut spool, is_told): (MeshSpool, bool),
    job: &Job,
) -> Result<(MeshSpool, Vec<Extracted>, Vec<Gauge>)> {
    if !is_told {
        let found = scan.meshes_into(isos, surface, budget, &mut spool, job);
        return Ok((spool, found.map_err(explained)?, vec![]));
    }
    let mut gauged = Gauged::new(spool, isos.len(), job);
    let found = scan.meshes_into(isos, surface, budget, &mut gauged, job).map_err(explained)?;
    let (spool, gauges) = gauged.finish().map_err(PipelineError::from)?;
    Ok((spool, found, gauges))
}

/// What may be in memory at a time.
fn budget(plan: &ExtractPlan, limit: u64, scan: &SlabScan, copies: u64) -> Result<Budget> {
    let beside = match plan.index {
        true => BASE.saturating_add(scan.index_bytes()),
        false => BASE,
    };
    let left = limit.saturating_sub(beside);
    let budget = scan.budget(left, (plan.levels.len() as u64, copies), &plan.surface);
    Ok(budget.map_err(|over| {
        let needed = over.needed.saturating_add(beside).div_ceil(1 << 20);
        let message = format!(
            "--max-memory is too little: the fewest slices at a time need {needed}MiB in all"
        );
        let advice = match plan.surface.extract.placement {
            Placement::Linear => "allow as much, or take a part of each slice with --roi",
            _ => "allow as much, take a part of each slice with --roi, or take --placement linear, which \
                  looks at fewer slices",
        };
        CallerError { message, advice }
    })?)
}

/// An error with what can be done about too little memory.
fn explained(error: PipelineError) -> anyhow::Error {
    let PipelineError::Stopped(Stopped::OverLimit(over)) = error else { return error.into() };
    let OverLimit { what, needed, limit } = over;
    let message = format!("--max-memory is too little: {what} needs {needed} bytes of {limit}");
    CallerError { message, advice: "allow more, or take a part of each slice with --roi" }.into()
}

fn heads(levels: &[LevelPlan], isos: &[f64]) -> Vec<SurfaceHead> {
    let head = |(level, &iso): (&LevelPlan, &f64)| SurfaceHead {
        name: level.name(iso),
        color: level.color,
        iso: Some(iso),
    };
    levels.iter().zip(isos).map(head).collect()
}

fn create(
    plan: &ExtractPlan,
    path: &Path,
    heads: &[SurfaceHead],
    scan: &SlabScan,
    session: &Session<'_, '_>,
) -> Result<MeshSpool> {
    let context =
        MeshContext { gltf_unit: plan.target.gltf_unit, ..scan.context(session.command.as_str()) };
    let normals = SlabScan::has_normals(&plan.surface);
    Ok(MeshSpool::create(path, heads.to_vec(), normals, &context, &session.job)?)
}

/// Says how large a surface is, and what is peculiar about it.
fn tell(
    plan: &ExtractPlan,
    scan: &SlabScan,
    (head, Extracted { counts, .. }): (&SurfaceHead, &Extracted),
    session: &Session<'_, '_>,
) -> Result<()> {
    let vertices = counted(counts.vertices, "vertex", "vertices");
    let triangles = counted(counts.triangles, "triangle", "triangles");
    session.console.info(&format!("{}: {vertices}, {triangles}", head.name));
    let iso = head.iso.unwrap_or(f64::NAN);
    let remark = scan.remark(iso, *counts, &plan.surface, &session.job)?;
    remark.iter().for_each(|remark| session.console.warn(&remark.to_string()));
    Ok(())
}

fn report(
    plan: &ExtractPlan,
    scan: &SlabScan,
    (heads, found, gauges): (&[SurfaceHead], &[Extracted], &[Gauge]),
    written: &Written,
    timings_s: Timings,
    session: &Session<'_, '_>,
) -> Result<String> {
    let of_surface =
        |((head, extracted), gauge): ((&SurfaceHead, &Extracted), &Gauge)| SurfaceReport {
            name: head.name.clone(),
            iso: head.iso,
            color: head.color.map(|color| color.to_string()),
            singular_cells: Some(extracted.singular_cells),
            refined: None,
            counts: SlabCounts::of(gauge),
            shortfalls: None,
        };
    let statistics = scan.statistics(&session.job)?;
    let report = ExtractReport {
        schema: EXTRACT_SCHEMA,
        command: &session.command,
        input: VolumeFacts::of_slabs(&plan.input, scan, &statistics),
        surfaces: heads.iter().zip(found).zip(gauges).map(of_surface).collect(),
        vertex_colors: None,
        outputs: &written.files,
        warnings: &written.warnings,
        merged_vertices: written.merged_vertices,
        skipped: found.first().map_or(Skipped::default(), |one| one.skipped).into(),
        timings_s,
        threads: session.job.threads.count(),
        simd: simd(),
        peak_rss_bytes: peak_rss_bytes(),
        version: env!("CARGO_PKG_VERSION"),
    };
    Ok(to_json(&report)?)
}
