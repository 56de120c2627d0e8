//! Vertices on polynomials, and normals of as high an order.

use super::{Cut, Placer, curve::crossing, delta};
use crate::Placement;
use isokit_lanes::{Coordinate, Curve, Edges, OneByOne, Vertices, curved_vertices};
use isokit_volume::{Dtype, Sample, line};

/// The most samples on one line that a place depends on.
pub(super) const MOST: usize = 6;

impl<T: Sample> Placer<'_, T> {
    /// Places vertices on curves. A kernel does most; what it calls odd is done one by one.
    pub(super) fn place_curved<C: Coordinate>(
        &self,
        edges: &Edges,
        positions: &mut [[C; 3]],
        mut normals: Option<&mut [[f32; 3]]>,
        odd: &mut Vec<u32>,
    ) {
        let curve = match self.placement {
            Placement::Quintic => Curve::Quintic,
            _ => Curve::Cubic,
        };
        match &self.samples {
            Some(samples) => {
                let normals = normals.as_deref_mut();
                let out = Vertices { positions: &mut *positions, normals, odd: &mut *odd };
                let one_by_one = OfEdges { placer: self, edges };
                curved_vertices((samples, &self.field), curve, edges, &one_by_one, out);
            }
            None => odd.extend(0..edges.len() as u32),
        }
        for n in odd.iter().map(|&n| n as usize) {
            let (axis, low) = edges.get(n);
            let straight = self.cut(axis, low);
            let cut = self.curved(&straight).unwrap_or(straight);
            positions[n] = self.position(&cut);
            if let Some(normals) = &mut normals {
                normals[n] = self.normal_on_curve(&cut);
            }
        }
    }

    /// The cut of an edge by the polynomial through the samples around it, if there is one to be cut.
    pub(super) fn curved(&self, cut: &Cut) -> Option<Cut> {
        let ([Some(ijk), Some(_)], axis) = (cut.ends, cut.axis) else { return None };
        let mut around = [0.0; MOST];
        let around = &mut around[..2 * self.placement.pairs()];
        self.line(ijk, axis, around);
        let delta = crossing(around, delta(cut.values, self.field.iso))?;
        Some(Cut { delta: delta.clamp(-self.field.reach, self.field.reach), ..*cut })
    }

    /// The values around the edge from the sample `ijk` on along an axis, less the isovalue.
    fn line(&self, ijk: [usize; 3], axis: usize, around: &mut [f64]) {
        let first = ijk[axis] as isize + 1 - (around.len() / 2) as isize;
        line::values(around, first, self.view.dims()[axis], |i| {
            self.view.value(with(ijk, axis, i)) - self.field.iso
        });
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
                slope::<T>(across)
            });
            *gradient = line::mean(around, &weights) * self.field.slope;
        }
        let is_finite = gradient.iter().all(|part| part.is_finite());
        is_finite.then(|| self.outward(gradient)).flatten()
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
        self.placer.normal_on_curve(&Cut { delta, ..self.placer.cut(axis, low) })
    }
}

/// What [`line::slope`] gives of stored samples: in f32 for those that are f32, unless it overflows there.
/// Neighbours are subtracted without a loss where neither is twice the other (Sterbenz); elsewhere what is
/// lost is no more than the samples lost when they were rounded.
#[inline(always)]
fn slope<T: Sample>(values: &[f64]) -> f64 {
    if T::DTYPE == Dtype::F32 {
        let mut narrow = [0.0_f32; MOST + 1];
        for (narrow, &value) in narrow.iter_mut().zip(values) {
            *narrow = value as f32;
        }
        let slope = line::slope(&narrow[..values.len()]);
        if slope.is_finite() {
            return slope.into();
        }
    }
    line::slope(values)
}

/// The same place but for one axis.
#[inline(always)]
fn with(mut ijk: [usize; 3], axis: usize, i: usize) -> [usize; 3] {
    ijk[axis] = i;
    ijk
}
