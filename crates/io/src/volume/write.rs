//! Writing a volume: the format chosen by the name, samples little-endian.
//!
//! NRRD, NPY and raw cannot say that a stored sample means another value. A scaled volume is written
//! to them as its values, in f64: those are the very numbers that an isovalue is compared with, and
//! none is rounded. NIfTI keeps stored samples and scaling.

use super::{nifti, npy, nrrd};
use crate::{Output, WriteError, WriteFault};
use flate2::{Compression, write::GzEncoder};
use isokit_job::Job;
use isokit_volume::{AnyVolume, Dtype, Sample, Volume, for_any};
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
    let at = |fault: WriteFault| fault.at(path);
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let ends = |ending: &str| name.len() > ending.len() && name.ends_with(ending);
    if ends(".nhdr") {
        return nrrd::write_detached(path, volume, job);
    }
    let write: fn(&mut Output, &AnyVolume, &Job) -> Result<(), WriteFault> = match () {
        () if ends(".nii.gz") => write_gzip,
        () if ends(".nii") => nifti::write,
        () if ends(".nrrd") => nrrd::write,
        () if ends(".npy") => npy::write,
        () if ends(".raw") => |out, volume, job| put_samples(out, volume, form(volume), job),
        () => {
            let known = "a volume is written as .nrrd, .nhdr, .nii, .nii.gz, .npy or .raw";
            return Err(at(WriteFault::Caller(known.into())));
        }
    };
    let mut out = Output::create(path)?;
    write(&mut out, volume, job).map_err(at)?;
    out.finish()
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
