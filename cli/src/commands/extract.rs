//! `extract`: from a volume to a mesh.

mod attribute;
mod color;
mod cut;
mod near;
mod scene;
mod shape;

use super::{check::sentence, write_text};
use crate::{
    Exit, Session,
    plan::{ExtractPlan, LevelPlan, Repeat, Stream},
    report::{
        ColorReport, EXTRACT_SCHEMA, ExtractReport, MeshCounts, RefineReport, SurfaceReport,
        Timings, VolumeFacts, median, peak_rss_bytes, simd, timed, to_json,
    },
    text::{counted, grouped},
};
use anyhow::Result;
use isokit::{
    io::{MeshContext, Written, write_mesh, write_mesh_to},
    job::Job,
    lanes::return_freed_memory,
    marching_cubes::{Extracted, Skipped},
    mesh::{Surface, TriMesh, topology},
    pipeline::{Index, IsoChoice, Mask, PipelineError, Region, Remark, Scan, ScanFile},
    refine::{Refined, Subdivision},
};
use std::{path::Path, time::Instant};

pub(crate) fn run(plan: &ExtractPlan, session: &mut Session<'_, '_>) -> Result<Exit> {
    let text = session.watching(|session| match (plan.shape, plan.max_memory) {
        (Some(spacing), _) => shape::extract(plan, spacing, session),
        (None, Some(limit)) => super::slabs::extract(plan, limit, session),
        (None, None) => extract(plan, session),
    })?;
    write_text(plan.report.as_ref(), &text, session)?;
    Ok(Exit::Done)
}

/// Reads the part that is looked at; to make an index, which is of the whole volume, all of that.
fn read(
    plan: &ExtractPlan,
    file: ScanFile,
    session: &Session<'_, '_>,
) -> Result<Scan, PipelineError> {
    match plan.index && file.lattice().is_cropped() && !file.has_index() {
        true => {
            let whole = open(plan, &Region::Whole, session)?;
            Ok(whole.read(&session.job)?.cropped(&plan.region)?)
        }
        false => file.read(&session.job),
    }
}

fn open(
    plan: &ExtractPlan,
    region: &Region,
    session: &Session<'_, '_>,
) -> Result<ScanFile, PipelineError> {
    ScanFile::open(&plan.input, &plan.volume, plan.space, region, &session.job)
}

/// Makes and writes the mesh; the report comes back as text, empty if there is to be none.
fn extract(plan: &ExtractPlan, session: &mut Session<'_, '_>) -> Result<String> {
    let (start, mut timings) = (Instant::now(), Timings::default());
    let attribute = attribute::open(&plan.color, plan.target.format, session)?;
    let mask = cut::open(plan, session)?;
    let file = timed(&mut timings.read, || open(plan, &plan.region, session))?;
    if let Some(near) = timed(&mut timings.index, || near::of(plan, &file, session)) {
        return near::extract(plan, near, (start, timings), session);
    }
    let mut scan = timed(&mut timings.read, || read(plan, file, session))?;
    scan.notes().iter().for_each(|note| session.console.note(note));
    if plan.index {
        let found = timed(&mut timings.index, || scan.index(&session.job))?;
        tell_index(&found, session);
    }
    let isos = isos(plan, |choice, job| scan.iso(choice, job), session)?;
    let mask = timed(&mut timings.read, || cut::mask(plan, mask, &scan, session))?;
    let with = (&isos[..], mask.as_ref());
    let (meshes, extracted) = meshes(plan, &scan, with, &mut timings, session)?;
    let mut surfaces = surfaces(&plan.levels, &isos, meshes);
    let refined = timed(&mut timings.mend, || refined(plan, &scan, &mut surfaces, session))?;
    let colors = timed(&mut timings.mend, || {
        color::color((&plan.color, attribute), &scan, &mut surfaces, session)
    })?;
    let made = Made { surfaces, found: extracted.into_iter().zip(refined).collect(), colors };
    for (surface, iso, (extracted, refined)) in made.each() {
        let remark = scan.remark(iso, extracted.counts, &plan.surface, &session.job)?;
        tell(plan, surface, remark, session);
        tell_singular(extracted, &surface.name, session);
        tell_refined(plan, refined, &surface.name, session);
    }
    let context = scan.context(session.command.as_str());
    let input = |job: &Job| Ok(VolumeFacts::of(&plan.input, &scan, &scan.statistics(job)?));
    finish(plan, made, (context, input), (start, timings), session)
}

