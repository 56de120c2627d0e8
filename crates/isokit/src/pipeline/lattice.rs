//! Where the samples of a scan are, whether they were read or not.

use crate::pipeline::{Region, RegionError};
use isokit_geom::{Aabb, Frame, Space};
use isokit_volume::Grid;
use std::ops::Range;

/// A lattice of samples, and the part of it that is looked at.
///
/// # Guarantees
///
/// The part is not empty, and in the lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    whole: Grid,
    part: [Range<usize>; 3],
}

impl Lattice {
    /// A part of a lattice.
    ///
    /// # Errors
    ///
    /// If there is no such part.
    pub fn new(whole: Grid, region: &Region) -> Result<Self, RegionError> {
        // What is in memory is numbered by its address space.
        let part = region.samples(&whole)?.map(|range| range.start as usize..range.end as usize);
        Ok(Self { whole, part })
    }

    /// The same part, elsewhere in the world.
    pub(super) fn placed(mut self, frame: Frame) -> Self {
        self.whole.frame = frame;
        self
    }

    /// All of the lattice.
    pub fn whole(&self) -> &Grid {
        &self.whole
    }

    /// Index space of the whole lattice to world space.
    pub fn frame(&self) -> &Frame {
        &self.whole.frame
    }

    /// The samples that are looked at along x, y, z, of the whole lattice.
    pub fn part(&self) -> [Range<usize>; 3] {
        self.part.clone()
    }

    /// Whether not all samples are looked at.
    pub fn is_cropped(&self) -> bool {
        self.part.iter().zip(self.whole.dims()).any(|(part, n)| part.len() as u64 != n)
    }

    /// How many samples are looked at.
    pub fn count(&self) -> u64 {
        count(&self.part)
    }

    /// The lattice of the part alone, every sample where it was.
    pub fn part_grid(&self) -> Grid {
        let frame = frame_at(&self.whole.frame, &self.part);
        let dims = self.part.each_ref().map(|range| range.len() as u64);
        Grid::new(dims, frame).expect("a part of a lattice")
    }

    /// The box of the part in the world, and the world's axes.
    pub fn around(&self) -> (Aabb, Space) {
        (self.part_grid().bounds(), self.whole.frame.space)
    }
}

/// The samples of a box.
pub(crate) fn count(part: &[Range<usize>; 3]) -> u64 {
    part.iter().map(|range| range.len() as u64).product()
}

/// The frame of a part, whose samples stay where they are.
pub(super) fn frame_at(whole: &Frame, part: &[Range<usize>; 3]) -> Frame {
    // A sample of a lattice lies in finite space, or nobody would have built it.
    whole.starting_at(part.each_ref().map(|range| range.start)).unwrap_or(*whole)
}
