//! A volume on its way to a mesh, of which a few slices are in memory at a time.

use crate::pipeline::{
    Index, IsoChoice, Normals, PipelineError, Region, Remark, ScanFile, SurfaceOptions,
    TargetSpace, error::of_slabs, index, iso::Facts,
};
use isokit_geom::Frame;
use isokit_io::{Format, MeshContext, PartSlices, ReadError, ReadFault, VolumeOptions};
use isokit_job::{Job, OverLimit};
use isokit_marching_cubes::{Budget, Extracted, Slabs, extract_slabs};
use isokit_mesh::{Counts, MeshSinks, TriMesh};
use isokit_volume::{
    AnyBricks, BrickGrid, Bricks, Dtype, Grid, Histogram, Observed, Sample, Scaling, Statistics,
    for_dtype,
};
use std::{borrow::Cow, ops::Range, path::Path, sync::OnceLock};

/// A [`Scan`](crate::pipeline::Scan) that stays in its file: each look at the samples reads them again.
/// Meshes are the same.
#[derive(Clone, Debug)]
pub struct SlabScan {
    scan: ScanFile,
    /// Whether extractions look for range and NaN by the way.
    is_observed: bool,
    /// Of the whole lattice.
    bricks: Option<AnyBricks>,
    statistics: OnceLock<Statistics>,
    histogram: OnceLock<Option<Histogram>>,
}

impl SlabScan {
    /// Opens a scan in a file, and reads no sample.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, is not what the caller thinks it is, or has no slices that could be
    /// read one after another.
    pub fn open(
        path: &Path,
        options: &VolumeOptions,
        space: TargetSpace,
        region: &Region,
        job: &Job,
    ) -> Result<Self, PipelineError> {
        let scan = ScanFile::open(path, options, space, region, job)?;
        if scan.file.is_of_vectors() {
            let says = "a quantity of vectors is made of all of them: read the volume into memory, or convert it first";
            return Err(ReadFault::Caller(says.into()).at(path).into());
        }
        if !scan.has_slices() {
            let says = "the samples are z fastest (Fortran order), so no slice can be read alone: \
                        convert the file to .nrrd first, or read all of it into memory";
            return Err(ReadFault::Caller(says.into()).at(path).into());
        }
        Ok(Self::of(scan))
    }

    /// A scan that [has slices](ScanFile::has_slices).
    pub(super) fn of(scan: ScanFile) -> Self {
        let (statistics, histogram) = (OnceLock::new(), OnceLock::new());
        Self { scan, is_observed: false, bricks: None, statistics, histogram }
    }

    /// The same scan, with range and NaN looked for by the way in the next extraction, unless an [index](Self::index) tells
    /// it what not to read.
    pub fn observed(self) -> Self {
        Self { is_observed: true, ..self }
    }

    /// The whole lattice, of which a part may be looked at.
    pub fn grid(&self) -> &Grid {
        self.scan.lattice.whole()
    }

    /// The type of the samples.
    pub fn dtype(&self) -> Dtype {
        self.scan.dtype()
    }

    /// What a stored sample means.
    pub fn scaling(&self) -> Scaling {
        self.scan.scaling()
    }

    /// The samples that are looked at, along x, y, z.
    pub fn part(&self) -> [Range<usize>; 3] {
        self.scan.lattice.part()
    }

    /// Whether not all samples are looked at.
    pub fn is_cropped(&self) -> bool {
        self.scan.lattice.is_cropped()
    }

    /// Index space of the whole volume to world space.
    pub fn frame(&self) -> &Frame {
        self.scan.lattice.frame()
    }

    /// What a file says of the world of this scan's meshes, and of the command that made them.
    pub fn context(&self, command: impl Into<String>) -> MeshContext {
        let (unit, space) = (self.frame().unit, self.frame().space);
        MeshContext { unit, space, command: command.into(), gltf_unit: None }
    }

    /// What the file is.
    pub fn format(&self) -> Format {
        self.scan.format()
    }

    /// What was assumed, overridden or ignored, each a sentence for the user.
    pub fn notes(&self) -> &[String] {
        self.scan.notes()
    }

    /// Range and NaN of the part. Looked for once.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or the job is cancelled.
    pub fn statistics(&self, job: &Job) -> Result<Statistics, PipelineError> {
        if let Some(known) = self.statistics.get() {
            return Ok(*known);
        }
        let told = for_dtype!(self.dtype(), T => self.told::<T>());
        if let Some(told) = told {
            return Ok(*self.statistics.get_or_init(|| told));
        }
        let found = for_dtype!(self.dtype(), T => {
            Statistics::of_slices(self.source::<T>(job)?, job)
        })?;
        Ok(*self.statistics.get_or_init(|| found))
    }

