//! `extract` of a shape: from a file that describes it to a mesh, with samples only near its surface.

use super::{Made, color::pattern, finish, surfaces, tell_counts, tell_refined, tell_singular};
use crate::{
    Session,
    plan::{ExtractPlan, LevelPlan},
    report::{Timings, VolumeFacts, timed},
    shape_file::read_shape,
    text::{counted, grouped},
};
use anyhow::Result;
use isokit::{
    field::FieldSamples,
    io::MeshContext,
    job::Job,
    marching_cubes::Skipped,
    mesh::{Surface, TriMesh},
    pipeline::{refine_on, sparse_meshes_into},
    refine::Isosurface,
};
use std::time::Instant;

/// Makes and writes the mesh; the report comes back as text, empty if there is to be none.
pub(super) fn extract(
    plan: &ExtractPlan,
    spacing: [f64; 3],
    session: &mut Session<'_, '_>,
) -> Result<String> {
    let (start, mut timings) = (Instant::now(), Timings::default());
    let solid = timed(&mut timings.read, || read_shape(&plan.input))?;
    let grid = solid.grid(spacing)?;
    let placed = solid.placed(&grid);
    let samples = FieldSamples::<f32>::new(&placed, grid.frame)?;
    let isos: Vec<f64> = plan.levels.iter().filter_map(LevelPlan::value).collect();
    let mut meshes = vec![TriMesh::default(); isos.len()];
    let extracted = timed(&mut timings.extract, || {
        let options = plan.surface.before(&plan.refine);
        sparse_meshes_into(&samples, &isos, &options, &mut meshes, &session.job)
    })?;
    let mut surfaces = surfaces(&plan.levels, &isos, meshes);
    let options = plan.refine.with_file_scale(plan.target.file_scale(grid.frame.unit));
    let mut refine = |surface: &mut Surface| {
        let isosurface = Isosurface { field: &placed, iso: surface.iso.unwrap_or(f64::NAN) };
        refine_on(&isosurface, &mut surface.mesh, (&options, &plan.surface), &session.job)
    };
    let refined = timed(&mut timings.mend, || {
        surfaces.iter_mut().map(&mut refine).collect::<Result<Vec<_>, _>>()
    })?;
    let colors = (!plan.color.is_empty()).then(|| pattern(&plan.color, &mut surfaces));
    let made = Made { surfaces, found: extracted.into_iter().zip(refined).collect(), colors };
    for (surface, _, (extracted, refined)) in made.each() {
        tell_counts(surface, session);
        tell_refined(plan, refined, &surface.name, session);
        let Skipped { bricks, bricks_skipped, samples_read } = extracted.skipped;
        let ([nx, ny, nz], skipped) = (grid.dims(), grouped(bricks_skipped));
        let (bricks, made) = (counted(bricks, "brick", "bricks"), grouped(samples_read));
        session.console.detail(&format!(
            "{}: {nx} x {ny} x {nz}, of {bricks} {skipped} skipped, {made} samples made",
            surface.name
        ));
        tell_singular(extracted, &surface.name, session);
    }
    let (unit, space) = (grid.frame.unit, grid.frame.space);
    let context = MeshContext { unit, space, command: session.command.clone(), gltf_unit: None };
    let input = |_: &Job| Ok(VolumeFacts::of_shape(&plan.input, &grid));
    finish(plan, made, (context, input), (start, timings), session)
}
