//! Sixteen samples from anywhere, as f64.

use super::Lanes;
use crate::{Lane, Samples};

/// How a level loads.
pub(super) trait Load: Copy {
    /// The samples of these numbers.
    ///
    /// # Safety
    ///
    /// Each must be the number of a lattice point of `samples`.
    unsafe fn load<T: Lane>(self, samples: &Samples<'_, T>, numbers: &Lanes<i64>) -> Lanes;
}

/// One by one.
#[derive(Clone, Copy)]
pub(super) struct Plain;

impl Load for Plain {
    #[inline(always)]
    unsafe fn load<T: Lane>(self, samples: &Samples<'_, T>, numbers: &Lanes<i64>) -> Lanes {
        // SAFETY: a lattice point's sample lies in the slice, as `Samples` guarantees.
        let stored = numbers.map(|number| unsafe { *samples.all().get_unchecked(number as usize) });
        stored.map(Into::into)
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use gather::Gather;

#[cfg(target_arch = "x86_64")]
mod gather {
    use super::{Lanes, Load, Plain};
    use crate::{Lane, Samples};
    use std::{any::TypeId, arch::x86_64::*};

    /// Eight at a time with AVX-512, where samples are 4 or 8 bytes wide. A token: who holds one may.
    #[derive(Clone, Copy)]
    pub(in super::super) struct Gather(());

    impl Gather {
        /// # Safety
        ///
        /// The machine must have AVX-512 F and VL.
        pub(in super::super) unsafe fn new() -> Self {
            Self(())
        }
    }

    impl Load for Gather {
        #[inline(always)]
        unsafe fn load<T: Lane>(self, samples: &Samples<'_, T>, numbers: &Lanes<i64>) -> Lanes {
            let base = samples.all().as_ptr();
            let is = |id: TypeId| TypeId::of::<T>() == id;
            // SAFETY: the numbers are of samples in the slice, as the caller promises; `base` points to
            // samples of the type compared with; the machine has the instructions, or there were no token.
            unsafe {
                if is(TypeId::of::<f32>()) {
                    f32s(base.cast(), numbers)
                } else if is(TypeId::of::<f64>()) {
                    f64s(base.cast(), numbers)
                } else if is(TypeId::of::<i32>()) {
                    i32s(base.cast(), numbers)
                } else if is(TypeId::of::<u32>()) {
                    u32s(base.cast(), numbers)
                } else {
                    Plain.load(samples, numbers)
                }
            }
        }
    }

    /// Both halves of a batch, by a function of eight numbers.
    macro_rules! halves {
        ($name:ident, $t:ty, |$base:ident, $numbers:ident| $load:expr) => {
            /// # Safety
            ///
            /// `base` plus each number must point to a sample.
            #[inline]
            #[target_feature(enable = "avx512f,avx512vl")]
            unsafe fn $name($base: *const $t, numbers: &Lanes<i64>) -> Lanes {
                let mut out = [0.0; 16];
                let (from, _) = numbers.as_chunks::<8>();
                let (to, _) = out.as_chunks_mut::<8>();
                for (from, to) in from.iter().zip(to) {
                    // SAFETY: each half is one register of 64-bit numbers, `from` to read and `to` to
                    // write; what is gathered the caller answers for.
                    unsafe {
                        let $numbers = _mm512_loadu_epi64(from.as_ptr());
                        _mm512_storeu_pd(to.as_mut_ptr(), $load);
                    }
                }
                out
            }
        };
    }

    halves!(f32s, f32, |base, at| _mm512_cvtps_pd(_mm512_i64gather_ps::<4>(at, base.cast())));
    halves!(f64s, f64, |base, at| _mm512_i64gather_pd::<8>(at, base.cast()));
    halves!(i32s, i32, |base, at| _mm512_cvtepi32_pd(_mm512_i64gather_epi32::<4>(at, base.cast())));
    halves!(u32s, u32, |base, at| _mm512_cvtepu32_pd(_mm512_i64gather_epi32::<4>(at, base.cast())));
}
