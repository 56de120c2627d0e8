//! Sixteen numbers at a time: what the arithmetic of vertices, and between samples, is written in.
//!
//! [`Plain`] is its definition: arrays, number by number. Wider registers do the same operations, each
//! rounded once, so that the numbers are the same.

mod along;
mod plain;
#[cfg(test)]
mod tests;

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;

use crate::{Lane, Level, Samples};
use along::{one_and_one, three_along_x, two_and_two};
use plain::Plain;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};
#[cfg(target_arch = "x86_64")]
use {
    avx2::Avx2,
    avx512::{Avx512, is_gather_quick},
};

/// Numbers in a batch: one register of f32 at the widest, two of f64.
pub(crate) const BATCH: usize = 16;

/// Work that is written once and compiled for every level.
pub(crate) trait Task {
    fn run<W: Wide>(self, wide: W);
}

/// Does a task with the instructions of a level.
///
/// # Panics
///
/// If the machine has not the level.
pub(crate) fn run_at(level: Level, task: impl Task) {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { run_avx512(task) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { run_avx2(task) }
        }
        _ => task.run(Plain),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx2(task: impl Task) {
    // SAFETY: this function runs only where the machine has AVX2.
    task.run(unsafe { Avx2::new() });
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
fn run_avx512(task: impl Task) {
    // SAFETY: this function runs only where the machine has AVX-512 F, BW, DQ and VL.
    task.run(unsafe { Avx512::new(is_gather_quick()) });
}

/// A set of registers.
pub trait Wide: Copy {
    /// Sixteen u32. Sums and products wrap.
    type U32: Copy + Add<Output = Self::U32> + Mul<Output = Self::U32>;
    /// Sixteen f32.
    type F32: Float<Mask = Self::Mask>;
    /// Sixteen f64.
    type F64: Float<Mask = Self::Mask>;
    /// A choice of the sixteen.
    type Mask: Mask;

    /// Words from sixteen places come sooner by one instruction than one by one.
    fn is_gather_quick(self) -> bool;

    fn u32(self, number: u32) -> Self::U32;

    fn f32(self, number: f32) -> Self::F32;

    fn f64(self, number: f64) -> Self::F64;

    fn load(self, numbers: &[u32; BATCH]) -> Self::U32;

    fn store(self, numbers: Self::U32) -> [u32; BATCH];

    fn load_f32(self, numbers: &[f32; BATCH]) -> Self::F32;

    fn store_f32(self, numbers: Self::F32, out: &mut [f32; BATCH]);

    fn load_f64(self, numbers: &[f64; BATCH]) -> Self::F64;

    fn store_f64(self, numbers: Self::F64, out: &mut [f64; BATCH]);

    /// Those whose bit is set.
    fn mask(self, bits: u16) -> Self::Mask;

    /// Where both are equal.
    fn equal(self, a: Self::U32, b: Self::U32) -> Self::Mask;

    /// Where the first is less.
    fn less(self, a: Self::U32, b: Self::U32) -> Self::Mask;

    /// The first where chosen, else the second.
    fn select(self, mask: Self::Mask, a: Self::U32, b: Self::U32) -> Self::U32;

    /// The first where chosen, else the second.
    fn select_f64(self, mask: Self::Mask, a: Self::F64, b: Self::F64) -> Self::F64;

    /// The first where chosen, else the second.
    fn select_f32(self, mask: Self::Mask, a: Self::F32, b: Self::F32) -> Self::F32;

    fn u32_to_f64(self, numbers: Self::U32) -> Self::F64;

    /// Of numbers taken as i32: those from 2³¹ on lose 2³².
    fn i32_to_f64(self, numbers: Self::U32) -> Self::F64;

    fn f32_to_f64(self, numbers: Self::F32) -> Self::F64;

    /// Rounded to the nearest.
    fn f64_to_f32(self, numbers: Self::F64) -> Self::F32;

    /// Without their fractions; for numbers from 0 to 2³¹ − 1.
    fn truncate(self, numbers: Self::F64) -> Self::U32;

    /// Without their fractions; for numbers from 0 to 2²⁴.
    fn truncate_f32(self, numbers: Self::F32) -> Self::U32;

    /// For numbers from 0 to 2²⁴.
    fn u32_to_f32(self, numbers: Self::U32) -> Self::F32;

    /// The power of two by which a number becomes one from 1 to 2; for numbers from 2⁻⁶⁰ to 2¹²⁰.
    fn to_unit(self, numbers: Self::F32) -> Self::F32;

    /// The samples of the numbers `from + at[n]`, where `at` counts up and down.
    ///
    /// # Safety
    ///
    /// Each must be a sample from which on four bytes of all samples can be read, as from those that have both
    /// neighbours along two axes or more, and in a slice for which [`Samples::is_near`] holds, as far from the one
    /// that `from` lies in.
    unsafe fn near<T: Lane>(
        self,
        samples: &Samples<'_, T>,
        from: i64,
        at: Self::U32,
    ) -> <T::Exact as Exact>::Of<Self>;

    /// The samples below, at and above the numbers `from + at[n]` along x.
    ///
    /// # Safety
    ///
    /// As of [`near`](Self::near), and each sample must have all its neighbours.
    #[inline(always)]
    unsafe fn along_x<T: Lane>(
        self,
        samples: &Samples<'_, T>,
        from: i64,
        at: Self::U32,
    ) -> [<T::Exact as Exact>::Of<Self>; 3] {
        // SAFETY: the caller says so.
        unsafe { three_along_x(self, samples, from, at) }
    }

    /// Of each row the samples at and above the numbers `from + at[n]` along x.
    ///
    /// # Safety
    ///
    /// As of [`near`](Self::near), and so of the samples above, which must be there.
    #[inline(always)]
    unsafe fn two_along_x<T: Lane, const ROWS: usize>(
        self,
        samples: &Samples<'_, T>,
        from: [i64; ROWS],
        at: Self::U32,
    ) -> [[<T::Exact as Exact>::Of<Self>; 2]; ROWS] {
        // SAFETY: the caller says so.
        unsafe { one_and_one(self, samples, from, at) }
    }

    /// Of each row the samples at the numbers `from + at[n]`, and the next three along x.
    ///
    /// # Safety
    ///
    /// As of [`near`](Self::near), and so of the three above, which must be there.
    #[inline(always)]
    unsafe fn four_along_x<T: Lane, const ROWS: usize>(
        self,
        samples: &Samples<'_, T>,
        from: [i64; ROWS],
        at: Self::U32,
    ) -> [[<T::Exact as Exact>::Of<Self>; 4]; ROWS] {
        // SAFETY: the caller says so.
        unsafe { two_and_two(self, samples, from, at) }
    }

    /// Three numbers per vertex, from one register per axis.
    fn interleave(self, axes: [Self::F32; 3], out: &mut [[f32; 3]; BATCH]);

    /// The same of f64.
    #[inline(always)]
    fn interleave_f64(self, axes: [Self::F64; 3], out: &mut [[f64; 3]; BATCH]) {
        let mut lists = [[0.0; BATCH]; 3];
        for (list, numbers) in lists.iter_mut().zip(axes) {
            self.store_f64(numbers, list);
        }
        for (n, place) in out.iter_mut().enumerate() {
            *place = [lists[0][n], lists[1][n], lists[2][n]];
        }
    }
}

/// A choice of sixteen numbers.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// A bit each.
    fn bits(self) -> u16;
}

impl Mask for u16 {
    #[inline(always)]
    fn bits(self) -> u16 {
        self
    }
}

/// Sixteen numbers with a fraction.
pub trait Float:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Where a condition holds.
    type Mask: Mask;

    /// The greater; `other` where the two are equal or one is NaN.
    fn max(self, other: Self) -> Self;

    /// The less; `other` where the two are equal or one is NaN.
    fn min(self, other: Self) -> Self;

    /// Without its sign.
    fn abs(self) -> Self;

    fn sqrt(self) -> Self;

    /// Where it is less than the other: nowhere for NaN.
    fn less(self, other: Self) -> Self::Mask;
}

