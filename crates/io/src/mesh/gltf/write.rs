//! Writes glTF: all sizes are known, and within the format's limits, before the first byte.

use super::{
    Scale,
    document::{Bounds, Content, document},
    layout::{self, Shape, layout},
    mark,
};
use crate::{
    Format, Output, WriteError, WriteFault,
    mesh::{
        MeshContext, Written,
        axes::y_up,
        rounding::Loss,
        stream::{Stream, put_f32, put_u32},
    },
};
use isokit_job::Job;
use isokit_mesh::Surface;
use std::{array, io::Write, path::Path};

/// Writes all surfaces as one GLB.
pub(in crate::mesh) fn write_glb(
    out: &mut dyn Write,
    surfaces: &[Surface],
    context: &MeshContext,
    job: &Job,
    written: &mut Written,
) -> Result<(), WriteFault> {
    let plan = Plan::new(Format::Glb, surfaces, context, None, job, written)?;
    let json = layout::padded(plan.json.len() as u64);
    let total = layout::glb_bytes(plan.json.len() as u64, plan.buffer);
    let mut stream = Stream::new(out, job);
    put_words(&mut stream, [mark::MAGIC.into(), mark::VERSION.into(), total]);
    put_words(&mut stream, [json, mark::JSON.into()]);
    stream.put(&plan.json);
    stream.put(&b"   "[..(json - plan.json.len() as u64) as usize]);
    if plan.buffer > 0 {
        put_words(&mut stream, [plan.buffer, mark::BIN.into()]);
        plan.put_buffer(&mut stream)?;
    }
    stream.finish()
}

/// Puts numbers that the plan has found to be within 32 bits.
fn put_words<const N: usize>(stream: &mut Stream<'_>, words: [u64; N]) {
    words.iter().for_each(|&word| stream.put(&(word as u32).to_le_bytes()));
}

/// Writes all surfaces as JSON at `path` and their buffer beside it. The buffer gets its name first.
pub(in crate::mesh) fn write_gltf(
    path: &Path,
    surfaces: &[Surface],
    context: &MeshContext,
    job: &Job,
    written: &mut Written,
) -> Result<(), WriteError> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let bin = path.with_file_name(format!("{stem}.bin"));
    let uri = Some(encoded(&format!("{stem}.bin")));
    let plan = Plan::new(Format::Gltf, surfaces, context, uri, job, written)
        .map_err(|fault| fault.at(path))?;
    let mut json = Output::create(path)?;
    let io = |error: std::io::Error| WriteFault::Io(error).at(path);
    json.write_all(&plan.json).map_err(io)?;
    if plan.buffer > 0 {
        let mut out = Output::create(&bin)?;
        let mut stream = Stream::new(&mut out, job);
        let put = plan.put_buffer(&mut stream).and_then(|()| stream.finish());
        put.map_err(|fault| fault.at(&bin))?;
        out.finish()?;
        written.files.push(bin);
    }
    json.finish()?;
    written.files.push(path.to_owned());
    Ok(())
}

/// A file name as a URI may hold it (RFC 3986).
fn encoded(name: &str) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
    let one = |byte: u8| {
        if is_plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") }
    };
    name.bytes().map(one).collect()
}

/// What will be written.
struct Plan<'a> {
    scale: Scale,
    json: Vec<u8>,
    /// Bytes of the buffer.
    buffer: u64,
    parts: Vec<Part<'a>>,
}

/// A surface with at least one triangle.
struct Part<'a> {
    surface: &'a Surface,
    normals: Option<&'a [[f32; 3]]>,
    bounds: Bounds,
}

