//! Where edges are crossed by cubics, 16 edges at a time.
//!
//! Loops take turns over some batches at a time: one loads the samples on the lines of the edges, the second
//! finds roots (`roots.rs`), the third makes places, and a fourth normals (`slopes.rs`), if they are wanted. Each
//! is short, so that the machine works at several batches at once while one waits, and only the first and the
//! last are compiled for each type of sample.
//!
//! The caller tells the values of lines that leave the lattice, and the normals near its border. Edges that have
//! none, that have values which are not finite, or a root that is hard to find, are called odd and left to
//! the caller.

use super::{
    Batch, Field, Kernel, Vertices,
    roots::Roots,
    slopes::Turning,
    wide::{BATCH, Task, Wide, run_at},
};
use crate::{Coordinate, Edges, Lane, Level, Samples};

#[cfg(test)]
mod tests;

/// Batches that are worked at in turn, an even number: what is known of them stays in the first cache.
const TURN: usize = 8;

/// Samples to either side of an edge's middle, and of one that a slope is made from.
const PAIRS: usize = 2;

/// What the caller tells of edges, by their number, where samples that a stencil asks for are missing.
pub trait OneByOne {
    /// The four values on the line of an edge, less the isovalue: that before the lower end, the ends, and that
    /// after the upper end. None if the ends are not both samples.
    fn line(&self, edge: usize) -> Option<[f64; 4]>;

    /// The normal so many edge lengths from the middle of an edge.
    fn normal(&self, edge: usize, delta: f64) -> [f32; 3];
}

/// Places vertices where the cubic through the four samples nearest on the line of an edge has the isovalue;
/// where the cubic rings, where the straight line has it. Normals are those of differences of order four.
///
/// # Panics
///
/// If `out` has not room for exactly one vertex per edge.
pub fn cubic_vertices<T: Lane, C: Coordinate>(
    samples: &Samples<'_, T>,
    field: &Field,
    edges: &Edges,
    one_by_one: &dyn OneByOne,
    out: Vertices<'_, C>,
) {
    cubic_vertices_at(Level::current(), samples, field, edges, one_by_one, out);
}

fn cubic_vertices_at<T: Lane, C: Coordinate>(
    level: Level,
    samples: &Samples<'_, T>,
    field: &Field,
    edges: &Edges,
    one_by_one: &dyn OneByOne,
    Vertices { positions, mut normals, odd }: Vertices<'_, C>,
) {
    assert_eq!(positions.len(), edges.len(), "room for every vertex");
    if let Some(normals) = &normals {
        assert_eq!(normals.len(), edges.len(), "room for every normal");
    }
    let kernel = Kernel { samples, field, directions: [[0.0; 3]; 3], edges };
    let mut lines = [const { Line::DEFAULT }; TURN];
    for (turn, positions) in positions.chunks_mut(TURN * BATCH).enumerate() {
        let (first, count) = (turn * TURN * BATCH, positions.len());
        let batches = count.div_ceil(BATCH);
        run_at(level, Loading { kernel: &kernel, first, lines: &mut lines[..batches] });
        for (number, line) in lines[..batches].iter_mut().enumerate() {
            let at = number * BATCH;
            for n in set_bits(line.is_odd, count - at) {
                if let Some(values) = one_by_one.line(first + at + n) {
                    line.is_odd ^= 1 << n;
                    (0..4).for_each(|k| line.values[k][n] = values[k]);
                }
            }
        }
        // Two by two; what is left over of the turn before does no harm.
        let (pairs, _) = lines.as_chunks_mut();
        run_at(level, Roots { lines: &mut pairs[..batches.div_ceil(2)], reach: field.reach });
        let lines = &lines[..batches];
        run_at(level, Placing { field, edges, first, lines, positions });
        for (number, line) in lines.iter().enumerate() {
            let at = first + number * BATCH;
            odd.extend(set_bits(line.is_odd, edges.len() - at).map(|n| (at + n) as u32));
        }
        let Some(normals) = &mut normals else { continue };
        let normals = &mut normals[first..first + count];
        let mut left = [0; TURN];
        let kernel = &kernel;
        run_at(level, Turning { kernel, first, pairs: PAIRS, lines, normals, left: &mut left });
        for (number, line) in lines.iter().enumerate() {
            let at = number * BATCH;
            for n in set_bits(left[number] & !line.is_odd, count - at) {
                normals[at + n] = one_by_one.normal(first + at + n, line.delta[n]);
            }
        }
    }
}

