//! The lattice around a mesh.

use isokit_geom::{Aabb, Affine, AffineError, Frame, Space, Unit};
use isokit_volume::{Grid, GridError};

/// Why there is no such lattice.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AroundError {
    /// Distances between samples that are none.
    #[error("samples are to be farther apart than 0, found {}, {}, {}", .0[0], .0[1], .0[2])]
    Spacing([f64; 3]),
    /// Too many samples to number.
    #[error("{} x {} x {} samples are more than can be numbered", .0[0], .0[1], .0[2])]
    TooMany([f64; 3]),
    /// No place.
    #[error(transparent)]
    Place(#[from] AffineError),
    /// No lattice.
    #[error(transparent)]
    Grid(#[from] GridError),
}

/// Samples so far from each other along the axes of the world, from at least `margin` of them before a box to as many
/// behind it.
///
/// # Errors
///
/// If a distance is not above 0, or there would be more samples than are numbered.
pub fn grid_around(
    bounds: Aabb,
    spacing: [f64; 3],
    margin: u32,
    unit: Unit,
    space: Space,
) -> Result<Grid, AroundError> {
    if !spacing.iter().all(|&step| step > 0.0 && step.is_finite()) {
        return Err(AroundError::Spacing(spacing));
    }
    let margin = f64::from(margin);
    let steps = |k: usize| ((bounds.max[k] - bounds.min[k]) / spacing[k]).ceil();
    let counts = [0, 1, 2].map(|k| steps(k) + 2.0 * margin + 1.0);
    if !counts.iter().all(|&count| count < f64::from(1_u32 << 31)) {
        return Err(AroundError::TooMany(counts));
    }
    let origin = [0, 1, 2].map(|k| bounds.min[k] - margin * spacing[k]);
    let index_to_world = Affine::axis_aligned(spacing, origin)?;
    Ok(Grid::new(counts.map(|count| count as u64), Frame { index_to_world, unit, space })?)
}

#[cfg(test)]
mod tests {
    use super::{AroundError, grid_around};
    use isokit_geom::{Aabb, Space, Unit};

    #[test]
    fn a_lattice_reaches_beyond_the_box_by_its_margin() {
        let bounds = Aabb { min: [0.0, 1.0, -2.0], max: [1.0, 1.0, 2.5] };
        let grid = grid_around(bounds, [0.5; 3], 2, Unit::Millimetre, Space::Ras).unwrap();
        assert_eq!(grid.dims(), [7, 5, 14]);
        assert_eq!(grid.bounds().min, [-1.0, 0.0, -3.0]);
        assert_eq!(grid.bounds().max, [2.0, 2.0, 3.5]);
        assert_eq!((grid.frame.unit, grid.frame.space), (Unit::Millimetre, Space::Ras));
    }

    #[test]
    fn what_is_no_lattice_is_refused() {
        let bounds = Aabb { min: [0.0; 3], max: [1.0; 3] };
        let of = |spacing| grid_around(bounds, spacing, 2, Unit::Unknown, Space::Unknown);
        assert!(matches!(of([0.0, 1.0, 1.0]), Err(AroundError::Spacing(_))));
        assert!(matches!(of([f64::NAN, 1.0, 1.0]), Err(AroundError::Spacing(_))));
        assert!(matches!(of([1e-12, 1.0, 1.0]), Err(AroundError::TooMany(_))));
    }
}