impl<'a> Plan<'a> {
    fn new(
        format: Format,
        surfaces: &'a [Surface],
        context: &MeshContext,
        uri: Option<String>,
        job: &Job,
        written: &mut Written,
    ) -> Result<Self, WriteFault> {
        let scale = Scale::of(context);
        let is_empty = |surface: &Surface| surface.mesh.triangles.is_empty();
        let shown = surfaces.iter().filter(|surface| !is_empty(surface));
        for Surface { name, mesh, .. } in surfaces.iter().filter(|surface| is_empty(surface)) {
            if !mesh.positions.is_empty() {
                let count = mesh.positions.len();
                let lost = format!("surface {name:?}: {count} vertices and no triangle; left out");
                written.warnings.push(lost);
            }
        }
        let shape = |surface: &Surface, has_normals| Shape {
            vertices: surface.mesh.positions.len() as u64,
            triangles: surface.mesh.triangles.len() as u64,
            has_normals,
        };
        // Before anything that takes time: with JSON of no size at all.
        let (_, least) = layout(shown.clone().map(|s| shape(s, s.mesh.normals.is_some())));
        layout::check(format, 0, least)?;
        let parts = shown.map(|surface| Part::new(surface, scale, format, job, written));
        let parts = parts.collect::<Result<Vec<_>, _>>()?;
        let (blocks, buffer) =
            layout(parts.iter().map(|part| shape(part.surface, part.normals.is_some())));
        let mut contents =
            parts.iter().zip(blocks).map(|(part, blocks)| Content { blocks, bounds: part.bounds });
        let nodes: Vec<_> = surfaces
            .iter()
            .map(|surface| (surface, if is_empty(surface) { None } else { contents.next() }))
            .collect();
        let root = document(&nodes, context, (buffer, uri));
        let json = root.to_vec().map_err(|error| WriteFault::Caller(error.to_string().into()))?;
        layout::check(format, json.len() as u64, buffer)?;
        let items = parts.iter().map(|part| {
            let shape = shape(part.surface, part.normals.is_some());
            shape.vertices * (1 + u64::from(shape.has_normals)) + shape.triangles
        });
        job.progress.begin("write", items.sum());
        Ok(Self { scale, json, buffer, parts })
    }

    fn put_buffer(&self, stream: &mut Stream<'_>) -> Result<(), WriteFault> {
        for part in &self.parts {
            let mesh = &part.surface.mesh;
            let positions = mesh.positions.iter().map(|xyz| self.scale.store(xyz));
            stream.items(positions, put_f32)?;
            if let Some(normals) = part.normals {
                stream.items(normals.iter().map(|&normal| y_up(unit(normal))), put_f32)?;
            }
            stream.items(mesh.triangles.iter().copied(), put_u32)?;
        }
        Ok(())
    }
}

impl<'a> Part<'a> {
    fn new(
        surface: &'a Surface,
        scale: Scale,
        format: Format,
        job: &Job,
        written: &mut Written,
    ) -> Result<Self, WriteFault> {
        let loss = Loss::of(surface, |xyz| scale.store(xyz), |xyz| scale.restore(xyz), job)?;
        loss.report(surface, format, written);
        Ok(Self { surface, normals: directions(surface, written), bounds: bounds(surface, scale)? })
    }
}

/// The box around what is written, which glTF wants to know exactly.
fn bounds(surface: &Surface, scale: Scale) -> Result<Bounds, WriteFault> {
    let mut bounds = Bounds { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };
    for (vertex, xyz) in surface.mesh.positions.iter().enumerate() {
        let stored = scale.store(xyz);
        if !stored.iter().all(|c| c.is_finite()) {
            let name = &surface.name;
            let fault = format!(
                "surface {name:?}: vertex {vertex} is at {xyz:?}; glTF holds finite f32 only"
            );
            return Err(WriteFault::Caller(fault.into()));
        }
        bounds.min = array::from_fn(|k| bounds.min[k].min(stored[k]));
        bounds.max = array::from_fn(|k| bounds.max[k].max(stored[k]));
    }
    Ok(bounds)
}

/// The normals, if each has a direction: glTF allows no others.
fn directions<'a>(surface: &'a Surface, written: &mut Written) -> Option<&'a [[f32; 3]]> {
    let normals = surface.mesh.normals.as_deref()?;
    let has_none = |&normal: &[f32; 3]| !unit(normal).iter().all(|c| c.is_finite());
    let Some(vertex) = normals.iter().position(has_none) else { return Some(normals) };
    let (name, normal) = (&surface.name, normals[vertex]);
    written.warnings.push(format!(
        "surface {name:?}: the normal of vertex {vertex} is {normal:?}, which is no direction; written \
         without normals"
    ));
    None
}

/// A normal of length 1, as it is where it is near enough; not finite where it has no direction.
fn unit(normal: [f32; 3]) -> [f32; 3] {
    const NEAR: f64 = 1e-4;
    let square: f64 = normal.iter().map(|&c| f64::from(c) * f64::from(c)).sum();
    if (square - 1.0).abs() <= NEAR {
        return normal;
    }
    normal.map(|c| (f64::from(c) / square.sqrt()) as f32)
}
