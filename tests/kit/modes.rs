//! The options that say what a surface is, and what its normals are made from.

use isokit::marching_cubes::{Boundary, Diagonals, ExtractOptions, Gradient, Placement, Topology};

/// Each topology with each maker of vertices and normals, closed and open; vertices are kept apart.
pub fn modes() -> Vec<ExtractOptions> {
    let mut all = vec![];
    for topology in [Topology::Table, Topology::Trilinear] {
        for (placement, gradient) in [
            (Placement::Linear, Gradient::Central),
            (Placement::Cubic, Gradient::Matching),
            (Placement::Quintic, Gradient::Central),
            (Placement::Quintic, Gradient::Matching),
        ] {
            for boundary in [Boundary::Closed, Boundary::Open] {
                let options = ExtractOptions::DEFAULT.with_topology(topology);
                let options = options.with_placement(placement).with_gradient(gradient);
                all.push(options.with_boundary(boundary));
            }
        }
    }
    all
}

/// The same, where quintics with central normals have fitted diagonals, closed by the table and open by the trilinear
/// interpolant; a mesh must have normals for that.
pub fn modes_some_fitted() -> Vec<ExtractOptions> {
    let mut all = modes();
    for options in &mut all {
        let is_plain =
            (options.placement, options.gradient) == (Placement::Quintic, Gradient::Central);
        let is_closed = options.boundary == Boundary::Closed;
        if is_plain && is_closed == (options.topology == Topology::Table) {
            options.diagonals = Diagonals::Fitted;
        }
    }
    all
}
