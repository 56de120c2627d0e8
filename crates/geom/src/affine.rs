//! The map from index space to world space.

use glam::{DMat3, DVec3};

/// An invertible affine map, in f64: `world = matrix · index + origin`.
///
/// Never assumed diagonal: it may rotate, shear (a tilted gantry) and reflect.
///
/// # Guarantees
///
/// All entries are finite and the map is invertible: its columns, scaled to length 1, span a volume
/// above 10⁻⁹. A distance or a normal may therefore be divided by what the map does to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    matrix: DMat3,
    origin: DVec3,
}

/// Why sixteen numbers are no map from samples to the world.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AffineError {
    /// An entry is NaN or infinite.
    #[error("row {row}, column {column} is {value}")]
    NotFinite {
        /// Counted from 0.
        row: usize,
        /// Counted from 0.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// One axis of samples has no length.
    #[error("axis {axis} has length {length}")]
    NoLength {
        /// 0, 1 or 2 for x, y, z.
        axis: usize,
        /// What was found instead of a usable length.
        length: f64,
    },
    /// The three axes of samples lie in a plane.
    #[error("the three axes lie in one plane (their unit vectors span {volume:e})")]
    Flat {
        /// The volume that unit vectors along the axes span.
        volume: f64,
    },
}

impl Affine {
    /// Index space itself.
    pub const IDENTITY: Self = Self { matrix: DMat3::IDENTITY, origin: DVec3::ZERO };

    /// The map whose `columns` say where one step along x, y, z of index space leads, and whose
    /// `origin` is the place of the first sample.
    ///
    /// # Errors
    ///
    /// If the map has an entry that is not finite or is not invertible.
    pub fn new(columns: [[f64; 3]; 3], origin: [f64; 3]) -> Result<Self, AffineError> {
        for (column, entries) in columns.iter().chain([&origin]).enumerate() {
            if let Some(row) = entries.iter().position(|entry| !entry.is_finite()) {
                return Err(AffineError::NotFinite { row, column, value: entries[row] });
            }
        }
        let affine =
            Self { matrix: DMat3::from_cols_array_2d(&columns), origin: DVec3::from(origin) };
        let spacing = affine.spacing();
        // Below this a length, or a volume of lengths, may no longer be squared and inverted.
        if let Some(axis) = spacing.iter().position(|h| !(1e-75..1e75).contains(h)) {
            return Err(AffineError::NoLength { axis, length: spacing[axis] });
        }
        let [x, y, z]: [DVec3; 3] =
            std::array::from_fn(|axis| affine.matrix.col(axis) / spacing[axis]);
        let volume = x.cross(y).dot(z).abs();
        if volume > 1e-9 { Ok(affine) } else { Err(AffineError::Flat { volume }) }
    }

    /// A grid along the world's axes.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new). A negative spacing reflects, and is allowed.
    pub fn axis_aligned(spacing: [f64; 3], origin: [f64; 3]) -> Result<Self, AffineError> {
        let column =
            |axis: usize| std::array::from_fn(|k| if k == axis { spacing[k] } else { 0.0 });
        Self::new([column(0), column(1), column(2)], origin)
    }

    /// The map as three rows of four, the origin in the last column.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new).
    pub fn from_rows(rows: [[f64; 4]; 3]) -> Result<Self, AffineError> {
        let column = |c: usize| rows.map(|row| row[c]);
        Self::new([column(0), column(1), column(2)], column(3))
    }

    /// The map as a 4×4 matrix, row by row; the last row is 0, 0, 0, 1.
    pub fn rows(&self) -> [[f64; 4]; 4] {
        let [x, y, z] = self.columns();
        let origin = self.origin();
        let row = |k: usize| [x[k], y[k], z[k], origin[k]];
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    }

    /// Where one step along x, y, z of index space leads.
    pub fn columns(&self) -> [[f64; 3]; 3] {
        self.matrix.to_cols_array_2d()
    }