/// What was made of a volume or a shape.
struct Made {
    surfaces: Vec<Surface>,
    /// Of each surface, in their order.
    found: Vec<(Extracted, Refined)>,
    colors: Option<ColorReport>,
}

impl Made {
    /// Each surface with its isovalue.
    fn each(&self) -> impl Iterator<Item = (&Surface, f64, &(Extracted, Refined))> {
        let each = self.surfaces.iter().zip(&self.found);
        each.map(|(surface, found)| (surface, surface.iso.unwrap_or(f64::NAN), found))
    }
}

/// Writes what was made. `input` is asked for what there is to say of the volume only where that is said.
fn finish(
    plan: &ExtractPlan,
    made: Made,
    (context, input): (MeshContext, impl FnOnce(&Job) -> Result<VolumeFacts, PipelineError>),
    (start, mut timings): (Instant, Timings),
    session: &mut Session<'_, '_>,
) -> Result<String> {
    let written = timed(&mut timings.write, || write(plan, context, &made.surfaces, session))?;
    timings.total = start.elapsed().as_secs_f64();
    tell_written(&written, &timings, session);
    let isos: Vec<f64> = made.each().map(|(_, iso, _)| iso).collect();
    dump_scene(plan, &isos, session)?;
    if plan.report.is_none() && !session.console.is_verbose() {
        return Ok(String::new());
    }
    report(input(&session.job)?, (plan, made), (&written, timings), session)
}

/// Writes what was made as a scene, if that is wanted.
pub(super) fn dump_scene(
    plan: &ExtractPlan,
    isos: &[f64],
    session: &mut Session<'_, '_>,
) -> Result<()> {
    let Some(path) = &plan.dump_scene else { return Ok(()) };
    write_text(Some(&Stream::File(path.clone())), &scene::text(plan, isos)?, session)?;
    session.console.info(&format!("wrote {}", path.display()));
    Ok(())
}

/// Says where the mesh went, what is to be known about that, and how long steps took.
pub(super) fn tell_written(written: &Written, timings: &Timings, session: &Session<'_, '_>) {
    written.warnings.iter().for_each(|warning| session.console.warn(warning));
    for file in &written.files {
        session.console.info(&format!("wrote {}", file.display()));
    }
    let Timings { read, index, extract, mend, write, total, .. } = timings;
    session.console.detail(&format!(
        "read {read:.3} s, index {index:.3} s, extract {extract:.3} s, mend {mend:.3} s, \
         write {write:.3} s, total {total:.3} s"
    ));
}

/// Says what is to be known of another file.
fn tell_notes(
    path: &Path,
    notes: impl IntoIterator<Item = impl AsRef<str>>,
    session: &Session<'_, '_>,
) {
    let name = path.display();
    let notes = notes.into_iter();
    notes.for_each(|note| session.console.note(&format!("{name}: {}", note.as_ref())));
}

/// Says where the index is, if that is new.
pub(super) fn tell_index(found: &Index, session: &Session<'_, '_>) {
    match found {
        Index::Read(_) => session.console.detail(&found.to_string()),
        Index::Made { .. } => session.console.note(&found.to_string()),
        _ => session.console.warn(&found.to_string()),
    }
}

