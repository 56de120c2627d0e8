//! A borrowed box of samples.

use crate::{Grid, Sample, Scaling};
use isokit_geom::Frame;
use isokit_lanes::Samples;
use std::ops::Range;

/// Samples that lie in somebody else's memory, in any order of axes.
///
/// # Guarantees
///
/// Every lattice point has its sample inside the borrowed slice.
#[derive(Clone, Copy, Debug)]
pub struct View<'a, T> {
    samples: &'a [T],
    first: usize,
    strides: [isize; 3],
    dims: [usize; 3],
    frame: Frame,
    scaling: Scaling,
}

/// A layout that leads out of the samples, or a box that leads out of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// Some lattice point has no sample.
    #[error("the layout reaches from sample {least} to {greatest} of {held}")]
    OutOfBounds {
        /// Number of the first sample that is asked for; may be below 0.
        least: i128,
        /// Number of the last.
        greatest: i128,
        /// How many samples there are.
        held: usize,
    },
    /// A part that is empty or not inside the whole.
    #[error("samples {}..{} of axis {axis}, which has {size}", range.0, range.1)]
    Part {
        /// 0, 1 or 2 for x, y, z.
        axis: usize,
        /// First sample, and one after the last.
        range: (usize, usize),
        /// How many samples the axis has.
        size: usize,
    },
}

/// One row of samples along x.
#[derive(Clone, Copy, Debug)]
pub enum Row<'a, T> {
    /// Neighbours in the row are neighbours in memory.
    Contiguous(&'a [T]),
    /// They are `stride` samples apart; `first` is the place of the first in `samples`.
    Strided {
        /// All samples.
        samples: &'a [T],
        /// Place of the row's first sample.
        first: usize,
        /// Samples from one to the next; may be negative.
        stride: isize,
        /// Samples in the row.
        length: usize,
    },
}

impl<'a, T: Sample> Row<'a, T> {
    /// Some samples of the row.
    ///
    /// # Panics
    ///
    /// If the range leads out of the row.
    pub fn part(self, range: Range<usize>) -> Self {
        match self {
            Self::Contiguous(row) => Self::Contiguous(&row[range]),
            Self::Strided { samples, first, stride, length } => {
                assert!(range.start <= range.end && range.end <= length, "{range:?} of {length}");
                let first = first.wrapping_add_signed(range.start as isize * stride);
                Self::Strided { samples, first, stride, length: range.len() }
            }
        }
    }

    /// The row as a slice: itself where it is contiguous, else a copy made in `scratch`.
    pub fn gather(self, scratch: &'a mut Vec<T>) -> &'a [T] {
        match self {
            Self::Contiguous(row) => row,
            Self::Strided { samples, first, stride, length } => {
                scratch.clear();
                let place = |i: usize| first.wrapping_add_signed(i as isize * stride);
                scratch.extend((0..length).map(|i| samples[place(i)]));
                scratch
            }
        }
    }
}

impl<'a, T: Sample> View<'a, T> {
    /// The samples of a lattice, x fastest, without gaps.
    ///
    /// # Errors
    ///
    /// If there are fewer samples than lattice points.
    pub fn new(samples: &'a [T], grid: &Grid) -> Result<Self, ViewError> {
        let [nx, ny, _] = grid.dims();
        Self::strided(samples, 0, [1, nx as isize, (nx as i128 * ny as i128) as isize], grid)
    }

    /// The samples of a lattice where sample (i, j, k) is number `first + (i, j, k) · strides`.
    ///
    /// # Errors
    ///
    /// If some lattice point would have no sample.
    pub fn strided(
        samples: &'a [T],
        first: usize,
        strides: [isize; 3],
        grid: &Grid,
    ) -> Result<Self, ViewError> {
        let (mut least, mut greatest) = (first as i128, first as i128);
        for (n, stride) in grid.dims().into_iter().zip(strides) {
            // Neither factor exceeds 64 bits, so neither product nor sum leaves 128.
            let reach = (n - 1) as i128 * stride as i128;
            *if reach < 0 { &mut least } else { &mut greatest } += reach;
        }
        if least < 0 || greatest >= samples.len() as i128 {
            return Err(ViewError::OutOfBounds { least, greatest, held: samples.len() });
        }
        // With a stride of 0 an axis may be longer than memory.
        let dims = grid.dims().map(|n| usize::try_from(n).unwrap_or(usize::MAX));
        Ok(Self { samples, first, strides, dims, frame: grid.frame, scaling: Scaling::IDENTITY })
    }

    /// The same samples with another meaning.
    pub fn with_scaling(self, scaling: Scaling) -> Self {
        Self { scaling, ..self }
    }

    /// The same samples in another place.
    pub fn with_frame(self, frame: Frame) -> Self {
        Self { frame, ..self }
    }

