//! The edges between neighbouring samples, and what each adds to the surfaces that cross it.
//!
//! A surface crosses the edges along axis k as often as its projection along k has room for them: `|n·cₖ| / V` times for
//! each unit of area, with n the unit normal, c the steps of the lattice and V the volume of a cell. With `n = Σ (n·cₖ) cᵏ`,
//! where cᵏ are the covectors of the steps, a crossing that counts for `V |cᵏ·n|`, with the sign of what it adds,
//! makes all of them together the area (Cauchy's and Crofton's formulas, with the direction known); and with
//! `V |cᵏ·∇f|` the total gradient.
//!
//! The normal of an edge is the mean of those at its ends, which are those of central differences. As it is of unit
//! length, the area is wrong only by the square of the angle by which it is. Where it points against the rise along its
//! edge, it takes from the area: noise less than a sample wide does not add to it. A sheet one sample thin loses about
//! half of its area that way, and noise alone more.

use isokit_geom::{Affine, vector::dot};

/// How a lattice lies in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Metric {
    /// The volume of a cell.
    pub(crate) cell: f64,
    /// The products of the steps' covectors.
    products: [[f64; 3]; 3],
}

impl Metric {
    pub(crate) fn of(affine: &Affine) -> Self {
        let columns = affine.covector_columns();
        let cell = affine.determinant().abs();
        Self { cell, products: columns.map(|a| columns.map(|b| dot(a, b))) }
    }

    /// The squares of the steps' covectors, if they are at right angles but for rounding.
    pub(crate) fn squares(&self) -> Option<[f64; 3]> {
        let squares: [f64; 3] = std::array::from_fn(|k| self.products[k][k]);
        let is_right = |a: usize, b: usize| {
            self.products[a][b].abs() <= 1e-9 * (squares[a] * squares[b]).sqrt()
        };
        (is_right(0, 1) && is_right(0, 2) && is_right(1, 2)).then_some(squares)
    }

    /// What an edge along each axis counts for in the area of a surface with that gradient in index space, with the sign
    /// of the gradient along it. 0 where there is no gradient, or one beyond all numbers.
    #[inline]
    pub(crate) fn normal(&self, gradient: [f64; 3]) -> [f64; 3] {
        let along = self.products.map(|row| dot(row, gradient));
        let unit = self.cell / dot(gradient, along).sqrt();
        match unit.is_finite() {
            true => along.map(|along| along * unit),
            false => [0.0; 3],
        }
    }

    /// What an edge along `axis` adds to the total gradient, of which the gradient in index space is known: along the edge
    /// that is the difference between its ends. None where that is beyond all numbers.
    #[inline]
    pub(crate) fn flux(&self, axis: usize, gradient: [f64; 3]) -> Option<f64> {
        let flux = self.cell * dot(self.products[axis], gradient) * gradient[axis].signum();
        flux.is_finite().then_some(flux)
    }
}

#[cfg(test)]
mod tests {
    use super::Metric;
    use isokit_geom::Affine;

    #[test]
    fn a_plane_across_an_axis_counts_for_the_area_between_edges() {
        let affine = Affine::axis_aligned([0.5, 2.0, 3.0], [0.0; 3]).unwrap();
        let metric = Metric::of(&affine);
        let gradient = [0.0, -8.0, 0.0];
        assert_eq!(metric.normal(gradient), [0.0, -1.5, 0.0], "0.5 by 3");
        assert_eq!(metric.flux(1, gradient), Some(6.0), "4 per unit on that");
        assert_eq!(metric.normal([0.0; 3]), [0.0; 3]);
        assert_eq!(metric.normal([f64::MAX; 3]), [0.0; 3]);
        assert_eq!(metric.flux(0, [f64::MAX; 3]), None);
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
                area += crossings * metric.normal(gradient)[axis].abs();
                flux += crossings * metric.flux(axis, gradient).unwrap();
            }
            assert!((area - 1.0).abs() < 1e-12 && (flux - 5.0).abs() < 1e-12, "{area}, {flux}");
        }
    }
}
