//! Planes of which only some words are compared, and only some others written.

use super::{Plane, Signs, classify::slice_by_slice};
use crate::{ExtractError, sparse::Choice};
use isokit_job::Job;
use isokit_lanes::{WORD, signs_of_many, words};
use isokit_volume::Sample;
use std::ops::Range;

impl<T: Sample> Signs<'_, T> {
    /// A plane for each threshold. What nobody looks at is left 0.
    pub(super) fn chosen_planes<E>(
        &self,
        choice: &Choice,
        job: &Job,
    ) -> Result<Vec<Plane>, ExtractError<E>> {
        let count = self.thresholds.count();
        let fill = |k: usize, slices: &mut [&mut [u64]]| {
            self.classify_chosen(k, choice, slices, &mut vec![]);
        };
        let is_blank = |k: usize| choice.skips_slice(k);
        Ok(slice_by_slice(self.lattice, count, &is_blank, &fill, None, job)?.0)
    }

    /// The chosen bits of slice `k` of the samples, over zeros for each threshold.
    pub(crate) fn classify_chosen(
        &self,
        k: usize,
        choice: &Choice,
        slices: &mut [&mut [u64]],
        scratch: &mut Vec<T>,
    ) {
        let Self { view, lattice, thresholds, .. } = self;
        let [nx, ny, _] = view.dims();
        let mut found = vec![];
        for j in 0..ny {
            let own = lattice.row_of_samples(j);
            for run in choice.compared.of_row(j, k) {
                let row = view.row(j, k).part(run.start * WORD..nx.min(run.end * WORD));
                let row = row.gather(scratch);
                let own_words = words(row.len());
                if let ([slice], 0) = (&mut *slices, lattice.guard) {
                    let own = &mut slice[own.start + run.start..][..own_words];
                    signs_of_many(row, thresholds, own, own_words);
                    continue;
                }
                found.resize(own_words * slices.len(), 0);
                signs_of_many(row, thresholds, &mut found, own_words);
                for (found, slice) in found.chunks_exact(own_words).zip(&mut *slices) {
                    let words = found.iter().copied();
                    place(words, run.start, lattice.guard, &mut slice[own.clone()]);
                }
            }
            for (slice, full) in slices.iter_mut().zip(&choice.full) {
                for run in full.of_row(j, k) {
                    place(ones(run.clone(), nx), run.start, lattice.guard, &mut slice[own.clone()]);
                }
            }
        }
    }
}

/// Words of a row of `nx` samples that are all inside.
fn ones(words: Range<usize>, nx: usize) -> impl Iterator<Item = u64> {
    words.map(move |w| match nx - WORD * w {
        rest @ 1..WORD => (1 << rest) - 1,
        _ => u64::MAX,
    })
}

/// Adds the words of a row, from word `first` on, behind its guard, if it has one. Words of zeros are not
/// touched.
fn place(words: impl Iterator<Item = u64>, first: usize, guard: usize, row: &mut [u64]) {
    for (word, w) in words.zip(first..).filter(|&(word, _)| word != 0) {
        row[w] |= word << guard;
        let carry = word >> 1 >> (63 - guard);
        if carry != 0 {
            row[w + 1] |= carry;
        }
    }
}
