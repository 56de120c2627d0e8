//! Where the vertices in the interior of a cell lie, in cell sizes from its lowest corner.
//!
//! *Fan.* The mean of its loop, moved onto the surface by a few steps of Newton's method.
//!
//! *Waist.* Where q(t) of `decide.rs` has its two roots, the slice's hyperbola is a pair of lines along
//! the axes of the cell. The same is true across the other two axes, and the six lines meet in six points:
//! a hexagon that lies in the surface around the narrowest part of the tube (the inner hexagon of Grosso,
//! "Construction of topologically correct and manifold isosurfaces", CGF 35(5), 2016). It consists of the
//! corners of a box but for two opposite ones.
//!
//! *No triangle is flat.* All these vertices keep [`CLEARANCE`] from the faces of the cell, and so does the
//! box, whose sides are at least as long. A triangle of an interior vertex and a side of a loop has that
//! side in a face and its apex off it. A triangle of a vertex on an edge of the cell and a side of the
//! hexagon has its apex off the line of that side, which is parallel to an axis, through the interior, and
//! so keeps the clearance from every edge of the cell. Rounding to f32 moves no vertex by a quarter of it.

use super::{cell::Cell, patch::WAIST};
use isokit_geom::cube::Edge;

/// What vertices keep from the faces of the cell: as much as vertices on edges keep from samples at most.
const CLEARANCE: f64 = 1.0 / 16.0;

/// How far, along each axis, the centre of a fan may move away from the mean of its loop.
const REACH: f64 = 0.25;

/// The trilinear interpolant of a cell, but for a factor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interpolant {
    values: [f64; 8],
}

impl Interpolant {
    /// Of the cell, if all its corners have finite values.
    pub(super) fn new(cell: &Cell) -> Option<Self> {
        let greatest = cell.values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let values = cell.values.map(|value| value / greatest);
        (cell.known == u8::MAX).then_some(Self { values })
    }

    /// Where an edge has the value 0, wherever its vertex is placed; its middle if that is not told.
    pub(super) fn crossing(&self, edge: Edge) -> [f64; 3] {
        let [start, end] = edge.ends();
        let [a, b] = [start, end].map(|corner| self.values[corner.index()]);
        let (mut place, share) = (start.offset().map(|i| i as f64), a / (a - b));
        place[edge.axis()] += if share.is_nan() { 0.5 } else { share };
        place
    }

    /// The gradient, and the value.
    pub(super) fn gradient(&self, [x, y, z]: [f64; 3]) -> ([f64; 3], f64) {
        let v = &self.values;
        let mix = |a: f64, b: f64, t: f64| a * (1.0 - t) + b * t;
        // Along x on the four edges, then along y on two lines, then along z.
        let edge = |k: usize| (mix(v[k], v[k + 1], x), v[k + 1] - v[k]);
        let [e, f, g, h] = [edge(0), edge(2), edge(4), edge(6)];
        let (low, high) = (mix(e.0, f.0, y), mix(g.0, h.0, y));
        let along_x = mix(mix(e.1, f.1, y), mix(g.1, h.1, y), z);
        ([along_x, mix(f.0 - e.0, h.0 - g.0, z), high - low], mix(low, high, z))
    }
}

/// The centre of a fan in a loop of these places.
pub(super) fn centre(interpolant: Option<&Interpolant>, ring: &[[f64; 3]]) -> [f64; 3] {
    let sum = |axis: usize| ring.iter().map(|place| place[axis]).sum::<f64>();
    let mean: [f64; 3] = std::array::from_fn(|axis| sum(axis) / ring.len() as f64);
    let inside = |place: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|axis| {
            let near = place[axis].clamp(mean[axis] - REACH, mean[axis] + REACH);
            near.clamp(CLEARANCE, 1.0 - CLEARANCE)
        })
    };
    let mut best = inside(mean);
    let Some(interpolant) = interpolant else { return best };
    let (mut gradient, mut value) = interpolant.gradient(best);
    for _ in 0..8 {
        let square: f64 = gradient.iter().map(|part| part * part).sum();
        let step = value / square;
        if !step.is_finite() {
            break;
        }
        let next = inside(std::array::from_fn(|axis| best[axis] - step * gradient[axis]));
        let (next_gradient, next_value) = interpolant.gradient(next);
        if next_value.abs() >= value.abs() {
            break;
        }
        (best, gradient, value) = (next, next_gradient, next_value);
    }
    best
}

/// The waist of the tube that joins corners `a` and `c`, which lie across each other along x and y.
pub(super) fn waist(interpolant: &Interpolant, [a, c]: [u8; 2]) -> [[f64; 3]; WAIST] {
    let diagonal = [0, 1].map(|axis| f64::from(c >> axis & 1) - f64::from(a >> axis & 1));
    let roots = roots(interpolant, [a, c]);
    let [first, second] = roots.map(|t| saddle(interpolant, t));
    // Between the two slices the saddle moves along the tube, one way or the other.
    let along = |axis: usize| (second[axis] - first[axis]) * diagonal[axis];
    let rises = |axis: usize| (along(0) + along(1) >= 0.0) == (diagonal[axis] > 0.0);
    let [x, y] = [0, 1].map(|axis| match rises(axis) {
        true => apart(first[axis], second[axis]),
        false => {
            let [low, high] = apart(first[axis], second[axis]);
            [high, low]
        }
    });
    let z = apart(roots[0], roots[1]);
    let places = [[0, 0, 0], [1, 0, 0], [1, 0, 1], [1, 1, 1], [0, 1, 1], [0, 1, 0]];
    places.map(|[i, j, k]| [x[i], y[j], z[k]])
}

/// Where q(t) is 0, in ascending order.
fn roots(interpolant: &Interpolant, [a, c]: [u8; 2]) -> [f64; 2] {
    let corner = |x: u8, y: u8| {
        let k = usize::from((x & 1) | (y & 2));
        let [low, high] = [interpolant.values[k], interpolant.values[k | 4]];
        (low, high - low)
    };
    let [a, b, c, d] = [corner(a, a), corner(c, a), corner(c, c), corner(a, c)];
    let curvature = a.1 * c.1 - b.1 * d.1;
    let slope = a.0 * c.1 + c.0 * a.1 - b.0 * d.1 - d.0 * b.1;
    let start = a.0 * c.0 - b.0 * d.0;
    let spread = (slope * slope - 4.0 * curvature * start).max(0.0).sqrt();
    // The curvature is negative.
    [(spread - slope) / (2.0 * curvature), (-spread - slope) / (2.0 * curvature)]
}

/// Where the slice at `t` along z has its saddle, along x and y.
fn saddle(interpolant: &Interpolant, t: f64) -> [f64; 2] {
    let at = |k: usize| interpolant.values[k] * (1.0 - t) + interpolant.values[k | 4] * t;
    let twist = at(0) + at(3) - at(1) - at(2);
    [(at(0) - at(2)) / twist, (at(0) - at(1)) / twist]
}

/// The two numbers in ascending order, with the clearance between them and from 0 and 1.
fn apart(p: f64, q: f64) -> [f64; 2] {
    let inside = |n: f64| if n.is_nan() { 0.5 } else { n.clamp(CLEARANCE, 1.0 - CLEARANCE) };
    let [low, high] = [inside(p.min(q)), inside(p.max(q))];
    if high - low >= CLEARANCE {
        return [low, high];
    }
    let middle = low.midpoint(high).clamp(1.5 * CLEARANCE, 1.0 - 1.5 * CLEARANCE);
    [middle - 0.5 * CLEARANCE, middle + 0.5 * CLEARANCE]
}

#[cfg(test)]
mod tests;
