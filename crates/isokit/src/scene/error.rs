//! Why there is no picture.

use crate::pipeline::PipelineError;
use isokit_job::{Cancelled, Stopped};
use isokit_render::{CameraError, RasterError, RaycastError};

/// Why a scene became no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A surface could not be made.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// The caller's fault: no picture can be taken so.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// Surfaces could not be drawn.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// Rays could not be cast.
    #[error(transparent)]
    Raycast(#[from] RaycastError),
    /// The caller's fault: a plane is to cut a surface that is not there.
    #[error("a plane is to cut the surface {0:?}, and no surface has that name")]
    UnknownSurface(String),
    /// The caller's fault: nothing says what values look like.
    #[error("nothing says what values look like: there is no transfer function")]
    NoTransfer,
    /// The caller's fault: a cap of something that is known by its surface alone.
    #[error("a cap shows what is inside, and of a mesh nobody knows that")]
    NoValues,
    /// The job was cancelled, or allows less memory.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl From<Cancelled> for SceneError {
    fn from(cancelled: Cancelled) -> Self {
        Self::Stopped(cancelled.into())
    }
}
