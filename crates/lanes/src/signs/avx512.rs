//! The comparisons with 512-bit registers: a comparison is its own bit mask.

use super::Strided;
use crate::prefetch::prefetch_ahead;
use std::arch::x86_64::*;

/// Bytes from the samples at hand to those that are asked for: rows `classify` and `index` of `scripts/bench`, on a Xeon.
pub(crate) const AHEAD: usize = 2560;

/// A module for one type of sample, with the row loops `at_least` and `at_most`. Each word of
/// samples, which stays in the cache, is compared with every bound.
macro_rules! kernels {
    ($t:ident, $lanes:literal, $mask:ident, $load:expr, $splat:expr, $at_least:expr, $at_most:expr) => {
        pub(super) mod $t {
            use super::*;

            kernels!(@row at_least, $t, $lanes, $mask, $load, $splat, $at_least);
            kernels!(@row at_most, $t, $lanes, $mask, $load, $splat, $at_most);
        }
    };
    (@row $name:ident, $t:ident, $lanes:literal, $mask:ident, $load:expr, $splat:expr, $compare:expr) => {
        #[target_feature(enable = "avx512f,avx512bw")]
        pub(in super::super) fn $name(rows: &[[$t; 64]], bounds: &[$t], out: Strided<'_>) {
            let Strided { out, stride, step } = out;
            let last = bounds.len().saturating_sub(1) * stride;
            for (w, samples) in rows.iter().enumerate() {
                prefetch_ahead::<AHEAD, _>(samples);
                let words = out[w * step..=w * step + last].as_mut_ptr();
                let (parts, _) = samples.as_chunks::<$lanes>();
                // SAFETY: each part is one register's worth of samples; the load needs no alignment.
                let parts: [_; 64 / $lanes] =
                    std::array::from_fn(|n| unsafe { $load(parts[n].as_ptr().cast()) });
                for (k, &bound) in bounds.iter().enumerate() {
                    let bound = $splat(bound);
                    for (n, part) in parts.into_iter().enumerate() {
                        // SAFETY: the word of the last bound is among those that were asked for, and the masks of all
                        // parts fill it.
                        let mask = unsafe { words.add(k * stride).cast::<$mask>().add(n) };
                        // SAFETY: as above; `out` is borrowed, and nobody else writes there.
                        unsafe { mask.write($compare(part, bound)) };
                    }
                }
            }
        }
    };
}

kernels!(
    u8,
    64,
    u64,
    _mm512_loadu_epi8,
    |b: u8| _mm512_set1_epi8(b as i8),
    _mm512_cmpge_epu8_mask,
    _mm512_cmple_epu8_mask
);
kernels!(
    i8,
    64,
    u64,
    _mm512_loadu_epi8,
    _mm512_set1_epi8,
    _mm512_cmpge_epi8_mask,
    _mm512_cmple_epi8_mask
);
kernels!(
    u16,
    32,
    u32,
    _mm512_loadu_epi16,
    |b: u16| _mm512_set1_epi16(b as i16),
    _mm512_cmpge_epu16_mask,
    _mm512_cmple_epu16_mask
);
kernels!(
    i16,
    32,
    u32,
    _mm512_loadu_epi16,
    _mm512_set1_epi16,
    _mm512_cmpge_epi16_mask,
    _mm512_cmple_epi16_mask
);
kernels!(
    u32,
    16,
    u16,
    _mm512_loadu_epi32,
    |b: u32| _mm512_set1_epi32(b as i32),
    _mm512_cmpge_epu32_mask,
    _mm512_cmple_epu32_mask
);
kernels!(
    i32,
    16,
    u16,
    _mm512_loadu_epi32,
    _mm512_set1_epi32,
    _mm512_cmpge_epi32_mask,
    _mm512_cmple_epi32_mask
);
kernels!(
    f32,
    16,
    u16,
    _mm512_loadu_ps,
    _mm512_set1_ps,
    _mm512_cmp_ps_mask::<_CMP_GE_OQ>,
    _mm512_cmp_ps_mask::<_CMP_LE_OQ>
);
kernels!(
    f64,
    8,
    u8,
    _mm512_loadu_pd,
    _mm512_set1_pd,
    _mm512_cmp_pd_mask::<_CMP_GE_OQ>,
    _mm512_cmp_pd_mask::<_CMP_LE_OQ>
);
