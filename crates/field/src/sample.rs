//! From a field to samples on its lattice: a volume, slabs of one, or samples where somebody asks for them.
//!
//! A sample is the value at its lattice point, rounded once where it is f32. It is asked of the field within a small
//! box, which may be cheaper, and is the same whoever asks, and whatever for.

use crate::{Interval, ScalarField};
use isokit_geom::{Aabb, Frame};
use isokit_job::{Cancelled, Job, Stopped};
use isokit_lanes::{Extent, Real, exactly};
use isokit_volume::{Grid, GridError, Points, Sample, SampleSource, SlabSource, Volume, collect};
use rayon::prelude::*;
use std::marker::PhantomData;

/// The samples of a field, f32 or f64, made where somebody asks for them.
pub struct FieldSamples<'a, T> {
    field: Held<'a>,
    grid: Grid,
    samples: PhantomData<fn() -> T>,
}

enum Held<'a> {
    Whole(&'a dyn ScalarField),
    Part(Box<dyn ScalarField + 'a>),
}

impl<'a, T: Sample + Real> FieldSamples<'a, T> {
    /// Those at the lattice points of a field. `frame` says unit and space of the world; where the lattice lies there the field
    /// says.
    ///
    /// # Errors
    ///
    /// If there are none, or more than 64 bits can count.
    pub fn new(field: &'a dyn ScalarField, frame: Frame) -> Result<Self, GridError> {
        let frame = Frame { index_to_world: field.index_to_world(), ..frame };
        let grid = Grid::new(field.dims().map(|n| n as u64), frame)?;
        Ok(Self { field: Held::Whole(field), grid, samples: PhantomData })
    }

    fn field(&self) -> &dyn ScalarField {
        match &self.field {
            Held::Whole(field) => *field,
            Held::Part(field) => &**field,
        }
    }
}

impl<T: Sample + Real> SampleSource<T> for FieldSamples<'_, T> {
    fn grid(&self) -> Grid {
        self.grid
    }

    fn extent(&self, points: &Points) -> Option<Extent<T>> {
        let Interval { low, high } = self.field().bounds(around(points));
        // Rounding keeps the order of numbers.
        let [least, greatest] = [low, high].map(T::nearest);
        let is_known = low <= high && (low > f64::NEG_INFINITY || high < f64::INFINITY);
        is_known.then_some(Extent { least, greatest, has_nan: false })
    }

    fn within(&self, points: &Points) -> Option<Box<dyn SampleSource<T> + '_>> {
        let field = Held::Part(self.field().within(around(points))?);
        Some(Box::new(FieldSamples { field, grid: self.grid, samples: PhantomData }))
    }

    fn fill(&self, points: &Points, samples: &mut [T]) {
        let mut values = vec![0.0; samples.len()];
        self.field().fill(points.clone(), &mut values);
        for (sample, value) in samples.iter_mut().zip(values) {
            *sample = T::nearest(value);
        }
    }
}

/// The box of lattice points in index space.
fn around(points: &Points) -> Aabb {
    Aabb {
        min: points.each_ref().map(|range| range.start as f64),
        max: points.each_ref().map(|range| range.end.saturating_sub(1) as f64),
    }
}

/// The samples of a field slice by slice, in parallel.
pub struct FieldSlices<'a, T> {
    samples: FieldSamples<'a, T>,
    job: &'a Job,
    next: usize,
}

/// Points along x and along y and z of the boxes that are asked for at a time.
const BOX: [usize; 2] = [64, 8];

impl<'a, T: Sample + Real> FieldSlices<'a, T> {
    /// From the first slice on.
    pub fn new(samples: FieldSamples<'a, T>, job: &'a Job) -> Self {
        Self { samples, job, next: 0 }
    }

    /// Slices from the one with number `first` on.
    fn slices(&self, first: usize, samples: &mut [T]) -> Result<(), Cancelled> {
        self.job.check()?;
        let [nx, ny, _] = self.samples.grid.dims().map(|n| n as usize);
        let z = first..first + samples.len() / (nx * ny);
        let mut held = vec![];
        for (y, x) in
            (0..ny).step_by(BOX[1]).flat_map(|y| (0..nx).step_by(BOX[0]).map(move |x| (y, x)))
        {
            let points = [x..nx.min(x + BOX[0]), y..ny.min(y + BOX[1]), z.clone()];
            let near = self.samples.within(&points);
            held.resize(points.iter().map(|range| range.len()).product(), T::default());
            match &near {
                Some(near) => near.fill(&points, &mut held),
                None => self.samples.fill(&points, &mut held),
            }
            let [x, y, _] = &points;
            for (n, row) in held.chunks_exact(x.len()).enumerate() {
                let place = x.start + nx * (y.start + n % y.len() + ny * (n / y.len()));
                samples[place..place + x.len()].copy_from_slice(row);
            }
        }
        Ok(())
    }
}

impl<T: Sample + Real> SlabSource<T> for FieldSlices<'_, T> {
    type Error = Stopped;

    fn grid(&self) -> &Grid {
        &self.samples.grid
    }

    fn fill(&mut self, slices: &mut [T]) -> Result<(), Stopped> {
        let slice = self.samples.grid.slice_count() as usize;
        let each = (slices.len() / slice / self.job.threads.count()).clamp(1, BOX[1]);
        let first = self.next;
        self.job.threads.run(|| {
            let parts = slices.par_chunks_mut(each * slice).enumerate();
            parts.try_for_each(|(n, part)| exactly(|| self.slices(first + n * each, part)))
        })?;
        self.next += slices.len() / slice;
        Ok(())
    }
}

/// The values of a field at its lattice points. The same bytes for any number of threads.
///
/// # Errors
///
/// If the job is cancelled or allows less memory.
pub fn sample<T: Sample + Real>(
    samples: FieldSamples<'_, T>,
    job: &Job,
) -> Result<Volume<T>, Stopped> {
    collect(&mut FieldSlices::new(samples, job), job)
}

#[cfg(test)]
mod tests;
