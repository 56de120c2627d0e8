//! How far a point is from a triangle, and from the nearest of many.
//!
//! The nearest point of a triangle lies on one of its edges, or else straight below or above (Ericson 2005, "Real-time
//! collision detection", section 5.1.5, has the regions). Here all four candidates are computed and the nearest is taken:
//! that holds for triangles without an area too. Where a triangle is so thin that its normal is mostly rounding, its edges
//! are taken for all of it: what lies between is no farther from them than 10⁻⁸ of its longest edge.

use isokit_geom::vector::{cross, dot, sub};
use isokit_lanes::Facet;

/// A triangle's area over the square of its longest edge, twice: no less than that has a normal.
pub(crate) const THIN: f64 = 1e-8;

/// A triangle, made ready for points.
pub(crate) fn facet([a, b, c]: [[f64; 3]; 3]) -> Facet {
    let (first, third) = (sub(b, a), sub(c, a));
    let across = sub(third, first);
    let squares = [first, third, across].map(|edge| dot(edge, edge));
    let normal = cross(first, third);
    let square = dot(normal, normal);
    let longest = squares.into_iter().fold(0.0, f64::max);
    let has_area = square.sqrt() > THIN * longest && square > f64::MIN_POSITIVE;
    let mut facet = Facet {
        corner: a,
        edges: [first, third],
        shares: squares.map(|square| if square > f64::MIN_POSITIVE { 1.0 / square } else { 0.0 }),
        has_area,
        ..Facet::default()
    };
    if has_area {
        let scaled = |v: [f64; 3]| v.map(|c| c / square);
        let long = square.sqrt();
        facet.normal = normal.map(|c| c / long);
        facet.inside = [scaled(cross(third, normal)), scaled(cross(normal, first))];
    }
    facet
}

/// What of a triangle a point is nearest to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// What is between the edges.
    Face,
    /// An edge: the direction, one long.
    Edge([f64; 3]),
    /// A corner.
    Corner,
}

/// The nearest point of a facet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Near {
    /// The squared distance.
    pub(crate) squared: f64,
    /// What leads from there to the point that was asked about.
    pub(crate) away: [f64; 3],
    pub(crate) part: Part,
    /// How much of the first edge and of the third leads there from the corner they have in common.
    along: [f64; 2],
}

impl Near {
    /// How much of each corner is in it; together 1.
    pub(crate) fn shares(&self) -> [f64; 3] {
        let [first, third] = self.along;
        [(1.0 - first - third).max(0.0), first, third]
    }
}

/// To the bit what sixteen points at once are told.
pub(crate) fn near(point: [f64; 3], facet: &Facet) -> Near {
    let Facet { corner, edges: [first, third], shares, normal, inside, has_area } = facet;
    let v = sub(point, *corner);
    if *has_area {
        let [a, b] = [dot(v, inside[0]), dot(v, inside[1])];
        if !(a < 0.0 || b < 0.0 || 1.0 < a + b) {
            let height = dot(v, *normal);
            let away = normal.map(|c| c * height);
            return Near { squared: height * height, away, part: Part::Face, along: [a, b] };
        }
    }
    let across = sub(*third, *first);
    let w = sub(v, *first);
    let to_edge = |from: [f64; 3], edge: [f64; 3], share: f64, place: fn(f64) -> [f64; 2]| {
        let along = (dot(from, edge) * share).clamp(0.0, 1.0);
        let away = [0, 1, 2].map(|k| from[k] - along * edge[k]);
        let is_within = along > 0.0 && along < 1.0;
        let part = match is_within {
            true => Part::Edge(edge.map(|c| c * share.sqrt())),
            false => Part::Corner,
        };
        Near { squared: dot(away, away), away, part, along: place(along) }
    };
    let all = [
        to_edge(v, *first, shares[0], |along| [along, 0.0]),
        to_edge(v, *third, shares[1], |along| [0.0, along]),
        to_edge(w, across, shares[2], |along| [1.0 - along, along]),
    ];
    all.into_iter().reduce(|a, b| if b.squared < a.squared { b } else { a }).unwrap_or(all[0])
}
