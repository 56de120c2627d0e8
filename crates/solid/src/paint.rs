//! The colours of a surface: those of vertices, and what is between them.
//!
//! A colour is four codes, sRGB and straight opacity, and what is between vertices is linear in the codes, as most programs
//! draw it that have colours of vertices in bytes. Nothing is turned into light and back, so a colour that all corners have
//! comes out as it is, and one that is linear in space stays so.

use crate::SolidError;
use isokit_job::{Job, Stopped};
use isokit_mesh::{Rgba, TriMesh};

/// The colours of all corners.
#[derive(Clone, Debug)]
pub(crate) struct Paint {
    /// In the order of facets.
    corners: Vec<[Rgba; 3]>,
    is_opaque: bool,
}

impl Paint {
    /// The colours of a mesh whose triangles are in this order; none if it has none.
    pub(crate) fn of(
        mesh: &TriMesh,
        triangles: &[u32],
        job: &Job,
    ) -> Result<Option<Self>, SolidError> {
        let Some(colors) = &mesh.attributes.colors else { return Ok(None) };
        let vertices = mesh.positions.len();
        if colors.len() != vertices {
            return Err(SolidError::Colors { colors: colors.len(), vertices });
        }
        let count = Some(triangles.len() as u64);
        let mut corners = job.limits.vec("colours of triangles", count).map_err(Stopped::from)?;
        let colored = |&t: &u32| mesh.triangles[t as usize].map(|vertex| colors[vertex as usize]);
        corners.extend(triangles.iter().map(colored));
        let is_opaque = !corners.as_flattened().iter().any(|color: &Rgba| color.is_translucent());
        Ok(Some(Self { corners, is_opaque }))
    }

    /// Whether nothing shows through anywhere.
    pub(crate) fn is_opaque(&self) -> bool {
        self.is_opaque
    }

    /// What there is of a facet where so much of each corner is.
    pub(crate) fn mixed(&self, facet: u32, shares: [f64; 3]) -> Rgba {
        let corners = &self.corners[facet as usize];
        let code = |k: usize| {
            let [a, b, c] = [0, 1, 2].map(|n| shares[n] * f64::from(corners[n].0[k]));
            (a + b + c).round().clamp(0.0, 255.0) as u8
        };
        Rgba([0, 1, 2, 3].map(code))
    }
}
