//! What each command does. A command says what it found with numbers, and leaves words about errors to
//! [`fault`](crate::fault).

pub(crate) mod check;
pub(crate) mod completions;
pub(crate) mod convert;
pub(crate) mod extract;
pub(crate) mod info;
pub(crate) mod man;
pub(crate) mod render;
pub(crate) mod resample;
pub(crate) mod sample;
mod slabs;
pub(crate) mod suggest;
pub(crate) mod voxelize;

use crate::{Session, plan::TextTarget};
use anyhow::{Context, Result};
use isokit::{
    io::{MeshInput, Output},
    mesh::{Rgba, Welded, weld_exact, weld_within},
};
use std::{
    io::{BufWriter, Write},
    path::Path,
};

/// What a surface without colour looks like, as in files that want one.
const NEUTRAL: Rgba = Rgba([204, 204, 204, 255]);

/// Writes a report where it is to go, if anywhere.
fn write_text(
    target: Option<&TextTarget>,
    text: &str,
    session: &mut Session<'_, '_>,
) -> Result<()> {
    match target {
        None => {}
        Some(TextTarget::Stdout) => session.out.write_all(text.as_bytes())?,
        Some(TextTarget::File(path)) => {
            let mut output = Output::create(path)?;
            let written = output.write_all(text.as_bytes());
            written.with_context(|| format!("{}: cannot write", path.display()))?;
            output.finish()?;
        }
    }
    Ok(())
}

/// Writes a file that appears when it is whole.
fn to_file<R>(
    path: &Path,
    session: &Session<'_, '_>,
    write: impl FnOnce(&mut dyn Write) -> Result<R>,
) -> Result<R> {
    let mut output = Output::create(path)?;
    let mut buffer = BufWriter::new(&mut output);
    let what = || format!("{}: cannot write", path.display());
    let written = write(&mut buffer).with_context(what)?;
    buffer.flush().with_context(what)?;
    drop(buffer);
    output.finish()?;
    session.console.info(&format!("wrote {}", path.display()));
    Ok(written)
}

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
