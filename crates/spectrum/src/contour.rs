//! The surface at each of many isovalues, as far as can be said without making one.
//!
//! The contour spectrum (Bajaj, Pascucci & Schikore 1997, "The contour spectrum"): area, enclosed volume and mean gradient
//! by isovalue. The total gradient, which is the integral of the gradient's length over the surface, is the one of
//! Pekar, Wiemker & Hempel 2001, "Fast detection of meaningful isosurfaces for volume data visualization"; by Gauss's
//! theorem it is the sum of the Laplacian inside, and that is a sum over the edges that cross the surface.
//!
//! Each pair of neighbouring samples is looked at once, and says how much it adds at which isovalues (`edges.rs`): from
//! which on and up to which, so that all isovalues cost no more than one. Samples of one byte on lattices with steps at
//! right angles are added up by value before (`bytes.rs`).

use crate::{
    Levels, bytes,
    edges::{Crossing, Metric},
};
use isokit_job::{Job, Stopped, Work};
use isokit_lanes::exactly;
use isokit_volume::{Sample, View};
use rayon::prelude::*;
use std::ops::Range;

/// The surfaces at many isovalues.
#[derive(Clone, Debug, PartialEq)]
pub struct ContourSpectrum {
    levels: Levels,
    contours: Vec<Contour>,
}

/// The surface at one isovalue. It ends at the border of the volume, and beside samples that are not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contour {
    /// The value.
    pub iso: f64,
    /// The area, in units of the world squared: of balls and tori sixteen samples thick and more within 0.6 %.
    /// Of samples of one byte, on lattices with steps at right angles, normals come from central differences alone: noise
    /// less than a sample wide does not add to it, and of what is one sample thin about half is missing.
    pub area: f64,
    /// The integral of the gradient's length over it, in units of the values times those of the world. Of values that were
    /// rounded it is too great, by a share of `1 / 2g²` where they rise by `g` roundings from one sample to the next: 0.8 %
    /// of 8, 3 % of 4.
    pub total_gradient: f64,
    /// The volume of the cells around the samples that are inside, in units of the world cubed.
    pub volume: f64,
    /// Edges between neighbouring samples that it crosses: so many vertices it has in a mesh.
    pub crossings: u64,
}

impl Contour {
    /// How long the gradient is on average: values per unit of the world. `None` where there is no surface.
    pub fn mean_gradient(&self) -> Option<f64> {
        (self.area > 0.0).then(|| self.total_gradient / self.area)
    }
}

impl ContourSpectrum {
    /// Looks at every pair of neighbouring samples once. The same numbers for any threads.
    ///
    /// # Errors
    ///
    /// If the job is cancelled, or does not allow the memory: 32 bytes for each level and each of up to 64 parts of the
    /// volume, and 12 for each sample of four slices for each thread. Samples of one byte need less.
    pub fn of<T: Sample>(view: &View<'_, T>, levels: Levels, job: &Job) -> Result<Self, Stopped> {
        let metric = Metric::of(&view.frame().index_to_world);
        if let Some(contours) = exactly(|| bytes::contours(view, &levels, metric, job))? {
            return Ok(Self { levels, contours });
        }
        let [nx, ny, nz] = view.dims();
        let per_part = nz.div_ceil(PARTS).max(SLICES);
        let parts = nz.div_ceil(per_part);
        let bins = (levels.isos().len() + 1) as u64 * parts as u64;
        job.limits.probe("spectrum", Some(bins), 32)?;
        let slices = (nx as u64 * ny as u64).checked_mul(4 * job.threads.count() as u64);
        job.limits.probe("slices", slices, size_of::<f64>() + size_of::<u32>())?;
        job.progress.begin("spectrum", nz as u64);
        let part: Work<'_, _, _> = &|n: usize| {
            let slices = n * per_part..nz.min((n + 1) * per_part);
            exactly(|| Pass::new(view, &levels, metric).part(slices, job))
        };
        let parts = job
            .threads
            .run(|| (0..parts).into_par_iter().map(part).collect::<Result<Vec<Sums>, Stopped>>())?;
        let contours = exactly(|| {
            let mut all = Sums::none(&levels);
            parts.iter().for_each(|part| all.add(part));
            all.contours(&levels, metric.cell)
        });
        Ok(Self { levels, contours })
    }

    /// The isovalues.
    pub fn levels(&self) -> &Levels {
        &self.levels
    }

    /// The surface at each of them.
    pub fn contours(&self) -> &[Contour] {
        &self.contours
    }
}

