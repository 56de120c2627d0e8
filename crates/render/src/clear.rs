//! Where nothing can be seen.

use crate::{
    Interpolant,
    transfer::{Lookup, Scale},
};
use isokit_job::{Job, Stopped, Work};
use isokit_lanes::{Blocks, Columns, Extent, WORD, add_row, exactly, words};
use isokit_volume::{Bricks, Sample, View};
use rayon::prelude::*;

/// For each block of a volume how far around it nothing can be seen.
#[derive(Clone, Debug)]
pub(crate) struct Clear {
    /// Blocks along x, y, z.
    counts: [usize; 3],
    /// In blocks along each axis, and diagonally: 0 if something in the block itself can be seen, 1 if nothing in it can,
    /// 2 if nothing in those that touch it can either, and so on. What is beyond the volume cannot be seen.
    reach: Vec<u8>,
}

/// Cells of a block along each axis.
pub(crate) const CELLS: usize = 4;

/// A brick's samples along x, with those around it, are two words.
pub(crate) const MOST_MARGIN: usize = 16;

/// Blocks of a brick along x, y, z: a brick is a word of cells long, and two blocks wide and deep.
const BLOCKS: [usize; 3] = [WORD / CELLS, 2, 2];

/// What is looked up of samples.
#[derive(Clone, Copy)]
struct Looks<'a, T> {
    view: &'a View<'a, T>,
    scale: Scale,
    lookup: &'a Lookup<'a>,
    around: Around,
}

/// What else than the samples of a cell may be seen in it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Around {
    /// Samples so many places away, no more than [`MOST_MARGIN`].
    pub(crate) margin: usize,
    /// Values beyond those of samples: what is between them is cubic.
    pub(crate) is_cubic: bool,
}

impl Clear {
    /// Of the bricks of which something can be seen the samples are looked at once more, block by block.
    ///
    /// # Errors
    ///
    /// If the job is cancelled or does not allow a byte for each block.
    pub(crate) fn new<T: Sample>(
        view: &View<'_, T>,
        bricks: &Bricks<T>,
        (lookup, around): (&Lookup<'_>, Around),
        job: &Job,
    ) -> Result<Self, Stopped> {
        let counts = view.dims().map(|n| (n - 1).div_ceil(CELLS).max(1));
        let all = counts.iter().map(|&n| n as u64).product();
        let mut reach: Vec<u8> = job.limits.zeroed("blocks of the volume", Some(all))?;
        reach.fill(u8::MAX);
        let looks = Looks { view, scale: Scale::of(view.scaling()), lookup, around };
        let [nx, ny, _] = bricks.grid().counts();
        let layer: Work<'_, _, _> = &|(z, blocks): (usize, &mut [u8])| {
            job.check()?;
            exactly(|| {
                for (y, x) in (0..ny).flat_map(|y| (0..nx).map(move |x| (y, x))) {
                    // Those beside it too, if they are so near.
                    let mut extents = near(bricks, [x, y, z], around.margin);
                    // Bricks share samples, so that what is clear in each is clear in all; but not beyond their values.
                    let is_clear = match around.is_cubic {
                        true => {
                            let all = extents.reduce(|a, b| a.with(b));
                            let is_border = on_border([x, y, z], bricks.grid().counts());
                            all.is_none_or(|all| looks.is_clear(&all, is_border))
                        }
                        false => extents.all(|extent| looks.is_clear(&extent, false)),
                    };
                    if !is_clear {
                        looks.look_into([x, y, z], counts, blocks);
                    }
                }
            });
            Ok::<_, Stopped>(())
        };
        let size = counts[0] * counts[1] * BLOCKS[2];
        job.threads.run(|| reach.par_chunks_mut(size).enumerate().try_for_each(layer))?;
        let mut clear = Self { counts, reach };
        clear.spread();
        Ok(clear)
    }

