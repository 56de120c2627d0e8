//! Four words in an AVX2 register.

use super::{Bits, Pack};
use std::{
    arch::x86_64::*,
    ops::{Add, BitAnd, BitOr, BitXor, Not},
};

/// Four words.
#[derive(Clone, Copy)]
pub(crate) struct Four(__m256i);

/// Ones at the words whose bits are not set.
const ELSEWHERE: [[u64; 4]; 16] = {
    let mut table = [[0; 4]; 16];
    let mut i = 0;
    while i < 64 {
        if (i / 4) >> (i % 4) & 1 == 0 {
            table[i / 4][i % 4] = u64::MAX;
        }
        i += 1;
    }
    table
};

impl Pack for Four {
    type Words = [u64; 4];
    type Column = [Four; 2];
    type Columns = [[Four; 2]; 4];

    const WORDS: usize = 4;

    #[inline(always)]
    unsafe fn splat(word: u64) -> Self {
        // SAFETY: the caller says that the machine has the instructions.
        Self(unsafe { _mm256_set1_epi64x(word as i64) })
    }

    #[inline(always)]
    unsafe fn load(words: &[u64]) -> Self {
        let all = words.first_chunk::<4>().copied();
        let four =
            all.unwrap_or_else(|| [0, 1, 2, 3].map(|n| words.get(n).map_or(0, |word| *word)));
        // SAFETY: the caller says that the machine has the instructions; four words are one register, and the
        // load needs no alignment.
        Self(unsafe { _mm256_loadu_si256(four.as_ptr().cast()) })
    }

    #[inline(always)]
    unsafe fn load_all(words: *const u64) -> Self {
        // SAFETY: the caller says so; four words are one register, and the load needs no alignment.
        Self(unsafe { _mm256_loadu_si256(words.cast()) })
    }

    #[inline(always)]
    fn shifted_in(self, next: Self) -> Self {
        // SAFETY: a register exists only where the instructions do; so in all that follows.
        Self(unsafe {
            _mm256_or_si256(_mm256_srli_epi64::<1>(self.0), _mm256_slli_epi64::<63>(next.0))
        })
    }

    #[inline(always)]
    fn at(self, places: u8) -> Self {
        let elsewhere = &ELSEWHERE[usize::from(places & 0xF)];
        // SAFETY: there is a register; four words are one, and the load needs no alignment.
        Self(unsafe { _mm256_or_si256(self.0, _mm256_loadu_si256(elsewhere.as_ptr().cast())) })
    }

    #[inline(always)]
    fn found(self) -> u8 {
        // SAFETY: there is a register.
        unsafe {
            let zero = _mm256_cmpeq_epi64(self.0, _mm256_setzero_si256());
            !_mm256_movemask_pd(_mm256_castsi256_pd(zero)) as u8 & 0xF
        }
    }

    #[inline(always)]
    fn count_ones(self) -> Self {
        self.ones_of_bytes().sums_of_bytes()
    }

    /// The numbers are added up byte by byte first.
    #[inline(always)]
    fn sums([ones, twos, fours]: [Self; 3]) -> Self {
        let pairs = twos.ones_of_bytes_times::<2>().add_bytes(fours.ones_of_bytes_times::<4>());
        ones.ones_of_bytes().add_bytes(pairs).sums_of_bytes()
    }

    #[inline(always)]
    fn quarters([a, b, c, d]: [Self; 4]) -> Self {
        // SAFETY: there is a register.
        let (b, c, d) = unsafe {
            (
                _mm256_slli_epi64::<16>(b.0),
                _mm256_slli_epi64::<32>(c.0),
                _mm256_slli_epi64::<48>(d.0),
            )
        };
        a | Self(b) | Self(c) | Self(d)
    }

    #[inline(always)]
    fn words(self) -> [u64; 4] {
        let mut words = [0; 4];
        // SAFETY: four words are one register; the store needs no alignment.
        unsafe { _mm256_storeu_si256(words.as_mut_ptr().cast(), self.0) };
        words
    }

