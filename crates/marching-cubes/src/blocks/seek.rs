//! Which blocks may hold the surface, and their samples.

use super::layer::{Bits, Block, BlockGrid, Layer, SAMPLES, SIDE};
use crate::{Nan, found::Found};
use isokit_job::{Cancelled, Job};
use isokit_lanes::{Side, Threshold, Thresholds, exactly, has_nan, nans, signs_of_many};
use isokit_volume::{Points, Sample, SampleSource, Scaling};
use rayon::prelude::*;
use std::ops::Range;

/// What is asked of blocks.
#[derive(Clone)]
pub(super) struct Seek<'a, T> {
    source: &'a dyn SampleSource<T>,
    pub(super) grid: BlockGrid,
    threshold: Threshold<T>,
    /// None where no sample is inside.
    thresholds: Option<Thresholds<T>>,
    may_miss: bool,
    pub(super) job: &'a Job,
}

/// What was found out about some blocks.
struct Seen<T> {
    inside: Vec<[Range<usize>; 3]>,
    /// With their layers.
    made: Vec<(usize, Block<T>)>,
}

/// Boxes of more blocks are shared among threads.
const SHARED: usize = 256;

impl<'a, T: Sample> Seek<'a, T> {
    pub(super) fn new(
        source: &'a dyn SampleSource<T>,
        grid: BlockGrid,
        iso: f64,
        nan: Nan,
        job: &'a Job,
    ) -> Self {
        let threshold = Scaling::IDENTITY.threshold(iso);
        let thresholds = Thresholds::new(&[threshold]);
        let may_miss = nan != Nan::Outside && !T::DTYPE.is_integer();
        Self { source, grid, threshold, thresholds, may_miss, job }
    }

    /// What is known of some layers.
    pub(super) fn layers(&self, layers: Range<usize>) -> Result<Vec<Layer<T>>, Cancelled> {
        if layers.is_empty() {
            return Ok(vec![]);
        }
        let [nx, ny, _] = self.grid.counts;
        let mut found: Vec<_> =
            layers.clone().map(|_| Layer::outside(self.grid.per_layer())).collect();
        for seen in self.look(self.source, [0..nx, 0..ny, layers.clone()])? {
            for [x, y, z] in seen.inside {
                for layer in &mut found[z.start - layers.start..z.end - layers.start] {
                    for row in y.clone() {
                        layer.set_inside(x.start + nx * row..x.end + nx * row);
                    }
                }
            }
            for (layer, block) in seen.made {
                found[layer - layers.start].add(block);
            }
        }
        Ok(found)
    }

    /// The samples of some blocks, given by their layers and numbers.
    pub(super) fn make(&self, blocks: &[(usize, usize)]) -> Result<Vec<Block<T>>, Cancelled> {
        let [nx, ..] = self.grid.counts;
        let make = |&(layer, number): &(usize, usize)| {
            self.job.check()?;
            let (x, y) = (number % nx, number / nx);
            let points = self.grid.points(&[x..x + 1, y..y + 1, layer..layer + 1]);
            Ok(exactly(|| {
                let near = self.source.within(&points);
                self.block(near.as_deref().unwrap_or(self.source), &points, number)
            }))
        };
        blocks.par_iter().map(make).collect()
    }

    fn look(
        &self,
        source: &dyn SampleSource<T>,
        blocks: [Range<usize>; 3],
    ) -> Result<Vec<Seen<T>>, Cancelled> {
        let count: usize = blocks.iter().map(Range::len).product();
        if count <= SHARED {
            self.job.check()?;
            let mut seen = Seen { inside: vec![], made: vec![] };
            exactly(|| self.look_closer(source, &blocks, &mut seen));
            return Ok(vec![seen]);
        }
        let points = self.grid.points(&blocks);
        match exactly(|| self.side(source, &points)) {
            Side::Outside => return Ok(vec![]),
            Side::Inside => return Ok(vec![Seen { inside: vec![blocks], made: vec![] }]),
            Side::Both => {}
        }
        let near = exactly(|| source.within(&points));
        let source = near.as_deref().unwrap_or(source);
        let parts = parts(&blocks).into_par_iter().map(|part| self.look(source, part));
        let parts: Vec<_> = parts.collect::<Result<_, Cancelled>>()?;
        Ok(parts.into_iter().flatten().collect())
    }

