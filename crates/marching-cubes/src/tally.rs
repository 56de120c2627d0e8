//! How much surfaces have, where nobody wants them: slices are classified for all isovalues and counted while
//! they are in the cache. No plane is kept. Where the machine counts eight planes side by side, they are.

use crate::planes::{Lattice, Signs};
use isokit_job::{Job, Stopped, Work};
use isokit_lanes::{Layer, Rows, Threshold, Thresholds, exactly};
use isokit_mesh::Counts;
use isokit_volume::{Sample, View};
use rayon::prelude::*;
use std::{mem, ops::Range};

/// Tasks per thread: few, for each looks at one slice that another looks at too.
const TASKS: usize = 4;

/// So many planes and more are counted side by side, in groups of eight: of fewer most of a group would be empty.
const SIDE_BY_SIDE: usize = 4;

/// What there is to count.
pub(crate) struct Tally<'a, T> {
    signs: Signs<'a, T>,
    /// The thresholds of planes that lie side by side; none where planes are apart.
    groups: Vec<Thresholds<T>>,
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
            let is_abreast = Rows::are_side_by_side() && thresholds.count() >= SIDE_BY_SIDE;
            let groups = if is_abreast { thresholds.groups(8).collect() } else { vec![] };
            let signs = Signs { view, lattice, thresholds, stops_at_nan };
            let tally = Self { signs, groups, cells };
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
        let count: Work<'_, _, _> = &|task| {
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
        if self.groups.is_empty() { self.apart(slices, job) } else { self.abreast(slices, job) }
    }

    /// With planes one after another.
    fn apart(&self, slices: Range<usize>, job: &Job) -> Result<Found, Stopped> {
        let rows = Rows { words: self.signs.lattice.words, cells: &self.cells };
        // A slice ends with the one word more that the loops may look at.
        let (stride, planes) = (self.cells.len() + 1, self.signs.thresholds.count());
        let size = (stride as u64).checked_mul(planes as u64);
        let zeroed = || job.limits.zeroed("bits of a slice", size);
        let bits: [Vec<u64>; 2] = [zeroed()?, zeroed()?];
        let mut scratch = vec![];
        let classify = |k: Option<usize>, bits: &mut Vec<u64>| match k {
            Some(k) => self.signs.classify(k, (bits, stride), &mut scratch),
            None => {
                bits.fill(0);
                true
            }
        };
        let layers = |low: Option<&Vec<u64>>, high: &Vec<u64>, layers: &mut [Layer]| {
            for (k, layer) in layers.iter_mut().enumerate() {
                let plane = k * stride..(k + 1) * stride;
                *layer = match low {
                    Some(low) => rows.above((&low[plane.clone()], *layer), &high[plane]),
                    None => rows.lowest(&high[plane]),
                };
            }
        };
        self.walk((slices, planes), bits, classify, layers, job)
    }

    /// With eight planes side by side.
    fn abreast(&self, slices: Range<usize>, job: &Job) -> Result<Found, Stopped> {
        let rows = Rows { words: self.signs.lattice.words, cells: &self.cells };
        let (stride, groups) = (self.cells.len(), self.groups.len());
        let size = (stride as u64).checked_mul(groups as u64);
        let zeroed = || job.limits.zeroed("bits of a slice", size);
        let bits: [Vec<[u64; 8]>; 2] = [zeroed()?, zeroed()?];
        let mut scratch = vec![];
        let classify = |k: Option<usize>, bits: &mut Vec<[u64; 8]>| {
            let Some(k) = k else {
                bits.fill([0; 8]);
                return true;
            };
            let mut of_groups = self.groups.iter().zip(bits.chunks_exact_mut(stride));
            of_groups.all(|(group, bits)| self.signs.classify_abreast(k, group, bits, &mut scratch))
        };
        let layers = |low: Option<&Vec<[u64; 8]>>, high: &Vec<[u64; 8]>, layers: &mut [Layer]| {
            let (layers, _) = layers.as_chunks_mut::<8>();
            for (n, layers) in layers.iter_mut().enumerate() {
                let group = n * stride..(n + 1) * stride;
                *layers = match low {
                    Some(low) => rows.above_of_eight((&low[group.clone()], layers), &high[group]),
                    None => rows.lowest_of_eight(&high[group]),
                };
            }
        };
        let mut found = self.walk((slices, 8 * groups), bits, classify, layers, job)?;
        found.counts.truncate(self.signs.thresholds.count());
        Ok(found)
    }

    /// Goes through slices, of which two are kept: `classify` makes the bits of a slice of samples, or of one without, and
    /// says whether it has no NaN that matters; `layers` says what it adds, which is given for the slice below if there is
    /// one.
    fn walk<B>(
        &self,
        (slices, planes): (Range<usize>, usize),
        [mut low, mut high]: [B; 2],
        mut classify: impl FnMut(Option<usize>, &mut B) -> bool,
        layers: impl Fn(Option<&B>, &B, &mut [Layer]),
        job: &Job,
    ) -> Result<Found, Stopped> {
        let Lattice { points: [_, _, nz], guard, .. } = self.signs.lattice;
        let of_samples = |z: usize| (guard..nz - guard).contains(&z).then(|| z - guard);
        let mut found = Found { counts: vec![Whole::default(); planes], has_nan: false };
        let mut added = vec![Layer::default(); planes];
        let add = |found: &mut Found, added: &[Layer]| {
            found.counts.iter_mut().zip(added).for_each(|(whole, &layer)| whole.add(layer.into()));
        };
        found.has_nan |= !classify(of_samples(slices.start), &mut high);
        layers(None, &high, &mut added);
        if slices.start == 0 {
            add(&mut found, &added);
        }
        for z in slices {
            job.check()?;
            if z + 1 < nz {
                mem::swap(&mut low, &mut high);
                found.has_nan |= !classify(of_samples(z + 1), &mut high);
                layers(Some(&low), &high, &mut added);
                add(&mut found, &added);
            }
            job.progress.advance(1);
        }
        Ok(found)
    }
}

fn slice_words(lattice: Lattice) -> Option<u64> {
    (lattice.words as u64).checked_mul(lattice.points[1] as u64)
}
