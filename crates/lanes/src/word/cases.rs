//! The cases of crossed cells, one after the other.

use super::Word;
use crate::Level;
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

/// Adds the cases of all crossed cells of some words to `out`, in their order.
pub fn add_cases(words: &[Word], out: &mut Vec<u8>) {
    add_cases_at(Level::current(), words, out);
}

pub(super) fn add_cases_at(level: Level, words: &[Word], out: &mut Vec<u8>) {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 | Level::Avx2 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above, and with it what the lower one has.
            unsafe { add_cases_avx2(words, out) }
        }
        _ => words.iter().for_each(|word| add_cases_plain(word, out)),
    }
}

/// Eight cells at a time.
fn add_cases_plain(word: &Word, out: &mut Vec<u8>) {
    for first in (0..u64::BITS).step_by(8) {
        let mut active = word.active >> first & 0xFF;
        if active == 0 {
            continue;
        }
        let corners = word.corners.iter().rev();
        let rows = corners.fold(0, |rows, corner| rows << 8 | (corner >> first & 0xFF));
        let cases = transposed(rows).to_le_bytes();
        while active != 0 {
            out.push(cases[active.trailing_zeros() as usize]);
            active &= active - 1;
        }
    }
}

/// Eight bytes of which bit `i` of byte `k` becomes bit `k` of byte `i` (Warren, "Hacker's Delight", 2nd edition 2013,
/// section 7-3).
fn transposed(rows: u64) -> u64 {
    let swapped = |rows: u64, by: u32, mask: u64| {
        let other = (rows ^ rows >> by) & mask;
        rows ^ other ^ other << by
    };
    let rows = swapped(rows, 7, 0x00AA_00AA_00AA_00AA);
    let rows = swapped(rows, 14, 0x0000_CCCC_0000_CCCC);
    swapped(rows, 28, 0x0000_0000_F0F0_F0F0)
}

/// The bits of a cell at all eight corners become the signs of eight numbers, and those its case.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn add_cases_avx2(words: &[Word], out: &mut Vec<u8>) {
    for word in words {
        let parts = word.corners.as_chunks::<4>().0;
        // SAFETY: each is four 64-bit numbers; the load needs no alignment.
        let [near, far] =
            unsafe { [&parts[0], &parts[1]].map(|part| _mm256_loadu_si256(part.as_ptr().cast())) };
        let mut active = word.active;
        out.reserve(active.count_ones() as usize);
        while active != 0 {
            let up = _mm_cvtsi32_si128(63 - active.trailing_zeros() as i32);
            active &= active - 1;
            let signs =
                |list| _mm256_movemask_pd(_mm256_castsi256_pd(_mm256_sll_epi64(list, up))) as u8;
            out.push(signs(near) | signs(far) << 4);
        }
    }
}
