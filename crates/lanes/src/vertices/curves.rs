//! Where edges are crossed by cubics or quintics, 16 edges at a time.
//!
//! Loops take turns over some batches at a time: one loads the samples on the lines of the edges, and what central
//! normals are made from (`curves/load.rs`, and `curves/singly.rs` one by one), the second finds roots (`roots.rs`), the
//! third makes places, and a fourth normals (`normals.rs`), if they are wanted. Each is short, so that the machine works at several batches at once while
//! one waits, and only the first and the last are compiled for each type of sample.
//!
//! Lines that leave the lattice are continued (`curves/beyond.rs`). The caller tells the values of those that are
//! too short for that or cannot be loaded so, and the normals that a loop leaves. Edges that have none, that have
//! values which are not finite, or a root that is hard to find, are called odd and left to the caller.

use super::{
    Field, Kernel, Places, Vertices,
    normals::{Normals, Source},
    roots::{Roots, Search},
};
use crate::{
    Coordinate, Edges, Lane, Level, Samples,
    wide::{BATCH, Task, Wide, run_at},
};

mod beyond;
mod line;
mod load;
mod singly;
#[cfg(test)]
mod tests;

pub use beyond::ONE_BEFORE;
pub(super) use line::{Crossing, Line, Precision};
pub(super) use load::Differences;
pub use load::Loading;
use singly::Singly;

/// Batches that are worked at in turn: what is known of them stays in the first cache.
pub(super) const TURN: usize = 8;

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
    let mut lines = [const { Line::<C>::DEFAULT }; TURN];
    let mut crossings = [const { Crossing::DEFAULT }; TURN];
    let mut singly = Singly::new();
    let mut searches = [const { Search::DEFAULT }; TURN];
    let mut source = normals.as_ref().map(|_| Source::new(gradient, samples.strides(), pairs));
    for (turn, positions) in positions.chunks_mut(TURN * BATCH).enumerate() {
        let (first, count) = (turn * TURN * BATCH, positions.len());
        let batches = count.div_ceil(BATCH);
        let (kernel, differences) = (&kernel, source.as_mut().and_then(Source::differences));
        let (lines, crossings) = (&mut lines[..batches], &mut crossings[..batches]);
        let (to, singly) = ((&mut *lines, &mut *crossings), &mut singly);
        C::load_lines(level, Loading { kernel, first, pairs, to, differences, singly });
        for (number, crossing) in crossings.iter_mut().enumerate().filter(|(_, c)| c.is_odd != 0) {
            let at = number * BATCH;
            for n in set_bits(crossing.is_odd, count - at) {
                let values = &mut [0.0; MOST][..2 * pairs];
                if one_by_one.line(first + at + n, values) {
                    crossing.is_odd ^= 1 << n;
                    let to = lines[number].values.iter_mut();
                    to.zip(values).for_each(|(to, value)| to[n] = C::round(*value));
                }
            }
        }
        let (batches, searches) = ((lines, &mut *crossings), &mut searches[..]);
        C::find_roots(level, Roots { batches, searches, pairs, reach: field.reach });
        let crossings = &*crossings;
        let (starts, positions) = (kernel.starts, C::places(positions));
        place(level, Placing { field, starts, edges, first, crossings, positions });
        for (number, crossing) in crossings.iter().enumerate().filter(|(_, c)| c.is_odd != 0) {
            let at = first + number * BATCH;
            odd.extend(set_bits(crossing.is_odd, edges.len() - at).map(|n| (at + n) as u32));
        }
        let (Some(normals), Some(source)) = (&mut normals, &mut source) else { continue };
        let normals = &mut normals[first..first + count];
        let mut left = [0; TURN];
        let to = (&mut *normals, &mut left[..]);
        T::turn(level, Normals { kernel, first, source, crossings, to });
        for (number, crossing) in crossings.iter().enumerate() {
            let at = number * BATCH;
            for n in set_bits(left[number] & !crossing.is_odd, count - at) {
                normals[at + n] = one_by_one.normal(first + at + n, crossing.delta[n]);
            }
        }
    }
}

/// The places of those of the first `count` bits that are set.
pub(super) fn set_bits(mut bits: u16, count: usize) -> impl Iterator<Item = usize> {
    // The last batch may have fewer edges than it has numbers.
    bits &= u16::MAX >> (BATCH - BATCH.min(count));
    std::iter::from_fn(move || {
        let place = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (place < BATCH).then_some(place)
    })
}

/// Makes the places of the batches from edge `first` on.
struct Placing<'l> {
    field: &'l Field,
    starts: Option<[f64; 3]>,
    edges: &'l Edges,
    first: usize,
    crossings: &'l [Crossing],
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
        for (number, crossing) in self.crossings.iter().enumerate() {
            let [axis, x, y] = self.edges.batch(self.first + number * BATCH);
            let low = [wide.load(x), wide.load(y), z];
            let delta = wide.load_f64(&crossing.delta);
            let places = self.field.places(wide, self.starts, wide.load(axis), low, delta);
            self.positions.write(wide, number * BATCH, places);
        }
    }
}
