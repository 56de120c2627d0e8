//! Sixteen numbers in one AVX-512 register, or in two.

mod gather;
mod registers;

use super::{
    BATCH, Exact, Wide,
    along::{one_and_one, three_along_x, two_and_two},
};
use crate::{Lane, Samples};
pub(crate) use gather::is_gather_quick;
use gather::{exact, gather, gather_f64, singly, without, words_of_two};
use registers::{F32, F64, U32};
use std::{any::TypeId, arch::x86_64::*, mem::transmute_copy};

/// A token: who holds one, or a register, has the instructions.
#[derive(Clone, Copy)]
pub(crate) struct Avx512 {
    /// Words from sixteen places are loaded by one instruction, and not one by one.
    gathers: bool,
}

impl Avx512 {
    /// # Safety
    ///
    /// The machine must have AVX-512 F, BW, DQ and VL.
    #[inline(always)]
    pub(crate) unsafe fn new(gathers: bool) -> Self {
        Self { gathers }
    }
}

/// The lower and the upper half of a register.
#[inline(always)]
fn halves(_: Avx512, numbers: __m512i) -> [__m256i; 2] {
    // SAFETY: there is a token.
    unsafe { [_mm512_castsi512_si256(numbers), _mm512_extracti64x4_epi64::<1>(numbers)] }
}

impl Wide for Avx512 {
    type U32 = U32;
    type F32 = F32;
    type F64 = F64;
    type Mask = u16;

    #[inline(always)]
    fn is_gather_quick(self) -> bool {
        self.gathers
    }

    #[inline(always)]
    fn u32(self, number: u32) -> U32 {
        // SAFETY: there is a token; so in all that follows.
        U32(unsafe { _mm512_set1_epi32(number as i32) })
    }

    #[inline(always)]
    fn f32(self, number: f32) -> F32 {
        // SAFETY: there is a token.
        F32(unsafe { _mm512_set1_ps(number) })
    }

    #[inline(always)]
    fn f64(self, number: f64) -> F64 {
        // SAFETY: there is a token.
        let half = unsafe { _mm512_set1_pd(number) };
        F64(half, half)
    }

    #[inline(always)]
    fn load(self, numbers: &[u32; BATCH]) -> U32 {
        // SAFETY: there is a token; the array fills a register, and the load needs no alignment.
        U32(unsafe { _mm512_loadu_epi32(numbers.as_ptr().cast()) })
    }

    #[inline(always)]
    fn store(self, numbers: U32) -> [u32; BATCH] {
        let mut out = [0; BATCH];
        // SAFETY: as in `load`.
        unsafe { _mm512_storeu_epi32(out.as_mut_ptr().cast(), numbers.0) };
        out
    }

    #[inline(always)]
    fn load_f32(self, numbers: &[f32; BATCH]) -> F32 {
        // SAFETY: as in `load`.
        F32(unsafe { _mm512_loadu_ps(numbers.as_ptr()) })
    }

    #[inline(always)]
    fn store_f32(self, numbers: F32, out: &mut [f32; BATCH]) {
        // SAFETY: as in `load`.
        unsafe { _mm512_storeu_ps(out.as_mut_ptr(), numbers.0) };
    }

    #[inline(always)]
    fn load_f64(self, numbers: &[f64; BATCH]) -> F64 {
        let (halves, _) = numbers.as_chunks::<8>();
        // SAFETY: as in `load`, for both halves.
        unsafe { F64(_mm512_loadu_pd(halves[0].as_ptr()), _mm512_loadu_pd(halves[1].as_ptr())) }
    }

    #[inline(always)]
    fn store_f64(self, numbers: F64, out: &mut [f64; BATCH]) {
        let (halves, _) = out.as_chunks_mut::<8>();
        // SAFETY: there is a token; each half is one register.
        unsafe {
            _mm512_storeu_pd(halves[0].as_mut_ptr(), numbers.0);
            _mm512_storeu_pd(halves[1].as_mut_ptr(), numbers.1);
        }
    }

    #[inline(always)]
    fn mask(self, bits: u16) -> u16 {
        bits
    }

    #[inline(always)]
    fn equal(self, a: U32, b: U32) -> u16 {
        // SAFETY: there is a token.
        unsafe { _mm512_cmpeq_epi32_mask(a.0, b.0) }
    }

    #[inline(always)]
    fn less(self, a: U32, b: U32) -> u16 {
        // SAFETY: there is a token.
        unsafe { _mm512_cmplt_epu32_mask(a.0, b.0) }
    }

