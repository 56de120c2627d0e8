//! Arithmetic as Rust means it, whatever else is in the process.
//!
//! A library compiled with `-ffast-math` has denormal numbers taken for 0 (FTZ and DAZ) in the thread that
//! loads it and in all that this thread starts. Then `-1e-45 >= 0.0` holds, and a mesh is another. So what
//! compares samples or computes with them does it within [`exactly`], where a call comes in and again where
//! a thread begins a task. Elsewhere than on x86-64 it calls and does nothing else.

/// Calls `work` with denormal numbers kept and results rounded to the nearest, and afterwards has things as
/// they were, also after a panic. In a thread where nothing was changed this costs one read of a register.
#[inline]
pub fn exactly<R>(work: impl FnOnce() -> R) -> R {
    let _restored = control::Usual::begin();
    apart(work)
}

/// In a function of its own, so that no arithmetic moves to before or after the change.
#[inline(never)]
fn apart<R>(work: impl FnOnce() -> R) -> R {
    work()
}

// Miri knows no `asm!`.
#[cfg(all(target_arch = "x86_64", not(miri)))]
mod control {
    use std::arch::asm;

    /// Denormal numbers are kept, results rounded to the nearest, exceptions masked: what Rust relies on.
    const USUAL: u32 = 0x1F80;

    /// The bits that tell what has happened, which nobody here asks.
    const HAPPENED: u32 = 0x3F;

    /// Takes back what it changed when it is dropped.
    pub(super) struct Usual {
        before: Option<u32>,
    }

    impl Usual {
        #[inline]
        pub(super) fn begin() -> Self {
            let before = Some(read()).filter(|word| word & !HAPPENED != USUAL);
            if before.is_some() {
                // SAFETY: these are the settings that Rust relies on.
                unsafe { write(USUAL) };
            }
            Self { before }
        }
    }

    impl Drop for Usual {
        #[inline]
        fn drop(&mut self) {
            if let Some(word) = self.before {
                // SAFETY: the thread had these settings when `begin` was called, from there on they are again
                // the affair of whoever chose them. They change what arithmetic gives, never where memory is.
                unsafe { write(word) };
            }
        }
    }

    /// The thread's settings, the register MXCSR.
    #[inline]
    pub(super) fn read() -> u32 {
        let mut word = 0_u32;
        // SAFETY: it stores four bytes into `word`; every x86-64 has the instruction.
        unsafe {
            asm!("stmxcsr [{}]", in(reg) &raw mut word, options(nostack, preserves_flags));
        }
        word
    }

    /// Sets them.
    ///
    /// # Safety
    ///
    /// No bit is reserved: the word is [`USUAL`] or what [`read`] gave. Rust's own arithmetic relies on
    /// [`USUAL`]; what runs under another word may compute other numbers, and nothing worse if no memory
    /// depends on them.
    #[inline]
    pub(super) unsafe fn write(word: u32) {
        // SAFETY: it reads four bytes of `word`; no bit is reserved, as the caller says.
        unsafe {
            asm!("ldmxcsr [{}]", in(reg) &raw const word, options(nostack));
        }
    }
}

#[cfg(not(all(target_arch = "x86_64", not(miri))))]
mod control {
    /// Nothing is known here that could be changed.
    pub(super) struct Usual;

    impl Usual {
        pub(super) fn begin() -> Self {
            Self
        }
    }
}

#[cfg(all(test, target_arch = "x86_64", not(miri)))]
mod tests {
    use super::{control, exactly};
    use crate::{Threshold, Thresholds, signs_of_many};
    use std::{
        hint::black_box,
        panic::{catch_unwind, resume_unwind},
    };

    /// Flush to zero, denormals are zero, and round up.
    const FOREIGN: u32 = 0x1F80 | 0x8000 | 0x0040 | 0x4000;

    /// Runs `work` as foreign code may leave a thread, in a thread of its own.
    fn under_foreign<R: Send + 'static>(work: impl FnOnce() -> R + Send + 'static) -> R {
        let thread = std::thread::spawn(|| {
            // SAFETY: no bit is reserved, and no memory depends on the numbers that tests compute here.
            unsafe { control::write(FOREIGN) };
            work()
        });
        thread.join().unwrap()
    }

    fn least_doubled() -> f32 {
        black_box(f32::from_bits(1)) * black_box(2.0)
    }

    fn signs() -> Vec<u64> {
        let row: Vec<f32> = (0..200).map(|n| f32::from_bits((n % 7) | (n << 31))).collect();
        let thresholds = Thresholds::new(&[Threshold::AtLeast(f32::from_bits(3))]).unwrap();
        let mut out = vec![0; 4];
        signs_of_many(black_box(&row), &thresholds, &mut out, 4);
        out
    }

    #[test]
    fn denormal_numbers_are_lost_under_foreign_settings_and_kept_within() {
        let (outside, within, after) =
            under_foreign(|| (least_doubled(), exactly(least_doubled), least_doubled()));
        assert_eq!([outside, within, after].map(f32::to_bits), [0, 2, 0]);
        let (outside, within) = under_foreign(|| (signs(), exactly(signs)));
        assert_eq!(within, signs());
        assert_ne!(outside, signs(), "or the guard is not needed");
    }

    #[test]
    fn results_are_rounded_to_the_nearest_within() {
        let third = || black_box(1.0_f64) / black_box(3.0);
        let (outside, within) = under_foreign(move || (third(), exactly(third)));
        assert_eq!((within, outside), (third(), third().next_up()));
    }

    #[test]
    fn settings_are_as_they_were_after_the_call_and_after_a_panic() {
        let words = under_foreign(|| {
            let before = control::read();
            let within = exactly(control::read);
            let panicked = catch_unwind(|| exactly::<()>(|| resume_unwind(Box::new(()))));
            assert!(panicked.is_err());
            [before, within, control::read()].map(|word| word & !0x3F)
        });
        assert_eq!(words, [FOREIGN, 0x1F80, FOREIGN]);
    }
}
