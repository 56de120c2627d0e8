//! Normals on curves, 16 edges at a time: from central differences, or from those of the curve's order.
//!
//! Central ones are made as on straight lines (`vertices.rs`), of differences that came with the samples on the lines. Of
//! the others `vertex/curved.rs` of `marching-cubes` has the definition, for one edge, with the same operations in the
//! same order, so that the bits are the same. Each part of the gradient is a sum of differences over two steps, four and
//! so on, at the samples around the edge on its line: for the part along the edge between samples that they share, for
//! those across between samples beside it. Differences are made in the type that holds samples exactly, and are f64 from
//! there on.
//!
//! They take their time: the rows `modes` of `scripts/bench` say how much on scans.

use super::{
    AHEAD, Kernel,
    curves::{Differences, Line, Stencil},
};
use crate::{
    Lane,
    prefetch::prefetch_beyond,
    wide::{BATCH, Exact, Float, Mask, Task, Wide},
};
use std::ops::Range;

/// The range of a gradient's greatest part within which its square neither overflows nor vanishes.
const TAME: Range<f64> = 1e-120..1e120;

/// The most pairs of samples around an edge that a vertex depends on.
const MOST: usize = 3;

/// By pairs, less two: of the derivative times 12 or 60 the leading part and each correction, as shares of the
/// differences over two steps, four and six.
const SLOPES: [[[f64; MOST]; MOST]; 2] = [
    [[6.0, 0.0, 0.0], [2.0, -1.0, 0.0], [0.0; MOST]],
    [[30.0, 0.0, 0.0], [10.0, -5.0, 0.0], [5.0, -4.0, 1.0]],
];

/// Makes the normals of the batches from edge `first` on, where their lines are crossed. Those that are no unit
/// vector are left; matching ones also of edges so near to the border that a slope is one-sided.
pub struct Normals<'l, 'b, 'a, T> {
    pub(super) kernel: &'l Kernel<'b, 'a, T>,
    pub(super) first: usize,
    /// The differences that central gradients are made from; `None` for matching ones.
    pub(super) around: Option<&'l [Differences]>,
    /// The samples to either side of one that a matching slope is made from, 2 or 3: as many pairs around an edge too.
    pub(super) pairs: usize,
    pub(super) lines: &'l [Line],
    /// Where normals go, and the bits of those that are left, by batches.
    pub(super) to: (&'l mut [[f32; 3]], &'l mut [u16]),
}

impl<T: Lane> Task for Normals<'_, '_, '_, T> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Self { kernel, first, around, pairs, lines, to: (normals, left) } = self;
        let mut directions = [[0.0; 3]; BATCH];
        for (number, normals) in normals.chunks_mut(BATCH).enumerate() {
            prefetch_beyond::<AHEAD, _>(normals);
            let delta = wide.load_f64(&lines[number].delta);
            left[number] = match around {
                Some(around) => kernel.mix(wide, &around[number], delta, &mut directions),
                None => {
                    let first = first + number * BATCH;
                    kernel.turn(wide, first, pairs, delta, &mut directions)
                }
            };
            // The last batch may have less room than it has numbers.
            normals.copy_from_slice(&directions[..normals.len()]);
        }
    }
}

impl<T: Lane> Kernel<'_, '_, T> {
    /// Normals from differences over two steps at both ends of each edge; the bits of those that are left.
    #[inline(always)]
    fn mix<W: Wide>(
        &self,
        wide: W,
        around: &Differences,
        delta: W::F64,
        normals: &mut [[f32; 3]; BATCH],
    ) -> u16 {
        let share = wide.f64_to_f32(wide.f64(0.5) + delta);
        self.write_normals(wide, around.load(wide), share, normals)
    }

    /// The normals of the batch that begins with edge `first`, of the curve's order; the bits of those that are left.
    #[inline(always)]
    fn turn<W: Wide>(
        &self,
        wide: W,
        first: usize,
        pairs: usize,
        delta: W::F64,
        normals: &mut [[f32; 3]; BATCH],
    ) -> u16 {
        if !self.samples.is_near(pairs as i64 + 1) {
            return u16::MAX;
        }
        let batch = self.ends(wide, first);
        let is_inner = self.are_within(wide, [batch.low, batch.high], pairs as u32).bits();
        if is_inner == 0 {
            return u16::MAX;
        }
        let batch = batch.keeping(wide, is_inner);
        let stencil = self.stencil(wide, &batch);
        // SAFETY: the edges that are left are so far from the border, and the farthest samples no more
        // slices away.
        let parts = unsafe {
            match pairs {
                2 => self.parts::<W, 2, 6>(wide, &stencil, delta),
                _ => self.parts::<W, 3, 8>(wide, &stencil, delta),
            }
        };
        !is_inner | self.write_curved_normals(wide, batch.axis, parts, normals)
    }

