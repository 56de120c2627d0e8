//! A lattice of samples in memory, whose bounds are checked once.

use crate::Lane;

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
        let strides = strides.map(|stride| stride as i64);
        inside.then(|| Self { all, first: first as i64, strides, dims: dims.map(|n| n as u32) })
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
}
