//! A solid on a lattice: a field like any other.

use crate::tape::{Range, Tape};
use isokit_field::{Interval, Jet, ScalarField, Slope};
use isokit_geom::{Aabb, Affine};
use isokit_job::{Job, Stopped};
use isokit_lanes::{Real, exactly};
use isokit_volume::{Grid, Sample, Volume};
use rayon::prelude::*;
use std::ops;

/// A solid as a function of index space; values stay lengths of the world. [`Solid::placed`](crate::Solid::placed) makes
/// one.
///
/// Where minimum and maximum go over from one operand to the other, derivatives are those of one of them. In the middle of
/// a ball, where there is no direction, the slope is 0.
#[derive(Clone, Debug)]
pub struct Placed {
    tape: Tape,
    grid: Grid,
    /// Whether there is a value at every place between samples, as bounds tell.
    is_known: bool,
}

/// Samples of a brick: in it operands that have no say are left out.
const BRICK: [usize; 3] = [32, 16, 8];

impl Placed {
    pub(crate) fn new(tape: Tape, grid: &Grid) -> Self {
        let last = grid.dims().map(|n| (n - 1) as f64);
        let all = exactly(|| tape.range(ranges(Aabb { min: [0.0; 3], max: last })));
        let is_known = !all.none && all.low.is_finite() && all.high.is_finite();
        Self { tape, grid: *grid, is_known }
    }

    fn shortened(&self, ijk: Aabb) -> Option<Self> {
        let tape = exactly(|| self.tape.shortened(ranges(ijk)))?;
        Some(Self { tape, ..*self })
    }

    /// All its samples. The same bytes for any number of threads.
    ///
    /// # Errors
    ///
    /// If the job is cancelled or allows less memory.
    pub fn volume<T: Real + Sample + Default>(&self, job: &Job) -> Result<Volume<T>, Stopped> {
        let grid = self.grid;
        let mut samples: Vec<T> = job.limits.zeroed("volume", Some(grid.count()))?;
        let layers = BRICK[2];
        let slab = grid.slice_count() as usize * layers;
        job.progress.begin("sample", grid.dims()[2].div_ceil(layers as u64));
        job.threads.run(|| {
            samples.par_chunks_mut(slab).enumerate().try_for_each(|(n, samples)| {
                job.check()?;
                self.fill_slab(n * layers, samples);
                job.progress.advance(1);
                Ok::<_, Stopped>(())
            })
        })?;
        Ok(Volume::new(grid, samples).expect("one for each point"))
    }

    /// The samples of some slices, brick by brick.
    fn fill_slab<T: Real>(&self, first: usize, samples: &mut [T]) {
        let [nx, ny, _] = self.dims();
        let z = first..first + samples.len() / (nx * ny);
        let slab = self.shortened(around(&[0..nx, 0..ny, z.clone()]));
        let slab = slab.as_ref().unwrap_or(self);
        let mut values = vec![0.0; BRICK.iter().product()];
        for from_y in (0..ny).step_by(BRICK[1]) {
            for from_x in (0..nx).step_by(BRICK[0]) {
                let x = from_x..nx.min(from_x + BRICK[0]);
                let y = from_y..ny.min(from_y + BRICK[1]);
                let points = [x.clone(), y.clone(), z.clone()];
                let brick = slab.shortened(around(&points));
                let values = &mut values[..points.iter().map(ExactSizeIterator::len).product()];
                brick.as_ref().unwrap_or(slab).fill(points, values);
                let rows = z.clone().flat_map(|k| y.clone().map(move |j| (k, j)));
                for ((k, j), row) in rows.zip(values.chunks_exact(x.len())) {
                    let at = ((k - first) * ny + j) * nx + x.start;
                    let out = &mut samples[at..at + x.len()];
                    out.iter_mut().zip(row).for_each(|(out, &value)| *out = T::nearest(value));
                }
            }
        }
    }
}

/// The box from the first of some points to the last.
fn around(points: &[ops::Range<usize>; 3]) -> Aabb {
    Aabb {
        min: points.each_ref().map(|range| range.start as f64),
        max: points.each_ref().map(|range| range.end.saturating_sub(1) as f64),
    }
}

fn ranges(ijk: Aabb) -> [Range; 3] {
    [0, 1, 2].map(|axis| Range::new(ijk.min[axis], ijk.max[axis]))
}

impl ScalarField for Placed {
    fn dims(&self) -> [usize; 3] {
        self.grid.dims().map(|n| usize::try_from(n).unwrap_or(usize::MAX))
    }

    fn index_to_world(&self) -> Affine {
        self.grid.frame.index_to_world
    }

    fn value(&self, ijk: [f64; 3]) -> f64 {
        exactly(|| self.tape.value(ijk))
    }

    fn is_known(&self, ijk: [f64; 3]) -> bool {
        let is_between = |k: usize| ijk[k] >= 0.0 && ijk[k] <= (self.grid.dims()[k] - 1) as f64;
        self.is_known && (0..3).all(is_between) || self.value(ijk).is_finite()
    }

    fn slope(&self, ijk: [f64; 3]) -> Slope {
        let [x, y, z, value] = exactly(|| self.tape.slope(ijk)).0;
        Slope { value, gradient: [x, y, z] }
    }

    fn jet(&self, ijk: [f64; 3]) -> Jet {
        let found = exactly(|| self.tape.jet(ijk));
        Jet { value: found.value, gradient: found.gradient, hessian: found.hessian }
    }

    fn bounds(&self, ijk: Aabb) -> Interval {
        let found = exactly(|| self.tape.range(ranges(ijk)));
        match found.none {
            true => Interval::EVERYTHING,
            false => Interval { low: found.low, high: found.high },
        }
    }

    fn within(&self, ijk: Aabb) -> Option<Box<dyn ScalarField + '_>> {
        self.shortened(ijk).map(|shorter| Box::new(shorter) as _)
    }

    fn fill(&self, points: [ops::Range<usize>; 3], values: &mut [f64]) {
        exactly(|| self.tape.fill(points, values));
    }
}

#[cfg(test)]
mod tests;
