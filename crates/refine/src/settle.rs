//! Takes back, step by step, what would spoil a triangle.

use crate::exact::in_chunks;
use isokit_job::{Cancelled, Job};

/// Lowers states until no triangle is bad. `parts` are, for each triangle, the three things whose states
/// decide its shape: edges, or vertices. Of a bad triangle those in the greatest state go down by one; a
/// triangle whose parts are all at 0 was bad before, and stays.
///
/// All triangles are judged by the same states before any of them changes, so the order does not matter, nor
/// the number of threads. States only fall, so there is an end.
pub(crate) fn settle(
    states: &mut [u8],
    parts: &[[u32; 3]],
    is_bad: impl Fn(usize, &[u8]) -> bool + Sync,
    job: &Job,
) -> Result<(), Cancelled> {
    let job = job.unwatched();
    let mut changed: Option<Vec<bool>> = None;
    loop {
        let judged = |t: &usize| {
            let own = parts[*t].map(|part| part as usize);
            let is_new = changed.as_ref().is_none_or(|c| own.iter().any(|&part| c[part]));
            is_new && own.iter().any(|&part| states[part] > 0) && is_bad(*t, states)
        };
        let bad = in_chunks(parts.len(), &job, |range| range.filter(judged).collect::<Vec<_>>())?;
        let mut lower = vec![];
        for t in bad.into_iter().flatten() {
            let own = parts[t].map(|part| part as usize);
            let most = own.iter().map(|&part| states[part]).fold(0, u8::max);
            lower.extend(own.into_iter().filter(|&part| states[part] == most).map(|p| (p, most)));
        }
        if lower.is_empty() {
            return Ok(());
        }
        let flags = changed.get_or_insert_with(|| vec![false; states.len()]);
        flags.fill(false);
        for (part, most) in lower {
            states[part] = most - 1;
            flags[part] = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::settle;
    use isokit_job::{CancelToken, Job};

    #[test]
    fn states_fall_until_nothing_is_bad_and_no_further() {
        // A chain: three neighbours may not be at 2 together.
        let parts: Vec<[u32; 3]> = (0..98).map(|n| [n, n + 1, n + 2]).collect();
        let is_bad = |t: usize, states: &[u8]| states[t..t + 3] == [2; 3];
        let mut states = [2_u8; 100];
        states[50] = 0;
        settle(&mut states, &parts, is_bad, &Job::default()).unwrap();
        assert!((0..98).all(|t| !is_bad(t, &states)));
        assert_eq!((states[49], states[50], states[51]), (1, 0, 1));
        // What is bad whatever happens ends at 0.
        settle(&mut states, &parts, |t, _| t == 7, &Job::default()).unwrap();
        assert_eq!((states[7..10].iter().max(), states[6]), (Some(&0), 1));
    }

    #[test]
    fn a_cancelled_job_settles_nothing() {
        let cancel = CancelToken::default();
        cancel.cancel();
        let job = Job { cancel, ..Job::default() };
        assert!(settle(&mut [1; 3], &[[0, 1, 2]], |_, _| true, &job).is_err());
    }
}
