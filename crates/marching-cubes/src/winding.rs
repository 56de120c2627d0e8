//! A frame that mirrors turns triangles round.

use isokit_geom::Frame;

/// Which way round triangles go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Winding {
    /// As the table has them.
    Kept,
    /// The other way, since the frame mirrors.
    Turned,
}

impl Winding {
    /// The one that keeps triangles counter-clockwise in a frame.
    pub(crate) fn of(frame: &Frame) -> Self {
        match frame.index_to_world.determinant() < 0.0 {
            true => Self::Turned,
            false => Self::Kept,
        }
    }
}
