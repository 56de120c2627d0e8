//! Where edges are crossed by cubics or quintics, 16 edges at a time.
//!
//! Loops take turns over some batches at a time: one loads the samples on the lines of the edges, the second
//! finds roots (`roots.rs`), the third makes places, and a fourth normals (`normals.rs`), if they are wanted. Each
//! is short, so that the machine works at several batches at once while one waits, and only the first and the
//! last are compiled for each type of sample.
//!
//! Lines that leave the lattice are continued (`curves/beyond.rs`). The caller tells the values of those that are
//! too short for that or cannot be loaded so, and the normals that a loop leaves. Edges that have none, that have
//! values which are not finite, or a root that is hard to find, are called odd and left to the caller.

use super::{
    Field, Kernel, Places, Vertices,
    around::Batch,
    normals::Normals,
    roots::{Roots, Search, find_roots},
};
use crate::{
    Coordinate, Edges, Lane, Level, Samples,
    wide::{BATCH, Mask, Task, Wide, run_at},
};

mod beyond;
#[cfg(test)]
mod tests;

use beyond::Lacking;
pub use beyond::ONE_BEFORE;

/// Batches that are worked at in turn: what is known of them stays in the first cache.
const TURN: usize = 8;

/// The polynomial through the samples nearest on the line of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curve {
    /// Through four.
    Cubic,
    /// Through six.
    Quintic,
}

impl Curve {
    /// Samples to either side of an edge's middle, and of one that a slope is made from.
    fn pairs(self) -> usize {
        match self {
            Self::Cubic => 2,
            Self::Quintic => 3,
        }
    }
}

/// What the normals at curves are made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gradient {
    /// Differences over two steps at the ends of the edge, as [`vertices`](super::vertices) takes them.
    Central,
    /// Those of the order of the curve.
    Matching,
}

/// The most samples on a line.
const MOST: usize = 6;

/// What the caller tells of edges that the loops leave, by their number.
pub trait OneByOne {
    /// The values on the line of an edge, less the isovalue, of which the two in the middle are those of the ends:
    /// asked where the lattice has fewer samples on it, or they cannot be loaded sixteen at a time. False if the
    /// ends are not both samples.
    fn line(&self, edge: usize, values: &mut [f64]) -> bool;

    /// The normal so many edge lengths from the middle of an edge: asked where a sample that it depends on is
    /// missing, or its gradient is not tame.
    fn normal(&self, edge: usize, delta: f64) -> [f32; 3];
}

/// Places vertices where the curve of an edge has the isovalue; where the curve rings, where the straight line
/// has it.
///
/// # Panics
///
/// If `out` has not room for exactly one vertex per edge.
pub fn curved_vertices<T: Lane, C: Coordinate>(
    (samples, field): (&Samples<'_, T>, &Field),
    made: (Curve, Gradient),
    edges: &Edges,
    one_by_one: &dyn OneByOne,
    out: Vertices<'_, C>,
) {
    curved_vertices_at(Level::current(), (samples, field), made, edges, one_by_one, out);
}

fn curved_vertices_at<T: Lane, C: Coordinate>(
    level: Level,
    (samples, field): (&Samples<'_, T>, &Field),
    (curve, gradient): (Curve, Gradient),
    edges: &Edges,
    one_by_one: &dyn OneByOne,
    out: Vertices<'_, C>,
) {
    out.check(edges.len());
    let Vertices { positions, mut normals, odd } = out;
    let kernel = Kernel::new(samples, field, edges);
    let pairs = curve.pairs();
    let mut lines = [const { Line::DEFAULT }; TURN];
    let mut searches = [const { Search::DEFAULT }; TURN];
    for (turn, positions) in positions.chunks_mut(TURN * BATCH).enumerate() {
        let (first, count) = (turn * TURN * BATCH, positions.len());
        let batches = count.div_ceil(BATCH);
        T::load(level, Loading { kernel: &kernel, first, pairs, lines: &mut lines[..batches] });
        let with_odd = |(_, line): &(usize, &mut Line)| line.is_odd != 0;
        for (number, line) in lines[..batches].iter_mut().enumerate().filter(with_odd) {
            let at = number * BATCH;
            for n in set_bits(line.is_odd, count - at) {
                let values = &mut [0.0; MOST][..2 * pairs];
                if one_by_one.line(first + at + n, values) {
                    line.is_odd ^= 1 << n;
                    line.values.iter_mut().zip(values).for_each(|(to, value)| to[n] = *value);
                }
            }
        }
        let held = &mut lines[..batches];
        let searches = &mut searches[..];
        find_roots(level, Roots { lines: held, searches, pairs, reach: field.reach });
        let lines = &lines[..batches];
        let (starts, positions) = (kernel.starts, C::places(positions));
        place(level, Placing { field, starts, edges, first, lines, positions });
        for (number, line) in lines.iter().enumerate().filter(|(_, line)| line.is_odd != 0) {
            let at = first + number * BATCH;
            odd.extend(set_bits(line.is_odd, edges.len() - at).map(|n| (at + n) as u32));
        }
        let Some(normals) = &mut normals else { continue };
        let normals = &mut normals[first..first + count];
        let mut left = [0; TURN];
        let kernel = &kernel;
        let left_here = &mut left;
        T::turn(level, Normals { kernel, first, gradient, pairs, lines, normals, left: left_here });
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
    /// The samples on the line of each edge, less the isovalue, as many as the curve goes through.
    pub(super) values: [[f64; BATCH]; MOST],
    /// Where each is crossed, in edge lengths from its middle.
    pub(super) delta: [f64; BATCH],
    /// Which are odd.
    pub(super) is_odd: u16,
}

impl Line {
    const DEFAULT: Self = Self { values: [[0.0; BATCH]; MOST], delta: [0.0; BATCH], is_odd: 0 };
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
pub struct Loading<'l, 'b, 'a, T> {
    kernel: &'l Kernel<'b, 'a, T>,
    first: usize,
    pairs: usize,
    lines: &'l mut [Line],
}

impl<T: Lane> Task for Loading<'_, '_, '_, T> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        for (number, line) in self.lines.iter_mut().enumerate() {
            let first = self.first + number * BATCH;
            let values = &mut line.values;
            line.is_odd = match self.pairs {
                2 => self.kernel.load::<W, 4>(wide, first, values),
                _ => self.kernel.load::<W, 6>(wide, first, values),
            };
        }
    }
}

