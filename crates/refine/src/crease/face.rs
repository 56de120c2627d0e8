//! Faces of a surface as tangent planes, and where they meet.

use crate::ground::Ground;
use isokit_geom::vector::{Vector, cross, dot, length, sub};

/// The tangent plane of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Face {
    /// One long, inward: the way in which the value rises.
    pub(crate) normal: Vector,
    /// A point of it.
    through: Vector,
}

/// How often faces are asked again, nearer to the crease.
const ROUNDS: usize = 3;

/// How much nearer each time.
const NEARER: f64 = 1.0 / 8.0;

/// How far from the surface a point of it may seem to be, as a part of the edge that it cuts.
const OFF: f64 = 1e-3;

/// Ends that are nearer to a crease than this part of their edge are on it.
const ON_CREASE: f64 = 1e-2;

impl Face {
    /// The plane of the surface near a place, none beyond the volume, on its border, and where the field has no slope.
    pub(crate) fn near(place: Vector, ground: &Ground<'_>) -> Option<Self> {
        let spot = ground.spot(place);
        if spot.is_beyond || spot.held() != [false; 3] {
            return None;
        }
        let slope = ground.field().slope(spot.ijk);
        let ascent = ground.ascent(slope.gradient, [false; 3])?;
        let off = (slope.value - ground.iso()) / ascent.steepness;
        let normal = ascent.direction;
        let through: Vector = std::array::from_fn(|k| place[k] - off * normal[k]);
        through.iter().all(|c| c.is_finite()).then_some(Self { normal, through })
    }

    /// Whether this one and another look ways whose product is below `least`.
    pub(crate) fn meets(&self, other: &Self, least: f64) -> bool {
        dot(self.normal, other.normal) < least
    }

    /// The outward normal, as a mesh keeps it.
    pub(crate) fn outward(&self) -> [f32; 3] {
        self.normal.map(|c| -c as f32)
    }

    /// How far the plane is from a place, along its normal.
    pub(crate) fn height(&self, from: Vector) -> f64 {
        dot(self.normal, sub(self.through, from))
    }
}

/// Where an edge of the mesh crosses the crease between the faces of its ends, if there is one: they are
/// [to meet](Face::meets) however near to it they are looked at.
pub(crate) fn crossing(
    [a, b]: [Vector; 2],
    faces: [Face; 2],
    least: f64,
    ground: &Ground<'_>,
) -> Option<Vector> {
    let long = length(sub(b, a));
    let mut place = on_both([a, b], faces)?;
    for round in 1..=ROUNDS {
        let share = NEARER.powi(round as i32);
        let near = |end: Vector| std::array::from_fn(|k| place[k] + share * (end[k] - place[k]));
        let [p, q] = [a, b].map(|end| Face::near(near(end), ground));
        let nearer = [p?, q?];
        if !nearer[0].meets(&nearer[1], least) {
            return None;
        }
        place = on_both([a, b], nearer)?;
    }
    is_on_surface(place, OFF * long, ground).then_some(place)
}

/// The point of both planes at which the edge would cross their line if one were turned about it into the other: so what
/// is on one side of an edge stays there.
fn on_both([a, b]: [Vector; 2], [p, q]: [Face; 2]) -> Option<Vector> {
    let middle: Vector = std::array::from_fn(|k| a[k].midpoint(b[k]));
    let product = dot(p.normal, q.normal);
    let square = 1.0 - product * product;
    let (up, uq) = (p.height(middle), q.height(middle));
    let (kp, kq) = ((up - product * uq) / square, (uq - product * up) / square);
    let base: Vector = std::array::from_fn(|k| middle[k] + kp * p.normal[k] + kq * q.normal[k]);
    let line = cross(p.normal, q.normal).map(|c| c / square.sqrt());
    let [(along_a, from_a), (along_b, from_b)] = [a, b].map(|end| {
        let way = sub(end, base);
        let along = dot(way, line);
        (along, length(std::array::from_fn(|k| way[k] - along * line[k])))
    });
    let long = length(sub(b, a));
    let is_between = from_a.min(from_b) > ON_CREASE * long; // not if a place is NaN
    let along = along_a + (along_b - along_a) * (from_a / (from_a + from_b));
    let place: Vector = std::array::from_fn(|k| base[k] + along * line[k]);
    (is_between && length(sub(place, middle)) <= long).then_some(place)
}

/// Where three faces meet, no farther than `reach` from a place.
pub(crate) fn meeting_point(
    faces: [Face; 3],
    from: Vector,
    reach: f64,
    ground: &Ground<'_>,
) -> Option<Vector> {
    let is_near = |place: &Vector| length(sub(*place, from)) <= reach;
    let mut place = on_all(faces, from).filter(is_near)?;
    for round in 1..=ROUNDS {
        let share = NEARER.powi(round as i32);
        let nearer = faces.map(|face| {
            let end = face.through;
            Face::near(std::array::from_fn(|k| place[k] + share * (end[k] - place[k])), ground)
        });
        let [Some(p), Some(q), Some(r)] = nearer else { return None };
        place = on_all([p, q, r], place)?;
    }
    (is_near(&place) && is_on_surface(place, OFF * reach, ground)).then_some(place)
}

/// The point of three planes.
fn on_all([p, q, r]: [Face; 3], from: Vector) -> Option<Vector> {
    let (qr, rp, pq) =
        (cross(q.normal, r.normal), cross(r.normal, p.normal), cross(p.normal, q.normal));
    let volume = dot(p.normal, qr);
    let [up, uq, ur] = [p, q, r].map(|face| face.height(from));
    let place: Vector =
        std::array::from_fn(|k| from[k] + (up * qr[k] + uq * rp[k] + ur * pq[k]) / volume);
    place.iter().all(|c| c.is_finite()).then_some(place)
}

/// Whether a place within the volume is as near to the surface as `off`, by the slope there.
fn is_on_surface(place: Vector, off: f64, ground: &Ground<'_>) -> bool {
    let face = Face::near(place, ground);
    face.is_some_and(|face| face.height(place).abs() <= off)
}
