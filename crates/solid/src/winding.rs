//! How often a surface winds around a point, be it open or not.
//!
//! The generalised winding number (Jacobson, Kavan & Sorkine-Hornung 2013, "Robust inside-outside segmentation using
//! generalized winding numbers") is the sum of the solid angles that triangles are seen under (Van Oosterom & Strackee 1983,
//! "The solid angle of a plane triangle"), over 4π. Of a closed surface it is a whole number, 1 within one that is wound
//! outwards. Far triangles are taken together, by the first two terms of their potential (Barill, Dickson, Schmidt, Levin &
//! Jacobson 2018, "Fast winding numbers for soups and clouds", section 3).
//!
//! What that costs in accuracy is bounded: the third derivative of 1/ρ along three directions is 6/ρ⁴ at most, so triangles
//! about a centre, with ∫ δ² over them and none farther from it than r, are wrong by 3 ∫ δ² / (4π (R − r)⁴) at most at a
//! distance R. Triangles are taken together only if that is no more than their area's share of an allowance. What is
//! returned is within the allowance of the plain sum, but for rounding.

use crate::bvh::{Below, Bvh, squared_to_box};
use isokit_geom::vector::{cross, dot, length, sub};
use isokit_lanes::Facet;
use std::f64::consts::PI;

/// The surface as windings are made of it.
#[derive(Clone, Debug)]
pub(crate) struct Windings {
    /// One for each box of the tree.
    moments: Vec<Moments>,
    /// How often each facet counts, those that are wound the other way negative.
    weights: Vec<f64>,
}

/// What is known of the triangles of a box together.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    /// The middle of their area.
    centre: [f64; 3],
    area: f64,
    /// Their normals, each as long as the area.
    dipole: [f64; 3],
    /// ∫ nᵢ δⱼ, where δ leads from the centre.
    quadrupole: [[f64; 3]; 3],
    /// ∫ δ².
    spread: f64,
    /// How far from the centre they reach.
    radius: f64,
}

impl Windings {
    /// Of the facets of a tree, each with its weight.
    pub(crate) fn new(bvh: &Bvh, weights: Vec<f64>) -> Self {
        let mut moments = vec![Moments::default(); bvh.boxes().len()];
        // What is in a box comes after it.
        for at in (0..moments.len()).rev() {
            moments[at] = match bvh.below(at) {
                Below::Boxes(two) => together(&two.map(|n| moments[n])),
                Below::Facets(facets) => {
                    let one = |n| of_facet(&bvh.facets()[n], weights[n]);
                    together(&facets.map(one).collect::<Vec<_>>())
                }
            };
        }
        Self { moments, weights }
    }

    /// The winding number at a point, within an allowance, and a bound of the error. An allowance of 0: the plain sum.
    pub(crate) fn at(&self, bvh: &Bvh, point: [f64; 3], allowance: f64) -> (f64, f64) {
        let (mut sum, mut error) = (0.0, 0.0);
        let allowed = allowance / self.moments[0].area;
        let mut waiting = vec![0];
        while let Some(at) = waiting.pop() {
            let moments = &self.moments[at];
            if moments.area == 0.0 {
                continue;
            }
            let away = sub(moments.centre, point);
            let square = dot(away, away);
            let gap = square.sqrt() - moments.radius;
            let wrong = 3.0 * moments.spread / (4.0 * PI * (gap * gap) * (gap * gap));
            if gap > 0.0 && wrong <= allowed * moments.area {
                sum += far(moments, away, square);
                error += wrong;
                continue;
            }
            match bvh.below(at) {
                Below::Boxes([a, b]) => waiting.extend([b, a]),
                Below::Facets(facets) => {
                    for n in facets.filter(|&n| self.weights[n] != 0.0) {
                        sum += self.weights[n] * solid_angle(&bvh.facets()[n], point);
                    }
                }
            }
        }
        // Sums of this many terms are not rounded by more.
        let rounding = 1e-15 * self.weights.len() as f64;
        (sum / (4.0 * PI), error + rounding)
    }
}

/// The potential of far triangles.
fn far(moments: &Moments, away: [f64; 3], square: f64) -> f64 {
    let inverse = 1.0 / square;
    let cubed = inverse * inverse.sqrt();
    let Moments { dipole, quadrupole: m, .. } = moments;
    let trace = m[0][0] + m[1][1] + m[2][2];
    let turned = m.map(|row| dot(row, away));
    (dot(*dipole, away) + trace - 3.0 * inverse * dot(turned, away)) * cubed
}