/// Makes the places of the batches from edge `first` on.
struct Placing<'l> {
    field: &'l Field,
    starts: Option<[f64; 3]>,
    edges: &'l Edges,
    first: usize,
    lines: &'l [Line],
    positions: Places<'l>,
}

/// Does the task with the instructions of a level, compiled here and not anew wherever edges are placed.
fn place(level: Level, placing: Placing<'_>) {
    run_at(level, placing);
}

impl Task for Placing<'_> {
    #[inline(always)]
    fn run<W: Wide>(mut self, wide: W) {
        let z = wide.u32(self.edges.z());
        for (number, line) in self.lines.iter().enumerate() {
            let [axis, x, y] = self.edges.batch(self.first + number * BATCH);
            let low = [wide.load(x), wide.load(y), z];
            let delta = wide.load_f64(&line.delta);
            let places = self.field.places(wide, self.starts, wide.load(axis), low, delta);
            self.positions.write(wide, number * BATCH, places);
        }
    }
}

impl<T: Lane> Kernel<'_, '_, T> {
    /// Loads the values around the batch that begins with edge `first`; the bits of those that cannot be loaded,
    /// which have others.
    #[inline(always)]
    fn load<W: Wide, const HELD: usize>(
        &self,
        wide: W,
        first: usize,
        values: &mut [[f64; BATCH]; MOST],
    ) -> u16 {
        let pairs = HELD / 2;
        if !self.samples.is_near(pairs as i64) {
            return u16::MAX;
        }
        let batch = self.ends(wide, first);
        let Stencil { slice, low, steps: [step, ..] } = self.stencil(wide, &batch);
        // From so many steps before the lower end.
        let mut begin = low + step * wide.u32((pairs - 1).wrapping_neg() as u32);
        // Inner edges have one neighbour on either side.
        let (mut is_odd, mut lacking) = (0, None);
        if batch.is_inner != u16::MAX || pairs > 2 {
            let (along, size) = self.along(wide, &batch);
            is_odd = batch.is_outside | wide.less(size, wide.u32(HELD as u32)).bits();
            let found = Lacking::new(wide, pairs as u32, wide.mask(!is_odd), along, size);
            if found.any != 0 {
                begin = found.moved(wide, begin, step);
                // Samples are as many slices farther in as are lacking.
                if !self.samples.is_near(2 * pairs as i64 - 1) {
                    is_odd |= found.any;
                }
                lacking = Some(found);
            }
            is_odd |=
                !self.can_load(wide, slice, [begin, begin + step * wide.u32(HELD as u32 - 1)]);
        }
        let mut numbers = [begin; HELD];
        for n in 1..HELD {
            numbers[n] = numbers[n - 1] + step;
        }
        if is_odd == u16::MAX {
            return u16::MAX;
        }
        if is_odd != 0 {
            // In place of each that cannot be loaded there is one that can.
            let kept = is_odd.trailing_ones() as usize;
            for number in &mut numbers {
                let other = wide.u32(wide.store(*number)[kept]);
                *number = wide.select(wide.mask(is_odd), other, *number);
            }
        }
        for (value, number) in values.iter_mut().zip(numbers) {
            // SAFETY: of the edges that are left both ends are samples, and so are the others on their lines: there are as
            // many as are held, or more, and those that would not be are moved in. Four bytes can be read from each
            // on: that was looked at, or all have both neighbours across. The farthest is as many slices away as
            // there are pairs, or twice as many less one where that was asked.
            let sample = unsafe { wide.near(self.samples, slice, number) };
            wide.store_f64(self.above_iso(wide, sample), value);
        }
        if let Some(lacking) = lacking {
            lacking.put_in::<HELD>(wide, values);
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

    /// The places of lower ends along their edges, and how many samples the lattice has there.
    #[inline(always)]
    fn along<W: Wide>(&self, wide: W, batch: &Batch<W>) -> (W::U32, W::U32) {
        let size = self.samples.dims();
        let (mut along, mut sizes) = (batch.low[2], wide.u32(size[2]));
        for axis in [1, 0] {
            let is_along = wide.equal(batch.axis, wide.u32(axis as u32));
            along = wide.select(is_along, batch.low[axis], along);
            sizes = wide.select(is_along, wide.u32(size[axis]), sizes);
        }
        (along, sizes)
    }

    /// The bits of those lines from whose samples, of which the first and the last have these numbers from that of
    /// the slice, four bytes can be read on.
    #[inline(always)]
    fn can_load<W: Wide>(&self, wide: W, slice: i64, ends: [W::U32; 2]) -> u16 {
        let reach = 4_usize.div_ceil(size_of::<T>());
        let end = self.samples.all().len() as i64 - reach as i64 - slice + 1;
        // Compared as numbers without a sign, from the least on.
        let least = i64::from(i32::MIN);
        let end = end.clamp(least, i32::MAX.into()) - least;
        let mut can_load = wide.mask(u16::MAX);
        for number in ends {
            can_load = can_load & wide.less(number + wide.u32(1 << 31), wide.u32(end as u32));
        }
        can_load.bits()
    }
}
