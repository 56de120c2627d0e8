//! The same surfaces of samples of one byte, of which there are so few that all are added up by value.
//!
//! What edges add at their lower ends and take at their higher ends is added for each sample, with all its edges
//! (`isokit_lanes::Outflows`), and given to levels only then. A few rows of a few slices are taken at a time, so that
//! they stay in the machine's caches. All sums are of whole numbers, so that parts may be added in any order.

use crate::{Contour, Levels, edges::Metric};
use isokit_job::{Job, Stopped, Work};
use isokit_lanes::{
    Neighbours, Outflow, Outflows, RowNormals, STRIP, Scale, WHOLE, exactly, prefetch,
};
use isokit_volume::{Row, Sample, View};
use rayon::prelude::*;
use std::ops::Range;

/// Slices of samples in memory: from two below the newest on.
const SLICES: usize = 4;

/// Slices of normals in memory.
const NORMALS: usize = 3;

/// Samples of a slice of a part, about, and its slices.
const BAND: usize = 1 << 14;
const DEEP: usize = 64;

/// A part of a volume: rows of some slices.
#[derive(Clone, Debug)]
struct Part {
    rows: Range<usize>,
    slices: Range<usize>,
}

/// Parts that together are all.
fn parts([nx, ny, nz]: [usize; 3]) -> Vec<Part> {
    let rows = (BAND / nx).clamp(8, 64);
    let bands = (0..ny).step_by(rows).map(|first| first..ny.min(first + rows));
    let part = |rows: &Range<usize>, first: usize| Part {
        rows: rows.clone(),
        slices: first..nz.min(first + DEEP),
    };
    let deep = |rows: Range<usize>| (0..nz).step_by(DEEP).map(move |first| part(&rows, first));
    bands.flat_map(deep).collect()
}

/// What rises along the axes count for.
#[derive(Clone, Copy, Debug)]
struct Weights {
    /// The squares of the steps' covectors, the greatest as 1.
    shares: [f32; 3],
    /// Whether they differ.
    differ: bool,
}

impl Weights {
    fn of(squares: [f64; 3], most: f64) -> Self {
        Self {
            shares: squares.map(|square| (square / most) as f32),
            differ: squares.iter().any(|square| *square != most),
        }
    }
}

/// The way through the slices of a part.
struct Pass<'a, T> {
    view: &'a View<'a, T>,
    weights: Weights,
    part: Part,
    /// Numbers of a padded row.
    stride: usize,
    strips: usize,
    /// Rows from two before the part to two behind.
    samples: [Vec<u8>; SLICES],
    /// The value of each of these rows, if all its samples have one, as in air.
    values: [Vec<Option<u8>>; SLICES],
    /// Rows from one before the part to one behind.
    normals: [[Vec<i16>; 3]; NORMALS],
    is_even: [Vec<bool>; NORMALS],
    scratch: Vec<T>,
}

impl<'a, T: Sample> Pass<'a, T> {
    fn new(view: &'a View<'a, T>, weights: Weights, part: Part) -> Self {
        let strips = view.dims()[0].div_ceil(STRIP);
        let stride = STRIP * (strips + 2);
        let rows = part.rows.len();
        Self {
            view,
            weights,
            stride,
            strips,
            samples: [(); SLICES].map(|()| vec![0; stride * (rows + 4)]),
            values: [(); SLICES].map(|()| vec![None; rows + 4]),
            normals: [(); NORMALS].map(|()| [(); 3].map(|()| vec![0; stride * (rows + 2)])),
            is_even: [(); NORMALS].map(|()| vec![false; strips * (rows + 2)]),
            part,
            scratch: vec![],
        }
    }

    fn outflows(mut self, job: &Job) -> Result<Outflows, Stopped> {
        let mut sums = Outflows::new(self.weights.differ);
        let first = self.part.slices.start as isize;
        for k in first - 2..self.part.slices.end as isize + 2 {
            job.check()?;
            self.load(k);
            if k >= first {
                self.normals_of(k - 1);
            }
            if k > first + 1 {
                self.add(k - 2, &mut sums);
                job.progress.advance(1);
            }
        }
        Ok(sums)
    }