/// The places of those of the first `count` bits that are set.
fn set_bits(mut bits: u16, count: usize) -> impl Iterator<Item = usize> {
    // The last batch may have fewer edges than it has numbers.
    bits &= u16::MAX >> (BATCH - BATCH.min(count));
    std::iter::from_fn(move || {
        let place = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (place < BATCH).then_some(place)
    })
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

/// Where the samples around the edges of a batch are.
#[derive(Clone, Copy)]
pub(super) struct Stencil<W: Wide> {
    /// The number of the first sample of the slice of all lower ends.
    pub(super) slice: i64,
    /// The numbers of the lower ends from there.
    pub(super) low: W::U32,
    /// How far apart samples are along the edge, and along the axes that follow it.
    pub(super) steps: [W::U32; 3],
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
    /// Loads the values around the batch that begins with edge `first`; the bits of those that cannot be loaded,
    /// which have others.
    #[inline(always)]
    fn load<W: Wide>(&self, wide: W, first: usize, values: &mut [[f64; BATCH]; 4]) -> u16 {
        if !self.samples.is_near(2) {
            return u16::MAX;
        }
        let batch = self.ends(wide, first);
        let Stencil { slice, low, steps: [step, ..] } = self.stencil(wide, &batch);
        let high = low + step;
        let mut numbers = [low + step * wide.u32(u32::MAX), low, high, high + step];
        let is_odd = if batch.is_inner { 0 } else { !self.can_load(wide, &batch, slice, &numbers) };
        if is_odd == u16::MAX {
            return u16::MAX;
        }
        if is_odd != 0 {
            // In place of each that cannot be loaded there is one that can.
            let kept = is_odd.trailing_ones() as usize;
            for number in &mut numbers {
                let other = wide.u32(wide.store(*number)[kept]);
                *number = wide.select(is_odd, other, *number);
            }
        }
        for (value, number) in values.iter_mut().zip(numbers) {
            // SAFETY: all four samples on the lines of the edges that are left are there. Four bytes can be
            // read from each on: of inner edges they have both neighbours across, of others that was
            // looked at. The farthest is two slices away.
            let sample = unsafe { wide.near(self.samples, slice, number) };
            wide.store_f64(self.above_iso(wide, sample), value);
        }
        is_odd
    }

    /// Where the samples around edges are. The lower ends are in the lattice, or any number will do.
    #[inline(always)]
    pub(super) fn stencil<W: Wide>(&self, wide: W, batch: &Batch<W>) -> Stencil<W> {
        // Numbers fit, as `is_near` says, and wrap to what they are.
        let strides = self.samples.strides();
        let mut all = [wide.u32(0); 3];
        for (step, stride) in all.iter_mut().zip(strides) {
            *step = wide.u32(stride as u32);
        }
        let mut steps = [all[2], all[0], all[1]];
        for axis in [1, 0] {
            let is_along = wide.equal(batch.axis, wide.u32(axis as u32));
            for (n, step) in steps.iter_mut().enumerate() {
                *step = wide.select(is_along, all[(axis + n) % 3], *step);
            }
        }
        let low = batch.low[0] * all[0] + batch.low[1] * all[1];
        let slice = self.samples.first() + i64::from(self.edges.z()) * strides[2];
        Stencil { slice, low, steps }
    }

    /// The bits of those edges whose samples on the line, of these numbers from that of the slice, are there,
    /// each with four bytes from it on.
    #[inline(always)]
    fn can_load<W: Wide>(
        &self,
        wide: W,
        batch: &Batch<W>,
        slice: i64,
        numbers: &[W::U32; 4],
    ) -> u16 {
        let mut can_load = !batch.is_outside;
        for axis in 0..3 {
            let is_along = wide.equal(batch.axis, wide.u32(axis as u32));
            // A wrapped −1 is beyond all sizes.
            let within = wide.u32(self.samples.dims()[axis].saturating_sub(3));
            can_load &= wide.less(batch.low[axis] + wide.u32(u32::MAX), within) | !is_along;
        }
        let reach = 4_usize.div_ceil(size_of::<T>());
        let end = self.samples.all().len() as i64 - reach as i64 - slice + 1;
        // Compared as numbers without a sign, from the least on.
        let least = i64::from(i32::MIN);
        let end = end.clamp(least, i32::MAX.into()) - least;
        for number in [numbers[0], numbers[3]] {
            can_load &= wide.less(number + wide.u32(1 << 31), wide.u32(end as u32));
        }
        can_load
    }
}
