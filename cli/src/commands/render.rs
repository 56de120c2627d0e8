//! `render`: from a scene, a volume or a mesh to a picture.

mod detail;
mod pictures;
mod words;

use super::write_text;
use crate::{
    Exit, Session,
    plan::{FadePlan, LookPlan, ModelPlan, RenderPlan, Stream, Subject, color},
    report::{
        DrawnSurface, RenderInput, RenderReport, RenderSkipped, RenderTimings, VolumeFacts, timed,
        to_json,
    },
    scene_file::ModeWord,
};
use anyhow::Result;
use isokit::{
    geom::{Aabb, Space},
    io::{Format, read_mesh},
    mesh::{Surface, TriMesh},
    pipeline::{IsoChoice, Region, Scan, TargetSpace},
    render::{OpticalModel, SlopeFunction},
    scene::{Scene, SurfaceLook, full_slope},
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
    /// One for each surface of the scene, once they are made.
    meshes: Vec<TriMesh>,
    around: (Aabb, Space),
    /// For the report, if one is wanted.
    input: Option<RenderInput>,
}

/// Makes the pictures; the report comes back as text, or what would be done.
fn render(plan: &RenderPlan, session: &mut Session<'_, '_>) -> Result<String> {
    let (start, mut timings) = (Instant::now(), RenderTimings::default());
    let mut seen = timed(&mut timings.read, || read(plan, session))?;
    if let Some(path) = plan.plot.as_deref().filter(|_| !plan.is_plan) {
        pictures::plot(path, plan, &seen, session)?;
    }
    let is_plan = plan.is_plan;
    let wants_needs = is_plan || plan.report.is_some() || session.console.is_verbose();
    let mut skipped = RenderSkipped::default();
    let camera = (&plan.viewpoints[..], pictures::size(plan, seen.scene.surfaces.len())?);
    if let (Some(scan), true) = (&seen.scan, wants_needs) {
        let needs = match plan.mode {
            mode if mode.shows_values() => seen.scene.needs_of_rays(scan, camera, &session.job)?,
            _ => seen.scene.needs(scan, camera, &session.job)?,
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
            let made = timed(&mut timings.extract, || {
                let scene = plan.neediest(&seen.scene);
                match plan.is_on_screen {
                    true => detail::meshes((&scene, scan), camera, &mut skipped, session),
                    false => Ok(scene.meshes(scan, camera, &session.job)?),
                }
            });
            seen.meshes = made?;
        }
        pictures::pictures(plan, &mut seen, (&mut skipped, &mut timings), session)?;
        pictures::channels(plan, &seen, session)?;
    }
    timings.total = start.elapsed().as_secs_f64();
    let surfaces = surfaces(plan, &seen);
    if is_plan && plan.report.is_none() {
        return Ok(words::plan_lines(plan, &seen, &skipped));
    }
    words::tell(plan.mode, &skipped, &timings, session);
    let Some(input) = seen.input else { return Ok(String::new()) };
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
        skipped,
        timings_s: timings,
        threads: session.job.threads.count(),
        ..RenderReport::new(&session.command, input)
    };
    Ok(to_json(&report)?)
}

/// Reads what is looked at, and finds out what is still to be chosen.
fn read(plan: &RenderPlan, session: &Session<'_, '_>) -> Result<Seen> {
    let mut scene = Scene {
        surfaces: vec![],
        clips: plan.clips.clone(),
        model: None,
        viewpoint: plan.viewpoints[0],
        raster: plan.raster,
        raycast: plan.raycast,
    };
    match &plan.subject {
        Subject::Volume(path, options) => {
            let (space, whole) = (TargetSpace::Source, Region::Whole);
            let scan = Scan::open(path, options, space, &whole, &session.job)?;
            scan.notes().iter().for_each(|note| session.console.note(note));
            let look = |look: &LookPlan| surface_look(look, &scan, session);
            scene.surfaces = plan.surfaces.iter().map(look).collect::<Result<_>>()?;
            if plan.mode.shows_values() || scene.has_slices() {
                scene.model = Some(model(&plan.model, &scan, session)?);
            }
            let input = match plan.report {
                None => None,
                Some(_) => {
                    let statistics = scan.statistics(&session.job)?;
                    let facts = VolumeFacts::of(path, &scan, &statistics);
                    Some(RenderInput::Volume(Box::new(facts)))
                }
            };
            let around = scan.around();
            Ok(Seen { scene, scan: Some(scan), meshes: vec![], around, input })
        }
        Subject::Mesh(path, chosen) => {
            let input = read_mesh(path, &session.job)?;
            input.notes.iter().for_each(|note| session.console.note(note));
            let mut meshes = vec![];
            for (n, surface) in input.surfaces.into_iter().enumerate() {
                let Surface { name, color: own, mut mesh, .. } = surface;
                // What was typed comes before all that the file says.
                if chosen.is_some() {
                    mesh.attributes.colors = None;
                }
                let color = chosen.or(own).unwrap_or(color(n));
                let [r, g, b, opacity] = color.to_linear();
                // Vertices have an opacity of their own, which in OBJ is that of the surface.
                let is_shared = mesh.attributes.colors.is_none() || input.format == Format::Obj;
                let opacity = if is_shared { opacity } else { 1.0 };
                scene.surfaces.push(SurfaceLook {
                    name,
                    iso: None,
                    color: [r, g, b],
                    opacity,
                    texture: None,
                });
                meshes.push(mesh);
            }
            // A picture of nothing has a camera too.
            let bounds = Aabb { min: [0.0; 3], max: [1.0; 3] };
            let path = path.display().to_string();
            let (around, input) = ((bounds, input.space), Some(RenderInput::Mesh { path }));
            Ok(Seen { scene, scan: None, meshes, around, input })
        }
    }
}

/// What values look like. What was chosen for the user is told.
fn model(plan: &ModelPlan, scan: &Scan, session: &Session<'_, '_>) -> Result<OpticalModel> {
    let (function, fade) = match plan {
        ModelPlan::Mixture(mixture) => return Ok(mixture.clone().into()),
        ModelPlan::Rows(slopes) => return Ok(slopes.clone().into()),
        ModelPlan::Points(function, fade) => (function.clone(), fade),
        ModelPlan::Preset(preset, fade) => (preset.transfer(scan, &session.job)?, fade),
    };
    let full = match fade {
        None => return Ok(function.into()),
        Some(FadePlan::Slope(slope)) => *slope,
        Some(FadePlan::Auto) => {
            let slope = full_slope(scan, &function, &session.job)?;
            session.console.note(&format!("gradient is {slope} here"));
            slope
        }
    };
    Ok(SlopeFunction::fading(function, full)?.into())
}

/// A surface with the isovalue that was meant. What was chosen for the user is told.
fn surface_look(look: &LookPlan, scan: &Scan, session: &Session<'_, '_>) -> Result<SurfaceLook> {
    let iso = scan.iso(look.iso, &session.job)?;
    if !matches!(look.iso, IsoChoice::Value(_)) {
        session.console.note(&format!("iso {} is {iso} here", look.iso));
    }
    let name = look.name.clone().unwrap_or_else(|| format!("iso_{iso}"));
    let [r, g, b, _] = look.color.to_linear();
    let LookPlan { opacity, texture, .. } = *look;
    Ok(SurfaceLook { name, iso: Some(iso), color: [r, g, b], opacity, texture })
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
