//! A part of a volume in a file, and what of it is read.

use super::FileSlices;
use crate::{ReadError, ReadFault, VolumeFile};
use isokit_geom::Frame;
use isokit_job::Job;
use isokit_volume::{
    AnyVolume, Bricks, Grid, Sample, Scaling, SlabSource, Slices, Volume, collect, for_any,
    for_dtype,
};
use std::ops::Range;

/// The slices of a part of a volume in a file: [`VolumeFile::into_part`] makes it.
#[derive(Debug)]
pub struct PartSlices<T> {
    source: FileSlices<T>,
    grid: Grid,
    bricks: Option<Bricks<T>>,
    rows: [Range<usize>; 2],
}

impl<T> PartSlices<T> {
    /// The same with what is known of the part.
    pub fn with_bricks(self, bricks: Option<Bricks<T>>) -> Self {
        Self { bricks, ..self }
    }

    /// The same slices in another place of the world.
    pub fn at(mut self, frame: Frame) -> Self {
        self.grid.frame = frame;
        self
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
        let slice = self.rows.iter().map(ExactSizeIterator::len).product();
        let mut slices = slices.chunks_exact_mut(slice);
        slices.try_for_each(|slice| self.source.fill_part(&self.rows, slice))
    }

    fn fill_rows(&mut self, slice: &mut [T], rows: Range<usize>) -> Result<(), ReadError> {
        let [x, y] = self.rows.clone();
        let own = x.len() * rows.start..x.len() * rows.end;
        let rows = y.start + rows.start..y.start + rows.end;
        self.source.fill_part(&[x, rows], &mut slice[own])
    }
}

impl VolumeFile {
    /// The samples of a part along x, y, z, slice by slice. Every sample stays where it was.
    ///
    /// # Errors
    ///
    /// As [`into_source`](Self::into_source).
    ///
    /// # Panics
    ///
    /// If the volume has no such part.
    pub fn into_part<T: Sample>(self, part: [Range<u64>; 3]) -> Result<PartSlices<T>, ReadError> {
        let grid = part_of(self.grid(), &part);
        let [x, y, z] = part;
        let mut source = self.into_source()?;
        source.skip(z.start);
        Ok(PartSlices { source, grid, bricks: None, rows: [in_memory(x), in_memory(y)] })
    }

    /// A part of the volume along x, y, z, in memory, of which no more is read than what is wanted. Samples of the part that
    /// are not wanted are 0, and take no memory where the system gives none for what nobody wrote.
    ///
    /// Of rows and slices those that are not wanted are left out; packed files are unpacked up to the last one that is. A
    /// file in Fortran order and a quantity of vectors are read whole.
    ///
    /// # Errors
    ///
    /// As [`collect`](Self::collect).
    ///
    /// # Panics
    ///
    /// If the volume has no such part, or if what is wanted is not in it.
    pub fn collect_part(
        self,
        part: [Range<u64>; 3],
        wanted: [Range<u64>; 3],
        job: &Job,
    ) -> Result<AnyVolume, ReadError> {
        let all = self.grid().dims().map(|n| 0..n);
        let is_within = |k: usize| part[k].start <= wanted[k].start && wanted[k].end <= part[k].end;
        assert!((0..3).all(is_within), "{wanted:?} of {part:?}");
        if part == all && wanted == all {
            return self.collect(job);
        }
        let (path, grid) = (self.path.clone(), part_of(self.grid(), &part));
        let at = |error: ReadError| match error.path.as_os_str().is_empty() {
            true => error.fault.at(&path),
            false => error,
        };
        if !self.has_slices() {
            let whole = self.collect(job)?;
            return for_any!(&whole, volume => {
                let view = volume.view().part(part.map(in_memory)).expect("a part of the volume");
                let stopped = |stopped| ReadFault::from(stopped).at(&path);
                collect(&mut Slices::new(view), job).map(AnyVolume::from).map_err(stopped)
            });
        }
        let volume = for_dtype!(self.dtype(), T => {
            let source = self.with_job(job).into_part::<T>(wanted.clone());
            source.and_then(|mut source| match wanted == part {
                true => collect(&mut source, job),
                false => spread(&mut source, (grid, &part, &wanted), job),
            })
            .map(AnyVolume::from)
        });
        volume.map_err(at)
    }
}

/// What a source has, where it is in a part, and 0 elsewhere.
fn spread<T: Sample>(
    source: &mut PartSlices<T>,
    (grid, part, wanted): (Grid, &[Range<u64>; 3], &[Range<u64>; 3]),
    job: &Job,
) -> Result<Volume<T>, ReadError> {
    let mut samples: Vec<T> = job.limits.zeroed("volume", Some(grid.count()))?;
    let [nx, ny, _] = grid.dims().map(|n| n as usize);
    let [x, y, z]: [Range<usize>; 3] = std::array::from_fn(|k| {
        in_memory(wanted[k].start - part[k].start..wanted[k].end - part[k].start)
    });
    let is_whole = x.len() == nx;
    let mut scratch: Vec<T> = vec![];
    job.progress.begin("read", z.len() as u64);
    for k in z {
        job.check()?;
        let rows = &mut samples[nx * (y.start + ny * k)..][..nx * y.len()];
        if is_whole {
            source.fill(rows)?;
        } else {
            scratch.resize(x.len() * y.len(), T::default());
            source.fill(&mut scratch)?;
            for (row, read) in rows.chunks_exact_mut(nx).zip(scratch.chunks_exact(x.len())) {
                row[x.clone()].copy_from_slice(read);
            }
        }
        job.progress.advance(1);
    }
    let volume = Volume::new(grid, samples).expect("a sample for each lattice point");
    Ok(volume.with_scaling(source.scaling()))
}

/// The lattice of a part, every sample where it was.
fn part_of(whole: &Grid, part: &[Range<u64>; 3]) -> Grid {
    let start = part.each_ref().map(|range| range.start as usize);
    // A sample of the volume lies in finite space, or its file would have been refused.
    let frame: Frame = whole.frame.starting_at(start).unwrap_or(whole.frame);
    let is_part = (0..3).all(|k| part[k].end <= whole.dims()[k]);
    let dims = part.each_ref().map(|range| range.end.saturating_sub(range.start));
    Grid::new(dims, frame).ok().filter(|_| is_part).expect("a part of the volume")
}

/// What is read is numbered by memory's address space.
fn in_memory(range: Range<u64>) -> Range<usize> {
    range.start as usize..range.end as usize
}

#[cfg(test)]
mod tests;
