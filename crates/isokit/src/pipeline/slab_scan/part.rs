//! The slices of a part of a volume in a file.

use isokit_io::{FileSlices, ReadError};
use isokit_volume::{Bricks, Grid, Sample, Scaling, SlabSource};
use std::ops::Range;

/// Slices without the samples that are not looked at.
pub(super) struct PartSlices<T> {
    source: FileSlices<T>,
    /// The lattice of the part.
    grid: Grid,
    bricks: Option<Bricks<T>>,
    rows: [Range<usize>; 2],
    /// A whole slice, where its rows are cut.
    whole: Vec<T>,
}

impl<T: Sample> PartSlices<T> {
    pub(super) fn new(mut source: FileSlices<T>, grid: Grid, part: [Range<usize>; 3]) -> Self {
        let [x, y, z] = part;
        source.skip(z.start as u64);
        Self { source, grid, bricks: None, rows: [x, y], whole: vec![] }
    }

    /// The same with what is known of the part.
    pub(super) fn with_bricks(self, bricks: Option<Bricks<T>>) -> Self {
        Self { bricks, ..self }
    }
}

impl<T: Sample> SlabSource<T> for PartSlices<T> {
    type Error = ReadError;

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn scaling(&self) -> Scaling {
        self.source.scaling()
    }

    fn bricks(&self) -> Option<&Bricks<T>> {
        self.bricks.as_ref()
    }

    fn fill(&mut self, slices: &mut [T]) -> Result<(), ReadError> {
        let [all_x, all_y, _] = self.source.grid().dims().map(|n| n as usize);
        let [x, y] = self.rows.clone();
        if (x.len(), y.len()) == (all_x, all_y) {
            return self.source.fill(slices);
        }
        self.whole.resize(all_x * all_y, T::default());
        for slice in slices.chunks_exact_mut(x.len() * y.len()) {
            self.source.fill(&mut self.whole)?;
            let rows = self.whole.chunks_exact(all_x).skip(y.start);
            for (row, whole) in slice.chunks_exact_mut(x.len()).zip(rows) {
                row.copy_from_slice(&whole[x.clone()]);
            }
        }
        Ok(())
    }

    fn fill_rows(&mut self, slice: &mut [T], rows: Range<usize>) -> Result<(), ReadError> {
        let [all_x, all_y, _] = self.source.grid().dims().map(|n| n as usize);
        let [x, y] = self.rows.clone();
        if (x.len(), y.len()) == (all_x, all_y) {
            return self.source.fill_rows(slice, rows);
        }
        self.whole.resize(all_x * all_y, T::default());
        let in_whole = y.start + rows.start..y.start + rows.end;
        self.source.fill_rows(&mut self.whole, in_whole.clone())?;
        for (row, j) in rows.zip(in_whole) {
            let own = &mut slice[x.len() * row..x.len() * (row + 1)];
            own.copy_from_slice(&self.whole[all_x * j..][x.clone()]);
        }
        Ok(())
    }
}
