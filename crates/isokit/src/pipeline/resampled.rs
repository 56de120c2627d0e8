//! A scan with other samples of the same field.

use super::{PipelineError, Scan};
use isokit_field::{Filter, resample, resample_nearest};
use isokit_job::Job;
use isokit_volume::{AnyVolume, for_any};

impl Scan {
    /// The part that is looked at, at samples that are `spacing` from each other along its axes, in world units, as a
    /// filter sees it. The first sample stays where it is; the last ones are no farther than the old ones.
    ///
    /// The nearest samples keep their type. Others are f32; of i32, u32 and f64, f64.
    ///
    /// # Errors
    ///
    /// If a distance is not above 0 or not finite; if there would be more samples than are numbered or the job allows; if a
    /// sample is not finite and the filter is a spline; or if the job is cancelled.
    pub fn resampled(
        &self,
        filter: Filter,
        spacing: [f64; 3],
        job: &Job,
    ) -> Result<Self, PipelineError> {
        let volume: AnyVolume = for_any!(self.volume(), volume => {
            let view = self.view(volume);
            match filter {
                Filter::Nearest => resample_nearest(&view, spacing, job)?.into(),
                _ => resample(&view, &filter, spacing, job)?,
            }
        });
        Ok(self.with_samples(volume))
    }
}
