//! Writes binary PLY.

use crate::{
    WriteFault,
    mesh::{
        MeshContext, facts,
        stream::{Stream, put_f32, put_f64, put_u32},
    },
};
use isokit_job::Job;
use isokit_mesh::{Positions, Precision, Surface, TriMesh};
use std::io::Write;

/// Writes one surface.
pub(in crate::mesh) fn write(
    out: &mut dyn Write,
    surface: &Surface,
    context: &MeshContext,
    job: &Job,
) -> Result<(), WriteFault> {
    let mesh = &surface.mesh;
    let counts = mesh.counts();
    job.progress.begin("write", counts.vertices + counts.triangles);
    let mut stream = Stream::new(out, job);
    stream.put(header(surface, context).as_bytes());
    match &mesh.positions {
        Positions::F32(all) => put_vertices(&mut stream, all, mesh, put_f32)?,
        Positions::F64(all) => put_vertices(&mut stream, all, mesh, put_f64)?,
    }
    stream.items(mesh.triangles.iter(), |bytes, &corners| {
        bytes.push(3);
        put_u32(bytes, corners);
    })?;
    stream.finish()
}

fn put_vertices<T: Copy>(
    stream: &mut Stream<'_>,
    positions: &[T],
    mesh: &TriMesh,
    put: impl Fn(&mut Vec<u8>, T),
) -> Result<(), WriteFault> {
    match &mesh.normals {
        None => stream.items(positions, |bytes, &xyz| put(bytes, xyz)),
        Some(normals) => stream.items(positions.iter().zip(normals), |bytes, (&xyz, &normal)| {
            put(bytes, xyz);
            put_f32(bytes, normal);
        }),
    }
}

fn header(surface: &Surface, context: &MeshContext) -> String {
    let mesh = &surface.mesh;
    let mut lines = vec!["ply".to_owned(), "format binary_little_endian 1.0".to_owned()];
    let facts = facts::of_file(context).into_iter().chain(facts::of_surface(surface));
    lines.extend(facts.map(|fact| format!("comment {fact}")));
    lines.push(format!("element vertex {}", mesh.positions.len()));
    let float = match mesh.positions.precision() {
        Precision::F32 => "float",
        Precision::F64 => "double",
    };
    lines.extend(["x", "y", "z"].map(|name| format!("property {float} {name}")));
    if mesh.normals.is_some() {
        lines.extend(["nx", "ny", "nz"].map(|name| format!("property float {name}")));
    }
    lines.push(format!("element face {}", mesh.triangles.len()));
    // Every reader knows `int`; `uint` is taken where it is needed.
    let index = if i32::try_from(mesh.positions.len()).is_ok() { "int" } else { "uint" };
    lines.push(format!("property list uchar {index} vertex_indices"));
    lines.push("end_header\n".to_owned());
    lines.join("\n")
}