    /// The place of the first sample.
    pub fn origin(&self) -> [f64; 3] {
        self.origin.to_array()
    }

    /// The same map with the first sample elsewhere.
    ///
    /// # Errors
    ///
    /// If `origin` is not finite.
    pub fn with_origin(self, origin: [f64; 3]) -> Result<Self, AffineError> {
        Self::new(self.columns(), origin)
    }

    /// The distance between neighbouring samples along x, y, z; always positive.
    pub fn spacing(&self) -> [f64; 3] {
        std::array::from_fn(|axis| self.matrix.col(axis).length())
    }

    /// The image of a point.
    pub fn point(&self, ijk: [f64; 3]) -> [f64; 3] {
        (self.matrix * DVec3::from(ijk) + self.origin).to_array()
    }

    /// The image of a displacement.
    pub fn vector(&self, ijk: [f64; 3]) -> [f64; 3] {
        (self.matrix * DVec3::from(ijk)).to_array()
    }

    /// The matrix, as columns, that takes a gradient in index space to the gradient in world space:
    /// the inverse transpose, since a gradient is a covector.
    pub fn covector_columns(&self) -> [[f64; 3]; 3] {
        self.matrix.inverse().transpose().to_cols_array_2d()
    }

    /// The point of index space whose image is `xyz`.
    pub fn inverse_point(&self, xyz: [f64; 3]) -> [f64; 3] {
        (self.matrix.inverse() * (DVec3::from(xyz) - self.origin)).to_array()
    }

    /// The displacement in index space whose image is `xyz`.
    pub fn inverse_vector(&self, xyz: [f64; 3]) -> [f64; 3] {
        (self.matrix.inverse() * DVec3::from(xyz)).to_array()
    }

    /// The signed volume of a cell. Negative where the map reflects.
    pub fn determinant(&self) -> f64 {
        self.matrix.determinant()
    }

    /// The least factor by which the map stretches any direction: its least singular value. What is
    /// one sample apart in any direction of index space is at least so far apart in the world.
    ///
    /// One-sided Jacobi rotations (Hestenes 1958), which keep the relative accuracy of small values.
    pub fn least_stretch(&self) -> f64 {
        let mut columns: [DVec3; 3] = std::array::from_fn(|axis| self.matrix.col(axis));
        // Converges quadratically; three axes need three to five sweeps, and a further one is harmless.
        for (p, q) in [(0, 1), (0, 2), (1, 2)].into_iter().cycle().take(24) {
            let product = columns[p].dot(columns[q]);
            if product != 0.0 {
                let ratio =
                    (columns[q].length_squared() - columns[p].length_squared()) / (2.0 * product);
                let tangent = ratio.signum() / (ratio.abs() + ratio.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                let (a, b) = (columns[p], columns[q]);
                columns[p] = (a - b * tangent) * cosine;
                columns[q] = (a * tangent + b) * cosine;
            }
        }
        columns.iter().fold(f64::INFINITY, |least, column| least.min(column.length()))
    }

    /// This map after a step in index space: the image of `ijk` becomes the new origin.
    ///
    /// # Errors
    ///
    /// If that image is not finite.
    pub fn starting_at(&self, ijk: [f64; 3]) -> Result<Self, AffineError> {
        self.with_origin(self.point(ijk))
    }

    /// The same map with steps that are so many times as long along x, y, z of index space.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new).
    pub fn scaled_steps(&self, factors: [f64; 3]) -> Result<Self, AffineError> {
        let columns = self.columns();
        let column = |axis: usize| columns[axis].map(|entry| entry * factors[axis]);
        Self::new(std::array::from_fn(column), self.origin())
    }

    /// The same map into a world whose axes are stretched (or, below 0, reflected) by `factors`.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new).
    pub fn scaled_world(&self, factors: [f64; 3]) -> Result<Self, AffineError> {
        let scale = |v: [f64; 3]| std::array::from_fn(|axis| v[axis] * factors[axis]);
        Self::new(self.columns().map(scale), scale(self.origin()))
    }
}

#[cfg(test)]
mod tests {
    use super::{Affine, AffineError};