    /// The parts of the gradients along the edges, and along the two axes that follow, from so many pairs of
    /// samples around each edge, and `LINE` samples on its line: one more on either side.
    ///
    /// # Safety
    ///
    /// Beyond both ends of each edge there must be as many samples to all sides as there are pairs.
    /// [`Samples::is_near`](crate::Samples) must hold for one more.
    #[inline(always)]
    unsafe fn parts<W: Wide, const PAIRS: usize, const LINE: usize>(
        &self,
        wide: W,
        stencil: &Stencil<W>,
        delta: W::F64,
    ) -> [W::F64; 3] {
        let Stencil { slice, low, steps } = *stencil;
        let back = wide.u32(u32::MAX);
        let zero = T::Exact::splat(wide, 0.0);
        // From so many before the lower end as there are pairs.
        let mut number = low + steps[0] * wide.u32((PAIRS as u32).wrapping_neg());
        let (mut numbers, mut line) = ([number; LINE], [zero; LINE]);
        for (to, sample) in numbers.iter_mut().zip(&mut line) {
            *to = number;
            // SAFETY: samples along the edge so far beyond its ends are there, and have both neighbours to all
            // other sides.
            *sample = unsafe { wide.near(self.samples, slice, number) };
            number = number + steps[0];
        }
        let weights = slope_weights::<W, PAIRS>(wide, delta);
        let mut parts = [wide.f64(0.0); 3];
        for (part, sum) in parts.iter_mut().enumerate() {
            let (step, mut aside) = (steps[part], [wide.u32(0); 2]);
            for (n, weights) in weights.iter().enumerate() {
                aside = [aside[0] + step * back, aside[1] + step];
                let mut mean = *sum;
                for (pair, weights) in weights[..PAIRS - n].iter().enumerate() {
                    let mut both = [*sum; 2];
                    for (side, both) in both.iter_mut().enumerate() {
                        let middle = [PAIRS - pair, PAIRS + 1 + pair][side];
                        let [below, above] = match part {
                            0 => [line[middle - n - 1], line[middle + n + 1]],
                            // SAFETY: samples so far to this side are there. They have both neighbours along
                            // the edge, where more lie beyond, and along the third axis.
                            _ => unsafe {
                                [
                                    wide.near(self.samples, slice, numbers[middle] + aside[0]),
                                    wide.near(self.samples, slice, numbers[middle] + aside[1]),
                                ]
                            },
                        };
                        let difference = T::Exact::to_f64(wide, above - below);
                        *both = difference * weights[side];
                    }
                    let both = both[0] + both[1];
                    mean = if pair == 0 { both } else { mean + both };
                }
                *sum = if n == 0 { mean } else { *sum + mean };
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
        !(is_tame & square.less(wide.f64(f64::INFINITY))).bits()
    }
}

/// The weights of differences in the derivative, so many edge lengths from the middle of an edge, as `line.rs` of
/// `volume` has them.
#[inline(always)]
fn slope_weights<W: Wide, const PAIRS: usize>(wide: W, s: W::F64) -> [[[W::F64; 2]; PAIRS]; PAIRS] {
    const { assert!(PAIRS == 2 || PAIRS == 3, "two pairs or three") };
    let mut sums = [[[wide.f64(0.0); 2]; PAIRS]; PAIRS];
    for (level, shares) in SLOPES[PAIRS - 2][..PAIRS].iter().enumerate() {
        let weights = weights(wide, PAIRS - level, s);
        for (sums, &share) in sums.iter_mut().zip(shares).take(level + 1) {
            let share = wide.f64(share);
            for (sum, weights) in sums.iter_mut().zip(weights).take(PAIRS - level) {
                *sum = [sum[0] + share * weights[0], sum[1] + share * weights[1]];
            }
        }
    }
    sums
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
