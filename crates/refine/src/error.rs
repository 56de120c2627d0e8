//! Why a surface cannot be refined.

use isokit_job::{Cancelled, OverLimit, Stopped};

/// Why a surface was not refined. It is then what the last whole step left.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RefineError {
    /// The caller's fault: levels or an error that mean nothing.
    #[error("cannot refine {0}")]
    Options(&'static str),

    /// The caller's fault, or the file's: the mesh is not sound.
    #[error("triangle {triangle} names a vertex twice, or one that is not there")]
    Unsound {
        /// Counted from 0.
        triangle: usize,
    },

    /// Our limit: triangles name their vertices in 32 bits.
    #[error(
        "the refined surface has {vertices} vertices and {triangles} triangles, more than 32 bits can \
         number"
    )]
    TooLarge {
        /// Vertices it would have.
        vertices: u64,
        /// Triangles it would have.
        triangles: u64,
    },

    /// The caller's choice: cancelled, or more memory than allowed.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl From<Cancelled> for RefineError {
    fn from(cancelled: Cancelled) -> Self {
        Self::Stopped(cancelled.into())
    }
}

impl From<OverLimit> for RefineError {
    fn from(over: OverLimit) -> Self {
        Self::Stopped(over.into())
    }
}
