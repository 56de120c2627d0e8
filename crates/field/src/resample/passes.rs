//! One axis after the other, sixteen lines abreast.

use super::{ResampleError, Weights};
use isokit_job::{Job, OverLimit, Stopped, WorkWith};
use isokit_lanes::{Abreast, Real, exactly, find_weights, weigh};
use isokit_volume::{Sample, View};
use rayon::prelude::*;

/// Lines abreast.
const LINES: usize = 16;

/// What is made of the samples of a view.
pub(super) struct Passes<'a, T, F> {
    pub(super) view: &'a View<'a, T>,
    pub(super) weights: &'a [Weights<F>; 3],
    pub(super) job: &'a Job,
}

/// Sixteen lines, and what is made of them.
struct Bundle<F> {
    /// With one number more at each end.
    line: Vec<Abreast<F>>,
    made: Vec<Abreast<F>>,
}

impl<F: Real> Bundle<F> {
    fn new([size, count]: [usize; 2]) -> Self {
        Self { line: vec![Abreast::default(); size + 2], made: vec![Abreast::default(); count] }
    }

    fn make(&mut self, weights: &Weights<F>) {
        if weights.is_same {
            self.made.copy_from_slice(&self.line[1..=weights.sizes[0]]);
            return;
        }
        if let Some(recursion) = &weights.recursion {
            find_weights(&mut self.line, recursion);
        }
        weigh(&self.line, &weights.taps, &mut self.made);
    }
}

impl<F: Real> Weights<F> {
    /// What makes bundles. Here it does not know of the type of samples, and so the loops do not.
    fn bundle(&self) -> impl Fn() -> Bundle<F> + Sync {
        let sizes = self.sizes;
        move || Bundle::new(sizes)
    }
}

