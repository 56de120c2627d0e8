//! Planes of which only some words are compared, and only some others written.

use super::{Lattice, Plane, classify::slice_by_slice};
use crate::{ExtractError, sparse::Choice};
use isokit_job::Job;
use isokit_lanes::{Thresholds, WORD, signs_of_many, words};
use isokit_volume::{Sample, View};
use std::ops::Range;

/// A plane for each threshold, and how many samples were compared. What nobody looks at is left 0.
pub(super) fn chosen<T: Sample, E>(
    view: &View<'_, T>,
    lattice: Lattice,
    thresholds: &Thresholds<T>,
    choice: &Choice,
    job: &Job,
) -> Result<(Vec<Plane>, u64), ExtractError<E>> {
    let [nx, ny, _] = view.dims();
    let is_blank =
        |k: usize| [&choice.compared].into_iter().chain(&choice.full).all(|r| r.skips_slice(k));
    let fill = |k: usize, slices: &mut [&mut [u64]]| {
        let (mut read, mut scratch, mut found) = (0, vec![], vec![]);
        for j in 0..ny {
            let own = lattice.row_of_samples(j);
            for run in choice.compared.of_row(j, k) {
                let row = view.row(j, k).part(run.start * WORD..nx.min(run.end * WORD));
                let row = row.gather(&mut scratch);
                let own_words = words(row.len());
                found.resize(own_words * slices.len(), 0);
                signs_of_many(row, thresholds, &mut found, own_words);
                read += row.len() as u64;
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
        read
    };
    let (planes, read) = slice_by_slice(lattice, thresholds.count(), is_blank, fill, None, job)?;
    Ok((planes, read.iter().sum()))
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