    /// The same by one thread.
    fn look_closer(
        &self,
        source: &dyn SampleSource<T>,
        blocks: &[Range<usize>; 3],
        seen: &mut Seen<T>,
    ) {
        let points = self.grid.points(blocks);
        match self.side(source, &points) {
            Side::Outside => return,
            Side::Inside => return seen.inside.push(blocks.clone()),
            Side::Both => {}
        }
        let near = source.within(&points);
        let source = near.as_deref().unwrap_or(source);
        if blocks.iter().all(|range| range.len() == 1) {
            let number = blocks[0].start + self.grid.counts[0] * blocks[1].start;
            seen.made.push((blocks[2].start, self.block(source, &points, number)));
            return;
        }
        for part in parts(blocks) {
            self.look_closer(source, &part, seen);
        }
    }

    /// On which side the samples of a box are, as far as that is told.
    fn side(&self, source: &dyn SampleSource<T>, points: &Points) -> Side {
        let Some(extent) = source.extent(points) else { return Side::Both };
        match self.may_miss && extent.has_nan {
            true => Side::Both,
            false => extent.side(self.threshold),
        }
    }

    fn block(&self, source: &dyn SampleSource<T>, points: &Points, number: usize) -> Block<T> {
        let mut samples = vec![T::default(); SAMPLES].into_boxed_slice();
        let sizes = points.each_ref().map(Range::len);
        if sizes == [SIDE; 3] {
            source.fill(points, &mut samples);
        } else {
            let mut held = vec![T::default(); sizes.iter().product()];
            source.fill(points, &mut held);
            let near = |i: usize, size: usize| i.min(size - 1);
            for (n, sample) in samples.iter_mut().enumerate() {
                let [i, j, k] = [n % SIDE, n / SIDE % SIDE, n / SIDE / SIDE];
                let row = near(j, sizes[1]) + sizes[1] * near(k, sizes[2]);
                *sample = held[near(i, sizes[0]) + sizes[0] * row];
            }
        }
        let mut inside = Bits::default();
        if let Some(thresholds) = &self.thresholds {
            signs_of_many(&samples, thresholds, &mut inside, SIDE);
        }
        let (mut missing, mut nan) = (None, Found::default());
        if self.may_miss && has_nan(&samples) {
            let mut bits = Bits::default();
            nans(&samples, &mut bits);
            nan = of_lattice(&bits, points);
            missing = Some(Box::new(bits));
        }
        let held = sizes.iter().product::<usize>() as u64;
        Block { number, samples, held, inside, missing, nan }
    }
}

/// The NaN samples of a block, without those beyond the lattice.
fn of_lattice(bits: &Bits, [x, y, z]: &Points) -> Found {
    let mut found = Found::default();
    for (bits, k) in bits.iter().zip(z.clone()) {
        for (row, j) in y.clone().enumerate() {
            let row = bits >> (SIDE * row) & ((1 << x.len()) - 1);
            let of_row = Found::in_row(&[row], [j, k]);
            let first = of_row.first.map(|[i, j, k]| [x.start + i, j, k]);
            found.add(Found { first, ..of_row });
        }
    }
    found
}

/// The halves of a box of blocks along each axis that is more than half as long as the longest.
fn parts(blocks: &[Range<usize>; 3]) -> Vec<[Range<usize>; 3]> {
    let longest = blocks.iter().map(Range::len).max().unwrap_or(0);
    let mut parts = vec![blocks.clone()];
    for axis in 0..3 {
        let Range { start, end } = blocks[axis];
        if end - start < 2 || 2 * (end - start) <= longest {
            continue;
        }
        let middle = start + (end - start).div_ceil(2).next_power_of_two().min(end - start - 1);
        let mut halves = vec![];
        for part in parts {
            for half in [start..middle, middle..end] {
                let mut part = part.clone();
                part[axis] = half;
                halves.push(part);
            }
        }
        parts = halves;
    }
    parts
}
