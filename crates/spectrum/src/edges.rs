//! The edges between neighbouring samples, and what each adds to the surfaces that cross it.
//!
//! A surface crosses the edges along axis k as often as its projection along k has room for them: `|n·cₖ| / V` times for
//! each unit of area, with n the unit normal, c the steps of the lattice and V the volume of a cell. With `n = Σ (n·cₖ) cᵏ`,
//! where cᵏ are the covectors of the steps, a crossing that counts for `V |cᵏ·n|`, with the sign of what it adds,
//! makes all of them together the area (Cauchy's and Crofton's formulas, with the direction known); and with
//! `V |cᵏ·∇f|` the total gradient.

use isokit_geom::{Affine, vector::dot};

/// How a lattice lies in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Metric {
    /// The volume of a cell.
    pub(crate) cell: f64,
    /// The products of the steps' covectors.
    products: [[f64; 3]; 3],
}

/// What one crossing of an edge adds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    pub(crate) area: f64,
    pub(crate) flux: f64,
}

impl Metric {
    pub(crate) fn of(affine: &Affine) -> Self {
        let columns = affine.covector_columns();
        let cell = affine.determinant().abs();
        Self { cell, products: columns.map(|a| columns.map(|b| dot(a, b))) }
    }

    /// The squares of the steps' covectors, if those are at right angles but for rounding.
    pub(crate) fn squares(&self) -> Option<[f64; 3]> {
        let squares: [f64; 3] = std::array::from_fn(|k| self.products[k][k]);
        let is_right = |a: usize, b: usize| {
            self.products[a][b].abs() <= 1e-9 * (squares[a] * squares[b]).sqrt()
        };
        (is_right(0, 1) && is_right(0, 2) && is_right(1, 2)).then_some(squares)
    }

    /// What an edge along `axis` adds, of which the gradient in index space is known: along the edge that is the
    /// difference between its ends. None where that is nothing, or beyond all numbers.
    #[inline]
    pub(crate) fn crossing(&self, axis: usize, gradient: [f64; 3]) -> Option<Crossing> {
        let along = self.products.map(|row| dot(row, gradient));
        let square = dot(gradient, along);
        let flux = self.cell * along[axis] * gradient[axis].signum();
        let area = flux / square.sqrt();
        (area.is_finite() && flux.is_finite()).then_some(Crossing { area, flux })
    }
}

#[cfg(test)]
mod tests {
    use super::{Crossing, Metric};
    use isokit_geom::Affine;

    #[test]
    fn a_plane_across_an_axis_counts_for_the_area_between_edges() {
        let affine = Affine::axis_aligned([0.5, 2.0, 3.0], [0.0; 3]).unwrap();
        let metric = Metric::of(&affine);
        let crossing = metric.crossing(1, [0.0, -8.0, 0.0]);
        assert_eq!(crossing, Some(Crossing { area: 1.5, flux: 6.0 }), "4 per unit on 0.5 by 3");
        assert_eq!(metric.crossing(0, [0.0; 3]), None);
        assert_eq!(metric.crossing(0, [f64::MAX; 3]), None);
    }

    #[test]
    fn crossings_of_all_axes_make_the_area_in_lattices_of_any_shape() {
        for columns in [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [[0.5, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, -3.0]],
            [[1.0, 0.2, 0.0], [-0.3, 1.5, 0.1], [0.2, 0.4, 0.8]],
        ] {
            let affine = Affine::new(columns, [0.0; 3]).unwrap();
            let metric = Metric::of(&affine);
            let normal = [2.0 / 7.0, -3.0 / 7.0, 6.0 / 7.0];
            // A field that rises by 5 per unit along the normal, in index space.
            let along = |step: [f64; 3]| (0..3).map(|k| normal[k] * step[k]).sum::<f64>();
            let gradient = columns.map(|step| 5.0 * along(step));
            let (mut area, mut flux) = (0.0, 0.0);
            for (axis, step) in columns.into_iter().enumerate() {
                let crossings = along(step).abs() / affine.determinant().abs();
                let one = metric.crossing(axis, gradient).unwrap();
                (area, flux) = (area + crossings * one.area, flux + crossings * one.flux);
            }
            assert!((area - 1.0).abs() < 1e-12 && (flux - 5.0).abs() < 1e-12, "{area}, {flux}");
        }
    }
}
