//! Triangles with the eight lists in one register.

use super::{CaseTable, FirstVertices, Word};
use crate::prefetch::prefetch_beyond;
use std::arch::x86_64::*;

/// Room that is asked for while the triangles of a cell are written, in bytes behind them.
const AHEAD: usize = 1 << 11;

/// The eight lists are the lanes of one register, and cells that cut an edge are gone through in turn: the
/// numbers of one are those of the one before, one further on where that one's edge is cut. So the second
/// neighbours along y and z are where the next cell's lists begin.
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn triangles_avx2(
    words: &[Word],
    mut first: impl FnMut(usize) -> FirstVertices,
    table: &CaseTable,
    out: &mut [[u32; 3]],
) -> usize {
    let (mut next, mut row) = (_mm256_setzero_si256(), None);
    // Where the numbers of a cell's edges are, in (x0 x1 y0 y2 x2 x3 z0 z2 | the same, further on).
    let order = _mm_setr_epi8(0, 1, 4, 5, 2, 10, 3, 11, 6, 14, 7, 15, 0, 0, 0, 0);
    let one = _mm256_set1_epi64x(1);
    let out = out.as_flattened_mut();
    let (mut filled, mut rest) = (0, [0; 16]);
    for word in words {
        if row != Some(word.row) {
            let FirstVertices { x: [a, b, c, d], y: [e, f], z: [g, h] } = first(word.row);
            let lists = [a, b, e, f, c, d, g, h];
            // SAFETY: eight numbers fill the register; the load needs no alignment.
            next = unsafe { _mm256_loadu_si256(lists.as_ptr().cast()) };
            row = Some(word.row);
        }
        if word.active == 0 {
            let counts = word.cuts.map(|cuts| cuts.count_ones() as i32);
            let [a, b, c, d, e, f, g, h] = counts;
            next = _mm256_add_epi32(next, _mm256_setr_epi32(a, b, e, f, c, d, g, h));
            continue;
        }
        let (cuts, corners) = (word.cuts.as_chunks::<4>().0, word.corners.as_chunks::<4>().0);
        // SAFETY: all are four 64-bit numbers.
        let [x, y_z, near, far] = unsafe {
            [&cuts[0], &cuts[1], &corners[0], &corners[1]]
                .map(|part| _mm256_loadu_si256(part.as_ptr().cast()))
        };
        let mut left = word.cuts.iter().fold(word.active, |all, cuts| all | cuts);
        while left != 0 {
            let cell = left.trailing_zeros();
            left &= left - 1;
            let down = _mm_cvtsi32_si128(cell as i32);
            let up = _mm_cvtsi32_si128(63 - cell as i32);
            let is_cut = |list| _mm256_and_si256(_mm256_srl_epi64(list, down), one);
            let [x, y_z] = [is_cut(x), is_cut(y_z)].map(|cut| _mm256_castsi256_ps(cut));
            let cut = _mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(x, y_z));
            let (low, high) = (next, _mm256_add_epi32(next, cut));
            next = high;
            let sign =
                |list| _mm256_movemask_pd(_mm256_castsi256_pd(_mm256_sll_epi64(list, up))) as usize;
            let case = sign(near) | sign(far) << 4;
            // SAFETY: a row of the table is 16 bytes.
            let edges = unsafe { _mm_loadu_si128(table.edges[case].as_ptr().cast()) };
            let places = _mm_shuffle_epi8(order, edges);
            let ids = |places| {
                let places = _mm256_cvtepu8_epi32(places);
                let is_high = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(places));
                let [low, high] = [low, high]
                    .map(|ids| _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(ids, places)));
                _mm256_castps_si256(_mm256_blendv_ps(low, high, is_high))
            };
            let [start, end] = [ids(places), ids(_mm_unpackhi_epi64(places, places))];
            let is_active = (word.active >> cell & 1) as usize;
            let count = 3 * usize::from(table.counts[case]) * is_active;
            // What is written too much is overwritten by the next cell, or stays behind the last triangle.
            let (room, is_whole) = match out[filled..].first_chunk_mut::<16>() {
                Some(room) => {
                    prefetch_beyond::<AHEAD, _>(room);
                    (room, true)
                }
                None => (&mut rest, false),
            };
            let (parts, _) = room.as_chunks_mut::<8>();
            // SAFETY: each part is a register.
            unsafe {
                _mm256_storeu_si256(parts[0].as_mut_ptr().cast(), start);
                _mm256_storeu_si256(parts[1].as_mut_ptr().cast(), end);
            }
            if !is_whole {
                out[filled..filled + count].copy_from_slice(&rest[..count]);
            }
            filled += count;
        }
    }
    filled / 3
}

