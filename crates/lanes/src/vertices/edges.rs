//! Edges on their way to vertices.

use crate::{Level, WORD, Word, wide::BATCH, word::OWN};

/// With so many edges or more the queue is to be emptied: calls cost nothing then, and the first cache
/// still holds them all, but for those of dense words.
const FULL: usize = 1024;

/// Words whose edges are added at a time, at most: so many that what each call costs does not count.
pub const BLOCK: usize = 64;

/// Room for what a block may add, along two axes, to a queue that is not full.
const ROOM: usize = FULL + 2 * WORD * BLOCK;

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

    /// Adds the cut edges that the rows of `words` own: row by row those along one axis and then those
    /// along the next. Bit 0 of word 0 of row 0 is sample `first`, whose places may be a wrapped −1. Says
    /// whether the queue is full now.
    ///
    /// # Panics
    ///
    /// If it was full before, if there are more than [`BLOCK`] words, or more than two axes.
    pub fn push(&mut self, axes: &[usize], first: [u32; 2], words: &[Word]) -> bool {
        self.push_at(Level::current(), axes, first, words)
    }

    pub(super) fn push_at(
        &mut self,
        level: Level,
        axes: &[usize],
        first: [u32; 2],
        words: &[Word],
    ) -> bool {
        assert!(self.count < FULL && words.len() <= BLOCK && axes.len() <= 2, "room for all edges");
        match level {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => {
                level.assert_available();
                // SAFETY: the machine has the level and there is room for all words and axes, both asserted above.
                unsafe { self.push_avx512(axes, first, words) }
            }
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => {
                level.assert_available();
                // SAFETY: as above.
                unsafe { self.push_avx2(axes, first, words) }
            }
            _ => {
                for row in words.chunk_by(|a, b| a.row == b.row) {
                    axes.iter().for_each(|&axis| self.push_row_plain(axis, first, row));
                }
            }
        }
        self.count >= FULL
    }

    #[inline(always)]
    fn push_row_plain(&mut self, axis: usize, [x, y]: [u32; 2], words: &[Word]) {
        for word in words {
            let first = x.wrapping_add(word.first as u32);
            let mut cuts = word.cuts[OWN[axis]];
            while cuts != 0 {
                self.axis[self.count] = axis as u32;
                self.x[self.count] = first.wrapping_add(cuts.trailing_zeros());
                self.y[self.count] = y.wrapping_add(word.row as u32);
                self.count += 1;
                cuts &= cuts - 1;
            }
        }
    }

    /// Two at a time: half as many branches that nobody foresees.
    ///
    /// # Safety
    ///
    /// There must be room for the edges of all words along all axes.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn push_avx2(&mut self, axes: &[usize], [x, y]: [u32; 2], words: &[Word]) {
        let lists = [self.x.as_mut_ptr(), self.y.as_mut_ptr(), self.axis.as_mut_ptr()];
        let mut end = self.count;
        for row in words.chunk_by(|a, b| a.row == b.row) {
            let y = y.wrapping_add(row[0].row as u32);
            for &axis in axes {
                for word in row {
                    let mut cuts = word.cuts[OWN[axis]];
                    let first = x.wrapping_add(word.first as u32);
                    let mut at = end;
                    end += cuts.count_ones() as usize;
                    // What is written behind the last is overwritten or stays behind the end.
                    loop {
                        let others = cuts & cuts.wrapping_sub(1);
                        let found =
                            [cuts, others].map(|cuts| first.wrapping_add(cuts.trailing_zeros()));
                        for (list, numbers) in lists.iter().zip([found, [y; 2], [axis as u32; 2]]) {
                            // SAFETY: before `ROOM` there is room for the edges, as the caller says, and behind
                            // it for two more.
                            unsafe { list.add(at).cast::<[u32; 2]>().write(numbers) };
                        }
                        cuts = others & others.wrapping_sub(1);
                        at += 2;
                        if at >= end {
                            break;
                        }
                    }
                }
            }
        }
        self.count = end;
    }

    /// The places of the set bits of a word at once, then sixteen of them at a time.
    ///
    /// # Safety
    ///
    /// There must be room for the edges of all words along all axes.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vbmi2")]
    unsafe fn push_avx512(&mut self, axes: &[usize], [x, y]: [u32; 2], words: &[Word]) {
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
        let lists = [self.x.as_mut_ptr(), self.y.as_mut_ptr(), self.axis.as_mut_ptr()];
        let mut end = self.count;
        for row in words.chunk_by(|a, b| a.row == b.row) {
            let y = _mm512_set1_epi32(y.wrapping_add(row[0].row as u32) as i32);
            for &axis in axes {
                let axes = _mm512_set1_epi32(axis as i32);
                for word in row {
                    let cuts = word.cuts[OWN[axis]];
                    let first = _mm512_set1_epi32(x.wrapping_add(word.first as u32) as i32);
                    let mut found = _mm512_maskz_compress_epi8(cuts, places);
                    let mut at = end;
                    end += cuts.count_ones() as usize;
                    // Most words have one to sixteen; where there is none, what is written is overwritten or
                    // stays behind the end.
                    loop {
                        let low = _mm512_cvtepu8_epi32(_mm512_castsi512_si128(found));
                        let edges = [_mm512_add_epi32(first, low), y, axes];
                        for (list, numbers) in lists.iter().zip(edges) {
                            // SAFETY: before `ROOM` there is room for the edges, as the caller says, and behind
                            // it for a register.
                            unsafe { _mm512_storeu_epi32(list.add(at).cast(), numbers) };
                        }
                        at += BATCH;
                        if at >= end {
                            break;
                        }
                        found = _mm512_alignr_epi64::<2>(found, found);
                    }
                }
            }
        }
        self.count = end;
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
    /// any numbers follow.
    #[inline(always)]
    pub(super) fn batch(&self, first: usize) -> [&[u32; BATCH]; 3] {
        [batch(&self.axis, first), batch(&self.x, first), batch(&self.y, first)]
    }
}

#[inline(always)]
fn batch(list: &[u32], first: usize) -> &[u32; BATCH] {
    list[first..].first_chunk().expect("a batch begins before the last edge")
}
