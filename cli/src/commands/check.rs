//! `check`: whether a mesh is what every program takes.

use super::weld;
use crate::{
    Exit, Session,
    args::CheckArgs,
    fault::CallerError,
    report::{CheckReport, MeshCounts, SurfaceReport, to_json},
    text::{counted, rounded},
};
use anyhow::Result;
use isokit::{
    io::{MeshInput, detect, read_mesh},
    mesh::{Surface, topology, weld_exact},
};

pub(crate) fn run(args: &CheckArgs, session: &mut Session<'_, '_>) -> Result<Exit> {
    let report = session.watching(|session| check(args, session))?;
    let text = if args.json { to_json(&report)? } else { lines(&report) };
    session.out.write_all(text.as_bytes())?;
    Ok(if report.ok { Exit::Done } else { Exit::FallsShort })
}

fn check(args: &CheckArgs, session: &Session<'_, '_>) -> Result<CheckReport> {
    let path = &args.mesh;
    if detect(path)?.is_volume() {
        let message = format!("{}: this is a volume, and `check` is for meshes", path.display());
        let advice = "`isokit info` says what a volume holds, `isokit extract` makes a mesh of it";
        return Err(CallerError { message, advice }.into());
    }
    let mut input = read_mesh(path, &session.job)?;
    weld(&mut input, args.weld.weld, session)?;
    let mut surfaces = vec![];
    for surface in &input.surfaces {
        let found = topology(&surface.mesh, &session.job)?;
        let shortfalls = Some(found.shortfalls());
        surfaces.push(SurfaceReport { shortfalls, ..SurfaceReport::of(surface, &found) });
    }
    let ok = surfaces.iter().all(|surface| surface.shortfalls.iter().all(Vec::is_empty));
    let mut notes = input.notes.clone();
    if !ok && args.weld.weld.is_none() {
        notes.extend(hint(&input, &surfaces, session)?);
    }
    let whole = surfaces.iter().map(|surface| &surface.counts);
    let whole = whole.fold(None, |sum: Option<MeshCounts>, counts| {
        Some(sum.map_or_else(|| counts.clone(), |sum| sum.with(counts)))
    });
    Ok(CheckReport {
        schema: "isokit.check/1",
        ok,
        path: path.display().to_string(),
        whole: whole.unwrap_or_default(),
        surfaces,
        notes,
    })
}

/// Many files split vertices where normals differ; the surface is then open only on paper.
fn hint(
    input: &MeshInput,
    surfaces: &[SurfaceReport],
    session: &Session<'_, '_>,
) -> Result<Option<String>> {
    let is_open = |report: &SurfaceReport| report.counts.boundary_edges > 0;
    let open = input.surfaces.iter().zip(surfaces).filter(|(_, report)| is_open(report));
    for (Surface { mesh, .. }, report) in open {
        let welded = weld_exact(mesh, &session.job)?.mesh;
        let left = topology(&welded, &session.job)?.boundary_edges;
        if left < report.counts.boundary_edges {
            let says = "vertices in the same place are stored apart: --weld 0 makes them one, and \
                        then has boundary edges:";
            return Ok(Some(format!("{}: {says} {left}", report.name)));
        }
    }
    Ok(None)
}

fn lines(report: &CheckReport) -> String {
    let verdict = if report.ok { "sound" } else { "falls short" };
    let mut lines = vec![format!("{}: {verdict}", report.path)];
    for surface in &report.surfaces {
        let name = if surface.name.is_empty() { "surface" } else { &surface.name };
        lines.push(format!("  {name}: {}", sentence(&surface.counts)));
        lines.extend(surface.shortfalls.iter().flatten().map(|line| format!("    {line}")));
    }
    lines.extend(report.notes.iter().map(|note| format!("  note: {note}")));
    lines.join("\n") + "\n"
}

/// A surface in a line.
pub(super) fn sentence(counts: &MeshCounts) -> String {
    let vertices = counted(counts.vertices, "vertex", "vertices");
    let triangles = counted(counts.triangles, "triangle", "triangles");
    let pieces = counted(counts.components, "piece", "pieces");
    let genus = counts.genus.map_or(String::new(), |genus| format!(" (genus {genus})"));
    let (euler, [area, volume]) = (counts.euler, [counts.area, counts.volume].map(rounded));
    format!(
        "{vertices}, {triangles}, {pieces}, Euler characteristic {euler}{genus}, area {area}, \
         volume {volume}"
    )
}