/// A type that holds every sample of another exactly: f32 or f64.
pub trait Exact: Copy + Default + Into<f64> {
    /// It is f64.
    const IS_DOUBLE: bool;

    /// Sixteen of them.
    type Of<W: Wide>: Float<Mask = W::Mask>;

    fn load<W: Wide>(wide: W, numbers: &[Self; BATCH]) -> Self::Of<W>;

    fn store<W: Wide>(wide: W, numbers: Self::Of<W>, out: &mut [Self; BATCH]);

    fn to_f64<W: Wide>(wide: W, numbers: Self::Of<W>) -> W::F64;

    /// Rounded to the nearest.
    fn to_f32<W: Wide>(wide: W, numbers: Self::Of<W>) -> W::F32;

    /// Rounded to the nearest.
    fn from_f64<W: Wide>(wide: W, numbers: W::F64) -> Self::Of<W>;

    /// Sixteen times the same number, rounded to the nearest.
    fn splat<W: Wide>(wide: W, number: f64) -> Self::Of<W>;

    /// The first where chosen, else the second.
    fn select<W: Wide>(wide: W, mask: W::Mask, a: Self::Of<W>, b: Self::Of<W>) -> Self::Of<W>;

    /// `a − b`, rounded to f32.
    fn difference<W: Wide>(wide: W, a: Self::Of<W>, b: Self::Of<W>) -> W::F32;
}

