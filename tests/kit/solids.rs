//! Simple solids as distances: below 0 inside, in the unit of the coordinates.
//!
//! Nothing but the four operations and square roots, which round alike on every machine.

/// A solid.
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Solid {
    Ellipsoid {
        centre: [f64; 3],
        radii: [f64; 3],
    },
    /// Ends of two radii, and the cone between them.
    Capsule {
        ends: [[f64; 3]; 2],
        radii: [f64; 2],
    },
    Box {
        centre: [f64; 3],
        halves: [f64; 3],
    },
    /// Along an axis; `span` are its ends on that axis.
    Cylinder {
        axis: usize,
        centre: [f64; 3],
        radius: f64,
        span: [f64; 2],
    },
}

impl Solid {
    /// The distance from `p` to the surface; for an ellipsoid one that is right to first order.
    pub fn distance(&self, p: [f64; 3]) -> f64 {
        match *self {
            Self::Ellipsoid { centre, radii } => ellipsoid(minus(p, centre), radii),
            Self::Capsule { ends: [a, b], radii: [ra, rb] } => {
                let (along, from) = (minus(b, a), minus(p, a));
                let t = (dot(from, along) / dot(along, along)).clamp(0.0, 1.0);
                length(minus(from, along.map(|c| c * t))) - (ra + (rb - ra) * t)
            }
            Self::Box { centre, halves } => {
                let q = minus(p, centre);
                let beyond: [f64; 3] = std::array::from_fn(|k| q[k].abs() - halves[k]);
                let outside = length(beyond.map(|c| c.max(0.0)));
                outside + beyond[0].max(beyond[1]).max(beyond[2]).min(0.0)
            }
            Self::Cylinder { axis, centre, radius, span } => {
                let mut q = minus(p, centre);
                q[axis] = 0.0;
                let ends = (span[0] - p[axis]).max(p[axis] - span[1]);
                (length(q) - radius).max(ends)
            }
        }
    }
}

fn ellipsoid(q: [f64; 3], radii: [f64; 3]) -> f64 {
    let scaled: [f64; 3] = std::array::from_fn(|k| q[k] / radii[k]);
    let steep = length(std::array::from_fn(|k| scaled[k] / radii[k]));
    if steep == 0.0 {
        return -radii[0].min(radii[1]).min(radii[2]);
    }
    length(scaled) * (length(scaled) - 1.0) / steep
}

/// The union of two solids, rounded where they meet, over a distance of about `blend`.
pub fn blended(a: f64, b: f64, blend: f64) -> f64 {
    let near = (blend - (a - b).abs()).max(0.0) / blend;
    a.min(b) - near * near * blend / 4.0
}

/// How much of a sample's surroundings, `width` wide, lies inside: a smooth ramp from 1 to 0.
pub fn coverage(distance: f64, width: f64) -> f64 {
    let t = (0.5 - distance / width).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The length of a vector.
pub fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

/// The difference of two vectors.
pub fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

/// The scalar product.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::{Solid, blended, coverage};

    #[test]
    fn distances_are_those_of_a_ruler() {
        let ball = Solid::Ellipsoid { centre: [1.0, 0.0, 0.0], radii: [2.0; 3] };
        assert_eq!(ball.distance([6.0, 0.0, 0.0]), 3.0);
        assert_eq!(ball.distance([1.0, 0.0, 0.0]), -2.0);
        let ends = [[0.0; 3], [4.0, 0.0, 0.0]];
        let capsule = Solid::Capsule { ends, radii: [1.0, 3.0] };
        assert_eq!(
            [-2.0, 2.0].map(|x| capsule.distance([x, 5.0, 0.0])),
            [29_f64.sqrt() - 1.0, 3.0]
        );
        let block = Solid::Box { centre: [0.0; 3], halves: [1.0, 2.0, 3.0] };
        assert_eq!(block.distance([4.0, 6.0, 0.0]), 5.0);
        assert_eq!(block.distance([0.0; 3]), -1.0);
        let rod = Solid::Cylinder { axis: 2, centre: [0.0; 3], radius: 1.0, span: [0.0, 9.0] };
        assert_eq!([-2.0, 4.5].map(|z| rod.distance([3.0, 0.0, z])), [2.0, 2.0]);
    }

    #[test]
    fn a_blend_is_the_union_away_from_the_seam_and_more_at_it() {
        assert_eq!(blended(1.0, 9.0, 4.0), 1.0);
        assert_eq!(blended(1.0, 1.0, 4.0), 0.0);
        assert_eq!([-1.0, 0.0, 1.0].map(|d| coverage(d, 2.0)), [1.0, 0.5, 0.0]);
    }
}
