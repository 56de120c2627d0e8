//! Edges on their way to vertices.

use super::wide::BATCH;
use crate::{Level, WORD, Word, word::OWN};

/// Edges that are held at most: enough that calls cost nothing, few enough for the first cache.
const ROOM: usize = 1024;

/// What a register may write beyond the last edge.
const SLACK: usize = BATCH;

/// Edges between samples of one slice, by axis and lower end.
#[derive(Clone, Debug)]
pub struct Edges {
    /// The axis, 0 to 2, of each.
    axis: Vec<u32>,
    /// The lower end of each.
    x: Vec<u32>,
    y: Vec<u32>,
    /// The slice of all lower ends.
    z: u32,
    count: usize,
}

impl Default for Edges {
    fn default() -> Self {
        let numbers = || vec![0; ROOM + SLACK];
        Self { axis: numbers(), x: numbers(), y: numbers(), z: 0, count: 0 }
    }
}

impl Edges {
    /// Forgets all edges; those to come have their lower ends in slice `z`.
    pub fn begin(&mut self, z: u32) {
        (self.z, self.count) = (z, 0);
    }

    /// Forgets all edges.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds the cut edges along `axis` that start in the words of row `y`, where bit 0 of word 0 is
    /// sample `x`, which may be a wrapped −1. Says of how many words there was room for the edges.
    pub fn push(&mut self, axis: usize, [x, y]: [u32; 2], words: &[Word]) -> usize {
        self.push_at(Level::current(), axis, [x, y], words)
    }

    pub(super) fn push_at(
        &mut self,
        level: Level,
        axis: usize,
        [x, y]: [u32; 2],
        words: &[Word],
    ) -> usize {
        match level {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => {
                level.assert_available();
                // SAFETY: the machine has the level, asserted above; the function asks nothing else.
                unsafe { self.push_avx512(axis, [x, y], words) }
            }
            _ => self.push_plain(axis, [x, y], words),
        }
    }

    #[inline(always)]
    fn push_plain(&mut self, axis: usize, [x, y]: [u32; 2], words: &[Word]) -> usize {
        for (n, word) in words.iter().enumerate() {
            if self.count + WORD > ROOM {
                return n;
            }
            let first = x.wrapping_add(word.first as u32);
            let mut cuts = word.owned()[axis];
            while cuts != 0 {
                self.axis[self.count] = axis as u32;
                self.x[self.count] = first.wrapping_add(cuts.trailing_zeros());
                self.y[self.count] = y;
                self.count += 1;
                cuts &= cuts - 1;
            }
        }
        words.len()
    }

    /// The places of the set bits of a word at once, then sixteen of them at a time.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vbmi2")]
    fn push_avx512(&mut self, axis: usize, [x, y]: [u32; 2], words: &[Word]) -> usize {
        use std::arch::x86_64::*;
        const PLACES: [u8; WORD] = {
            let mut places = [0; WORD];
            let mut i = 0;
            while i < WORD {
                places[i] = i as u8;
                i += 1;
            }
            places
        };
        // SAFETY: the places fill one register; the load needs no alignment.
        let places = unsafe { _mm512_loadu_epi8(PLACES.as_ptr().cast()) };
        let (axes, ys) = (_mm512_set1_epi32(axis as i32), _mm512_set1_epi32(y as i32));
        let mut lists =
            [&mut self.x, &mut self.y, &mut self.axis].map(|list| &mut list[..ROOM + SLACK]);
        for (n, word) in words.iter().enumerate() {
            let cuts = word.cuts[OWN[axis]];
            if cuts == 0 {
                continue;
            }
            if self.count + WORD > ROOM {
                return n;
            }
            let first = _mm512_set1_epi32(x.wrapping_add(word.first as u32) as i32);
            let mut found = _mm512_maskz_compress_epi8(cuts, places);
            let count = cuts.count_ones() as usize;
            for from in (0..count).step_by(BATCH) {
                let low = _mm512_cvtepu8_epi32(_mm512_castsi512_si128(found));
                found = _mm512_alignr_epi64::<2>(found, found);
                let numbers = [_mm512_add_epi32(first, low), ys, axes];
                for (list, numbers) in lists.iter_mut().zip(numbers) {
                    let room = &mut list[self.count + from..][..BATCH];
                    // SAFETY: there is room for sixteen numbers.
                    unsafe { _mm512_storeu_epi32(room.as_mut_ptr().cast(), numbers) };
                }
            }
            self.count += count;
        }
        words.len()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Axis and lower end of edge `n`.
    pub fn get(&self, n: usize) -> (usize, [u32; 3]) {
        (self.axis[n] as usize, [self.x[n], self.y[n], self.z])
    }

    /// The slice of all lower ends.
    pub(super) fn z(&self) -> u32 {
        self.z
    }

    /// Axes, x and y of the lower ends of the batch that begins with edge `first`. After the last edge
    /// others follow that once were there.
    #[inline(always)]
    pub(super) fn batch(&self, first: usize) -> [&[u32; BATCH]; 3] {
        [batch(&self.axis, first), batch(&self.x, first), batch(&self.y, first)]
    }
}

#[inline(always)]
fn batch(list: &[u32], first: usize) -> &[u32; BATCH] {
    list[first..].first_chunk().expect("a batch begins before the last edge")
}
