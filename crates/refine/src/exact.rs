//! Chunks of work, in each of which arithmetic is as Rust means it (`isokit_lanes::exactly`), whatever thread it
//! runs in.

use isokit_job::{Cancelled, Job};
use isokit_lanes::exactly;
use std::ops::Range;

/// As [`isokit_job::in_chunks`].
pub(crate) fn in_chunks<T: Send>(
    items: usize,
    job: &Job,
    work: impl Fn(Range<usize>) -> T + Sync,
) -> Result<Vec<T>, Cancelled> {
    isokit_job::in_chunks(items, job, |range| exactly(|| work(range)))
}
