//! Blocks of samples: how a lattice is cut, and what is known of those of one layer.

use crate::found::Found;
use isokit_job::{Job, OverLimit};
use isokit_volume::Points;
use std::ops::Range;

/// Samples of a block along each axis; at the upper ends there may be fewer.
pub(super) const SIDE: usize = 8;

/// All samples of a block.
pub(super) const SAMPLES: usize = SIDE * SIDE * SIDE;

/// A bit for each sample of a block: bit x + 8 y of word z.
pub(super) type Bits = [u64; SIDE];

/// How a lattice is cut into blocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockGrid {
    pub(super) dims: [usize; 3],
    /// Blocks along x, y, z.
    pub(super) counts: [usize; 3],
}

impl BlockGrid {
    /// # Errors
    ///
    /// If what is kept of a layer of blocks is more than the job allows.
    pub(super) fn new(dims: [u64; 3], job: &Job) -> Result<Self, OverLimit> {
        let counts = dims.map(|n| n.div_ceil(SIDE as u64));
        job.limits.probe("layer of blocks", counts[0].checked_mul(counts[1]), 8)?;
        let dims = dims.map(|n| usize::try_from(n).unwrap_or(usize::MAX));
        Ok(Self { dims, counts: counts.map(|n| usize::try_from(n).unwrap_or(usize::MAX)) })
    }

    /// Blocks of a layer.
    pub(super) fn per_layer(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// The samples of some blocks.
    pub(super) fn points(&self, blocks: &[Range<usize>; 3]) -> Points {
        std::array::from_fn(|axis| {
            let Range { start, end } = blocks[axis];
            SIDE * start..self.dims[axis].min(SIDE * end)
        })
    }

    /// The slices of some layers.
    pub(super) fn slices(&self, layers: &Range<usize>) -> Range<usize> {
        SIDE * layers.start..self.dims[2].min(SIDE * layers.end)
    }
}

/// Samples that are made, the last of a line again where the block ends beyond the lattice.
#[derive(Debug)]
pub(super) struct Block<T> {
    /// Number in the layer.
    pub(super) number: usize,
    pub(super) samples: Box<[T]>,
    /// How many of them are in the lattice.
    pub(super) held: u64,
    /// Which are inside.
    pub(super) inside: Bits,
    /// Which are NaN, where some are and that matters.
    pub(super) missing: Option<Box<Bits>>,
    /// Of those that are in the lattice.
    pub(super) nan: Found,
}

/// What is known of the blocks of one layer.
#[derive(Debug)]
pub(super) struct Layer<T> {
    /// Where each is among those that are made; or that it is not, and on which side it lies.
    places: Vec<u32>,
    pub(super) made: Vec<Block<T>>,
}

/// No sample of the block is inside.
const OUTSIDE: u32 = u32::MAX;

/// All are inside.
const INSIDE: u32 = u32::MAX - 1;

impl<T> Layer<T> {
    /// No block has a sample inside.
    pub(super) fn outside(blocks: usize) -> Self {
        Self { places: vec![OUTSIDE; blocks], made: vec![] }
    }

    pub(super) fn set_inside(&mut self, blocks: Range<usize>) {
        self.places[blocks].fill(INSIDE);
    }

    pub(super) fn add(&mut self, block: Block<T>) {
        self.places[block.number] = self.made.len() as u32;
        self.made.push(block);
    }

    pub(super) fn is_made(&self, block: usize) -> bool {
        self.places[block] < INSIDE
    }

    /// The samples of a block that are inside.
    pub(super) fn inside(&self, block: usize) -> &Bits {
        match self.places[block] {
            OUTSIDE => &[0; SIDE],
            INSIDE => &[u64::MAX; SIDE],
            place => &self.made[place as usize].inside,
        }
    }

    /// Those that are NaN.
    pub(super) fn missing(&self, block: usize) -> &Bits {
        match self.places[block] {
            OUTSIDE | INSIDE => &[0; SIDE],
            place => self.made[place as usize].missing.as_deref().unwrap_or(&[0; SIDE]),
        }
    }

    /// Whether some blocks are outside without a look.
    pub(super) fn are_outside(&self, blocks: Range<usize>) -> bool {
        self.places[blocks].iter().all(|&place| place == OUTSIDE)
    }

    /// The side of a block of which no sample is made.
    pub(super) fn told(&self, block: usize) -> Option<bool> {
        match self.places[block] {
            OUTSIDE => Some(false),
            INSIDE => Some(true),
            _ => None,
        }
    }
}
