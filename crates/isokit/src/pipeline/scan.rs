//! A volume on its way to a mesh.

mod mesh;

use crate::pipeline::{
    Index, IsoChoice, Lattice, PipelineError, Region, RegionError, ScanFile, TargetSpace,
    UnknownSpace,
    attribute::source_of,
    index,
    iso::Facts,
    lattice::{count, frame_at},
};
use isokit_geom::{Aabb, Frame, Space};
use isokit_io::{BrickFile, Format, MeshContext, VolumeOptions};
use isokit_job::{Cancelled, Job, Stopped};
use isokit_volume::{
    AnyBricks, AnyVolume, Bricks, Histogram, Sample, Statistics, View, Volume, for_any, halved,
};
use std::{borrow::Cow, ops::Range, path::Path, sync::OnceLock};

/// A volume, the part of it that is looked at, and what was found out about that part so far.
#[derive(Clone, Debug)]
pub struct Scan {
    volume: AnyVolume,
    /// Which samples of the lattice those of the volume are.
    held: [Range<usize>; 3],
    /// Which of them were read; the others are 0.
    read: [Range<usize>; 3],
    /// Where the samples were before they were placed elsewhere.
    pub(super) source: Frame,
    lattice: Lattice,
    format: Option<Format>,
    notes: Vec<String>,
    /// Where an index of the whole volume is kept.
    index_file: Option<BrickFile>,
    /// Of all samples in memory.
    bricks: Option<AnyBricks>,
    part_bricks: OnceLock<AnyBricks>,
    statistics: OnceLock<Statistics>,
    histogram: OnceLock<Option<Histogram>>,
}

impl Scan {
    /// Reads a scan from a file, all of it, where the file says it is.
    ///
    /// # Errors
    ///
    /// If the file cannot be read.
    pub fn read(path: impl AsRef<Path>, job: &Job) -> Result<Self, PipelineError> {
        let (options, space) = (VolumeOptions::default(), TargetSpace::Source);
        Self::open(path.as_ref(), &options, space, &Region::Whole, job)
    }

