//! Where edges are crossed by cubics, 16 edges at a time.
//!
//! Three loops take turns over some batches at a time: one loads the samples on the lines of the edges, the
//! second finds roots ([`roots`](super::roots)), the third makes places. Each is short, so that the machine
//! works at several batches at once while one waits, and only the first is compiled for each type of sample.
//!
//! Edges that are not between inner samples, that have values which are not finite, or a root that is hard
//! to find, are called odd and left to the caller.

use super::{
    Batch, Field, Kernel,
    roots::Roots,
    wide::{BATCH, Task, Wide, run_at},
};
use crate::{Coordinate, Edges, Lane, Level, Samples};

#[cfg(test)]
mod tests;

/// Batches that are worked at in turn, an even number: what is known of them stays in the first cache.
const TURN: usize = 16;

/// Where vertices on cubics go.
#[derive(Debug)]
pub struct Crossings<'a, C> {
    /// Places in world space.
    pub positions: &'a mut [[C; 3]],
    /// The same in edge lengths from the middle of the edge, if somebody wants them.
    pub deltas: Option<&'a mut [f64]>,
    /// The numbers of the odd edges are added here: those have yet to be placed.
    pub odd: &'a mut Vec<u32>,
}

/// Places vertices where the cubic through the four samples nearest on the line of an edge has the isovalue;
/// where the cubic rings, where the straight line has it.
///
/// # Panics
///
/// If `out` has not room for exactly one vertex per edge.
pub fn cubic_crossings<T: Lane, C: Coordinate>(
    samples: &Samples<'_, T>,
    field: &Field,
    edges: &Edges,
    out: Crossings<'_, C>,
) {
    cubic_crossings_at(Level::current(), samples, field, edges, out);
}

fn cubic_crossings_at<T: Lane, C: Coordinate>(
    level: Level,
    samples: &Samples<'_, T>,
    field: &Field,
    edges: &Edges,
    Crossings { positions, mut deltas, odd }: Crossings<'_, C>,
) {
    assert_eq!(positions.len(), edges.len(), "room for every vertex");
    if let Some(deltas) = &deltas {
        assert_eq!(deltas.len(), edges.len(), "room for every vertex");
    }
    let kernel = Kernel { samples, field, directions: [[0.0; 3]; 3], edges };
    let mut lines = [const { Line::DEFAULT }; TURN];
    for (turn, positions) in positions.chunks_mut(TURN * BATCH).enumerate() {
        let (first, count) = (turn * TURN * BATCH, positions.len());
        let batches = count.div_ceil(BATCH);
        run_at(level, Loading { kernel: &kernel, first, lines: &mut lines[..batches] });
        // Two by two; what is left over of the turn before does no harm.
        let (pairs, _) = lines.as_chunks_mut();
        run_at(level, Roots { lines: &mut pairs[..batches.div_ceil(2)], reach: field.reach });
        let lines = &lines[..batches];
        run_at(level, Placing { field, edges, first, lines, positions });
        for (number, line) in lines.iter().enumerate() {
            let at = number * BATCH;
            let own = BATCH.min(count - at);
            if let Some(deltas) = &mut deltas {
                deltas[first + at..][..own].copy_from_slice(&line.delta[..own]);
            }
            // The last batch may have fewer edges than it has numbers.
            let mut left = line.is_odd & (u16::MAX >> (BATCH - own));
            while left != 0 {
                odd.push((first + at) as u32 + left.trailing_zeros());
                left &= left - 1;
            }
        }
    }
}

/// What is known of a batch of edges.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Line {
    /// The samples on the line of each edge, less the isovalue: that before the lower end, the ends, and
    /// that after the upper end.
    pub(super) values: [[f64; BATCH]; 4],
    /// Where each is crossed, in edge lengths from its middle.
    pub(super) delta: [f64; BATCH],
    /// Which are odd.
    pub(super) is_odd: u16,
}

impl Line {
    const DEFAULT: Self = Self { values: [[0.0; BATCH]; 4], delta: [0.0; BATCH], is_odd: 0 };
}

