//! What a mesh lacks to be a surface that every program takes.

use crate::Topology;

impl Topology {
    /// Vertices in use − edges + triangles.
    pub fn euler(&self) -> i64 {
        let faces: u64 = self.components.iter().map(|component| component.triangles).sum();
        (self.vertices - self.unused_vertices) as i64 - self.edges as i64 + faces as i64
    }

    /// How many handles all pieces have together; `None` unless each has a genus.
    pub fn genus(&self) -> Option<u64> {
        self.components.iter().map(|component| component.genus()).sum()
    }

    /// Whether no edge belongs to one triangle only.
    pub fn is_closed(&self) -> bool {
        self.boundary_edges == 0
    }

    /// Whether the triangles around each vertex are one fan, open or closed, and each edge has at most two.
    pub fn is_manifold(&self) -> bool {
        self.nonmanifold_edges == 0 && self.nonmanifold_vertices == 0
    }

    /// Whether neighbours are wound alike everywhere.
    pub fn is_oriented(&self) -> bool {
        self.inconsistent_edges == 0
    }

    /// Whether a closed, consistently wound surface as a whole has its outside inside. Single pieces may:
    /// cavities do.
    pub fn is_inside_out(&self) -> bool {
        let span = self.measure.bounds.map_or(0.0, |bounds| {
            (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f64::max)
        });
        // What lies flat has no volume but for rounding.
        let rounding = 1e-13 * self.measure.area * span;
        self.is_closed() && self.is_oriented() && self.measure.volume < -rounding
    }

    /// What the mesh lacks to be closed, manifold, consistently wound with its outside outside, without
    /// degenerate or duplicate triangles, and finite: one line each, in words; nothing if it has it all.
    pub fn shortfalls(&self) -> Vec<String> {
        let counters = [
            (self.out_of_range_triangles, "triangle", "naming a missing vertex"),
            (self.non_finite_vertices, "vertex", "not finite"),
            (self.boundary_edges, "edge", "with one triangle only: not closed"),
            (self.nonmanifold_edges, "edge", "with more than two triangles: not manifold"),
            (self.nonmanifold_vertices, "vertex", "not amid a single fan: not manifold"),
            (self.inconsistent_edges, "edge", "with neighbours wound against one another"),
            (self.degenerate_triangles, "triangle", "without area"),
            (self.duplicate_triangles, "triangle", "there more than once"),
        ];
        let counted = counters.into_iter().filter(|(count, ..)| *count > 0);
        let mut lines: Vec<String> = counted
            .map(|(count, noun, lack)| format!("{count} {} {lack}", plural(count, noun)))
            .collect();
        if self.is_inside_out() {
            lines.push(format!("inside out: the volume is {}", self.measure.volume));
        }
        lines
    }
}

/// The noun as it follows a number.
fn plural(count: u64, noun: &'static str) -> &'static str {
    match (count, noun) {
        (1, _) => noun,
        (_, "vertex") => "vertices",
        (_, "edge") => "edges",
        (_, _) => "triangles",
    }
}
