//! From where a picture is taken.

use isokit_geom::{
    Aabb, Space,
    vector::{Vector, cross},
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
        /// What the picture shows.
        projection: Projection,
    },
}

impl Viewpoint {
    /// That of a camera, whatever is seen.
    pub fn of(camera: &Camera) -> Self {
        let (from, forward, far) = (camera.from(), camera.forward(), camera.distance());
        let at = Some(std::array::from_fn(|k| from[k] + far * forward[k]));
        Self::At { from, at, up: camera.up(), projection: camera.projection() }
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
            Self::At { from, at, up, projection } => {
                let middle = |k: usize| bounds.min[k].midpoint(bounds.max[k]);
                let at = at.unwrap_or_else(|| std::array::from_fn(middle));
                Camera::new(from, at, up, projection)
            }
        }
    }
}
