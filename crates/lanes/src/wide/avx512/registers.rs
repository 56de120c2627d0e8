//! The AVX-512 registers, and what is done with numbers of one kind. They are made from a token only.

use super::super::Float;
use std::{
    arch::x86_64::*,
    ops::{Add, Div, Mul, Sub},
};

#[derive(Clone, Copy)]
pub struct U32(pub(super) __m512i);

#[derive(Clone, Copy)]
pub struct F32(pub(super) __m512);

/// The lower eight, and the upper eight.
#[derive(Clone, Copy)]
pub struct F64(pub(super) __m512d, pub(super) __m512d);

macro_rules! operators {
    ($($trait:ident $name:ident $f32:ident $f64:ident;)*) => {$(
        impl $trait for F32 {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: a register exists only where the instructions do.
                Self(unsafe { $f32(self.0, other.0) })
            }
        }

        impl $trait for F64 {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: a register exists only where the instructions do.
                unsafe { Self($f64(self.0, other.0), $f64(self.1, other.1)) }
            }
        }
    )*};
}

operators! {
    Add add _mm512_add_ps _mm512_add_pd;
    Sub sub _mm512_sub_ps _mm512_sub_pd;
    Mul mul _mm512_mul_ps _mm512_mul_pd;
    Div div _mm512_div_ps _mm512_div_pd;
}

impl Add for U32 {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: a register exists only where the instructions do.
        Self(unsafe { _mm512_add_epi32(self.0, other.0) })
    }
}

impl Mul for U32 {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: a register exists only where the instructions do.
        Self(unsafe { _mm512_mullo_epi32(self.0, other.0) })
    }
}

/// `max` and `min` give their second operand where the two are equal or one is NaN.
impl Float for F32 {
    type Mask = u16;

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: a register exists only where the instructions do.
        Self(unsafe { _mm512_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_min_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_abs_ps(self.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn less(self, other: Self) -> u16 {
        // SAFETY: as above.
        unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) }
    }
}

impl Float for F64 {
    type Mask = u16;

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: a register exists only where the instructions do.
        unsafe { Self(_mm512_max_pd(self.0, other.0), _mm512_max_pd(self.1, other.1)) }
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm512_min_pd(self.0, other.0), _mm512_min_pd(self.1, other.1)) }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm512_abs_pd(self.0), _mm512_abs_pd(self.1)) }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm512_sqrt_pd(self.0), _mm512_sqrt_pd(self.1)) }
    }

    #[inline(always)]
    fn less(self, other: Self) -> u16 {
        // SAFETY: as above.
        let [low, high] = unsafe {
            [
                _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0),
                _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.1, other.1),
            ]
        };
        u16::from(low) | u16::from(high) << 8
    }
}