    #[inline(always)]
    fn select(self, mask: u16, a: U32, b: U32) -> U32 {
        // SAFETY: there is a token.
        U32(unsafe { _mm512_mask_blend_epi32(mask, b.0, a.0) })
    }

    #[inline(always)]
    fn select_f64(self, mask: u16, a: F64, b: F64) -> F64 {
        // SAFETY: there is a token.
        unsafe {
            let low = _mm512_mask_blend_pd(mask as u8, b.0, a.0);
            F64(low, _mm512_mask_blend_pd((mask >> 8) as u8, b.1, a.1))
        }
    }

    #[inline(always)]
    fn select_f32(self, mask: u16, a: F32, b: F32) -> F32 {
        // SAFETY: there is a token.
        F32(unsafe { _mm512_mask_blend_ps(mask, b.0, a.0) })
    }

    #[inline(always)]
    fn u32_to_f64(self, numbers: U32) -> F64 {
        let [low, high] = halves(self, numbers.0);
        // SAFETY: there is a token.
        unsafe { F64(_mm512_cvtepu32_pd(low), _mm512_cvtepu32_pd(high)) }
    }

    #[inline(always)]
    fn i32_to_f64(self, numbers: U32) -> F64 {
        let [low, high] = halves(self, numbers.0);
        // SAFETY: there is a token.
        unsafe { F64(_mm512_cvtepi32_pd(low), _mm512_cvtepi32_pd(high)) }
    }

    #[inline(always)]
    fn f32_to_f64(self, numbers: F32) -> F64 {
        // SAFETY: there is a token.
        unsafe {
            let [low, high] = halves(self, _mm512_castps_si512(numbers.0));
            let [low, high] = [_mm256_castsi256_ps(low), _mm256_castsi256_ps(high)];
            F64(_mm512_cvtps_pd(low), _mm512_cvtps_pd(high))
        }
    }

    #[inline(always)]
    fn f64_to_f32(self, numbers: F64) -> F32 {
        // SAFETY: there is a token.
        unsafe {
            let low = _mm512_castps256_ps512(_mm512_cvtpd_ps(numbers.0));
            F32(_mm512_insertf32x8::<1>(low, _mm512_cvtpd_ps(numbers.1)))
        }
    }

