//! `render`: from a scene, a volume or a mesh to a picture.

mod detail;
mod pictures;
mod read;
mod words;

use super::write_text;
use crate::{
    Exit, Session,
    plan::{RenderPlan, Stream},
    report::{
        DrawnSurface, ReadSamples, RenderInput, RenderReport, RenderSkipped, RenderTimings, timed,
        to_json,
    },
    scene_file::ModeWord,
};
use anyhow::Result;
use isokit::{
    geom::{Aabb, Space},
    mesh::TriMesh,
    pipeline::{Scan, ScanFile},
    render::Size,
    scene::{Needs, Scene, Viewpoint},
};
use std::time::Instant;

pub(crate) fn run(plan: &RenderPlan, session: &mut Session<'_, '_>) -> Result<Exit> {
    let text = session.watching(|session| render(plan, session))?;
    if plan.is_plan && plan.report.is_none() {
        session.out.write_all(text.as_bytes())?;
        return Ok(Exit::Done);
    }
    write_text(plan.report.as_ref(), &text, session)?;
    Ok(Exit::Done)
}

/// What is looked at, in memory.
struct Seen {
    scene: Scene,
    scan: Option<Scan>,
    /// The header of a scan of which no sample is looked at.
    file: Option<ScanFile>,
    /// Which samples are read, or would be.
    samples: Option<ReadSamples>,
    /// One for each surface of the scene, once they are made.
    meshes: Vec<TriMesh>,
    around: (Aabb, Space),
    /// For the report, if one is wanted.
    input: Option<RenderInput>,
}

/// Makes the pictures; the report comes back as text, or what would be done.
fn render(plan: &RenderPlan, session: &mut Session<'_, '_>) -> Result<String> {
    let (start, mut timings) = (Instant::now(), RenderTimings::default());
    let mut seen = timed(&mut timings.read, || read::read(plan, session))?;
    if let Some(path) = plan.plot.as_deref().filter(|_| !plan.is_plan) {
        pictures::plot(path, plan, &seen, session)?;
    }
    let is_plan = plan.is_plan;
    let wants_needs = is_plan || plan.report.is_some() || session.console.is_verbose();
    let mut skipped = RenderSkipped::default();
    let camera = (&plan.viewpoints[..], pictures::size(plan, seen.scene.surfaces.len())?);
    if wants_needs {
        let (scene, shows_values) = (&seen.scene, plan.mode.shows_values());
        let needs = match (&seen.scan, &seen.file) {
            (Some(scan), _) if shows_values => scene.needs_of_rays(scan, camera, &session.job)?,
            (Some(scan), _) => scene.needs(scan, camera, &session.job)?,
            (None, Some(file)) if shows_values => scene.needs_of_rays_of_file(file, camera)?,
            (None, Some(file)) => scene.needs_of_file(file, camera)?,
            (None, None) => Needs::default(),
        };
        skipped = RenderSkipped::of(&needs, plan.mode);
    }
    let has_pictures = !plan.targets.is_empty() || !plan.channels.is_empty();
    if plan.is_on_screen && (is_plan || plan.mode != ModeWord::Surfaces) {
        let made = timed(&mut timings.extract, || detail::halve(plan, &mut seen, camera, session));
        skipped.halvings = made?;
    }
    if has_pictures && !is_plan {
        if let (Some(scan), ModeWord::Surfaces) = (&seen.scan, plan.mode) {
            let scene = (&plan.neediest(&seen.scene), scan);
            let make = || meshes(plan, scene, camera, &mut skipped, session);
            seen.meshes = timed(&mut timings.extract, make)?;
        }
        pictures::pictures(plan, &mut seen, (&mut skipped, &mut timings), session)?;
        pictures::channels(plan, &seen, session)?;
    }
    timings.total = start.elapsed().as_secs_f64();
    let surfaces = surfaces(plan, &seen);
    if is_plan && plan.report.is_none() {
        return Ok(words::plan_lines(plan, &seen, &skipped));
    }
    words::tell((plan.mode, seen.samples.as_ref()), &skipped, &timings, session);
    let (samples, Some(input)) = (seen.samples, seen.input) else { return Ok(String::new()) };
    let pictures = plan.targets.iter().filter_map(|target| match target {
        Stream::File(path) => Some(path.clone()),
        Stream::Stdout => None,
    });
    let others = plan.channels.iter().map(|(_, path)| path).chain(&plan.plot).cloned();
    let outputs = pictures.chain(others.filter(|_| !is_plan));
    let report = RenderReport {
        mode: words::mode_name(plan.mode),
        size: [plan.size.width.get(), plan.size.height.get()],
        surfaces,
        outputs: outputs.collect(),
        samples,
        skipped,
        timings_s: timings,
        threads: session.job.threads.count(),
        ..RenderReport::new(&session.command, input)
    };
    Ok(to_json(&report)?)
}

/// The surfaces that pictures need.
fn meshes(
    plan: &RenderPlan,
    (scene, scan): (&Scene, &Scan),
    camera: (&[Viewpoint], Size),
    skipped: &mut RenderSkipped,
    session: &Session<'_, '_>,
) -> Result<Vec<TriMesh>> {
    if plan.is_on_screen {
        return detail::meshes((scene, scan), camera, skipped, session);
    }
    // Each alone is seen whole, and what is written beside a picture is of other points.
    if plan.is_sheet || !plan.channels.is_empty() {
        return Ok(scene.meshes(scan, camera, &session.job)?);
    }
    let made = scene.meshes_in_sight(scan, camera, &session.job)?;
    made.hidden.iter().for_each(|&n| skipped.add_hidden(n, &scene.surfaces[n]));
    Ok(made.meshes)
}

fn surfaces(plan: &RenderPlan, seen: &Seen) -> Vec<DrawnSurface> {
    if plan.mode.shows_values() {
        return vec![];
    }
    let looks = seen.scene.surfaces.iter().enumerate();
    let drawn = looks.map(|(n, look)| DrawnSurface {
        name: look.name.clone(),
        iso: look.iso,
        opacity: look.opacity,
        triangles: seen.meshes.get(n).map_or(0, |mesh| mesh.triangles.len() as u64),
    });
    drawn.collect()
}
