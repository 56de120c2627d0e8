//! Which axis points up.
//!
//! In memory z does. In glTF (by its specification) and in OBJ (by custom: Blender's default) y does. The
//! map between them is a rotation, so triangles keep their winding. It is written here and nowhere else.

use std::ops::Neg;

/// The map in words, for headers.
pub(super) const Y_UP: &str = "y up: (x, z, -y) of the source, whose z is up";

/// From z up to y up.
pub(super) fn y_up<T: Neg<Output = T>>([x, y, z]: [T; 3]) -> [T; 3] {
    [x, z, -y]
}

/// From y up to z up.
pub(super) fn z_up<T: Neg<Output = T>>([x, y, z]: [T; 3]) -> [T; 3] {
    [x, -z, y]
}

#[cfg(test)]
mod tests {
    use super::{y_up, z_up};

    #[test]
    fn up_stays_up_and_there_and_back_is_where_it_was() {
        assert_eq!(y_up([0.0, 0.0, 1.0]), [0.0, 1.0, 0.0]);
        assert_eq!(z_up(y_up([1, 2, 3])), [1, 2, 3]);
    }

    #[test]
    fn right_stays_right() {
        let [x, y, z] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(y_up);
        let cross =
            [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
        assert_eq!(cross, z, "a rotation, not a reflection");
    }
}
