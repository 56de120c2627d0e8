//! Samples from sixteen places.

use super::{
    Avx2,
    registers::{F32, F64, U32, four, two},
};
use crate::{
    Lane,
    wide::{Exact, Wide},
};
use std::{any::TypeId, arch::x86_64::*, mem::transmute_copy};

/// The four bytes from each sample on. Not by `gather_rows`: this is inlined a dozen times into each task and for each
/// type, and its loops over one row took the compiler as long as all the rest of the crate (Rust 1.95, `opt-level` 1).
///
/// # Safety
///
/// They must lie in the slice that `base` was made from, where `at` counts up and down from it.
#[inline(always)]
pub(super) unsafe fn gather<T>(wide: Avx2, base: *const T, at: U32) -> [__m256i; 2] {
    let numbers = wide.store(at);
    macro_rules! load {
        ($n:expr) => {
            base.wrapping_offset(numbers[$n] as i32 as isize).cast::<i32>().read_unaligned()
        };
    }
    // SAFETY: there is a token, and the caller says that these bytes are there.
    unsafe {
        two!(N => _mm256_setr_epi32(
            load!(8 * N), load!(8 * N + 1), load!(8 * N + 2), load!(8 * N + 3),
            load!(8 * N + 4), load!(8 * N + 5), load!(8 * N + 6), load!(8 * N + 7),
        ))
    }
}

/// Of each row the four bytes from each sample on. The rows of one place are loaded one after another, so that its
/// number is taken out of its register once: a look at values takes 0.83 of the time of row after row (EPYC of 2021,
/// November 2026).
///
/// # Safety
///
/// They must lie in the slice that the bases were made from, where `at` counts up and down from them.
#[inline(always)]
pub(super) unsafe fn gather_rows<T, const ROWS: usize>(
    wide: Avx2,
    bases: [*const T; ROWS],
    at: U32,
) -> [[__m256i; 2]; ROWS] {
    let numbers = wide.store(at);
    macro_rules! load {
        ($base:expr, $n:expr) => {
            $base.wrapping_offset(numbers[$n] as i32 as isize).cast::<i32>().read_unaligned()
        };
    }
    // SAFETY: there is a token, and the caller says that these bytes are there.
    unsafe {
        let mut quarters = [[_mm_setzero_si128(); ROWS]; 4];
        macro_rules! fill {
            ($($quarter:expr),*) => {$(
                for (row, base) in quarters[$quarter].iter_mut().zip(&bases) {
                    *row = _mm_cvtsi32_si128(load!(base, 4 * $quarter));
                }
                for (row, base) in quarters[$quarter].iter_mut().zip(&bases) {
                    *row = _mm_insert_epi32::<1>(*row, load!(base, 4 * $quarter + 1));
                }
                for (row, base) in quarters[$quarter].iter_mut().zip(&bases) {
                    *row = _mm_insert_epi32::<2>(*row, load!(base, 4 * $quarter + 2));
                }
                for (row, base) in quarters[$quarter].iter_mut().zip(&bases) {
                    *row = _mm_insert_epi32::<3>(*row, load!(base, 4 * $quarter + 3));
                }
            )*};
        }
        fill!(0, 1, 2, 3);
        let mut rows = [[_mm256_setzero_si256(); 2]; ROWS];
        for (n, row) in rows.iter_mut().enumerate() {
            *row = two!(N => _mm256_set_m128i(quarters[2 * N + 1][n], quarters[2 * N][n]));
        }
        rows
    }
}

/// A number from each place.
///
/// # Safety
///
/// They must lie in the slice that `base` was made from, where `at` counts up and down from it.
#[inline(always)]
pub(super) unsafe fn gather_f64(wide: Avx2, base: *const f64, at: U32) -> F64 {
    let numbers = wide.store(at);
    macro_rules! load {
        ($n:expr) => {
            *base.wrapping_offset(numbers[$n] as i32 as isize)
        };
    }
    // SAFETY: there is a token, and the caller says that these numbers are there.
    F64(unsafe {
        four!(N => _mm256_setr_pd(
            load!(4 * N), load!(4 * N + 1), load!(4 * N + 2), load!(4 * N + 3),
        ))
    })
}

