//! From samples to extents, with one look at each.
//!
//! Every slice is cut into columns of 8 cells first, in parallel. A brick is then nine slices of one
//! column; those that it shares with its neighbour are not looked at again. Of slices that pass by a few are in
//! memory at a time.

use super::{BrickGrid, Bricks};
use crate::{Sample, SlabSource, View, passes::each_piece};
use isokit_job::{Cancelled, Job, Stopped, Work};
use isokit_lanes::{Columns, Extent, add_row, exactly, words};
use rayon::prelude::*;

impl<T: Sample> Bricks<T> {
    /// Looks at every sample.
    ///
    /// # Errors
    ///
    /// If the job is cancelled or allows less memory.
    pub fn of(view: &View<'_, T>, job: &Job) -> Result<Self, Stopped> {
        let grid = BrickGrid::new(view.dims());
        let [_, _, nz] = view.dims();
        let per_slice = grid.counts[0] as u64 * grid.counts[1] as u64;
        let all = per_slice.checked_mul(nz as u64);
        job.limits.allow("bricks", all, size_of::<Extent<T>>())?;
        job.progress.begin("index", nz as u64);
        let slices = each_slice(nz, job, &|k| {
            job.progress.advance(1);
            exactly(|| of_slice(view, &grid, k))
        })?;
        let mut extents = Vec::with_capacity(grid.counts.iter().product());
        exactly(|| {
            for brick in 0..grid.counts[2] {
                for column in 0..per_slice as usize {
                    let of = slices[grid.samples(2, brick)].iter().map(|slice| slice[column]);
                    extents.push(of.fold(Extent::EMPTY, Extent::with));
                }
            }
        });
        Ok(Self { grid, extents })
    }
}

impl<T: Sample> Bricks<T> {
    /// Looks at every sample of a source once: the same as of a volume in memory.
    ///
    /// # Errors
    ///
    /// If the source fails, or the job is cancelled or allows less memory.
    pub fn of_slices<S: SlabSource<T>>(mut source: S, job: &Job) -> Result<Self, S::Error> {
        // What is not in memory may be more than its address space numbers.
        let dims = source.grid().dims().map(|n| usize::try_from(n).unwrap_or(usize::MAX));
        let grid = BrickGrid::new(dims);
        job.limits.allow("bricks", grid.count(), size_of::<Extent<T>>())?;
        let per_layer = grid.counts[0] * grid.counts[1];
        let mut extents = vec![Extent::EMPTY; per_layer * grid.counts[2]];
        let mut before = 0;
        each_piece(&mut source, "index", job, |view| {
            let own = |k| exactly(|| of_slice(&view, &grid, k));
            let slices = each_slice(view.dims()[2], job, &own)?;
            for (slice, k) in slices.iter().zip(before..) {
                for layer in grid.brick_of(2, k.max(1) - 1)..=grid.brick_of(2, k) {
                    let own = &mut extents[per_layer * layer..per_layer * (layer + 1)];
                    exactly(|| {
                        own.iter_mut().zip(slice).for_each(|(own, &more)| *own = own.with(more))
                    });
                }
            }
            before += slices.len();
            Ok(())
        })?;
        Ok(Self { grid, extents })
    }
}

/// What comes of each slice, by its number.
fn each_slice<R: Send>(
    slices: usize,
    job: &Job,
    work: Work<'_, usize, R>,
) -> Result<Vec<R>, Cancelled> {
    let one = |k| job.check().map(|()| work(k));
    job.threads.run(|| (0..slices).into_par_iter().map(one).collect())
}

/// The part of each brick that lies in a slice.
fn of_slice<T: Sample>(view: &View<'_, T>, grid: &BrickGrid, k: usize) -> Vec<Extent<T>> {
    let mut extents = Vec::with_capacity(grid.counts[0] * grid.counts[1]);
    let (mut scratch, mut columns) = (vec![], vec![Columns::EMPTY; words(view.dims()[0])]);
    for brick in 0..grid.counts[1] {
        columns.fill(Columns::EMPTY);
        for j in grid.samples(1, brick) {
            add_row(view.row(j, k).gather(&mut scratch), &mut columns);
        }
        extents.extend((0..grid.counts[0]).map(|brick| {
            // The last sample of a brick is the first of the next word.
            let last = columns.get(brick + 1).map_or(Extent::EMPTY, Columns::first);
            columns[brick].extent().with(last)
        }));
    }
    extents
}

