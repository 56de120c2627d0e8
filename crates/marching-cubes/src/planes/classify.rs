//! From samples to planes, for any number of isovalues with one look at the samples.

use super::{Counted, Lattice, PIECE, PIECE_WORDS, Plane, Planes, Signs, behind_guard};
use crate::{ExtractError, Nan, Skipped, Source, found::Found, sparse::Choice};
use isokit_job::{Cancelled, Job, OverLimit, Stopped};
use isokit_lanes::{
    BitRows, RowCounts, Threshold, Thresholds, count_rows, exactly, has_nan, nans, signs_of_many,
    words,
};
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
        let (mut inside, mut visits, mut counted) = (vec![], vec![], None);
        match (Thresholds::new(&asked), bricks) {
            (Some(each), None) => {
                let test = |row: &[T], _, out: &mut [u64]| {
                    signs_of_many(row, &each, out, words(row.len()));
                    let count = u64::from(may_be_nan && has_nan(row));
                    Found { count, first: None }
                };
                // Of several the counts would take as much memory as the planes.
                if each.count() == 1 && lattice.has_cells() {
                    counted = Some(Counted::none(lattice, job)?);
                }
                let found;
                (inside, found) = planes(view, lattice, each.count(), test, counted.as_mut(), job)?;
                may_be_nan = found.count > 0;
                skipped.samples_read = all;
            }
            (Some(thresholds), Some(bricks)) => {
                let choice = Choice::new(bricks, &asked, lattice);
                let signs = Signs { view: *view, lattice, thresholds, stops_at_nan: false };
                inside = signs.chosen_planes(&choice, job)?;
                (skipped, visits) = (choice.skipped, choice.visits);
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
                Threshold::Never => Plane::blank(lattice),
                _ => inside.next().expect("a plane for each that is asked"),
            },
            missing: absent.clone(),
            counted: match threshold {
                Threshold::Never => None,
                _ => counted.take().filter(|_| absent.is_none()),
            },
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
    let (mut found, Found { count, first }) = planes(view, lattice, 1, test, None, job)?;
    match (first, nan) {
        (Some(first), Nan::Error) => Err(ExtractError::Nan { count, first }),
        (Some(_), Nan::Mask) => Ok(found.pop().map(Arc::new)),
        _ => Ok(None),
    }
}

/// `count` planes at once, by `test`, which is given a row, its place, and room for the words of all
/// planes, one after another; of a single plane it may be part of a slice as if that were one row.
fn planes<T: Sample, E>(
    view: &View<'_, T>,
    lattice: Lattice,
    count: usize,
    test: impl Fn(&[T], [usize; 2], &mut [u64]) -> Found + Sync,
    counted: Option<&mut Counted>,
    job: &Job,
) -> Result<(Vec<Plane>, Found), ExtractError<E>> {
    let [nx, ny, _] = view.dims();
    let fill = |k: usize, slices: &mut [&mut [u64]]| {
        let (mut found, mut scratch) = (Found::default(), vec![]);
        if let [slice] = slices
            && let Some(pieces) = lattice.as_one_row(view, k)
        {
            for (n, (piece, out)) in pieces.zip(slice.chunks_mut(PIECE_WORDS)).enumerate() {
                found.add(test(piece, [0, k], out).placed_from(n * PIECE, nx));
            }
            return found;
        }
        let mut row_of_all = vec![0; count * words(nx)];
        for j in 0..ny {
            let row = view.row(j, k).gather(&mut scratch);
            let own = lattice.row_of_samples(j);
            if let [slice] = &mut slices[..] {
                let out = &mut slice[own];
                found.add(test(row, [j, k], &mut out[..words(nx)]));
                if lattice.guard > 0 {
                    behind_guard(out);
                }
                continue;
            }
            found.add(test(row, [j, k], &mut row_of_all));
            for (slice, words) in slices.iter_mut().zip(row_of_all.chunks_exact(words(nx))) {
                let out = &mut slice[own.clone()];
                out[..words.len()].copy_from_slice(words);
                if lattice.guard > 0 {
                    behind_guard(out);
                }
            }
        }
        found
    };
    let (planes, found) = slice_by_slice(lattice, count, &|_| false, &fill, counted, job)?;
    let mut nan = Found::default();
    found.into_iter().for_each(|found| nan.add(found));
    Ok((planes, nan))
}

