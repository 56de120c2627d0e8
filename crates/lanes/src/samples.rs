//! A lattice of samples in memory, whose bounds are checked once.

use crate::{Lane, Word};

/// Samples that lie `strides` apart along x, y, z.
///
/// # Guarantees
///
/// The sample of every lattice point lies in the slice, and no size exceeds 2³¹ − 1. A kernel that has
/// checked a point against the sizes may load its sample without a further check.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a, T> {
    all: &'a [T],
    first: i64,
    strides: [i64; 3],
    dims: [u32; 3],
    near: i64,
}

impl<'a, T: Lane> Samples<'a, T> {
    /// Sample (i, j, k) is number `first + (i, j, k) · strides`. `None` where one would not be in the
    /// slice, a size is 0 or exceeds 2³¹ − 1.
    pub fn new(all: &'a [T], first: usize, strides: [isize; 3], dims: [usize; 3]) -> Option<Self> {
        let (mut least, mut greatest) = (first as i128, first as i128);
        for (n, stride) in dims.into_iter().zip(strides) {
            if n == 0 || n > i32::MAX as usize {
                return None;
            }
            let reach = (n - 1) as i128 * stride as i128;
            *if reach < 0 { &mut least } else { &mut greatest } += reach;
        }
        let inside = least >= 0 && greatest < all.len() as i128;
        let near = near::<T>(all.len(), first, strides, dims);
        let (first, dims) = (first as i64, dims.map(|n| n as u32));
        let strides = strides.map(|stride| stride as i64);
        inside.then_some(Self { all, first, strides, dims, near })
    }

    /// Samples along x, y, z.
    pub fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// How far apart neighbours along x, y, z are.
    pub(crate) fn strides(&self) -> [i64; 3] {
        self.strides
    }

    /// The number of sample (0, 0, 0).
    pub(crate) fn first(&self) -> i64 {
        self.first
    }

    /// The slice that the numbers are of.
    pub(crate) fn all(&self) -> &'a [T] {
        self.all
    }

    /// Asks for samples of slice `z` that will be read soon: those of the same numbers as the `wanted` cells
    /// of `words`, where number 0 of row 0 is sample `x` of row `y`. All three may be wrapped, or beyond
    /// the last.
    #[inline(always)]
    pub fn prefetch(&self, [x, y, z]: [u32; 3], words: &[Word], wanted: impl Fn(&Word) -> u64) {
        #[cfg(target_arch = "x86_64")]
        if self.strides[0] == 1 && z < self.dims[2] {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            let slice = self.first + i64::from(z) * self.strides[2] + i64::from(x as i32);
            for word in words {
                let row = i64::from(y as i32) + word.row as i64;
                let first = slice + row * self.strides[1] + word.first as i64;
                let sample = self.all.as_ptr().wrapping_offset(first as isize);
                let wanted = wanted(word);
                let per_line = 64 / size_of::<T>();
                for line in 0..size_of::<T>() {
                    let bits = wanted >> (line * per_line);
                    if bits & (u64::MAX >> (64 - per_line)) != 0 {
                        let place = sample.cast::<i8>().wrapping_add(64 * line);
                        // SAFETY: a prefetch reads nothing, so any address will do.
                        unsafe { _mm_prefetch::<_MM_HINT_T0>(place) };
                    }
                }
            }
        }
    }

    /// Whether the number of a sample, from the first of a slice as many slices below or above, fits 31
    /// bits, and four bytes can be read from every sample on that has both neighbours along two axes or
    /// more.
    pub(crate) fn is_near(&self, slices: i64) -> bool {
        slices <= self.near
    }
}

/// The most slices between two samples for which [`Samples::is_near`] holds; −1 where it never does.
fn near<T>(held: usize, first: usize, strides: [isize; 3], dims: [usize; 3]) -> i64 {
    let strides = strides.map(|stride| stride as i128);
    let reach = |axis: usize| (dims[axis] as i128 - 1) * strides[axis];
    let left = i128::from(i32::MAX) - reach(0).abs() - reach(1).abs();
    // Farthest along each axis, and on the others as far as leaves a neighbour.
    let most = |axis: usize, margin: i128| {
        let far = (dims[axis] as i128 - 1 - margin) * strides[axis];
        far.max(margin * strides[axis])
    };
    let greatest = |end: usize| {
        let others = (0..3).filter(|&axis| axis != end).map(|axis| most(axis, 1));
        first as i128 + most(end, 0) + others.sum::<i128>()
    };
    let greatest = (0..3).map(greatest).max().unwrap_or(0);
    let size = size_of::<T>() as i128;
    match left >= 0 && greatest * size + 4 <= held as i128 * size {
        true => (left / strides[2].abs().max(1)) as i64,
        false => -1,
    }
}
