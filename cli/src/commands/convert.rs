//! `convert`: the same volume or mesh in another format.

use super::weld;
use crate::{
    Exit, Session,
    fault::CallerError,
    plan::{ConvertPlan, ConvertTo, MeshTarget, Stream},
    text::counted,
};
use anyhow::Result;
use isokit::{
    geom::Space,
    io::{
        MeshContext, MeshInput, VolumeOptions, Written, detect, read_mesh, write_mesh,
        write_mesh_to, write_volume,
    },
    mesh::{Positions, TriMesh},
    pipeline::{Region, Scan, TargetSpace, UnknownSpace},
};
use std::path::Path;

pub(crate) fn run(plan: &ConvertPlan, session: &mut Session<'_, '_>) -> Result<Exit> {
    session.watching(|session| match &plan.to {
        ConvertTo::Volume { path, options } => volume(plan, path, options, session),
        ConvertTo::Mesh { target, weld } => mesh(plan, target, *weld, session),
    })?;
    Ok(Exit::Done)
}

fn volume(
    plan: &ConvertPlan,
    path: &Path,
    options: &VolumeOptions,
    session: &mut Session<'_, '_>,
) -> Result<()> {
    let input = &plan.input;
    if options.raw.is_none() && !detect(input)?.is_volume() {
        let message = format!("{}: this is a mesh, and the output is a volume", input.display());
        let advice =
            "choose .glb .gltf .obj .ply or .stl; `isokit voxelize` makes a volume of a mesh";
        return Err(CallerError { message, advice }.into());
    }
    let scan = Scan::open(input, options, plan.space, &Region::Whole, &session.job)?;
    scan.notes().iter().for_each(|note| session.console.note(note));
    write_volume(path, scan.volume(), &session.job)?;
    let [nx, ny, nz] = scan.volume().grid().dims();
    let dtype = scan.volume().dtype();
    session.console.info(&format!("wrote {}: {nx} x {ny} x {nz} of {dtype}", path.display()));
    Ok(())
}

fn mesh(
    plan: &ConvertPlan,
    target: &MeshTarget,
    distance: Option<f64>,
    session: &mut Session<'_, '_>,
) -> Result<()> {
    let path = &plan.input;
    if detect(path)?.is_volume() {
        let message = format!("{}: this is a volume, and the output is a mesh", path.display());
        let advice = "`isokit extract` makes a mesh of a volume";
        return Err(CallerError { message, advice }.into());
    }
    let mut input = read_mesh(path, &session.job)?;
    input.notes.iter().for_each(|note| session.console.note(note));
    let names: Vec<&str> = input.surfaces.iter().map(|surface| surface.name.as_str()).collect();
    plan.check_files(&names)?;
    place(&mut input, plan.space)?;
    weld(&mut input, distance, session)?;
    let context = MeshContext {
        unit: input.unit,
        space: input.space,
        command: session.command.clone(),
        gltf_unit: target.gltf_unit,
    };
    let written = match &target.stream {
        Stream::File(path) => write_mesh(path, &input.surfaces, &context, &session.job)?,
        Stream::Stdout => {
            write_mesh_to(session.out, target.format, &input.surfaces, &context, &session.job)
                .map_err(|fault| fault.at("stdout"))?
        }
    };
    let triangles = input.surfaces.iter().map(|surface| surface.mesh.counts().triangles).sum();
    told(&written, triangles, session);
    Ok(())
}

fn told(written: &Written, triangles: u64, session: &Session<'_, '_>) {
    written.warnings.iter().for_each(|warning| session.console.warn(warning));
    for file in &written.files {
        let triangles = counted(triangles, "triangle", "triangles");
        session.console.info(&format!("wrote {}: {triangles} in all", file.display()));
    }
}

/// Turns a mesh to other axes: half a turn around z, which keeps the winding.
fn place(input: &mut MeshInput, space: TargetSpace) -> Result<()> {
    let wanted = match space {
        TargetSpace::Ras => Space::Ras,
        TargetSpace::Lps => Space::Lps,
        TargetSpace::Source | TargetSpace::Index => return Ok(()),
    };
    if input.space == Space::Unknown {
        return Err(isokit::pipeline::PipelineError::from(UnknownSpace { wanted }).into());
    }
    if input.space != wanted {
        input.surfaces.iter_mut().for_each(|surface| turn(&mut surface.mesh));
        input.space = wanted;
    }
    Ok(())
}

fn turn(mesh: &mut TriMesh) {
    match &mut mesh.positions {
        Positions::F32(all) => all.iter_mut().for_each(|[x, y, _]| (*x, *y) = (-*x, -*y)),
        Positions::F64(all) => all.iter_mut().for_each(|[x, y, _]| (*x, *y) = (-*x, -*y)),
    }
    for [x, y, _] in mesh.normals.iter_mut().flatten() {
        (*x, *y) = (-*x, -*y);
    }
}
