//! What each command does. A command says what it found with numbers, and leaves words about errors to
//! [`fault`](crate::fault).

pub(crate) mod check;
pub(crate) mod completions;
pub(crate) mod convert;
pub(crate) mod extract;
pub(crate) mod info;
pub(crate) mod man;
mod slabs;

use crate::Session;
use anyhow::Result;
use isokit::{
    io::MeshInput,
    mesh::{Welded, weld_exact, weld_within},
};

/// Makes one vertex of several where the user asks for it, and says so.
fn weld(input: &mut MeshInput, distance: Option<f64>, session: &Session<'_, '_>) -> Result<()> {
    let Some(distance) = distance else { return Ok(()) };
    for surface in &mut input.surfaces {
        let welded = match distance > 0.0 {
            true => weld_within(&surface.mesh, distance, &session.job),
            false => weld_exact(&surface.mesh, &session.job),
        }?;
        let Welded { mesh, merged_vertices, dropped_triangles, new_nonmanifold_edges } = welded;
        surface.mesh = mesh;
        let name = &surface.name;
        session
            .console
            .detail(&format!("{name}: {merged_vertices} vertices became one with others"));
        if dropped_triangles > 0 {
            let says = "triangles collapsed and were dropped";
            session.console.note(&format!("{name}: {dropped_triangles} {says}"));
        }
        if new_nonmanifold_edges > 0 {
            let says = "edges have more than two triangles since vertices were welded";
            session.console.warn(&format!("{name}: {new_nonmanifold_edges} {says}"));
        }
    }
    Ok(())
}
