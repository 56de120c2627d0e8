//! Writing a volume: the format chosen by the name, samples little-endian.
//!
//! NRRD, NPY and raw cannot say that a stored sample means another value. A scaled volume is written
//! to them as its values, in f64: those are the very numbers that an isovalue is compared with, and
//! none is rounded. NIfTI keeps stored samples and scaling.

use super::{nifti, npy, nrrd};
use crate::{Output, WriteError, WriteFault};
use flate2::{Compression, write::GzEncoder};
use isokit_job::Job;
use isokit_volume::{AnyVolume, ColorVolume, Dtype, Grid, Sample, Volume, for_any};
use std::{
    io::Write,
    path::{Path, PathBuf},
};

/// What is written for a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// Itself.
    Stored,
    /// The value it means, as f64.
    Values,
}

/// What a file is to hold.
#[derive(Clone, Copy, Debug)]
pub(super) enum Content<'a> {
    Values(&'a AnyVolume),
    Colors(&'a ColorVolume),
}

/// A volume that is written, but whose files do not have their names yet.
///
/// So several volumes that belong together are all written whole before any of them has its name. They get their names one
/// after the other: if the system refuses one, those before it have theirs. Dropped, it is gone, and what stood under the
/// names before still stands there.
#[derive(Debug)]
pub struct Prepared(Vec<Output>);

/// Samples written between two looks at the cancel token.
const PIECE: usize = 1 << 20;

/// Writes `volume` in the format that the name of `path` ends in: `.nrrd`, `.nhdr` with the samples in
/// a `.raw` beside it, `.nii`, `.nii.gz`, `.npy` or `.raw`.
///
/// The file appears when it is whole. Of header and samples the header comes last. What a format has
/// no words for is not written: NPY and raw hold neither place nor unit.
///
/// # Errors
///
/// If the name has another ending, if the file cannot be written, or if the job is cancelled.
pub fn write_volume(path: &Path, volume: &AnyVolume, job: &Job) -> Result<(), WriteError> {
    prepare_volume(path, volume, job)?.finish()
}

/// Writes `volume` as [`write_volume`] does, up to the names of its files.
///
/// # Errors
///
/// As [`write_volume`].
pub fn prepare_volume(path: &Path, volume: &AnyVolume, job: &Job) -> Result<Prepared, WriteError> {
    let at = |fault: WriteFault| fault.at(path);
    if has_ending(path, ".nhdr") {
        return nrrd::write_detached(path, Content::Values(volume), job).and_then(Prepared::new);
    }
    let ends = |ending: &str| has_ending(path, ending);
    let write: fn(&mut Output, &AnyVolume, &Job) -> Result<(), WriteFault> = match () {
        () if ends(".nii.gz") => write_gzip,
        () if ends(".nii") => nifti::write,
        () if ends(".nrrd") => |out, volume, job| nrrd::write(out, Content::Values(volume), job),
        () if ends(".npy") => npy::write,
        () if ends(".raw") => |out, volume, job| put_samples(out, volume, form(volume), job),
        () => {
            let known = "a volume is written as .nrrd, .nhdr, .nii, .nii.gz, .npy or .raw";
            return Err(at(WriteFault::Caller(known.into())));
        }
    };
    let mut out = Output::create(path)?;
    write(&mut out, volume, job).map_err(at)?;
    Prepared::new(vec![out])
}

/// Writes colours in the format that the name of `path` ends in, up to the names of its files: `.nrrd`, or `.nhdr` with the
/// samples in a `.raw` beside it. The numbers of a colour are beside each other, the axis that counts them is the first, and
/// of the kind `RGB-color` or `RGBA-color`.
///
/// # Errors
///
/// If the name has another ending, if the file cannot be written, or if the job is cancelled.
pub fn prepare_colors(
    path: &Path,
    colors: &ColorVolume,
    job: &Job,
) -> Result<Prepared, WriteError> {
    let (at, content) = (|fault: WriteFault| fault.at(path), Content::Colors(colors));
    match () {
        () if has_ending(path, ".nhdr") => {
            nrrd::write_detached(path, content, job).and_then(Prepared::new)
        }
        () if has_ending(path, ".nrrd") => {
            let mut out = Output::create(path)?;
            nrrd::write(&mut out, content, job).map_err(at)?;
            Prepared::new(vec![out])
        }
        () => Err(at(WriteFault::Caller("colours are written as .nrrd or .nhdr".into()))),
    }
}

/// Writes colours as [`prepare_colors`] does. The file appears when it is whole.
///
/// # Errors
///
/// As [`prepare_colors`].
pub fn write_colors(path: &Path, colors: &ColorVolume, job: &Job) -> Result<(), WriteError> {
    prepare_colors(path, colors, job)?.finish()
}

impl Prepared {
    /// Files to be named in this order, once the system has taken all of them.
    fn new(mut files: Vec<Output>) -> Result<Self, WriteError> {
        for out in &mut files {
            out.flush().map_err(|error| WriteFault::Io(error).at(out.path()))?;
        }
        Ok(Self(files))
    }

    /// Gives the files their names, a header last.
    ///
    /// # Errors
    ///
    /// If the system does not take what was written, or if it cannot be renamed.
    pub fn finish(self) -> Result<(), WriteError> {
        self.0.into_iter().try_for_each(Output::finish)
    }
}

fn has_ending(path: &Path, ending: &str) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    name.len() > ending.len() && name.ends_with(ending)
}

