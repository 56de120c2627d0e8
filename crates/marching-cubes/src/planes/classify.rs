//! From samples to planes, for any number of isovalues with one look at the samples.

use super::{Lattice, Plane, Planes};
use crate::{ExtractError, Nan};
use isokit_job::{Cancelled, Job, OverLimit};
use isokit_lanes::{Threshold, Thresholds, nans, signs_of_many, words};
use isokit_volume::{Sample, View};
use rayon::prelude::*;
use std::sync::Arc;

/// NaN samples met in a task.
#[derive(Clone, Copy, Default)]
struct Found {
    count: u64,
    first: Option<[usize; 3]>,
}

impl Planes {
    /// Compares every sample with every isovalue.
    pub(crate) fn classify<T: Sample, E: Send>(
        view: &View<'_, T>,
        lattice: Lattice,
        isos: &[f64],
        nan: Nan,
        job: &Job,
    ) -> Result<Vec<Self>, ExtractError<E>> {
        let missing = missing(view, lattice, nan, job)?;
        let thresholds: Vec<_> = isos.iter().map(|&iso| view.scaling().threshold(iso)).collect();
        let reached = |threshold: &&Threshold<T>| !matches!(threshold, Threshold::Never);
        let asked: Vec<_> = thresholds.iter().filter(reached).copied().collect();
        let mut inside = match Thresholds::new(&asked) {
            Some(asked) => {
                let test = |row: &[T], _, out: &mut [u64]| {
                    signs_of_many(row, &asked, out);
                    Found::default()
                };
                planes(view, lattice, asked.count(), test, job)?.0
            }
            // Nothing is inside, whatever the samples are: not one is read.
            None => vec![],
        }
        .into_iter();
        let of = |threshold| Self {
            lattice,
            inside: match threshold {
                Threshold::Never => Plane { lattice, bits: vec![] },
                _ => inside.next().expect("a plane for each that is asked"),
            },
            missing: missing.clone(),
        };
        Ok(thresholds.into_iter().map(of).collect())
    }
}

/// Which samples are NaN, where the policy asks and some are.
fn missing<T: Sample, E: Send>(
    view: &View<'_, T>,
    lattice: Lattice,
    nan: Nan,
    job: &Job,
) -> Result<Option<Arc<Plane>>, ExtractError<E>> {
    if nan == Nan::Outside || T::DTYPE.is_integer() {
        return Ok(None);
    }
    let test = |row: &[T], [j, k]: [usize; 2], out: &mut [u64]| {
        nans(row, out);
        let count = out.iter().map(|word| u64::from(word.count_ones())).sum();
        let word = out.iter().position(|&word| word != 0);
        let first = word.map(|w| [64 * w + out[w].trailing_zeros() as usize, j, k]);
        Found { count, first }
    };
    let (mut found, Found { count, first }) = planes(view, lattice, 1, test, job)?;
    match (first, nan) {
        (Some(first), Nan::Error) => Err(ExtractError::Nan { count, first }),
        (Some(_), Nan::Mask) => Ok(found.pop().map(Arc::new)),
        _ => Ok(None),
    }
}

/// `count` planes at once, by `test`, which is given a row, its place, and room for the words of all
/// planes: those of the first 64 samples first.
fn planes<T: Sample, E>(
    view: &View<'_, T>,
    lattice: Lattice,
    count: usize,
    test: impl Fn(&[T], [usize; 2], &mut [u64]) -> Found + Sync,
    job: &Job,
) -> Result<(Vec<Plane>, Found), ExtractError<E>> {
    let [nx, ny, nz] = view.dims();
    let (guard, rows) = (lattice.guard, lattice.rows());
    let size = rows.and_then(|rows| rows.checked_mul(lattice.words as u64));
    let plane = |_| job.limits.zeroed("sign plane", size);
    let mut bits = (0..count).map(plane).collect::<Result<Vec<Vec<u64>>, OverLimit>>()?;
    let fill = |(k, mut slices): (usize, Vec<&mut [u64]>)| {
        job.check()?;
        let (mut found, mut scratch) = (Found::default(), vec![]);
        let mut row_of_all = vec![0; count * words(nx)];
        for j in 0..ny {
            let row = view.row(j, k).gather(&mut scratch);
            let own = (guard + j) * lattice.words..(guard + j + 1) * lattice.words;
            let more = if let [slice] = &mut slices[..] {
                let out = &mut slice[own];
                let more = test(row, [j, k], &mut out[..words(nx)]);
                place(out, guard);
                more
            } else {
                let more = test(row, [j, k], &mut row_of_all);
                for (plane, slice) in slices.iter_mut().enumerate() {
                    let out = &mut slice[own.clone()];
                    let words = row_of_all.chunks_exact(count).map(|all| all[plane]);
                    out.iter_mut().zip(words).for_each(|(out, word)| *out = word);
                    place(out, guard);
                }
                more
            };
            found = Found { count: found.count + more.count, first: found.first.or(more.first) };
        }
        job.progress.advance(1);
        Ok(found)
    };
    let mut slices = slices(&mut bits, lattice.words * lattice.points[1], lattice.points[2]);
    let slices: Vec<_> = slices.drain(guard..guard + nz).collect();
    let found = slices.into_par_iter().enumerate().map(fill);
    let found: Vec<Found> = found.collect::<Result<_, Cancelled>>()?;
    let nan = found.iter().map(|found| found.count).sum();
    let first = found.iter().find_map(|found| found.first);
    let plane = |bits| Plane { lattice, bits };
    Ok((bits.into_iter().map(plane).collect(), Found { count: nan, first }))
}

/// The slices of all planes: for each z, that of every plane.
fn slices(planes: &mut [Vec<u64>], slice: usize, count: usize) -> Vec<Vec<&mut [u64]>> {
    let mut planes: Vec<_> = planes.iter_mut().map(|bits| bits.chunks_exact_mut(slice)).collect();
    let next = |_| planes.iter_mut().filter_map(Iterator::next).collect();
    (0..count).map(next).collect()
}

/// Moves the bits of a row behind its guard, if it has one.
#[inline(always)]
fn place(row: &mut [u64], guard: usize) {
    if guard == 0 {
        return;
    }
    let mut carry = 0;
    for word in row {
        (carry, *word) = (*word >> 63, *word << 1 | carry);
    }
}
