//! Which samples are not a number.

use super::{Lane, Strided, WORD, by_words, pack, words};
use crate::Level;

#[inline(always)]
fn is_nan<T: Lane>(sample: T) -> bool {
    sample.partial_cmp(&sample).is_none()
}

/// Sets the bit of each sample that is NaN, and clears all other bits of `out`.
///
/// # Panics
///
/// If `out` has not [`words`]`(row.len())` words.
pub fn nans<T: Lane>(row: &[T], out: &mut [u64]) {
    assert_eq!(out.len(), words(row.len()), "one bit per sample");
    by_words(row, 1, Strided { out, stride: 0, step: 1 }, |whole, Strided { out, .. }| {
        for (word, samples) in out.iter_mut().zip(whole) {
            *word = pack(samples, is_nan);
        }
    });
}

/// Whether a sample is NaN.
pub fn has_nan<T: Lane>(row: &[T]) -> bool {
    has_nan_at(Level::current(), row)
}

pub(super) fn has_nan_at<T: Lane>(level: Level, row: &[T]) -> bool {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 | Level::Avx2 => {
            level.assert_available();
            // SAFETY: the machine has AVX2 or more, asserted above; the function asks nothing else.
            unsafe { has_nan_avx2(row) }
        }
        _ => has_nan_plain(row),
    }
}

#[inline(always)]
fn has_nan_plain<T: Lane>(row: &[T]) -> bool {
    let (whole, rest) = row.as_chunks::<WORD>();
    // No branch within a word, so that it becomes vector code.
    let of = |samples: &[T]| samples.iter().fold(false, |any, &sample| any | is_nan(sample));
    whole.iter().fold(of(rest), |any, samples| any | of(samples))
}

/// Wider registers gain nothing: the loop waits for samples.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn has_nan_avx2<T: Lane>(row: &[T]) -> bool {
    has_nan_plain(row)
}