    /// Reads a scan from a file, and of its samples those of the part. Whether it has the part, and axes that can be turned,
    /// is found out before they are read.
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
        ScanFile::open(path, options, space, region, job)?.read(job)
    }

    /// What was read of a file: the part of a lattice, and of that what was read.
    pub(super) fn of_file(
        mut volume: AnyVolume,
        (source, lattice, read): (Frame, Lattice, [Range<usize>; 3]),
        (format, notes, index_file): (Format, Vec<String>, Option<BrickFile>),
    ) -> Self {
        let held = lattice.part();
        volume.set_frame(frame_at(lattice.frame(), &held));
        let format = Some(format);
        Self { held, read, source, lattice, format, notes, index_file, ..Self::new(volume) }
    }

    /// Samples from elsewhere, all of them, where they are.
    pub fn new(volume: impl Into<AnyVolume>) -> Self {
        let volume = volume.into();
        let lattice = Lattice::new(*volume.grid(), &Region::Whole);
        let lattice = lattice.expect("all of a lattice is a part of it");
        Self {
            source: volume.grid().frame,
            held: lattice.part(),
            read: lattice.part(),
            volume,
            lattice,
            format: None,
            notes: vec![],
            index_file: None,
            bricks: None,
            part_bricks: OnceLock::new(),
            statistics: OnceLock::new(),
            histogram: OnceLock::new(),
        }
    }

    /// The same scan in another world.
    ///
    /// # Errors
    ///
    /// If RAS or LPS is wanted and the scan does not say which way its axes point.
    pub fn placed(mut self, space: TargetSpace) -> Result<Self, UnknownSpace> {
        let frame = space.place(*self.frame())?;
        self.lattice = self.lattice.placed(frame);
        self.volume.set_frame(frame_at(self.lattice.frame(), &self.held));
        Ok(self)
    }

    /// A part of the scan. Every sample stays where it was. What lies beyond is not looked at: near the part's border
    /// normals, and vertices that are not placed linearly, differ a little from those of the whole.
    ///
    /// # Errors
    ///
    /// If there is no such part, or if it was not read.
    pub fn cropped(self, region: &Region) -> Result<Self, RegionError> {
        let lattice = Lattice::new(*self.lattice.whole(), region)?;
        let part = lattice.part();
        let is_read =
            |k: usize| self.read[k].start <= part[k].start && part[k].end <= self.read[k].end;
        if !(0..3).all(is_read) {
            return Err(RegionError::Unread { part, read: self.read });
        }
        Ok(Self {
            read: part,
            lattice,
            part_bricks: OnceLock::new(),
            statistics: OnceLock::new(),
            histogram: OnceLock::new(),
            ..self
        })
    }

    /// The part that is looked at with fewer samples, [halved](isokit_volume::halved) so often along x, y, z; none if
    /// that is not once.
    ///
    /// # Errors
    ///
    /// If the job is cancelled or does not allow the samples' memory.
    ///
    /// # Panics
    ///
    /// If samples are so far apart that no [`Affine`](isokit_geom::Affine) has so many times their distance.
    pub fn halved(&self, mut halvings: [u32; 3], job: &Job) -> Result<Option<Self>, Stopped> {
        let mut coarse: Option<AnyVolume> = None;
        while halvings != [0; 3] {
            let axes = halvings.map(|left| left > 0);
            halvings = halvings.map(|left| left.saturating_sub(1));
            coarse = Some(match &coarse {
                None => for_any!(&self.volume, volume => halved(&self.view(volume), axes, job))?,
                Some(coarse) => for_any!(coarse, volume => halved(&volume.view(), axes, job))?,
            });
        }
        Ok(coarse.map(|volume| self.with_samples(volume)))
    }

    pub(super) fn with_samples(&self, volume: AnyVolume) -> Self {
        let new = Self::new(volume);
        let source = source_of(new.source, (self.frame(), &self.source));
        Self { format: self.format, notes: self.notes.clone(), source, ..new }
    }

    /// The samples in memory: all of the lattice, or the part of it that a file was read for.
    pub fn volume(&self) -> &AnyVolume {
        &self.volume
    }

    /// Where the samples are.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// The samples that are looked at along x, y, z, of the whole lattice.
    pub fn part(&self) -> [Range<usize>; 3] {
        self.lattice.part()
    }

    /// Those of them that were read; of others nothing is known.
    pub fn samples_read(&self) -> [Range<usize>; 3] {
        self.read.clone()
    }

    /// Whether not all samples are looked at.
    pub fn is_cropped(&self) -> bool {
        self.lattice.is_cropped()
    }

    /// Whether some of the samples that are looked at were not read.
    pub fn is_read_in_part(&self) -> bool {
        count(&self.read) < self.lattice.count()
    }

    /// Index space of the whole lattice to world space.
    pub fn frame(&self) -> &Frame {
        self.lattice.frame()
    }

    /// What a file says of the world of this scan's meshes, and of the command that made them.
    pub fn context(&self, command: impl Into<String>) -> MeshContext {
        let (unit, space) = (self.frame().unit, self.frame().space);
        MeshContext { unit, space, command: command.into(), gltf_unit: None }
    }

    /// What the file was, if there was one.
    pub fn format(&self) -> Option<Format> {
        self.format
    }

    /// What was assumed, overridden or ignored on reading, each a sentence for the user.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Range and NaN of the part, as far as it was read. Looked for once.
    ///
    /// # Errors
    ///
    /// If the job is cancelled.
    pub fn statistics(&self, job: &Job) -> Result<Statistics, Cancelled> {
        if let Some(known) = self.statistics.get() {
            return Ok(*known);
        }
        let found = for_any!(&self.volume, volume => {
            let view = self.seen(volume);
            // Ends that the index of the whole tells of a part may be farther off than its samples are.
            let bricks = self.bricks.as_ref().filter(|_| self.holds_all());
            let told = bricks.and_then(|bricks| index::statistics(bricks, &view));
            told.map_or_else(|| Statistics::of(&view, job), Ok)
        })?;
        Ok(*self.statistics.get_or_init(|| found))
    }

    /// How often each value occurs in the part, as far as it was read; `None` if none is finite. Counted once.
    ///
    /// # Errors
    ///
    /// If the job is cancelled.
    pub fn histogram(&self, job: &Job) -> Result<Option<&Histogram>, Cancelled> {
        if let Some(known) = self.histogram.get() {
            return Ok(known.as_ref());
        }
        let (statistics, found) = for_any!(&self.volume, volume => {
            Histogram::with_statistics(&self.seen(volume), self.statistics.get(), job)
        })?;
        self.statistics.get_or_init(|| statistics);
        Ok(self.histogram.get_or_init(|| found).as_ref())
    }

    /// Where in the part, of which `view` is, which values are. Found out once.
    pub(crate) fn part_bricks<T: Sample>(
        &self,
        view: &View<'_, T>,
        job: &Job,
    ) -> Result<&Bricks<T>, Stopped> {
        let known = match self.part_bricks.get() {
            Some(known) => known,
            None => {
                let found = Bricks::of(view, job)?.into();
                self.part_bricks.get_or_init(|| found)
            }
        };
        Ok(known.of().expect("the bricks of a scan are of its own samples"))
    }

    /// The isovalue that was meant.
    ///
    /// # Errors
    ///
    /// If the samples give none, or if the job is cancelled.
    pub fn iso(&self, choice: IsoChoice, job: &Job) -> Result<f64, PipelineError> {
        choice.find(self, job)
    }

    /// Finds out where in the volume which values occur, so that surfaces are made sooner: the same, byte
    /// for byte. Of a scan from a file that is kept in a file beside it, and read from there where it is
    /// of the volume as it is. It is of all samples in memory, whatever part is looked at now or later; so it is kept
    /// only if the whole volume was read.
    ///
    /// # Errors
    ///
    /// If the job is cancelled or allows less memory. That nothing could be kept is no error.
    pub fn index(&mut self, job: &Job) -> Result<Index, PipelineError> {
        let (bricks, found) = for_any!(&self.volume, volume => self.found_index(volume, job))?;
        self.bricks = Some(bricks);
        Ok(found)
    }

    fn found_index<T: Sample>(
        &self,
        volume: &Volume<T>,
        job: &Job,
    ) -> Result<(AnyBricks, Index), Stopped> {
        let make = || Bricks::of(&volume.view(), job);
        if self.holds_all() {
            return index::of(self.index_file.as_ref(), make);
        }
        let kept = |file: &BrickFile| {
            let bricks = file.read::<T>().ok()?.part(&self.held)?;
            Some((bricks.into(), Index::Read(file.path().to_owned())))
        };
        match self.index_file.as_ref().and_then(kept) {
            Some(found) => Ok(found),
            None => {
                let says = "of the volume only a part was read";
                Ok((make()?.into(), Index::NotKept(Some(says.into()))))
            }
        }
    }

    /// Whether all of the lattice is in memory.
    fn holds_all(&self) -> bool {
        self.volume.grid().dims() == self.lattice.whole().dims()
    }

    /// The box of the part in the world, and the world's axes.
    pub fn around(&self) -> (Aabb, Space) {
        self.lattice.around()
    }

    /// What an index tells of a part, where surfaces are sooner made with it.
    pub(super) fn known<'a, T: Sample>(
        &'a self,
        volume: &Volume<T>,
        part: &[Range<usize>; 3],
        isos: &[f64],
    ) -> Option<Cow<'a, Bricks<T>>> {
        let known = index::of_part(self.bricks.as_ref()?, &self.within(part))?;
        index::is_worth_it(&known, volume.scaling(), isos).then_some(known)
    }

    pub(crate) fn view<'a, T: Sample>(&self, volume: &'a Volume<T>) -> View<'a, T> {
        self.part_of(volume, &self.part())
    }

    /// What of the part was read.
    fn seen<'a, T: Sample>(&self, volume: &'a Volume<T>) -> View<'a, T> {
        self.part_of(volume, &self.read)
    }

    /// A part of the lattice, every sample where it is in the whole.
    pub(crate) fn part_of<'a, T: Sample>(
        &self,
        volume: &'a Volume<T>,
        part: &[Range<usize>; 3],
    ) -> View<'a, T> {
        let view = volume.view().part(self.within(part));
        let view = view.expect("the part was checked against the volume");
        view.with_frame(frame_at(self.frame(), part))
    }

    /// Where a part of the lattice is in memory.
    fn within(&self, part: &[Range<usize>; 3]) -> [Range<usize>; 3] {
        std::array::from_fn(|k| {
            let first = self.held[k].start;
            part[k].start - first..part[k].end - first
        })
    }
}

impl Facts for Scan {
    fn statistics(&self, job: &Job) -> Result<Statistics, PipelineError> {
        Ok(self.statistics(job)?)
    }

    fn histogram(&self, job: &Job) -> Result<Option<&Histogram>, PipelineError> {
        Ok(self.histogram(job)?)
    }
}

#[cfg(test)]
mod tests;
