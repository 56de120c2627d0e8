//! Rows of samples beside each other, from sixteen places.

use super::{
    Avx2,
    gather::{exact, gather_rows, words_of_four, words_of_two},
    registers::{U32, two},
};
use crate::{
    Lane, Samples,
    wide::{
        Exact,
        along::{one_and_one, two_and_two},
    },
};
use std::arch::x86_64::*;

/// See [`Wide::two_along_x`](crate::wide::Wide::two_along_x).
///
/// # Safety
///
/// As there.
#[inline(always)]
pub(super) unsafe fn two_along_x<T: Lane, const ROWS: usize>(
    wide: Avx2,
    samples: &Samples<'_, T>,
    from: [i64; ROWS],
    at: U32,
) -> [[<T::Exact as Exact>::Of<Avx2>; 2]; ROWS] {
    if size_of::<T>() > 4 || samples.strides()[0] != 1 {
        // SAFETY: the caller says so.
        return unsafe { one_and_one(wide, samples, from, at) };
    }
    let (bases, mut rows) = (bases(samples, from), [[T::Exact::splat(wide, 0.0); 2]; ROWS]);
    // SAFETY: there is a token, and the caller says that both samples are there, and four bytes from the first.
    unsafe {
        if size_of::<T>() == 4 {
            for (row, base) in rows.iter_mut().zip(bases) {
                let [own, above] = words_of_two(wide, base.cast(), at);
                *row = [exact::<T>(wide, own), exact::<T>(wide, above)];
            }
        } else {
            for (row, both) in rows.iter_mut().zip(gather_rows(wide, bases, at)) {
                let above = match size_of::<T>() {
                    1 => two!(N => _mm256_srli_epi32::<8>(both[N])),
                    _ => two!(N => _mm256_srli_epi32::<16>(both[N])),
                };
                *row = [exact::<T>(wide, both), exact::<T>(wide, above)];
            }
        }
    }
    rows
}

/// See [`Wide::four_along_x`](crate::wide::Wide::four_along_x).
///
/// # Safety
///
/// As there.
#[inline(always)]
pub(super) unsafe fn four_along_x<T: Lane, const ROWS: usize>(
    wide: Avx2,
    samples: &Samples<'_, T>,
    from: [i64; ROWS],
    at: U32,
) -> [[<T::Exact as Exact>::Of<Avx2>; 4]; ROWS] {
    if !matches!(size_of::<T>(), 1 | 4) || samples.strides()[0] != 1 {
        // SAFETY: the caller says so.
        return unsafe { two_and_two(wide, samples, from, at) };
    }
    let (bases, mut rows) = (bases(samples, from), [[T::Exact::splat(wide, 0.0); 4]; ROWS]);
    // SAFETY: there is a token, and the caller says that all four samples are there.
    unsafe {
        if size_of::<T>() == 4 {
            for (row, base) in rows.iter_mut().zip(bases) {
                let words = words_of_four(wide, base.cast(), at);
                for (sample, words) in row.iter_mut().zip(words) {
                    *sample = exact::<T>(wide, words);
                }
            }
        } else {
            for (row, all) in rows.iter_mut().zip(gather_rows(wide, bases, at)) {
                *row = [
                    exact::<T>(wide, all),
                    exact::<T>(wide, two!(N => _mm256_srli_epi32::<8>(all[N]))),
                    exact::<T>(wide, two!(N => _mm256_srli_epi32::<16>(all[N]))),
                    exact::<T>(wide, two!(N => _mm256_srli_epi32::<24>(all[N]))),
                ];
            }
        }
    }
    rows
}

/// Where the samples of these numbers are.
#[inline(always)]
fn bases<T: Lane, const ROWS: usize>(
    samples: &Samples<'_, T>,
    from: [i64; ROWS],
) -> [*const T; ROWS] {
    let mut bases = [samples.all().as_ptr(); ROWS];
    for (base, from) in bases.iter_mut().zip(from) {
        *base = base.wrapping_offset(from as isize);
    }
    bases
}
