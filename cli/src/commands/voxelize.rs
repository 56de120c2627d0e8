//! `voxelize`: samples of what a mesh encloses.

use super::NEUTRAL;
use crate::{Exit, Session, fault::CallerError, plan::VoxelizePlan, text::counted};
use anyhow::Result;
use isokit::{
    io::{Prepared, detect, prepare_colors, prepare_volume, read_mesh},
    job::{Job, OverLimit},
    mesh::{Rgba, Surface, TriMesh},
    solid::{
        Flaws, MeshSolid, SolidOptions, VoxelError, grid_around, voxelize, voxelize_with_colors,
    },
    volume::Grid,
};
use std::path::Path;

pub(crate) fn run(plan: &VoxelizePlan, session: &mut Session<'_, '_>) -> Result<Exit> {
    session.watching(|session| voxels(plan, session))?;
    Ok(Exit::Done)
}

fn voxels(plan: &VoxelizePlan, session: &Session<'_, '_>) -> Result<()> {
    let (path, job) = (&plan.input, &session.job);
    if detect(path)?.is_volume() {
        let message = format!("{}: this is a volume, and `voxelize` is for meshes", path.display());
        let advice = "`isokit resample` makes other samples of a volume";
        return Err(CallerError { message, advice }.into());
    }
    let input = read_mesh(path, job)?;
    input.notes.iter().for_each(|note| session.console.note(note));
    // All surfaces of a file enclose one solid.
    let whole = TriMesh::joined(input.surfaces.iter().map(|surface| &surface.mesh));
    let mut whole = whole.ok_or_else(|| CallerError {
        message: format!("{}: all surfaces together have 2^32 vertices or more", path.display()),
        advice: "write its surfaces to files of their own",
    })?;
    if plan.colors.is_some() {
        let colors = colors(&input.surfaces, session)?.ok_or_else(|| CallerError {
            message: format!("{}: neither vertices nor surfaces have colours", path.display()),
            advice: "leave out --colors",
        })?;
        whole.attributes.colors = Some(colors);
    }
    let failed = |why: &dyn std::fmt::Display, advice| CallerError {
        message: format!("{}: {why}", path.display()),
        advice,
    };
    let solid = match MeshSolid::new(&whole, SolidOptions::default(), job) {
        Err(isokit::solid::SolidError::Stopped(stopped)) => return Err(stopped.into()),
        Err(why) => return Err(failed(&why, "`isokit check` says more of a mesh").into()),
        Ok(solid) => solid,
    };
    told(&solid.flaws(), session);
    let grid = grid_around(solid.bounds(), plan.spacing, plan.margin, input.unit, input.space)
        .map_err(|why| failed(&why, "choose another --spacing"))?;
    let files = match samples(plan, &solid, grid, job)? {
        Err(why) => return Err(failed(&why, "choose another --band").into()),
        Ok(files) => files,
    };
    let [nx, ny, nz] = grid.dims();
    // All is written whole, so all gets its name now, one after the other; the system may still refuse a name.
    for (path, prepared, content) in files {
        prepared.finish()?;
        let path = path.display();
        session.console.info(&format!("wrote {path}: {nx} x {ny} x {nz} of {content}"));
    }
    Ok(())
}

/// A file, what will be there, and of what that is.
type ToBeNamed<'a> = (&'a Path, Prepared, String);

/// The samples, written up to the names of the files; colours first.
fn samples<'a>(
    plan: &'a VoxelizePlan,
    solid: &MeshSolid,
    grid: Grid,
    job: &Job,
) -> Result<Result<Vec<ToBeNamed<'a>>, VoxelError>> {
    let sampled = match plan.colors {
        None => voxelize(solid, grid, &plan.options, job).map(|volume| (volume, None)),
        Some(_) => voxelize_with_colors(solid, grid, &plan.options, job)
            .map(|(volume, colors)| (volume, Some(colors))),
    };
    let (volume, colors) = match sampled {
        Err(VoxelError::Stopped(stopped)) => return Err(stopped.into()),
        Err(why) => return Ok(Err(why)),
        Ok(sampled) => sampled,
    };
    let mut files = vec![];
    if let (Some(path), Some(colors)) = (&plan.colors, colors) {
        let of = format!("colours, {} bytes each", colors.channels().count());
        files.push((path.as_path(), prepare_colors(path, &colors, job)?, of));
    }
    let output = prepare_volume(&plan.output, &volume, job)?;
    files.push((&plan.output, output, volume.dtype().to_string()));
    Ok(Ok(files))
}

/// The colours of all vertices, of one surface after the other; none if there are none. A vertex without a colour has that of
/// its surface, and if others have colours, the one that files give to what has none.
fn colors(surfaces: &[Surface], session: &Session<'_, '_>) -> Result<Option<Vec<Rgba>>, OverLimit> {
    let has_colors =
        |surface: &Surface| surface.mesh.attributes.colors.is_some() || surface.color.is_some();
    if !surfaces.iter().any(has_colors) {
        return Ok(None);
    }
    let vertices = surfaces.iter().map(|surface| surface.mesh.positions.len() as u64).sum();
    let mut all = session.job.limits.vec("colours of vertices", Some(vertices))?;
    for surface in surfaces {
        if !has_colors(surface) {
            let name = &surface.name;
            session.console.note(&format!("{name} has no colours: it is taken as {NEUTRAL}"));
        }
        match &surface.mesh.attributes.colors {
            Some(colors) => all.extend_from_slice(colors),
            None => {
                let own = surface.color.unwrap_or(NEUTRAL);
                all.extend(std::iter::repeat_n(own, surface.mesh.positions.len()));
            }
        }
    }
    Ok(Some(all))
}

/// What is wrong with the mesh, and how inside is decided.
fn told(flaws: &Flaws, session: &Session<'_, '_>) {
    let note = |count: usize, [one, many]: [&str; 2], says: &str| {
        if count > 0 {
            session.console.note(&format!("{} {says}", counted(count as u64, one, many)));
        }
    };
    let triangles = ["triangle", "triangles"];
    note(flaws.doubled, triangles, "in the place of another, wound alike, counted once");
    note(flaws.back_to_back, triangles, "back to back with another");
    note(flaws.turned, triangles, "turned to be wound as their neighbours");
    note(flaws.flat, triangles, "without an area");
    let says = "at which the surface ends: where it winds around half a time or more is inside";
    note(flaws.open_edges, ["edge", "edges"], says);
    if flaws.open_edges == 0 {
        session.console.detail("the surface is closed: inside is what it winds around");
    }
}
