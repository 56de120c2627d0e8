//! Eight words at a time, of which blank ones are not counted.

use super::{RowCounts, count_corners};
use crate::{
    BitRows, Word,
    word::wide::{Eight, Eights, words},
};
use std::ops::Range;

#[target_feature(
    enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi2,avx512vpopcntdq"
)]
pub(super) fn count_rows(
    bits: &BitRows<'_>,
    rows: Range<usize>,
    out: &mut [RowCounts],
    mut open: Option<&mut Vec<Word>>,
) {
    if let Some(open) = &mut open {
        open.clear();
    }
    let (first, has_cells) = (rows.start, |row: usize| bits.has_cells(row));
    let mut eights = Eights::new(bits, rows);
    while let Some(eight) = eights.next() {
        let counts = counts(&eight);
        let mask = if has_cells(eight.place(0)[0]) { u64::MAX } else { u64::MAX >> 16 };
        let mut n = 0;
        while n < 8 {
            let [row, w] = eight.place(n);
            let Some(out) = out.get_mut(row - first) else { break };
            // Eight words fill no 16 bits.
            let end = (n + bits.words() - w).min(8);
            out.unpack(counts[n..end].iter().sum::<u64>() & mask);
            n = end;
        }
        if let Some(open) = &mut open {
            eight.push_open_words(open);
        }
    }
}

/// For each word a number of four times 16 bits.
#[inline]
#[target_feature(
    enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi2,avx512vpopcntdq"
)]
fn counts(eight: &Eight) -> [u64; 8] {
    let [a, b, c, d] = eight.low.map(|register| words(register));
    let [a1, b1, c1, d1] = eight.high.map(|register| words(register));
    let cells = words(eight.cells);
    let mut counts = [0; 8];
    for i in 0..8 {
        let (low, high) = ([a[i], b[i], c[i], d[i]], [a1[i], b1[i], c1[i], d1[i]]);
        counts[i] = count_corners(low, high, cells[i]);
    }
    counts
}
