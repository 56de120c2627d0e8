//! A surface as headers tell of it: what it is called, and how much of it there is.

use isokit_mesh::{Counts, Precision, Rgba, Surface};

/// What is known of a surface before its vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceHead {
    /// What a viewer calls it.
    pub name: String,
    /// How it looks; `None` leaves it to the viewer.
    pub color: Option<Rgba>,
    /// The value it is the isosurface of, where it is one.
    pub iso: Option<f64>,
}

impl From<&Surface> for SurfaceHead {
    fn from(surface: &Surface) -> Self {
        Self { name: surface.name.clone(), color: surface.color, iso: surface.iso }
    }
}

/// All that a file says of a surface before its vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Outline {
    pub(super) head: SurfaceHead,
    pub(super) counts: Counts,
    pub(super) precision: Precision,
    pub(super) has_normals: bool,
    pub(super) has_values: bool,
    pub(super) has_colors: bool,
}

impl Outline {
    /// How many normals there are.
    pub(super) fn normals(&self) -> u64 {
        if self.has_normals { self.counts.vertices } else { 0 }
    }

    /// All that is written one by one: vertices, normals, colours, values and triangles.
    pub(super) fn items(&self) -> u64 {
        let kinds = 1 + [self.has_normals, self.has_colors, self.has_values]
            .map(u64::from)
            .iter()
            .sum::<u64>();
        self.counts.vertices * kinds + self.counts.triangles
    }
}

impl From<&Surface> for Outline {
    fn from(surface: &Surface) -> Self {
        let mesh = &surface.mesh;
        Self {
            head: surface.into(),
            counts: mesh.counts(),
            precision: mesh.positions.precision(),
            has_normals: mesh.normals.is_some(),
            has_values: mesh.attributes.values.is_some(),
            has_colors: mesh.attributes.colors.is_some(),
        }
    }
}