/// The isovalues that were meant. What was chosen for the user is told; names after it may turn out to be
/// those of other files.
pub(super) fn isos(
    plan: &ExtractPlan,
    find: impl Fn(IsoChoice, &Job) -> Result<f64, PipelineError>,
    session: &Session<'_, '_>,
) -> Result<Vec<f64>> {
    let iso = |level: &LevelPlan| {
        let iso = find(level.iso, &session.job)?;
        if !matches!(level.iso, IsoChoice::Value(_)) {
            session.console.note(&format!("--iso {} is {iso} here", level.iso));
        }
        Ok(iso)
    };
    let isos = plan.levels.iter().map(iso).collect::<Result<Vec<f64>>>()?;
    plan.check_names(&isos)?;
    Ok(isos)
}

/// Says in how many cells the field itself touches.
pub(super) fn tell_singular(extracted: &Extracted, name: &str, session: &Session<'_, '_>) {
    if extracted.singular_cells > 0 {
        let cells = counted(extracted.singular_cells, "cell", "cells");
        session.console.detail(&format!("{name}: a saddle is exactly on the isovalue in {cells}"));
    }
}

/// A mesh for each isovalue, made as often as was asked for, and what can be said of each.
fn meshes(
    plan: &ExtractPlan,
    scan: &Scan,
    (isos, mask): (&[f64], Option<&Mask>),
    timings: &mut Timings,
    session: &Session<'_, '_>,
) -> Result<(Vec<TriMesh>, Vec<Extracted>)> {
    let surface = plan.surface.before(&plan.refine);
    if plan.cuts() {
        let made = timed(&mut timings.extract, || {
            cut::meshes(plan, scan, (isos, mask, &surface), session)
        });
        return Ok(made?.into_iter().unzip());
    }
    let make = |meshes: &mut [TriMesh]| scan.meshes_into(isos, &surface, meshes, &session.job);
    let fresh = || vec![TriMesh::default(); isos.len()];
    let (runs, is_warm) = match plan.repeat {
        Repeat::Once => (1, false),
        Repeat::Cold(runs) => (runs.get(), false),
        Repeat::Warm(runs) => (runs.get(), true),
    };
    let (mut meshes, mut all, mut extracted) = (fresh(), vec![], vec![]);
    if is_warm {
        make(&mut meshes)?;
    }
    for _ in 0..runs {
        if !is_warm {
            meshes = fresh();
            return_freed_memory(); // what the last run took goes back before the clock starts
        }
        let mut seconds = 0.0;
        extracted = timed(&mut seconds, || make(&mut meshes))?;
        all.push(seconds);
    }
    timings.extract = median(&all);
    timings.extract_all = (plan.repeat != Repeat::Once).then_some(all);
    Ok((meshes, extracted))
}

/// The meshes with what files say of them.
fn surfaces(levels: &[LevelPlan], isos: &[f64], meshes: Vec<TriMesh>) -> Vec<Surface> {
    let surface = |((level, &iso), mesh): ((&LevelPlan, &f64), TriMesh)| Surface {
        name: level.name(iso),
        color: level.color,
        iso: Some(iso),
        mesh,
    };
    levels.iter().zip(isos).zip(meshes).map(surface).collect()
}

/// Brings the meshes nearer to their field, if that is wanted.
fn refined(
    plan: &ExtractPlan,
    scan: &Scan,
    surfaces: &mut [Surface],
    session: &Session<'_, '_>,
) -> Result<Vec<Refined>> {
    let options = plan.refine.with_file_scale(plan.target.file_scale(scan.frame().unit));
    let refine = |surface: &mut Surface| {
        let iso = surface.iso.unwrap_or(f64::NAN);
        Ok(scan.refine(iso, &mut surface.mesh, (&options, &plan.surface), &session.job)?)
    };
    surfaces.iter_mut().map(refine).collect()
}

