//! The comparisons with 256-bit registers: a comparison gives whole lanes of ones, which are narrowed to
//! bytes, whose top bits are gathered into a mask. There is no unsigned comparison and no "at least"; the
//! greater (or lesser) of two is compared with one of them instead, or the opposite comparison is inverted.
//!
//! Each half of registers is narrowed by itself. So lower halves hold the first 16 of 32 samples and upper halves the
//! others, and what is narrowed is in order.

use super::{Lane, Strided, WORD};
use crate::prefetch::prefetch_ahead;
use std::arch::x86_64::*;

/// Bytes from the samples at hand to those that are asked for. With the 2560 of AVX-512 to classify f32 of 512³ takes
/// 1.18 times as long, and to find their extents 1.07 times (EPYC, Zen 3, November 2026).
pub(crate) const AHEAD: usize = 1024;

/// A module for one type of sample, with the row loops `at_least` and `at_most`. `$cast` gives registers of bits
/// the type that samples are compared in. `$bits` gives the bits of a word's samples, whose registers have lanes of
/// ones. Each word of samples, which stays in the cache, is compared with every bound.
macro_rules! kernels {
    ($t:ident, $lanes:literal, $cast:expr, $splat:expr, $bits:expr, $at_least:expr, $at_most:expr) => {
        pub(super) mod $t {
            use super::*;

            kernels!(@row at_least, $t, $lanes, $cast, $splat, $bits, $at_least);
            kernels!(@row at_most, $t, $lanes, $cast, $splat, $bits, $at_most);
        }
    };
    (@row $name:ident, $t:ident, $lanes:literal, $cast:expr, $splat:expr, $bits:expr, $holds:expr) => {
        #[target_feature(enable = "avx2")]
        pub(in super::super) fn $name(rows: &[[$t; WORD]], bounds: &[$t], out: Strided<'_>) {
            let Strided { out, stride, step } = out;
            for (w, samples) in rows.iter().enumerate() {
                prefetch_ahead::<AHEAD, _>(samples);
                let mut parts = [_mm256_setzero_si256(); WORD / $lanes];
                for (n, part) in parts.iter_mut().enumerate() {
                    *part = halves::<$t, $lanes>(samples, n);
                }
                for (k, &bound) in bounds.iter().enumerate() {
                    let (bound, mut held) = ($splat(bound), parts);
                    for held in &mut held {
                        *held = $holds($cast(*held), bound);
                    }
                    out[k * stride + w * step] = $bits(held);
                }
            }
        }
    };
}

/// Register `n` of a word, of so many samples: half as many of the first 16 of 32, and as many of the others.
#[target_feature(enable = "avx2")]
fn halves<T: Lane, const LANES: usize>(samples: &[T; WORD], n: usize) -> __m256i {
    const { assert!(size_of::<T>() * LANES == 32, "a register") };
    let per_32 = 32 / LANES;
    assert!(n < 2 * per_32, "a register of the word");
    let low = n / per_32 * 32 + n % per_32 * (LANES / 2);
    let low = samples.as_ptr().wrapping_add(low);
    let high = low.wrapping_add(16);
    // SAFETY: both are the first of half a register's worth of samples, the last of which is before sample
    // 32 · (n / per_32 + 1), so in the word; loads need no alignment.
    unsafe { _mm256_loadu2_m128i(high.cast(), low.cast()) }
}

#[target_feature(enable = "avx2")]
fn not(lanes: __m256i) -> __m256i {
    _mm256_xor_si256(lanes, _mm256_set1_epi8(-1))
}

#[target_feature(enable = "avx2")]
fn bits_of_8([low, high]: [__m256i; 2]) -> u64 {
    let bits = |lanes| u64::from(_mm256_movemask_epi8(lanes) as u32);
    bits(low) | bits(high) << 32
}

#[target_feature(enable = "avx2")]
fn bits_of_16([a, b, c, d]: [__m256i; 4]) -> u64 {
    bits_of_8([_mm256_packs_epi16(a, b), _mm256_packs_epi16(c, d)])
}

#[target_feature(enable = "avx2")]
fn bits_of_32([a, b, c, d, e, f, g, h]: [__m256i; 8]) -> u64 {
    let narrow = |a, b| _mm256_packs_epi32(a, b);
    bits_of_16([narrow(a, b), narrow(c, d), narrow(e, f), narrow(g, h)])
}

#[target_feature(enable = "avx2")]
fn bits_of_64(lanes: [__m256i; 16]) -> u64 {
    let mut narrow = [_mm256_setzero_si256(); 8];
    for (narrow, [a, b]) in narrow.iter_mut().zip(lanes.as_chunks::<2>().0) {
        let (a, b) = (_mm256_castsi256_ps(*a), _mm256_castsi256_ps(*b));
        *narrow = _mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(a, b));
    }
    bits_of_32(narrow)
}

kernels!(
    u8,
    32,
    |v| v,
    |b: u8| _mm256_set1_epi8(b as i8),
    bits_of_8,
    |v, b| _mm256_cmpeq_epi8(_mm256_max_epu8(v, b), v),
    |v, b| _mm256_cmpeq_epi8(_mm256_min_epu8(v, b), v)
);
kernels!(
    i8,
    32,
    |v| v,
    _mm256_set1_epi8,
    bits_of_8,
    |v, b| not(_mm256_cmpgt_epi8(b, v)),
    |v, b| not(_mm256_cmpgt_epi8(v, b))
);
kernels!(
    u16,
    16,
    |v| v,
    |b: u16| _mm256_set1_epi16(b as i16),
    bits_of_16,
    |v, b| _mm256_cmpeq_epi16(_mm256_max_epu16(v, b), v),
    |v, b| _mm256_cmpeq_epi16(_mm256_min_epu16(v, b), v)
);
kernels!(
    i16,
    16,
    |v| v,
    _mm256_set1_epi16,
    bits_of_16,
    |v, b| not(_mm256_cmpgt_epi16(b, v)),
    |v, b| not(_mm256_cmpgt_epi16(v, b))
);
kernels!(
    u32,
    8,
    |v| v,
    |b: u32| _mm256_set1_epi32(b as i32),
    bits_of_32,
    |v, b| _mm256_cmpeq_epi32(_mm256_max_epu32(v, b), v),
    |v, b| _mm256_cmpeq_epi32(_mm256_min_epu32(v, b), v)
);
kernels!(
    i32,
    8,
    |v| v,
    _mm256_set1_epi32,
    bits_of_32,
    |v, b| not(_mm256_cmpgt_epi32(b, v)),
    |v, b| not(_mm256_cmpgt_epi32(v, b))
);
kernels!(
    f32,
    8,
    _mm256_castsi256_ps,
    _mm256_set1_ps,
    bits_of_32,
    |v, b| _mm256_castps_si256(_mm256_cmp_ps::<_CMP_GE_OQ>(v, b)),
    |v, b| _mm256_castps_si256(_mm256_cmp_ps::<_CMP_LE_OQ>(v, b))
);
kernels!(
    f64,
    4,
    _mm256_castsi256_pd,
    _mm256_set1_pd,
    bits_of_64,
    |v, b| _mm256_castpd_si256(_mm256_cmp_pd::<_CMP_GE_OQ>(v, b)),
    |v, b| _mm256_castpd_si256(_mm256_cmp_pd::<_CMP_LE_OQ>(v, b))
);
