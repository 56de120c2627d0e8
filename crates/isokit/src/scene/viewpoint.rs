//! From where a picture is taken.

use isokit_geom::{
    Aabb, Space,
    vector::{Vector, cross, dot, sub, unit},
};
use isokit_render::{Camera, CameraError, Projection, Side, Size};

/// From where something is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Viewpoint {
    /// From a side, with all of it in the picture: what planes leave of surfaces that are drawn as meshes, and the whole
    /// box of what rays go through.
    Framed {
        /// The side; in a world whose axes nobody knows, as if x pointed right, y forward and z up.
        side: Side,
        /// Degrees around the direction up: seen from above, counter-clockwise.
        orbit: f64,
        /// The angle of a perspective in degrees; without one the projection is parallel.
        fov: Option<f64>,
        /// Whether it is one of several pictures around it: all of them have the same scale, at which all is in each.
        turns: bool,
    },
    /// From a place.
    At {
        /// The place.
        from: Vector,
        /// What is in the middle of the picture: without it the middle of the box.
        at: Option<Vector>,
        /// What is up.
        up: Vector,
        /// Degrees by which the place goes around what is in the middle, about the direction up: seen from above,
        /// counter-clockwise.
        orbit: f64,
        /// What the picture shows.
        projection: Projection,
    },
}

impl Viewpoint {
    /// That of a camera, whatever is seen.
    pub fn of(camera: &Camera) -> Self {
        let (from, forward, far) = (camera.from(), camera.forward(), camera.distance());
        let at = Some(std::array::from_fn(|k| from[k] + far * forward[k]));
        Self::At { from, at, up: camera.up(), orbit: 0.0, projection: camera.projection() }
    }

    /// The camera, for a box in a world with such axes.
    ///
    /// # Errors
    ///
    /// As [`Camera::new`] and [`Camera::framing`].
    pub fn camera(
        &self,
        (bounds, space): (Aabb, Space),
        size: Size,
    ) -> Result<Camera, CameraError> {
        match *self {
            Self::Framed { side, orbit, fov, turns } => {
                let aspect = f64::from(size.width.get()) / f64::from(size.height.get());
                let (forward, up) = side.directions(space);
                // Framed from where it ends up, so that all is in the picture.
                let (sine, cosine) = orbit.to_radians().sin_cos();
                let aside = cross(up, forward);
                let forward = std::array::from_fn(|k| forward[k] * cosine + aside[k] * sine);
                match turns {
                    false => Camera::framing(bounds, (forward, up), fov, aspect),
                    true => Camera::framing_turns(bounds, (forward, up), fov, aspect),
                }
            }
            Self::At { from, at, up, orbit, projection } => {
                let middle = |k: usize| bounds.min[k].midpoint(bounds.max[k]);
                let at = at.unwrap_or_else(|| std::array::from_fn(middle));
                let from = match unit(up).filter(|_| orbit != 0.0) {
                    Some(axis) => around(from, (at, axis), orbit),
                    None => from,
                };
                Camera::new(from, at, up, projection)
            }
        }
    }
}

/// A place after so many degrees about an axis of length 1 through another one (Rodrigues 1840).
fn around(place: Vector, (middle, axis): (Vector, Vector), degrees: f64) -> Vector {
    let away = sub(place, middle);
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let (aside, along) = (cross(axis, away), dot(axis, away) * (1.0 - cosine));
    std::array::from_fn(|k| middle[k] + away[k] * cosine + aside[k] * sine + axis[k] * along)
}

#[cfg(test)]
mod tests {
    use super::Viewpoint;
    use isokit_geom::{Aabb, Space};
    use isokit_render::{Projection, Size};
    use std::num::NonZeroU32;

    #[test]
    fn a_place_goes_around_what_is_in_the_middle_at_one_height_and_distance() {
        let n = NonZeroU32::new(10).unwrap();
        let (bounds, size) =
            (Aabb { min: [0.0; 3], max: [4.0, 6.0, 8.0] }, Size { width: n, height: n });
        let from = |at, up, orbit| {
            let projection = Projection::Parallel { height: 1.0 };
            let viewpoint = Viewpoint::At { from: [12.0, 3.0, 9.0], at, up, orbit, projection };
            viewpoint.camera((bounds, Space::Unknown), size).unwrap().from()
        };
        let up = [0.0, 0.0, 2.0];
        // Around the middle of the box, (2, 3, 4), and from above counter-clockwise: from x to y.
        for (orbit, expected) in
            [(0.0, [12.0, 3.0, 9.0]), (90.0, [2.0, 13.0, 9.0]), (-180.0, [-8.0, 3.0, 9.0])]
        {
            let found = from(None, up, orbit);
            assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-12), "{orbit}: {found:?}");
        }
        let found = from(Some([12.0, 0.0, 0.0]), [1.0, 0.0, 0.0], 90.0);
        assert!((0..3).all(|k| (found[k] - [12.0, -9.0, 3.0][k]).abs() < 1e-12), "{found:?}");
    }
}
