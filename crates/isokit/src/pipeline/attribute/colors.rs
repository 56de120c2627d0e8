//! The colours of a volume of colours at the vertices of a mesh.

use super::at_vertices;
use crate::pipeline::{PipelineError, Scan};
use isokit_field::{Between, probe};
use isokit_job::Job;
use isokit_mesh::{Rgba, TriMesh};
use isokit_volume::ColorVolume;

impl Scan {
    /// The colours of a volume of colours at the vertices of a mesh of this scan; none where it has none, as [`probe`] says. The
    /// mesh is where this scan is; the colours may have any lattice. Of what both say of their world,
    /// [`attribute`](Self::attribute) tells.
    ///
    /// Between samples each of the numbers is linear as it is kept, and rounded. A colour of three numbers is opaque.
    ///
    /// # Errors
    ///
    /// If the job is cancelled or allows less memory.
    pub fn attribute_colors(
        &self,
        mesh: &TriMesh,
        colors: &ColorVolume,
        between: Between,
        job: &Job,
    ) -> Result<Vec<Option<Rgba>>, PipelineError> {
        let views = colors.views();
        let at = |ijk| {
            let mut color = [u8::MAX; 4];
            for (code, view) in color.iter_mut().zip(&views) {
                // Rounding ends between the least and the greatest byte.
                *code = probe(view, ijk, between)?.round() as u8;
            }
            Some(Rgba(color))
        };
        let way = self.way(&colors.grid().frame);
        at_vertices(mesh, &way, ("colours of vertices", at), job)
    }
}
