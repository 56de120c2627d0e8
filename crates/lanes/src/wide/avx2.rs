//! Sixteen numbers in two AVX2 registers, or in four.
//!
//! Samples are loaded one by one, and those next to each other in memory at once.

mod gather;
mod registers;
mod rows;

use super::{BATCH, Exact, Wide, along::three_along_x};
use crate::{Lane, Samples};
use gather::{exact, gather, gather_f64, words_of_four};
use registers::{Choice, F32, F64, U32, four, two};
use std::{any::TypeId, arch::x86_64::*, mem::transmute_copy};

/// A token: who holds one, or a register, has the instructions.
#[derive(Clone, Copy)]
pub(crate) struct Avx2(());

impl Avx2 {
    /// # Safety
    ///
    /// The machine must have AVX2.
    #[inline(always)]
    pub(crate) unsafe fn new() -> Self {
        Self(())
    }
}

/// What turns numbers without a sign into numbers with one, and back.
const MIDDLE: i32 = i32::MIN;

/// The four quarters of sixteen numbers.
#[inline(always)]
fn quarters(_: Avx2, [low, high]: [__m256i; 2]) -> [__m128i; 4] {
    // SAFETY: there is a token.
    unsafe {
        [
            _mm256_castsi256_si128(low),
            _mm256_extracti128_si256::<1>(low),
            _mm256_castsi256_si128(high),
            _mm256_extracti128_si256::<1>(high),
        ]
    }
}

impl Wide for Avx2 {
    type U32 = U32;
    type F32 = F32;
    type F64 = F64;
    type Mask = Choice;

    #[inline(always)]
    fn is_gather_quick(self) -> bool {
        false
    }

    #[inline(always)]
    fn u32(self, number: u32) -> U32 {
        // SAFETY: there is a token; so in all that follows.
        U32([unsafe { _mm256_set1_epi32(number as i32) }; 2])
    }

    #[inline(always)]
    fn f32(self, number: f32) -> F32 {
        // SAFETY: there is a token.
        F32([unsafe { _mm256_set1_ps(number) }; 2])
    }

    #[inline(always)]
    fn f64(self, number: f64) -> F64 {
        // SAFETY: there is a token.
        F64([unsafe { _mm256_set1_pd(number) }; 4])
    }

    #[inline(always)]
    fn load(self, numbers: &[u32; BATCH]) -> U32 {
        let (parts, _) = numbers.as_chunks::<8>();
        // SAFETY: there is a token; each part fills a register, and the load needs no alignment.
        U32(unsafe { two!(N => _mm256_loadu_si256(parts[N].as_ptr().cast())) })
    }

    #[inline(always)]
    fn store(self, numbers: U32) -> [u32; BATCH] {
        let mut out = [0; BATCH];
        let (parts, _) = out.as_chunks_mut::<8>();
        // SAFETY: as in `load`.
        unsafe { two!(N => _mm256_storeu_si256(parts[N].as_mut_ptr().cast(), numbers.0[N])) };
        out
    }

    #[inline(always)]
    fn load_f32(self, numbers: &[f32; BATCH]) -> F32 {
        let (parts, _) = numbers.as_chunks::<8>();
        // SAFETY: as in `load`.
        F32(unsafe { two!(N => _mm256_loadu_ps(parts[N].as_ptr())) })
    }

    #[inline(always)]
    fn store_f32(self, numbers: F32, out: &mut [f32; BATCH]) {
        let (parts, _) = out.as_chunks_mut::<8>();
        // SAFETY: as in `load`.
        unsafe { two!(N => _mm256_storeu_ps(parts[N].as_mut_ptr(), numbers.0[N])) };
    }

    #[inline(always)]
    fn load_f64(self, numbers: &[f64; BATCH]) -> F64 {
        let (parts, _) = numbers.as_chunks::<4>();
        // SAFETY: as in `load`.
        F64(unsafe { four!(N => _mm256_loadu_pd(parts[N].as_ptr())) })
    }

    #[inline(always)]
    fn store_f64(self, numbers: F64, out: &mut [f64; BATCH]) {
        let (parts, _) = out.as_chunks_mut::<4>();
        // SAFETY: as in `load`.
        unsafe { four!(N => _mm256_storeu_pd(parts[N].as_mut_ptr(), numbers.0[N])) };
    }

