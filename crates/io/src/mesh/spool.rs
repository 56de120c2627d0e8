//! Surfaces that come in pieces, several at the same time, gathered in memory and then written.

use crate::{MeshContext, WriteError, Written, write_mesh};
use isokit_job::Job;
use isokit_mesh::{
    Counts, MeshSink, Piece, Positions, PositionsMut, Precision, Rgba, Surface, TriMesh,
};
use std::path::{Path, PathBuf};
/// What a file says of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceHead {
    /// What a viewer calls it.
    pub name: String,
    /// How it looks; `None` leaves it to the viewer.
    pub color: Option<Rgba>,
    /// The value it is the isosurface of, where it is one.
    pub iso: Option<f64>,
}
/// Gathers surfaces for a file.
#[derive(Debug)]
pub struct MeshSpool {
    path: PathBuf,
    surfaces: Vec<Surface>,
    context: MeshContext,
    job: Job,
}
/// Takes the pieces of a surface.
#[derive(Debug)]
pub struct SpoolSink<'a>(&'a mut TriMesh);
impl MeshSpool {
    /// Begins with empty surfaces.
    ///
    /// # Errors
    ///
    /// If the file cannot be made.
    pub fn create(
        path: &Path,
        heads: Vec<SurfaceHead>,
        normals: bool,
        context: &MeshContext,
        job: &Job,
    ) -> Result<Self, WriteError> {
        let surfaces = heads
            .into_iter()
            .map(|h| Surface {
                name: h.name,
                color: h.color,
                iso: h.iso,
                mesh: TriMesh { normals: normals.then(Vec::new), ..TriMesh::default() },
            })
            .collect();
        Ok(Self { path: path.to_owned(), surfaces, context: context.clone(), job: job.clone() })
    }
    /// Takes the pieces of a surface.
    pub fn sink(&mut self, n: usize) -> SpoolSink<'_> {
        SpoolSink(&mut self.surfaces[n].mesh)
    }
    /// Writes the file.
    ///
    /// # Errors
    ///
    /// As [`write_mesh`].
    pub fn finish(self) -> Result<Written, WriteError> {
        write_mesh(&self.path, &self.surfaces, &self.context, &self.job)
    }
}
impl MeshSink for SpoolSink<'_> {
    type Error = WriteError;
    fn wants_normals(&self) -> bool {
        self.0.normals.is_some()
    }
    fn piece(&mut self, counts: Counts, precision: Precision) -> Result<Piece<'_>, WriteError> {
        let v = counts.vertices as usize;
        let t = counts.triangles as usize;
        if self.0.positions.is_empty() && precision == Precision::F64 {
            self.0.positions = Positions::F64(vec![]);
        }
        let n = self.0.positions.len();
        let positions = match &mut self.0.positions {
            Positions::F32(p) => {
                p.resize(n + v, [0.0; 3]);
                PositionsMut::F32(&mut p[n..])
            }
            Positions::F64(p) => {
                p.resize(n + v, [0.0; 3]);
                PositionsMut::F64(&mut p[n..])
            }
        };
        let normals = self.0.normals.as_mut().map(|p| {
            p.resize(n + v, [0.0; 3]);
            &mut p[n..]
        });
        let m = self.0.triangles.len();
        self.0.triangles.resize(m + t, [0; 3]);
        Ok(Piece { positions, normals, triangles: &mut self.0.triangles[m..] })
    }
}