    /// The blocks, for leaps.
    pub(crate) fn blocks(&self) -> Option<Blocks<'_>> {
        Blocks::new(self.counts, CELLS as u16, &self.reach)
    }

    /// Blocks along x, y, z.
    pub(crate) fn counts(&self) -> [usize; 3] {
        self.counts
    }

    /// Those of a layer across z of which something can be seen.
    pub(crate) fn seen(&self, z: usize) -> impl Iterator<Item = [usize; 3]> {
        let [nx, ny, _] = self.counts;
        let layer = self.reach[z * nx * ny..][..nx * ny].iter().enumerate();
        layer.filter(|&(_, reach)| *reach == 0).map(move |(n, _)| [n % nx, n / nx, z])
    }

    /// The numbers of blocks no farther than so many blocks from one of which something can be seen, in the order of
    /// memory.
    pub(crate) fn near(&self, blocks: u8) -> impl Iterator<Item = [usize; 3]> {
        let [nx, ny, _] = self.counts;
        let near = self.reach.iter().enumerate().filter(move |&(_, reach)| *reach <= blocks);
        near.map(move |(n, _)| [n % nx, n / nx % ny, n / nx / ny])
    }

    /// Whether nothing can be seen in the block that a place of index space, in the volume, is in.
    pub(crate) fn is_clear(&self, place: [f64; 3]) -> bool {
        let block = |axis: usize| (place[axis] as usize / CELLS).min(self.counts[axis] - 1);
        self.reach[block(0) + self.counts[0] * (block(1) + self.counts[1] * block(2))] > 0
    }

    /// From blocks that can be seen to the others: a block's reach is one more than the least around it (Rosenfeld &
    /// Pfaltz 1966, "Sequential operations in digital picture processing": once forward, once backward).
    fn spread(&mut self) {
        let [nx, ny, nz] = self.counts;
        let mut around = vec![0; nx];
        for is_back in [false, true] {
            for n in 0..ny * nz {
                let n = if is_back { ny * nz - 1 - n } else { n };
                let (y, z) = (n % ny, n / ny);
                // The rows that were visited and touch this one.
                let before: &[[isize; 2]] = &[[-1, 0], [-1, -1], [0, -1], [1, -1]];
                around.fill(u8::MAX);
                for offset in before {
                    let [dy, dz] = offset.map(|offset| if is_back { -offset } else { offset });
                    let (Some(y), Some(z)) = (y.checked_add_signed(dy), z.checked_add_signed(dz))
                    else {
                        continue;
                    };
                    if y < ny && z < nz {
                        let row = &self.reach[(z * ny + y) * nx..][..nx];
                        for (least, &own) in around.iter_mut().zip(row) {
                            *least = (*least).min(own);
                        }
                    }
                }
                let row = &mut self.reach[n * nx..][..nx];
                take_in(row, &around);
                match is_back {
                    false => follow(row.iter_mut()),
                    true => follow(row.iter_mut().rev()),
                }
            }
        }
    }
}

/// What is in a brick, and in those that have samples no farther from it than so many.
pub(crate) fn near<T: Sample>(
    bricks: &Bricks<T>,
    [x, y, z]: [usize; 3],
    margin: usize,
) -> impl Iterator<Item = Extent<T>> {
    let grid = bricks.grid();
    let near = move |n: usize, axis: usize| {
        let more = margin.div_ceil(BLOCKS[axis] * CELLS);
        n.saturating_sub(more)..(n + more + 1).min(grid.counts()[axis])
    };
    let rows = near(z, 2).flat_map(move |z| near(y, 1).map(move |y| [y, z]));
    let places = rows.flat_map(move |[y, z]| near(x, 0).map(move |x| [x, y, z]));
    places.map(move |place| bricks.extents()[grid.number(place)])
}

/// Whether one of so many things along each axis is at a border of them.
pub(crate) fn on_border(place: [usize; 3], counts: [usize; 3]) -> bool {
    (0..3).any(|axis| place[axis] == 0 || place[axis] + 1 == counts[axis])
}

/// A row's reaches are no more than one more than those beside it, and diagonally, in other rows.
fn take_in(row: &mut [u8], around: &[u8]) {
    for x in 0..row.len() {
        let beside = &around[x.saturating_sub(1)..(x + 2).min(around.len())];
        let least = beside.iter().copied().min().unwrap_or(u8::MAX);
        row[x] = row[x].min(least.saturating_add(1));
    }
}

/// Nor one more than that before it.
fn follow<'a>(row: impl Iterator<Item = &'a mut u8>) {
    let mut before = u8::MAX;
    for reach in row {
        *reach = (*reach).min(before.saturating_add(1));
        before = *reach;
    }
}

