//! `voxelize`: samples of what a mesh encloses.

use crate::{Exit, Session, fault::CallerError, plan::VoxelizePlan, text::counted};
use anyhow::Result;
use isokit::{
    io::{detect, read_mesh, write_volume},
    mesh::TriMesh,
    solid::{Flaws, MeshSolid, SolidOptions, grid_around, voxelize},
};

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
    let whole = whole.ok_or_else(|| CallerError {
        message: format!("{}: all surfaces together have 2^32 vertices or more", path.display()),
        advice: "write its surfaces to files of their own",
    })?;
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
    let volume = match voxelize(&solid, grid, &plan.options, job) {
        Err(isokit::solid::VoxelError::Stopped(stopped)) => return Err(stopped.into()),
        Err(why) => return Err(failed(&why, "choose another --band").into()),
        Ok(volume) => volume,
    };
    write_volume(&plan.output, &volume, job)?;
    let ([nx, ny, nz], dtype) = (grid.dims(), volume.dtype());
    session
        .console
        .info(&format!("wrote {}: {nx} x {ny} x {nz} of {dtype}", plan.output.display()));
    Ok(())
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
