//! Sixteen numbers as an array.

use super::{BATCH, Exact, Float, Wide};
use crate::{Lane, Samples};
use std::ops::{Add, Div, Mul, Sub};

/// Plain Rust, which the compiler makes wide as far as it can.
#[derive(Clone, Copy)]
pub(crate) struct Plain;

/// Sixteen numbers.
#[derive(Clone, Copy)]
pub struct Array<N>([N; BATCH]);

/// An array by an expression of the place. A macro, since closures are not always inlined into the
/// function that a level's instructions are enabled for.
macro_rules! each {
    ($n:ident => $number:expr) => {{
        let mut numbers = [Default::default(); BATCH];
        let mut $n = 0;
        while $n < BATCH {
            numbers[$n] = $number;
            $n += 1;
        }
        numbers
    }};
}

/// The bits of those places where a condition holds.
macro_rules! mask {
    ($n:ident => $condition:expr) => {{
        let mut mask = 0;
        let mut $n = 0;
        while $n < BATCH {
            mask |= u16::from($condition) << $n;
            $n += 1;
        }
        mask
    }};
}

macro_rules! operator {
    ($trait:ident $name:ident $($t:ty, |$a:ident, $b:ident| $result:expr);+) => {$(
        impl $trait for Array<$t> {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(each!(n => {
                    let ($a, $b) = (self.0[n], other.0[n]);
                    $result
                }))
            }
        }
    )+};
}

operator!(Add add u32, |a, b| a.wrapping_add(b); f32, |a, b| a + b; f64, |a, b| a + b);
operator!(Sub sub f32, |a, b| a - b; f64, |a, b| a - b);
operator!(Mul mul u32, |a, b| a.wrapping_mul(b); f32, |a, b| a * b; f64, |a, b| a * b);
operator!(Div div f32, |a, b| a / b; f64, |a, b| a / b);

macro_rules! float {
    ($($t:ty),*) => {$(
        impl Float for Array<$t> {
            type Mask = u16;

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(each!(n => if self.0[n] > other.0[n] { self.0[n] } else { other.0[n] }))
            }

            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(each!(n => if self.0[n] < other.0[n] { self.0[n] } else { other.0[n] }))
            }

            #[inline(always)]
            fn abs(self) -> Self {
                Self(each!(n => self.0[n].abs()))
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(each!(n => self.0[n].sqrt()))
            }

            #[inline(always)]
            fn less(self, other: Self) -> u16 {
                mask!(n => self.0[n] < other.0[n])
            }
        }
    )*};
}

float!(f32, f64);

impl Wide for Plain {
    type U32 = Array<u32>;
    type F32 = Array<f32>;
    type F64 = Array<f64>;
    type Mask = u16;

    #[inline(always)]
    fn is_gather_quick(self) -> bool {
        false
    }

    #[inline(always)]
    fn u32(self, number: u32) -> Array<u32> {
        Array([number; BATCH])
    }

    #[inline(always)]
    fn f32(self, number: f32) -> Array<f32> {
        Array([number; BATCH])
    }

    #[inline(always)]
    fn f64(self, number: f64) -> Array<f64> {
        Array([number; BATCH])
    }

    #[inline(always)]
    fn load(self, numbers: &[u32; BATCH]) -> Array<u32> {
        Array(*numbers)
    }

    #[inline(always)]
    fn store(self, numbers: Array<u32>) -> [u32; BATCH] {
        numbers.0
    }

    #[inline(always)]
    fn load_f32(self, numbers: &[f32; BATCH]) -> Array<f32> {
        Array(*numbers)
    }

    #[inline(always)]
    fn store_f32(self, numbers: Array<f32>, out: &mut [f32; BATCH]) {
        *out = numbers.0;
    }

    #[inline(always)]
    fn load_f64(self, numbers: &[f64; BATCH]) -> Array<f64> {
        Array(*numbers)
    }

    #[inline(always)]
    fn store_f64(self, numbers: Array<f64>, out: &mut [f64; BATCH]) {
        *out = numbers.0;
    }

    #[inline(always)]
    fn mask(self, bits: u16) -> u16 {
        bits
    }

    #[inline(always)]
    fn equal(self, a: Array<u32>, b: Array<u32>) -> u16 {
        mask!(n => a.0[n] == b.0[n])
    }

    #[inline(always)]
    fn less(self, a: Array<u32>, b: Array<u32>) -> u16 {
        mask!(n => a.0[n] < b.0[n])
    }

    #[inline(always)]
    fn select(self, mask: u16, a: Array<u32>, b: Array<u32>) -> Array<u32> {
        Array(each!(n => if mask >> n & 1 == 1 { a.0[n] } else { b.0[n] }))
    }

    #[inline(always)]
    fn select_f64(self, mask: u16, a: Array<f64>, b: Array<f64>) -> Array<f64> {
        Array(each!(n => if mask >> n & 1 == 1 { a.0[n] } else { b.0[n] }))
    }

    #[inline(always)]
    fn select_f32(self, mask: u16, a: Array<f32>, b: Array<f32>) -> Array<f32> {
        Array(each!(n => if mask >> n & 1 == 1 { a.0[n] } else { b.0[n] }))
    }

    #[inline(always)]
    fn u32_to_f64(self, numbers: Array<u32>) -> Array<f64> {
        Array(each!(n => f64::from(numbers.0[n])))
    }

    #[inline(always)]
    fn i32_to_f64(self, numbers: Array<u32>) -> Array<f64> {
        Array(each!(n => f64::from(numbers.0[n] as i32)))
    }

    #[inline(always)]
    fn f32_to_f64(self, numbers: Array<f32>) -> Array<f64> {
        Array(each!(n => f64::from(numbers.0[n])))
    }

    #[inline(always)]
    fn f64_to_f32(self, numbers: Array<f64>) -> Array<f32> {
        Array(each!(n => numbers.0[n] as f32))
    }

    #[inline(always)]
    fn truncate(self, numbers: Array<f64>) -> Array<u32> {
        // As i32, for which processors have an instruction.
        Array(each!(n => numbers.0[n] as i32 as u32))
    }

    #[inline(always)]
    fn truncate_f32(self, numbers: Array<f32>) -> Array<u32> {
        Array(each!(n => numbers.0[n] as i32 as u32))
    }

    #[inline(always)]
    fn u32_to_f32(self, numbers: Array<u32>) -> Array<f32> {
        Array(each!(n => numbers.0[n] as i32 as f32))
    }

    #[inline(always)]
    fn to_unit(self, numbers: Array<f32>) -> Array<f32> {
        Array(
            each!(n => f32::from_bits(0x7F00_0000_u32.wrapping_sub(numbers.0[n].to_bits() & 0x7F80_0000))),
        )
    }

    #[inline(always)]
    unsafe fn near<T: Lane>(
        self,
        samples: &Samples<'_, T>,
        from: i64,
        at: Array<u32>,
    ) -> <T::Exact as Exact>::Of<Self> {
        let numbers = each!(n => {
            let number = from + i64::from(at.0[n] as i32);
            // SAFETY: the sample of a lattice point lies in the slice, as `Samples` guarantees.
            unsafe { *samples.all().get_unchecked(number as usize) }.exact()
        });
        T::Exact::load(self, &numbers)
    }

    #[inline(always)]
    fn interleave(self, axes: [Array<f32>; 3], out: &mut [[f32; 3]; BATCH]) {
        *out = each!(n => [axes[0].0[n], axes[1].0[n], axes[2].0[n]]);
    }
}
