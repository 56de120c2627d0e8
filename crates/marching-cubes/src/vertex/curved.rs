//! Vertices on polynomials, and normals of as high an order where they are asked for.

use super::{Cut, Placer, curve::crossing, delta};
use crate::Gradient;
use isokit_lanes::{
    self as lanes, Coordinate, Curve, Edges, OneByOne, Samples, Vertices, curved_vertices,
};
use isokit_volume::{Dtype, Sample, line};

/// The most samples on one line that a place depends on.
pub(super) const MOST: usize = 6;

impl<T: Sample> Placer<'_, T> {
    /// Places vertices on curves, but for odd ones.
    pub(super) fn place_curved<C: Coordinate>(
        &self,
        samples: &Samples<'_, T>,
        curve: Curve,
        edges: &Edges,
        out: Vertices<'_, C>,
    ) {
        let gradient = match self.gradient {
            Gradient::Central => lanes::Gradient::Central,
            Gradient::Matching => lanes::Gradient::Matching,
        };
        let one_by_one = OfEdges { placer: self, edges };
        curved_vertices((samples, &self.field), (curve, gradient), edges, &one_by_one, out);
    }

    /// The cut of an edge by the polynomial through the samples around it, if there is one to be cut; for
    /// coordinates of a type.
    pub(super) fn curved<C: Coordinate>(&self, cut: &Cut) -> Option<Cut> {
        let ([Some(ijk), Some(_)], axis) = (cut.ends, cut.axis) else { return None };
        let mut around = [0.0; MOST];
        let around = &mut around[..2 * self.placement.pairs()];
        self.line(ijk, axis, around);
        let delta = crossing::<C>(around, delta(cut.values, self.field.iso))?;
        Some(Cut { delta: delta.clamp(-self.field.reach, self.field.reach), ..*cut })
    }

    /// The values around the edge from the sample `ijk` on along an axis, less the isovalue.
    fn line(&self, ijk: [usize; 3], axis: usize, around: &mut [f64]) {
        let first = ijk[axis] as isize + 1 - (around.len() / 2) as isize;
        line::values(around, first, self.view.dims()[axis], |i| {
            self.view.value(with(ijk, axis, i)) - self.field.iso
        });
    }

    /// The unit normal at a cut of a curve: against the gradient, whose parts are sums of differences to as high an
    /// order as the curve's ([`line::slope_weights`]). None where one is not finite or all are 0.
    pub(super) fn curved_normal<const PAIRS: usize>(&self, cut: &Cut) -> Option<[f32; 3]> {
        let ([Some(ijk), Some(_)], axis) = (cut.ends, cut.axis) else { return None };
        let (size, weights) = (self.view.dims()[axis], line::slope_weights::<PAIRS>(cut.delta));
        // What `line::values` may ask for: those around the edge; near a border as many of the nearest; on a short line all.
        let (after, held) = (ijk[axis] + 1, size.min(2 * PAIRS));
        let first = after.saturating_sub(PAIRS).min(size - held);
        let mut gradient = [0.0; 3];
        for (part, gradient) in gradient.iter_mut().enumerate() {
            let mut differences = [[0.0; PAIRS]; MOST];
            for (i, differences) in (first..).zip(&mut differences[..held]) {
                *differences = self.differences(with(ijk, axis, i), part);
            }
            for (n, weights) in weights.iter().enumerate() {
                let pairs = PAIRS - n;
                // Where a stencil leaves the lattice all differences are continued from as many samples as
                // those over two steps: what that gets wrong then cancels in a correction.
                let is_within = after >= pairs && after + pairs <= size;
                let reach = if is_within { pairs } else { PAIRS };
                let mut around = [0.0; MOST];
                let around = &mut around[..2 * reach];
                line::values(around, after as isize - reach as isize, size, |i| {
                    differences[i - first][n]
                });
                let mean = line::mean(&around[reach - pairs..reach + pairs], &weights[..pairs]);
                *gradient = if n == 0 { mean } else { *gradient + mean };
            }
            *gradient *= self.field.slope;
        }
        let is_finite = gradient.iter().all(|part| part.is_finite());
        is_finite.then(|| self.outward(gradient)).flatten()
    }

    /// By how much the stored sample one step above exceeds the one as far below, then two steps, up to as many as there
    /// are pairs. Beyond the border the line is continued. In f32 for those that are f32, unless it overflows there:
    /// neighbours are subtracted without a loss where neither is twice the other (Sterbenz); elsewhere what is lost
    /// is no more than the samples lost when they were rounded.
    fn differences<const PAIRS: usize>(&self, here: [usize; 3], part: usize) -> [f64; PAIRS] {
        let (at, size) = (here[part], self.view.dims()[part]);
        let mut across = [0.0; MOST + 1];
        line::values(&mut across[..=2 * PAIRS], at as isize - PAIRS as isize, size, |i| {
            self.view.stored(with(here, part, i)).to_f64()
        });
        std::array::from_fn(|n| {
            let (below, above) = (across[PAIRS - n - 1], across[PAIRS + n + 1]);
            let narrow = above as f32 - below as f32;
            match T::DTYPE == Dtype::F32 && narrow.is_finite() {
                true => narrow.into(),
                false => above - below,
            }
        })
    }
}

/// What a placer knows of the edges in a queue.
struct OfEdges<'e, 'a, T> {
    placer: &'e Placer<'a, T>,
    edges: &'e Edges,
}

impl<T: Sample> OneByOne for OfEdges<'_, '_, T> {
    fn line(&self, edge: usize, values: &mut [f64]) -> bool {
        let (axis, low) = self.edges.get(edge);
        let (dims, low) = (self.placer.view.dims(), low.map(|i| i as usize));
        let is_within = (0..3).all(|k| low[k] + usize::from(k == axis) < dims[k]);
        if is_within {
            self.placer.line(low, axis, values);
        }
        is_within
    }

    fn normal(&self, edge: usize, delta: f64) -> [f32; 3] {
        let (axis, low) = self.edges.get(edge);
        self.placer.normal(&Cut { delta, ..self.placer.cut(axis, low) })
    }
}

/// The same place but for one axis.
#[inline(always)]
fn with(mut ijk: [usize; 3], axis: usize, i: usize) -> [usize; 3] {
    ijk[axis] = i;
    ijk
}
