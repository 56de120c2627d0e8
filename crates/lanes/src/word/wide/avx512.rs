//! Eight words in an AVX-512 register.

use super::{Bits, Pack};
use std::{
    arch::x86_64::*,
    ops::{Add, BitAnd, BitOr, BitXor, Not},
};

/// Eight words.
#[derive(Clone, Copy)]
pub(crate) struct Eight(__m512i);

impl Pack for Eight {
    type Words = [u64; 8];
    type Column = __m512i;
    type Columns = [__m512i; 8];

    const WORDS: usize = 8;

    #[inline(always)]
    unsafe fn splat(word: u64) -> Self {
        // SAFETY: the caller says that the machine has the instructions.
        Self(unsafe { _mm512_set1_epi64(word as i64) })
    }

    #[inline(always)]
    unsafe fn load(words: &[u64]) -> Self {
        let own = if words.len() < 8 { (1_u8 << words.len()) - 1 } else { u8::MAX };
        // SAFETY: the caller says that the machine has the instructions; the mask lets through only the words.
        Self(unsafe { _mm512_maskz_loadu_epi64(own, words.as_ptr().cast()) })
    }

    #[inline(always)]
    unsafe fn load_all(words: *const u64) -> Self {
        // SAFETY: the caller says so; eight words are one register, and the load needs no alignment.
        Self(unsafe { _mm512_loadu_epi64(words.cast()) })
    }

    #[inline(always)]
    fn shifted_in(self, next: Self) -> Self {
        // SAFETY: a register exists only where the instructions do; so in all that follows.
        Self(unsafe { _mm512_shrdi_epi64::<1>(self.0, next.0) })
    }

    #[inline(always)]
    fn at(self, places: u8) -> Self {
        // SAFETY: there is a register.
        Self(unsafe { _mm512_mask_blend_epi64(places, _mm512_set1_epi64(-1), self.0) })
    }

    #[inline(always)]
    fn found(self) -> u8 {
        // SAFETY: there is a register.
        unsafe { _mm512_test_epi64_mask(self.0, self.0) }
    }

    #[inline(always)]
    fn count_ones(self) -> Self {
        // SAFETY: there is a register.
        Self(unsafe { _mm512_popcnt_epi64(self.0) })
    }

    #[inline(always)]
    fn quarters([a, b, c, d]: [Self; 4]) -> Self {
        // SAFETY: there is a register.
        let (b, c, d) = unsafe {
            (
                _mm512_slli_epi64::<16>(b.0),
                _mm512_slli_epi64::<32>(c.0),
                _mm512_slli_epi64::<48>(d.0),
            )
        };
        a | Self(b) | Self(c) | Self(d)
    }

    #[inline(always)]
    fn words(self) -> [u64; 8] {
        let mut words = [0; 8];
        // SAFETY: eight words are one register; the store needs no alignment.
        unsafe { _mm512_storeu_epi64(words.as_mut_ptr().cast(), self.0) };
        words
    }

    #[inline(always)]
    fn columns(packs: [Self; 8]) -> [__m512i; 8] {
        // SAFETY: there is a register.
        unsafe { transposed(packs.map(|pack| pack.0)) }
    }

    #[inline(always)]
    fn eight(column: __m512i) -> [u64; 8] {
        Self(column).words()
    }
}

/// Register `n` of what comes out holds number `n` of each register.
#[inline]
#[target_feature(enable = "avx512f")]
fn transposed(rows: [__m512i; 8]) -> [__m512i; 8] {
    let mut pairs = rows;
    for n in 0..4 {
        pairs[2 * n] = _mm512_unpacklo_epi64(rows[2 * n], rows[2 * n + 1]);
        pairs[2 * n + 1] = _mm512_unpackhi_epi64(rows[2 * n], rows[2 * n + 1]);
    }
    let mut columns = rows;
    for odd in 0..2 {
        let [a, b, c, d] = [pairs[odd], pairs[2 + odd], pairs[4 + odd], pairs[6 + odd]];
        let (ab, cd) = (_mm512_shuffle_i64x2::<0x88>(a, b), _mm512_shuffle_i64x2::<0x88>(c, d));
        columns[odd] = _mm512_shuffle_i64x2::<0x88>(ab, cd);
        columns[4 + odd] = _mm512_shuffle_i64x2::<0xDD>(ab, cd);
        let (ab, cd) = (_mm512_shuffle_i64x2::<0xDD>(a, b), _mm512_shuffle_i64x2::<0xDD>(c, d));
        columns[2 + odd] = _mm512_shuffle_i64x2::<0x88>(ab, cd);
        columns[6 + odd] = _mm512_shuffle_i64x2::<0xDD>(ab, cd);
    }
    columns
}

operators!(
    Eight _mm512_set1_epi64(-1),
    Add add _mm512_add_epi64,
    BitAnd bitand _mm512_and_si512,
    BitOr bitor _mm512_or_si512,
    BitXor bitxor _mm512_xor_si512
);
