//! Writes glTF from surfaces in memory.

use super::{
    Scale,
    content::{Bounds, Undirected, report_unseen, report_valueless, unit},
    plan::{Bin, Part, Plan, check, is_seen},
};
use crate::{
    Format, Output, WriteError, WriteFault,
    mesh::{
        MeshContext, Written,
        axes::y_up,
        outline::Outline,
        rounding::Loss,
        stream::{Stream, put_f32, put_u32},
    },
};
use isokit_job::Job;
use isokit_mesh::{Attributes, Positions, Rgba, Surface};
use std::{io::Write, path::Path};

/// Writes all surfaces as one GLB.
pub(in crate::mesh) fn write_glb(
    out: &mut dyn Write,
    surfaces: &[Surface],
    context: &MeshContext,
    job: &Job,
    written: &mut Written,
) -> Result<(), WriteFault> {
    let parts = parts(Format::Glb, surfaces, context, job, written)?;
    let plan = Plan::new(&parts, context, None)?;
    let mut stream = Stream::new(out, job);
    stream.put(&plan.glb_head());
    put_buffer(&mut stream, surfaces, &parts, context, job)?;
    stream.finish()
}

/// Writes all surfaces as JSON at `path` and their buffer beside it. The buffer gets its name first.
pub(in crate::mesh) fn write_gltf(
    path: &Path,
    surfaces: &[Surface],
    context: &MeshContext,
    job: &Job,
    written: &mut Written,
) -> Result<(), WriteError> {
    let bin = Bin::beside(path);
    let parts = parts(Format::Gltf, surfaces, context, job, written);
    let parts = parts.map_err(|fault| fault.at(path))?;
    let plan = Plan::new(&parts, context, Some(bin.uri.clone())).map_err(|fault| fault.at(path))?;
    let put = |out: &mut Output| {
        let mut stream = Stream::new(out, job);
        put_buffer(&mut stream, surfaces, &parts, context, job)?;
        stream.finish()
    };
    bin.finish(Output::create(path)?, &plan, put, written)
}

/// How each surface will be written.
fn parts(
    format: Format,
    surfaces: &[Surface],
    context: &MeshContext,
    job: &Job,
    written: &mut Written,
) -> Result<Vec<Part>, WriteFault> {
    let outlines: Vec<_> = surfaces.iter().map(Outline::from).collect();
    report_unseen(&outlines, written);
    check(format, &outlines)?;
    let scale = Scale::of(context);
    let part = |(mut outline, surface): (Outline, &Surface)| {
        let (mesh, mut bounds) = (&surface.mesh, Bounds::default());
        if is_seen(&&outline) {
            let (store, back) = (|xyz| scale.store(xyz), |xyz| scale.restore(xyz));
            let loss = Loss::of(&mesh.positions, store, back, job)?;
            loss.report(&outline, format, written);
            let normals = mesh.normals.as_deref().unwrap_or_default();
            if let Some(undirected) = Undirected::find(normals, 0) {
                undirected.report(&outline.head, written);
                outline.has_normals = false;
            }
            bounds.take(&mesh.positions, scale, &outline.head, 0)?;
            let values = mesh.attributes.values.as_deref().unwrap_or_default();
            let without = values.iter().filter(|value| !value.is_finite()).count();
            if without > 0 {
                report_valueless(without, &outline.head, written);
                outline.has_values = false;
            }
        }
        let colors = mesh.attributes.colors.as_deref().unwrap_or_default();
        let is_translucent = colors.iter().any(|color| color.is_translucent());
        Ok(Part { outline, bounds, is_translucent })
    };
    outlines.into_iter().zip(surfaces).map(part).collect()
}

fn put_buffer(
    stream: &mut Stream<'_>,
    surfaces: &[Surface],
    parts: &[Part],
    context: &MeshContext,
    job: &Job,
) -> Result<(), WriteFault> {
    let seen = || parts.iter().map(|part| &part.outline).zip(surfaces).filter(|(o, _)| is_seen(o));
    let items = seen().map(|(outline, _)| outline.items());
    job.progress.begin("write", items.sum());
    for (outline, surface) in seen() {
        let mesh = &surface.mesh;
        put_positions(stream, &mesh.positions, Scale::of(context))?;
        let normals = mesh.normals.as_deref().filter(|_| outline.has_normals);
        put_normals(stream, normals.unwrap_or_default())?;
        let Attributes { values, colors } = &mesh.attributes;
        put_colors(stream, colors.as_deref().unwrap_or_default())?;
        let values = values.as_deref().filter(|_| outline.has_values).unwrap_or_default();
        stream.items(values, |bytes, value| bytes.extend(value.to_le_bytes()))?;
        put_triangles(stream, &mesh.triangles)?;
    }
    Ok(())
}

pub(super) fn put_positions(
    stream: &mut Stream<'_>,
    positions: &Positions,
    scale: Scale,
) -> Result<(), WriteFault> {
    stream.items(positions.iter().map(|xyz| scale.store(xyz)), put_f32)
}

pub(super) fn put_normals(stream: &mut Stream<'_>, normals: &[[f32; 3]]) -> Result<(), WriteFault> {
    stream.items(normals.iter().map(|&normal| y_up(unit(normal))), put_f32)
}

/// Puts colours in linear light, as glTF wants them: sixteen bits, in which every eight of sRGB are apart.
fn put_colors(stream: &mut Stream<'_>, colors: &[Rgba]) -> Result<(), WriteFault> {
    let bits = |part: f32| (f64::from(part) * f64::from(u16::MAX)).round() as u16;
    stream.items(colors, |bytes, color| {
        color.to_linear().into_iter().for_each(|part| bytes.extend(bits(part).to_le_bytes()));
    })
}

pub(super) fn put_triangles(
    stream: &mut Stream<'_>,
    triangles: &[[u32; 3]],
) -> Result<(), WriteFault> {
    stream.items(triangles.iter().copied(), put_u32)
}