impl<T: Sample, F: Real + Sample> Passes<'_, T, F> {
    /// The new samples, x fastest.
    pub(super) fn made(&self) -> Result<Vec<F>, ResampleError> {
        let mut samples = self.along_x()?;
        let [x, y, z] = self.weights.each_ref().map(|weights| weights.sizes);
        for (axis, dims) in [(1, [x[1], y[0], z[0]]), (2, [x[1], y[1], z[0]])] {
            if !self.weights[axis].is_same {
                samples = self.across(&samples, dims, axis)?;
            }
        }
        Ok(samples)
    }

    /// Rows become numbers and lie abreast, so that each instruction does something for sixteen of them.
    fn along_x(&self) -> Result<Vec<F>, ResampleError> {
        let Self { view, weights: [weights, ..], job } = self;
        let ([_, ny, nz], [size, count]) = (view.dims(), weights.sizes);
        let mut samples = self.room([count, ny, nz])?;
        let is_spline = self.weights.iter().any(|weights| weights.recursion.is_some());
        job.progress.begin("resample along x", (ny * nz) as u64);
        let group: WorkWith<'_, Bundle<F>, _, _> = &|bundle, (number, rows): (usize, &mut [F])| {
            exactly(|| {
                let (first, lines) = (number * LINES, rows.len() / count);
                let (mut scratch, mut are_finite) = (vec![], true);
                for line in 0..lines {
                    let row = first + line;
                    let row = view.row(row % ny, row / ny).gather(&mut scratch);
                    for (numbers, stored) in bundle.line[1..=size].iter_mut().zip(row) {
                        let number = stored.to_f64();
                        are_finite &= number.is_finite();
                        numbers.0[line] = F::nearest(number);
                    }
                }
                if is_spline && !are_finite {
                    return Err(Cut::NotFinite);
                }
                bundle.make(weights);
                for (line, row) in rows.chunks_exact_mut(count).enumerate() {
                    for (sample, numbers) in row.iter_mut().zip(&bundle.made) {
                        *sample = numbers.0[line];
                    }
                }
                job.progress.advance(lines as u64);
                job.check().map_err(|cancelled| Cut::Stopped(cancelled.into()))
            })
        };
        let groups = samples.par_chunks_mut(LINES * count).enumerate();
        let done = job.threads.run(|| groups.try_for_each_init(weights.bundle(), group));
        match done {
            Ok(()) => Ok(samples),
            Err(Cut::Stopped(stopped)) => Err(stopped.into()),
            Err(Cut::NotFinite) => Err(self.not_finite()),
        }
    }

    /// Along y or z, where sixteen neighbours in a row are in lines abreast already.
    fn across(
        &self,
        from: &[F],
        [nx, ny, nz]: [usize; 3],
        axis: usize,
    ) -> Result<Vec<F>, ResampleError> {
        let (weights, job) = (&self.weights[axis], self.job);
        let count = weights.sizes[1];
        let dims = if axis == 1 { [nx, count, nz] } else { [nx, ny, count] };
        let mut samples = self.room(dims)?;
        let rows = (dims[1] * dims[2]) as u64;
        job.limits.allow("rows", Some(rows), size_of::<&mut [F]>()).map_err(Stopped::from)?;
        // The rows of lines that lie in one plane, and where it begins and the next row of it.
        let planes = if axis == 1 { nz } else { ny };
        let mut groups: Vec<Vec<&mut [F]>> = (0..planes).map(|_| Vec::new()).collect();
        for (n, row) in samples.chunks_exact_mut(nx).enumerate() {
            groups[if axis == 1 { n / count } else { n % ny }].push(row);
        }
        let (start, step) = if axis == 1 { (nx * ny, nx) } else { (nx, nx * ny) };
        job.progress.begin(["", "resample along y", "resample along z"][axis], planes as u64);
        let group: WorkWith<'_, Bundle<F>, _, _> =
            &|bundle, (plane, mut rows): (usize, Vec<&mut [F]>)| {
                exactly(|| {
                    for x in (0..nx).step_by(LINES) {
                        let lines = LINES.min(nx - x);
                        for (n, numbers) in bundle.line[1..=weights.sizes[0]].iter_mut().enumerate()
                        {
                            let place = plane * start + n * step + x;
                            numbers.0[..lines].copy_from_slice(&from[place..place + lines]);
                        }
                        bundle.make(weights);
                        for (row, numbers) in rows.iter_mut().zip(&bundle.made) {
                            row[x..x + lines].copy_from_slice(&numbers.0[..lines]);
                        }
                    }
                    job.progress.advance(1);
                    job.check()
                })
            };
        let groups = groups.into_par_iter().enumerate();
        let done = job.threads.run(|| groups.try_for_each_init(weights.bundle(), group));
        done.map_err(Stopped::from)?;
        Ok(samples)
    }

    fn room(&self, dims: [usize; 3]) -> Result<Vec<F>, Stopped> {
        Ok(room(dims, self.job)?)
    }

    /// Which sample is the first that is no number.
    fn not_finite(&self) -> ResampleError {
        let [nx, ny, nz] = self.view.dims();
        let places = (0..nx * ny * nz).map(|n| [n % nx, n / nx % ny, n / nx / ny]);
        let of = |at: [usize; 3]| (at, self.view.stored(at).to_f64());
        let found = places.map(of).find(|(_, value)| !value.is_finite());
        let (at, value) = found.expect("one was found before");
        ResampleError::NotFinite { at, value }
    }
}

/// Why a pass came to no end.
enum Cut {
    Stopped(Stopped),
    NotFinite,
}

fn room<S: Copy + Default>(dims: [usize; 3], job: &Job) -> Result<Vec<S>, OverLimit> {
    let count = dims.iter().try_fold(1_u64, |count, &n| count.checked_mul(n as u64));
    job.limits.zeroed("resampled samples", count)
}

/// Samples of a view at places along x, y, z.
pub(super) fn taken<T: Sample + Default>(
    view: &View<'_, T>,
    [x, y, z]: &[Vec<usize>; 3],
    job: &Job,
) -> Result<Vec<T>, Stopped> {
    let mut samples = room([x.len(), y.len(), z.len()], job)?;
    job.progress.begin("resample", (y.len() * z.len()) as u64);
    let row = |scratch: &mut Vec<T>, (n, row): (usize, &mut [T])| {
        let old = view.row(y[n % y.len()], z[n / y.len()]).gather(scratch);
        for (sample, &place) in row.iter_mut().zip(x) {
            *sample = old[place];
        }
        job.progress.advance(1);
        job.check()
    };
    let rows = samples.par_chunks_mut(x.len()).enumerate();
    job.threads.run(|| rows.try_for_each_init(Vec::new, row))?;
    Ok(samples)
}
