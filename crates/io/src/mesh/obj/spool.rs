//! OBJ of surfaces that come in pieces.
//!
//! Faces count the vertices of all surfaces before, which may still be coming. So they are kept as numbers
//! and become text when all is there.

use super::write::{Library, head, put_faces, put_normals, put_vertices, titles};
use crate::{
    Output, WriteError, WriteFault,
    mesh::{
        MeshContext, Written,
        outline::Outline,
        section::Section,
        stream::{Stream, put_u32},
    },
};
use isokit_job::Job;
use isokit_mesh::TriMesh;
use std::io::{self, Write};

/// A surface that comes in pieces.
#[derive(Debug)]
pub(in crate::mesh) struct Spool {
    vertices: Section,
    normals: Section,
    triangles: Section,
}

impl Spool {
    pub(in crate::mesh) fn create(beside: &Output) -> io::Result<Self> {
        let [vertices, normals, triangles] = [(); 3].map(|()| Section::create(beside));
        Ok(Self { vertices: vertices?, normals: normals?, triangles: triangles? })
    }

    /// Takes in the next piece.
    pub(in crate::mesh) fn take(&mut self, piece: &TriMesh, job: &Job) -> Result<(), WriteFault> {
        self.vertices.add(job, |stream| put_vertices(stream, &piece.positions))?;
        if let Some(normals) = &piece.normals {
            self.normals.add(job, |stream| put_normals(stream, normals))?;
        }
        let triangles = piece.triangles.iter().copied();
        self.triangles.add(job, |stream| stream.items(triangles, put_u32))
    }

    pub(in crate::mesh) fn sections(&self) -> [&Section; 3] {
        [&self.vertices, &self.normals, &self.triangles]
    }
}

/// Writes what [`write_with_materials`](super::write_with_materials) writes of the whole surfaces.
pub(in crate::mesh) fn finish(
    all: Vec<Spool>,
    mut object: Output,
    outlines: &[Outline],
    context: &MeshContext,
    job: &Job,
    written: &mut Written,
) -> Result<(), WriteError> {
    let path = object.path().to_owned();
    let library = Library::beside(&path, outlines);
    put_all(all, &mut object, outlines, context, &library, job).map_err(|fault| fault.at(path))?;
    library.finish(object, written)
}

fn put_all(
    all: Vec<Spool>,
    object: &mut Output,
    outlines: &[Outline],
    context: &MeshContext,
    library: &Library,
    job: &Job,
) -> Result<(), WriteFault> {
    object.write_all(head(context, Some(library)).as_bytes())?;
    for (spool, title) in all.into_iter().zip(titles(outlines, Some(library))) {
        object.write_all(title.text.as_bytes())?;
        spool.vertices.append_to(object, job)?;
        spool.normals.append_to(object, job)?;
        let quiet = job.unwatched();
        spool.triangles.read(job, |triangles| {
            let mut stream = Stream::new(object, &quiet);
            put_faces(&mut stream, triangles, title.first)?;
            stream.finish()
        })?;
    }
    Ok(())
}
