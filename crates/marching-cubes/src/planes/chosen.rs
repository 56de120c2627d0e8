//! Planes of which only some words are compared, and only some others written.

use super::{
    Lattice, Plane,
    classify::{of_bits, slices, zeros},
};
use crate::{ExtractError, sparse::Choice};
use isokit_job::{Cancelled, Job};
use isokit_lanes::{Thresholds, WORD, signs_of_many, words};
use isokit_volume::{Sample, View};
use rayon::prelude::*;
use std::ops::Range;

/// A plane for each threshold, and how many samples were compared. What nobody looks at is left 0.
pub(super) fn chosen<T: Sample, E>(
    view: &View<'_, T>,
    lattice: Lattice,
    thresholds: &Thresholds<T>,
    choice: &Choice,
    job: &Job,
) -> Result<(Vec<Plane>, u64), ExtractError<E>> {
    let ([nx, ny, _], count) = (view.dims(), thresholds.count());
    let mut bits = zeros(lattice, count, job)?;
    let fill = |(k, mut slices): (usize, Vec<&mut [u64]>)| {
        job.check()?;
        let (mut read, mut scratch, mut found) = (0, vec![], vec![]);
        let is_blank = [&choice.compared].into_iter().chain(&choice.full).all(|r| r.skips_slice(k));
        for j in 0..if is_blank { 0 } else { ny } {
            let own = j * lattice.words..(j + 1) * lattice.words;
            for run in choice.compared.of_row(j, k) {
                let row = view.row(j, k).part(run.start * WORD..nx.min(run.end * WORD));
                let row = row.gather(&mut scratch);
                let own_words = words(row.len());
                found.resize(own_words * count, 0);
                signs_of_many(row, thresholds, &mut found, own_words);
                read += row.len() as u64;
                for (found, slice) in found.chunks_exact(own_words).zip(&mut slices) {
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
        job.progress.advance(1);
        Ok(read)
    };
    let tasks = slices(&mut bits, lattice).into_par_iter().enumerate();
    let read = tasks.map(fill).collect::<Result<Vec<u64>, Cancelled>>()?;
    Ok((of_bits(lattice, bits), read.iter().sum()))
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
