//! What can be said of a mesh.

use super::RefineReport;
use isokit::{
    geom::Aabb,
    mesh::{Gauge, Surface, Topology},
};
use serde::Serialize;

/// What a mesh is as a surface: every counter apart. The whole of several adds them up.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct MeshCounts {
    pub(crate) vertices: u64,
    pub(crate) triangles: u64,
    pub(crate) components: u64,
    pub(crate) euler: i64,
    /// Handles; null unless the surface is closed, manifold and oriented.
    pub(crate) genus: Option<u64>,
    pub(crate) boundary_edges: u64,
    pub(crate) nonmanifold_edges: u64,
    pub(crate) nonmanifold_vertices: u64,
    pub(crate) inconsistent_edges: u64,
    pub(crate) degenerate_triangles: u64,
    pub(crate) duplicate_triangles: u64,
    pub(crate) out_of_range_triangles: u64,
    pub(crate) non_finite_vertices: u64,
    pub(crate) unused_vertices: u64,
    /// In squared units.
    pub(crate) area: f64,
    /// In cubed units; means something only if the surface is closed and oriented.
    pub(crate) volume: f64,
    /// Least and greatest coordinates; null if there are no vertices.
    pub(crate) bounds: Option<[[f64; 3]; 2]>,
}

/// What is known of a mesh that never was in memory as a whole.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct SlabCounts {
    pub(crate) vertices: u64,
    pub(crate) triangles: u64,
    pub(crate) components: u64,
    pub(crate) euler: i64,
    pub(crate) boundary_edges: u64,
    pub(crate) nonmanifold_edges: u64,
    pub(crate) inconsistent_edges: u64,
    pub(crate) degenerate_triangles: u64,
    pub(crate) area: f64,
    pub(crate) volume: f64,
    pub(crate) bounds: Option<[[f64; 3]; 2]>,
}

impl SlabCounts {
    pub(crate) fn of(gauge: &Gauge) -> Self {
        Self {
            vertices: gauge.vertices,
            triangles: gauge.triangles,
            components: gauge.components,
            euler: gauge.euler(),
            boundary_edges: gauge.boundary_edges,
            nonmanifold_edges: gauge.nonmanifold_edges,
            inconsistent_edges: gauge.inconsistent_edges,
            degenerate_triangles: gauge.degenerate_triangles,
            area: gauge.measure.area,
            volume: gauge.measure.volume,
            bounds: gauge.measure.bounds.map(corners),
        }
    }
}

/// A surface in a report.
#[derive(Debug, Serialize)]
pub(crate) struct SurfaceReport<C = MeshCounts> {
    pub(crate) name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) iso: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) color: Option<String>,
    /// Cells in which a saddle is exactly on the isovalue; where the surface was extracted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) singular_cells: Option<u64>,
    /// What was done after that, where anything was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) refined: Option<RefineReport>,
    #[serde(flatten)]
    pub(crate) counts: C,
    /// What it lacks to be a surface that every program takes, in words; where that was asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) shortfalls: Option<Vec<String>>,
}

/// What `info --json` prints of a mesh.
#[derive(Debug, Serialize)]
pub(crate) struct MeshReport {
    pub(crate) schema: &'static str,
    pub(crate) kind: &'static str,
    pub(crate) path: String,
    pub(crate) format: &'static str,
    pub(crate) unit: String,
    pub(crate) space: String,
    pub(crate) vertices: u64,
    pub(crate) triangles: u64,
    pub(crate) bounds: Option<[[f64; 3]; 2]>,
    pub(crate) surfaces: Vec<SurfaceBrief>,
    pub(crate) notes: Vec<String>,
}

/// A surface of which only the extent is told.
#[derive(Debug, Serialize)]
pub(crate) struct SurfaceBrief {
    pub(crate) name: String,
    pub(crate) color: Option<String>,
    pub(crate) vertices: u64,
    pub(crate) triangles: u64,
    pub(crate) normals: bool,
    pub(crate) bounds: Option<[[f64; 3]; 2]>,
}

