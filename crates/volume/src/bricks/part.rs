//! Bricks of a part of a volume, from those of all of it: no sample is looked at.
//!
//! Along y and z they are the same bricks. Along x, where a brick is a word of bits, each lies in two of the
//! others, unless the part begins with one: then its ends may be farther off than its own samples are. So may
//! those of bricks at the border of the part.

use super::Bricks;
use crate::{Points, Sample};
use isokit_lanes::Extent;
use std::ops::Range;

impl<T: Sample> Bricks<T> {
    /// What is known of the samples of a part. `None` if there is no such part.
    pub fn part(&self, part: &[Range<usize>; 3]) -> Option<Self> {
        let grid = self.grid.part(part)?;
        let [nx, ny, nz] = grid.counts;
        let points = |axis: usize, brick: usize| {
            let samples = grid.samples(axis, brick);
            part[axis].start + samples.start()..part[axis].start + samples.end() + 1
        };
        let mut extents = Vec::with_capacity(nx * ny * nz);
        for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
            let (y, z) = (points(1, y), points(2, z));
            extents.extend((0..nx).map(|x| self.extent(&[points(0, x), y.clone(), z.clone()])));
        }
        Some(Self { grid, extents })
    }

    /// What is known of the samples of a box: none is beyond these ends, which may be farther off.
    ///
    /// # Panics
    ///
    /// If the box is empty or leads out of the lattice.
    pub fn extent(&self, points: &Points) -> Extent<T> {
        // All samples of a box but the last have an edge to the next that lies in it.
        let bricks = |axis: usize| {
            let Range { start, end } = points[axis];
            let last = end.saturating_sub(2).max(start);
            self.grid.brick_of(axis, start)..self.grid.brick_of(axis, last) + 1
        };
        let (x, y, z) = (bricks(0), bricks(1), bricks(2));
        let rows = z.flat_map(|z| y.clone().map(move |y| (y, z)));
        let row = |(y, z)| {
            let first = self.grid.number([0, y, z]);
            &self.extents[first + x.start..first + x.end]
        };
        rows.flat_map(row).copied().fold(Extent::EMPTY, Extent::with)
    }
}

#[cfg(test)]
mod tests {
    use crate::{BrickGrid, Bricks, Grid, Volume};
    use isokit_job::Job;
    use isokit_lanes::Extent;
    use std::ops::Range;

    fn chance(dims: [u64; 3], seed: u64) -> Volume<f32> {
        let mut state = seed;
        let grid = Grid::new(dims, Default::default()).unwrap();
        let next = |_| {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
            if state >> 50 == 0 { f32::NAN } else { (state >> 40) as f32 }
        };
        Volume::new(grid, (0..grid.count()).map(next).collect()).unwrap()
    }

    fn holds(outer: &Extent<f32>, inner: &Extent<f32>) -> bool {
        outer.least <= inner.least
            && outer.greatest >= inner.greatest
            && outer.has_nan >= inner.has_nan
    }

    /// What is said of a part holds of the samples of its bricks, and is exact where the part's bricks are
    /// those of the volume.
    #[track_caller]
    fn check(volume: &Volume<f32>, part: [Range<usize>; 3]) -> Bricks<f32> {
        let job = Job::default();
        let told = Bricks::of(&volume.view(), &job).unwrap().part(&part).unwrap();
        let own = volume.view().part(part.clone()).unwrap();
        let grid = told.grid();
        let [nx, ny, nz] = grid.counts();
        for brick in (0..nx * ny * nz).map(|n| [n % nx, n / nx % ny, n / nx / ny]) {
            let samples = [0, 1, 2].map(|axis| {
                let range = grid.samples(axis, brick[axis]);
                *range.start()..range.end() + 1
            });
            let view = own.part(samples).unwrap();
            let found = Bricks::of(&view, &job).unwrap();
            let found = found.extents().iter().copied().fold(Extent::EMPTY, Extent::with);
            let told = &told.extents()[grid.number(brick)];
            assert!(holds(told, &found), "{brick:?} of {part:?}: {told:?}, {found:?}");
        }
        told
    }

    #[test]
    fn what_is_said_of_a_part_holds_of_its_samples() {
        let mut state = 5_usize;
        let mut below = |n: usize| {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
            (state >> 33) % n
        };
        let mut range = |n: usize| {
            let [a, b] = [below(n), below(n)];
            a.min(b)..a.max(b) + 1
        };
        for seed in 0..200 {
            let dims = [150, 30, 30].map(|most| range(most).len());
            let volume = chance(dims.map(|n| n as u64), seed);
            let part = dims.map(&mut range);
            let told = check(&volume, part.clone());
            let slices = range(part[2].len());
            if slices.len() == 1 {
                continue; // the last has no brick that begins with it
            }
            // A part of a part is the part that it is, where x begins alike.
            let whole = Bricks::of(&volume.view(), &Job::default()).unwrap();
            let [x, y, z] = part;
            let within = [0..x.len(), 0..y.len(), slices.clone()];
            let direct = whole.part(&[x, y, z.start + slices.start..z.start + slices.end]);
            assert_eq!(told.part(&within), direct);
        }
    }

    #[test]
    fn bricks_that_lie_in_a_part_whole_are_told_exactly() {
        let volume = chance([200, 40, 50], 3);
        let whole = Bricks::of(&volume.view(), &Job::default()).unwrap();
        assert_eq!(whole.part(&[0..200, 0..40, 0..50]).unwrap(), whole);
        let part = check(&volume, [64..193, 5..37, 7..50]);
        assert_eq!(part.grid().counts(), [2, 5, 7]);
        for [x, y, z] in [[0, 1, 1], [1, 3, 4], [0, 2, 5]] {
            let own = part.extents()[part.grid().number([x, y, z])];
            assert_eq!(own, whole.extents()[whole.grid().number([x + 1, y, z])]);
        }
    }

    #[test]
    fn the_bricks_of_a_part_lie_as_those_of_the_volume_do() {
        let grid = BrickGrid::new([100, 40, 40]);
        let part = grid.part(&[10..90, 3..21, 8..9]).unwrap();
        assert_eq!((part.dims(), part.counts()), ([80, 18, 1], [2, 3, 1]));
        let samples = |axis: usize, n: usize| part.samples(axis, n);
        assert_eq!([samples(1, 0), samples(1, 1), samples(1, 2)], [0..=5, 5..=13, 13..=17]);
        assert_eq!([0, 4, 5, 12, 13, 17].map(|j| part.brick_of(1, j)), [0, 0, 1, 1, 2, 2]);
        assert_eq!((samples(0, 1), samples(2, 0)), (64..=79, 0..=0));
        for wrong in [[0..0, 0..1, 0..1], [0..1, 0..41, 0..1], [0..1, 0..1, 40..41]] {
            assert!(grid.part(&wrong).is_none(), "{wrong:?}");
        }
    }
}
