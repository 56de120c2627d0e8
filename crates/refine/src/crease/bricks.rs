//! Questions to a field, those near each other asked together.
//!
//! A field may know a simpler one that is the same within a box, as a shape of many parts does. Places are sorted by
//! bricks of the lattice, and each brick has its own field. Answers are those of the whole field, to the bit.

use crate::ground::Ground;
use isokit_geom::{Aabb, vector::Vector};
use isokit_job::{Cancelled, Job};
use isokit_lanes::exactly;
use rayon::prelude::*;

/// Samples along the side of a brick.
const SIDE: f64 = 12.0;

/// Samples around a brick that may be asked about too.
const AROUND: f64 = 3.0;

/// What `ask` says of each of so many places, whose number it is given with the field near it. It may ask about what is less
/// than three samples away.
pub(super) fn in_bricks<T: Send>(
    places: &(impl Fn(usize) -> Vector + Sync),
    count: usize,
    ground: &Ground<'_>,
    ask: impl Fn(usize, &Ground<'_>) -> T + Sync,
    job: &Job,
) -> Result<Vec<T>, Cancelled> {
    let brick = |n: u32| ground.spot(places(n as usize)).ijk.map(|c| (c / SIDE).floor() as i64);
    let answers = job.threads.run(|| {
        let mut order: Vec<([i64; 3], u32)> =
            (0..count as u32).into_par_iter().map(|n| (brick(n), n)).collect();
        order.par_sort_unstable();
        let bricks: Vec<_> = order.chunk_by(|a, b| a.0 == b.0).collect();
        let answered = |within: &&[([i64; 3], u32)]| {
            job.check()?;
            let low = within[0].0.map(|c| c as f64 * SIDE);
            let min = low.map(|c| c - AROUND);
            let max = low.map(|c| c + SIDE + AROUND);
            let part = ground.field().within(Aabb { min, max });
            let near = part.as_deref().map_or(*ground, |part| ground.through(part));
            let answers = within.iter().map(|&(_, n)| (n, ask(n as usize, &near)));
            job.progress.advance(within.len() as u64);
            Ok(exactly(|| answers.collect::<Vec<_>>()))
        };
        bricks.par_iter().map(answered).collect::<Result<Vec<_>, Cancelled>>()
    })?;
    let mut all: Vec<Option<T>> = (0..count).map(|_| None).collect();
    answers.into_iter().flatten().for_each(|(n, answer)| all[n as usize] = Some(answer));
    Ok(all.into_iter().flatten().collect())
}