    #[inline(always)]
    fn truncate(self, numbers: F64) -> U32 {
        // SAFETY: there is a token.
        unsafe {
            let (low, high) = (_mm512_cvttpd_epi32(numbers.0), _mm512_cvttpd_epi32(numbers.1));
            U32(_mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high))
        }
    }

    #[inline(always)]
    fn truncate_f32(self, numbers: F32) -> U32 {
        // SAFETY: there is a token.
        U32(unsafe { _mm512_cvttps_epi32(numbers.0) })
    }

    #[inline(always)]
    fn u32_to_f32(self, numbers: U32) -> F32 {
        // SAFETY: there is a token.
        F32(unsafe { _mm512_cvtepi32_ps(numbers.0) })
    }

    #[inline(always)]
    fn to_unit(self, numbers: F32) -> F32 {
        // SAFETY: there is a token.
        unsafe {
            let exponents =
                _mm512_and_si512(_mm512_castps_si512(numbers.0), _mm512_set1_epi32(0x7F80_0000));
            let opposite = _mm512_sub_epi32(_mm512_set1_epi32(0x7F00_0000), exponents);
            F32(_mm512_castsi512_ps(opposite))
        }
    }

    #[inline(always)]
    unsafe fn near<T: Lane>(
        self,
        samples: &Samples<'_, T>,
        from: i64,
        at: U32,
    ) -> <T::Exact as Exact>::Of<Self> {
        let base = samples.all().as_ptr().wrapping_offset(from as isize);
        if TypeId::of::<T>() == TypeId::of::<f64>() {
            // SAFETY: samples are f64, and the caller says that they are there. What comes out is sixteen
            // of the exact type of f64, which is `T`.
            return unsafe { transmute_copy(&gather_f64(self, base.cast(), at)) };
        }
        // SAFETY: the four bytes from each number on lie in the slice, as the caller says.
        exact::<T>(self, unsafe {
            if self.gathers { gather(self, base, at) } else { singly(self, base, at) }
        })
    }

    #[inline(always)]
    unsafe fn along_x<T: Lane>(
        self,
        samples: &Samples<'_, T>,
        from: i64,
        at: U32,
    ) -> [<T::Exact as Exact>::Of<Self>; 3] {
        let [x, y, _] = samples.strides();
        if size_of::<T>() > 4 || x != 1 || y.abs() < 2 {
            // SAFETY: the caller says so.
            return unsafe { three_along_x(self, samples, from, at) };
        }
        let below = samples.all().as_ptr().wrapping_offset(from as isize - 1);
        // SAFETY: from the sample below on four lie in the slice: the last is no farther off than a neighbour
        // along y, which is there.
        let [below, own, above] = unsafe {
            match size_of::<T>() {
                1 => {
                    let all = gather(self, below, at);
                    [all, without::<8>(self, all), without::<16>(self, all)]
                }
                2 => {
                    let first = gather(self, below, at);
                    let above = gather(self, below.wrapping_add(2), at);
                    [first, without::<16>(self, first), above]
                }
                _ => {
                    let [first, own] = words_of_two(self, below, at);
                    [first, own, gather(self, below.wrapping_add(2), at)]
                }
            }
        };
        [exact::<T>(self, below), exact::<T>(self, own), exact::<T>(self, above)]
    }

    #[inline(always)]
    unsafe fn two_along_x<T: Lane, const ROWS: usize>(
        self,
        samples: &Samples<'_, T>,
        from: [i64; ROWS],
        at: U32,
    ) -> [[<T::Exact as Exact>::Of<Self>; 2]; ROWS] {
        if size_of::<T>() > 4 || samples.strides()[0] != 1 {
            // SAFETY: the caller says so.
            return unsafe { one_and_one(self, samples, from, at) };
        }
        let mut rows = [[T::Exact::splat(self, 0.0); 2]; ROWS];
        for (row, from) in rows.iter_mut().zip(from) {
            let base = samples.all().as_ptr().wrapping_offset(from as isize);
            // SAFETY: the caller says that both samples are there, and four bytes from the first.
            let [own, above] = unsafe {
                match size_of::<T>() {
                    1 => {
                        let both = gather(self, base, at);
                        [both, without::<8>(self, both)]
                    }
                    2 => {
                        let both = gather(self, base, at);
                        [both, without::<16>(self, both)]
                    }
                    _ => words_of_two(self, base, at),
                }
            };
            *row = [exact::<T>(self, own), exact::<T>(self, above)];
        }
        rows
    }

    #[inline(always)]
    unsafe fn four_along_x<T: Lane, const ROWS: usize>(
        self,
        samples: &Samples<'_, T>,
        from: [i64; ROWS],
        at: U32,
    ) -> [[<T::Exact as Exact>::Of<Self>; 4]; ROWS] {
        if size_of::<T>() != 1 || samples.strides()[0] != 1 {
            // SAFETY: the caller says so.
            return unsafe { two_and_two(self, samples, from, at) };
        }
        let mut rows = [[T::Exact::splat(self, 0.0); 4]; ROWS];
        for (row, from) in rows.iter_mut().zip(from) {
            let base = samples.all().as_ptr().wrapping_offset(from as isize);
            // SAFETY: the caller says that all four samples are there.
            let all = unsafe { gather(self, base, at) };
            let others =
                [without::<8>(self, all), without::<16>(self, all), without::<24>(self, all)];
            *row = [
                exact::<T>(self, all),
                exact::<T>(self, others[0]),
                exact::<T>(self, others[1]),
                exact::<T>(self, others[2]),
            ];
        }
        rows
    }

    #[inline(always)]
    fn interleave(self, [x, y, z]: [F32; 3], out: &mut [[f32; 3]; BATCH]) {
        let (registers, _) = out.as_flattened_mut().as_chunks_mut::<BATCH>();
        for (register, order) in registers.iter_mut().zip(&ORDER) {
            let [first, then] = [self.load(&order[0]).0, self.load(&order[1]).0];
            // SAFETY: there is a token; a third of the output is one register.
            unsafe {
                let xy = _mm512_permutex2var_ps(x.0, first, y.0);
                _mm512_storeu_ps(register.as_mut_ptr(), _mm512_permutex2var_ps(xy, then, z.0));
            }
        }
    }
}

/// For each of the three registers of output which number of the 16 + 16 of x and y comes where, and then
/// which of those or of z, which are numbered from 16 on.
const ORDER: [[[u32; BATCH]; 2]; 3] = {
    let mut order = [[[0; BATCH]; 2]; 3];
    let mut i = 0;
    while i < 3 * BATCH {
        let (vertex, axis, register, place) = (i / 3, i % 3, i / BATCH, i % BATCH);
        order[register][0][place] = (vertex + if axis == 1 { BATCH } else { 0 }) as u32;
        order[register][1][place] = if axis == 2 { vertex + BATCH } else { place } as u32;
        i += 1;
    }
    order
};
