//! A volume on its way to a mesh.

use crate::pipeline::{
    Index, IsoChoice, Normals, PipelineError, Region, RegionError, Remark, SurfaceOptions,
    TargetSpace, UnknownSpace, attribute::source_of, error::in_whole, index, iso::Facts,
};
use isokit_geom::{Aabb, Frame, Space};
use isokit_io::{BrickFile, Format, MeshContext, VolumeOptions, open_volume};
use isokit_job::{Cancelled, Job, Stopped};
use isokit_marching_cubes::{Extracted, Source, extract_many};
use isokit_mesh::{Counts, TriMesh, area_normals};
use isokit_volume::{
    AnyBricks, AnyVolume, Bricks, Histogram, Sample, Statistics, View, Volume, for_any, halved,
};
use std::{borrow::Cow, ops::Range, path::Path, slice, sync::OnceLock};

/// A volume, the part of it that is looked at, and what was found out about that part so far.
#[derive(Clone, Debug)]
pub struct Scan {
    volume: AnyVolume,
    /// Where the samples were before they were placed elsewhere.
    pub(super) source: Frame,
    part: [Range<usize>; 3],
    format: Option<Format>,
    notes: Vec<String>,
    /// Where an index of the whole volume is kept.
    index_file: Option<BrickFile>,
    /// Of the whole volume.
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

