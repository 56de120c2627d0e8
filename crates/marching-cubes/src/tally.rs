//! How much surfaces have, where nobody wants them: slices are classified for all isovalues and counted while
//! they are in the cache. No plane is kept.

use crate::planes::{Lattice, behind_guard};
use isokit_job::{Job, Stopped};
use isokit_lanes::{
    Between, Flat, Rows, Threshold, Thresholds, exactly, has_nan, signs_of_many, words,
};
use isokit_mesh::Counts;
use isokit_volume::{Sample, View};
use rayon::prelude::*;
use std::{mem, ops::Range};

/// Tasks per thread: few, for each looks at one slice that another looks at too.
const TASKS: usize = 4;

/// What there is to count.
pub(crate) struct Tally<'a, T> {
    view: View<'a, T>,
    lattice: Lattice,
    thresholds: Thresholds<T>,
    stops_at_nan: bool,
    /// For every word of a slice, which of its points begin a cell along x.
    cells: Vec<u64>,
}

/// What was counted, for each threshold. Worth nothing after the NaN that was asked for.
#[derive(Default)]
struct Found {
    counts: Vec<Whole>,
    has_nan: bool,
}

/// A surface, and the most triangles that a slice of it has.
#[derive(Clone, Copy, Default)]
pub(crate) struct Whole {
    pub(crate) counts: Counts,
    pub(crate) widest: u64,
}

impl Whole {
    /// Goes on with slices that come after.
    fn add(&mut self, more: Self) {
        self.counts.vertices += more.counts.vertices;
        self.counts.triangles += more.counts.triangles;
        self.widest = self.widest.max(more.widest);
    }
}

impl<'a, T: Sample> Tally<'a, T> {
    /// The counts for each isovalue, or nothing if a sample is NaN and that matters.
    pub(crate) fn of(
        view: View<'a, T>,
        lattice: Lattice,
        isos: &[f64],
        stops_at_nan: bool,
        job: &Job,
    ) -> Result<Option<Vec<Whole>>, Stopped> {
        let thresholds: Vec<_> = isos.iter().map(|&iso| view.scaling().threshold(iso)).collect();
        let is_asked = |threshold: &Threshold<T>| !matches!(threshold, Threshold::Never);
        let asked: Vec<_> = thresholds.iter().copied().filter(is_asked).collect();
        let mut found = vec![].into_iter();
        if let Some(thresholds) = Thresholds::new(&asked) {
            let mut cells = job.limits.zeroed("cells of a slice", slice_words(lattice))?;
            let row = (0..lattice.words).map(|w| lattice.cells(w)).cycle();
            cells.iter_mut().zip(row).for_each(|(word, cells)| *word = cells);
            let tally = Self { view, lattice, thresholds, stops_at_nan, cells };
            let all = tally.all(job)?;
            if all.has_nan {
                return Ok(None);
            }
            found = all.counts.into_iter();
        }
        let counts = thresholds.iter().map(|threshold| match is_asked(threshold) {
            true => found.next().unwrap_or_default(),
            false => Whole::default(),
        });
        Ok(Some(counts.collect()))
    }

    fn all(&self, job: &Job) -> Result<Found, Stopped> {
        let slices = self.lattice.points[2];
        let per_task = slices.div_ceil(TASKS * job.threads.count());
        let tasks = slices.div_ceil(per_task);
        let count = |task| {
            let first = task * per_task;
            exactly(|| self.some(first..slices.min(first + per_task), job))
        };
        let counted: Vec<Found> =
            (0..tasks).into_par_iter().map(count).collect::<Result<_, _>>()?;
        let mut sum = Found::default();
        sum.counts.resize(self.thresholds.count(), Whole::default());
        for found in counted {
            sum.has_nan |= found.has_nan;
            sum.counts.iter_mut().zip(found.counts).for_each(|(sum, more)| sum.add(more));
        }
        Ok(sum)
    }

    /// What some slices own.
    fn some(&self, slices: Range<usize>, job: &Job) -> Result<Found, Stopped> {
        let (planes, nz) = (self.thresholds.count(), self.lattice.points[2]);
        let rows = Rows { words: self.lattice.words, cells: &self.cells };
        // A slice ends with the one word more that the loops may look at.
        let stride = self.cells.len() + 1;
        let size = (stride as u64).checked_mul(planes as u64);
        let zeroed = || job.limits.zeroed("bits of a slice", size);
        let mut low = (zeroed()?, vec![Flat::default(); planes]);
        let mut high = (zeroed()?, vec![Flat::default(); planes]);
        let (mut found, mut scratch) = (Found::default(), vec![]);
        found.counts.resize(planes, Whole::default());
        let mut classify = |z: usize, (bits, flats): &mut (Vec<u64>, Vec<Flat>), found: &mut _| {
            self.classify(z, bits, found, &mut scratch);
            let of_planes = flats.iter_mut().zip(bits.chunks_exact(stride));
            of_planes.for_each(|(flat, plane)| *flat = rows.flat(plane));
        };
        classify(slices.start, &mut high, &mut found);
        for z in slices {
            job.check()?;
            mem::swap(&mut low, &mut high);
            let has_next = z + 1 < nz;
            if has_next {
                classify(z + 1, &mut high, &mut found);
            }
            for (k, whole) in found.counts.iter_mut().enumerate() {
                let plane = k * stride..(k + 1) * stride;
                let (low, high) = ((&low.0[plane.clone()], low.1[k]), (&high.0[plane], high.1[k]));
                let mut between = Between::default();
                if has_next {
                    between = rows.between(low, high);
                }
                let vertices = low.1.vertices + between.vertices;
                let triangles = between.triangles;
                whole.add(Whole { counts: Counts { vertices, triangles }, widest: triangles });
            }
            job.progress.advance(1);
        }
        Ok(found)
    }

    /// The bits of a slice for every threshold, one after another.
    fn classify(&self, z: usize, bits: &mut [u64], found: &mut Found, scratch: &mut Vec<T>) {
        let Lattice { points: [_, ny, nz], guard, words: per_row } = self.lattice;
        let stride = self.cells.len() + 1;
        if z < guard || z >= nz - guard {
            return bits.fill(0);
        }
        for y in guard..ny - guard {
            let row = self.view.row(y - guard, z - guard).gather(scratch);
            found.has_nan |= self.stops_at_nan && has_nan(row);
            let bits = &mut bits[y * per_row..];
            signs_of_many(row, &self.thresholds, bits, stride);
            if guard > 0 {
                for plane in bits.chunks_mut(stride) {
                    let row = &mut plane[..per_row];
                    row[words(self.view.dims()[0])..].fill(0);
                    behind_guard(row);
                }
            }
        }
    }
}

fn slice_words(lattice: Lattice) -> Option<u64> {
    (lattice.words as u64).checked_mul(lattice.points[1] as u64)
}
