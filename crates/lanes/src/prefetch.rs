//! Memory that is looked at soon, or written: asked for while other memory is worked on.

/// Asks for samples that will be read soon, into the second cache. The machine's own prefetchers stop where a row of a part
/// ends; a part of a spectrum takes 3 % less time so (one thread, AMD EPYC of 2024, `scripts/bench_fields`, 2026-11).
pub fn prefetch<T>(samples: &[T]) {
    ask::<SECOND, T>(samples, 0);
}

/// Asks for what lies so many bytes ahead of samples, into the second cache: the machine's own prefetchers stop at the end of
/// every page of 4 KiB.
#[inline(always)]
pub(crate) fn prefetch_ahead<const BYTES: usize, T>(samples: &[T]) {
    ask::<SECOND, T>(samples, BYTES);
}

/// Asks for what lies so many bytes ahead of some numbers that are written now, into the first cache. Where a surface is
/// larger than the caches, its stores wait for their lines otherwise, and soon all that follows waits for the stores: a
/// gyroid in f32 of 256³ with normals takes 0.93 of the time so, by two threads 0.90, and a sphere of 512³ 0.97 (in used
/// memory, AMD EPYC of 2021, 2026-11).
#[inline(always)]
pub(crate) fn prefetch_beyond<const BYTES: usize, T>(written: &[T]) {
    ask::<FIRST, T>(written, BYTES);
}

/// The cache that lines come to, as the machine numbers its hints: `_MM_HINT_T0` and `_MM_HINT_T1`.
const FIRST: i32 = 3;
const SECOND: i32 = 2;

/// Asks for as many lines as some numbers fill, so many bytes behind them.
#[inline(always)]
fn ask<const CACHE: i32, T>(numbers: &[T], bytes: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _MM_HINT_T1, _mm_prefetch};
        const { assert!(FIRST == _MM_HINT_T0 && SECOND == _MM_HINT_T1, "the machine's numbers") };
        let first = numbers.as_ptr().cast::<i8>().wrapping_add(bytes);
        for place in (0..size_of_val(numbers)).step_by(64) {
            // SAFETY: a prefetch reads nothing, so any address will do.
            unsafe { _mm_prefetch::<CACHE>(first.wrapping_add(place)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (numbers, bytes);
}
