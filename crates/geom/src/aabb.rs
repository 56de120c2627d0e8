//! Axis-aligned boxes.

/// The least box around some points; with no points, none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Least coordinate on each axis.
    pub min: [f64; 3],
    /// Greatest coordinate on each axis.
    pub max: [f64; 3],
}

impl Aabb {
    /// The box around `points`, or `None` if there are none. A NaN coordinate is passed over.
    pub fn around(points: impl IntoIterator<Item = [f64; 3]>) -> Option<Self> {
        let mut points = points.into_iter();
        let first = points.next()?;
        Some(points.fold(Self { min: first, max: first }, Self::with))
    }

    /// The least box that holds this one and `point`.
    pub fn with(self, point: [f64; 3]) -> Self {
        Self {
            min: std::array::from_fn(|axis| self.min[axis].min(point[axis])),
            max: std::array::from_fn(|axis| self.max[axis].max(point[axis])),
        }
    }

    /// The eight corners, numbered as [`crate::cube`] numbers them.
    pub fn corners(self) -> [[f64; 3]; 8] {
        let side = |k: usize, axis: usize| if k >> axis & 1 == 1 { self.max } else { self.min };
        std::array::from_fn(|k| std::array::from_fn(|axis| side(k, axis)[axis]))
    }

    /// The greatest absolute coordinate of any point of the box.
    pub fn reach(self) -> f64 {
        self.min.iter().chain(&self.max).fold(0.0, |reach, c| reach.max(c.abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::Aabb;

    #[test]
    fn holds_all_points_and_touches_the_outermost() {
        let found = Aabb::around([[1.0, 5.0, -2.0], [3.0, -4.0, 0.0], [2.0, 0.0, 7.0]]).unwrap();
        assert_eq!(found, Aabb { min: [1.0, -4.0, -2.0], max: [3.0, 5.0, 7.0] });
        assert_eq!(found.reach(), 7.0);
        assert_eq!(Aabb::around([]), None);
    }

    #[test]
    fn corners_are_numbered_by_the_bits_of_x_y_z() {
        let corners = Aabb { min: [0.0; 3], max: [1.0, 2.0, 4.0] }.corners();
        assert_eq!(corners[5], [1.0, 0.0, 4.0]);
    }
}
