//! Samples from sixteen places. Neighbours along x come together where they lie in four bytes, or in eight.

use super::{
    Avx512, halves,
    registers::{F32, F64, U32},
};
use crate::{
    Lane,
    wide::{BATCH, Exact, Wide},
};
use std::{any::TypeId, arch::x86_64::*, mem::transmute_copy};

/// The four bytes from each sample on, of samples of four bytes at most.
///
/// # Safety
///
/// They must lie in the slice that `base` was made from, where `at` counts up and down from it.
#[inline(always)]
pub(super) unsafe fn gather<T>(_: Avx512, base: *const T, at: U32) -> __m512i {
    // SAFETY: there is a token, and the caller says that these bytes are there.
    unsafe {
        match size_of::<T>() {
            1 => _mm512_i32gather_epi32::<1>(at.0, base.cast()),
            2 => _mm512_i32gather_epi32::<2>(at.0, base.cast()),
            _ => _mm512_i32gather_epi32::<4>(at.0, base.cast()),
        }
    }
}

/// The same, loaded one by one, which costs less where no neighbours come along.
///
/// # Safety
///
/// As of [`gather`].
#[inline(always)]
pub(super) unsafe fn singly<T>(wide: Avx512, base: *const T, at: U32) -> __m512i {
    let numbers = wide.store(at);
    let mut words = [0; BATCH];
    for (word, number) in words.iter_mut().zip(numbers) {
        let sample = base.wrapping_offset(number as i32 as isize);
        // SAFETY: the caller says that these bytes are there.
        *word = unsafe { sample.cast::<u32>().read_unaligned() };
    }
    wide.load(&words).0
}

/// A number from each place.
///
/// # Safety
///
/// They must lie in the slice that `base` was made from, where `at` counts up and down from it.
#[inline(always)]
pub(super) unsafe fn gather_f64(wide: Avx512, base: *const f64, at: U32) -> F64 {
    let [low, high] = halves(wide, at.0);
    // SAFETY: there is a token, and the caller says that these numbers are there.
    unsafe { F64(_mm512_i32gather_pd::<8>(low, base), _mm512_i32gather_pd::<8>(high, base)) }
}

/// Of the two words from each place on: all first ones, and all second ones.
///
/// # Safety
///
/// Both must lie in the slice that `base` was made from, where `at` counts up and down from it.
#[inline(always)]
pub(super) unsafe fn words_of_two<T>(wide: Avx512, base: *const T, at: U32) -> [__m512i; 2] {
    let [low, high] = halves(wide, at.0);
    let [first, second] = [wide.load(&FIRST).0, wide.load(&SECOND).0];
    // SAFETY: there is a token, and the caller says that these words are there.
    unsafe {
        let low = _mm512_i32gather_epi64::<4>(low, base.cast());
        let high = _mm512_i32gather_epi64::<4>(high, base.cast());
        [_mm512_permutex2var_epi32(low, first, high), _mm512_permutex2var_epi32(low, second, high)]
    }
}

/// Which words of two registers of pairs are the first ones, and the second ones.
const FIRST: [u32; BATCH] = every_second(0);
const SECOND: [u32; BATCH] = every_second(1);

const fn every_second(first: u32) -> [u32; BATCH] {
    let mut words = [0; BATCH];
    let mut n = 0;
    while n < BATCH {
        words[n] = 2 * n as u32 + first;
        n += 1;
    }
    words
}

/// Words without so many of their lowest bits.
#[inline(always)]
pub(super) fn without<const LOWEST: u32>(_: Avx512, words: __m512i) -> __m512i {
    // SAFETY: there is a token.
    unsafe { _mm512_srli_epi32::<LOWEST>(words) }
}

/// The samples in the lowest bits of words, in the type that holds them exactly.
#[inline(always)]
pub(super) fn exact<T: Lane>(wide: Avx512, words: __m512i) -> <T::Exact as Exact>::Of<Avx512> {
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
        f32, F32(_mm512_castsi512_ps(words));
        u8, F32(_mm512_cvtepi32_ps(_mm512_and_si512(words, _mm512_set1_epi32(0xFF))));
        i8, F32(_mm512_cvtepi32_ps(_mm512_srai_epi32::<24>(_mm512_slli_epi32::<24>(words))));
        u16, F32(_mm512_cvtepi32_ps(_mm512_and_si512(words, _mm512_set1_epi32(0xFFFF))));
        i16, F32(_mm512_cvtepi32_ps(_mm512_srai_epi32::<16>(_mm512_slli_epi32::<16>(words))));
        u32, wide.u32_to_f64(U32(words));
        i32, wide.i32_to_f64(U32(words));
    }
    unreachable!("no other type is a lane of four bytes or less")
}