    #[inline(always)]
    fn mask(self, bits: u16) -> Choice {
        // SAFETY: there is a token.
        unsafe {
            let (all, own) = (_mm256_set1_epi32(bits.into()), self.load(&BITS).0);
            Choice(two!(N => _mm256_cmpeq_epi32(_mm256_and_si256(all, own[N]), own[N])))
        }
    }

    #[inline(always)]
    fn equal(self, a: U32, b: U32) -> Choice {
        // SAFETY: there is a token.
        Choice(unsafe { two!(N => _mm256_cmpeq_epi32(a.0[N], b.0[N])) })
    }

    #[inline(always)]
    fn less(self, a: U32, b: U32) -> Choice {
        // SAFETY: there is a token.
        unsafe {
            let middle = _mm256_set1_epi32(MIDDLE);
            Choice(two!(N => _mm256_cmpgt_epi32(
                _mm256_xor_si256(b.0[N], middle),
                _mm256_xor_si256(a.0[N], middle),
            )))
        }
    }

    #[inline(always)]
    fn select(self, mask: Choice, a: U32, b: U32) -> U32 {
        // SAFETY: there is a token.
        U32(unsafe { two!(N => _mm256_blendv_epi8(b.0[N], a.0[N], mask.0[N])) })
    }

    #[inline(always)]
    fn select_f64(self, mask: Choice, a: F64, b: F64) -> F64 {
        let mask = quarters(self, mask.0);
        // SAFETY: there is a token.
        unsafe {
            let wide = four!(N => _mm256_castsi256_pd(_mm256_cvtepi32_epi64(mask[N])));
            F64(four!(N => _mm256_blendv_pd(b.0[N], a.0[N], wide[N])))
        }
    }

    #[inline(always)]
    fn select_f32(self, mask: Choice, a: F32, b: F32) -> F32 {
        // SAFETY: there is a token.
        F32(unsafe { two!(N => _mm256_blendv_ps(b.0[N], a.0[N], _mm256_castsi256_ps(mask.0[N]))) })
    }

    #[inline(always)]
    fn u32_to_f64(self, numbers: U32) -> F64 {
        // SAFETY: there is a token.
        unsafe {
            let middle = _mm256_set1_epi32(MIDDLE);
            let signed = quarters(self, two!(N => _mm256_xor_si256(numbers.0[N], middle)));
            let back = _mm256_set1_pd(-f64::from(MIDDLE));
            F64(four!(N => _mm256_add_pd(_mm256_cvtepi32_pd(signed[N]), back)))
        }
    }

    #[inline(always)]
    fn i32_to_f64(self, numbers: U32) -> F64 {
        let parts = quarters(self, numbers.0);
        // SAFETY: there is a token.
        F64(unsafe { four!(N => _mm256_cvtepi32_pd(parts[N])) })
    }

    #[inline(always)]
    fn f32_to_f64(self, numbers: F32) -> F64 {
        // SAFETY: there is a token.
        unsafe {
            let parts = quarters(self, two!(N => _mm256_castps_si256(numbers.0[N])));
            F64(four!(N => _mm256_cvtps_pd(_mm_castsi128_ps(parts[N]))))
        }
    }

    #[inline(always)]
    fn f64_to_f32(self, numbers: F64) -> F32 {
        // SAFETY: there is a token.
        unsafe {
            let parts = four!(N => _mm256_cvtpd_ps(numbers.0[N]));
            F32(two!(N => _mm256_set_m128(parts[2 * N + 1], parts[2 * N])))
        }
    }

    #[inline(always)]
    fn truncate(self, numbers: F64) -> U32 {
        // SAFETY: there is a token.
        unsafe {
            let parts = four!(N => _mm256_cvttpd_epi32(numbers.0[N]));
            U32(two!(N => _mm256_set_m128i(parts[2 * N + 1], parts[2 * N])))
        }
    }

    #[inline(always)]
    fn truncate_f32(self, numbers: F32) -> U32 {
        // SAFETY: there is a token.
        U32(unsafe { two!(N => _mm256_cvttps_epi32(numbers.0[N])) })
    }

    #[inline(always)]
    fn u32_to_f32(self, numbers: U32) -> F32 {
        // SAFETY: there is a token.
        F32(unsafe { two!(N => _mm256_cvtepi32_ps(numbers.0[N])) })
    }

