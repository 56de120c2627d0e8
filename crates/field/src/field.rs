//! What a function of space can be asked.

use crate::Interval;
use isokit_geom::{Aabb, Affine};
use std::ops::Range;

/// Value and gradient at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// The value.
    pub value: f64,
    /// How fast it changes along x, y, z of index space, per sample.
    pub gradient: [f64; 3],
}

/// Value, gradient and second derivatives at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// The value.
    pub value: f64,
    /// The first derivatives along x, y, z of index space, per sample.
    pub gradient: [f64; 3],
    /// The second derivatives, row by row; symmetric.
    pub hessian: [[f64; 3]; 3],
}

impl Jet {
    /// The second derivative along a displacement `e` in index space: eᵀ H e. The same number in world space,
    /// for the same displacement there.
    pub fn bend(&self, e: [f64; 3]) -> f64 {
        let row = |k: usize| {
            let h = self.hessian[k];
            h[0] * e[0] + h[1] * e[1] + h[2] * e[2]
        };
        e[0] * row(0) + e[1] * row(1) + e[2] * row(2)
    }
}

/// A function of index space that is smooth but for the faces of cells.
///
/// Where there is nothing to make a value of, it is NaN, and so are the derivatives. Nothing panics,
/// whatever the point.
pub trait ScalarField: Sync {
    /// Samples along x, y, z. The field is known from 0 to one less than these; a little farther out it goes
    /// on as it is at the border.
    fn dims(&self) -> [usize; 3];

    /// Where index space lies in the world.
    fn index_to_world(&self) -> Affine;

    /// The value at a point.
    fn value(&self, ijk: [f64; 3]) -> f64;

    /// Whether there is a value at a point.
    fn is_known(&self, ijk: [f64; 3]) -> bool {
        self.value(ijk).is_finite()
    }

    /// The value and its gradient.
    fn slope(&self, ijk: [f64; 3]) -> Slope;

    /// The value, its gradient and its Hessian.
    fn jet(&self, ijk: [f64; 3]) -> Jet;

    /// No value in a box of index space is outside of these bounds, which may be wider than need be. Where a value may be
    /// NaN, nothing is known, as by default: [`Interval::EVERYTHING`].
    fn bounds(&self, _ijk: Aabb) -> Interval {
        Interval::EVERYTHING
    }

    /// The same field for whoever asks within a box of index space only, where that is cheaper to ask: all answers there are
    /// the same, to the bit. Default: there is none that is cheaper.
    fn within(&self, _ijk: Aabb) -> Option<Box<dyn ScalarField + '_>> {
        None
    }

    /// The values at the lattice points of a box, x fastest: to the bit what [`value`](Self::value) says of each.
    ///
    /// # Panics
    ///
    /// If `values` has another length than there are points.
    fn fill(&self, points: [Range<usize>; 3], values: &mut [f64]) {
        let [x, y, z] = points;
        assert_eq!(values.len(), x.len() * y.len() * z.len(), "one value for each point");
        let rows = z.flat_map(|k| y.clone().map(move |j| [j, k]));
        for (row, [j, k]) in values.chunks_exact_mut(x.len().max(1)).zip(rows) {
            for (value, i) in row.iter_mut().zip(x.clone()) {
                *value = self.value([i, j, k].map(|c| c as f64));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Jet, ScalarField, Slope};
    use isokit_geom::{Aabb, Affine};

    /// A field that says no more than it must.
    struct Plain;

    impl ScalarField for Plain {
        fn dims(&self) -> [usize; 3] {
            [5, 4, 3]
        }

        fn index_to_world(&self) -> Affine {
            Affine::IDENTITY
        }

        fn value(&self, [x, y, z]: [f64; 3]) -> f64 {
            x + 10.0 * y + 100.0 * z
        }

        fn slope(&self, ijk: [f64; 3]) -> Slope {
            Slope { value: self.value(ijk), gradient: [1.0, 10.0, 100.0] }
        }

        fn jet(&self, ijk: [f64; 3]) -> Jet {
            let Slope { value, gradient } = self.slope(ijk);
            Jet { value, gradient, hessian: [[0.0; 3]; 3] }
        }
    }

    #[test]
    fn a_field_that_knows_no_better_is_asked_point_by_point_and_has_any_value() {
        let field = Plain;
        let all = Aabb { min: [0.0; 3], max: [4.0, 3.0, 2.0] };
        assert!(field.bounds(all).contains(f64::MAX) && field.within(all).is_none());
        let mut values = [f64::NAN; 2 * 3 * 2];
        field.fill([1..3, 1..4, 0..2], &mut values);
        let own = |n: usize| [1 + n % 2, 1 + n / 2 % 3, n / 6].map(|c| c as f64);
        let expected: Vec<f64> = (0..12).map(|n| field.value(own(n))).collect();
        assert_eq!(values[..], expected);
        field.fill([2..2, 0..4, 0..3], &mut []);
    }
}
