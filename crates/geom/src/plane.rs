//! Planes, and the half of space that one keeps.

use crate::vector::{Vector, dot};

/// The places on one side of a plane: those where `normal · place <= offset`, the plane with them.
///
/// # Guarantees
///
/// All numbers are finite, and the greatest part of the normal is about 1 to 2: what was given is scaled by a power of
/// two, which changes no digit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    normal: Vector,
    offset: f64,
}

/// Why four numbers are no half of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a plane has a direction other than 0, and finite numbers")]
pub struct PlaneError;

impl HalfSpace {
    /// The places where `normal · place <= offset`.
    ///
    /// # Errors
    ///
    /// If a number is not finite, or the normal is 0; or if the plane is farther away than numbers reach.
    pub fn new(normal: Vector, offset: f64) -> Result<Self, PlaneError> {
        let greatest = normal.iter().fold(0.0, |most: f64, part| most.max(part.abs()));
        // Twice, since half of the way there may be no power of two that is a number.
        let power = -greatest.log2().floor() as i32;
        let (half, rest) = (power / 2, power - power / 2);
        let scaled = |number: f64| number * 2.0_f64.powi(half) * 2.0_f64.powi(rest);
        let (normal, offset) = (normal.map(scaled), scaled(offset));
        let are_finite = normal.iter().chain([&offset]).all(|number| number.is_finite());
        match are_finite && normal != [0.0; 3] {
            true => Ok(Self { normal, offset }),
            false => Err(PlaneError),
        }
    }

    /// What points out of the half that is kept.
    pub fn normal(&self) -> Vector {
        self.normal
    }

    /// `normal · place` of the places on the plane.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// How far a place is beyond the plane, in lengths of the normal: 0 or less where it is kept.
    #[inline]
    pub fn beyond(&self, place: Vector) -> f64 {
        dot(self.normal, place) - self.offset
    }

    /// Whether a place is kept. One that is no number is not.
    #[inline]
    pub fn keeps(&self, place: Vector) -> bool {
        self.beyond(place) <= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::{HalfSpace, PlaneError};

    #[test]
    fn the_plane_itself_is_kept_and_what_is_no_number_is_not() {
        let half = HalfSpace::new([2.0, 0.0, 0.0], 6.0).unwrap();
        assert!(half.keeps([3.0, 1e9, -1e9]) && half.keeps([-1e300, 0.0, 0.0]));
        assert!(!half.keeps([3.0_f64.next_up(), 0.0, 0.0]) && !half.keeps([f64::NAN, 0.0, 0.0]));
        assert_eq!(half.beyond([4.0, 7.0, 7.0]), 1.0);
    }

    #[test]
    fn planes_of_any_size_of_numbers_are_the_same_plane() {
        let plain = HalfSpace::new([1.5, -0.25, 0.0], 3.0).unwrap();
        for power in [-1000, -3, 0, 5, 1000] {
            let scale = 2.0_f64.powi(power);
            let (normal, offset) = ([1.5 * scale, -0.25 * scale, 0.0], 3.0 * scale);
            assert_eq!(HalfSpace::new(normal, offset), Ok(plain), "{power}");
        }
        assert_eq!(HalfSpace::new([1e-300, 0.0, 0.0], 1e300), Err(PlaneError));
    }

    #[test]
    fn numbers_that_make_no_plane_are_refused() {
        for (normal, offset) in
            [([0.0; 3], 1.0), ([f64::INFINITY, 0.0, 0.0], 1.0), ([1.0; 3], f64::NAN)]
        {
            assert_eq!(HalfSpace::new(normal, offset), Err(PlaneError));
        }
    }
}