/// For groups of slices that lie together the words of each plane.
type Groups = Vec<Vec<Vec<u64>>>;

/// Words of some slices that lie together: small slices are many.
const TOGETHER: usize = 2048;

/// Tasks per thread. More wait less for each other; fewer leave fewer slices to be counted later.
const TASKS: usize = 16;

/// Makes `count` planes. For each slice of samples that is not blank `fill` gets its number and zeros for
/// each plane. What it finds comes in the order of the slices. Rows of a single plane without blanks are
/// counted, if that is wanted, as soon as the next slice is there, except where that is another task's. It is
/// compiled once for all types of samples, as [`isokit_job::Work`] has it.
pub(super) fn slice_by_slice<F: Send>(
    lattice: Lattice,
    count: usize,
    is_blank: &(dyn Fn(usize) -> bool + Sync),
    fill: &(dyn Fn(usize, &mut [&mut [u64]]) -> F + Sync),
    counted: Option<&mut Counted>,
    job: &Job,
) -> Result<(Vec<Plane>, Vec<F>), Stopped> {
    let words = lattice.rows().and_then(|rows| rows.checked_mul(lattice.words as u64));
    let words = words.and_then(|words| words.checked_mul(count as u64));
    job.limits.probe("sign planes", words, size_of::<u64>())?;
    let (words, slices) = (lattice.slice_words(), lattice.points[2] - 2 * lattice.guard);
    let together = (TOGETHER / words).max(1);
    let run = together * (slices / (together * TASKS * job.threads.count())).max(1);
    let mut rows = counted.map_or(vec![], |counted| counted.of_runs(lattice, run));
    rows.resize_with(slices.div_ceil(run), Default::default);
    let runs = rows.into_par_iter().enumerate().map(|(task, rows)| {
        let all = task * run..slices.min((task + 1) * run);
        let (mut groups, mut found): (Groups, _) = (vec![], vec![]);
        for first in all.clone().step_by(together) {
            job.check()?;
            let own = first..all.end.min(first + together);
            job.progress.advance(own.len() as u64);
            if own.clone().all(is_blank) {
                groups.push(vec![vec![]; count]);
                continue;
            }
            let mut planes = vec![vec![0; words * own.len()]; count];
            let fill_one = |k: usize| {
                let at = (k - first) * words;
                let slices = planes.iter_mut().map(|plane| &mut plane[at..at + words]);
                fill(k, &mut slices.collect::<Vec<_>>())
            };
            exactly(|| found.extend(own.clone().filter(|&k| !is_blank(k)).map(fill_one)));
            groups.push(planes);
            if !rows.is_empty() {
                let slice = |n: usize| &groups[n / together][0][n % together * words..][..words];
                for n in own.map(|k| k - all.start).filter(|&n| n > 0) {
                    let bits = BitRows::new(slice(n - 1), Some(slice(n)), lattice.points[0]);
                    let ny = lattice.points[1];
                    count_rows(&bits, 0..ny, &mut rows[(n - 1) * ny..n * ny]);
                }
            }
        }
        Ok((groups, found))
    });
    let runs: Vec<(Groups, Vec<F>)> = runs.collect::<Result<_, Cancelled>>()?;
    let mut planes = vec![];
    planes.resize_with(count, || Plane { together, ..Plane::blank(lattice) });
    let mut all = vec![];
    for (groups, found) in runs {
        for group in groups {
            planes.iter_mut().zip(group).for_each(|(plane, words)| plane.groups.push(words));
        }
        all.extend(found);
    }
    Ok((planes, all))
}

impl Counted {
    /// No slice is.
    pub(crate) fn none(lattice: Lattice, job: &Job) -> Result<Self, OverLimit> {
        let rows = job.limits.zeroed("rows", lattice.rows())?;
        Ok(Self { rows, done: vec![false; lattice.points[2]] })
    }

    /// The rows of so many slices of samples together: all but the last of them will be counted.
    fn of_runs(&mut self, lattice: Lattice, run: usize) -> Vec<&mut [RowCounts]> {
        let Lattice { points: [_, ny, nz], guard, .. } = lattice;
        let (first, last) = (guard, nz - 1 - guard);
        let in_one_run = |z: usize| (z - first) / run == (z + 1 - first) / run;
        (first..last).for_each(|z| self.done[z] = in_one_run(z));
        self.rows[first * ny..].chunks_mut(run * ny).collect()
    }
}