    #[inline(always)]
    fn to_unit(self, numbers: F32) -> F32 {
        // SAFETY: there is a token.
        unsafe {
            let (exponent, most) = (_mm256_set1_epi32(0x7F80_0000), _mm256_set1_epi32(0x7F00_0000));
            let own = two!(N => _mm256_and_si256(_mm256_castps_si256(numbers.0[N]), exponent));
            F32(two!(N => _mm256_castsi256_ps(_mm256_sub_epi32(most, own[N]))))
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
        debug_assert!(
            self.store(at).into_iter().all(|n| {
                let (n, size) = (from + i64::from(n as i32), size_of::<T>() as i64);
                n >= 0 && n * size + size.max(4) <= size_of_val(samples.all()) as i64
            }),
            "four bytes in the slice"
        );
        if TypeId::of::<T>() == TypeId::of::<f64>() {
            // SAFETY: samples are f64, and the caller says that they are there. What comes out is sixteen
            // of the exact type of f64, which is `T`.
            return unsafe { transmute_copy(&gather_f64(self, base.cast(), at)) };
        }
        // SAFETY: the four bytes from each number on lie in the slice, as the caller says.
        exact::<T>(self, unsafe { gather(self, base, at) })
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
        debug_assert!(
            self.store(at).into_iter().all(|n| {
                let n = from + i64::from(n as i32);
                n >= 1 && n + 3 <= samples.all().len() as i64
            }),
            "four samples in the slice"
        );
        // SAFETY: there is a token. From the sample below on four lie in the slice: the last is no farther
        // off than a neighbour along y, which is there.
        let [below, own, above] = unsafe {
            match size_of::<T>() {
                1 => {
                    let all = gather(self, below, at);
                    let own = two!(N => _mm256_srli_epi32::<8>(all[N]));
                    [all, own, two!(N => _mm256_srli_epi32::<16>(all[N]))]
                }
                2 => {
                    let first = gather(self, below, at);
                    let own = two!(N => _mm256_srli_epi32::<16>(first[N]));
                    [first, own, gather(self, below.wrapping_add(2), at)]
                }
                _ => {
                    let [below, own, above, _] = words_of_four(self, below.cast(), at);
                    [below, own, above]
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
        // SAFETY: the caller says so.
        unsafe { rows::two_along_x(self, samples, from, at) }
    }

    #[inline(always)]
    unsafe fn four_along_x<T: Lane, const ROWS: usize>(
        self,
        samples: &Samples<'_, T>,
        from: [i64; ROWS],
        at: U32,
    ) -> [[<T::Exact as Exact>::Of<Self>; 4]; ROWS] {
        // SAFETY: the caller says so.
        unsafe { rows::four_along_x(self, samples, from, at) }
    }

    #[inline(always)]
    fn interleave(self, axes: [F32; 3], out: &mut [[f32; 3]; BATCH]) {
        let (registers, _) = out.as_flattened_mut().as_chunks_mut::<4>();
        // SAFETY: there is a token; four numbers of the output are one register of the narrow ones.
        unsafe {
            for half in 0..2 {
                let [x, y, z] = [axes[0].0[half], axes[1].0[half], axes[2].0[half]];
                // Of four vertices in either half of a register: x0 x2 y0 y2, y1 y3 z1 z3, z0 z2 x1 x3.
                let even = _mm256_shuffle_ps::<0b10_00_10_00>(x, y);
                let odd = _mm256_shuffle_ps::<0b11_01_11_01>(y, z);
                let ends = _mm256_shuffle_ps::<0b11_01_10_00>(z, x);
                // x0 y0 z0 x1, y1 z1 x2 y2, z2 x3 y3 z3.
                let thirds = [
                    _mm256_shuffle_ps::<0b10_00_10_00>(even, ends),
                    _mm256_shuffle_ps::<0b11_01_10_00>(odd, even),
                    _mm256_shuffle_ps::<0b11_01_11_01>(ends, odd),
                ];
                for (n, third) in thirds.into_iter().enumerate() {
                    let (low, high) =
                        (_mm256_castps256_ps128(third), _mm256_extractf128_ps::<1>(third));
                    _mm_storeu_ps(registers[6 * half + n].as_mut_ptr(), low);
                    _mm_storeu_ps(registers[6 * half + 3 + n].as_mut_ptr(), high);
                }
            }
        }
    }
}

/// A bit for each place.
const BITS: [u32; BATCH] = {
    let mut bits = [0; BATCH];
    let mut n = 0;
    while n < BATCH {
        bits[n] = 1 << n;
        n += 1;
    }
    bits
};
