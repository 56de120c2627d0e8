//! The same field at other samples: farther from each other, or nearer.
//!
//! Along one axis after the other each new sample is a sum of old ones, weighed by a kernel. Where samples come farther
//! from each other the kernel is as much wider, so that waves are left out that the new ones cannot hold: nothing else
//! takes their place. What lies beyond the border is told from the last samples so that what rises evenly goes on
//! (`border.rs`); nothing of it reaches farther in than the kernel does, but for splines, of which it fades by three
//! quarters and more with each sample.

mod passes;
mod weights;

use crate::{SeparableKernel, Spline};
use isokit_geom::Frame;
use isokit_job::{Job, Stopped};
use isokit_lanes::Real;
use isokit_volume::{AnyVolume, Dtype, Grid, Sample, View, Volume};
use passes::Passes;
use weights::Weights;

/// Why there are no other samples.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResampleError {
    /// The caller's fault: no distance.
    #[error(
        "samples are to be {spacing} from each other along {axis}: expected a finite number above 0"
    )]
    Spacing {
        /// `x`, `y` or `z`.
        axis: char,
        /// What it would be.
        spacing: f64,
    },
    /// Ours: more samples along an axis, or more weights, than are numbered.
    #[error("{needed} samples and weights along {axis} are more than {most}")]
    TooMany {
        /// `x`, `y` or `z`.
        axis: char,
        /// How many there would be.
        needed: u64,
        /// How many there may be.
        most: u64,
    },
    /// The data's fault: a spline goes through all samples of a line, and one of them is no number.
    #[error("the sample at {at:?} is {value}: a spline needs finite samples")]
    NotFinite {
        /// Which one.
        at: [usize; 3],
        /// What it is.
        value: f64,
    },
    /// The job was cancelled, or allows less memory.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// What a field has at samples that are `spacing` from each other along its axes, in world units: as `kernel` sees it. The
/// first sample stays where it is, and the last ones are no farther than the old ones.
///
/// What samples mean stays. They are f32; of i32, u32 and f64, f64. The same bytes for any number of threads.
///
/// # Errors
///
/// If a distance is not above 0 or not finite; if there would be more samples than are numbered or the job allows; if a
/// sample is not finite and the kernel is a spline; or if the job is cancelled.
pub fn resample<T: Sample>(
    view: &View<'_, T>,
    kernel: &dyn SeparableKernel,
    spacing: [f64; 3],
    job: &Job,
) -> Result<AnyVolume, ResampleError> {
    match T::DTYPE {
        Dtype::I32 | Dtype::U32 | Dtype::F64 => {
            Ok(numbers::<T, f64>(view, kernel, spacing, job)?.into())
        }
        _ => Ok(numbers::<T, f32>(view, kernel, spacing, job)?.into()),
    }
}

/// The same of the samples as they are: each new one is that which is nearest, of two the one above. For labels.
///
/// # Errors
///
/// As [`resample`], whatever samples are.
pub fn resample_nearest<T: Sample + Default>(
    view: &View<'_, T>,
    spacing: [f64; 3],
    job: &Job,
) -> Result<Volume<T>, ResampleError> {
    let (grid, factors) = lattice(view, spacing)?;
    let dims = grid.dims().map(|n| n as usize);
    let nearest = |axis: usize| -> Result<Vec<usize>, ResampleError> {
        let mut places = job
            .limits
            .vec("places along an axis", Some(dims[axis] as u64))
            .map_err(Stopped::from)?;
        let last = view.dims()[axis] - 1;
        let place = |n: usize| ((n as f64 * factors[axis] + 0.5) as usize).min(last);
        places.extend((0..dims[axis]).map(place));
        Ok(places)
    };
    let places = [nearest(0)?, nearest(1)?, nearest(2)?];
    let samples = passes::taken(view, &places, job)?;
    Ok(Volume::new(grid, samples).expect("one for each point").with_scaling(view.scaling()))
}

fn numbers<T: Sample, F: Real + Sample>(
    view: &View<'_, T>,
    kernel: &dyn SeparableKernel,
    spacing: [f64; 3],
    job: &Job,
) -> Result<Volume<F>, ResampleError> {
    let (grid, factors) = lattice(view, spacing)?;
    let of = |axis: usize| {
        let sizes = [view.dims()[axis], grid.dims()[axis] as usize];
        Weights::new(kernel, sizes, (axis, factors[axis]), job)
    };
    let weights = [of(0)?, of(1)?, of(2)?];
    let samples = Passes { view, weights: &weights, job }.made()?;
    Ok(Volume::new(grid, samples).expect("one for each point").with_scaling(view.scaling()))
}

/// The numbers by which the pieces of a spline are weighed so that they add up to the samples, x fastest: for each sample one,
/// and one more at each end of each axis.
pub(crate) fn spline_numbers<T: Sample, F: Real + Sample>(
    view: &View<'_, T>,
    spline: Spline,
    job: &Job,
) -> Result<Vec<F>, ResampleError> {
    let along = |axis: usize| Weights::numbers(spline, view.dims()[axis], axis, job);
    let weights = [along(0)?, along(1)?, along(2)?];
    Passes { view, weights: &weights, job }.made()
}

/// The new lattice, and how many old samples it is from one new one to the next along each axis.
fn lattice<T: Sample>(
    view: &View<'_, T>,
    spacing: [f64; 3],
) -> Result<(Grid, [f64; 3]), ResampleError> {
    let (frame, dims) = (view.frame(), view.dims());
    let old = frame.index_to_world.spacing();
    let refused = |axis: usize| ResampleError::Spacing { axis: AXES[axis], spacing: spacing[axis] };
    if let Some(axis) = (0..3).find(|&k| !(spacing[k] > 0.0 && spacing[k].is_finite())) {
        return Err(refused(axis));
    }
    let factors: [f64; 3] = std::array::from_fn(|k| spacing[k] / old[k]);
    let mut counts = [0; 3];
    for axis in 0..3 {
        let steps = (dims[axis] - 1) as f64 / factors[axis];
        // As far as the last one, whatever rounding did to the distances.
        let count = (steps * (1.0 + 1e-12)).floor() + 1.0;
        if count > f64::from(MOST) {
            let needed = count as u64;
            return Err(ResampleError::TooMany { axis: AXES[axis], needed, most: MOST.into() });
        }
        counts[axis] = count as u64;
    }
    let longest = (0..3).max_by(|&a, &b| factors[a].total_cmp(&factors[b])).unwrap_or(0);
    let index_to_world =
        frame.index_to_world.scaled_steps(factors).map_err(|_| refused(longest))?;
    let grid = Grid::new(counts, Frame { index_to_world, ..*frame });
    let most = u64::MAX;
    let too_many = |_| ResampleError::TooMany { axis: AXES[longest], needed: most, most };
    Ok((grid.map_err(too_many)?, factors))
}

pub(crate) const AXES: [char; 3] = ['x', 'y', 'z'];

/// More samples of a line, or weights for them, are not numbered.
pub(crate) const MOST: u32 = 1 << 30;

#[cfg(test)]
mod tests;
