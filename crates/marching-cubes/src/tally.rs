//! How much surfaces have, where nobody wants them: slices are classified for all isovalues and counted while
//! they are in the cache. No plane is kept.

use crate::planes::{Lattice, Signs};
use isokit_job::{Job, Stopped};
use isokit_lanes::{Layer, Rows, Threshold, Thresholds, exactly};
use isokit_mesh::Counts;
use isokit_volume::{Sample, View};
use rayon::prelude::*;
use std::{mem, ops::Range};

/// Tasks per thread: few, for each looks at one slice that another looks at too.
const TASKS: usize = 4;

/// What there is to count.
pub(crate) struct Tally<'a, T> {
    signs: Signs<'a, T>,
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

impl From<Layer> for Whole {
    fn from(Layer { vertices, triangles, .. }: Layer) -> Self {
        Self { counts: Counts { vertices, triangles }, widest: triangles }
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
            let signs = Signs { view, lattice, thresholds, stops_at_nan };
            let tally = Self { signs, cells };
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
        let slices = self.signs.lattice.points[2];
        let per_task = slices.div_ceil(TASKS * job.threads.count());
        let tasks = slices.div_ceil(per_task);
        let count = |task| {
            let first = task * per_task;
            exactly(|| self.some(first..slices.min(first + per_task), job))
        };
        let counted: Vec<Found> =
            (0..tasks).into_par_iter().map(count).collect::<Result<_, _>>()?;
        let mut sum = Found::default();
        sum.counts.resize(self.signs.thresholds.count(), Whole::default());
        for found in counted {
            sum.has_nan |= found.has_nan;
            sum.counts.iter_mut().zip(found.counts).for_each(|(sum, more)| sum.add(more));
        }
        Ok(sum)
    }

    /// What the slices above these add, each to those below it; and with the first of all what that is by itself.
    fn some(&self, slices: Range<usize>, job: &Job) -> Result<Found, Stopped> {
        let (planes, nz) = (self.signs.thresholds.count(), self.signs.lattice.points[2]);
        let rows = Rows { words: self.signs.lattice.words, cells: &self.cells };
        // A slice ends with the one word more that the loops may look at.
        let stride = self.cells.len() + 1;
        let size = (stride as u64).checked_mul(planes as u64);
        let zeroed = || job.limits.zeroed("bits of a slice", size);
        let (mut low, mut high) = (zeroed()?, zeroed()?);
        let (mut found, mut scratch) = (Found::default(), vec![]);
        found.counts.resize(planes, Whole::default());
        self.classify(slices.start, &mut high, &mut found, &mut scratch);
        let mut layers: Vec<_> = high.chunks_exact(stride).map(|bits| rows.lowest(bits)).collect();
        if slices.start == 0 {
            let of_planes = found.counts.iter_mut().zip(&layers);
            of_planes.for_each(|(whole, &layer)| whole.add(layer.into()));
        }
        for z in slices {
            job.check()?;
            if z + 1 < nz {
                mem::swap(&mut low, &mut high);
                self.classify(z + 1, &mut high, &mut found, &mut scratch);
                for (k, (whole, layer)) in found.counts.iter_mut().zip(&mut layers).enumerate() {
                    let plane = k * stride..(k + 1) * stride;
                    *layer = rows.above((&low[plane.clone()], *layer), &high[plane]);
                    whole.add((*layer).into());
                }
            }
            job.progress.advance(1);
        }
        Ok(found)
    }

    /// The bits of slice `z` of the lattice for every threshold, one after another.
    fn classify(&self, z: usize, bits: &mut [u64], found: &mut Found, scratch: &mut Vec<T>) {
        let Lattice { points: [_, _, nz], guard, .. } = self.signs.lattice;
        if z < guard || z >= nz - guard {
            return bits.fill(0);
        }
        let of_planes = (bits, self.cells.len() + 1);
        found.has_nan |= !self.signs.classify(z - guard, of_planes, scratch);
    }
}

fn slice_words(lattice: Lattice) -> Option<u64> {
    (lattice.words as u64).checked_mul(lattice.points[1] as u64)
}
