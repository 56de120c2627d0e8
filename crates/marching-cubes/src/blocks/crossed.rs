//! Which blocks have crossed cells, and which samples these look at.

use super::layer::{Bits, BlockGrid, Layer, SIDE};
use crate::{ExtractOptions, Gradient, Placement};
use std::ops::{Range, RangeInclusive};

/// How many samples on a line the vertices of a cell and their normals look at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    below: usize,
    above: usize,
    /// At a border, from there on.
    border: usize,
    /// Whether away from the lines of the edges too.
    is_wide: bool,
}

impl Reach {
    pub(super) fn of(options: &ExtractOptions) -> Self {
        let pairs = options.placement.pairs();
        match (options.gradient, options.placement) {
            (Gradient::Matching, Placement::Cubic | Placement::Quintic) => Self {
                below: options.placement.below(),
                above: options.placement.above(),
                border: SIDE,
                is_wide: true,
            },
            // Differences for normals reach one sample beyond the ends of an edge.
            _ => {
                let pairs = pairs.max(2);
                Self { below: pairs - 1, above: pairs, border: 2 * pairs, is_wide: false }
            }
        }
    }

    /// The samples that cells with these numbers look at, of `size`.
    fn samples(self, cells: &RangeInclusive<usize>, size: usize) -> Range<usize> {
        let first = cells.start().saturating_sub(self.below).min(size.saturating_sub(self.border));
        let end = (cells.end() + self.above + 1).max(self.border);
        first..end.min(size)
    }
}

const _: () =
    assert!(Placement::Quintic.above() <= SIDE, "no more than the next layer is looked at");

/// Some layers, by their numbers.
pub(super) struct Layers<'a, T> {
    pub(super) grid: BlockGrid,
    pub(super) first: usize,
    pub(super) held: &'a [Layer<T>],
}

impl<T> Layers<'_, T> {
    fn layer(&self, z: usize) -> &Layer<T> {
        &self.held[z - self.first]
    }

    /// The cells that are crossed whose lowest corner is in a block, from the first to the last along each axis. At
    /// the upper ends of the lattice, where there are no more, cells without a depth count.
    pub(super) fn crossed(&self, block: [usize; 3]) -> Option<[RangeInclusive<usize>; 3]> {
        let [x, y, z] = block;
        let [nx, ny, nz] = self.grid.counts;
        let is_last = [x + 1 == nx, y + 1 == ny, z + 1 == nz];
        let step = |axis: usize, n: usize| usize::from(n >> axis & 1 == 1 && !is_last[axis]);
        let place = |n: usize| {
            let [x, y, z] = [x + step(0, n), y + step(1, n), z + step(2, n)];
            (self.layer(z), x + nx * y)
        };
        let (own, number) = place(0);
        if let Some(side) = own.told(number)
            && (1..8).all(|n| {
                let (layer, number) = place(n);
                layer.told(number) == Some(side)
            })
        {
            return None;
        }
        let around: [&Bits; 8] = std::array::from_fn(|n| {
            let (layer, number) = place(n);
            layer.inside(number)
        });
        let [any, all] = around
            .iter()
            .copied()
            .flatten()
            .fold([0, u64::MAX], |[any, all], word| [any | word, all & word]);
        if any == 0 || all == u64::MAX {
            return None;
        }
        let cells = crossed(&rows(around, is_last));
        let flat = cells.iter().fold(0, |flat, cells| flat | cells);
        let of_bits =
            |bits: u64| (bits != 0).then(|| bits.trailing_zeros()..=63 - bits.leading_zeros());
        let along_x = (0..SIDE).fold(0, |bits, row| bits | flat >> (SIDE * row) & 0xFF);
        let along_y = (0..SIDE)
            .fold(0, |bits, row| bits | u64::from(flat >> (SIDE * row) & 0xFF != 0) << row);
        let along_z = (0..SIDE).fold(0, |bits, z| bits | u64::from(cells[z] != 0) << z);
        let ranges = [of_bits(along_x)?, of_bits(along_y)?, of_bits(along_z)?];
        Some(std::array::from_fn(|axis| {
            let (first, last) = (SIDE * block[axis], self.grid.dims[axis] - 1);
            let at = |n: &u32| last.min(first + *n as usize);
            at(ranges[axis].start())..=at(ranges[axis].end())
        }))
    }

    /// Adds the blocks that crossed cells look at and that are not made, as layers and numbers.
    pub(super) fn wanted(
        &self,
        cells: &[RangeInclusive<usize>; 3],
        reach: Reach,
        wanted: &mut Vec<(usize, usize)>,
    ) {
        let blocks = |samples: Range<usize>| samples.start / SIDE..(samples.end - 1) / SIDE + 1;
        let far: [_; 3] =
            std::array::from_fn(|axis| blocks(reach.samples(&cells[axis], self.grid.dims[axis])));
        let near: [_; 3] = std::array::from_fn(|axis| {
            blocks(*cells[axis].start()..self.grid.dims[axis].min(cells[axis].end() + 2))
        });
        for axis in 0..3 {
            let mut arm = if reach.is_wide { far.clone() } else { near.clone() };
            arm[axis] = far[axis].clone();
            for z in arm[2].clone() {
                for number in arm[1]
                    .clone()
                    .flat_map(|y| arm[0].clone().map(move |x| x + self.grid.counts[0] * y))
                {
                    if !self.layer(z).is_made(number) {
                        wanted.push((z, number));
                    }
                }
            }
            if reach.is_wide {
                break;
            }
        }
    }

    /// Whether a block has samples inside at the border of the lattice, beside which there may be a cap.
    pub(super) fn is_capped(&self, block: [usize; 3]) -> bool {
        let is_at_border =
            (0..3).any(|axis| block[axis] == 0 || block[axis] + 1 == self.grid.counts[axis]);
        let [x, y, z] = block;
        is_at_border && *self.layer(z).inside(x + self.grid.counts[0] * y) != [0; SIDE]
    }
}

/// The bits of the rows of samples at the corners of a block's cells: nine rows of nine bits in each of nine slices.
fn rows(around: [&Bits; 8], is_last: [bool; 3]) -> [[u16; SIDE + 1]; SIDE + 1] {
    // One beyond the block is the first of the next, or the last again.
    let at = |axis: usize, n: usize| match (n < SIDE, is_last[axis]) {
        (true, _) => (0, n),
        (false, false) => (1 << axis, 0),
        (false, true) => (0, SIDE - 1),
    };
    std::array::from_fn(|k| {
        std::array::from_fn(|j| {
            let ((next_y, j), (next_z, k)) = (at(1, j), at(2, k));
            let row = |next_x: usize| around[next_x | next_y | next_z][k] >> (SIDE * j) & 0xFF;
            let (next_x, i) = at(0, SIDE);
            (row(0) | (row(next_x) >> i & 1) << SIDE) as u16
        })
    })
}

/// The cells whose corners differ.
fn crossed(rows: &[[u16; SIDE + 1]; SIDE + 1]) -> Bits {
    let along_x = rows.map(|slice| slice.map(|row| [row | row >> 1, row & row >> 1]));
    std::array::from_fn(|k| {
        let row = |j: usize| {
            let four = [along_x[k][j], along_x[k][j + 1], along_x[k + 1][j], along_x[k + 1][j + 1]];
            let [any, all] = four
                .into_iter()
                .fold([0, u16::MAX], |[any, all], row| [any | row[0], all & row[1]]);
            u64::from(any & !all & 0xFF) << (SIDE * j)
        };
        (0..SIDE).fold(0, |cells, j| cells | row(j))
    })
}
