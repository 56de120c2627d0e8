//! The layers of blocks that are looked at, and the slices that they are laid out in.

use super::{
    crossed::{Layers, Reach},
    layer::{Bits, Layer, SIDE},
    seek::Seek,
};
use crate::{
    Boundary, ExtractOptions,
    found::Found,
    planes::{Lattice, Plane, Planes, behind_guard},
    slabs::Held,
    sparse::{Visits, spans},
};
use isokit_geom::Frame;
use isokit_job::{Cancelled, OverLimit};
use isokit_lanes::{WORD, words};
use isokit_volume::{BrickGrid, Grid, Sample, View};
use rayon::prelude::*;
use std::{ops::Range, sync::Arc};

/// Layers whose surface is made next, one below them and one above.
pub(super) struct Window<'a, T> {
    seek: Seek<'a, T>,
    reach: Reach,
    boundary: Boundary,
    frame: Frame,
    together: usize,
    first: usize,
    layers: Vec<Layer<T>>,
    /// Room for the slices of these layers. Where no block lies, it holds anything.
    samples: Vec<T>,
    strides: [usize; 2],
    /// NaN samples met so far, where somebody looked.
    pub(super) nan: Found,
    pub(super) blocks_made: u64,
    pub(super) samples_made: u64,
}

/// A window is not made higher for these bytes and more.
const ENOUGH: usize = 256 << 20;

/// Nor for these layers; tests go through several windows.
const ENOUGH_LAYERS: usize = if cfg!(test) { 2 } else { 8 };

/// Bytes by which rows are longer than need be: rows that are a power of two of bytes apart are in each other's way in
/// the caches.
const PADDING: usize = 64;

impl<'a, T: Sample> Window<'a, T> {
    pub(super) fn new(
        seek: Seek<'a, T>,
        frame: Frame,
        options: &ExtractOptions,
    ) -> Result<Self, OverLimit> {
        let ([nx, ny, _], layers) = (seek.grid.dims, seek.grid.counts[2]);
        let stride = (nx.next_multiple_of(SIDE)).saturating_add(PADDING / size_of::<T>());
        let slice = stride.saturating_mul(ny);
        let layer = slice.saturating_mul(SIDE * size_of::<T>());
        let together =
            (ENOUGH / layer.max(1)).saturating_sub(2).clamp(1, ENOUGH_LAYERS).min(layers);
        let slices = seek.grid.slices(&(0..layers.min(together + 2))).len();
        let count = (slice as u64).checked_mul(slices as u64);
        let samples = seek.job.limits.zeroed("window of slices", count)?;
        Ok(Self {
            seek,
            reach: Reach::of(options),
            boundary: options.boundary,
            frame,
            together,
            first: 0,
            layers: vec![],
            samples,
            strides: [stride, slice],
            nan: Found::default(),
            blocks_made: 0,
            samples_made: 0,
        })
    }

    /// Layers whose surface is made at a time.
    pub(super) fn layers_together(&self) -> usize {
        self.together
    }

    /// Goes on to the layers whose surface is made next.
    pub(super) fn advance(&mut self, own: &Range<usize>) -> Result<(), Cancelled> {
        let first = own.start.saturating_sub(1);
        self.layers.drain(..(first - self.first).min(self.layers.len()));
        self.first = first;
        let new = first + self.layers.len()..self.seek.grid.counts[2].min(own.end + 1);
        let new = self.seek.layers(new)?;
        for block in new.iter().flat_map(|layer| &layer.made) {
            let firsts = [self.nan.first, block.nan.first].into_iter().flatten();
            self.nan.first = firsts.min_by_key(|[i, j, k]| [*k, *j, *i]);
            self.nan.count += block.nan.count;
            self.blocks_made += 1;
            self.samples_made += block.held;
        }
        self.layers.extend(new);
        Ok(())
    }

    fn held_layers(&self) -> Range<usize> {
        self.first..self.first + self.layers.len()
    }

    /// The planes of the slices of some layers, with their samples and what these look at laid out. None if there is no
    /// surface.
    pub(super) fn planes(&mut self, own: &Range<usize>) -> Result<Option<Planes>, Cancelled> {
        let (grid, held) = (self.seek.grid, self.held_layers());
        let layers = Layers { grid, first: self.first, held: &self.layers };
        let [nx, ny, _] = grid.counts;
        let rows: Vec<[usize; 2]> =
            own.clone().flat_map(|z| (0..ny).map(move |y| [y, z])).collect();
        let found = rows.par_iter().map(|&[y, z]| {
            let (mut near, mut wanted) = (vec![], vec![]);
            for x in 0..nx {
                if let Some(cells) = layers.crossed([x, y, z]) {
                    near.push(x);
                    layers.wanted(&cells, self.reach, &mut wanted);
                }
            }
            (near, wanted)
        });
        let found: Vec<_> = found.collect();
        let dims = [grid.dims[0], grid.dims[1], grid.slices(&held).len()];
        let lattice = Lattice::new(dims, self.boundary);
        let bricks = BrickGrid::new(dims);
        let mut near = vec![false; bricks.counts().iter().product()];
        let mut mark = |[x, y, z]: [usize; 3]| {
            let brick = [x * SIDE / BrickGrid::CELLS[0], y, z - held.start];
            let last = bricks.counts().map(|n| n - 1);
            near[bricks.number(std::array::from_fn(|axis| brick[axis].min(last[axis])))] = true;
        };
        let mut wanted = vec![];
        for ([y, z], (near, more)) in rows.iter().copied().zip(found) {
            for x in near {
                mark([x, y, z]);
                if z + 1 == own.end && own.end < held.end {
                    // The vertices of the next slice are numbered too, and lie on edges of these cells.
                    mark([x, y, z + 1]);
                }
            }
            wanted.extend(more);
        }
        if lattice.guard == 1 {
            for [y, z] in (own.start..held.end).flat_map(|z| (0..ny).map(move |y| [y, z])) {
                let is_inner = ![0, ny - 1].contains(&y) && ![0, grid.counts[2] - 1].contains(&z);
                let step = if is_inner { (nx - 1).max(1) } else { 1 };
                let blocks = (0..nx).step_by(step).map(|x| [x, y, z]);
                blocks.filter(|&block| layers.is_capped(block)).for_each(&mut mark);
            }
        }
        if !near.contains(&true) {
            return Ok(None);
        }
        wanted.sort_unstable();
        wanted.dedup();
        let made = self.seek.make(&wanted)?;
        for ((layer, _), block) in wanted.into_iter().zip(made) {
            self.blocks_made += 1;
            self.samples_made += block.held;
            self.layers[layer - held.start].add(block);
        }
        self.lay_out();
        let inside = self.plane(lattice, own, Layer::inside);
        let is_missing = |layer: &Layer<T>| layer.made.iter().any(|block| block.missing.is_some());
        let missing = self.layers.iter().any(is_missing);
        let missing = missing.then(|| Arc::new(self.plane(lattice, own, Layer::missing)));
        let visits = Some(Visits::new(bricks, lattice, &spans(&bricks, |n| near[n])));
        Ok(Some(Planes { inside, missing, visits, ..Planes::blank(lattice) }))
    }

