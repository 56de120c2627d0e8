//! Where a picture is taken from, and the ray of each of its points.

use crate::Size;
use isokit_geom::{
    Aabb, HalfSpace, Space,
    vector::{Vector, cross, dot, length, sub},
};

/// How rays lie to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Side by side: nothing is smaller for being far away.
    Parallel {
        /// What the picture shows from bottom to top, in world units.
        height: f64,
    },
    /// All from one point.
    Perspective {
        /// The angle between bottom and top, in degrees, above 0 and below 180.
        fov: f64,
    },
}

/// A place to look from, and what the picture shows from there.
///
/// # Guarantees
///
/// Right, up and forward are unit vectors at right angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    from: Vector,
    right: Vector,
    up: Vector,
    forward: Vector,
    /// The distance to what it looks at.
    distance: f64,
    projection: Projection,
    /// Half of what the picture shows from bottom to top: in a perspective, of what is 1 ahead.
    half: f64,
}

/// Why there is no such camera.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CameraError {
    /// A number is not finite.
    #[error("a camera's places and directions are finite numbers")]
    NotFinite,
    /// It looks nowhere.
    #[error("the camera is at the place that it looks at")]
    NoDirection,
    /// No direction of the picture is up.
    #[error("the camera looks along its direction up")]
    NoUp,
    /// A picture of nothing, or of more than what lies before it.
    #[error("a picture shows a height above 0 or an angle above 0 and below 180 degrees")]
    NoExtent,
}

/// A side of a body from which it is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// From the front.
    Anterior,
    /// From behind.
    Posterior,
    /// From the body's left.
    Left,
    /// From the body's right.
    Right,
    /// From above the head.
    Superior,
    /// From below the feet.
    Inferior,
}

/// A line that begins at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it begins.
    pub origin: Vector,
    /// Where it leads: of length 1 in the world.
    pub direction: Vector,
}

/// The share of the picture's height by which a framed box stays away from its edges.
const MARGIN: f64 = 0.03;

impl Camera {
    /// At `from`, looking at `at`, with `up` as nearly up in the picture as that allows.
    ///
    /// # Errors
    ///
    /// If a number is not finite, if the two places are one, if it looks along `up`, or if the projection
    /// shows nothing.
    pub fn new(
        from: Vector,
        at: Vector,
        up: Vector,
        projection: Projection,
    ) -> Result<Self, CameraError> {
        let extent = match projection {
            Projection::Parallel { height } => height,
            Projection::Perspective { fov } => fov,
        };
        if [from, at, up, [extent; 3]].as_flattened().iter().any(|number| !number.is_finite()) {
            return Err(CameraError::NotFinite);
        }
        let is_narrow = !matches!(projection, Projection::Perspective { fov } if fov >= 180.0);
        if !(extent > 0.0 && is_narrow) {
            return Err(CameraError::NoExtent);
        }
        let distance = length(sub(at, from));
        if !distance.is_finite() {
            return Err(CameraError::NotFinite);
        }
        let forward = unit(sub(at, from)).ok_or(CameraError::NoDirection)?;
        let up = unit(up).ok_or(CameraError::NoUp)?;
        let aside = cross(forward, up);
        // Nearer to each other than that, up would be what rounding makes of it.
        if !matches!(length(aside), 1e-6..) {
            return Err(CameraError::NoUp);
        }
        let right = unit(aside).ok_or(CameraError::NoUp)?;
        let half = match projection {
            Projection::Parallel { height } => 0.5 * height,
            Projection::Perspective { fov } => (fov.to_radians() / 2.0).tan(),
        };
        let up = cross(right, forward);
        Ok(Self { from, right, up, forward, distance, projection, half })
    }

    /// A camera that looks at a box along `forward` and shows all of it, in a picture that is `aspect` times
    /// as wide as high. `fov` is the angle of a perspective; without one the projection is parallel.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new); if the box is a point, or in a parallel projection a line that it looks along; or if
    /// `aspect` is not above 0.
    pub fn framing(
        bounds: Aabb,
        directions: (Vector, Vector),
        fov: Option<f64>,
        aspect: f64,
    ) -> Result<Self, CameraError> {
        Self::framed(bounds, directions, (fov, aspect), |[aside, up, ahead], slopes| match slopes {
            None => [aside.abs(), up.abs()],
            Some([across, upright]) => [aside.abs() / across - ahead, up.abs() / upright - ahead],
        })
    }