impl Content<'_> {
    pub(super) fn grid(&self) -> &Grid {
        match self {
            Self::Values(volume) => volume.grid(),
            Self::Colors(colors) => colors.grid(),
        }
    }

    /// All samples, x fastest, without a scaling.
    pub(super) fn put(self, out: &mut impl Write, job: &Job) -> Result<(), WriteFault> {
        match self {
            Self::Values(volume) => put_samples(out, volume, form(volume), job),
            Self::Colors(colors) => put_bytes(out, colors.samples(), job),
        }
    }
}

fn put_bytes(out: &mut impl Write, bytes: &[u8], job: &Job) -> Result<(), WriteFault> {
    job.progress.begin("write", bytes.len() as u64);
    for some in bytes.chunks(PIECE) {
        job.check()?;
        out.write_all(some)?;
        job.progress.advance(some.len() as u64);
    }
    Ok(())
}

/// The files that [`write_volume`] makes for `path`, those beside it included.
pub fn volume_files(path: &Path) -> Vec<PathBuf> {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let data = ending.eq_ignore_ascii_case("nhdr").then(|| path.with_extension("raw"));
    data.into_iter().chain([path.to_owned()]).collect()
}

fn write_gzip(out: &mut Output, volume: &AnyVolume, job: &Job) -> Result<(), WriteFault> {
    let mut encoder = GzEncoder::new(out, Compression::default());
    nifti::write(&mut encoder, volume, job)?;
    encoder.finish()?;
    Ok(())
}

/// How samples are written where there is no room for a scaling.
pub(super) fn form(volume: &AnyVolume) -> Form {
    if volume.scaling().is_identity() { Form::Stored } else { Form::Values }
}

/// The type that is written.
pub(super) fn dtype(volume: &AnyVolume) -> Dtype {
    match form(volume) {
        Form::Stored => volume.dtype(),
        Form::Values => Dtype::F64,
    }
}

/// All samples, x fastest.
pub(super) fn put_samples(
    out: &mut impl Write,
    volume: &AnyVolume,
    form: Form,
    job: &Job,
) -> Result<(), WriteFault> {
    for_any!(volume, volume => put(out, volume, form, job))
}

fn put<T: Sample>(
    out: &mut impl Write,
    volume: &Volume<T>,
    form: Form,
    job: &Job,
) -> Result<(), WriteFault> {
    let scaling = volume.scaling();
    job.progress.begin("write", volume.grid().count());
    for samples in volume.samples().chunks(PIECE) {
        job.check()?;
        match form {
            Form::Stored => put_little_endian(out, samples)?,
            Form::Values => {
                let values = samples.iter().map(|sample| scaling.value(sample.to_f64()));
                put_little_endian(out, &values.collect::<Vec<_>>())?;
            }
        }
        job.progress.advance(samples.len() as u64);
    }
    Ok(())
}

fn put_little_endian<T: Sample>(out: &mut impl Write, samples: &[T]) -> std::io::Result<()> {
    if cfg!(target_endian = "little") {
        return out.write_all(bytemuck::cast_slice(samples));
    }
    let swapped: Vec<T> = samples.iter().map(|sample| sample.swap_bytes()).collect();
    out.write_all(bytemuck::cast_slice(&swapped))
}
