//! Takes back, step by step, what would spoil a triangle or put two vertices in one place.

use crate::{exact::in_chunks, places::Things};
use isokit_geom::vector::Vector;
use isokit_job::{Job, Stopped};

/// What states must keep to.
pub(crate) struct Rules<'a, B, P> {
    /// For each triangle, the three things whose states decide its shape: edges, or vertices.
    pub(crate) parts: &'a [[u32; 3]],
    /// Whether a triangle is bad.
    pub(crate) is_bad: B,
    /// How many things have a place. Those without a state come last, and stay.
    pub(crate) count: usize,
    /// Where a thing is, as its position is kept, or as a file will have it; none if it is nowhere.
    pub(crate) place: P,
}

/// Lowers states until no triangle is bad and no two things are in the same place. Of a bad triangle, and of
/// things in one place, those in the greatest state go down by one; what is bad, or together, with all states at 0
/// was so before, and stays.
///
/// All triangles are judged by the same states before any of them changes, and so are all places, so the order does
/// not matter, nor the number of threads. States only fall, so there is an end.
pub(crate) fn settle(
    states: &mut [u8],
    rules: &Rules<
        '_,
        impl Fn(usize, &[u8]) -> bool + Sync,
        impl Fn(usize, &[u8]) -> Option<Vector> + Sync,
    >,
    job: &Job,
) -> Result<(), Stopped> {
    let job = job.unwatched();
    let mut changed: Option<Vec<bool>> = None;
    loop {
        let mut lower = vec![];
        let mut fall = |together: &[usize]| {
            let state = |n: usize| states.get(n).copied().unwrap_or(0);
            let most = together.iter().map(|&n| state(n)).fold(0, u8::max);
            lower.extend(together.iter().filter(|&&n| state(n) == most).map(|&n| (n, most)));
        };
        let judged = |t: &usize| {
            let own = rules.parts[*t].map(|part| part as usize);
            let is_new = changed.as_ref().is_none_or(|c| own.iter().any(|&part| c[part]));
            let can_fall = || own.iter().any(|&part| states[part] > 0);
            is_new && can_fall() && (rules.is_bad)(*t, states)
        };
        let bad =
            in_chunks(rules.parts.len(), &job, |range| range.filter(judged).collect::<Vec<_>>())?;
        bad.iter().flatten().for_each(|&t| fall(&rules.parts[t].map(|part| part as usize)));
        if bad.iter().all(Vec::is_empty) {
            let place = |n: usize| (rules.place)(n, states);
            let moves = |n: usize| states.get(n).is_some_and(|&state| state > 0);
            let things = Things { count: rules.count, place };
            things.sharing(moves, &job)?.iter().for_each(|together| fall(together));
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
    use super::{Rules, settle};
    use isokit_job::{CancelToken, Job};

    fn apart(n: usize, _: &[u8]) -> Option<[f64; 3]> {
        Some([n as f64; 3])
    }

    #[test]
    fn states_fall_until_nothing_is_bad_and_no_further() {
        // A chain: three neighbours may not be at 2 together.
        let parts: Vec<[u32; 3]> = (0..98).map(|n| [n, n + 1, n + 2]).collect();
        let is_bad = |t: usize, states: &[u8]| states[t..t + 3] == [2; 3];
        let mut states = [2_u8; 100];
        states[50] = 0;
        let rules = Rules { parts: &parts, is_bad, count: 100, place: apart };
        settle(&mut states, &rules, &Job::default()).unwrap();
        assert!((0..98).all(|t| !is_bad(t, &states)));
        assert_eq!((states[49], states[50], states[51]), (1, 0, 1));
        // What is bad whatever happens ends at 0.
        let rules =
            Rules { parts: &parts, is_bad: |t: usize, _: &[u8]| t == 7, count: 100, place: apart };
        settle(&mut states, &rules, &Job::default()).unwrap();
        assert_eq!((states[7..10].iter().max(), states[6]), (Some(&0), 1));
    }

    #[test]
    fn states_fall_until_no_two_are_in_one_place() {
        // Each at home at 0; at 1 with its neighbour, at 2 with all. The last, which has no state, is where 6 is at 1.
        let place = |n: usize, states: &[u8]| {
            let homes = [0, 1, 2, 3, 4, 5, 6, 7, 103];
            let x = match states.get(n) {
                None | Some(0) => homes[n],
                Some(1) => 100 + n / 2,
                _ => 1000,
            };
            Some([x as f64; 3])
        };
        let never = |_: usize, _: &[u8]| false;
        let rules = Rules { parts: &[], is_bad: never, count: 9, place };
        let settled = |mut states: [u8; 8]| {
            settle(&mut states, &rules, &Job::default()).unwrap();
            states
        };
        assert_eq!(settled([2, 0, 0, 0, 0, 0, 0, 0]), [2, 0, 0, 0, 0, 0, 0, 0], "alone");
        assert_eq!(settled([2, 0, 2, 0, 1, 0, 0, 0]), [1, 0, 1, 0, 1, 0, 0, 0], "once each");
        assert_eq!(settled([2, 2, 2, 1, 1, 0, 2, 0]), [0, 0, 0, 0, 1, 0, 0, 0], "twice");
        assert_eq!(settled([0, 0, 0, 0, 0, 0, 1, 0]), [0; 8], "what has no state stays");
    }

    #[test]
    fn what_goes_back_because_of_a_place_is_judged_again() {
        // 0 and 1 meet at 1, and a triangle of 0, 2 and 3 is bad as soon as 0 is at home and 2 is not.
        let place = |n: usize, states: &[u8]| {
            let x = if n < 2 && states[n] == 1 { 50 } else { n };
            Some([x as f64; 3])
        };
        let is_bad = |_: usize, states: &[u8]| states[0] == 0 && states[2] == 1;
        let rules = Rules { parts: &[[0, 2, 3]], is_bad, count: 4, place };
        let mut states = [1, 1, 1, 0];
        settle(&mut states, &rules, &Job::default()).unwrap();
        assert_eq!(states, [0; 4]);
    }

    #[test]
    fn a_cancelled_job_settles_nothing() {
        let cancel = CancelToken::default();
        cancel.cancel();
        let job = Job { cancel, ..Job::default() };
        let rules = Rules {
            parts: &[[0, 1, 2]],
            is_bad: |_: usize, _: &[u8]| true,
            count: 3,
            place: apart,
        };
        assert!(settle(&mut [1; 3], &rules, &job).is_err());
    }
}