    /// Whether range and NaN of the part are known, without a look at samples.
    pub fn has_statistics(&self) -> bool {
        self.statistics.get().is_some() || for_dtype!(self.dtype(), T => self.told::<T>()).is_some()
    }

    /// How often each value occurs in the part; `None` if none is finite. Counted once.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or the job is cancelled.
    pub fn histogram(&self, job: &Job) -> Result<Option<&Histogram>, PipelineError> {
        if let Some(known) = self.histogram.get() {
            return Ok(known.as_ref());
        }
        let range = self.statistics(job)?;
        let found = for_dtype!(self.dtype(), T => {
            Histogram::of_slices(|| self.source::<T>(job), &range, job)
        })?;
        Ok(self.histogram.get_or_init(|| found).as_ref())
    }

    /// The isovalue that was meant.
    ///
    /// # Errors
    ///
    /// If the samples give none, if the file cannot be read, or if the job is cancelled.
    pub fn iso(&self, choice: IsoChoice, job: &Job) -> Result<f64, PipelineError> {
        choice.find(self, job)
    }

    /// Finds out where in the volume which values occur, as [`Scan::index`](crate::pipeline::Scan::index) does: from the
    /// file beside it, or else with a pass over all samples. Extractions then read only the rows of slices around the
    /// surfaces; of a packed file what lies between them is unpacked, and not looked at.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or the job is cancelled or allows less memory. That nothing could be kept is
    /// no error.
    pub fn index(&mut self, job: &Job) -> Result<Index, PipelineError> {
        let kept = self.scan.file.bricks().ok();
        let (bricks, found) = for_dtype!(self.dtype(), T => index::of(kept.as_ref(), || {
            Bricks::of_slices(self.scan.file.clone().with_job(job).into_source::<T>()?, job)
        }))?;
        self.bricks = Some(bricks);
        Ok(found)
    }

    /// The same where such a file is there and is of the volume as it is. None, and no sample read, if not.
    pub fn kept_index(&mut self) -> Option<Index> {
        let file = self.scan.file.bricks().ok()?;
        self.bricks = Some(for_dtype!(self.dtype(), T => file.read::<T>().ok()?.into()));
        Some(Index::Read(file.path().to_owned()))
    }

    /// Whether an [index](Self::index) tells that surfaces go through so few bricks, an eighth at the most, that they are
    /// sooner made with it.
    pub fn is_sparse(&self, isos: &[f64]) -> bool {
        let Some(bricks) = &self.bricks else { return false };
        for_dtype!(self.dtype(), T => {
            let known = index::of_part::<T>(bricks, &self.part());
            known.is_some_and(|known| index::is_worth_it(&known, self.scaling(), isos))
        })
    }

    /// Bytes that an index and its use take at the most.
    pub fn index_bytes(&self) -> u64 {
        // Least, greatest and NaN: of the whole, of the part, of slices, and while they come from a file.
        let per_brick = 12 * self.dtype().bytes() as u64 + 16;
        let dims = self.grid().dims().map(|n| usize::try_from(n).unwrap_or(usize::MAX));
        BrickGrid::new(dims)
            .count()
            .and_then(|count| count.checked_mul(per_brick))
            .unwrap_or(u64::MAX)
    }

    /// What of an extraction is in memory at a time, for so many bytes in all, where the sinks take
    /// `pieces` times the bytes of a piece. What an [index](Self::index_bytes) takes comes on top of that.
    ///
    /// # Errors
    ///
    /// If those do not suffice. What is needed then suffices.
    pub fn budget(
        &self,
        bytes: u64,
        (surfaces, pieces): (u64, u64),
        options: &SurfaceOptions,
    ) -> Result<Budget, OverLimit> {
        // Of a file whose rows are cut off, one slice is read whole.
        let slice = match self.is_row_cut() {
            true => self.grid().slice_count().saturating_mul(self.dtype().bytes() as u64),
            false => 0,
        };
        let of = (&self.scan.lattice.part_grid(), self.dtype());
        let left = bytes.saturating_sub(slice);
        Budget::within(left, of, (surfaces, pieces), &options.extract).map_err(|over| OverLimit {
            needed: over.needed.saturating_add(slice),
            limit: bytes,
            ..over
        })
    }

