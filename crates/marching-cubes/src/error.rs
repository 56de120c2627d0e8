//! Why there is no surface. An empty surface is a result, not an error.

use isokit_job::{Cancelled, OverLimit, Stopped};
use std::convert::Infallible;

/// Why there is no surface. `E` is the sink's own error.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExtractError<E = Infallible> {
    /// The caller's fault.
    #[error("the isovalue is {0}, which is no finite number")]
    Iso(f64),

    /// The data's fault, where the caller chose [`Nan::Error`](crate::Nan::Error).
    #[error(
        "samples that are NaN: {count}, the first at [{}, {}, {}]", first[0], first[1], first[2]
    )]
    Nan {
        /// How many.
        count: u64,
        /// The first in storage order, x fastest.
        first: [usize; 3],
    },

    /// Our limit: an axis is longer than a kernel can count.
    #[error("axis {axis} has {size} samples, at most {} can be extracted at once", i32::MAX - 2)]
    TooLong {
        /// 0, 1 or 2 for x, y, z.
        axis: usize,
        /// Its samples.
        size: usize,
    },

    /// The caller's fault, or the file's: positions cannot be told apart.
    #[error(
        "coordinates reach out to {reach:e}, where their type does not tell samples apart that are \
         {spacing:e} from each other"
    )]
    TooFar {
        /// The greatest absolute coordinate, in world units.
        reach: f64,
        /// The least distance of neighbouring samples, in world units.
        spacing: f64,
    },

    /// Our limit: triangles name their vertices in 32 bits.
    #[error(
        "the surface has {vertices} vertices and {triangles} triangles, more than 32 bits can \
         number: extract it in parts"
    )]
    TooLarge {
        /// Vertices of the whole surface.
        vertices: u64,
        /// Triangles of the whole surface.
        triangles: u64,
    },

    /// The caller's fault: [`Diagonals::Fitted`](crate::Diagonals::Fitted) for a sink that keeps no surface, or takes no normals.
    #[error(
        "diagonals are fitted in a surface that is kept in memory with its normals, and this one {}",
        if *is_kept { "gets no normals" } else { "is handed on in pieces" }
    )]
    Unfitted {
        /// Whether the sink keeps it at least.
        is_kept: bool,
    },

    /// The caller's choice: cancelled, or more memory than allowed.
    #[error(transparent)]
    Stopped(#[from] Stopped),

    /// The sink has no room.
    #[error(transparent)]
    Sink(E),
}

/// Why there is no surface of a volume that is read slice by slice: `R` is the source's own error, `E`
/// the sink's.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SlabError<R, E = Infallible> {
    /// The source has no slices.
    #[error(transparent)]
    Source(R),
    /// The slices have no surface.
    #[error(transparent)]
    Extract(#[from] ExtractError<E>),
}

impl<E> ExtractError<E> {
    /// The sink's error, or else the same error without a sink.
    ///
    /// # Errors
    ///
    /// If it is not the sink's.
    pub fn into_sink(self) -> Result<E, ExtractError> {
        Err(match self {
            Self::Sink(error) => return Ok(error),
            Self::Iso(iso) => ExtractError::Iso(iso),
            Self::Nan { count, first } => ExtractError::Nan { count, first },
            Self::TooLong { axis, size } => ExtractError::TooLong { axis, size },
            ExtractError::TooFar { reach, spacing } => ExtractError::TooFar { reach, spacing },
            Self::TooLarge { vertices, triangles } => {
                ExtractError::TooLarge { vertices, triangles }
            }
            Self::Unfitted { is_kept } => ExtractError::Unfitted { is_kept },
            Self::Stopped(stopped) => ExtractError::Stopped(stopped),
        })
    }
}

impl<E> From<Cancelled> for ExtractError<E> {
    fn from(cancelled: Cancelled) -> Self {
        Self::Stopped(cancelled.into())
    }
}

impl<E> From<OverLimit> for ExtractError<E> {
    fn from(over: OverLimit) -> Self {
        Self::Stopped(over.into())
    }
}
