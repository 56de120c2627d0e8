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

    /// How often a facet counts.
    pub(crate) fn weight(&self, facet: u32) -> f64 {
        self.weights[facet as usize]
    }

    /// The winding number at a point, within an allowance, and a bound of the error. An allowance of 0: the plain sum.
    pub(crate) fn at(&self, bvh: &Bvh, point: [f64; 3], allowance: f64) -> (f64, f64) {
        let (mut sum, mut error) = (0.0, 0.0);
        let allowed = allowance / self.moments[0].area;
        let mut waiting = vec![0];
        while let Some(at) = waiting.pop() {
            let Some(far) = self.taken_together(at, point) else { continue };
            if far.wrong <= allowed * self.moments[at].area {
                sum += far.angle;
                error += far.wrong;
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

    /// The triangles of a box as one, and how wrong that is, as a part of a whole winding; none if there are none.
    fn taken_together(&self, at: usize, point: [f64; 3]) -> Option<Far> {
        let moments = &self.moments[at];
        if moments.area == 0.0 {
            return None;
        }
        let away = sub(moments.centre, point);
        let square = dot(away, away);
        let gap = square.sqrt() - moments.radius;
        if gap <= 0.0 {
            return Some(Far { at, angle: 0.0, wrong: f64::INFINITY });
        }
        let wrong = 3.0 * moments.spread / (4.0 * PI * (gap * gap) * (gap * gap));
        Some(Far { at, angle: far(moments, away, square), wrong })
    }
}

/// The winding number at a point, found step by step: with each the bound of its error is less.
pub(crate) struct Search<'a> {
    windings: &'a Windings,
    bvh: &'a Bvh,
    point: [f64; 3],
    /// Facets that do not count.
    left_out: &'a [u32],
    /// Of the triangles that were looked at one by one.
    seen: Turns,
    /// What stands for all others.
    far: Vec<Far>,
}

/// The triangles of a box, taken together.
#[derive(Clone, Copy, Debug)]
struct Far {
    at: usize,
    angle: f64,
    wrong: f64,
}

impl<'a> Search<'a> {
    pub(crate) fn new(windings: &'a Windings, bvh: &'a Bvh, point: [f64; 3]) -> Self {
        Self::without(&[], windings, bvh, point)
    }

    /// Without some facets that go through the point; so near they are never taken together with others.
    pub(crate) fn without(
        left_out: &'a [u32],
        windings: &'a Windings,
        bvh: &'a Bvh,
        point: [f64; 3],
    ) -> Self {
        let all = Far { at: 0, angle: 0.0, wrong: f64::INFINITY };
        Self { windings, bvh, point, left_out, seen: Turns::default(), far: vec![all] }
    }

    /// Opens boxes until none is wrong by more than a limit; the winding number as it is known then, and a bound of its error.
    pub(crate) fn open(&mut self, limit: f64) -> (f64, f64) {
        let mut waiting = vec![];
        let mut kept = vec![];
        for far in std::mem::take(&mut self.far) {
            if far.wrong <= limit {
                kept.push(far)
            } else {
                waiting.push(far.at)
            }
            while let Some(at) = waiting.pop() {
                match self.bvh.below(at) {
                    Below::Boxes(two) => {
                        for at in two {
                            match self.windings.taken_together(at, self.point) {
                                Some(far) if far.wrong <= limit => kept.push(far),
                                Some(_) => waiting.push(at),
                                None => {}
                            }
                        }
                    }
                    Below::Facets(facets) => {
                        let counts = |n: &usize| {
                            self.windings.weights[*n] != 0.0
                                && !self.left_out.contains(&(*n as u32))
                        };
                        for n in facets.filter(counts) {
                            let seen = seen(&self.bvh.facets()[n], self.point);
                            self.seen.turn(seen, self.windings.weights[n]);
                        }
                    }
                }
            }
        }
        self.far = kept;
        let angle: f64 = self.far.iter().map(|far| far.angle).sum();
        let wrong: f64 = self.far.iter().map(|far| far.wrong).sum();
        let rounding = 1e-15 * self.windings.weights.len() as f64;
        ((angle + 2.0 * self.seen.angle()) / (4.0 * PI), wrong + rounding)
    }
}

/// Angles that are added without a call for each: the product of complex numbers, and how often it came around.
///
/// An arctangent takes longer than all else that is done for a triangle.
#[derive(Clone, Copy, Debug)]
struct Turns {
    product: [f64; 2],
    whole: f64,
}

impl Default for Turns {
    fn default() -> Self {
        Self { product: [1.0, 0.0], whole: 0.0 }
    }
}

impl Turns {
    /// Adds the argument of a complex number, from −π to π, or takes it away.
    ///
    /// If both are in one half, above or below, the sum came around if the product is in the other, or if it is on the right
    /// and neither is: there rounding may bring it over the axis.
    fn turn(&mut self, [re, im]: [f64; 2], weight: f64) {
        let size = re.abs() + im.abs();
        if size == 0.0 {
            return; // the point is a corner
        }
        let ([a, b], [c, d]) = (self.product, [re / size, weight * im / size + 0.0]);
        let (re, im) = (a * c - b * d, a * d + b * c);
        let is_right = re > 0.0 && a < 0.0 && c < 0.0;
        if b >= 0.0 && d >= 0.0 && (im < 0.0 || is_right) {
            self.whole += 1.0;
        } else if b < 0.0 && d < 0.0 && (im >= 0.0 || is_right) {
            self.whole -= 1.0;
        }
        let size = re.abs() + im.abs();
        self.product = [re / size, im / size + 0.0]; // no −0, whose argument would be −π
    }

    fn angle(&self) -> f64 {
        2.0 * PI * self.whole + self.product[1].atan2(self.product[0])
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

/// The solid angle of a facet; positive where it is seen from inside.
fn solid_angle(facet: &Facet, point: [f64; 3]) -> f64 {
    let [rest, volume] = seen(facet, point);
    2.0 * volume.atan2(rest)
}

/// A complex number whose argument is half the solid angle (Van Oosterom & Strackee 1983).
fn seen(facet: &Facet, point: [f64; 3]) -> [f64; 2] {
    let a = sub(facet.corner, point);
    let add = |edge: [f64; 3]| [0, 1, 2].map(|k| a[k] + edge[k]);
    let [b, c] = facet.edges.map(add);
    let [la, lb, lc] = [a, b, c].map(length);
    let volume = dot(a, cross(facet.edges[0], facet.edges[1]));
    let rest = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    [rest, volume]
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
            for (j, along) in shift.iter().enumerate() {
                all.quadrupole[i][j] += part.quadrupole[i][j] + part.dipole[i] * along;
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

#[cfg(test)]
mod tests;
