//! Normals on curves, 16 edges at a time: from central differences, or from those of the curve's order.
//!
//! Central ones are made as on straight lines (`vertices.rs`), of differences that came with the samples on the lines; the
//! others in `normals/matching.rs`.

use super::{
    AHEAD, Kernel,
    curves::{Crossing, Differences, Gradient, TURN},
};
use crate::{
    Lane,
    prefetch::prefetch_beyond,
    wide::{BATCH, Task, Wide},
};

mod copies;
mod matching;

use copies::Copies;

/// Makes the normals of the batches from edge `first` on, where their lines are crossed. Those that are no unit
/// vector are left; matching ones also of edges so near to the border that a slope is one-sided.
pub struct Normals<'l, 'b, 'a, T> {
    pub(super) kernel: &'l Kernel<'b, 'a, T>,
    pub(super) first: usize,
    pub(super) source: &'l mut Source<T>,
    pub(super) crossings: &'l [Crossing],
    /// Where normals go, and the bits of those that are left, by batches.
    pub(super) to: (&'l mut [[f32; 3]], &'l mut [u16]),
}

/// What gradients are made from.
#[expect(
    clippy::large_enum_variant,
    reason = "samples of any type are not counted: the other is larger"
)]
pub(super) enum Source<T> {
    /// Differences over two steps, by batches.
    Central([Differences; TURN]),
    /// Samples around the edges, for which there is room here: as many to either side of one as a slope is made from, and
    /// as many pairs around an edge.
    Matching(Copies<T>),
}

impl<T: Lane> Source<T> {
    pub(super) fn new(gradient: Gradient, strides: [i64; 3], pairs: usize) -> Self {
        match gradient {
            Gradient::Central => Self::Central([const { Differences::DEFAULT }; TURN]),
            Gradient::Matching => Self::Matching(Copies::new(strides, pairs)),
        }
    }

    /// The differences, if gradients are made from those.
    pub(super) fn differences(&mut self) -> Option<&mut [Differences]> {
        match self {
            Self::Central(differences) => Some(differences),
            Self::Matching(_) => None,
        }
    }
}

impl<T: Lane> Task for Normals<'_, '_, '_, T> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Self { kernel, first, source, crossings, to: (normals, left) } = self;
        let (whole, rest) = normals.as_chunks_mut();
        // The last batch may have less room than it has numbers.
        let mut last = [[0.0; 3]; BATCH];
        let mut room = Room { whole, last: &mut last };
        match source {
            Source::Central(differences) => {
                for (number, (crossing, left)) in crossings.iter().zip(left).enumerate() {
                    let (around, normals) = (differences[number].load(wide), room.of(number));
                    let share = wide.f64_to_f32(wide.f64(0.5) + wide.load_f64(&crossing.delta));
                    *left = kernel.write_normals(wide, around, share, normals);
                }
            }
            Source::Matching(copies) => {
                let batches = (first, crossings, left);
                match copies.pairs() {
                    2 => kernel.turn::<W, 2, 6, 30>(wide, batches, copies, room),
                    _ => kernel.turn::<W, 3, 8, 56>(wide, batches, copies, room),
                }
            }
        }
        rest.copy_from_slice(&last[..rest.len()]);
    }
}

/// Where the normals of batches go.
struct Room<'o> {
    whole: &'o mut [[[f32; 3]; BATCH]],
    /// For the last batch, if it is not whole.
    last: &'o mut [[f32; 3]; BATCH],
}

impl Room<'_> {
    #[inline(always)]
    fn of(&mut self, batch: usize) -> &mut [[f32; 3]; BATCH] {
        match self.whole.get_mut(batch) {
            Some(own) => {
                prefetch_beyond::<AHEAD, _>(own);
                own
            }
            None => self.last,
        }
    }
}