    /// The box of samples in these ranges; its frame keeps every sample where it was.
    ///
    /// # Errors
    ///
    /// If a range is empty or leads out of the view.
    pub fn part(self, ranges: [Range<usize>; 3]) -> Result<Self, ViewError> {
        for (axis, range) in ranges.iter().enumerate() {
            let size = self.dims[axis];
            if range.is_empty() || range.end > size {
                return Err(ViewError::Part { axis, range: (range.start, range.end), size });
            }
        }
        let start = ranges.each_ref().map(|range| range.start);
        // A sample of the view lies in finite space, or its whole would not have been built.
        let frame = self.frame.starting_at(start).unwrap_or(self.frame);
        let first = self.place(start);
        Ok(Self { first, frame, dims: ranges.map(|range| range.len()), ..self })
    }

    /// Samples along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Index space to world space.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// What a stored sample means.
    pub fn scaling(&self) -> Scaling {
        self.scaling
    }

    /// The lattice.
    pub fn grid(&self) -> Grid {
        Grid::new(self.dims.map(|n| n as u64), self.frame).expect("a view is of a lattice")
    }

    /// The stored sample at a lattice point.
    ///
    /// # Panics
    ///
    /// If there is no such lattice point.
    #[inline(always)]
    pub fn stored(&self, ijk: [usize; 3]) -> T {
        debug_assert!(ijk.iter().zip(self.dims).all(|(&i, n)| i < n), "{ijk:?} of {:?}", self.dims);
        self.samples[self.place(ijk)]
    }

    /// The value at a lattice point: what the stored sample means.
    ///
    /// # Panics
    ///
    /// If there is no such lattice point.
    #[inline(always)]
    pub fn value(&self, ijk: [usize; 3]) -> f64 {
        self.scaling.value(self.stored(ijk).to_f64())
    }

    /// The stored samples at four lattice points along x from one on, if they are neighbours in memory.
    ///
    /// # Panics
    ///
    /// If there are no such lattice points.
    #[inline(always)]
    pub fn four(&self, ijk: [usize; 3]) -> Option<&'a [T; 4]> {
        debug_assert!(
            (0..3).all(|axis| ijk[axis] + [3, 0, 0][axis] < self.dims[axis]),
            "{ijk:?} {:?}",
            self.dims
        );
        match self.strides[0] {
            1 => self.samples[self.place(ijk)..].first_chunk(),
            _ => None,
        }
    }

    /// The stored samples at the corners of the cell whose lowest corner is a lattice point: corner `c` is as
    /// far on along x, y, z as the bits of `c` say.
    ///
    /// # Panics
    ///
    /// If there is no such cell.
    #[inline(always)]
    pub fn cell(&self, low: [usize; 3]) -> [T; 8] {
        debug_assert!(
            (0..3).all(|axis| low[axis] + 1 < self.dims[axis]),
            "{low:?} {:?}",
            self.dims
        );
        let (first, [x, y, z]) = (self.place(low), self.strides);
        if x == 1 {
            let pair = |offset| {
                let low = first.wrapping_add_signed(offset);
                &self.samples[low..low + 2]
            };
            let [a, b, c, d] = [pair(0), pair(y), pair(z), pair(y + z)];
            return [a[0], a[1], b[0], b[1], c[0], c[1], d[0], d[1]];
        }
        let corners = [0, x, y, x + y, z, x + z, y + z, x + y + z];
        corners.map(|offset| self.samples[first.wrapping_add_signed(offset)])
    }

    /// The samples (0, j, k), (1, j, k), …
    ///
    /// # Panics
    ///
    /// If there is no such row.
    #[inline]
    pub fn row(&self, j: usize, k: usize) -> Row<'a, T> {
        assert!(j < self.dims[1] && k < self.dims[2], "row {j}, {k} of {:?}", self.dims);
        let (first, length) = (self.place([0, j, k]), self.dims[0]);
        match self.strides[0] {
            1 => Row::Contiguous(&self.samples[first..first + length]),
            stride => Row::Strided { samples: self.samples, first, stride, length },
        }
    }

    /// The samples of slice `k`, row by row, where they lie so in memory.
    ///
    /// # Panics
    ///
    /// If there is no such slice.
    pub fn slice(&self, k: usize) -> Option<&'a [T]> {
        let ([nx, ny, nz], strides) = (self.dims, self.strides);
        assert!(k < nz, "slice {k} of {nz}");
        let first = self.place([0, 0, k]);
        (strides[0] == 1 && (ny == 1 || strides[1] == nx as isize))
            .then(|| &self.samples[first..first + nx * ny])
    }

    /// The same lattice as kernels take it. `None` if an axis has 2³¹ samples or more.
    pub fn samples(&self) -> Option<Samples<'a, T>> {
        Samples::new(self.samples, self.first, self.strides, self.dims)
    }

    #[inline(always)]
    fn place(&self, ijk: [usize; 3]) -> usize {
        let offset = |axis: usize| ijk[axis] as isize * self.strides[axis];
        self.first.wrapping_add_signed(offset(0) + offset(1) + offset(2))
    }
}

