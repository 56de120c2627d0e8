//! What is peculiar about a surface: why it is empty, or only a box.

use crate::pipeline::{PipelineError, SurfaceOptions, iso::Facts};
use isokit_job::Job;
use isokit_marching_cubes::Boundary;
use isokit_mesh::Counts;
use isokit_volume::Statistics;
use std::fmt;

/// A lawful result that is hardly the one that was meant.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Remark {
    /// The isovalue is above every sample: nothing is inside.
    AllOutside {
        /// The isovalue.
        iso: f64,
        /// Least and greatest value.
        range: [f64; 2],
    },
    /// No sample is below the isovalue: all of the volume is inside.
    AllInside {
        /// The isovalue.
        iso: f64,
        /// Least and greatest value.
        range: [f64; 2],
        /// What the surface is then.
        boundary: Boundary,
    },
    /// Every sample is NaN.
    AllNan,
    /// An open surface needs cells, and an axis of one sample has none.
    NoCells,
    /// The surface is empty for another reason: NaN covers it.
    Empty,
}

impl Remark {
    /// What is peculiar about a surface of a part of `dims` samples, if anything. Asks for facts only where
    /// the counts raise the question.
    pub(super) fn among(
        facts: &impl Facts,
        dims: [usize; 3],
        (iso, counts): (f64, Counts),
        options: &SurfaceOptions,
        job: &Job,
    ) -> Result<Option<Self>, PipelineError> {
        if !Self::is_worth_a_look(counts, dims, options.extract.boundary) {
            return Ok(None);
        }
        Ok(Self::of(iso, counts, dims, options, &facts.statistics(job)?))
    }

    /// Whether a surface is so peculiar by its counts alone that it is worth looking at every sample.
    fn is_worth_a_look(counts: Counts, dims: [usize; 3], boundary: Boundary) -> bool {
        let [nx, ny, nz] = dims.map(|n| n as u64);
        // One vertex outside each border sample, on each side of the box that it lies on.
        let of_box = 2 * (nx * ny + ny * nz + nz * nx);
        counts.triangles == 0 || boundary == Boundary::Closed && counts.vertices == of_box
    }

    /// What to say of a surface, if anything.
    fn of(
        iso: f64,
        counts: Counts,
        dims: [usize; 3],
        options: &SurfaceOptions,
        statistics: &Statistics,
    ) -> Option<Self> {
        let boundary = options.extract.boundary;
        match statistics.range {
            None => Some(Self::AllNan),
            Some(range) if iso > range[1] => Some(Self::AllOutside { iso, range }),
            Some(range) if iso <= range[0] && statistics.nan == 0 => {
                Some(Self::AllInside { iso, range, boundary })
            }
            _ if counts.triangles > 0 => None,
            _ if boundary == Boundary::Open && dims.contains(&1) => Some(Self::NoCells),
            _ => Some(Self::Empty),
        }
    }
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AllOutside { iso, range: [least, greatest] } => write!(
                f,
                "isovalue {iso} is above every sample, they range from {least} to {greatest}: the \
                 surface is empty"
            ),
            Self::AllInside { iso, range: [least, greatest], boundary } => {
                let shape = match boundary {
                    Boundary::Closed => "the box of the volume",
                    Boundary::Open => "empty",
                };
                write!(
                    f,
                    "isovalue {iso} is not above the least sample, they range from {least} to \
                     {greatest}: the surface is {shape}"
                )
            }
            Self::AllNan => f.write_str("every sample is NaN: the surface is empty"),
            Self::NoCells => f.write_str(
                "an axis has one sample only, and so no cells: the open surface is empty",
            ),
            Self::Empty => f.write_str("NaN lies wherever the surface would be: it is empty"),
        }
    }
}
