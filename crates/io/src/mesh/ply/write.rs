//! Writes binary PLY.

use super::{COLORS, VALUE};
use crate::{
    Output, WriteFault,
    mesh::{
        MeshContext, facts,
        outline::Outline,
        section::Section,
        stream::{Stream, put_f32, put_f64, put_u32},
    },
};
use isokit_job::Job;
use isokit_mesh::{Attributes, Positions, Precision, Surface, TriMesh};
use std::io::{self, Write};

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
    stream.put(header(&surface.into(), context).as_bytes());
    put_vertices(&mut stream, mesh)?;
    put_faces(&mut stream, mesh)?;
    stream.finish()
}

/// A surface that comes in pieces.
#[derive(Debug)]
pub(in crate::mesh) struct Spool {
    vertices: Section,
    faces: Section,
}

impl Spool {
    pub(in crate::mesh) fn create(beside: &Output) -> io::Result<Self> {
        Ok(Self { vertices: Section::create(beside)?, faces: Section::create(beside)? })
    }

    /// Takes in the next piece.
    pub(in crate::mesh) fn take(&mut self, piece: &TriMesh, job: &Job) -> Result<(), WriteFault> {
        self.vertices.add(job, |stream| put_vertices(stream, piece))?;
        self.faces.add(job, |stream| put_faces(stream, piece))
    }

    pub(in crate::mesh) fn sections(&self) -> [&Section; 2] {
        [&self.vertices, &self.faces]
    }

    /// What [`write()`] writes of the whole surface.
    pub(in crate::mesh) fn finish(
        self,
        out: &mut Output,
        outline: &Outline,
        context: &MeshContext,
        job: &Job,
    ) -> Result<(), WriteFault> {
        out.write_all(header(outline, context).as_bytes())?;
        self.vertices.append_to(out, job)?;
        self.faces.append_to(out, job)
    }
}

fn put_vertices(stream: &mut Stream<'_>, mesh: &TriMesh) -> Result<(), WriteFault> {
    match &mesh.positions {
        Positions::F32(all) => put_each(stream, all, mesh, put_f32),
        Positions::F64(all) => put_each(stream, all, mesh, put_f64),
    }
}

fn put_each<T: Copy>(
    stream: &mut Stream<'_>,
    positions: &[T],
    mesh: &TriMesh,
    put: impl Fn(&mut Vec<u8>, T),
) -> Result<(), WriteFault> {
    let Attributes { values, colors } = &mesh.attributes;
    if !mesh.attributes.is_empty() {
        return stream.items(0..positions.len(), |bytes, vertex| {
            put(bytes, positions[vertex]);
            if let Some(normals) = &mesh.normals {
                put_f32(bytes, normals[vertex]);
            }
            if let Some(colors) = colors {
                bytes.extend(colors[vertex].0);
            }
            if let Some(values) = values {
                bytes.extend(values[vertex].to_le_bytes());
            }
        });
    }
    match &mesh.normals {
        None => stream.items(positions, |bytes, &xyz| put(bytes, xyz)),
        Some(normals) => stream.items(positions.iter().zip(normals), |bytes, (&xyz, &normal)| {
            put(bytes, xyz);
            put_f32(bytes, normal);
        }),
    }
}

fn put_faces(stream: &mut Stream<'_>, mesh: &TriMesh) -> Result<(), WriteFault> {
    stream.items(mesh.triangles.iter(), |bytes, &corners| {
        bytes.push(3);
        put_u32(bytes, corners);
    })
}

fn header(outline: &Outline, context: &MeshContext) -> String {
    let vertices = outline.counts.vertices;
    let mut lines = vec!["ply".to_owned(), "format binary_little_endian 1.0".to_owned()];
    let facts = facts::of_file(context).into_iter().chain(facts::of_surface(&outline.head));
    lines.extend(facts.map(|fact| format!("comment {fact}")));
    lines.push(format!("element vertex {vertices}"));
    let float = match outline.precision {
        Precision::F32 => "float",
        Precision::F64 => "double",
    };
    lines.extend(["x", "y", "z"].map(|name| format!("property {float} {name}")));
    if outline.has_normals {
        lines.extend(["nx", "ny", "nz"].map(|name| format!("property float {name}")));
    }
    if outline.has_colors {
        lines.extend(COLORS.map(|name| format!("property uchar {name}")));
    }
    if outline.has_values {
        lines.push(format!("property float {VALUE}"));
    }
    lines.push(format!("element face {}", outline.counts.triangles));
    // Every reader knows `int`; `uint` is taken where it is needed.
    let index = if i32::try_from(vertices).is_ok() { "int" } else { "uint" };
    lines.push(format!("property list uchar {index} vertex_indices"));
    lines.push("end_header\n".to_owned());
    lines.join("\n")
}
