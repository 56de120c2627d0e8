//! Samples on lines, loaded one by one where no instruction loads sixteen as quickly.
//!
//! A loop of its own reads from where each line leads, and in what steps, and writes samples as they are stored: so no
//! number goes through a register of sixteen by itself.

use super::{MOST, TURN};
use crate::{Lane, Samples, wide::BATCH};

/// The batches of a turn that are loaded so.
pub struct Singly<T> {
    /// Which they are, a bit each.
    chosen: u32,
    /// From which sample on their numbers are.
    from: [i64; TURN],
    /// The numbers of the first samples on their lines, and the steps along those.
    lines: [[[u32; BATCH]; 2]; TURN],
    samples: [[[T; BATCH]; MOST]; TURN],
}

impl<T: Lane> Singly<T> {
    pub(super) fn new() -> Self {
        let (from, lines) = ([0; TURN], [[[0; BATCH]; 2]; TURN]);
        Self { chosen: 0, from, lines, samples: [[[T::default(); BATCH]; MOST]; TURN] }
    }

    /// Chooses a batch.
    #[inline(always)]
    pub(super) fn put(&mut self, batch: usize, from: i64, lines: [[u32; BATCH]; 2]) {
        self.chosen |= 1 << batch;
        (self.from[batch], self.lines[batch]) = (from, lines);
    }

    /// Loads so many samples on each line of the batches that are chosen, by batches and by their place on the lines;
    /// none is chosen then.
    ///
    /// # Safety
    ///
    /// They must all be samples of `samples`, whose numbers from the one that they count from, and whose steps, fit in 31 bits
    /// and a sign.
    #[inline(always)]
    pub(super) unsafe fn take<const HELD: usize>(
        &mut self,
        samples: &Samples<'_, T>,
    ) -> impl Iterator<Item = (usize, &[[T; BATCH]])> {
        let all = samples.all().as_ptr();
        let chosen = std::mem::take(&mut self.chosen);
        let is_chosen = move |batch: usize| chosen >> batch & 1 == 1;
        for batch in (0..TURN).filter(|&batch| is_chosen(batch)) {
            let from = all.wrapping_offset(self.from[batch] as isize);
            let ([begin, step], to) = (&self.lines[batch], &mut self.samples[batch]);
            for n in 0..BATCH {
                let (mut sample, step) =
                    (from.wrapping_offset(begin[n] as i32 as isize), step[n] as i32 as isize);
                for to in &mut to[..HELD] {
                    debug_assert!(samples.all().as_ptr_range().contains(&sample), "a sample");
                    // SAFETY: the caller says that it is one of the samples.
                    to[n] = unsafe { *sample };
                    sample = sample.wrapping_offset(step);
                }
            }
        }
        let samples = self.samples.iter().enumerate().filter(move |&(batch, _)| is_chosen(batch));
        samples.map(|(batch, samples)| (batch, &samples[..HELD]))
    }
}
