//! A scan in a file, of which no sample was read.

use crate::pipeline::{Lattice, PipelineError, Region, Scan, SlabScan, TargetSpace};
use isokit_geom::Frame;
use isokit_io::{Format, VolumeFile, VolumeOptions, open_volume};
use isokit_job::Job;
use isokit_volume::{Bricks, Dtype, Sample, Scaling, for_dtype};
use std::{ops::Range, path::Path};

/// The header of a scan: enough to know where its samples are, and to read those that are needed.
#[derive(Clone, Debug)]
pub struct ScanFile {
    pub(super) file: VolumeFile,
    /// Where the samples are before they are placed elsewhere.
    source: Frame,
    pub(super) lattice: Lattice,
}

impl ScanFile {
    /// Opens a scan in a file. Whether it has the part, and axes that can be turned, is found out here.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or is not what the caller thinks it is.
    pub fn open(
        path: &Path,
        options: &VolumeOptions,
        space: TargetSpace,
        region: &Region,
        job: &Job,
    ) -> Result<Self, PipelineError> {
        let file = open_volume(path, options, job)?;
        let (mut whole, source) = (*file.grid(), file.grid().frame);
        whole.frame = space.place(source)?;
        let lattice = Lattice::new(whole, region)?;
        Ok(Self { file, source, lattice })
    }

    /// Where the samples are.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// The type of the samples.
    pub fn dtype(&self) -> Dtype {
        self.file.dtype()
    }

    /// What a stored sample means.
    pub fn scaling(&self) -> Scaling {
        self.file.scaling()
    }

    /// What the file is.
    pub fn format(&self) -> Format {
        self.file.format()
    }

    /// What was assumed, overridden or ignored, each a sentence for the user.
    pub fn notes(&self) -> &[String] {
        self.file.notes()
    }

    /// Whether some of the samples can be read without the others. Those of NPY files in Fortran order are spread over the
    /// whole file, and a quantity of vectors is made of all of them.
    pub fn has_slices(&self) -> bool {
        self.file.has_slices()
    }

    /// Whether an [index](Scan::index) of the volume as it is lies beside the file. Without one, all of the volume has to be
    /// read to make it, whatever part is looked at.
    pub fn has_index(&self) -> bool {
        let Ok(file) = self.file.bricks() else { return false };
        for_dtype!(self.dtype(), T => file.read::<T>().is_ok())
    }

    /// Where in the scan which values are, if all of it is looked at and an [index](Scan::index) of it is kept beside the
    /// file.
    pub(crate) fn bricks<T: Sample>(&self) -> Option<Bricks<T>> {
        let file = self.file.bricks().ok().filter(|_| !self.lattice.is_cropped());
        file.and_then(|file| file.read().ok())
    }

    /// The scan left in its file; none if some samples cannot be read without the others.
    pub fn into_slabs(self) -> Option<SlabScan> {
        self.has_slices().then(|| SlabScan::of(self))
    }

    /// The scan with the samples of the part in memory, and no others.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or the job is cancelled or allows less memory.
    pub fn read(self, job: &Job) -> Result<Scan, PipelineError> {
        let part = self.lattice.part();
        self.read_wanted(&part, job)
    }

    /// The same, but of the samples only those that are wanted are read. The others are 0, and count for nothing in
    /// statistics; so it is of use where nothing depends on them, as pictures of a [`Scene`](crate::scene::Scene) do not.
    ///
    /// # Errors
    ///
    /// As [`read`](Self::read).
    ///
    /// # Panics
    ///
    /// If what is wanted is not in the part.
    pub fn read_wanted(self, wanted: &[Range<usize>; 3], job: &Job) -> Result<Scan, PipelineError> {
        let Self { file, source, lattice } = self;
        let (format, notes) = (file.format(), file.notes().to_vec());
        // An index tells nothing of what is 0 here.
        let index_file = file.bricks().ok().filter(|_| *wanted == lattice.part());
        let [part, read] = [&lattice.part(), wanted]
            .map(|ranges| ranges.each_ref().map(|range| range.start as u64..range.end as u64));
        let has_slices = file.has_slices();
        let volume = file.collect_part(part, read, job)?;
        let read = if has_slices { wanted.clone() } else { lattice.part() };
        Ok(Scan::of_file(volume, (source, lattice, read), (format, notes, index_file)))
    }
}

#[cfg(test)]
mod tests;