    /// Reads a scan from a file. Whether it has the part, and axes that can be turned, is found out
    /// before the samples are read.
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
        let mut grid = *file.grid();
        grid.frame = space.place(grid.frame)?;
        region.samples(&grid)?;
        let (format, notes) = (file.format(), file.notes().to_vec());
        let index_file = file.bricks().ok();
        let scan = Self::new(file.collect(job)?).placed(space)?.cropped(region)?;
        Ok(Self { format: Some(format), notes, index_file, ..scan })
    }

    /// Samples from elsewhere, all of them, where they are.
    pub fn new(volume: impl Into<AnyVolume>) -> Self {
        let volume = volume.into();
        // What is in memory is numbered by its address space.
        let part = volume.grid().dims().map(|n| 0..n as usize);
        Self {
            source: volume.grid().frame,
            volume,
            part,
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
        self.volume.set_frame(space.place(self.volume.grid().frame)?);
        Ok(self)
    }

    /// A part of the scan. Every sample stays where it was. What lies beyond is not looked at: near the part's border
    /// normals, and vertices that are not placed linearly, differ a little from those of the whole.
    ///
    /// # Errors
    ///
    /// If there is no such part.
    pub fn cropped(self, region: &Region) -> Result<Self, RegionError> {
        let part = region.samples(self.volume.grid())?;
        let part = part.map(|range| range.start as usize..range.end as usize);
        Ok(Self {
            part,
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

    /// The whole volume, of which a part may be looked at.
    pub fn volume(&self) -> &AnyVolume {
        &self.volume
    }

    /// The samples that are looked at, along x, y, z.
    pub fn part(&self) -> [Range<usize>; 3] {
        self.part.clone()
    }

    /// Whether not all samples are looked at.
    pub fn is_cropped(&self) -> bool {
        self.part.iter().zip(self.volume.grid().dims()).any(|(part, n)| part.len() as u64 != n)
    }

    /// Index space of the whole volume to world space.
    pub fn frame(&self) -> &Frame {
        &self.volume.grid().frame
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

    /// Range and NaN of the part. Looked for once.
    ///
    /// # Errors
    ///
    /// If the job is cancelled.
    pub fn statistics(&self, job: &Job) -> Result<Statistics, Cancelled> {
        if let Some(known) = self.statistics.get() {
            return Ok(*known);
        }
        let found = for_any!(&self.volume, volume => {
            let view = self.view(volume);
            let told = self.bricks.as_ref().and_then(|bricks| index::statistics(bricks, &view));
            told.map_or_else(|| Statistics::of(&view, job), Ok)
        })?;
        Ok(*self.statistics.get_or_init(|| found))
    }

    /// How often each value occurs in the part; `None` if none is finite. Counted once.
    ///
    /// # Errors
    ///
    /// If the job is cancelled.
    pub fn histogram(&self, job: &Job) -> Result<Option<&Histogram>, Cancelled> {
        if let Some(known) = self.histogram.get() {
            return Ok(known.as_ref());
        }
        let (statistics, found) = for_any!(&self.volume, volume => {
            Histogram::with_statistics(&self.view(volume), self.statistics.get(), job)
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
    /// of the volume as it is. It is of all of the volume, whatever part is looked at now or later.
    ///
    /// # Errors
    ///
    /// If the job is cancelled or allows less memory. That nothing could be kept is no error.
    pub fn index(&mut self, job: &Job) -> Result<Index, PipelineError> {
        let (bricks, found) = for_any!(&self.volume, volume => {
            index::of(self.index_file.as_ref(), || Bricks::of(&volume.view(), job))
        })?;
        self.bricks = Some(bricks);
        Ok(found)
    }

    /// The surface where the value is `iso`.
    ///
    /// # Errors
    ///
    /// If the isovalue is not finite, if there is NaN and the options forbid it, if 32 bits cannot
    /// number the vertices, or if the job is cancelled or allows less memory.
    pub fn mesh(
        &self,
        iso: f64,
        options: &SurfaceOptions,
        job: &Job,
    ) -> Result<TriMesh, PipelineError> {
        let mut mesh = TriMesh::default();
        self.mesh_into(iso, options, &mut mesh, job)?;
        Ok(mesh)
    }

    /// The same in the memory of a used mesh.
    ///
    /// # Errors
    ///
    /// As [`mesh`](Self::mesh).
    pub fn mesh_into(
        &self,
        iso: f64,
        options: &SurfaceOptions,
        mesh: &mut TriMesh,
        job: &Job,
    ) -> Result<(), PipelineError> {
        self.meshes_into(&[iso], options, slice::from_mut(mesh), job).map(drop)
    }

    /// The surfaces of several isovalues, for which the samples are classified once, each in the memory
    /// of a used mesh. What comes back says too what an index told not to do; an index by which the
    /// surfaces go through more than a sixteenth of the part is left aside, for then to ask it takes longer.
    ///
    /// # Errors
    ///
    /// As [`mesh`](Self::mesh).
    ///
    /// # Panics
    ///
    /// If there are not as many meshes as isovalues.
    pub fn meshes_into(
        &self,
        isos: &[f64],
        options: &SurfaceOptions,
        meshes: &mut [TriMesh],
        job: &Job,
    ) -> Result<Vec<Extracted>, PipelineError> {
        self.meshes_of_part(&self.part, isos, options, meshes, job)
    }

    /// The same in a part of the whole volume, which must have it.
    pub(crate) fn meshes_of_part(
        &self,
        part: &[Range<usize>; 3],
        isos: &[f64],
        options: &SurfaceOptions,
        meshes: &mut [TriMesh],
        job: &Job,
    ) -> Result<Vec<Extracted>, PipelineError> {
        for mesh in &mut *meshes {
            match options.normals {
                Normals::Gradient => drop(mesh.normals.get_or_insert_default()),
                Normals::Area | Normals::None => mesh.normals = None,
            }
        }
        let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
        let extracted = for_any!(&self.volume, volume => {
            let view = part_of(volume, part);
            let known = self.known(volume, part, isos);
            let source = known.as_deref().and_then(|bricks| Source::with_bricks(&view, bricks));
            let source = source.unwrap_or(Source::from(&view));
            extract_many(source, isos, &options.extract, &mut sinks, job)
        });
        let mut extracted = extracted.map_err(|error| in_whole(error, part))?;
        drop(sinks);
        if options.normals == Normals::Area {
            meshes.iter_mut().try_for_each(|mesh| area_normals(mesh, job))?;
        }
        if self.bricks.is_some() {
            // Of an index that was left aside no brick is skipped.
            let bricks = index::bricks_of_part(self.volume.grid().dims(), part);
            extracted.iter_mut().for_each(|one| one.skipped.bricks = bricks);
        }
        Ok(extracted)
    }

    /// What is peculiar about a surface of so many vertices and triangles, if anything. Looks at the
    /// samples only where the counts raise the question.
    ///
    /// # Errors
    ///
    /// If the job is cancelled.
    pub fn remark(
        &self,
        iso: f64,
        counts: Counts,
        options: &SurfaceOptions,
        job: &Job,
    ) -> Result<Option<Remark>, PipelineError> {
        let dims = self.part.each_ref().map(|range| range.len());
        Remark::among(self, dims, (iso, counts), options, job)
    }

    /// The box of the part in the world, and the world's axes.
    pub fn around(&self) -> (Aabb, Space) {
        (for_any!(&self.volume, volume => self.view(volume).grid().bounds()), self.frame().space)
    }

    /// What an index tells of a part, where surfaces are sooner made with it.
    pub(super) fn known<'a, T: Sample>(
        &'a self,
        volume: &Volume<T>,
        part: &[Range<usize>; 3],
        isos: &[f64],
    ) -> Option<Cow<'a, Bricks<T>>> {
        let known = index::of_part(self.bricks.as_ref()?, part)?;
        index::is_worth_it(&known, volume.scaling(), isos).then_some(known)
    }

    pub(crate) fn view<'a, T: Sample>(&self, volume: &'a Volume<T>) -> View<'a, T> {
        part_of(volume, &self.part)
    }
}

fn part_of<'a, T: Sample>(volume: &'a Volume<T>, part: &[Range<usize>; 3]) -> View<'a, T> {
    volume.view().part(part.clone()).expect("the part was checked against the volume")
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