    /// Takes the rows of a slice, of the last or first one where there is none.
    fn load(&mut self, k: isize) {
        let [nx, ny, nz] = self.view.dims();
        let k_inside = k.clamp(0, nz as isize - 1) as usize;
        let next = (k_inside + 1).min(nz - 1);
        let turn = k.rem_euclid(SLICES as isize) as usize;
        let rows = self.samples[turn].chunks_exact_mut(self.stride);
        for (r, (out, value)) in rows.zip(&mut self.values[turn]).enumerate() {
            let j = (self.part.rows.start + r).saturating_sub(2).min(ny - 1);
            if let Row::Contiguous(next) = self.view.row(j, next) {
                prefetch(next);
            }
            let row = self.view.row(j, k_inside).gather(&mut self.scratch);
            let (before, out) = out.split_at_mut(STRIP);
            for (out, &sample) in out.iter_mut().zip(row) {
                *out = sample.rank() as u8;
            }
            let [first, last] = [out[0], out[nx - 1]];
            let is_even = || out[..nx].iter().fold(0, |differ, v| differ | (v ^ first)) == 0;
            *value = (first == last && is_even()).then_some(first);
            out[nx..].fill(last);
            before[STRIP - 1] = first;
        }
    }

    /// Row `r` of a slice, of those in memory.
    fn row(&self, k: isize, r: usize) -> &[u8] {
        let slice = &self.samples[k.rem_euclid(SLICES as isize) as usize];
        &slice[r * self.stride..(r + 1) * self.stride]
    }

    /// And those beside it.
    fn neighbours(&self, k: isize, r: usize) -> Neighbours<'_> {
        Neighbours {
            own: self.row(k, r),
            low: [self.row(k, r - 1), self.row(k - 1, r)],
            high: [self.row(k, r + 1), self.row(k + 1, r)],
        }
    }

    /// The one value that a row and those beside it have, if they do.
    fn value(&self, k: isize, r: usize) -> Option<u8> {
        let value = |k: isize, r: usize| self.values[k.rem_euclid(SLICES as isize) as usize][r];
        let beside = [value(k, r - 1), value(k, r + 1), value(k - 1, r), value(k + 1, r)];
        value(k, r).filter(|own| beside.iter().all(|value| *value == Some(*own)))
    }

    /// Finds normals, of slices of which both neighbours are in memory.
    fn normals_of(&mut self, k: isize) {
        let [nx, ny, nz] = self.view.dims();
        let turn = k.rem_euclid(NORMALS as isize) as usize;
        let mut normals = std::mem::take(&mut self.normals[turn]);
        let mut is_even = std::mem::take(&mut self.is_even[turn]);
        let times =
            |n: isize, count: usize| if n <= 0 || n + 1 >= count as isize { 2.0 } else { 1.0 };
        for r in 0..self.part.rows.len() + 2 {
            // Its normals count for no edge: all that lead there have equal ends.
            if self.value(k, r + 1).is_some() {
                continue;
            }
            let is_even = &mut is_even[r * self.strips..(r + 1) * self.strips];
            let out =
                normals.each_mut().map(|all| &mut all[r * self.stride..(r + 1) * self.stride]);
            let j = (self.part.rows.start + r) as isize - 1;
            let scale = Scale { weights: self.weights.shares, times: [times(j, ny), times(k, nz)] };
            self.neighbours(k, r + 1).normals(&scale, nx, out, is_even);
        }
        self.normals[turn] = normals;
        self.is_even[turn] = is_even;
    }

    /// Normals along an axis at row `r` of a slice.
    fn normals(&self, axis: usize, k: isize, r: usize) -> &[i16] {
        &self.normals[k.rem_euclid(NORMALS as isize) as usize][axis]
            [r * self.stride..(r + 1) * self.stride]
    }

    /// Adds what the samples of a slice add.
    fn add(&self, k: isize, sums: &mut Outflows) {
        let [nx, ..] = self.view.dims();
        for r in 1..=self.part.rows.len() {
            if let Some(value) = self.value(k, r + 1) {
                sums.add_even(value, nx);
                continue;
            }
            let normals = RowNormals {
                own: [0, 1, 2].map(|axis| self.normals(axis, k, r)),
                low: [self.normals(1, k, r - 1), self.normals(2, k - 1, r)],
                high: [self.normals(1, k, r + 1), self.normals(2, k + 1, r)],
            };
            let is_even = &self.is_even[k.rem_euclid(NORMALS as isize) as usize];
            let is_even = &is_even[r * self.strips..(r + 1) * self.strips];
            sums.add(self.neighbours(k, r + 1), normals, is_even, nx);
        }
    }
}

