//! In which world the mesh is.

use isokit_geom::{Frame, Space};

/// Whose axes the coordinates of a mesh follow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TargetSpace {
    /// The file's own.
    #[default]
    Source,
    /// x to the right, y to anterior, z to superior.
    Ras,
    /// x to the left, y to posterior, z to superior.
    Lps,
    /// Sample numbers: neighbours are 1 apart, and there is no unit.
    Index,
}

/// The file does not say which way its axes point, so nobody can turn them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the axes cannot be turned to {wanted}: the file does not say which way its own point")]
pub struct UnknownSpace {
    /// What was asked for.
    pub wanted: Space,
}

impl TargetSpace {
    /// The frame of the same samples in this world.
    ///
    /// # Errors
    ///
    /// If RAS or LPS is wanted of a frame whose space is unknown.
    pub fn place(self, frame: Frame) -> Result<Frame, UnknownSpace> {
        let turned = |wanted| frame.in_space(wanted).ok_or(UnknownSpace { wanted });
        match self {
            Self::Source => Ok(frame),
            Self::Ras => turned(Space::Ras),
            Self::Lps => turned(Space::Lps),
            Self::Index => Ok(Frame::default()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{TargetSpace, UnknownSpace};
    use isokit_geom::{Affine, Frame, Space, Unit};

    #[test]
    fn a_known_space_is_turned_and_an_unknown_one_is_not() {
        let index_to_world = Affine::axis_aligned([1.0, 2.0, 3.0], [10.0, 20.0, 30.0]).unwrap();
        let ras = Frame { index_to_world, unit: Unit::Millimetre, space: Space::Ras };
        let lps = TargetSpace::Lps.place(ras).unwrap();
        assert_eq!(lps.index_to_world.origin(), [-10.0, -20.0, 30.0]);
        assert_eq!(TargetSpace::Source.place(ras), Ok(ras));
        assert_eq!(TargetSpace::Index.place(ras), Ok(Frame::default()));
        let unknown = TargetSpace::Ras.place(Frame::default());
        assert_eq!(unknown, Err(UnknownSpace { wanted: Space::Ras }));
    }
}
