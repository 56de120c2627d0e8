//! Long loops cut into chunks that do not depend on the number of threads.
//!
//! What is added up per chunk, and then chunk after chunk in order, is the same sum for any number of
//! threads. Between chunks a task looks whether it should stop, and tells how far it is.

use crate::{Cancelled, Job, Work};
use rayon::prelude::*;
use std::ops::Range;

/// Items per chunk: a fraction of a millisecond of work, thousands of chunks in a large mesh.
pub const CHUNK: usize = 1 << 14;

/// Runs `work` on each chunk of `0..items`, in parallel; the results come in the order of the chunks.
/// Progress advances by one per item.
///
/// # Errors
///
/// [`Cancelled`] once the job is; what was done so far is lost.
pub fn in_chunks<T: Send>(
    items: usize,
    job: &Job,
    work: impl Fn(Range<usize>) -> T + Sync,
) -> Result<Vec<T>, Cancelled> {
    let chunk: Work<'_, _, _> = &|n: usize| {
        job.check()?;
        let range = n * CHUNK..items.min((n + 1) * CHUNK);
        let length = range.len() as u64;
        let done = work(range);
        job.progress.advance(length);
        Ok(done)
    };
    job.threads.run(|| (0..items.div_ceil(CHUNK)).into_par_iter().map(chunk).collect())
}

#[cfg(test)]
mod tests {
    use super::{CHUNK, in_chunks};
    use crate::{Cancelled, Job};

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
}
