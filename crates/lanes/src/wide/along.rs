//! Samples beside each other along x, loaded place by place: for samples that lie in any order, and of any size.

use super::{Exact, Wide};
use crate::{Lane, Samples};

/// [`Wide::two_along_x`] one by one.
///
/// # Safety
///
/// As there.
#[inline(always)]
pub(super) unsafe fn one_and_one<W: Wide, T: Lane, const ROWS: usize>(
    wide: W,
    samples: &Samples<'_, T>,
    from: [i64; ROWS],
    at: W::U32,
) -> [[<T::Exact as Exact>::Of<W>; 2]; ROWS] {
    let x = samples.strides()[0];
    let mut rows = [[T::Exact::splat(wide, 0.0); 2]; ROWS];
    for (row, from) in rows.iter_mut().zip(from) {
        // SAFETY: the caller says that both samples are there.
        *row = unsafe { [wide.near(samples, from, at), wide.near(samples, from + x, at)] };
    }
    rows
}

/// [`Wide::four_along_x`] by two and two.
///
/// # Safety
///
/// As there.
#[inline(always)]
pub(super) unsafe fn two_and_two<W: Wide, T: Lane, const ROWS: usize>(
    wide: W,
    samples: &Samples<'_, T>,
    from: [i64; ROWS],
    at: W::U32,
) -> [[<T::Exact as Exact>::Of<W>; 4]; ROWS] {
    let mut next = from;
    for from in &mut next {
        *from += 2 * samples.strides()[0];
    }
    // SAFETY: the caller says that all four samples are there.
    let pairs =
        unsafe { [wide.two_along_x(samples, from, at), wide.two_along_x(samples, next, at)] };
    let mut rows = [[T::Exact::splat(wide, 0.0); 4]; ROWS];
    for (n, row) in rows.iter_mut().enumerate() {
        *row = [pairs[0][n][0], pairs[0][n][1], pairs[1][n][0], pairs[1][n][1]];
    }
    rows
}

/// [`Wide::along_x`] for samples that lie in any order.
///
/// # Safety
///
/// As there.
#[inline(always)]
pub(super) unsafe fn three_along_x<W: Wide, T: Lane>(
    wide: W,
    samples: &Samples<'_, T>,
    from: i64,
    at: W::U32,
) -> [<T::Exact as Exact>::Of<W>; 3] {
    let [x, _, _] = samples.strides();
    // SAFETY: the caller says that all are samples, with both neighbours along y and z.
    unsafe {
        [
            wide.near(samples, from - x, at),
            wide.near(samples, from, at),
            wide.near(samples, from + x, at),
        ]
    }
}
