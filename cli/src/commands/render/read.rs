//! What is looked at: read from its file, as far as the pictures need it.

use super::{Seen, pictures};
use crate::{
    Session,
    plan::{FadePlan, LookPlan, ModelPlan, RenderPlan, Subject, color},
    report::{ReadSamples, RenderInput, VolumeFacts},
};
use anyhow::Result;
use isokit::{
    geom::Aabb,
    io::{Format, VolumeOptions, read_mesh},
    mesh::{Rgba, Surface},
    pipeline::{IsoChoice, Lattice, Region, Scan, ScanFile, TargetSpace},
    render::{OpticalModel, SlopeFunction},
    scene::{Scene, SurfaceLook, full_slope},
};
use std::{ops::Range, path::Path};

/// Reads what is looked at, and finds out what is still to be chosen. Of a plan no sample is read, if it needs none.
pub(super) fn read(plan: &RenderPlan, session: &Session<'_, '_>) -> Result<Seen> {
    let scene = Scene {
        surfaces: vec![],
        clips: plan.clips.clone(),
        model: None,
        viewpoint: plan.viewpoints[0],
        raster: plan.raster,
        raycast: plan.raycast,
    };
    match &plan.subject {
        Subject::Volume(path, options, region) => {
            volume(plan, (path, options, region), scene, session)
        }
        Subject::Mesh(path, chosen) => mesh((path, *chosen), scene, session),
    }
}

fn volume(
    plan: &RenderPlan,
    (path, options, region): (&Path, &VolumeOptions, &Region),
    mut scene: Scene,
    session: &Session<'_, '_>,
) -> Result<Seen> {
    let file = ScanFile::open(path, options, TargetSpace::Source, region, &session.job)?;
    file.notes().iter().for_each(|note| session.console.note(note));
    let lattice = file.lattice().clone();
    let shows_model = plan.mode.shows_values() || scene.has_slices();
    let chosen = chosen(plan, shows_model);
    let (mut scan, mut file) = match chosen {
        Some(_) => (Some(file.read(&session.job)?), None),
        None => (None, Some(file)),
    };
    let look = |look: &LookPlan| surface_look(look, scan.as_ref(), session);
    scene.surfaces = plan.surfaces.iter().map(look).collect::<Result<_>>()?;
    if shows_model {
        scene.model = Some(model(&plan.model, scan.as_ref(), session)?);
    }
    let why = chosen.or_else(|| all(plan, file.as_ref()));
    let ranges = match why {
        Some(_) => lattice.part(),
        None => shown(plan, &scene, &lattice)?,
    };
    if !plan.is_plan
        && let Some(file) = file.take()
    {
        scan = Some(file.read_wanted(&ranges, &session.job)?);
    }
    let samples = Some(ReadSamples::of(&lattice, &ranges, why));
    let input = match (&plan.report, &scan, &file) {
        (Some(_), Some(scan), _) => {
            Some(VolumeFacts::of(path, scan, &scan.statistics(&session.job)?))
        }
        (Some(_), None, Some(file)) => Some(VolumeFacts::of_file(path, file)),
        _ => None,
    };
    let input = input.map(|facts| RenderInput::Volume(Box::new(facts)));
    Ok(Seen { scene, scan, file, samples, meshes: vec![], around: lattice.around(), input })
}

/// What cannot be known of the pictures before all samples are, if there is something.
fn chosen(plan: &RenderPlan, shows_model: bool) -> Option<&'static str> {
    let is_auto = |fade: &Option<FadePlan>| *fade == Some(FadePlan::Auto);
    let is_of_samples = match &plan.model {
        ModelPlan::Preset(preset, fade) => preset.known().is_none() || is_auto(fade),
        ModelPlan::Points(_, fade) => is_auto(fade),
        ModelPlan::Rows(_) | ModelPlan::Mixture(_) => false,
    };
    if plan.surfaces.iter().any(|look| !matches!(look.iso, IsoChoice::Value(_))) {
        return Some("an isovalue is chosen by all of them");
    }
    (shows_model && is_of_samples).then_some("what values look like is chosen by all of them")
}

/// Why all samples are read of a file of which the pictures may need fewer.
fn all(plan: &RenderPlan, file: Option<&ScanFile>) -> Option<&'static str> {
    if plan.plot.is_some() {
        return Some("the chart counts all of them");
    }
    if plan.is_on_screen {
        return Some("all of them are looked at before some are left out");
    }
    let has_slices = file.is_none_or(ScanFile::has_slices);
    (!has_slices).then_some("the file has no slices that could be read without the others")
}

/// The samples that pictures depend on: one, if they depend on none.
fn shown(plan: &RenderPlan, scene: &Scene, lattice: &Lattice) -> Result<[Range<usize>; 3]> {
    let camera = (&plan.viewpoints[..], pictures::size(plan, scene.surfaces.len())?);
    let found = match plan.mode.shows_values() {
        true => scene.samples_of_rays(lattice, camera)?,
        false => plan.neediest(scene).samples_of_surfaces(lattice, camera)?,
    };
    Ok(found.unwrap_or_else(|| lattice.part().map(|range| range.start..range.start + 1)))
}

fn mesh(
    (path, chosen): (&Path, Option<Rgba>),
    mut scene: Scene,
    session: &Session<'_, '_>,
) -> Result<Seen> {
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
    Ok(Seen { scene, scan: None, file: None, samples: None, meshes, around, input })
}

/// What values look like. What was chosen for the user is told.
///
/// # Panics
///
/// If it is chosen by samples, and there are none.
pub(super) fn model(
    plan: &ModelPlan,
    scan: Option<&Scan>,
    session: &Session<'_, '_>,
) -> Result<OpticalModel> {
    let scan = || scan.expect("samples by which something is chosen are read");
    let (function, fade) = match plan {
        ModelPlan::Mixture(mixture) => return Ok(mixture.clone().into()),
        ModelPlan::Rows(slopes) => return Ok(slopes.clone().into()),
        ModelPlan::Points(function, fade) => (function.clone(), fade),
        ModelPlan::Preset(preset, fade) => {
            let known = preset.known().map_or_else(|| preset.transfer(scan(), &session.job), Ok);
            (known?, fade)
        }
    };
    let full = match fade {
        None => return Ok(function.into()),
        Some(FadePlan::Slope(slope)) => *slope,
        Some(FadePlan::Auto) => {
            let slope = full_slope(scan(), &function, &session.job)?;
            session.console.note(&format!("gradient is {slope} here"));
            slope
        }
    };
    Ok(SlopeFunction::fading(function, full)?.into())
}

/// A surface with the isovalue that was meant. What was chosen for the user is told.
fn surface_look(
    look: &LookPlan,
    scan: Option<&Scan>,
    session: &Session<'_, '_>,
) -> Result<SurfaceLook> {
    let iso = match look.iso {
        IsoChoice::Value(iso) => iso,
        choice => {
            let scan = scan.expect("samples by which something is chosen are read");
            let iso = scan.iso(choice, &session.job)?;
            session.console.note(&format!("iso {choice} is {iso} here"));
            iso
        }
    };
    let name = look.name.clone().unwrap_or_else(|| format!("iso_{iso}"));
    let [r, g, b, _] = look.color.to_linear();
    let LookPlan { opacity, texture, .. } = *look;
    Ok(SurfaceLook { name, iso: Some(iso), color: [r, g, b], opacity, texture })
}