/// What `check --json` prints.
#[derive(Debug, Serialize)]
pub(crate) struct CheckReport {
    pub(crate) schema: &'static str,
    pub(crate) ok: bool,
    pub(crate) path: String,
    #[serde(flatten)]
    pub(crate) whole: MeshCounts,
    pub(crate) surfaces: Vec<SurfaceReport>,
    pub(crate) notes: Vec<String>,
}

impl MeshCounts {
    pub(crate) fn of(topology: &Topology) -> Self {
        Self {
            vertices: topology.vertices,
            triangles: topology.triangles,
            components: topology.components.len() as u64,
            euler: topology.euler(),
            genus: topology.genus(),
            boundary_edges: topology.boundary_edges,
            nonmanifold_edges: topology.nonmanifold_edges,
            nonmanifold_vertices: topology.nonmanifold_vertices,
            inconsistent_edges: topology.inconsistent_edges,
            degenerate_triangles: topology.degenerate_triangles,
            duplicate_triangles: topology.duplicate_triangles,
            out_of_range_triangles: topology.out_of_range_triangles,
            non_finite_vertices: topology.non_finite_vertices,
            unused_vertices: topology.unused_vertices,
            area: topology.measure.area,
            volume: topology.measure.volume,
            bounds: topology.measure.bounds.map(corners),
        }
    }

    /// Both together.
    pub(crate) fn with(self, other: &Self) -> Self {
        Self {
            vertices: self.vertices + other.vertices,
            triangles: self.triangles + other.triangles,
            components: self.components + other.components,
            euler: self.euler + other.euler,
            genus: self.genus.zip(other.genus).map(|(a, b)| a + b),
            boundary_edges: self.boundary_edges + other.boundary_edges,
            nonmanifold_edges: self.nonmanifold_edges + other.nonmanifold_edges,
            nonmanifold_vertices: self.nonmanifold_vertices + other.nonmanifold_vertices,
            inconsistent_edges: self.inconsistent_edges + other.inconsistent_edges,
            degenerate_triangles: self.degenerate_triangles + other.degenerate_triangles,
            duplicate_triangles: self.duplicate_triangles + other.duplicate_triangles,
            out_of_range_triangles: self.out_of_range_triangles + other.out_of_range_triangles,
            non_finite_vertices: self.non_finite_vertices + other.non_finite_vertices,
            unused_vertices: self.unused_vertices + other.unused_vertices,
            area: self.area + other.area,
            volume: self.volume + other.volume,
            bounds: around(self.bounds.into_iter().chain(other.bounds)),
        }
    }
}

impl SurfaceReport {
    pub(crate) fn of(surface: &Surface, topology: &Topology) -> Self {
        Self {
            name: surface.name.clone(),
            iso: surface.iso,
            color: surface.color.map(|color| color.to_string()),
            singular_cells: None,
            refined: None,
            counts: MeshCounts::of(topology),
            shortfalls: None,
        }
    }
}

impl SurfaceBrief {
    pub(crate) fn of(surface: &Surface) -> Self {
        let counts = surface.mesh.counts();
        Self {
            name: surface.name.clone(),
            color: surface.color.map(|color| color.to_string()),
            vertices: counts.vertices,
            triangles: counts.triangles,
            normals: surface.mesh.normals.is_some(),
            bounds: surface.mesh.bounds().map(corners),
        }
    }
}

/// The box around several boxes.
pub(crate) fn around(boxes: impl IntoIterator<Item = [[f64; 3]; 2]>) -> Option<[[f64; 3]; 2]> {
    Aabb::around(boxes.into_iter().flatten()).map(corners)
}

fn corners(bounds: Aabb) -> [[f64; 3]; 2] {
    [bounds.min, bounds.max]
}
