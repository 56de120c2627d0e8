//! The comparisons with 512-bit registers: a comparison is its own bit mask.

use super::prefetch_ahead;
use std::arch::x86_64::*;

/// A module for one type of sample, with the row loops `at_least` and `at_most`. For each word of samples,
/// which stays in the cache, `out` gets a word for each bound.
macro_rules! kernels {
    ($t:ident, $lanes:literal, $load:expr, $splat:expr, $at_least:expr, $at_most:expr) => {
        pub(super) mod $t {
            use super::*;

            kernels!(@row at_least, $t, $lanes, $load, $splat, $at_least);
            kernels!(@row at_most, $t, $lanes, $load, $splat, $at_most);
        }
    };
    (@row $name:ident, $t:ident, $lanes:literal, $load:expr, $splat:expr, $compare:expr) => {
        #[target_feature(enable = "avx512f,avx512bw")]
        pub(in super::super) fn $name(rows: &[[$t; 64]], bounds: &[$t], out: &mut [u64]) {
            for (words, samples) in out.chunks_exact_mut(bounds.len()).zip(rows) {
                prefetch_ahead(samples);
                let (parts, _) = samples.as_chunks::<$lanes>();
                for (word, &bound) in words.iter_mut().zip(bounds) {
                    let (bound, mut bits) = ($splat(bound), 0);
                    for part in parts.iter().rev() {
                        // SAFETY: `part` is one register's worth of samples; the load needs no
                        // alignment.
                        let part = unsafe { $load(part.as_ptr().cast()) };
                        bits = match $lanes {
                            64 => u64::from($compare(part, bound)),
                            _ => bits << ($lanes % 64) | u64::from($compare(part, bound)),
                        };
                    }
                    *word = bits;
                }
            }
        }
    };
}

kernels!(
    u8,
    64,
    _mm512_loadu_epi8,
    |b: u8| _mm512_set1_epi8(b as i8),
    _mm512_cmpge_epu8_mask,
    _mm512_cmple_epu8_mask
);
kernels!(
    i8,
    64,
    _mm512_loadu_epi8,
    _mm512_set1_epi8,
    _mm512_cmpge_epi8_mask,
    _mm512_cmple_epi8_mask
);
kernels!(
    u16,
    32,
    _mm512_loadu_epi16,
    |b: u16| _mm512_set1_epi16(b as i16),
    _mm512_cmpge_epu16_mask,
    _mm512_cmple_epu16_mask
);
kernels!(
    i16,
    32,
    _mm512_loadu_epi16,
    _mm512_set1_epi16,
    _mm512_cmpge_epi16_mask,
    _mm512_cmple_epi16_mask
);
kernels!(
    u32,
    16,
    _mm512_loadu_epi32,
    |b: u32| _mm512_set1_epi32(b as i32),
    _mm512_cmpge_epu32_mask,
    _mm512_cmple_epu32_mask
);
kernels!(
    i32,
    16,
    _mm512_loadu_epi32,
    _mm512_set1_epi32,
    _mm512_cmpge_epi32_mask,
    _mm512_cmple_epi32_mask
);
kernels!(
    f32,
    16,
    _mm512_loadu_ps,
    _mm512_set1_ps,
    _mm512_cmp_ps_mask::<_CMP_GE_OQ>,
    _mm512_cmp_ps_mask::<_CMP_LE_OQ>
);
kernels!(
    f64,
    8,
    _mm512_loadu_pd,
    _mm512_set1_pd,
    _mm512_cmp_pd_mask::<_CMP_GE_OQ>,
    _mm512_cmp_pd_mask::<_CMP_LE_OQ>
);
