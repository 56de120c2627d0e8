//! Normals from differences of the order of curves.
//!
//! `vertex/curved.rs` of `marching-cubes` has the definition, for one edge, with the same operations in the
//! same order, so that the bits are the same. Each part of the gradient is a sum of differences over two steps, four and
//! so on, at the samples around the edge on its line: for the part along the edge between samples that they share, for
//! those across between samples beside it. Differences are made in the type that holds samples exactly, and are f64 from
//! there on.
//!
//! They take their time: the rows `modes` of `scripts/bench` say how much on scans.

use super::{
    Room,
    copies::{Copies, count},
};
use crate::{
    Lane,
    vertices::{Kernel, curves::Crossing},
    wide::{BATCH, Exact, Float, Mask, Wide},
};
use std::ops::Range;

/// The range of a gradient's greatest part within which its square neither overflows nor vanishes.
const TAME: Range<f64> = 1e-120..1e120;

/// The most pairs of samples around an edge that a vertex depends on.
const MOST_PAIRS: usize = 3;

/// By pairs, less two: of the derivative times 12 or 60 the leading part and each correction, as shares of the
/// differences over two steps, four and six.
const SLOPES: [[[f64; MOST_PAIRS]; MOST_PAIRS]; 2] = [
    [[6.0, 0.0, 0.0], [2.0, -1.0, 0.0], [0.0; MOST_PAIRS]],
    [[30.0, 0.0, 0.0], [10.0, -5.0, 0.0], [5.0, -4.0, 1.0]],
];

impl<T: Lane> Kernel<'_, '_, T> {
    /// The normals of batches from edge `first` on, and the bits of those that are left.
    #[inline(always)]
    pub(super) fn turn<W: Wide, const PAIRS: usize, const LINE: usize, const COUNT: usize>(
        &self,
        wide: W,
        (first, crossings, left): (usize, &[Crossing], &mut [u16]),
        copies: &mut Copies<T>,
        mut room: Room<'_>,
    ) {
        const { assert!(LINE == 2 * (PAIRS + 1) && COUNT == count(PAIRS), "as many as steps") };
        assert!(copies.are_for(self.samples.strides(), PAIRS), "room for other samples");
        for (number, (crossing, left)) in crossings.iter().zip(left).enumerate() {
            let first = first + number * BATCH;
            let batch = self.ends(wide, first);
            let ends = [batch.low, batch.high];
            let is_inner = self.are_within(wide, ends, PAIRS as u32).bits() & batch.is_own;
            *left = !is_inner;
            if is_inner == 0 {
                continue;
            }
            // SAFETY: these edges are so far from the border, and the rest is asserted above.
            unsafe { copies.take::<COUNT>(self, first, is_inner) };
            let delta = wide.load_f64(&crossing.delta);
            let parts = Self::parts::<W, PAIRS, LINE>(wide, copies, delta);
            *left |= self.write_curved_normals(wide, batch.axis, parts, room.of(number));
        }
    }

    /// The parts of the gradients along the edges, and along the two axes that follow, from the samples around the
    /// edges of a batch: `LINE` of them on their lines.
    #[inline(always)]
    fn parts<W: Wide, const PAIRS: usize, const LINE: usize>(
        wide: W,
        copies: &Copies<T>,
        delta: W::F64,
    ) -> [W::F64; 3] {
        let mut line = [T::Exact::splat(wide, 0.0); LINE];
        for (place, sample) in line.iter_mut().enumerate() {
            *sample = copies.at(wide, place);
        }
        // Those beside the lines follow in this order.
        let mut next = LINE;
        let weights = slope_weights::<W, PAIRS>(wide, delta);
        let mut parts = [wide.f64(0.0); 3];
        for (part, sum) in parts.iter_mut().enumerate() {
            for (n, weights) in weights.iter().enumerate() {
                let mut mean = *sum;
                for (pair, weights) in weights[..PAIRS - n].iter().enumerate() {
                    let mut both = [*sum; 2];
                    for (side, both) in both.iter_mut().enumerate() {
                        let middle = [PAIRS - pair, PAIRS + 1 + pair][side];
                        let [below, above] = match part {
                            0 => [line[middle - n - 1], line[middle + n + 1]],
                            _ => {
                                next += 2;
                                [copies.at(wide, next - 2), copies.at(wide, next - 1)]
                            }
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
fn weights<W: Wide>(wide: W, pairs: usize, s: W::F64) -> [[W::F64; 2]; MOST_PAIRS] {
    let mut weights = [[s; 2]; MOST_PAIRS];
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
