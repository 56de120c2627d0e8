//! Normals from differences of a high order, 16 edges at a time.
//!
//! `vertex/curved.rs` of `marching-cubes` has the definition, for one edge, with the same operations in the same
//! order, so that the bits are the same. Each part of the gradient is made from slopes at the samples around
//! the edge on its line: the part along the edge from samples that slopes share, those across from samples
//! beside it. Slopes are made in the type that holds samples exactly, and are f64 from there on.

use super::{
    Batch, Kernel,
    curves::{Line, Stencil},
    wide::{BATCH, Exact, Float, Task, Wide},
};
use crate::Lane;
use std::ops::Range;

/// The range of a gradient's greatest part within which its square neither overflows nor vanishes.
const TAME: Range<f64> = 1e-120..1e120;

/// The most pairs of samples around an edge that a vertex depends on.
const MOST: usize = 3;

/// The weights of differences between samples one step to either side, two and so on, in the derivative times
/// 12 or 60.
const SLOPES: [&[f32]; MOST] = [&[], &[8.0, -1.0], &[45.0, -9.0, 1.0]];

/// Makes the normals of the batches from edge `first` on, where their lines are crossed. Those of edges so near
/// to the border that a slope is one-sided are left, and those that are no unit vector.
pub(super) struct Turning<'l, 'b, 'a, T> {
    pub(super) kernel: &'l Kernel<'b, 'a, T>,
    pub(super) first: usize,
    /// The samples to either side of one that a slope is made from, 2 or 3: as many pairs around an edge too.
    pub(super) pairs: usize,
    pub(super) lines: &'l [Line],
    pub(super) normals: &'l mut [[f32; 3]],
    /// The bits of those that are left, by batches.
    pub(super) left: &'l mut [u16],
}

impl<T: Lane> Task for Turning<'_, '_, '_, T> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Self { kernel, first, pairs, lines, normals, left } = self;
        let mut directions = [[0.0; 3]; BATCH];
        for (number, normals) in normals.chunks_mut(BATCH).enumerate() {
            let first = first + number * BATCH;
            let delta = wide.load_f64(&lines[number].delta);
            left[number] = kernel.turn(wide, first, pairs, delta, &mut directions);
            // The last batch may have less room than it has numbers.
            normals.copy_from_slice(&directions[..normals.len()]);
        }
    }
}

impl<T: Lane> Kernel<'_, '_, T> {
    /// The normals of the batch that begins with edge `first`; the bits of those that are left.
    #[inline(always)]
    fn turn<W: Wide>(
        &self,
        wide: W,
        first: usize,
        pairs: usize,
        delta: W::F64,
        normals: &mut [[f32; 3]; BATCH],
    ) -> u16 {
        if !self.samples.is_near(2 * pairs as i64) {
            return u16::MAX;
        }
        let mut batch = self.ends(wide, first);
        let (along, across) = (2 * pairs as u32 - 1, pairs as u32);
        let is_left = self.keep_inner(wide, &mut batch, along, across);
        if is_left == u16::MAX {
            return u16::MAX;
        }
        let stencil = self.stencil(wide, &batch);
        // SAFETY: the edges that are left are so far from the border, and the farthest samples no more
        // slices away.
        let parts = unsafe { self.parts(wide, &stencil, pairs, delta) };
        is_left | self.write_curved_normals(wide, batch.axis, parts, normals)
    }

    /// Puts an edge that is an inner one in the place of those that are not; the bits of those. Of an inner
    /// one both ends are so far from the border along its axis, and across.
    #[inline(always)]
    fn keep_inner<W: Wide>(&self, wide: W, batch: &mut Batch<W>, along: u32, across: u32) -> u16 {
        let mut is_inner = u16::MAX;
        for axis in 0..3 {
            // No size exceeds 2³¹ − 1, so a wrapped −1 is beyond all of them, and −5 too.
            let size = self.samples.dims()[axis];
            let is_along = wide.equal(batch.axis, wide.u32(axis as u32));
            for (margin, is_concerned) in [(along, is_along), (across, !is_along)] {
                let less = wide.u32(margin.wrapping_neg());
                let within = wide.u32(size.saturating_sub(2 * margin));
                for end in [batch.low[axis], batch.high[axis]] {
                    is_inner &= wide.less(end + less, within) | !is_concerned;
                }
            }
        }
        if is_inner != 0 && is_inner != u16::MAX {
            let kept = is_inner.trailing_zeros() as usize;
            for numbers in batch.low.iter_mut().chain([&mut batch.axis]) {
                *numbers = wide.select(is_inner, *numbers, wide.u32(wide.store(*numbers)[kept]));
            }
        }
        !is_inner
    }

