//! Questions to a field, those near each other asked together.
//!
//! A field may know a simpler one that is the same within a box, as a shape of many parts does. Places are sorted by
//! bricks of the lattice, and these by small ones within them; each brick has its own field, made from that around it.
//! Answers are those of the whole field, to the bit.

use crate::ground::Ground;
use isokit_field::{Jet, ScalarField, Slope};
use isokit_geom::{Aabb, Affine, vector::Vector};
use isokit_job::{Cancelled, Job};
use isokit_lanes::exactly;
use rayon::prelude::*;

/// Samples along the side of a small brick.
const SIDE: i64 = 4;

/// Small bricks along the side of a brick.
const BRICKS: i64 = 4;

/// Samples around a brick that its field is for too.
const AROUND: i64 = 1;

/// What `ask` says of each of so many places, whose number it is given with the field near it.
pub(super) fn in_bricks<T: Send>(
    places: &(impl Fn(usize) -> Vector + Sync),
    count: usize,
    ground: &Ground<'_>,
    ask: impl Fn(usize, &Ground<'_>) -> T + Sync,
    job: &Job,
) -> Result<Vec<T>, Cancelled> {
    let small =
        |n: u32| ground.spot(places(n as usize)).ijk.map(|c| (c.floor() as i64).div_euclid(SIDE));
    let large = |small: [i64; 3]| small.map(|c| c.div_euclid(BRICKS));
    let answers = job.threads.run(|| {
        let mut order: Vec<([i64; 3], u32)> =
            (0..count as u32).into_par_iter().map(|n| (small(n), n)).collect();
        order.par_sort_unstable_by_key(|&(small, n)| (large(small), small, n));
        let bricks: Vec<_> = order.chunk_by(|a, b| large(a.0) == large(b.0)).collect();
        let answered = |brick: &&[([i64; 3], u32)]| {
            job.check()?;
            let mut answers = Vec::with_capacity(brick.len());
            exactly(|| {
                let near = Near::new(large(brick[0].0), SIDE * BRICKS, ground.field());
                for brick in brick.chunk_by(|a, b| a.0 == b.0) {
                    let near = Near::new(brick[0].0, SIDE, &near);
                    let ground = ground.through(&near);
                    answers.extend(brick.iter().map(|&(_, n)| (n, ask(n as usize, &ground))));
                }
            });
            job.progress.advance(brick.len() as u64);
            Ok(answers)
        };
        bricks.par_iter().map(answered).collect::<Result<Vec<_>, Cancelled>>()
    })?;
    let mut all: Vec<Option<T>> = (0..count).map(|_| None).collect();
    answers.into_iter().flatten().for_each(|(n, answer)| all[n as usize] = Some(answer));
    Ok(all.into_iter().flatten().collect())
}

/// A field that is asked through a simpler one where that is the same.
struct Near<'a> {
    inside: Aabb,
    /// The simpler one, within the box.
    part: Option<Box<dyn ScalarField + 'a>>,
    whole: &'a dyn ScalarField,
}

impl<'a> Near<'a> {
    /// For a brick, counted in bricks of so many samples, and a little around it.
    fn new(brick: [i64; 3], side: i64, whole: &'a dyn ScalarField) -> Self {
        let low = brick.map(|c| c.saturating_mul(side));
        let inside = Aabb {
            min: low.map(|c| c.saturating_sub(AROUND) as f64),
            max: low.map(|c| c.saturating_add(side + AROUND) as f64),
        };
        Self { inside, part: whole.within(inside), whole }
    }

    fn at(&self, ijk: [f64; 3]) -> &dyn ScalarField {
        self.of(Aabb { min: ijk, max: ijk })
    }

    /// The one for a box.
    fn of(&self, ijk: Aabb) -> &dyn ScalarField {
        let is_inside =
            (0..3).all(|k| self.inside.min[k] <= ijk.min[k] && ijk.max[k] <= self.inside.max[k]);
        self.part.as_deref().filter(|_| is_inside).unwrap_or(self.whole)
    }
}

impl ScalarField for Near<'_> {
    fn dims(&self) -> [usize; 3] {
        self.whole.dims()
    }

    fn index_to_world(&self) -> Affine {
        self.whole.index_to_world()
    }

    fn value(&self, ijk: [f64; 3]) -> f64 {
        self.at(ijk).value(ijk)
    }

    fn slope(&self, ijk: [f64; 3]) -> Slope {
        self.at(ijk).slope(ijk)
    }

    fn jet(&self, ijk: [f64; 3]) -> Jet {
        self.at(ijk).jet(ijk)
    }

    fn within(&self, ijk: Aabb) -> Option<Box<dyn ScalarField + '_>> {
        self.of(ijk).within(ijk)
    }
}