/// Says what became of a surface after it was extracted, and what not.
fn tell_refined(plan: &ExtractPlan, refined: &Refined, name: &str, session: &Session<'_, '_>) {
    let Refined { new_vertices, unprojected, balanced, unbalanced, .. } = *refined;
    if plan.refine.creases.is_some() {
        let vertices = counted(refined.creased, "vertex is", "vertices are");
        session.console.detail(&format!("{name}: {vertices} new on creases"));
    }
    if plan.refine.subdivision != Subdivision::None {
        let vertices = counted(new_vertices, "vertex is", "vertices are");
        let off = grouped(unprojected);
        session.console.detail(&format!("{name}: {vertices} new, {off} of them not on the field"));
    }
    if plan.refine.balance {
        let vertices = counted(balanced, "vertex is", "vertices are");
        let kept = grouped(unbalanced);
        session.console.detail(&format!("{name}: {vertices} balanced, {kept} could not be"));
    }
    if let (Subdivision::MaxError(error), 1..) = (plan.refine.subdivision, refined.unbounded) {
        let triangles = counted(refined.unbounded, "triangle", "triangles");
        session.console.warn(&format!(
            "{name}: of {triangles} it cannot be said that they leave the surface by {error} at most"
        ));
    }
}

/// Says how large a surface is.
fn tell_counts(surface: &Surface, session: &Session<'_, '_>) {
    let counts = surface.mesh.counts();
    let vertices = counted(counts.vertices, "vertex", "vertices");
    let triangles = counted(counts.triangles, "triangle", "triangles");
    session.console.info(&format!("{}: {vertices}, {triangles}", surface.name));
}

/// The same, and what is peculiar about it.
fn tell(plan: &ExtractPlan, surface: &Surface, remark: Option<Remark>, session: &Session<'_, '_>) {
    tell_counts(surface, session);
    let is_empty = surface.mesh.triangles.is_empty();
    let is_cut = plan.is_cut(&surface.name);
    let says = match remark {
        Some(remark @ (Remark::AllOutside { .. } | Remark::AllNan)) => remark.to_string(),
        _ if is_cut && is_empty => {
            format!("{}: what is kept of the volume holds nothing of it", surface.name)
        }
        Some(remark) if !is_cut => remark.to_string(),
        _ => return,
    };
    session.console.warn(&says);
}

fn write(
    plan: &ExtractPlan,
    context: MeshContext,
    surfaces: &[Surface],
    session: &mut Session<'_, '_>,
) -> Result<Written> {
    let context = MeshContext { gltf_unit: plan.target.gltf_unit, ..context };
    Ok(match &plan.target.stream {
        Stream::File(path) => write_mesh(path, surfaces, &context, &session.job)?,
        Stream::Stdout => {
            write_mesh_to(session.out, plan.target.format, surfaces, &context, &session.job)
                .map_err(|fault| fault.at("stdout"))?
        }
    })
}

fn report(
    input: VolumeFacts,
    (plan, made): (&ExtractPlan, Made),
    (written, timings_s): (&Written, Timings),
    session: &Session<'_, '_>,
) -> Result<String> {
    let peak_rss_bytes = peak_rss_bytes(); // of the work, not of the report
    let mut of_surfaces = vec![];
    for (surface, _, (extracted, refined)) in made.each() {
        let topology = topology(&surface.mesh, &session.job)?;
        let counts = sentence(&MeshCounts::of(&topology));
        session.console.detail(&format!("{}: {counts}", surface.name));
        let singular_cells = Some(extracted.singular_cells);
        let refined = RefineReport::of(&plan.refine, refined);
        let report = SurfaceReport::of(surface, &topology);
        of_surfaces.push(SurfaceReport { singular_cells, refined, ..report });
    }
    let report = ExtractReport {
        schema: EXTRACT_SCHEMA,
        command: &session.command,
        input,
        surfaces: of_surfaces,
        vertex_colors: made.colors,
        outputs: &written.files,
        warnings: &written.warnings,
        merged_vertices: written.merged_vertices,
        skipped: made.found.first().map_or(Skipped::default(), |(one, _)| one.skipped).into(),
        timings_s,
        threads: session.job.threads.count(),
        simd: simd(),
        peak_rss_bytes,
        version: env!("CARGO_PKG_VERSION"),
    };
    Ok(to_json(&report)?)
}
