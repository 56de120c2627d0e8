//! `render`: from a scene, a volume or a mesh to a picture.

use super::write_text;
use crate::{
    Exit, Session,
    plan::{FadePlan, LookPlan, ModelPlan, RenderPlan, Stream, Subject, color},
    report::{
        DrawnSurface, RenderInput, RenderReport, RenderSkipped, RenderTimings, VolumeFacts, timed,
        to_json,
    },
    scene_file::ModeWord,
    text::{counted, grouped},
};
use anyhow::{Context, Result};
use isokit::{
    geom::{Aabb, Space},
    io::{Output, read_mesh},
    mesh::TriMesh,
    pipeline::{IsoChoice, Region, Scan, TargetSpace},
    render::{Image, OpticalModel, SlopeFunction, write_png},
    scene::{Scene, SurfaceLook, full_slope},
};
use std::{
    io::{BufWriter, Write},
    time::Instant,
};

pub(crate) fn run(plan: &RenderPlan, session: &mut Session<'_, '_>) -> Result<Exit> {
    let text = session.watching(|session| render(plan, session))?;
    if plan.targets.is_empty() && plan.report.is_none() {
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
    let is_plan = plan.targets.is_empty();
    let wants_needs = is_plan || plan.report.is_some() || session.console.is_verbose();
    let mut skipped = RenderSkipped::default();
    if let (Some(scan), true) = (&seen.scan, wants_needs) {
        let needs = match plan.mode {
            mode if mode.shows_values() => seen.scene.needs_of_rays(scan, &session.job)?,
            _ => seen.scene.needs(scan, &session.job)?,
        };
        skipped = RenderSkipped::of(&needs);
    }
    if !is_plan {
        if let (Some(scan), ModeWord::Surfaces) = (&seen.scan, plan.mode) {
            let made = timed(&mut timings.extract, || seen.scene.meshes(scan, &session.job));
            seen.meshes = made?;
        }
        pictures(plan, &mut seen, (&mut skipped, &mut timings), session)?;
    }
    timings.total = start.elapsed().as_secs_f64();
    let surfaces = surfaces(plan, &seen);
    if is_plan && plan.report.is_none() {
        return Ok(plan_lines(plan, &seen, &skipped));
    }
    tell(plan.mode, &skipped, &timings, session);
    let Some(input) = seen.input else { return Ok(String::new()) };
    let outputs = plan.targets.iter().filter_map(|target| match target {
        Stream::File(path) => Some(path.clone()),
        Stream::Stdout => None,
    });
    let report = RenderReport {
        mode: mode_name(plan.mode),
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
        Subject::Mesh(path) => {
            let input = read_mesh(path, &session.job)?;
            input.notes.iter().for_each(|note| session.console.note(note));
            let mut meshes = vec![];
            for (n, surface) in input.surfaces.into_iter().enumerate() {
                let [r, g, b, opacity] = surface.color.unwrap_or(color(n)).to_linear();
                let name = surface.name;
                scene.surfaces.push(SurfaceLook {
                    name,
                    iso: None,
                    color: [r, g, b],
                    opacity,
                    texture: None,
                });
                meshes.push(surface.mesh);
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

/// Makes and writes one picture after the other.
fn pictures(
    plan: &RenderPlan,
    seen: &mut Seen,
    (skipped, timings): (&mut RenderSkipped, &mut RenderTimings),
    session: &mut Session<'_, '_>,
) -> Result<()> {
    for (viewpoint, target) in plan.viewpoints.iter().zip(&plan.targets) {
        seen.scene.viewpoint = *viewpoint;
        let (size, job) = (plan.size, session.job.clone());
        let image = timed(&mut timings.render, || -> Result<Image> {
            match (plan.mode, &seen.scan) {
                (ModeWord::Raycast, Some(scan)) => {
                    let (image, cast) = seen.scene.cast(scan, size, &job)?;
                    skipped.add_cast(&cast);
                    Ok(image)
                }
                (ModeWord::Splat, Some(scan)) => {
                    let (image, splatted) = seen.scene.splat(scan, size, &job)?;
                    skipped.add_splatted(&splatted);
                    Ok(image)
                }
                (ModeWord::IsoRaycast, Some(scan)) => {
                    let (image, traced) = seen.scene.trace(scan, size, &job)?;
                    skipped.add_traced(&traced);
                    Ok(image)
                }
                (_, scan) => {
                    let subject = (scan.as_ref(), seen.around);
                    let (image, drawn) = seen.scene.draw(&seen.meshes, subject, size, &job)?;
                    skipped.add_drawn(&drawn);
                    Ok(image)
                }
            }
        })?;
        timed(&mut timings.write, || write(plan, &image, target, session))?;
    }
    Ok(())
}

fn write(
    plan: &RenderPlan,
    image: &Image,
    target: &Stream,
    session: &mut Session<'_, '_>,
) -> Result<()> {
    match target {
        Stream::Stdout => write_png(image, plan.background, plan.depth, &mut session.out)?,
        Stream::File(path) => {
            let mut output = Output::create(path)?;
            let mut buffer = BufWriter::new(&mut output);
            let written = write_png(image, plan.background, plan.depth, &mut buffer);
            let what = || format!("{}: cannot write", path.display());
            written.with_context(what)?;
            buffer.flush().with_context(what)?;
            drop(buffer);
            output.finish()?;
            session.console.info(&format!("wrote {}", path.display()));
        }
    }
    Ok(())
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

/// Says what was computed, and what not.
fn tell(
    mode: ModeWord,
    skipped: &RenderSkipped,
    timings: &RenderTimings,
    session: &Session<'_, '_>,
) {
    skipped_lines(mode, skipped).iter().for_each(|line| session.console.detail(line));
    let RenderTimings { read, extract, render, write, total } = timings;
    session.console.detail(&format!(
        "read {read:.3} s, extract {extract:.3} s, render {render:.3} s, write {write:.3} s, \
         total {total:.3} s"
    ));
}

/// What would be done, for people.
fn plan_lines(plan: &RenderPlan, seen: &Seen, skipped: &RenderSkipped) -> String {
    let pictures = counted(plan.viewpoints.len() as u64, "picture", "pictures");
    let [width, height] = [plan.size.width, plan.size.height];
    let mut lines = vec![format!("{pictures} of {width} x {height}, {}", mode_name(plan.mode))];
    if !plan.mode.shows_values() {
        for (n, look) in seen.scene.surfaces.iter().enumerate() {
            let why = skipped.surfaces.iter().find(|skipped| skipped.number == n);
            let what = match (why, look.iso) {
                (Some(why), _) => format!("not made: {}", why.why),
                (None, Some(iso)) if plan.mode == ModeWord::IsoRaycast => {
                    format!("found by rays at {iso}")
                }
                (None, Some(iso)) => format!("extracted at {iso}, with normals"),
                (None, None) => "read".to_owned(),
            };
            lines.push(format!("  {}: {what}", look.name));
        }
    } else if !seen.scene.surfaces.is_empty() {
        lines.push("not computed: surfaces and caps, which pictures of values do not show".into());
    }
    lines.extend(skipped_lines(plan.mode, skipped));
    lines.join("\n") + "\n"
}

/// What is not computed, a sentence each.
fn skipped_lines(mode: ModeWord, skipped: &RenderSkipped) -> Vec<String> {
    let of = |part: u64, all: u64, what: &str| {
        (all > 0).then(|| format!("skipped {} of {} {what}", grouped(part), grouped(all)))
    };
    let triangles = skipped.triangles + skipped.triangles_skipped;
    let of_samples = match mode {
        ModeWord::Splat => "samples, which give nothing to what can be seen",
        _ => "samples, which planes cut away",
    };
    let steps = skipped.steps + skipped.steps_leapt + skipped.steps_hidden;
    [
        (skipped.bricks > 0).then(|| {
            let what = match mode {
                mode if mode.shows_values() => "nothing that can be seen",
                _ => "no surface that can be seen",
            };
            let [part, all] = [skipped.bricks_skipped, skipped.bricks].map(grouped);
            format!("{part} of {all} bricks hold {what}")
        }),
        of(skipped.samples_skipped, skipped.samples, of_samples),
        of(skipped.triangles_skipped, triangles, "triangles, which are not in the picture"),
        of(skipped.steps_leapt, steps, "steps of rays, where nothing can be seen"),
        of(skipped.steps_hidden, steps, "steps of rays, behind what is opaque"),
        (skipped.bricks_passed > 0).then(|| {
            let bricks = grouped(skipped.bricks_passed);
            format!("rays passed {bricks} times a brick without a surface")
        }),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn mode_name(mode: ModeWord) -> &'static str {
    match mode {
        ModeWord::Surfaces => "surfaces",
        ModeWord::IsoRaycast => "iso-raycast",
        ModeWord::Raycast => "raycast",
        ModeWord::Splat => "splat",
    }
}
