//! The loop with wider registers.

use super::{Columns, add_row_plain, padded};
use crate::{
    Lane, WORD,
    prefetch::prefetch_ahead,
    signs::{avx2::AHEAD, avx512},
};
use std::{any::TypeId, arch::x86_64::*, slice};

#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512dq")]
pub(super) fn add_row_avx512<T: Lane>(row: &[T], columns: &mut [Columns<T>]) {
    add_row_plain::<T, { avx512::AHEAD }>(row, columns);
}

/// With loops of their own for floats, of which the compiler would store each that changes by a mask: row `index` of
/// `scripts/bench`.
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn add_row_avx2<T: Lane>(row: &[T], columns: &mut [Columns<T>]) {
    if let Some((row, columns)) = as_type(row, columns) {
        return add_f32(row, columns);
    }
    if let Some((row, columns)) = as_type(row, columns) {
        return add_f64(row, columns);
    }
    add_row_plain::<T, AHEAD>(row, columns);
}

/// The same row and columns, if their type is `U`.
fn as_type<'a, T: Lane, U: Lane>(
    row: &'a [T],
    columns: &'a mut [Columns<T>],
) -> Option<(&'a [U], &'a mut [Columns<U>])> {
    let is_same = TypeId::of::<T>() == TypeId::of::<U>();
    // SAFETY: the two types are one.
    is_same.then(|| unsafe {
        let row = slice::from_raw_parts(row.as_ptr().cast(), row.len());
        (row, slice::from_raw_parts_mut(columns.as_mut_ptr().cast(), columns.len()))
    })
}

/// The loop for one type of float. Of two that are equal, or of which one is NaN, `$min` and `$max` give the second.
macro_rules! floats {
    (
        $add:ident $take:ident $t:ident $lanes:literal
        $load:ident $store:ident $min:ident $max:ident $compare:ident $bits:ident
    ) => {
        #[target_feature(enable = "avx2")]
        fn $add(row: &[$t], columns: &mut [Columns<$t>]) {
            let (whole, rest) = row.as_chunks::<WORD>();
            for (samples, columns) in whole.iter().zip(&mut *columns) {
                $take(columns, samples);
            }
            if let (Some(samples), Some(columns)) = (padded(rest), columns.last_mut()) {
                $take(columns, &samples);
            }
        }

        #[inline]
        #[target_feature(enable = "avx2")]
        fn $take(columns: &mut Columns<$t>, samples: &[$t; WORD]) {
            prefetch_ahead::<AHEAD, _>(samples);
            let (parts, _) = samples.as_chunks::<$lanes>();
            let (least, _) = columns.least.as_chunks_mut::<$lanes>();
            let (greatest, _) = columns.greatest.as_chunks_mut::<$lanes>();
            let mut nans = 0;
            for ((part, least), greatest) in parts.iter().zip(least).zip(greatest) {
                // SAFETY: each is one register's worth of numbers; loads and stores need no alignment.
                unsafe {
                    let part = $load(part.as_ptr());
                    $store(least.as_mut_ptr(), $min(part, $load(least.as_ptr())));
                    $store(greatest.as_mut_ptr(), $max(part, $load(greatest.as_ptr())));
                    nans |= $bits($compare::<_CMP_UNORD_Q>(part, part));
                }
            }
            columns.has_nan |= nans != 0;
            columns.first_has_nan |= samples[0].is_nan();
        }
    };
}

floats!(
    add_f32 take_f32 f32 8
    _mm256_loadu_ps _mm256_storeu_ps _mm256_min_ps _mm256_max_ps _mm256_cmp_ps
    _mm256_movemask_ps
);
floats!(
    add_f64 take_f64 f64 4
    _mm256_loadu_pd _mm256_storeu_pd _mm256_min_pd _mm256_max_pd _mm256_cmp_pd
    _mm256_movemask_pd
);