/// Of the four words from each place on: all first ones, all second ones, and so on.
///
/// # Safety
///
/// All four must lie in the slice that `base` was made from, where `at` counts up and down from it.
#[inline(always)]
pub(super) unsafe fn words_of_four(wide: Avx2, base: *const f32, at: U32) -> [[__m256i; 2]; 4] {
    let numbers = wide.store(at);
    macro_rules! load {
        ($n:expr) => {
            _mm_loadu_ps(base.wrapping_offset(numbers[$n] as i32 as isize))
        };
    }
    // Those of places n and n + 4.
    macro_rules! both {
        ($n:expr) => {
            _mm256_set_m128(load!($n + 4), load!($n))
        };
    }
    // SAFETY: there is a token, and the caller says that the words are there.
    unsafe {
        // The first and second ones of places n, n + 1 and n + 2, n + 3, and then the others.
        let low = two!(N => _mm256_unpacklo_ps(both!(8 * N), both!(8 * N + 1)));
        let next_low = two!(N => _mm256_unpacklo_ps(both!(8 * N + 2), both!(8 * N + 3)));
        let high = two!(N => _mm256_unpackhi_ps(both!(8 * N), both!(8 * N + 1)));
        let next_high = two!(N => _mm256_unpackhi_ps(both!(8 * N + 2), both!(8 * N + 3)));
        let first = two!(N => _mm256_shuffle_ps::<0b01_00_01_00>(low[N], next_low[N]));
        let second = two!(N => _mm256_shuffle_ps::<0b11_10_11_10>(low[N], next_low[N]));
        let third = two!(N => _mm256_shuffle_ps::<0b01_00_01_00>(high[N], next_high[N]));
        let fourth = two!(N => _mm256_shuffle_ps::<0b11_10_11_10>(high[N], next_high[N]));
        [
            two!(N => _mm256_castps_si256(first[N])),
            two!(N => _mm256_castps_si256(second[N])),
            two!(N => _mm256_castps_si256(third[N])),
            two!(N => _mm256_castps_si256(fourth[N])),
        ]
    }
}

/// Of the two words from each place on: all first ones, and all second ones.
///
/// # Safety
///
/// Both must lie in the slice that `base` was made from, where `at` counts up and down from it.
#[inline(always)]
pub(super) unsafe fn words_of_two(wide: Avx2, base: *const f32, at: U32) -> [[__m256i; 2]; 2] {
    let numbers = wide.store(at);
    macro_rules! load {
        ($n:expr) => {
            base.wrapping_offset(numbers[$n] as i32 as isize).cast::<f64>().read_unaligned()
        };
    }
    // SAFETY: there is a token, and the caller says that the words are there.
    unsafe {
        // Those of places n, n + 1 and n + 4, n + 5, so that halves of registers need not change sides.
        let low = two!(N => _mm256_castpd_ps(_mm256_setr_pd(
            load!(8 * N), load!(8 * N + 1), load!(8 * N + 4), load!(8 * N + 5),
        )));
        let high = two!(N => _mm256_castpd_ps(_mm256_setr_pd(
            load!(8 * N + 2), load!(8 * N + 3), load!(8 * N + 6), load!(8 * N + 7),
        )));
        let first = two!(N => _mm256_shuffle_ps::<0b10_00_10_00>(low[N], high[N]));
        let second = two!(N => _mm256_shuffle_ps::<0b11_01_11_01>(low[N], high[N]));
        [two!(N => _mm256_castps_si256(first[N])), two!(N => _mm256_castps_si256(second[N]))]
    }
}

/// The samples in the lowest bits of words, in the type that holds them exactly.
#[inline(always)]
pub(super) fn exact<T: Lane>(wide: Avx2, words: [__m256i; 2]) -> <T::Exact as Exact>::Of<Avx2> {
    macro_rules! by_type {
        ($($t:ty, $numbers:expr;)*) => {
            $(if TypeId::of::<T>() == TypeId::of::<$t>() {
                // SAFETY: there is a token. What `$numbers` gives is sixteen of the exact type of `$t`,
                // which is `T`.
                return unsafe { transmute_copy(&$numbers) };
            })*
        };
    }
    by_type! {
        f32, F32(two!(N => _mm256_castsi256_ps(words[N])));
        u8, F32(two!(N => _mm256_cvtepi32_ps(low_bits::<24>(words[N]))));
        i8, F32(two!(N => _mm256_cvtepi32_ps(signed_low_bits::<24>(words[N]))));
        u16, F32(two!(N => _mm256_cvtepi32_ps(low_bits::<16>(words[N]))));
        i16, F32(two!(N => _mm256_cvtepi32_ps(signed_low_bits::<16>(words[N]))));
        u32, wide.u32_to_f64(U32(words));
        i32, wide.i32_to_f64(U32(words));
    }
    unreachable!("no other type is a lane of four bytes or less")
}

/// Words without so many of their highest bits.
#[inline]
#[target_feature(enable = "avx2")]
fn low_bits<const OTHERS: i32>(words: __m256i) -> __m256i {
    _mm256_srli_epi32::<OTHERS>(_mm256_slli_epi32::<OTHERS>(words))
}

/// The same of numbers with a sign.
#[inline]
#[target_feature(enable = "avx2")]
fn signed_low_bits<const OTHERS: i32>(words: __m256i) -> __m256i {
    _mm256_srai_epi32::<OTHERS>(_mm256_slli_epi32::<OTHERS>(words))
}
