//! Samples from sixteen places. Neighbours along x come together where they lie in four bytes, or in eight.

use super::{
    Avx512, halves,
    registers::{F32, F64, U32},
};
use crate::{
    Lane,
    wide::{BATCH, Exact, Wide},
};
use std::{any::TypeId, arch::x86_64::*, mem::transmute_copy, sync::OnceLock};

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

/// The same, loaded one by one: see [`is_gather_quick`].
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

/// Whether words from sixteen places come sooner by one instruction than one by one, where no neighbours come along.
///
/// Surfaces of scans take 0.94 to 0.97 of the time so, with normals 0.92 to 0.96, on an Intel Xeon of the fourth
/// generation or the fifth (November 2026). It loses on an EPYC with Zen 4, and on Intel machines before those, whose
/// microcode slows it since an attack of 2023 (Gather Data Sampling). The first that need no such thing have FP16.
pub(crate) fn is_gather_quick() -> bool {
    static IS_QUICK: OnceLock<bool> = OnceLock::new();
    *IS_QUICK.get_or_init(|| {
        let vendor = __cpuid(0);
        let name = [vendor.ebx, vendor.edx, vendor.ecx].map(u32::to_le_bytes);
        name.as_flattened() == b"GenuineIntel" && is_x86_feature_detected!("avx512fp16")
    })
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

#[cfg(test)]
mod tests {
    use crate::{
        Lane, Level, Samples,
        wide::{BATCH, Exact, Wide, avx512::Avx512},
    };

    #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
    fn loaded<T: Lane>(
        gathers: bool,
        samples: &Samples<'_, T>,
        at: &[u32; BATCH],
    ) -> [T::Exact; BATCH] {
        let mut out = [T::Exact::default(); BATCH];
        // SAFETY: this function runs only where the machine has AVX-512.
        let wide = unsafe { Avx512::new(gathers) };
        // SAFETY: at least four bytes follow on each number, and there is one slice.
        let numbers = unsafe { wide.near(samples, 40, wide.load(at)) };
        T::Exact::store(wide, numbers, &mut out);
        out
    }

    fn check<T: Lane>(of: impl Fn(u32) -> T) {
        let all: Vec<T> = (0..84).map(of).collect();
        let samples = Samples::new(&all, 0, [1, 8, 80], [8, 10, 1]).expect("80 samples");
        for first in 0..BATCH {
            // Up and down from number 40, the first and the last of the slice among them.
            let places = std::array::from_fn(|n| ((n + first) % BATCH * 53 + first) % 80);
            let at = places.map(|place| (place as u32).wrapping_sub(40));
            let expected = places.map(|place| all[place].into());
            for gathers in [false, true] {
                // SAFETY: the machine has the level, as the caller has seen.
                let found = unsafe { loaded(gathers, &samples, &at) };
                assert_eq!(found.map(Into::into), expected, "{gathers}, {places:?}");
            }
        }
    }

    #[test]
    fn words_are_the_same_by_one_instruction_and_one_by_one() {
        if !Level::available().contains(&Level::Avx512) {
            return;
        }
        check(|n| (n * 7 + 3) as u8);
        check(|n| (n * 7 + 3) as u8 as i8);
        check(|n| (n * 1031 + 200) as u16);
        check(|n| (n * 1031 + 200) as u16 as i16);
        check(|n| n.wrapping_mul(0x9E37_79B9));
        check(|n| n.wrapping_mul(0x9E37_79B9) as i32);
        check(|n| n as f32 * 0.1 - 3.0);
        check(|n| f64::from(n) * 0.1 - 3.0);
    }
}