#[cfg(test)]
mod tests {
    use super::{View, ViewError};
    use crate::Grid;
    use isokit_geom::Frame;

    fn grid(dims: [u64; 3]) -> Grid {
        Grid::new(dims, Frame::default()).unwrap()
    }

    #[test]
    fn strides_may_permute_skip_and_run_backwards() {
        let samples: Vec<u8> = (0..24).collect();
        let plain = View::new(&samples, &grid([2, 3, 4])).unwrap();
        let turned = View::strided(&samples, 23, [-6, -2, -1], &grid([4, 3, 2])).unwrap();
        for [i, j, k] in [[0, 0, 0], [1, 2, 3], [1, 0, 2]] {
            assert_eq!(plain.stored([i, j, k]), turned.stored([3 - k, 2 - j, 1 - i]));
        }
        assert_eq!(turned.row(2, 1).gather(&mut vec![]), [18, 12, 6, 0]);
        assert_eq!(turned.row(2, 1).part(1..3).gather(&mut vec![]), [12, 6]);
        assert_eq!(plain.row(0, 0).part(1..2).gather(&mut vec![]), [1]);
    }

    #[test]
    fn a_slice_is_one_piece_where_its_rows_lie_one_behind_another() {
        let samples: Vec<u8> = (0..60).collect();
        let plain = View::new(&samples, &grid([3, 4, 5])).unwrap();
        assert_eq!(plain.slice(1), Some(&samples[12..24]));
        assert_eq!(plain.part([0..3, 1..3, 2..5]).unwrap().slice(2), Some(&samples[51..57]));
        assert_eq!(plain.part([0..2, 0..4, 0..5]).unwrap().slice(2), None);
        let downwards = View::strided(&samples, 48, [1, 3, -12], &grid([3, 4, 5])).unwrap();
        assert_eq!(downwards.slice(0), Some(&samples[48..]));
        for (first, strides) in [(2, [-1, 3, 12]), (9, [1, -3, 12]), (0, [4, 1, 12])] {
            let view = View::strided(&samples, first, strides, &grid([3, 4, 5])).unwrap();
            assert_eq!(view.slice(1), None, "{strides:?}");
        }
    }

    #[test]
    fn four_in_line_are_those_of_the_row_where_they_are_neighbours() {
        let samples: Vec<u8> = (0..60).collect();
        let plain = View::new(&samples, &grid([5, 4, 3])).unwrap();
        assert_eq!(plain.four([1, 2, 1]), Some(&[31, 32, 33, 34]));
        assert_eq!(
            plain.part([1..5, 1..3, 0..3]).unwrap().four([0, 1, 2]),
            Some(&[51, 52, 53, 54])
        );
        let turned = View::strided(&samples, 59, [-1, -5, -20], &grid([5, 4, 3])).unwrap();
        assert_eq!(turned.four([1, 2, 1]), None);
    }

    #[test]
    fn a_part_keeps_its_samples_where_they_were() {
        let samples: Vec<u8> = (0..60).collect();
        let whole = View::new(&samples, &grid([3, 4, 5])).unwrap();
        let part = whole.part([1..3, 2..3, 1..4]).unwrap();
        assert_eq!(part.dims(), [2, 1, 3]);
        assert_eq!(part.stored([1, 0, 2]), whole.stored([2, 2, 3]));
        assert_eq!(part.frame().index_to_world.origin(), [1.0, 2.0, 1.0]);
        assert_eq!(part.row(0, 0).gather(&mut vec![]), [19, 20]);
    }

    #[test]
    fn no_layout_leads_out_of_the_samples() {
        let samples = [0_u8; 24];
        let too_few = View::new(&samples[..23], &grid([2, 3, 4])).unwrap_err();
        assert_eq!(too_few, ViewError::OutOfBounds { least: 0, greatest: 23, held: 23 });
        let below = View::strided(&samples, 0, [-1, 2, 6], &grid([2, 3, 4])).unwrap_err();
        assert_eq!(below, ViewError::OutOfBounds { least: -1, greatest: 22, held: 24 });
        assert!(View::strided(&samples, 1, [isize::MAX; 3], &grid([1 << 20; 3])).is_err());
        let whole = View::new(&samples, &grid([2, 3, 4])).unwrap();
        assert!(matches!(whole.part([0..2, 1..1, 0..4]), Err(ViewError::Part { axis: 1, .. })));
        assert!(matches!(whole.part([0..2, 0..3, 0..5]), Err(ViewError::Part { axis: 2, .. })));
    }
}