impl<T: Sample> Looks<'_, T> {
    /// A value between samples is between their least and greatest, but for the rounding of three
    /// interpolations, one after another; so what holds them is clear if the lookup shows nothing from there to there.
    /// Cubics lead beyond.
    fn is_clear(&self, extent: &Extent<T>, is_border: bool) -> bool {
        let Some(range) = extent.range() else { return true }; // all samples are NaN
        let range = range.map(Sample::to_f64);
        let reach = Interpolant::<T>::reach(range, self.around.is_cubic, is_border);
        let [least, greatest] = reach.map(|end| end as f32);
        let slack = 8.0 * f32::EPSILON * least.abs().max(greatest.abs());
        let [a, b] = [least - slack, greatest + slack].map(|stored| self.scale.value(stored));
        self.lookup.is_clear([a.min(b), a.max(b)])
    }

    /// Marks the blocks of a brick of which something can be seen, where `blocks` are those of its layer.
    fn look_into(&self, brick: [usize; 3], counts: [usize; 3], blocks: &mut [u8]) {
        let dims = self.view.dims();
        let first = [0, 1, 2].map(|axis| brick[axis] * BLOCKS[axis]);
        // The samples of so many blocks from one on, with those on the far side, and those around.
        let of = |axis: usize, block: usize, more: usize| {
            (block * CELLS).saturating_sub(self.around.margin)
                ..((block + more) * CELLS + 1 + self.around.margin).min(dims[axis])
        };
        let along_x = of(0, first[0], BLOCKS[0]);
        let mut scratch = vec![];
        for (k, j) in (0..BLOCKS[2]).flat_map(|k| (0..BLOCKS[1]).map(move |j| (k, j))) {
            let (y, z) = (first[1] + j, first[2] + k);
            if y >= counts[1] || z >= counts[2] {
                continue;
            }
            let mut columns = [Columns::<T>::EMPTY; 2];
            let columns = &mut columns[..words(along_x.len())];
            for (z, y) in of(2, z, 1).flat_map(|z| of(1, y, 1).map(move |y| (z, y))) {
                add_row(self.view.row(y, z).part(along_x.clone()).gather(&mut scratch), columns);
            }
            let row = &mut blocks[(k * counts[1] + y) * counts[0]..][..counts[0]];
            for (n, reach) in row.iter_mut().enumerate().skip(first[0]).take(BLOCKS[0]) {
                let own = of(0, n, 1);
                let [begin, end] = [own.start, own.end].map(|at| at - along_x.start);
                // The last ones may be in the next word.
                let mut extent = columns[0].some(begin.min(WORD)..end.min(WORD));
                if end > WORD {
                    extent = extent.with(columns[1].some(begin.max(WORD) - WORD..end - WORD));
                }
                if !self.is_clear(&extent, on_border([n, y, z], counts)) {
                    *reach = 0;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Around, CELLS, Clear, MOST_MARGIN};
    use crate::{ControlPoint, TransferFunction, transfer::Lookup};
    use isokit_job::Job;
    use isokit_volume::{Bricks, Grid, Volume};

    fn chance() -> impl FnMut(u64) -> u64 {
        let mut state = 1_u64;
        move |below| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
            (state >> 40) % below
        }
    }

    #[test]
    fn the_reach_is_how_far_the_next_block_is_that_can_be_seen() {
        let (counts, mut chance) = ([9, 8, 7], chance());
        let [nx, ny, nz] = counts;
        for share in [0, 1, 20] {
            let seen: Vec<bool> = (0..nx * ny * nz).map(|_| chance(300) < share).collect();
            let reach = seen.iter().map(|&seen| if seen { 0 } else { u8::MAX }).collect();
            let mut clear = Clear { counts, reach };
            clear.spread();
            let place = |n: usize| [n % nx, n / nx % ny, n / nx / ny];
            for n in 0..seen.len() {
                let away = |m: usize| {
                    let (a, b) = (place(n), place(m));
                    (0..3).map(|k| a[k].abs_diff(b[k])).max().unwrap()
                };
                let nearest = (0..seen.len()).filter(|&m| seen[m]).map(away).min();
                let expected = nearest.map_or(u8::MAX, |away| away as u8);
                assert_eq!(clear.reach[n], expected, "{:?}", place(n));
            }
        }
    }

    #[test]
    fn a_block_is_clear_if_no_value_from_its_least_sample_to_its_greatest_is_seen() {
        let point = |value: f64, rgba: &str| ControlPoint::new(value, rgba.parse().unwrap());
        let band =
            [point(100.0, "#ffffff00"), point(110.0, "#ffffff80"), point(120.0, "#ffffff00")];
        let band = TransferFunction::new(band.into()).unwrap().into();
        let lookup = Lookup::new(&band, 1.0, 1.0);
        let mut chance = chance();
        // In the last one so little is seen that it is bricks away from most blocks.
        let volumes = [[2, 2, 2], [65, 9, 17], [66, 10, 3], [130, 5, 18], [64, 4, 30]];
        let volumes = volumes.map(|dims| (dims, 80)).into_iter();
        for (dims, margin) in volumes
            .zip([0, 1, 3, 5, 2])
            .chain([(([6, 6, 190], 900), 9), (([6, 190, 6], 900), MOST_MARGIN)])
        {
            let (dims, seldom) = dims;
            let grid = Grid::new(dims, Default::default()).unwrap();
            let mut sample =
                |_| if chance(seldom) == 0 { 255 } else { 7 + 80 * (chance(60) == 0) as u8 };
            let volume: Volume<u8> =
                Volume::new(grid, (0..grid.count()).map(&mut sample).collect()).unwrap();
            let (view, job) = (volume.view(), Job::default());
            let bricks = Bricks::of(&view, &job).unwrap();
            let clear =
                Clear::new(&view, &bricks, (&lookup, Around { margin, is_cubic: false }), &job)
                    .unwrap();
            let [nx, ny, nz] = clear.counts;
            for n in 0..nx * ny * nz {
                let block = [n % nx, n / nx % ny, n / nx / ny];
                let along = |axis: usize| {
                    let first = block[axis] * CELLS;
                    first.saturating_sub(margin)
                        ..=(first + CELLS + margin).min(view.dims()[axis] - 1)
                };
                let (mut least, mut greatest) = (u8::MAX, 0);
                for (k, j) in along(2).flat_map(|k| along(1).map(move |j| (k, j))) {
                    for sample in along(0).map(|i| view.stored([i, j, k])) {
                        (least, greatest) = (least.min(sample), greatest.max(sample));
                    }
                }
                let is_seen = least < 120 && greatest > 100;
                assert_eq!(clear.reach[n] == 0, is_seen, "{block:?}: {least} to {greatest}");
            }
        }
    }
}