#[cfg(test)]
mod tests {
    use super::Bricks;
    use crate::{Grid, Sample, Slices, View, Volume};
    use isokit_job::{Job, Limits, Stopped};
    use isokit_lanes::Extent;

    fn chance<T: Sample>(dims: [u64; 3], sample: fn(u64) -> T) -> Volume<T> {
        let mut state = dims[0] + 100 * dims[1];
        let grid = Grid::new(dims, Default::default()).unwrap();
        let next = |_| {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
            sample(state >> 33)
        };
        Volume::new(grid, (0..grid.count()).map(next).collect()).unwrap()
    }

    /// The definition: every sample of every brick.
    #[track_caller]
    fn check<T: Sample>(view: &View<'_, T>) {
        let bricks = Bricks::of(view, &Job::default()).unwrap();
        let (grid, mut extents) = (*bricks.grid(), bricks.extents().iter());
        let [nx, ny, nz] = grid.counts();
        for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
            for x in 0..nx {
                let mut expected = Extent::EMPTY;
                for (k, j) in
                    grid.samples(2, z).flat_map(|k| grid.samples(1, y).map(move |j| (k, j)))
                {
                    for sample in grid.samples(0, x).map(|i| view.stored([i, j, k])) {
                        let is_nan = sample.partial_cmp(&sample).is_none();
                        expected = expected.with(match is_nan {
                            true => Extent { has_nan: true, ..Extent::EMPTY },
                            false => Extent { least: sample, greatest: sample, has_nan: false },
                        });
                    }
                }
                assert_eq!(extents.next(), Some(&expected), "brick {x}, {y}, {z} of {grid:?}");
            }
        }
        assert_eq!(extents.next(), None);
        let of_slices = Bricks::of_slices(Slices::new(*view), &Job::default()).unwrap();
        assert!(of_slices.extents().iter().eq(bricks.extents()) && of_slices.grid() == &grid);
    }

    #[test]
    fn every_brick_has_the_least_and_the_greatest_of_its_samples() {
        let sizes = [[1, 1, 1], [1, 9, 2], [64, 8, 8], [65, 9, 9], [66, 10, 10], [129, 1, 18]];
        for dims in sizes {
            check(&chance(dims, |r| r as u8).view());
            check(&chance(dims, |r| r as i16).view());
            check(&chance(dims, |r| r as i32).view());
            check(&chance(dims, |r| (r % 1000) as f64 - 500.0).view());
            check(&chance(dims, |r| [f32::NAN, 1.0, f32::INFINITY][r as usize % 3]).view());
            check(&chance(dims, |_| f32::NAN).view());
        }
    }

    #[test]
    fn rows_may_lie_in_memory_in_any_way() {
        let volume = chance([70, 20, 12], |r| r as u16);
        let turned = Grid::new([12, 20, 70], Default::default()).unwrap();
        check(&View::strided(volume.samples(), 0, [1400, 70, 1], &turned).unwrap());
        check(&volume.view().part([3..69, 1..20, 2..11]).unwrap());
    }

    #[test]
    fn a_job_may_forbid_it() {
        let view = chance([65, 9, 9], |r| r as u8);
        let limited = Job { limits: Limits { bytes: 10 }, ..Job::default() };
        let found = Bricks::of(&view.view(), &limited);
        assert!(matches!(found, Err(Stopped::OverLimit(_))));
        let found = Bricks::of_slices(Slices::new(view.view()), &limited);
        assert!(matches!(found, Err(Stopped::OverLimit(_))));
        let cancelled = Job::default();
        cancelled.cancel.cancel();
        assert!(matches!(Bricks::of(&view.view(), &cancelled), Err(Stopped::Cancelled(_))));
    }
}
