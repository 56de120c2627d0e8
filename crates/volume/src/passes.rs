//! Statistics and histogram of slices that pass by: the same as of a volume in memory.

use crate::{
    Grid, Histogram, Sample, Scaling, SlabSource, Statistics, View, histogram::finite_range,
};
use isokit_job::{Cancelled, Job};
use isokit_lanes::exactly;

/// A source whose samples are looked at on their way to whoever asked for them.
#[derive(Debug)]
pub struct Observed<S> {
    source: S,
    statistics: Statistics,
    slices: usize,
    job: Job,
}

/// Bytes of slices that are in memory at a time, or one slice.
const PIECE: usize = 4 << 20;

impl<S> Observed<S> {
    /// The same slices. The job says when to stop and on which threads to look; its progress is left to
    /// whoever asks for the slices.
    pub fn new(source: S, job: &Job) -> Self {
        Self { source, statistics: Statistics::EMPTY, slices: 0, job: job.unwatched() }
    }

    /// What holds of the slices so far.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }
}

impl<T: Sample, S: SlabSource<T>> SlabSource<T> for Observed<S> {
    type Error = S::Error;

    fn grid(&self) -> &Grid {
        self.source.grid()
    }

    fn scaling(&self) -> Scaling {
        self.source.scaling()
    }

    fn fill(&mut self, slices: &mut [T]) -> Result<(), S::Error> {
        self.source.fill(slices)?;
        let view = some_slices(&self.source, slices);
        let found = Statistics::of(&view, &self.job)?;
        self.statistics = self.statistics.then(found, self.slices);
        self.slices += view.dims()[2];
        Ok(())
    }
}

impl Statistics {
    /// Looks at every sample of a source once.
    ///
    /// # Errors
    ///
    /// If the source fails, or the job is cancelled.
    pub fn of_slices<T: Sample, S: SlabSource<T>>(source: S, job: &Job) -> Result<Self, S::Error> {
        let mut source = Observed::new(source, job);
        each_piece(&mut source, "scan", job, |_| Ok(()))?;
        Ok(source.statistics)
    }
}

impl Histogram {
    /// Counts every sample of a source once; asks for the source a second time if some are infinite.
    /// `None` if no sample is finite.
    ///
    /// # Errors
    ///
    /// If the source fails, or the job is cancelled.
    pub fn of_slices<T: Sample, S: SlabSource<T>>(
        mut source: impl FnMut() -> Result<S, S::Error>,
        statistics: &Statistics,
        job: &Job,
    ) -> Result<Option<Self>, S::Error> {
        let mut range = statistics.range;
        if statistics.infinite > 0 {
            range = None;
            each_piece(&mut source()?, "scan", job, |view: View<'_, T>| {
                exactly(|| {
                    let more = finite_range(&view, statistics);
                    range = match (range, more) {
                        (Some([a, b]), Some([c, d])) => Some([c.min(a), d.max(b)]),
                        (a, b) => a.or(b),
                    };
                });
                Ok(())
            })?;
        }
        let Some(range) = range else { return Ok(None) };
        let mut source = source()?;
        let mut histogram = exactly(|| Self::empty::<T>(range, source.scaling()));
        each_piece(&mut source, "scan", job, |view| exactly(|| histogram.count(&view, job)))?;
        Ok(Some(histogram))
    }
}

/// Lets all slices pass by, some at a time.
pub(crate) fn each_piece<T: Sample, S: SlabSource<T>>(
    source: &mut S,
    step: &'static str,
    job: &Job,
    mut look: impl FnMut(View<'_, T>) -> Result<(), Cancelled>,
) -> Result<(), S::Error> {
    let (slice, slices) = (source.grid().slice_count(), source.grid().dims()[2]);
    let at_once = (PIECE as u64 / size_of::<T>() as u64 / slice).clamp(1, slices);
    let mut samples: Vec<T> = job.limits.zeroed("slices", slice.checked_mul(at_once))?;
    job.progress.begin(step, slices);
    for first in (0..slices).step_by(at_once as usize) {
        job.check()?;
        let count = at_once.min(slices - first);
        let some = &mut samples[..(count * slice) as usize];
        source.fill(some)?;
        look(some_slices(source, some))?;
        job.progress.advance(count);
    }
    Ok(())
}

/// Whole slices of a source as a lattice of their own.
fn some_slices<'a, T: Sample>(source: &impl SlabSource<T>, samples: &'a [T]) -> View<'a, T> {
    let [nx, ny, _] = source.grid().dims();
    let slices = samples.len() as u64 / source.grid().slice_count();
    let grid = Grid::new([nx, ny, slices], source.grid().frame);
    let view = grid.ok().and_then(|grid| View::new(samples, &grid).ok());
    view.expect("whole slices, and at least one").with_scaling(source.scaling())
}

#[cfg(test)]
mod tests {
    use crate::{Grid, Histogram, Sample, Scaling, Slices, Statistics, Volume};
    use isokit_geom::Frame;
    use isokit_job::Job;

    fn check<T: Sample>(dims: [u64; 3], sample: impl Fn(u64) -> T) {
        let grid = Grid::new(dims, Frame::default()).unwrap();
        let chance = |n: u64| n.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40;
        let samples: Vec<T> = (0..grid.count()).map(|n| sample(chance(n))).collect();
        for slope in [1.0, -0.5] {
            let volume = Volume::new(grid, samples.clone()).unwrap();
            let volume = volume.with_scaling(Scaling::new(slope, 3.0).unwrap());
            let (view, job) = (volume.view(), Job::default());
            let statistics = Statistics::of(&view, &job).unwrap();
            assert_eq!(Statistics::of_slices(Slices::new(view), &job), Ok(statistics));
            let source = || Ok(Slices::new(view));
            let found = Histogram::of_slices(source, &statistics, &job).unwrap();
            assert_eq!(found, Histogram::of(&view, &statistics, &job).unwrap());
            for known in [None, Some(&statistics)] {
                let both = Histogram::with_statistics(&view, known, &job).unwrap();
                assert_eq!(both, (statistics, found.clone()));
            }
        }
    }

    #[test]
    fn slices_that_pass_by_tell_what_the_volume_tells() {
        check([1500, 1000, 5], |r| (r % 251) as u8);
        check([70, 3, 9], |r| r as i16);
        check([3, 3, 3], |_| -7_i8);
        check([700, 900, 7], |r| if r % 5 == 0 { f32::NAN } else { r as f32 });
        check([700, 900, 4], |r| if r % 3 == 0 { f64::INFINITY } else { r as f64 - 1e6 });
        check([5, 5, 5], |_| f32::NAN);
    }
}