    /// The same, as far away or as wide as shows all of the box also while it turns around what is up in the picture:
    /// pictures of a way around it are of one scale.
    ///
    /// # Errors
    ///
    /// As [`framing`](Self::framing).
    pub fn framing_turns(
        bounds: Aabb,
        directions: (Vector, Vector),
        fov: Option<f64>,
        aspect: f64,
    ) -> Result<Self, CameraError> {
        Self::framed(bounds, directions, (fov, aspect), |[aside, up, ahead], slopes| {
            let around = length([aside, 0.0, ahead]);
            match slopes {
                None => [around, up.abs()],
                // The most of `|around * cos t| / across - around * sin t` and of what the upper edge asks for.
                Some([across, upright]) => {
                    [around * length([1.0, across.recip(), 0.0]), up.abs() / upright + around]
                }
            }
        })
    }

    /// A camera that shows corners of a box, so far to the right, up and ahead of its middle, as far as they reach: along
    /// the picture's width and height; or, of a perspective that is so much wider and higher with each step ahead, how
    /// far the camera is from the middle.
    fn framed(
        bounds: Aabb,
        (forward, up): (Vector, Vector),
        (fov, aspect): (Option<f64>, f64),
        reach: impl Fn(Vector, Option<[f64; 2]>) -> [f64; 2],
    ) -> Result<Self, CameraError> {
        let middle: Vector = std::array::from_fn(|k| bounds.min[k].midpoint(bounds.max[k]));
        let radius = length(sub(bounds.max, middle));
        if radius == 0.0 || !(aspect > 0.0 && aspect.is_finite()) {
            return Err(CameraError::NoExtent);
        }
        let forward = unit(forward).ok_or(CameraError::NoDirection)?;
        let from = |back: f64| std::array::from_fn(|k| middle[k] - back * forward[k]);
        let projection = match fov {
            Some(fov) => Projection::Perspective { fov },
            None => Projection::Parallel { height: radius },
        };
        let first = Self::new(from(2.0 * radius), middle, up, projection)?;
        let usable = 1.0 - 2.0 * MARGIN;
        let slopes = fov.map(|fov| {
            let slope = (fov.to_radians() / 2.0).tan() * usable;
            [slope * aspect, slope]
        });
        let reaches = bounds.corners().map(|corner| {
            let corner = sub(corner, middle);
            reach([first.right, first.up, forward].map(|axis| dot(corner, axis)), slopes)
        });
        let most = |k: usize| reaches.iter().map(|reach| reach[k]).fold(0.0, f64::max);
        match slopes {
            None => {
                let height = 2.0 * (most(0) / aspect).max(most(1)) / usable;
                Self::new(from(2.0 * radius), middle, up, Projection::Parallel { height })
            }
            Some(_) => Self::new(from(most(0).max(most(1))), middle, up, projection),
        }
    }

    /// Where the camera is.
    pub fn from(&self) -> Vector {
        self.from
    }

    /// How far away the place is that it looks at.
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// Where it looks: of length 1.
    pub fn forward(&self) -> Vector {
        self.forward
    }

    /// What is up in the picture: of length 1.
    pub fn up(&self) -> Vector {
        self.up
    }

    /// How rays lie to each other.
    pub fn projection(&self) -> Projection {
        self.projection
    }

    /// A place as the camera sees it: how far to the right, up, and ahead of the camera it is.
    #[inline]
    pub fn view(&self, place: Vector) -> Vector {
        self.turned(sub(place, self.from))
    }

    /// The parts of a direction to the right, up and ahead.
    #[inline]
    pub fn turned(&self, direction: Vector) -> Vector {
        [self.right, self.up, self.forward].map(|axis| dot(direction, axis))
    }

    /// How far from the middle of the picture, in halves of its height, a place is seen that is 1 aside: in a
    /// perspective, of one that is 1 ahead.
    pub fn magnification(&self) -> f64 {
        1.0 / self.half
    }

    /// To the right, up and ahead: at right angles, and of length 1.
    pub(crate) fn axes(&self) -> [Vector; 3] {
        [self.right, self.up, self.forward]
    }