    /// The parts of the gradients along the edges, and along the two axes that follow, from so many pairs of
    /// samples around each edge. How many is known when it runs, so that gathers are not written out for each.
    ///
    /// # Safety
    ///
    /// Beyond both ends of each edge there must be samples: along it twice the pairs less one, and to all
    /// other sides as many as there are pairs. [`Samples::is_near`](crate::Samples) must hold for twice
    /// the pairs.
    #[inline(always)]
    unsafe fn parts<W: Wide>(
        &self,
        wide: W,
        stencil: &Stencil<W>,
        pairs: usize,
        delta: W::F64,
    ) -> [W::F64; 3] {
        let Stencil { slice, low, steps } = *stencil;
        // From 2 · pairs − 1 before the lower end.
        let first = low + steps[0] * wide.u32((2 * pairs - 1).wrapping_neg() as u32);
        let (mut numbers, mut line) = ([first; 4 * MOST], [T::Exact::splat(wide, 0.0); 4 * MOST]);
        let mut number = first;
        for (to, sample) in numbers.iter_mut().zip(&mut line).take(4 * pairs) {
            *to = number;
            // SAFETY: samples along the edge so far beyond its ends are there, and have both neighbours to all
            // other sides.
            *sample = unsafe { wide.near(self.samples, slice, number) };
            number = number + steps[0];
        }
        let weights = weights(wide, pairs, delta);
        let mut parts = [wide.f64(0.0); 3];
        for (part, sum) in parts.iter_mut().enumerate() {
            let mut slopes = [*sum; 2 * MOST];
            for (n, to) in slopes[..2 * pairs].iter_mut().enumerate() {
                let middle = pairs + n;
                let mut slope = T::Exact::splat(wide, 0.0);
                let mut beside = [numbers[middle]; 2];
                for (apart, &weight) in (1..).zip(SLOPES[pairs - 1]) {
                    let [below, above] = match part {
                        0 => [line[middle - apart], line[middle + apart]],
                        _ => {
                            let step = steps[part];
                            beside = [beside[0] + step * wide.u32(u32::MAX), beside[1] + step];
                            // SAFETY: samples so far to this side are there. They have both neighbours along
                            // the edge, where more lie beyond, and along the third axis.
                            unsafe {
                                [
                                    wide.near(self.samples, slice, beside[0]),
                                    wide.near(self.samples, slice, beside[1]),
                                ]
                            }
                        }
                    };
                    slope = slope + T::Exact::splat(wide, weight) * (above - below);
                }
                *to = T::Exact::to_f64(wide, slope);
            }
            for (pair, weights) in weights[..pairs].iter().enumerate() {
                let [below, above] = [slopes[pairs - 1 - pair], slopes[pairs + pair]];
                let both = below * weights[0] + above * weights[1];
                *sum = if pair == 0 { both } else { *sum + both };
            }
        }
        parts
    }

    /// The normals against gradients by their parts along edges; the bits of those that are left.
    #[inline(always)]
    fn write_curved_normals<W: Wide>(
        &self,
        wide: W,
        axis: W::U32,
        parts: [W::F64; 3],
        out: &mut [[f32; 3]; BATCH],
    ) -> u16 {
        let columns = &self.field.covectors;
        let mut gradient = parts;
        for (along, part) in gradient.iter_mut().enumerate() {
            let is_first = wide.equal(axis, wide.u32(along as u32));
            let is_second = wide.equal(axis, wide.u32((along as u32 + 2) % 3));
            *part = wide.select_f64(is_second, parts[1], parts[2]);
            *part = wide.select_f64(is_first, parts[0], *part) * wide.f64(self.field.slope);
        }
        let (mut world, mut greatest) = (gradient, wide.f64(0.0));
        for k in 0..3 {
            let x_y = wide.f64(columns[0][k]) * gradient[0] + wide.f64(columns[1][k]) * gradient[1];
            world[k] = x_y + wide.f64(columns[2][k]) * gradient[2];
            greatest = greatest.max(world[k].abs());
        }
        let square = world[0] * world[0] + world[1] * world[1] + world[2] * world[2];
        let outward = wide.f64(-1.0) / square.sqrt();
        let mut normal = [wide.f32(0.0); 3];
        for (part, world) in normal.iter_mut().zip(world) {
            *part = wide.f64_to_f32(world * outward);
        }
        wide.interleave(normal, out);
        let is_tame = greatest.less(wide.f64(TAME.end)) & !greatest.less(wide.f64(TAME.start));
        // A part that is NaN may hide behind the greatest of the others, not in the sum of squares.
        !(is_tame & square.less(wide.f64(f64::INFINITY)))
    }
}

/// The weights of pairs of values around an edge in what the polynomial through all of them is, so many edge
/// lengths from its middle.
#[inline(always)]
fn weights<W: Wide>(wide: W, pairs: usize, s: W::F64) -> [[W::F64; 2]; MOST] {
    let mut weights = [[s; 2]; MOST];
    for (pair, weights) in weights[..pairs].iter_mut().enumerate() {
        let place = pair as f64 + 0.5;
        let mut weight = wide.f64(0.5 / place);
        for other in (0..pairs).filter(|&other| other != pair) {
            let (own, other) = (place * place, (other as f64 + 0.5) * (other as f64 + 0.5));
            weight = weight * ((s * s - wide.f64(other)) * wide.f64(1.0 / (own - other)));
        }
        *weights = [weight * (wide.f64(place) - s), weight * (wide.f64(place) + s)];
    }
    weights
}
