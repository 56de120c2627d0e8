//! What became of a surface after it was extracted.

use isokit::refine::{RefineOptions, Refined, Subdivision};
use serde::Serialize;

/// What `--refine`, `--max-error` and `--balance` did. Distances are in world units.
#[derive(Debug, Serialize)]
pub(crate) struct RefineReport {
    /// New vertices on creases.
    creased_vertices: u64,
    /// How often edges were divided.
    rounds: u32,
    new_vertices: u64,
    /// New vertices that are in the middle of their edges, not on the field.
    unprojected_vertices: u64,
    /// Edges that stayed whole because a triangle would have become flat.
    undivided_edges: u64,
    /// The error that was asked for.
    max_error: Option<f64>,
    /// The error that was reached, by all triangles but those without a bound, before they were balanced.
    bound: Option<f64>,
    unbounded_triangles: u64,
    /// Vertices that were moved so that triangles are as much outside as inside, and those that could not.
    balanced_vertices: u64,
    unbalanced_vertices: u64,
}

impl RefineReport {
    /// None where nothing was to be done.
    pub(crate) fn of(options: &RefineOptions, refined: &Refined) -> Option<Self> {
        let max_error = match options.subdivision {
            Subdivision::MaxError(error) => Some(error),
            _ => None,
        };
        let report = Self {
            creased_vertices: refined.creased,
            rounds: refined.rounds,
            new_vertices: refined.new_vertices,
            unprojected_vertices: refined.unprojected,
            undivided_edges: refined.undivided,
            max_error,
            bound: refined.bound,
            unbounded_triangles: refined.unbounded,
            balanced_vertices: refined.balanced,
            unbalanced_vertices: refined.unbalanced,
        };
        (!options.do_nothing()).then_some(report)
    }
}
