//! The comparisons with 256-bit registers: a comparison gives whole lanes of ones, which are narrowed to
//! bytes, whose top bits are gathered into a mask. There is no unsigned comparison and no "at least"; the
//! greater (or lesser) of two is compared with one of them instead, or the opposite comparison is inverted.

use super::{Strided, prefetch_ahead};
use std::arch::x86_64::*;

/// A module for one type of sample, with the row loops `at_least` and `at_most`. `$bits` gives the bits of
/// a word's samples, whose registers have lanes of ones. Each word of samples, which stays in the cache, is
/// compared with every bound.
macro_rules! kernels {
    ($t:ident, $lanes:literal, $load:expr, $splat:expr, $bits:expr, $at_least:expr, $at_most:expr) => {
        pub(super) mod $t {
            use super::*;

            kernels!(@row at_least, $t, $lanes, $load, $splat, $bits, $at_least);
            kernels!(@row at_most, $t, $lanes, $load, $splat, $bits, $at_most);
        }
    };
    (@row $name:ident, $t:ident, $lanes:literal, $load:expr, $splat:expr, $bits:expr, $holds:expr) => {
        #[target_feature(enable = "avx2")]
        pub(in super::super) fn $name(rows: &[[$t; 64]], bounds: &[$t], out: Strided<'_>) {
            let Strided { out, stride } = out;
            for (w, samples) in rows.iter().enumerate() {
                prefetch_ahead(samples);
                let (parts, _) = samples.as_chunks::<$lanes>();
                for (k, &bound) in bounds.iter().enumerate() {
                    let (bound, mut held) = ($splat(bound), [_mm256_setzero_si256(); 64 / $lanes]);
                    for (held, part) in held.iter_mut().zip(parts) {
                        // SAFETY: `part` is one register's worth of samples; the load needs no
                        // alignment.
                        let part = unsafe { $load(part.as_ptr().cast()) };
                        *held = $holds(part, bound);
                    }
                    out[k * stride + w] = $bits(held);
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
fn bits_of_8([low, high]: [__m256i; 2]) -> u64 {
    let bits = |lanes| u64::from(_mm256_movemask_epi8(lanes) as u32);
    bits(low) | bits(high) << 32
}

#[target_feature(enable = "avx2")]
fn bits_of_16([a, b, c, d]: [__m256i; 4]) -> u64 {
    // Registers are narrowed by halves: first the lower ones of both.
    let narrow = |a, b| _mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_packs_epi16(a, b));
    bits_of_8([narrow(a, b), narrow(c, d)])
}

#[target_feature(enable = "avx2")]
fn bits_of_32([a, b, c, d, e, f, g, h]: [__m256i; 8]) -> u64 {
    // As above: the lower halves of all four, and then the upper ones.
    let order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
    let narrow = |a, b, c, d| {
        let halves = _mm256_packs_epi16(_mm256_packs_epi32(a, b), _mm256_packs_epi32(c, d));
        _mm256_permutevar8x32_epi32(halves, order)
    };
    bits_of_8([narrow(a, b, c, d), narrow(e, f, g, h)])
}

#[target_feature(enable = "avx2")]
fn bits_of_64(lanes: [__m256i; 16]) -> u64 {
    let mut narrow = [_mm256_setzero_si256(); 8];
    for (narrow, [a, b]) in narrow.iter_mut().zip(lanes.as_chunks::<2>().0) {
        let (a, b) = (_mm256_castsi256_ps(*a), _mm256_castsi256_ps(*b));
        let halves = _mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(a, b));
        *narrow = _mm256_permute4x64_epi64::<0b11_01_10_00>(halves);
    }
    bits_of_32(narrow)
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
    bits_of_32,
    |v, b| _mm256_castps_si256(_mm256_cmp_ps::<_CMP_GE_OQ>(v, b)),
    |v, b| _mm256_castps_si256(_mm256_cmp_ps::<_CMP_LE_OQ>(v, b))
);
kernels!(
    f64,
    4,
    _mm256_loadu_pd,
    _mm256_set1_pd,
    bits_of_64,
    |v, b| _mm256_castpd_si256(_mm256_cmp_pd::<_CMP_GE_OQ>(v, b)),
    |v, b| _mm256_castpd_si256(_mm256_cmp_pd::<_CMP_LE_OQ>(v, b))
);
