//! Sizes and place of a lattice.

use isokit_geom::{Aabb, Frame};

/// How many samples there are along x, y, z, and where they are.
///
/// # Guarantees
///
/// No size is 0, and the number of samples fits a `u64`. It may exceed what memory holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    dims: [u64; 3],
    /// Index space to world space.
    pub frame: Frame,
}

/// Sizes that are no lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("sizes {} x {} x {} are no lattice: {}", dims[0], dims[1], dims[2],
    if dims.contains(&0) { "a size is 0" } else { "more samples than 64 bits can count" })]
pub struct GridError {
    /// The sizes along x, y, z.
    pub dims: [u64; 3],
}

impl Grid {
    /// A lattice of `dims` samples along x, y, z.
    ///
    /// # Errors
    ///
    /// If a size is 0 or the product overflows.
    pub fn new(dims: [u64; 3], frame: Frame) -> Result<Self, GridError> {
        let count = dims.iter().try_fold(1_u64, |count, &n| count.checked_mul(n));
        match count {
            Some(count) if count > 0 => Ok(Self { dims, frame }),
            _ => Err(GridError { dims }),
        }
    }

    /// Samples along x, y, z.
    pub fn dims(&self) -> [u64; 3] {
        self.dims
    }

    /// All samples.
    pub fn count(&self) -> u64 {
        self.dims.iter().product()
    }

    /// Samples in one slice.
    pub fn slice_count(&self) -> u64 {
        self.dims[0] * self.dims[1]
    }

    /// The box, in world space, that reaches from the first sample to the last.
    pub fn bounds(&self) -> Aabb {
        let last = self.dims.map(|n| (n - 1) as f64);
        let corners = Aabb { min: [0.0; 3], max: last }.corners();
        let world = corners.map(|ijk| self.frame.index_to_world.point(ijk));
        world.into_iter().fold(Aabb { min: world[0], max: world[0] }, Aabb::with)
    }
}

#[cfg(test)]
mod tests {
    use super::{Grid, GridError};
    use isokit_geom::Frame;

    #[test]
    fn sizes_are_checked_before_they_are_multiplied() {
        let grid = |dims| Grid::new(dims, Frame::default());
        assert_eq!(grid([3, 0, 4]), Err(GridError { dims: [3, 0, 4] }));
        assert_eq!(grid([1 << 40, 1 << 40, 1]), Err(GridError { dims: [1 << 40, 1 << 40, 1] }));
        assert_eq!(grid([1 << 31, 1 << 32, 1]).unwrap().count(), 1 << 63);
    }

    #[test]
    fn bounds_reach_from_the_first_sample_to_the_last() {
        let grid = Grid::new([3, 4, 5], Frame::default()).unwrap();
        assert_eq!((grid.bounds().min, grid.bounds().max), ([0.0; 3], [2.0, 3.0, 4.0]));
    }
}