    /// Half of what the picture shows from bottom to top of what is so far ahead.
    pub(crate) fn half_height(&self, ahead: f64) -> f64 {
        match self.projection {
            Projection::Parallel { .. } => self.half,
            Projection::Perspective { .. } => self.half * ahead,
        }
    }

    /// What a picture shows that is `aspect` times as wide as high: what is in all of these, but for rounding. A side is
    /// left out where numbers end.
    pub fn frustum(&self, aspect: f64) -> Vec<HalfSpace> {
        let is_parallel = matches!(self.projection, Projection::Parallel { .. });
        let sides = [(self.right, self.half * aspect), (self.up, self.half)];
        let sides =
            sides.into_iter().flat_map(|(axis, half)| [(axis, half), (axis.map(|c| -c), half)]);
        let sides = sides.map(|(axis, half)| match is_parallel {
            true => (axis, half),
            false => (std::array::from_fn(|k| axis[k] - half * self.forward[k]), 0.0),
        });
        let ahead = (self.forward.map(|c| -c), 0.0);
        let half_spaces = sides
            .chain([ahead])
            .map(|(normal, beyond)| HalfSpace::new(normal, dot(normal, self.from) + beyond));
        half_spaces.flatten().collect()
    }

    /// The ray of a point of the picture: `x` from −`aspect` at the left edge to `aspect`, `y` from −1 at the
    /// bottom to 1, where `aspect` is the picture's width over its height.
    pub fn ray(&self, [x, y]: [f64; 2]) -> Ray {
        let (right, up) = (self.half * x, self.half * y);
        let aside: Vector = std::array::from_fn(|k| right * self.right[k] + up * self.up[k]);
        match self.projection {
            Projection::Parallel { .. } => {
                let origin = std::array::from_fn(|k| self.from[k] + aside[k]);
                Ray { origin, direction: self.forward }
            }
            Projection::Perspective { .. } => {
                let shorter = (1.0 + right * right + up * up).sqrt().recip();
                let direction = std::array::from_fn(|k| (self.forward[k] + aside[k]) * shorter);
                Ray { origin: self.from, direction }
            }
        }
    }

    /// The ray of a place in a picture of so many pixels, in pixels from its upper left corner.
    pub fn pixel_ray(&self, size: Size, [x, y]: [f64; 2]) -> Ray {
        let [width, height] = [size.width, size.height].map(|n| f64::from(n.get()));
        self.ray([(2.0 * x - width) / height, (height - 2.0 * y) / height])
    }

    /// The same camera, moved around what it looks at by an angle in degrees: from above, that is where `up`
    /// comes from, counter-clockwise.
    #[must_use]
    pub fn orbited(&self, degrees: f64) -> Self {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let turned = |v: Vector| -> Vector {
            let (along, across) = (dot(v, self.up), cross(self.up, v));
            // Rodrigues' rotation about the direction up.
            std::array::from_fn(|k| {
                v[k] * cosine + across[k] * sine + self.up[k] * along * (1.0 - cosine)
            })
        };
        let (right, forward) = (turned(self.right), turned(self.forward));
        let from =
            std::array::from_fn(|k| self.from[k] + self.distance * (self.forward[k] - forward[k]));
        Self { from, right, forward, ..*self }
    }
}

impl Side {
    /// Where a camera at this side looks, and what is up in its picture, in a world whose axes point so. In an
    /// unknown world as in RAS.
    pub fn directions(self, space: Space) -> (Vector, Vector) {
        let flip = if space == Space::Lps { -1.0 } else { 1.0 };
        let (right, anterior, superior) = ([flip, 0.0, 0.0], [0.0, flip, 0.0], [0.0, 0.0, 1.0]);
        let back = |v: Vector| v.map(|c| -c);
        match self {
            Self::Anterior => (back(anterior), superior),
            Self::Posterior => (anterior, superior),
            Self::Left => (right, superior),
            Self::Right => (back(right), superior),
            Self::Superior => (back(superior), anterior),
            Self::Inferior => (superior, anterior),
        }
    }
}

/// The unit vector along `v`. None along 0.
fn unit(v: Vector) -> Option<Vector> {
    let greatest = v.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
    if greatest == 0.0 {
        return None;
    }
    // Divided first, so that no square overflows or vanishes.
    let v = v.map(|c| c / greatest);
    let length = length(v);
    Some(v.map(|c| c / length))
}

#[cfg(test)]
mod tests;
