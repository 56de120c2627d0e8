//! The entries: a file described, a file read.

use super::{
    Described, FileSlices, VolumeInput, VolumeOptions, metaimage, nifti, npy, nrrd, place, raw,
    stored::{Order, Stored},
    vectors::Flow,
};
use crate::{Format, Place, ReadError, ReadFault, detect};
use isokit_geom::Frame;
use isokit_job::Job;
use isokit_volume::{AnyVolume, Dtype, Grid, Sample, Scaling, Volume, collect, for_dtype};
use std::path::{Path, PathBuf};

/// A file whose header was read and checked, and whose samples were not.
#[derive(Clone, Debug)]
pub struct VolumeFile {
    pub(super) path: PathBuf,
    /// Of all numbers.
    pub(super) grid: Grid,
    /// What is made of them, if they are vectors.
    pub(super) flow: Option<Flow>,
    pub(super) scaling: Scaling,
    pub(super) stored: Stored,
    /// Number of the volume's first sample among all that are stored.
    pub(super) first: u64,
    pub(super) job: Job,
    sample_unit: Option<String>,
    notes: Vec<String>,
}

/// Reads the volume in the file at `path`. Of a header and its data either may be named.
///
/// # Errors
///
/// If the file cannot be read, breaks its format, uses what we do not support, needs more memory than
/// the job allows, or is not what `options` say; if the job is cancelled.
pub fn read_volume(
    path: &Path,
    options: &VolumeOptions,
    job: &Job,
) -> Result<VolumeInput, ReadError> {
    let file = open_volume(path, options, job)?;
    let (format, notes) = (file.format(), file.notes.clone());
    Ok(VolumeInput { volume: file.collect(job)?, format, notes })
}

/// Reads and checks the header of the volume in the file at `path`, and no sample.
///
/// # Errors
///
/// As [`read_volume`]; memory for samples is not asked for yet.
pub fn open_volume(
    path: &Path,
    options: &VolumeOptions,
    job: &Job,
) -> Result<VolumeFile, ReadError> {
    describe(path, options)?.check(path, options, job)
}

/// What the header of a file says.
pub(super) fn describe(path: &Path, options: &VolumeOptions) -> Result<Described, ReadError> {
    match options.raw {
        Some(layout) => raw::describe(path, layout),
        None => match detect(path)? {
            Format::Nifti => nifti::describe(path),
            Format::Nrrd => nrrd::describe(path),
            Format::MetaImage => metaimage::describe(path),
            Format::Npy => npy::describe(path),
            Format::Raw => Err(raw::needs_layout(path)),
            mesh => {
                let fault = format!("this is a mesh ({mesh}), not a volume");
                Err(ReadFault::Caller(fault.into()).at(path))
            }
        },
    }
}

impl Described {
    /// What holds for every format: one volume chosen, a place in the world, and files as large as
    /// the header says.
    pub(super) fn check(
        self,
        path: &Path,
        options: &VolumeOptions,
        job: &Job,
    ) -> Result<VolumeFile, ReadError> {
        let at = |fault: ReadFault| fault.at(path);
        let (described, wanted) = self.of_numbers(options).map_err(at)?;
        let mut notes = described.notes;
        let index = chosen(described.volumes, options, &mut notes).map_err(at)?;
        let found = (described.affine, described.unit, described.space);
        let frame = place::frame(found, described.has_geometry, options, &mut notes).map_err(at)?;
        let grid = lattice(described.stored.format, described.dims, described.volumes, frame)
            .map_err(at)?;
        let flow = match wanted {
            Some(wanted) => Some(Flow::new(wanted, &grid, described.to_world.map_err(at)?)),
            None => None,
        };
        let per_file = grid.count() * described.volumes / described.stored.files.count().max(1);
        let stored = Stored { per_file, ..described.stored };
        let first = grid.count() * index;
        let path = path.to_owned();
        let mut file = VolumeFile {
            path,
            grid,
            flow,
            scaling: described.scaling,
            stored,
            first,
            job: job.clone(),
            sample_unit: described.sample_unit,
            notes,
        };
        file.check_files(job)?;
        Ok(file)
    }
}

/// Which volume to read.
fn chosen(
    volumes: u64,
    options: &VolumeOptions,
    notes: &mut Vec<String>,
) -> Result<u64, ReadFault> {
    match options.volume_index {
        Some(index) if index < volumes => Ok(index),
        Some(index) => {
            let fault = format!("volume {index} of {volumes} was asked for; they count from 0");
            Err(ReadFault::Caller(fault.into()))
        }
        None => {
            if volumes > 1 {
                let index = "--volume-index chooses another";
                notes
                    .push(format!("the file holds {volumes} volumes; the first is read ({index})"));
            }
            Ok(0)
        }
    }
}