    /// Puts all blocks into their slices.
    fn lay_out(&mut self) {
        let ([stride, slice], [nx, ny, _]) = (self.strides, self.seek.grid.dims);
        let (layers, across) = (&self.layers, self.seek.grid.counts[0]);
        let slices = self.samples.par_chunks_exact_mut(slice).enumerate();
        slices.for_each(|(k, samples)| {
            if cfg!(test) {
                // What nobody looks at may be anything.
                samples.fill(T::at_rank(k as u64 * 31 % T::LAST_RANK));
            }
            let Some(layer) = layers.get(k / SIDE) else { return };
            for block in &layer.made {
                let (i, j) = (SIDE * (block.number % across), SIDE * (block.number / across));
                let own = &block.samples[k % SIDE * SIDE * SIDE..][..SIDE * SIDE];
                for (row, j) in own.chunks_exact(SIDE).zip(j..ny.min(j + SIDE)) {
                    let width = SIDE.min(nx - i);
                    samples[j * stride + i..][..width].copy_from_slice(&row[..width]);
                }
            }
        });
    }

    /// The bits of the slices of some layers, and of the next slices below and above.
    fn plane(
        &self,
        lattice: Lattice,
        own: &Range<usize>,
        bits: impl Fn(&Layer<T>, usize) -> &Bits + Sync,
    ) -> Plane {
        let (grid, held) = (self.seek.grid, self.seek.grid.slices(&self.held_layers()));
        let own = grid.slices(own);
        let slices = own.start.saturating_sub(1).max(held.start)..held.end.min(own.end + 1);
        let mut plane = Plane::blank(lattice);
        let first = slices.start - held.start + lattice.guard;
        let rows = plane.window(first, slices.len());
        let of_slice = |(k, out): (usize, &mut [u64])| {
            let layer = &self.layers[k / SIDE - self.first];
            let [nx, ny, _] = grid.counts;
            let mask = match grid.dims[0] % WORD {
                0 => u64::MAX,
                rest => (1 << rest) - 1,
            };
            for y in (0..ny).filter(|y| !layer.are_outside(y * nx..(y + 1) * nx)) {
                for x in 0..nx {
                    let eight = bits(layer, x + nx * y)[k % SIDE];
                    if eight == 0 {
                        continue;
                    }
                    for j in SIDE * y..grid.dims[1].min(SIDE * (y + 1)) {
                        let row = eight >> (SIDE * (j % SIDE)) & 0xFF;
                        out[lattice.row_of_samples(j).start + x / SIDE] |=
                            row << (SIDE * (x % SIDE));
                    }
                }
                for j in SIDE * y..grid.dims[1].min(SIDE * (y + 1)) {
                    let row = &mut out[lattice.row_of_samples(j)];
                    row[words(grid.dims[0]) - 1] &= mask;
                    if lattice.guard > 0 {
                        behind_guard(row);
                    }
                }
            }
        };
        let size = lattice.slice_words();
        slices.into_par_iter().zip(rows.par_chunks_exact_mut(size)).for_each(of_slice);
        plane
    }

    /// The slices that are held, of which those of some layers are to be made.
    pub(super) fn held(&self, own: &Range<usize>, lattice: Lattice) -> Held<'_, T> {
        let (grid, held) = (self.seek.grid, self.seek.grid.slices(&self.held_layers()));
        let dims = [grid.dims[0], grid.dims[1], held.len()].map(|n| n as u64);
        let strides = [1, self.strides[0] as isize, self.strides[1] as isize];
        let view = Grid::new(dims, self.frame).ok();
        let view = view.and_then(|grid| View::strided(&self.samples, 0, strides, &grid).ok());
        let slices = grid.slices(own);
        let start = match slices.start {
            0 => 0,
            start => start - held.start + lattice.guard,
        };
        let end = match slices.end == grid.dims[2] {
            true => lattice.points[2],
            false => slices.end - held.start + lattice.guard,
        };
        Held {
            view: view.expect("slices that are held"),
            first: held.start as u64,
            own: start..end,
        }
    }
}
