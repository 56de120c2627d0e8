//! How often each sample occurs, of the types that have few: those of one and two bytes.

use crate::{Sample, View};
use isokit_job::{Cancelled, Job, Work};
use rayon::prelude::*;
use std::ops::Range;

/// How often each sample of a type occurs, by place in order.
pub(crate) struct Ranks {
    counts: Vec<u64>,
}

impl Ranks {
    /// Whether a type has so few samples.
    pub(crate) const fn suit<T: Sample>() -> bool {
        size_of::<T>() <= 2
    }

    /// Looks at every sample once, of a type that suits. `passed` hears of each slice.
    pub(crate) fn of<T: Sample>(
        view: &View<'_, T>,
        job: &Job,
        passed: impl Fn() + Sync,
    ) -> Result<Self, Cancelled> {
        let rows = view.dims()[1];
        let of_slices = |slices: Range<usize>| {
            let (mut tables, mut scratch) = (Tables::of::<T>(), vec![]);
            for k in slices {
                job.check()?;
                (0..rows).for_each(|j| tables.count(view.row(j, k).gather(&mut scratch)));
                passed();
            }
            Ok(tables.sums())
        };
        let mut counts = vec![0; T::LAST_RANK as usize + 1];
        for part in of_parts(view.dims()[2], job, of_slices)? {
            counts.iter_mut().zip(part).for_each(|(all, more)| *all += more);
        }
        Ok(Self { counts })
    }

    /// Those that occur, in order.
    pub(crate) fn occurring<T: Sample>(&self) -> impl DoubleEndedIterator<Item = (T, u64)> {
        let all = self.counts.iter().enumerate().filter(|(_, count)| **count > 0);
        all.map(|(rank, &count)| (T::at_rank(rank as u64), count))
    }
}

/// What is found of so many slices in as few parts as there are threads: for what needs much memory for each.
pub(crate) fn of_parts<R: Send>(
    slices: usize,
    job: &Job,
    of_slices: impl Fn(Range<usize>) -> Result<R, Cancelled> + Sync,
) -> Result<Vec<R>, Cancelled> {
    let per_part = slices.div_ceil(job.threads.count());
    let part: Work<'_, _, _> = &|first: usize| of_slices(first..slices.min(first + per_part));
    job.threads.run(|| (0..slices).into_par_iter().step_by(per_part).map(part).collect())
}

/// One table after another, each by place in order. In turns, so that neighbours, which are often equal, do not wait for
/// each other.
struct Tables(Vec<u64>);

const TURNS: usize = 4;

/// Samples that are counted at once if they are equal, as they are in air.
const STRIP: usize = 32;

impl Tables {
    fn of<T: Sample>() -> Self {
        Self(vec![0; TURNS * (T::LAST_RANK as usize + 1)])
    }

    fn count<T: Sample>(&mut self, row: &[T]) {
        match size_of::<T>() {
            1 => count::<T, { 1 << 8 }>(&mut self.0, row),
            _ => count::<T, { 1 << 16 }>(&mut self.0, row),
        }
    }

    fn sums(mut self) -> Vec<u64> {
        let values = self.0.len() / TURNS;
        let (all, others) = self.0.split_at_mut(values);
        for table in others.chunks(values) {
            all.iter_mut().zip(table).for_each(|(all, more)| *all += more);
        }
        self.0.truncate(values);
        self.0
    }
}

/// Into tables of `N` values each, which are all there are.
fn count<T: Sample, const N: usize>(tables: &mut [u64], row: &[T]) {
    let (tables, _) = tables.as_chunks_mut::<N>();
    let tables = tables.first_chunk_mut::<TURNS>().expect("tables for all turns");
    let place = |sample: T| sample.rank() as usize % N; // all are less: so the loops need no bounds checks
    let (strips, rest) = row.as_chunks::<STRIP>();
    for strip in strips {
        let first = place(strip[0]);
        if strip.iter().fold(0, |differ, &sample| differ | (place(sample) ^ first)) == 0 {
            tables[0][first] += STRIP as u64;
            continue;
        }
        for turn in strip.as_chunks::<TURNS>().0 {
            for n in 0..TURNS {
                tables[n][place(turn[n])] += 1;
            }
        }
    }
    rest.iter().for_each(|&sample| tables[0][place(sample)] += 1);
}
