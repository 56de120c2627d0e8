//! Long loops cut into chunks that do not depend on the number of threads.
//!
//! What is added up per chunk, and then chunk after chunk in order, is the same sum for any number of
//! threads. Between chunks a task looks whether it should stop, and tells how far it is.

use isokit_job::{Cancelled, Job};
use rayon::prelude::*;
use std::ops::Range;

/// Items per chunk: a fraction of a millisecond of work, thousands of chunks in a large mesh.
pub(crate) const CHUNK: usize = 1 << 14;

/// Runs `work` on each chunk of `0..items`, in parallel; the results come in the order of the chunks.
/// Progress advances by one per item.
pub(crate) fn in_chunks<T: Send>(
    items: usize,
    job: &Job,
    work: impl Fn(Range<usize>) -> T + Sync,
) -> Result<Vec<T>, Cancelled> {
    let chunk = |n: usize| {
        job.check()?;
        let range = n * CHUNK..items.min((n + 1) * CHUNK);
        let length = range.len() as u64;
        let done = work(range);
        job.progress.advance(length);
        Ok(done)
    };
    job.threads.run(|| (0..items.div_ceil(CHUNK)).into_par_iter().map(chunk).collect())
}

/// A sum that carries along what each addition rounds off (Neumaier): as if made in twice the precision.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sum {
    value: f64,
    lost: f64,
}

impl Sum {
    /// Adds one number.
    #[inline]
    pub(crate) fn add(&mut self, x: f64) {
        let sum = self.value + x;
        let (large, small) =
            if self.value.abs() >= x.abs() { (self.value, x) } else { (x, self.value) };
        self.lost += (large - sum) + small;
        self.value = sum;
    }

    /// Adds another sum.
    pub(crate) fn join(&mut self, other: Self) {
        self.add(other.value);
        self.lost += other.lost;
    }

    /// The sum, rounded once.
    pub(crate) fn total(self) -> f64 {
        self.value + self.lost
    }
}

/// Something that is counted for each label, where neighbours mostly have the same label.
#[derive(Clone, Debug)]
pub(crate) struct Tallies<T>(Vec<(u32, T)>);

impl<T: Default> Tallies<T> {
    /// Nothing counted.
    pub(crate) fn new() -> Self {
        Self(vec![])
    }

    /// The tally of `label`, to add to.
    #[inline]
    pub(crate) fn of(&mut self, label: u32) -> &mut T {
        if self.0.last().is_none_or(|last| last.0 != label) {
            self.0.push((label, T::default()));
        }
        let last = self.0.len() - 1;
        &mut self.0[last].1
    }

    /// Hands the tallies out, in the order in which they were made: a label may come several times.
    pub(crate) fn each(self) -> impl Iterator<Item = (usize, T)> {
        self.0.into_iter().map(|(label, tally)| (label as usize, tally))
    }
}

#[cfg(test)]
mod tests {
    use super::{CHUNK, Sum, in_chunks};
    use isokit_job::{Cancelled, Job};

    #[test]
    fn chunks_cover_all_items_in_order() {
        for items in [0, 1, CHUNK, 3 * CHUNK + 5] {
            let ranges = in_chunks(items, &Job::default(), |range| range).unwrap();
            assert!(ranges.into_iter().flatten().eq(0..items));
        }
    }

    #[test]
    fn a_cancelled_job_does_nothing() {
        let job = Job::default();
        job.cancel.cancel();
        let touched = in_chunks(5, &job, |_| unreachable!("cancelled before"));
        assert_eq!(touched, Err::<Vec<()>, _>(Cancelled));
    }

    #[test]
    fn a_sum_forgets_nothing_that_cancels() {
        let mut sum = Sum::default();
        for x in [1.0, 1e100, 1.0, -1e100] {
            sum.add(x);
        }
        assert_eq!(sum.total(), 2.0);
    }
}
