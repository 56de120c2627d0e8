//! The comparisons with 256-bit registers: a comparison gives whole lanes of ones, whose top bits are
//! gathered into a mask. There is no unsigned comparison and no "at least"; the greater (or lesser) of
//! two is compared with one of them instead, or the opposite comparison is inverted.

use super::{Strided, prefetch_ahead};
use std::arch::x86_64::*;

/// A module for one type of sample, with the row loops `at_least` and `at_most`. `$mask` gives the bits of
/// one register's samples whose lanes are ones. Each word of samples, which stays in the cache, is
/// compared with every bound.
macro_rules! kernels {
    ($t:ident, $lanes:literal, $load:expr, $splat:expr, $mask:expr, $at_least:expr, $at_most:expr) => {
        pub(super) mod $t {
            use super::*;

            kernels!(@row at_least, $t, $lanes, $load, $splat, $mask, $at_least);
            kernels!(@row at_most, $t, $lanes, $load, $splat, $mask, $at_most);
        }
    };
    (@row $name:ident, $t:ident, $lanes:literal, $load:expr, $splat:expr, $mask:expr, $holds:expr) => {
        #[target_feature(enable = "avx2")]
        pub(in super::super) fn $name(rows: &[[$t; 64]], bounds: &[$t], out: Strided<'_>) {
            let Strided { out, stride } = out;
            for (w, samples) in rows.iter().enumerate() {
                prefetch_ahead(samples);
                let (parts, _) = samples.as_chunks::<$lanes>();
                for (k, &bound) in bounds.iter().enumerate() {
                    let (bound, mut bits) = ($splat(bound), 0);
                    for part in parts.iter().rev() {
                        // SAFETY: `part` is one register's worth of samples; the load needs no
                        // alignment.
                        let part = unsafe { $load(part.as_ptr().cast()) };
                        bits = bits << $lanes | $mask($holds(part, bound));
                    }
                    out[k * stride + w] = bits;
                }
            }
        }
    };
}

#[target_feature(enable = "avx2")]
fn not(lanes: __m256i) -> __m256i {
    _mm256_xor_si256(lanes, _mm256_set1_epi8(-1))
}

#[target_feature(enable = "avx2")]
fn bits_of_8(lanes: __m256i) -> u64 {
    u64::from(_mm256_movemask_epi8(lanes) as u32)
}

/// The lanes are first narrowed to bytes, half of them into each half of a shorter register.
#[target_feature(enable = "avx2")]
fn bits_of_16(lanes: __m256i) -> u64 {
    let (low, high) = (_mm256_castsi256_si128(lanes), _mm256_extracti128_si256::<1>(lanes));
    u64::from(_mm_movemask_epi8(_mm_packs_epi16(low, high)) as u32)
}

#[target_feature(enable = "avx2")]
fn bits_of_32(lanes: __m256i) -> u64 {
    bits_of_f32(_mm256_castsi256_ps(lanes))
}

#[target_feature(enable = "avx2")]
fn bits_of_f32(lanes: __m256) -> u64 {
    u64::from(_mm256_movemask_ps(lanes) as u32)
}

#[target_feature(enable = "avx2")]
fn bits_of_f64(lanes: __m256d) -> u64 {
    u64::from(_mm256_movemask_pd(lanes) as u32)
}

kernels!(
    u8,
    32,
    _mm256_loadu_si256,
    |b: u8| _mm256_set1_epi8(b as i8),
    bits_of_8,
    |v, b| _mm256_cmpeq_epi8(_mm256_max_epu8(v, b), v),
    |v, b| _mm256_cmpeq_epi8(_mm256_min_epu8(v, b), v)
);
kernels!(
    i8,
    32,
    _mm256_loadu_si256,
    _mm256_set1_epi8,
    bits_of_8,
    |v, b| not(_mm256_cmpgt_epi8(b, v)),
    |v, b| not(_mm256_cmpgt_epi8(v, b))
);
kernels!(
    u16,
    16,
    _mm256_loadu_si256,
    |b: u16| _mm256_set1_epi16(b as i16),
    bits_of_16,
    |v, b| _mm256_cmpeq_epi16(_mm256_max_epu16(v, b), v),
    |v, b| _mm256_cmpeq_epi16(_mm256_min_epu16(v, b), v)
);
kernels!(
    i16,
    16,
    _mm256_loadu_si256,
    _mm256_set1_epi16,
    bits_of_16,
    |v, b| not(_mm256_cmpgt_epi16(b, v)),
    |v, b| not(_mm256_cmpgt_epi16(v, b))
);
kernels!(
    u32,
    8,
    _mm256_loadu_si256,
    |b: u32| _mm256_set1_epi32(b as i32),
    bits_of_32,
    |v, b| _mm256_cmpeq_epi32(_mm256_max_epu32(v, b), v),
    |v, b| _mm256_cmpeq_epi32(_mm256_min_epu32(v, b), v)
);
kernels!(
    i32,
    8,
    _mm256_loadu_si256,
    _mm256_set1_epi32,
    bits_of_32,
    |v, b| not(_mm256_cmpgt_epi32(b, v)),
    |v, b| not(_mm256_cmpgt_epi32(v, b))
);
kernels!(
    f32,
    8,
    _mm256_loadu_ps,
    _mm256_set1_ps,
    bits_of_f32,
    _mm256_cmp_ps::<_CMP_GE_OQ>,
    _mm256_cmp_ps::<_CMP_LE_OQ>
);
kernels!(
    f64,
    4,
    _mm256_loadu_pd,
    _mm256_set1_pd,
    bits_of_f64,
    _mm256_cmp_pd::<_CMP_GE_OQ>,
    _mm256_cmp_pd::<_CMP_LE_OQ>
);