#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn ids(first: &FirstVertices, word: &Word, cell: u32) -> [u32; 16] {
    first.ids_plain(word, cell)
}

#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn pass(next: &mut FirstVertices, word: &Word) {
    next.pass_plain(word);
}

/// The eight lists are the lanes of one register: a population count gives all eight numbers of a
/// cell, a bit test its case, a permutation by the table its triangles, one store writes them.
#[target_feature(
    enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl,avx512vpopcntdq"
)]
pub(super) fn triangles_avx512(
    words: &[Word],
    mut first: impl FnMut(usize) -> FirstVertices,
    table: &CaseTable,
    out: &mut [[u32; 3]],
) -> usize {
    let (mut next, mut row) = (_mm512_setzero_si512(), None);
    // From (x0…x3 y0 y2 z0 z2 | the same, one further on if cut) to the order of a cell's edges.
    let order = _mm512_setr_epi32(0, 1, 2, 3, 4, 12, 5, 13, 6, 14, 7, 15, 0, 0, 0, 0);
    let out = out.as_flattened_mut();
    let mut filled = 0;
    for word in words {
        if row != Some(word.row) {
            let FirstVertices { x: [a, b, c, d], y: [e, f], z: [g, h] } = first(word.row);
            let lists = [a, b, c, d, e, f, g, h].map(i64::from);
            // SAFETY: eight 64-bit numbers fill the register; the load needs no alignment.
            next = unsafe { _mm512_loadu_epi64(lists.as_ptr()) };
            row = Some(word.row);
        }
        // SAFETY: both are eight 64-bit numbers.
        let (cuts, corners) = unsafe {
            (
                _mm512_loadu_epi64(word.cuts.as_ptr().cast()),
                _mm512_loadu_epi64(word.corners.as_ptr().cast()),
            )
        };
        let mut active = word.active;
        while active != 0 {
            let cell = active.trailing_zeros();
            let bit = active & active.wrapping_neg();
            active ^= bit;
            let own = _mm512_set1_epi64(bit as i64);
            let before = _mm512_and_si512(cuts, _mm512_set1_epi64((bit - 1) as i64));
            let low = _mm512_add_epi64(next, _mm512_popcnt_epi64(before));
            let cut = _mm512_srl_epi64(_mm512_and_si512(cuts, own), _mm_cvtsi64_si128(cell.into()));
            let high = _mm512_add_epi64(low, cut);
            let ids = _mm512_inserti64x4::<1>(
                _mm512_castsi256_si512(_mm512_cvtepi64_epi32(low)),
                _mm512_cvtepi64_epi32(high),
            );
            let ids = _mm512_permutexvar_epi32(order, ids);
            let case = usize::from(_mm512_test_epi64_mask(corners, own));
            // SAFETY: a row of the table is 16 bytes.
            let edges = unsafe { _mm_loadu_si128(table.edges[case].as_ptr().cast()) };
            let corners_of_all = _mm512_permutexvar_epi32(_mm512_cvtepu8_epi32(edges), ids);
            let count = 3 * usize::from(table.counts[case]);
            if let Some(room) = out[filled..].first_chunk_mut::<16>() {
                prefetch_beyond::<AHEAD, _>(room);
                // What is written too much is overwritten by the next cell, or masked below.
                // SAFETY: there is room for 16 numbers.
                unsafe { _mm512_storeu_epi32(room.as_mut_ptr().cast(), corners_of_all) };
            } else {
                let room = &mut out[filled..filled + count];
                let mask = ((1_u32 << count) - 1) as u16;
                // SAFETY: the mask lets through `count` numbers, for which there is room.
                unsafe {
                    _mm512_mask_storeu_epi32(room.as_mut_ptr().cast(), mask, corners_of_all);
                }
            }
            filled += count;
        }
        next = _mm512_add_epi64(next, _mm512_popcnt_epi64(cuts));
    }
    filled / 3
}
