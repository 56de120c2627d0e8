//! Samples handed over slice by slice, from memory, file or formula.

use crate::{Bricks, Grid, Sample, Scaling, View, Volume};
use isokit_job::{Cancelled, Job, OverLimit};
use isokit_lanes::prefer_large_pages;
use std::ops::Range;

/// Gives the slices of a lattice, in z order, each once.
pub trait SlabSource<T: Sample> {
    /// Why slices could not be given.
    type Error: From<Cancelled> + From<OverLimit>;

    /// The lattice.
    fn grid(&self) -> &Grid;

    /// What a stored sample means.
    fn scaling(&self) -> Scaling {
        Scaling::IDENTITY
    }

    /// What is known of the samples beforehand. Who uses it asks for the rows that it needs. Default: nothing.
    fn bricks(&self) -> Option<&Bricks<T>> {
        None
    }

    /// Fills `slices` with the next whole slices, x fastest.
    ///
    /// The caller asks for as many slices as it likes at a time, and for no more than are left.
    ///
    /// # Errors
    ///
    /// If they cannot be had; what `slices` holds then is of no use.
    fn fill(&mut self, slices: &mut [T]) -> Result<(), Self::Error>;

    /// Fills some rows of the next whole slice, perhaps none; what becomes of the others is left open. Default: all
    /// are filled.
    ///
    /// # Errors
    ///
    /// As [`fill`](Self::fill).
    fn fill_rows(&mut self, slice: &mut [T], _rows: Range<usize>) -> Result<(), Self::Error> {
        self.fill(slice)
    }
}

/// Samples that a source hands over between two looks at the cancel token.
const PIECE: usize = 1 << 20;

/// Takes all slices into memory.
///
/// # Errors
///
/// If the volume needs more memory than the job allows (nothing is then allocated), if the job is
/// cancelled, or if the source fails.
pub fn collect<T: Sample, S: SlabSource<T>>(
    source: &mut S,
    job: &Job,
) -> Result<Volume<T>, S::Error> {
    let grid = *source.grid();
    let mut samples: Vec<T> = job.limits.vec("volume", Some(grid.count()))?;
    prefer_large_pages(samples.spare_capacity_mut());
    let count = samples.capacity().min(grid.count() as usize);
    let slice = grid.slice_count() as usize;
    let piece = slice * (PIECE / slice).max(1);
    job.progress.begin("read", grid.dims()[2]);
    while samples.len() < count {
        job.check()?;
        let done = samples.len();
        samples.resize(count.min(done + piece), T::default());
        source.fill(&mut samples[done..])?;
        job.progress.advance(((samples.len() - done) / slice) as u64);
    }
    let volume = Volume::new(grid, samples).expect("every slice was filled");
    Ok(volume.with_scaling(source.scaling()))
}

/// The slices of samples in memory.
#[derive(Debug)]
pub struct Slices<'a, T> {
    view: View<'a, T>,
    grid: Grid,
    next: usize,
}

impl<'a, T: Sample> Slices<'a, T> {
    /// From the first slice on.
    pub fn new(view: View<'a, T>) -> Self {
        Self { view, grid: view.grid(), next: 0 }
    }
}

impl<T: Sample> SlabSource<T> for Slices<'_, T> {
    type Error = isokit_job::Stopped;

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn scaling(&self) -> Scaling {
        self.view.scaling()
    }

    fn fill(&mut self, slices: &mut [T]) -> Result<(), Self::Error> {
        let [nx, ny, _] = self.view.dims();
        let mut scratch = vec![];
        for slice in slices.chunks_exact_mut(nx * ny) {
            for (j, row) in slice.chunks_exact_mut(nx).enumerate() {
                row.copy_from_slice(self.view.row(j, self.next).gather(&mut scratch));
            }
            self.next += 1;
        }
        Ok(())
    }
}

/// The slices of a formula of the lattice point.
#[derive(Debug)]
pub struct Formula<F> {
    grid: Grid,
    formula: F,
    next: u64,
}

impl<F> Formula<F> {
    /// `formula(ijk)` at each lattice point of `grid`.
    pub fn new(grid: Grid, formula: F) -> Self {
        Self { grid, formula, next: 0 }
    }
}

impl<T: Sample, F: FnMut([u64; 3]) -> T> SlabSource<T> for Formula<F> {
    type Error = isokit_job::Stopped;

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn fill(&mut self, slices: &mut [T]) -> Result<(), Self::Error> {
        let [nx, ny, _] = self.grid.dims();
        let mut samples = slices.iter_mut();
        let slices = samples.len() as u64 / self.grid.slice_count();
        for k in self.next..self.next + slices {
            for (j, i) in (0..ny).flat_map(|j| (0..nx).map(move |i| (j, i))) {
                let sample = samples.next().expect("whole slices");
                *sample = (self.formula)([i, j, k]);
            }
        }
        self.next += slices;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Formula, Slices, collect};
    use crate::{Grid, Sample, Scaling, Volume};
    use isokit_geom::Frame;
    use isokit_job::{Job, Limits, Stopped};

    fn grid(dims: [u64; 3]) -> Grid {
        Grid::new(dims, Frame::default()).unwrap()
    }

    fn numbered(dims: [u64; 3]) -> Result<Volume<u32>, Stopped> {
        let formula = |[i, j, k]: [u64; 3]| (i + dims[0] * (j + dims[1] * k)) as u32;
        collect(&mut Formula::new(grid(dims), formula), &Job::default())
    }

    #[test]
    fn a_formula_is_asked_x_fastest() {
        let volume = numbered([3, 2, 4]).unwrap();
        assert!(volume.samples().iter().enumerate().all(|(n, &sample)| sample == n as u32));
    }

    #[test]
    fn a_view_of_a_volume_collects_into_the_same_volume() {
        let volume = numbered([70, 5, 6]).unwrap().with_scaling(Scaling::new(2.0, 1.0).unwrap());
        assert_eq!(collect(&mut Slices::new(volume.view()), &Job::default()).unwrap(), volume);
        let part = volume.view().part([3..40, 1..5, 2..3]).unwrap();
        let copy = collect(&mut Slices::new(part), &Job::default()).unwrap();
        assert_eq!(copy.view().value([36, 3, 0]), part.value([36, 3, 0]));
    }

    #[test]
    fn nothing_is_allocated_beyond_the_limit_or_after_a_cancel() {
        let never = |_: [u64; 3]| -> f64 { panic!("asked for a sample") };
        let limited = Job { limits: Limits { bytes: 799 }, ..Job::default() };
        let found = collect(&mut Formula::new(grid([10, 10, 1]), never), &limited);
        assert!(matches!(found, Err(Stopped::OverLimit(over)) if over.needed == 800));
        let huge = collect(&mut Formula::new(grid([1 << 20; 3]), never), &Job::default());
        assert!(matches!(huge, Err(Stopped::OverLimit(_))));
        let cancelled = Job::default();
        cancelled.cancel.cancel();
        let found = collect(&mut Formula::new(grid([10, 10, 1]), never), &cancelled);
        assert!(matches!(found, Err(Stopped::Cancelled(_))));
    }

    #[test]
    fn progress_counts_slices() {
        let job = Job::default();
        let value = |[i, _, _]: [u64; 3]| i.to_string().len() as u8;
        let volume = collect(&mut Formula::new(grid([12, 1, 9]), value), &job).unwrap();
        assert_eq!(volume.samples()[11].to_f64(), 2.0);
        assert_eq!((job.progress.snapshot().done, job.progress.snapshot().total), (9, 9));
    }
}
