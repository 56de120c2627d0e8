//! As many samples as pixels show.

use super::Seen;
use crate::{Session, plan::RenderPlan, report::RenderSkipped, text::grouped};
use anyhow::Result;
use isokit::{
    mesh::TriMesh,
    pipeline::{Scan, ScanFile},
    render::Size,
    scene::{Scene, Viewpoint},
};

/// Leaves out samples that pixels do not show; how often they were halved along x, y, z comes back. What was said in
/// units of their distances stays as it was.
pub(super) fn halve(
    plan: &RenderPlan,
    seen: &mut Seen,
    camera: (&[Viewpoint], Size),
    session: &Session<'_, '_>,
) -> Result<[u32; 3]> {
    let file = seen.file.as_ref().map(ScanFile::lattice);
    let Some(lattice) = seen.scan.as_ref().map(Scan::lattice).or(file) else {
        return Ok([0; 3]);
    };
    let halvings = Scene::halvings(lattice, seen.around.0, camera)?;
    let (false, Some(scan)) = (plan.is_plan, &seen.scan) else { return Ok(halvings) };
    let spacing = scan.frame().index_to_world.spacing();
    let least = spacing.into_iter().fold(f64::INFINITY, f64::min);
    if let Some(coarse) = scan.halved(halvings, &session.job)? {
        let unit = seen.scene.raycast.unit.unwrap_or(least);
        seen.scene.raycast = seen.scene.raycast.with_unit(Some(unit));
        seen.scan = Some(coarse);
    }
    Ok(halvings)
}

/// The surfaces of as few samples as pixels show. What got lost is told.
pub(super) fn meshes(
    (scene, scan): (&Scene, &Scan),
    camera: (&[Viewpoint], Size),
    skipped: &mut RenderSkipped,
    session: &Session<'_, '_>,
) -> Result<Vec<TriMesh>> {
    let made = scene.meshes_on_screen(scan, camera, &session.job)?;
    skipped.halvings = made.halvings;
    skipped.bricks_lost = made.bricks_lost;
    if made.bricks_lost > 0 {
        let [lost, bricks] = [made.bricks_lost, made.bricks].map(grouped);
        session.console.note(&format!(
            "in {lost} of {bricks} bricks what is left of a surface is smaller than pixels, and not \
             shown: --lod full shows it"
        ));
    }
    Ok(made.meshes)
}