/// Parts of a volume that are added up one after another, whatever the threads: at most so many, of at least so many
/// slices.
const PARTS: usize = 64;
const SLICES: usize = 8;

/// What edges and samples add from one level to the next: as many as there are levels, and one more.
#[derive(Clone)]
struct Sums {
    area: Vec<f64>,
    flux: Vec<f64>,
    crossings: Vec<i64>,
    samples: Vec<u64>,
}

impl Sums {
    fn none(levels: &Levels) -> Self {
        let bins = levels.isos().len() + 1;
        let zeros = vec![0.0; bins];
        Self { area: zeros.clone(), flux: zeros, crossings: vec![0; bins], samples: vec![0; bins] }
    }

    /// An edge whose ends are inside at so many levels.
    #[inline]
    fn cross(&mut self, [low, high]: [usize; 2], Crossing { area, flux }: Crossing) {
        self.area[low] += area;
        self.area[high] -= area;
        self.flux[low] += flux;
        self.flux[high] -= flux;
        self.crossings[low] += 1;
        self.crossings[high] -= 1;
    }

    fn add(&mut self, other: &Self) {
        let add = |sums: &mut [f64], more: &[f64]| {
            sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        };
        add(&mut self.area, &other.area);
        add(&mut self.flux, &other.flux);
        self.crossings.iter_mut().zip(&other.crossings).for_each(|(sum, more)| *sum += more);
        self.samples.iter_mut().zip(&other.samples).for_each(|(sum, more)| *sum += more);
    }

    fn contours(&self, levels: &Levels, cell: f64) -> Vec<Contour> {
        let mut inside = self.samples.iter().sum::<u64>();
        let (mut area, mut flux, mut crossings) = (0.0, 0.0, 0);
        let contours = levels.isos().iter().enumerate().map(|(n, &iso)| {
            inside -= self.samples[n];
            area += self.area[n];
            flux += self.flux[n];
            crossings += self.crossings[n];
            // What is left of sums where nothing crosses is rounding.
            let rounded = |sum: f64| if crossings > 0 { sum.max(0.0) } else { 0.0 };
            Contour {
                iso,
                area: rounded(area),
                total_gradient: rounded(flux),
                volume: inside as f64 * cell,
                crossings: crossings as u64,
            }
        });
        contours.collect()
    }
}

/// A slice of samples: their values, and at how many levels each is inside.
#[derive(Default)]
struct Slice {
    values: Vec<f64>,
    ranks: Vec<u32>,
}

/// The gradients in index space of a row of samples, along x, y and z.
#[derive(Default)]
struct Gradients([Vec<f64>; 3]);

/// What is needed on the way through slices: those from one before to two behind.
struct Pass<'a, T> {
    view: &'a View<'a, T>,
    levels: &'a Levels,
    metric: Metric,
    window: [Slice; 4],
    scratch: Vec<T>,
    sums: Sums,
}

impl<'a, T: Sample> Pass<'a, T> {
    fn new(view: &'a View<'a, T>, levels: &'a Levels, metric: Metric) -> Self {
        let (window, sums) = (Default::default(), Sums::none(levels));
        Self { view, levels, metric, window, scratch: vec![], sums }
    }

    /// What the samples of some slices add, and the edges that begin there.
    fn part(mut self, slices: Range<usize>, job: &Job) -> Result<Sums, Stopped> {
        let [_, _, nz] = self.view.dims();
        let mut next = slices.start.saturating_sub(1);
        let mut rows: [Gradients; 3] = Default::default();
        for k in slices {
            job.check()?;
            while next < nz.min(k + 3) {
                self.load(next);
                next += 1;
            }
            self.slice(k, &mut rows);
            job.progress.advance(1);
        }
        Ok(self.sums)
    }

    fn load(&mut self, k: usize) {
        let Slice { values, ranks } = &mut self.window[k % 4];
        values.clear();
        ranks.clear();
        let scaling = self.view.scaling();
        for j in 0..self.view.dims()[1] {
            let row = self.view.row(j, k).gather(&mut self.scratch);
            values.extend(row.iter().map(|sample| scaling.value(sample.to_f64())));
        }
        ranks.extend(values.iter().map(|&value| self.levels.rank(value) as u32));
    }