    #[inline(always)]
    fn columns([a, b, c, d, e, f, g, h]: [Self; 8]) -> [[Four; 2]; 4] {
        let ([a, b, c, d], [e, f, g, h]) = (transposed([a, b, c, d]), transposed([e, f, g, h]));
        [[a, e], [b, f], [c, g], [d, h]]
    }

    #[inline(always)]
    fn eight([low, high]: [Four; 2]) -> [u64; 8] {
        let ([a, b, c, d], [e, f, g, h]) = (low.words(), high.words());
        [a, b, c, d, e, f, g, h]
    }
}

impl Four {
    /// How many bits of each byte are set.
    #[inline(always)]
    pub(crate) fn ones_of_bytes(self) -> Self {
        self.ones_of_bytes_times::<1>()
    }

    /// The same, so many times.
    #[inline(always)]
    fn ones_of_bytes_times<const TIMES: u8>(self) -> Self {
        const ONES: [u8; 16] = [0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4];
        // SAFETY: there is a register; sixteen bytes are one of half the size, and the load needs no alignment.
        Self(unsafe {
            let nibbles = _mm256_set1_epi8(0xF);
            let ones = const { times(ONES, TIMES) };
            let ones = _mm256_broadcastsi128_si256(_mm_loadu_si128(ones.as_ptr().cast()));
            let low = _mm256_and_si256(self.0, nibbles);
            let high = _mm256_and_si256(_mm256_srli_epi16::<4>(self.0), nibbles);
            _mm256_add_epi8(_mm256_shuffle_epi8(ones, low), _mm256_shuffle_epi8(ones, high))
        })
    }

    /// Each word shifted down by one bit, and above it the word of `next` shifted up by as many bits as `up` says.
    #[inline(always)]
    pub(crate) fn followed_by(self, next: Self, up: Self) -> Self {
        // SAFETY: there is a register.
        Self(unsafe {
            _mm256_or_si256(_mm256_srli_epi64::<1>(self.0), _mm256_sllv_epi64(next.0, up.0))
        })
    }

    /// The bits of another that are not set here.
    #[inline(always)]
    pub(crate) fn outside(self, other: Self) -> Self {
        // SAFETY: there is a register.
        Self(unsafe { _mm256_andnot_si256(self.0, other.0) })
    }

    /// Each byte with the same of another added.
    #[inline(always)]
    pub(crate) fn add_bytes(self, other: Self) -> Self {
        // SAFETY: there is a register.
        Self(unsafe { _mm256_add_epi8(self.0, other.0) })
    }

    /// The sum of the bytes of each word.
    #[inline(always)]
    pub(crate) fn sums_of_bytes(self) -> Self {
        // SAFETY: there is a register.
        Self(unsafe { _mm256_sad_epu8(self.0, _mm256_setzero_si256()) })
    }
}

const fn times(mut bytes: [u8; 16], times: u8) -> [u8; 16] {
    let mut n = 0;
    while n < 16 {
        bytes[n] *= times;
        n += 1;
    }
    bytes
}

/// Register `n` of what comes out holds number `n` of each register.
#[inline(always)]
fn transposed([a, b, c, d]: [Four; 4]) -> [Four; 4] {
    // SAFETY: there is a register.
    unsafe {
        let (ab, cd) = (_mm256_unpacklo_epi64(a.0, b.0), _mm256_unpacklo_epi64(c.0, d.0));
        let (ab1, cd1) = (_mm256_unpackhi_epi64(a.0, b.0), _mm256_unpackhi_epi64(c.0, d.0));
        [
            Four(_mm256_permute2x128_si256::<0x20>(ab, cd)),
            Four(_mm256_permute2x128_si256::<0x20>(ab1, cd1)),
            Four(_mm256_permute2x128_si256::<0x31>(ab, cd)),
            Four(_mm256_permute2x128_si256::<0x31>(ab1, cd1)),
        ]
    }
}

operators!(
    Four _mm256_set1_epi64x(-1),
    Add add _mm256_add_epi64,
    BitAnd bitand _mm256_and_si256,
    BitOr bitor _mm256_or_si256,
    BitXor bitxor _mm256_xor_si256
);