    /// The surfaces where the value is one of `isos`, each handed to its sink piece by piece, in one pass
    /// over the file. [`Normals::Area`] are made as if there were to be none: whoever has the whole mesh
    /// can add them.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, if a sink fails, and as [`Scan::mesh`](crate::pipeline::Scan::mesh).
    pub fn meshes_into<S>(
        &self,
        isos: &[f64],
        options: &SurfaceOptions,
        budget: Budget,
        sinks: &mut S,
        job: &Job,
    ) -> Result<Vec<Extracted>, PipelineError>
    where
        S: MeshSinks<Error: Into<PipelineError> + Send> + Send,
    {
        let slabs = Slabs { isos, options: &options.extract, budget };
        let found = for_dtype!(self.dtype(), T => {
            let known = self.bricks.as_ref().and_then(|bricks| index::of_part(bricks, &self.part()));
            let known = known.map(Cow::into_owned);
            let mut source = self.source::<T>(job)?.with_bricks(known);
            if self.bricks.is_none() && self.is_observed && self.statistics.get().is_none() {
                let mut source = Observed::new(source, job);
                let found = extract_slabs(&mut source, &slabs, sinks, job);
                if found.is_ok() {
                    self.statistics.get_or_init(|| source.statistics());
                }
                found
            } else {
                extract_slabs(&mut source, &slabs, sinks, job)
            }
        });
        let mut found = found.map_err(|error| of_slabs(error, &self.part()))?;
        if let Some(bricks) = &self.bricks {
            // Of an index that was left aside no brick is skipped.
            let bricks = index::bricks_of_part(bricks, &self.part());
            found.iter_mut().for_each(|one| one.skipped.bricks = bricks);
        }
        Ok(found)
    }

    /// The same into meshes, each in the memory of a used one, with the normals that are wanted. As many slices are held at a
    /// time as make it fast.
    ///
    /// # Errors
    ///
    /// As [`meshes_into`](Self::meshes_into).
    ///
    /// # Panics
    ///
    /// If there are fewer meshes than isovalues.
    pub fn whole_meshes_into(
        &self,
        isos: &[f64],
        options: &SurfaceOptions,
        meshes: &mut [TriMesh],
        job: &Job,
    ) -> Result<Vec<Extracted>, PipelineError> {
        let budget = self.budget(u64::MAX, (isos.len() as u64, 1), options)?;
        let budget = Budget { piece_bytes: u64::MAX, ..budget };
        options.fill(meshes, job, |sinks| self.meshes_into(isos, options, budget, sinks, job))
    }

    /// Range and NaN, if an index tells them.
    fn told<T: Sample>(&self) -> Option<Statistics> {
        let bricks = self.bricks.as_ref().filter(|_| !self.is_cropped())?;
        Statistics::of_bricks(bricks.of::<T>()?, self.scaling())
    }

    /// What is peculiar about a surface of so many vertices and triangles, if anything. Looks at the
    /// samples only where the counts raise the question and nobody looked before.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or the job is cancelled.
    pub fn remark(
        &self,
        iso: f64,
        counts: Counts,
        options: &SurfaceOptions,
        job: &Job,
    ) -> Result<Option<Remark>, PipelineError> {
        let dims = self.part().map(|range| range.len());
        Remark::among(self, dims, (iso, counts), options, job)
    }

    /// Whether sinks are asked for normals.
    pub fn has_normals(options: &SurfaceOptions) -> bool {
        options.normals == Normals::Gradient
    }

    fn is_row_cut(&self) -> bool {
        let ([nx, ny, _], [x, y, _]) = (self.grid().dims(), self.part());
        [x.len() as u64, y.len() as u64] != [nx, ny]
    }

    fn source<T: Sample>(&self, job: &Job) -> Result<PartSlices<T>, ReadError> {
        let part = self.part().map(|range| range.start as u64..range.end as u64);
        let slices = self.scan.file.clone().with_job(job).into_part(part)?;
        Ok(slices.at(self.scan.lattice.part_grid().frame))
    }
}

impl Facts for SlabScan {
    fn statistics(&self, job: &Job) -> Result<Statistics, PipelineError> {
        self.statistics(job)
    }

    fn histogram(&self, job: &Job) -> Result<Option<&Histogram>, PipelineError> {
        self.histogram(job)
    }
}