    fn slice(&mut self, k: usize, [own, beside, above]: &mut [Gradients; 3]) {
        let [_, ny, nz] = self.view.dims();
        self.gradients(0, k, own);
        for j in 0..ny {
            self.count(j, k);
            self.along_x([j, k], own);
            if k + 1 < nz {
                self.gradients(j, k + 1, above);
                self.across(2, [[j, k], [j, k + 1]], [own, above]);
            }
            if j + 1 < ny {
                self.gradients(j + 1, k, beside);
                self.across(1, [[j, k], [j + 1, k]], [own, beside]);
                std::mem::swap(own, beside);
            }
        }
    }

    fn count(&mut self, j: usize, k: usize) {
        let (values, ranks) = row(&self.window, [j, k], self.view.dims());
        for (value, &rank) in values.iter().zip(ranks) {
            self.sums.samples[rank as usize] += u64::from(!value.is_nan());
        }
    }

    /// The gradients of a row: central differences, one-sided at the border and beside what is not finite.
    fn gradients(&self, j: usize, k: usize, Gradients([x, y, z]): &mut Gradients) {
        let [nx, ny, nz] = self.view.dims();
        let row = |j: usize, k: usize| row(&self.window, [j, k], [nx, ny, nz]).0;
        let own = row(j, k);
        let beside = [row(j.saturating_sub(1), k), row((j + 1).min(ny - 1), k)];
        let above = [row(j, k.saturating_sub(1)), row(j, (k + 1).min(nz - 1))];
        let share = |n: usize, count: usize| if n > 0 && n + 1 < count { 0.5 } else { 1.0 };
        let (in_y, in_z) = (share(j, ny), share(k, nz));
        for (all, [low, high], share) in [(y, beside, in_y), (z, above, in_z)] {
            all.clear();
            all.extend((0..nx).map(|i| rise([low[i], own[i], high[i]], share)));
        }
        x.clear();
        x.extend((0..nx).map(|i| {
            let ends = [own[i.saturating_sub(1)], own[i], own[(i + 1).min(nx - 1)]];
            rise(ends, share(i, nx))
        }));
    }

    /// The edges of a row along x.
    fn along_x(&mut self, place: [usize; 2], Gradients([_, y, z]): &Gradients) {
        let (values, ranks) = row(&self.window, place, self.view.dims());
        for i in 1..values.len() {
            if ranks[i] != ranks[i - 1] {
                let mean = |all: &[f64]| 0.5 * (all[i - 1] + all[i]);
                let gradient = [values[i] - values[i - 1], mean(y), mean(z)];
                if let Some(crossing) = self.metric.crossing(0, gradient) {
                    self.sums.cross(in_order([ranks[i - 1], ranks[i]]), crossing);
                }
            }
        }
    }

    /// The edges from a row to the one beside it, or above it.
    fn across(&mut self, axis: usize, [low, high]: [[usize; 2]; 2], [a, b]: [&Gradients; 2]) {
        let (values, ranks) = row(&self.window, low, self.view.dims());
        let (others, other_ranks) = row(&self.window, high, self.view.dims());
        for i in 0..values.len() {
            if ranks[i] != other_ranks[i] {
                let mean = |along: usize| 0.5 * (a.0[along][i] + b.0[along][i]);
                let mut gradient = [mean(0), mean(1), mean(2)];
                gradient[axis] = others[i] - values[i];
                if let Some(crossing) = self.metric.crossing(axis, gradient) {
                    self.sums.cross(in_order([ranks[i], other_ranks[i]]), crossing);
                }
            }
        }
    }
}

/// Row `j` of slice `k`, if that is loaded: its values, and at how many levels each is inside.
fn row(window: &[Slice; 4], [j, k]: [usize; 2], [nx, ..]: [usize; 3]) -> (&[f64], &[u32]) {
    let (Slice { values, ranks }, own) = (&window[k % 4], j * nx..(j + 1) * nx);
    (&values[own.clone()], &ranks[own])
}

/// How a value rises between its neighbours, where there are such: half of the whole, or all of one side.
#[inline]
fn rise([low, own, high]: [f64; 3], share: f64) -> f64 {
    let is_finite = |rise: &f64| rise.is_finite();
    let whole = Some((high - low) * share).filter(is_finite);
    let either = || Some(high - own).filter(is_finite).or(Some(own - low).filter(is_finite));
    whole.or_else(either).unwrap_or(0.0)
}

fn in_order([a, b]: [u32; 2]) -> [usize; 2] {
    [a.min(b) as usize, a.max(b) as usize]
}

#[cfg(test)]
mod tests;
