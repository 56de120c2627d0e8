//! Vertices on polynomials, and normals of as high an order.

use super::{Cut, Placer, curve::Curve, delta};
use crate::Placement;
use isokit_lanes::{Coordinate, Crossings, Edges, cubic_crossings};
use isokit_volume::{Sample, line};

/// The most samples on one line that a place depends on.
const MOST: usize = 6;

impl<T: Sample> Placer<'_, T> {
    /// Places vertices on curves. A kernel places those on cubics; what it calls odd is done one by one.
    pub(super) fn place_curved<C: Coordinate>(
        &self,
        edges: &Edges,
        positions: &mut [[C; 3]],
        normals: Option<&mut [[f32; 3]]>,
        odd: &mut Vec<u32>,
    ) {
        let mut deltas = vec![0.0; if normals.is_some() { edges.len() } else { 0 }];
        match (&self.samples, self.placement) {
            (Some(samples), Placement::Cubic) => {
                let deltas = normals.is_some().then_some(&mut deltas[..]);
                let out = Crossings { positions: &mut *positions, deltas, odd: &mut *odd };
                cubic_crossings(samples, &self.field, edges, out);
            }
            _ => odd.extend(0..edges.len() as u32),
        }
        for n in odd.iter().map(|&n| n as usize) {
            let (axis, low) = edges.get(n);
            let straight = self.cut(axis, low);
            let cut = self.curved(&straight).unwrap_or(straight);
            positions[n] = self.position(&cut);
            if normals.is_some() {
                deltas[n] = cut.delta;
            }
        }
        for (n, normal) in normals.into_iter().flatten().enumerate() {
            let (axis, low) = edges.get(n);
            *normal = self.normal_on_curve(&Cut { delta: deltas[n], ..self.cut(axis, low) });
        }
    }

    /// The cut of an edge by the polynomial through the samples around it, if there is one to be cut.
    pub(super) fn curved(&self, cut: &Cut) -> Option<Cut> {
        let ([Some(ijk), Some(_)], axis) = (cut.ends, cut.axis) else { return None };
        let pairs = self.placement.pairs();
        let mut around = [0.0; MOST];
        let around = &mut around[..2 * pairs];
        let first = ijk[axis] as isize + 1 - pairs as isize;
        line::values(around, first, self.view.dims()[axis], |i| {
            self.view.value(with(ijk, axis, i)) - self.field.iso
        });
        let curve = Curve::through(around)?;
        let delta = curve.crossing(delta(cut.values, self.field.iso));
        Some(Cut { delta: delta.clamp(-self.field.reach, self.field.reach), ..*cut })
    }

    /// The unit normal at a cut of a curve; where its samples tell none, that of a straight line.
    pub(super) fn normal_on_curve(&self, cut: &Cut) -> [f32; 3] {
        let curved = match self.placement {
            Placement::Quintic => self.curved_normal::<3>(cut),
            _ => self.curved_normal::<2>(cut),
        };
        curved.unwrap_or_else(|| self.normal(cut))
    }

    /// The unit normal at a cut of a curve: against the gradient, whose parts are differences of as high an
    /// order as the curve's at the samples around the edge, and between those what the curve through them
    /// is. None where one is not finite or all are 0.
    fn curved_normal<const PAIRS: usize>(&self, cut: &Cut) -> Option<[f32; 3]> {
        let ([Some(ijk), Some(_)], axis) = (cut.ends, cut.axis) else { return None };
        let (dims, weights) = (self.view.dims(), line::weights::<PAIRS>(cut.delta));
        let mut gradient = [0.0; 3];
        for (part, gradient) in gradient.iter_mut().enumerate() {
            let mut around = [[0.0; 2]; PAIRS];
            let around = around.as_flattened_mut();
            let first = ijk[axis] as isize + 1 - PAIRS as isize;
            line::values(around, first, dims[axis], |i| {
                let here = with(ijk, axis, i);
                let mut across = [0.0; MOST + 1];
                let across = &mut across[..=2 * PAIRS];
                let first = here[part] as isize - PAIRS as isize;
                line::values(across, first, dims[part], |j| {
                    self.view.stored(with(here, part, j)).to_f64()
                });
                line::slope(across)
            });
            *gradient = line::mean(around, &weights) * self.field.slope;
        }
        let is_finite = gradient.iter().all(|part| part.is_finite());
        is_finite.then(|| self.outward(gradient)).flatten()
    }
}

/// The same place but for one axis.
#[inline(always)]
fn with(mut ijk: [usize; 3], axis: usize, i: usize) -> [usize; 3] {
    ijk[axis] = i;
    ijk
}