impl Exact for f32 {
    const IS_DOUBLE: bool = false;

    type Of<W: Wide> = W::F32;

    #[inline(always)]
    fn load<W: Wide>(wide: W, numbers: &[Self; BATCH]) -> W::F32 {
        wide.load_f32(numbers)
    }

    #[inline(always)]
    fn store<W: Wide>(wide: W, numbers: W::F32, out: &mut [Self; BATCH]) {
        wide.store_f32(numbers, out);
    }

    #[inline(always)]
    fn to_f64<W: Wide>(wide: W, numbers: W::F32) -> W::F64 {
        wide.f32_to_f64(numbers)
    }

    #[inline(always)]
    fn to_f32<W: Wide>(_: W, numbers: W::F32) -> W::F32 {
        numbers
    }

    #[inline(always)]
    fn from_f64<W: Wide>(wide: W, numbers: W::F64) -> W::F32 {
        wide.f64_to_f32(numbers)
    }

    #[inline(always)]
    fn splat<W: Wide>(wide: W, number: f64) -> W::F32 {
        wide.f32(number as f32)
    }

    #[inline(always)]
    fn select<W: Wide>(wide: W, mask: W::Mask, a: W::F32, b: W::F32) -> W::F32 {
        wide.select_f32(mask, a, b)
    }

    #[inline(always)]
    fn difference<W: Wide>(_: W, a: W::F32, b: W::F32) -> W::F32 {
        a - b
    }
}

impl Exact for f64 {
    const IS_DOUBLE: bool = true;

    type Of<W: Wide> = W::F64;

    #[inline(always)]
    fn load<W: Wide>(wide: W, numbers: &[Self; BATCH]) -> W::F64 {
        wide.load_f64(numbers)
    }

    #[inline(always)]
    fn store<W: Wide>(wide: W, numbers: W::F64, out: &mut [Self; BATCH]) {
        wide.store_f64(numbers, out);
    }

    #[inline(always)]
    fn to_f64<W: Wide>(_: W, numbers: W::F64) -> W::F64 {
        numbers
    }

    #[inline(always)]
    fn to_f32<W: Wide>(wide: W, numbers: W::F64) -> W::F32 {
        wide.f64_to_f32(numbers)
    }

    #[inline(always)]
    fn from_f64<W: Wide>(_: W, numbers: W::F64) -> W::F64 {
        numbers
    }

    #[inline(always)]
    fn splat<W: Wide>(wide: W, number: f64) -> W::F64 {
        wide.f64(number)
    }

    #[inline(always)]
    fn select<W: Wide>(wide: W, mask: W::Mask, a: W::F64, b: W::F64) -> W::F64 {
        wide.select_f64(mask, a, b)
    }

    #[inline(always)]
    fn difference<W: Wide>(wide: W, a: W::F64, b: W::F64) -> W::F32 {
        wide.f64_to_f32(a - b)
    }
}
