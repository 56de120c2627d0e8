//! What tests ask of meshes.

use isokit_mesh::{TriMesh, is_degenerate};
use std::collections::BTreeSet;

/// The first sample of a volume in which f32 tells a 64th of a unit, as far from the origin as meshes of f32 go where
/// samples are one unit apart.
pub(crate) const FAR: [f64; 3] = [255_500.0, -130_000.0, 200_000.0];

/// How many vertices are in one place with another, and how many triangles are flat, in a file that multiplies coordinates
/// by `scale` and rounds them to f32.
pub(crate) fn lost(mesh: &TriMesh, scale: f64) -> [usize; 2] {
    let stored = |place: [f64; 3]| place.map(|c| f64::from((c * scale) as f32));
    // + 0.0 makes 0 of −0.
    let places: BTreeSet<_> =
        mesh.positions.iter().map(|place| stored(place).map(|c| (c + 0.0).to_bits())).collect();
    let flat = |triangle: &&[u32; 3]| is_degenerate(mesh.corners(**triangle).map(stored));
    [mesh.positions.len() - places.len(), mesh.triangles.iter().filter(flat).count()]
}
