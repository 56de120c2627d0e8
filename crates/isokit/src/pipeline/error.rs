//! Why there is no mesh, step by step. An empty mesh is a result, not an error.

use crate::pipeline::{IsoChoice, RegionError, UnknownSpace};
use isokit_field::ResampleError;
use isokit_io::{ReadError, WriteError};
use isokit_job::{Cancelled, OverLimit, Stopped};
use isokit_marching_cubes::{ExtractError, SlabError};
use isokit_refine::RefineError;
use std::{convert::Infallible, ops::Range};

/// Why a step from scan to mesh failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PipelineError {
    /// The scan could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The caller's choice: axes that nobody knows.
    #[error(transparent)]
    Space(#[from] UnknownSpace),
    /// The caller's choice: a part that the volume does not have.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// The data's fault: nothing to choose an isovalue by.
    #[error("{choice} gives no isovalue: {reason}")]
    Iso {
        /// How it was to be found.
        choice: IsoChoice,
        /// Why it was not.
        reason: &'static str,
    },
    /// There are no such samples.
    #[error(transparent)]
    Resample(#[from] ResampleError),
    /// There is no surface; places are sample numbers of the whole volume.
    #[error(transparent)]
    Extract(#[from] ExtractError),
    /// The surface could not be refined.
    #[error(transparent)]
    Refine(#[from] RefineError),
    /// The mesh could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The caller's choice: cancelled, or more memory than allowed.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl From<Cancelled> for PipelineError {
    fn from(cancelled: Cancelled) -> Self {
        Self::Stopped(cancelled.into())
    }
}

impl From<OverLimit> for PipelineError {
    fn from(over: OverLimit) -> Self {
        Self::Stopped(over.into())
    }
}

impl From<Infallible> for PipelineError {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

/// What befell the slices of a part, with sample numbers of the whole volume.
pub(super) fn of_slabs<R: Into<PipelineError>, E: Into<PipelineError>>(
    error: SlabError<R, E>,
    part: &[Range<usize>; 3],
) -> PipelineError {
    match error {
        SlabError::Source(error) => error.into(),
        SlabError::Extract(error) => match error.into_sink() {
            Ok(error) => error.into(),
            Err(ExtractError::Stopped(stopped)) => stopped.into(),
            Err(error) => in_whole(error, part).into(),
        },
    }
}

/// The same error with sample numbers of the whole volume instead of the part.
pub(super) fn in_whole(error: ExtractError, part: &[Range<usize>; 3]) -> ExtractError {
    match error {
        ExtractError::Nan { count, first } => {
            let first = std::array::from_fn(|axis| first[axis] + part[axis].start);
            ExtractError::Nan { count, first }
        }
        other => other,
    }
}