/// Van Oosterom & Strackee 1983; positive where the triangle is seen from inside.
pub(crate) fn solid_angle(facet: &Facet, point: [f64; 3]) -> f64 {
    let a = sub(facet.corner, point);
    let add = |edge: [f64; 3]| [0, 1, 2].map(|k| a[k] + edge[k]);
    let [b, c] = facet.edges.map(add);
    let [la, lb, lc] = [a, b, c].map(length);
    let volume = dot(a, cross(facet.edges[0], facet.edges[1]));
    let rest = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    2.0 * volume.atan2(rest)
}

fn of_facet(facet: &Facet, weight: f64) -> Moments {
    let corners = [[0.0; 3], facet.edges[0], facet.edges[1]];
    let middle = [0, 1, 2].map(|k| (facet.edges[0][k] + facet.edges[1][k]) / 3.0);
    let dipole = cross(facet.edges[0], facet.edges[1]).map(|c| 0.5 * c);
    let area = length(dipole);
    let from = corners.map(|corner| sub(corner, middle));
    Moments {
        centre: [0, 1, 2].map(|k| facet.corner[k] + middle[k]),
        area: if weight == 0.0 { 0.0 } else { area },
        dipole: dipole.map(|c| c * weight),
        quadrupole: [[0.0; 3]; 3],
        // The corners' squares from the middle, over 12: their sum from there is 0.
        spread: weight.abs() * area / 12.0 * from.iter().map(|d| dot(*d, *d)).sum::<f64>(),
        radius: from.into_iter().map(length).fold(0.0, f64::max),
    }
}

fn together(parts: &[Moments]) -> Moments {
    let mut all = Moments::default();
    let parts = || parts.iter().filter(|part| part.area > 0.0);
    all.area = parts().map(|part| part.area).sum();
    if all.area == 0.0 {
        return all;
    }
    let middle = |k| parts().map(|part| part.centre[k] * (part.area / all.area)).sum();
    all.centre = [0, 1, 2].map(middle);
    for part in parts() {
        let shift = sub(part.centre, all.centre);
        for i in 0..3 {
            all.dipole[i] += part.dipole[i];
            for j in 0..3 {
                all.quadrupole[i][j] += part.quadrupole[i][j] + part.dipole[i] * shift[j];
            }
        }
        all.spread += part.spread + part.area * dot(shift, shift);
        all.radius = all.radius.max(length(shift) + part.radius);
    }
    all
}

/// Edges at which a surface ends, and how fast the winding number can change beside them.
///
/// Its gradient is that of the edges alone, by the law of Biot and Savart: ∮ (p − l) × dl / (4π |p − l|³). A closed
/// surface has none.
#[derive(Clone, Debug)]
pub(crate) struct Rim {
    bvh: Bvh,
    /// Of the edges of each box, together, each as often as it counts.
    lengths: Vec<f64>,
}

impl Rim {
    /// Of edges, each with how often it counts.
    pub(crate) fn new(edges: &[([[f64; 3]; 2], f64)]) -> Option<Self> {
        if edges.is_empty() {
            return None;
        }
        let flat: Vec<_> = edges.iter().map(|([a, b], _)| [*a, *b, *b]).collect();
        let bvh = Bvh::new(&flat);
        let mut lengths = vec![0.0; bvh.boxes().len()];
        for at in (0..lengths.len()).rev() {
            lengths[at] = match bvh.below(at) {
                Below::Boxes([a, b]) => lengths[a] + lengths[b],
                Below::Facets(facets) => {
                    let edges = facets.map(|n| &edges[bvh.triangles()[n] as usize]);
                    edges.map(|([a, b], count)| length(sub(*b, *a)) * count).sum()
                }
            };
        }
        Some(Self { bvh, lengths })
    }

    /// No less than the length of the gradient anywhere within a ball.
    pub(crate) fn steepness(&self, centre: [f64; 3], radius: f64) -> f64 {
        let mut sum = 0.0;
        let mut waiting = vec![0];
        while let Some(at) = waiting.pop() {
            let node = &self.bvh.boxes()[at];
            let gap = squared_to_box(centre, node).sqrt() - radius;
            let size = length([0, 1, 2].map(|k| f64::from(node.sides[1][k] - node.sides[0][k])));
            match self.bvh.below(at) {
                Below::Boxes([a, b]) if gap < 2.0 * size => waiting.extend([b, a]),
                _ if gap > 0.0 => sum += self.lengths[at] / (gap * gap),
                _ => return f64::INFINITY,
            }
        }
        sum / (4.0 * PI)
    }
}
