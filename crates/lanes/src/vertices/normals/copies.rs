//! Samples around edges, copied so that those of a batch lie side by side.
//!
//! What depends on dozens of samples around each edge takes them edge by edge, all of one before those of the next: edges
//! beside each other look at the same lines of memory, which are still in the first cache then.

use super::matching::{MOST, STEPS};
use crate::{
    Lane,
    vertices::{Kernel, curves::set_bits},
    wide::{BATCH, Exact, Wide},
};

/// Batches whose samples are copied before the first is used: a register that is loaded from numbers which were
/// written one by one right before waits for all of them.
pub(super) const AT_ONCE: usize = 4;

/// Samples around the edges of some batches.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(in crate::vertices) struct Copies<T> {
    batches: [[[T; BATCH]; MOST]; AT_ONCE],
    /// How far each is from the lower end in memory, by the axis of the edge.
    offsets: [[isize; MOST]; 3],
}

impl<T: Lane> Copies<T> {
    /// Room for those that normals depend on, from so many pairs of samples around each edge.
    pub(in crate::vertices) fn new(strides: [i64; 3], pairs: usize) -> Self {
        let mut offsets = [[0; MOST]; 3];
        for (axis, offsets) in offsets.iter_mut().enumerate() {
            for (offset, steps) in offsets.iter_mut().zip(&STEPS[pairs - 2]) {
                let along = |n: usize| steps[n] as isize * strides[(axis + n) % 3] as isize;
                *offset = along(0) + along(1) + along(2);
            }
        }
        Self { batches: [[[T::default(); BATCH]; MOST]; AT_ONCE], offsets }
    }

    /// Copies the first `COUNT` samples around those edges of the batch from edge `first` on whose bits are set.
    ///
    /// # Safety
    ///
    /// All must be samples.
    #[inline(always)]
    pub(super) unsafe fn take<const COUNT: usize>(
        &mut self,
        to: usize,
        kernel: &Kernel<'_, '_, T>,
        first: usize,
        edges: u16,
    ) {
        const { assert!(COUNT <= MOST, "room for them") };
        let ([axis, x, y], strides) = (kernel.edges.batch(first), kernel.samples.strides());
        let slice = kernel.samples.first() + i64::from(kernel.edges.z()) * strides[2];
        for n in set_bits(edges, BATCH) {
            let number = slice + i64::from(x[n]) * strides[0] + i64::from(y[n]) * strides[1];
            let low = kernel.samples.all().as_ptr().wrapping_offset(number as isize);
            let offsets = &self.offsets[axis[n] as usize];
            for (copies, &offset) in self.batches[to][..COUNT].iter_mut().zip(offsets) {
                // SAFETY: the caller says that it is a sample, and samples lie in the slice.
                copies[n] = unsafe { *low.wrapping_offset(offset) };
            }
        }
    }

    /// The samples at one of the places around each edge.
    #[inline(always)]
    pub(super) fn at<W: Wide>(
        &self,
        wide: W,
        batch: usize,
        place: usize,
    ) -> <T::Exact as Exact>::Of<W> {
        let mut exact = [T::Exact::default(); BATCH];
        for (exact, sample) in exact.iter_mut().zip(self.batches[batch][place]) {
            *exact = sample.exact();
        }
        T::Exact::load(wide, &exact)
    }
}