/// Loads the values of the batches from edge `first` on.
struct Loading<'l, 'b, 'a, T> {
    kernel: &'l Kernel<'b, 'a, T>,
    first: usize,
    lines: &'l mut [Line],
}

impl<T: Lane> Task for Loading<'_, '_, '_, T> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        for (number, line) in self.lines.iter_mut().enumerate() {
            let first = self.first + number * BATCH;
            line.is_odd = self.kernel.load(wide, first, &mut line.values);
        }
    }
}

/// Makes the places of the batches from edge `first` on.
struct Placing<'l, C> {
    field: &'l Field,
    edges: &'l Edges,
    first: usize,
    lines: &'l [Line],
    positions: &'l mut [[C; 3]],
}

impl<C: Coordinate> Task for Placing<'_, C> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let z = wide.u32(self.edges.z());
        for (number, line) in self.lines.iter().enumerate() {
            let [axis, x, y] = self.edges.batch(self.first + number * BATCH);
            let low = [wide.load(x), wide.load(y), z];
            let delta = wide.load_f64(&line.delta);
            let places = self.field.places(wide, wide.load(axis), low, delta);
            let out = &mut self.positions[number * BATCH..];
            match out.first_chunk_mut() {
                Some(out) => C::write(wide, places, out),
                None => {
                    let mut all = [[C::default(); 3]; BATCH];
                    C::write(wide, places, &mut all);
                    out.copy_from_slice(&all[..out.len()]);
                }
            }
        }
    }
}

impl<T: Lane> Kernel<'_, '_, T> {
    /// Loads the values around the batch that begins with edge `first`; the bits of those that are odd, which
    /// have others.
    #[inline(always)]
    fn load<W: Wide>(&self, wide: W, first: usize, values: &mut [[f64; BATCH]; 4]) -> u16 {
        if !self.samples.is_near(2) {
            return u16::MAX;
        }
        let mut batch = self.ends(wide, first);
        let is_outer = if batch.is_inner { 0 } else { self.keep_inner(wide, &mut batch) };
        if is_outer == u16::MAX {
            return u16::MAX;
        }
        let strides = self.samples.strides();
        // Numbers fit, as `is_near` says, and wrap to what they are.
        let steps = [wide.u32(strides[0] as u32), wide.u32(strides[1] as u32)];
        let mut step = wide.u32(strides[2] as u32);
        step = wide.select(wide.equal(batch.axis, wide.u32(1)), steps[1], step);
        step = wide.select(wide.equal(batch.axis, wide.u32(0)), steps[0], step);
        let low = batch.low[0] * steps[0] + batch.low[1] * steps[1];
        let slice = self.samples.first() + i64::from(self.edges.z()) * strides[2];
        let mut number = low + step * wide.u32(u32::MAX);
        for value in values {
            // SAFETY: both ends of the edges that are left are samples that have both neighbours along every
            // axis, so each of the four is there and has them across the edge. The farthest is two slices
            // away.
            let sample = unsafe { wide.near(self.samples, slice, number) };
            wide.store_f64(self.above_iso(wide, sample), value);
            number = number + step;
        }
        is_outer
    }

    /// Puts an edge that is an inner one in the place of those that are not; the bits of those.
    #[inline(always)]
    fn keep_inner<W: Wide>(&self, wide: W, batch: &mut Batch<W>) -> u16 {
        let mut is_inner = u16::MAX;
        for along in 0..3 {
            // No size exceeds 2³¹ − 1, so a wrapped −1 is beyond all of them.
            let within = wide.u32(self.samples.dims()[along].saturating_sub(2));
            for end in [batch.low[along], batch.high[along]] {
                is_inner &= wide.less(end + wide.u32(u32::MAX), within);
            }
        }
        if is_inner != 0 {
            let kept = is_inner.trailing_zeros() as usize;
            let [low, high] = [&mut batch.low, &mut batch.high];
            for numbers in low.iter_mut().chain(high).chain([&mut batch.axis]) {
                *numbers = wide.select(is_inner, *numbers, wide.u32(wide.store(*numbers)[kept]));
            }
        }
        !is_inner
    }
}