/// What samples of each value add.
fn outflows<T: Sample>(
    view: &View<'_, T>,
    weights: Weights,
    job: &Job,
) -> Result<[Outflow; 256], Stopped> {
    let parts = parts(view.dims());
    let rows = parts.iter().map(|part| part.rows.len() + 4).max().unwrap_or(0) as u64;
    let padded = (view.dims()[0] as u64).saturating_add(3 * STRIP as u64);
    let numbers = padded.checked_mul(rows * job.threads.count() as u64);
    let size = SLICES + 3 * NORMALS * size_of::<i16>();
    job.limits.probe("slices", numbers, size)?;
    let slices = parts.iter().map(|part| part.slices.len() as u64);
    job.progress.begin("spectrum", slices.sum());
    let part: Work<'_, _, _> =
        &|part: Part| exactly(|| Pass::new(view, weights, part).outflows(job).map(Outflows::sums));
    // One by one, since some parts are air.
    let all = || parts.into_par_iter().with_max_len(1).map(part).try_reduce(none, add);
    let all = job.threads.run(all)?;
    Ok(*all)
}

fn none() -> Box<[Outflow; 256]> {
    Box::new([Outflow::default(); 256])
}

fn add(
    mut all: Box<[Outflow; 256]>,
    more: Box<[Outflow; 256]>,
) -> Result<Box<[Outflow; 256]>, Stopped> {
    all.iter_mut().zip(*more).for_each(|(all, more)| *all = all.with(more));
    Ok(all)
}

/// The surfaces at all levels, of samples of one byte on a lattice whose steps are at right angles; else `None`.
pub(crate) fn contours<T: Sample>(
    view: &View<'_, T>,
    levels: &Levels,
    metric: Metric,
    job: &Job,
) -> Result<Option<Vec<Contour>>, Stopped> {
    let values: Vec<f64> = match size_of::<T>() {
        1 => (0..256).map(|rank| view.scaling().value(T::at_rank(rank).to_f64())).collect(),
        _ => return Ok(None),
    };
    let Some(squares) = metric.squares().filter(|_| values.iter().all(|v| v.is_finite())) else {
        return Ok(None);
    };
    let most = squares.iter().fold(0.0, |most: f64, square| square.max(most));
    let outflows = outflows(view, Weights::of(squares, most), job)?;
    let slope = view.scaling().slope();
    let mut bins = vec![Outflow::default(); levels.isos().len() + 1];
    for (&value, outflow) in values.iter().zip(&outflows) {
        let outflow = if slope < 0.0 { outflow.reversed() } else { *outflow };
        let bin = &mut bins[levels.rank(value)];
        *bin = bin.with(outflow);
    }
    let all = bins.iter().fold(Outflow::default(), |all, bin| all.with(*bin));
    let mut below = Outflow::default();
    let contour = |(bin, &iso): (&Outflow, &f64)| {
        below = below.with(*bin);
        let flux = |k: usize| below.rises[k] as f64 * slope.abs() * squares[k];
        Contour {
            iso,
            area: below.shares.max(0) as f64 * (metric.cell * most.sqrt() / f64::from(WHOLE)),
            total_gradient: metric.cell * (flux(0) + flux(1) + flux(2)),
            volume: (all.samples - below.samples) as f64 * metric.cell,
            crossings: below.crossings as u64,
        }
    };
    Ok(Some(bins.iter().zip(levels.isos()).map(contour).collect()))
}