    fn oblique() -> Affine {
        let columns = [[0.5, 0.1, 0.0], [-0.2, 0.7, 0.05], [0.3, 0.0, -2.0]];
        Affine::new(columns, [10.0, -20.0, 30.0]).unwrap()
    }

    #[test]
    fn longer_steps_lead_to_where_as_many_short_ones_do() {
        let (affine, factors) = (oblique(), [2.0, 1.0, -4.0]);
        let long = affine.scaled_steps(factors).unwrap();
        let [a, b] = [long.point([1.0, 2.0, 3.0]), affine.point([2.0, 2.0, -12.0])];
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?}, {b:?}");
        let far = Affine::axis_aligned([9e74, 1.0, 1.0], [0.0; 3]).unwrap();
        assert!(far.scaled_steps([2.0, 1.0, 1.0]).is_err());
    }

    #[test]
    fn inverse_undoes_it() {
        let ijk = [3.0, 4.5, -2.0];
        let back = oblique().inverse_point(oblique().point(ijk));
        assert!(ijk.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-12), "{back:?}");
        let back = oblique().inverse_vector(oblique().vector(ijk));
        assert!(ijk.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-12), "{back:?}");
    }

    #[test]
    fn rows_and_columns_are_the_same_map() {
        let rows = oblique().rows();
        assert_eq!(Affine::from_rows([rows[0], rows[1], rows[2]]), Ok(oblique()));
        assert_eq!(rows[1], [0.1, 0.7, 0.0, -20.0]);
    }

    #[test]
    fn covectors_keep_their_product_with_vectors() {
        let (v, g) = ([1.0, -2.0, 0.5], [0.3, 0.4, -0.9]);
        let columns = oblique().covector_columns();
        let image: [f64; 3] =
            std::array::from_fn(|k| (0..3).map(|axis| columns[axis][k] * g[axis]).sum());
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        assert!((dot(oblique().vector(v), image) - dot(v, g)).abs() < 1e-12);
    }

    #[test]
    fn least_stretch_is_the_least_over_all_directions() {
        let shear = Affine::new([[1.0, 0.0, 0.0], [3.0, 0.5, 0.0], [0.2, -4.0, 2.0]], [0.0; 3]);
        for affine in [oblique(), shear.unwrap()] {
            let mut least = f64::INFINITY;
            for (a, b) in (0..600).flat_map(|a| (0..300).map(move |b| (a, b))) {
                let (a, b) = (f64::from(a) * 0.010_5, f64::from(b) * 0.010_5);
                let v = affine.vector([a.cos() * b.sin(), a.sin() * b.sin(), b.cos()]);
                least = least.min(v.iter().map(|c| c * c).sum::<f64>().sqrt());
            }
            let found = affine.least_stretch();
            assert!(found <= least && least < found * 1.05, "{found} against {least}");
        }
        let thin = Affine::axis_aligned([1e-12, 1.0, 1e6], [0.0; 3]).unwrap();
        assert_eq!(thin.least_stretch(), 1e-12);
    }

    #[test]
    fn what_cannot_be_inverted_is_refused() {
        let nan = Affine::axis_aligned([1.0, f64::NAN, 1.0], [0.0; 3]);
        assert!(matches!(nan, Err(AffineError::NotFinite { row: 1, column: 1, .. })));
        let flat = Affine::new([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]);
        assert!(matches!(flat, Err(AffineError::Flat { .. })));
        let zero = Affine::axis_aligned([1.0, 1.0, 0.0], [0.0; 3]);
        assert!(matches!(zero, Err(AffineError::NoLength { axis: 2, .. })));
        assert!(Affine::axis_aligned([1e-12, 1.0, -1e6], [0.0; 3]).is_ok());
    }
}
