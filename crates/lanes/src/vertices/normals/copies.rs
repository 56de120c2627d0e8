//! Samples around edges, copied so that those of a batch lie side by side.
//!
//! What depends on dozens of samples around each edge takes them edge by edge, all of one before those of the next: edges
//! beside each other look at the same lines of memory, which are still in the first cache then.

use crate::{
    Lane,
    vertices::{Kernel, curves::set_bits},
    wide::{BATCH, Exact, Wide},
};

/// The samples around an edge of so many pairs: on its line one more on either side, and at the pairs so many beside them
/// along two axes.
pub(super) const fn count(pairs: usize) -> usize {
    2 * (pairs + 1) + 4 * pairs * (pairs + 1)
}

/// The most of them: around an edge of three pairs.
const MOST_AROUND: usize = count(3);

/// By pairs, less two: how many steps each of those samples is from the lower end along the edge, and along the two axes that
/// follow it. First those on the line. Then, for each of these two axes: the differences along it, over two steps first; of
/// each the pairs, nearest first; of each the lower and the upper sample; and at each the one below and the one above.
const STEPS: [[[i8; 3]; MOST_AROUND]; 2] = [steps(2), steps(3)];

const fn steps(pairs: usize) -> [[i8; 3]; MOST_AROUND] {
    let mut steps = [[0; 3]; MOST_AROUND];
    let mut next = 0;
    while next < 2 * (pairs + 1) {
        steps[next][0] = next as i8 - pairs as i8;
        next += 1;
    }
    let mut part = 1;
    while part < 3 {
        let mut apart = 1;
        while apart <= pairs {
            let mut pair = 0;
            while pair <= pairs - apart {
                let mut n = 0;
                while n < 4 {
                    steps[next][0] = [-(pair as i8), pair as i8 + 1][n / 2];
                    steps[next][part] = [-(apart as i8), apart as i8][n % 2];
                    (next, n) = (next + 1, n + 1);
                }
                pair += 1;
            }
            apart += 1;
        }
        part += 1;
    }
    assert!(next == count(pairs), "all of them");
    steps
}

/// Samples around the edges of a batch.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(in crate::vertices) struct Copies<T> {
    samples: [[T; BATCH]; MOST_AROUND],
    /// How many samples each is from the lower end in memory, by the axis of the edge.
    offsets: [[isize; MOST_AROUND]; 3],
    strides: [i64; 3],
    pairs: usize,
}

impl<T: Lane> Copies<T> {
    /// Room for those around edges of so many pairs, 2 or 3, of samples so far apart.
    pub(in crate::vertices) fn new(strides: [i64; 3], pairs: usize) -> Self {
        let mut offsets = [[0_isize; MOST_AROUND]; 3];
        for (axis, offsets) in offsets.iter_mut().enumerate() {
            for (offset, steps) in offsets.iter_mut().zip(&STEPS[pairs - 2]) {
                for (n, &steps) in steps.iter().enumerate() {
                    // Along an axis of one sample they may be any number apart, and nothing is copied.
                    let apart = strides[(axis + n) % 3] as isize;
                    *offset = offset.wrapping_add(apart.wrapping_mul(steps.into()));
                }
            }
        }
        Self { samples: [[T::default(); BATCH]; MOST_AROUND], offsets, strides, pairs }
    }

    /// The pairs of samples around each edge, 2 or 3.
    pub(super) fn pairs(&self) -> usize {
        self.pairs
    }

    /// Whether this is for edges of so many pairs, of samples so far apart.
    pub(super) fn are_for(&self, strides: [i64; 3], pairs: usize) -> bool {
        (self.strides, self.pairs) == (strides, pairs)
    }

    /// Copies the samples around those edges of the batch from edge `first` on whose bits are set.
    ///
    /// # Safety
    ///
    /// This must be [for](Self::are_for) the samples of the kernel, `COUNT` no more than there are of so many pairs, and
    /// all of them in the lattice: beyond both ends of these edges as many to all sides as there are pairs.
    #[inline(always)]
    pub(super) unsafe fn take<const COUNT: usize>(
        &mut self,
        kernel: &Kernel<'_, '_, T>,
        first: usize,
        edges: u16,
    ) {
        const { assert!(COUNT <= MOST_AROUND, "room for them") };
        let Kernel { samples, edges: list, .. } = kernel;
        let ([axis, x, y], z) = (list.batch(first), list.z());
        for n in set_bits(edges, BATCH) {
            let mut number = samples.first();
            for (place, stride) in [x[n], y[n], z].into_iter().zip(samples.strides()) {
                number += i64::from(place) * stride;
            }
            let low = samples.all().as_ptr().wrapping_offset(number as isize);
            let offsets = &self.offsets[axis[n] as usize];
            for (copies, &offset) in self.samples[..COUNT].iter_mut().zip(offsets) {
                // SAFETY: the caller says that it is a sample of the lattice, and those lie in the slice.
                copies[n] = unsafe { *low.wrapping_offset(offset) };
            }
        }
    }

    /// The samples at one of the places around each edge, in the order of `STEPS`.
    #[inline(always)]
    pub(super) fn at<W: Wide>(&self, wide: W, place: usize) -> <T::Exact as Exact>::Of<W> {
        let mut exact = [T::Exact::default(); BATCH];
        for (exact, sample) in exact.iter_mut().zip(self.samples[place]) {
            *exact = sample.exact();
        }
        T::Exact::load(wide, &exact)
    }
}
