//! From samples to planes, for any number of isovalues with one look at the samples.

use super::{Lattice, Plane, Planes, behind_guard, chosen::chosen};
use crate::{ExtractError, Nan, Skipped, Source, found::Found, sparse::Choice};
use isokit_job::{Cancelled, Job, OverLimit};
use isokit_lanes::{Threshold, Thresholds, has_nan, nans, signs_of_many, words};
use isokit_volume::{Bricks, Sample, View};
use rayon::prelude::*;
use std::sync::Arc;

impl Planes {
    /// Compares samples with every isovalue: all samples, or those of which bricks do not tell.
    pub(crate) fn classify<T: Sample, E: Send>(
        Source { view, bricks }: &Source<'_, T>,
        lattice: Lattice,
        isos: &[f64],
        nan: Nan,
        job: &Job,
    ) -> Result<(Vec<Self>, Skipped), ExtractError<E>> {
        let all = view.dims().iter().map(|&n| n as u64).product();
        let mut skipped = Skipped::default();
        let mut may_be_nan =
            nan != Nan::Outside && !T::DTYPE.is_integer() && bricks.is_none_or(Bricks::has_nan);
        let thresholds: Vec<_> = isos.iter().map(|&iso| view.scaling().threshold(iso)).collect();
        let reached = |threshold: &&Threshold<T>| !matches!(threshold, Threshold::Never);
        let asked: Vec<_> = thresholds.iter().filter(reached).copied().collect();
        let (mut inside, mut visits) = (vec![], vec![]);
        match (Thresholds::new(&asked), bricks) {
            (Some(each), None) => {
                let test = |row: &[T], _, out: &mut [u64]| {
                    signs_of_many(row, &each, out, words(row.len()));
                    let count = u64::from(may_be_nan && has_nan(row));
                    Found { count, first: None }
                };
                let found;
                (inside, found) = planes(view, lattice, each.count(), test, job)?;
                may_be_nan = found.count > 0;
                skipped.samples_read = all;
            }
            (Some(each), Some(bricks)) => {
                let sides: Vec<_> = asked.iter().map(|&one| bricks.sides(one)).collect();
                let choice = Choice::new(*bricks.grid(), &sides, lattice);
                let samples_read;
                (inside, samples_read) = chosen(view, lattice, &each, &choice, job)?;
                skipped = Skipped { samples_read, ..choice.skipped };
                visits = choice.visits;
            }
            // Nothing is inside, whatever the samples are: not one is read.
            (None, Some(bricks)) => {
                let bricks = bricks.extents().len() as u64;
                skipped = Skipped { bricks, bricks_skipped: bricks, samples_read: 0 };
            }
            (None, None) => {}
        }
        let mut absent = None;
        if may_be_nan {
            absent = missing(view, lattice, nan, job)?;
            skipped = Skipped { bricks_skipped: 0, samples_read: all, ..skipped };
        }
        let (mut inside, mut visits) = (inside.into_iter(), visits.into_iter());
        let of = |threshold| Self {
            lattice,
            inside: match threshold {
                Threshold::Never => Plane { lattice, bits: vec![] },
                _ => inside.next().expect("a plane for each that is asked"),
            },
            missing: absent.clone(),
            visits: match threshold {
                Threshold::Never => None,
                _ => visits.next(),
            },
        };
        Ok((thresholds.into_iter().map(of).collect(), skipped))
    }
}

/// Which samples are NaN, where some are.
fn missing<T: Sample, E: Send>(
    view: &View<'_, T>,
    lattice: Lattice,
    nan: Nan,
    job: &Job,
) -> Result<Option<Arc<Plane>>, ExtractError<E>> {
    let test = |row: &[T], [j, k]: [usize; 2], out: &mut [u64]| {
        nans(row, out);
        Found::in_row(out, [j, k])
    };
    let (mut found, Found { count, first }) = planes(view, lattice, 1, test, job)?;
    match (first, nan) {
        (Some(first), Nan::Error) => Err(ExtractError::Nan { count, first }),
        (Some(_), Nan::Mask) => Ok(found.pop().map(Arc::new)),
        _ => Ok(None),
    }
}

/// `count` planes at once, by `test`, which is given a row, its place, and room for the words of all
/// planes, one after another.
fn planes<T: Sample, E>(
    view: &View<'_, T>,
    lattice: Lattice,
    count: usize,
    test: impl Fn(&[T], [usize; 2], &mut [u64]) -> Found + Sync,
    job: &Job,
) -> Result<(Vec<Plane>, Found), ExtractError<E>> {
    let ([nx, ny, _], guard) = (view.dims(), lattice.guard);
    let mut bits = zeros(lattice, count, job)?;
    let fill = |(k, mut slices): (usize, Vec<&mut [u64]>)| {
        job.check()?;
        let (mut found, mut scratch) = (Found::default(), vec![]);
        let mut row_of_all = vec![0; count * words(nx)];
        for j in 0..ny {
            let row = view.row(j, k).gather(&mut scratch);
            let own = j * lattice.words..(j + 1) * lattice.words;
            let more = if let [slice] = &mut slices[..] {
                let out = &mut slice[own];
                let more = test(row, [j, k], &mut out[..words(nx)]);
                if guard > 0 {
                    behind_guard(out);
                }
                more
            } else {
                let more = test(row, [j, k], &mut row_of_all);
                for (slice, words) in slices.iter_mut().zip(row_of_all.chunks_exact(words(nx))) {
                    let out = &mut slice[own.clone()];
                    out[..words.len()].copy_from_slice(words);
                    if guard > 0 {
                        behind_guard(out);
                    }
                }
                more
            };
            found.add(more);
        }
        job.progress.advance(1);
        Ok(found)
    };
    let found = slices(&mut bits, lattice).into_par_iter().enumerate().map(fill);
    let found: Vec<Found> = found.collect::<Result<_, Cancelled>>()?;
    let mut nan = Found::default();
    found.into_iter().for_each(|found| nan.add(found));
    Ok((of_bits(lattice, bits), nan))
}

/// Fresh memory for the bits of so many planes.
pub(super) fn zeros(lattice: Lattice, count: usize, job: &Job) -> Result<Vec<Vec<u64>>, OverLimit> {
    let size = lattice.rows().and_then(|rows| rows.checked_mul(lattice.words as u64));
    (0..count).map(|_| job.limits.zeroed("sign plane", size)).collect()
}

pub(super) fn of_bits(lattice: Lattice, bits: Vec<Vec<u64>>) -> Vec<Plane> {
    let plane = |bits| Plane { lattice, bits };
    bits.into_iter().map(plane).collect()
}

/// The rows of samples in the slices of all planes: for each slice of samples, those of every plane.
pub(super) fn slices<'a>(planes: &'a mut [Vec<u64>], lattice: Lattice) -> Vec<Vec<&'a mut [u64]>> {
    let Lattice { points: [_, ny, nz], guard, words } = lattice;
    let slices = |bits: &'a mut Vec<u64>| bits.chunks_exact_mut(words * ny).skip(guard);
    let mut planes: Vec<_> = planes.iter_mut().map(slices).collect();
    let next = |_| {
        let slices = planes.iter_mut().filter_map(Iterator::next);
        slices.map(|slice| &mut slice[guard * words..(ny - guard) * words]).collect()
    };
    (0..nz - 2 * guard).map(next).collect()
}
