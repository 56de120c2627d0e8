//! The AVX2 registers, and what is done with numbers of one kind. They are made from a token only.

use super::super::{Float, Mask};
use std::{
    arch::x86_64::*,
    ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub},
};

#[derive(Clone, Copy)]
pub struct U32(pub(super) [__m256i; 2]);

#[derive(Clone, Copy)]
pub struct F32(pub(super) [__m256; 2]);

#[derive(Clone, Copy)]
pub struct F64(pub(super) [__m256d; 4]);

/// All bits of each chosen number of 32 bits, and none of the others.
#[derive(Clone, Copy)]
pub struct Choice(pub(super) [__m256i; 2]);

/// Two registers by an expression of their number. A macro, since closures are not always inlined into the
/// function that the instructions are enabled for.
macro_rules! two {
    ($n:ident => $register:expr) => {{
        let first = {
            const $n: usize = 0;
            $register
        };
        let second = {
            const $n: usize = 1;
            $register
        };
        [first, second]
    }};
}

/// Four.
macro_rules! four {
    ($n:ident => $register:expr) => {{
        let first = {
            const $n: usize = 0;
            $register
        };
        let second = {
            const $n: usize = 1;
            $register
        };
        let third = {
            const $n: usize = 2;
            $register
        };
        let fourth = {
            const $n: usize = 3;
            $register
        };
        [first, second, third, fourth]
    }};
}

pub(super) use {four, two};

macro_rules! operators {
    ($($trait:ident $name:ident $f32:ident $f64:ident;)*) => {$(
        impl $trait for F32 {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: a register exists only where the instructions do.
                Self(unsafe { two!(N => $f32(self.0[N], other.0[N])) })
            }
        }

        impl $trait for F64 {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: a register exists only where the instructions do.
                Self(unsafe { four!(N => $f64(self.0[N], other.0[N])) })
            }
        }
    )*};
}

operators! {
    Add add _mm256_add_ps _mm256_add_pd;
    Sub sub _mm256_sub_ps _mm256_sub_pd;
    Mul mul _mm256_mul_ps _mm256_mul_pd;
    Div div _mm256_div_ps _mm256_div_pd;
}

macro_rules! whole {
    ($($trait:ident $name:ident $type:ident $operation:ident;)*) => {$(
        impl $trait for $type {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: a register exists only where the instructions do.
                Self(unsafe { two!(N => $operation(self.0[N], other.0[N])) })
            }
        }
    )*};
}

whole! {
    Add add U32 _mm256_add_epi32;
    Mul mul U32 _mm256_mullo_epi32;
    BitAnd bitand Choice _mm256_and_si256;
    BitOr bitor Choice _mm256_or_si256;
}

impl Not for Choice {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: a register exists only where the instructions do.
        Self(unsafe { two!(N => _mm256_xor_si256(self.0[N], _mm256_set1_epi32(-1))) })
    }
}

impl Mask for Choice {
    #[inline(always)]
    fn bits(self) -> u16 {
        // Of two masks of eight the compiler makes two instructions more (Rust 1.95).
        // SAFETY: a register exists only where the instructions do.
        unsafe {
            let both = _mm256_packs_epi32(self.0[0], self.0[1]);
            let quarters =
                _mm_packs_epi16(_mm256_castsi256_si128(both), _mm256_extracti128_si256::<1>(both));
            _mm_movemask_epi8(_mm_shuffle_epi32::<0b11_01_10_00>(quarters)) as u16
        }
    }
}

/// The type, its parts, and the operations on one register. `max` and `min` give their second operand where
/// the two are equal or one is NaN.
macro_rules! float {
    (
        $type:ident $each:ident $max:ident $min:ident $sqrt:ident $andnot:ident $splat:ident,
        |$a:ident, $b:ident| $less:expr
    ) => {
        impl Float for $type {
            type Mask = Choice;

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                // SAFETY: a register exists only where the instructions do.
                Self(unsafe { $each!(N => $max(self.0[N], other.0[N])) })
            }

            #[inline(always)]
            fn min(self, other: Self) -> Self {
                // SAFETY: as above.
                Self(unsafe { $each!(N => $min(self.0[N], other.0[N])) })
            }

            #[inline(always)]
            fn abs(self) -> Self {
                // SAFETY: as above.
                Self(unsafe { $each!(N => $andnot($splat(-0.0), self.0[N])) })
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: as above.
                Self(unsafe { $each!(N => $sqrt(self.0[N])) })
            }

            #[inline(always)]
            fn less(self, other: Self) -> Choice {
                let ($a, $b) = (self.0, other.0);
                // SAFETY: as above.
                Choice(unsafe { $less })
            }
        }
    };
}

float!(
    F32 two _mm256_max_ps _mm256_min_ps _mm256_sqrt_ps _mm256_andnot_ps _mm256_set1_ps,
    |a, b| two!(N => _mm256_castps_si256(_mm256_cmp_ps::<_CMP_LT_OQ>(a[N], b[N])))
);
float!(
    F64 four _mm256_max_pd _mm256_min_pd _mm256_sqrt_pd _mm256_andnot_pd _mm256_set1_pd,
    |a, b| {
        let less = four!(N => _mm256_castpd_ps(_mm256_cmp_pd::<_CMP_LT_OQ>(a[N], b[N])));
        // The low half of each number, in quarters 0 2 1 3.
        let halves = two!(N => _mm256_shuffle_ps::<0b10_00_10_00>(less[2 * N], less[2 * N + 1]));
        let halves = two!(N => _mm256_castps_si256(halves[N]));
        two!(N => _mm256_permute4x64_epi64::<0b11_01_10_00>(halves[N]))
    }
);