/// The lattice, if all its volumes together can be counted.
fn lattice(format: Format, dims: [u64; 3], volumes: u64, frame: Frame) -> Result<Grid, ReadFault> {
    let broken = |found: String| {
        if format == Format::Raw {
            return ReadFault::Caller(found.into()); // no header says so, the caller does
        }
        let (place, expected) = (Place::Byte(0), "sizes that make a lattice".into());
        ReadFault::Broken { format, place, expected, found }
    };
    let grid = Grid::new(dims, frame).map_err(|error| broken(error.to_string()))?;
    match grid.count().checked_mul(volumes) {
        Some(count) if count > 0 => Ok(grid),
        _ => Err(broken(format!("{volumes} volumes of {} samples", grid.count()))),
    }
}

impl VolumeFile {
    /// The type of the samples; of a quantity of vectors, f32.
    pub fn dtype(&self) -> Dtype {
        if self.flow.is_some() { Dtype::F32 } else { self.stored.dtype }
    }

    /// Sizes and place of the lattice.
    pub fn grid(&self) -> &Grid {
        self.flow.as_ref().map_or(&self.grid, |flow| &flow.grid)
    }

    /// What a stored sample means.
    pub fn scaling(&self) -> Scaling {
        if self.flow.is_some() { Scaling::IDENTITY } else { self.scaling }
    }

    /// Whether the file holds vectors, of which a quantity is read.
    pub fn is_of_vectors(&self) -> bool {
        self.flow.is_some()
    }

    /// What values are in, in the file's own words, if it says so and they are what it speaks of: those of a
    /// derivative of vectors are not.
    pub fn sample_unit(&self) -> Option<&str> {
        let is_derived = self.flow.as_ref().is_some_and(Flow::is_derived);
        self.sample_unit.as_deref().filter(|_| !is_derived)
    }

    /// What the file is.
    pub fn format(&self) -> Format {
        self.stored.format
    }

    /// What was assumed, overridden or ignored, each a sentence for the user.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Whether the samples of a slice lie together, so that slices can be read one after another. Those
    /// of NPY files in Fortran order are spread over the whole file, and a quantity of vectors is made of
    /// all of them.
    pub fn has_slices(&self) -> bool {
        self.flow.is_none() && self.stored.order == Order::XFastest
    }

    /// The same file, read as part of another job.
    pub fn with_job(self, job: &Job) -> Self {
        Self { job: job.clone(), ..self }
    }

    /// The samples, slice by slice.
    ///
    /// # Errors
    ///
    /// If the samples are not of type `T`, or are made of vectors.
    pub fn into_source<T: Sample>(self) -> Result<FileSlices<T>, ReadError> {
        if self.flow.is_some() {
            let fault = "a quantity of vectors is made of all of them, not slice by slice";
            return Err(ReadFault::Caller(fault.into()).at(self.path));
        }
        if T::DTYPE == self.dtype() {
            return Ok(FileSlices::new(self));
        }
        let fault = format!("samples are {}, they were asked for as {}", self.dtype(), T::DTYPE);
        Err(ReadFault::Caller(fault.into()).at(self.path))
    }

    /// All samples, in memory.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, if the job's limit does not allow so much memory, or if the job
    /// is cancelled.
    pub fn collect(mut self, job: &Job) -> Result<AnyVolume, ReadError> {
        if let Some(flow) = self.flow.take() {
            return flow.collect(self, job);
        }
        let path = self.path.clone();
        let volume = for_dtype!(self.dtype(), T => self.collect_as::<T>(job).map(AnyVolume::from));
        volume.map_err(|error| match error.path.as_os_str().is_empty() {
            true => error.fault.at(path),
            false => error,
        })
    }

    fn collect_as<T: Sample>(self, job: &Job) -> Result<Volume<T>, ReadError> {
        let (grid, scaling, order) = (self.grid, self.scaling, self.stored.order);
        let mut source = self.with_job(job).into_source::<T>()?;
        if order == Order::XFastest {
            return collect(&mut source, job);
        }
        let samples = source.turn(job)?;
        let volume = Volume::new(grid, samples).expect("every plane was turned");
        Ok(volume.with_scaling(scaling))
    }

    /// Looks whether the files that hold the volume are there and large enough.
    fn check_files(&mut self, job: &Job) -> Result<(), ReadError> {
        let (stored, end) = (&self.stored, self.first + self.grid.count());
        for n in self.first / stored.per_file..end.div_ceil(stored.per_file) {
            job.check()?;
            let samples = stored.per_file.min(end - n * stored.per_file);
            let ignored = stored.check(n, samples, job)?;
            if ignored > 0 && stored.ends {
                return Err(raw::too_long(stored, ignored).at(&self.path));
            }
            if ignored > 0 {
                let name = stored.files.path(n);
                let name = name.file_name().unwrap_or_default().to_string_lossy();
                let note = format!("{ignored} bytes after the samples in {name} are ignored");
                self.notes.push(note);
            }
        }
        Ok(())
    }
}
