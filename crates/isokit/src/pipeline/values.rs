//! Which values of a scan matter.

use super::{PipelineError, Scan};
use isokit_job::Job;
use isokit_spectrum::{ContourSpectrum, Levels, Suggestion, suggest};
use isokit_volume::for_any;

/// The share of samples, at each end of their values, that few isovalues are spent on.
const FEW: f64 = 1e-4;

impl Scan {
    /// As many isovalues as are looked at for suggestions.
    pub const LEVELS: usize = 256;

    /// The surfaces at up to so many isovalues between the values of the part, rare ones at both ends aside; between
    /// each two of whole-number samples, if they are no more. `None` if there are not two values, or `most` is 0 or
    /// above 65 536.
    ///
    /// # Errors
    ///
    /// If the job is cancelled or does not allow the memory.
    pub fn spectrum(
        &self,
        most: usize,
        job: &Job,
    ) -> Result<Option<ContourSpectrum>, PipelineError> {
        let Some(histogram) = self.histogram(job)? else { return Ok(None) };
        let ends = [histogram.quantile(FEW), histogram.quantile(1.0 - FEW)];
        let range = if ends[0] < ends[1] { ends } else { histogram.range };
        let bins = ((range[1] - range[0]) / histogram.width).round();
        let count = if bins >= 1.0 { most.min(bins as usize) } else { most };
        let Some(levels) = Levels::between(range, count) else { return Ok(None) };
        let found = for_any!(self.volume(), volume => {
            ContourSpectrum::of(&self.view(volume), levels, job)
        });
        Ok(Some(found?))
    }

    /// The isovalues of the part that stand out, best first. None if there are not two values.
    ///
    /// # Errors
    ///
    /// As [`spectrum`](Self::spectrum).
    pub fn suggestions(&self, job: &Job) -> Result<Vec<Suggestion>, PipelineError> {
        let Some(spectrum) = self.spectrum(Self::LEVELS, job)? else { return Ok(vec![]) };
        let histogram = self.histogram(job)?;
        Ok(histogram.map_or(vec![], |histogram| suggest(histogram, &spectrum)))
    }
}

#[cfg(test)]
mod tests {
    use crate::pipeline::Scan;
    use isokit_geom::Frame;
    use isokit_job::Job;
    use isokit_volume::{Grid, Sample, Volume};

    fn scan<T: Sample>(value: impl Fn(f64) -> T) -> Scan
    where
        Volume<T>: Into<isokit_volume::AnyVolume>,
    {
        let grid = Grid::new([40; 3], Frame::default()).unwrap();
        let at = |n: usize| {
            let place = [n % 40, n / 40 % 40, n / 1600].map(|i| i as f64 - 19.4);
            value(place.iter().map(|c| c * c).sum::<f64>().sqrt())
        };
        Scan::new(Volume::new(grid, (0..64_000).map(at).collect()).unwrap())
    }

    #[test]
    fn whole_numbers_get_a_level_between_each_two() {
        let job = Job::default();
        let ball = scan(|r| (30.0 - r).clamp(5.0, 24.0) as u8);
        let spectrum = ball.spectrum(1000, &job).unwrap().unwrap();
        let isos = spectrum.levels().isos();
        assert_eq!((isos[0], isos.len()), (5.5, 19));
        assert_eq!(ball.spectrum(7, &job).unwrap().unwrap().contours().len(), 7);
    }

    #[test]
    fn the_boundary_of_a_ball_is_suggested() {
        let ball = scan(|r| (100.0 / (1.0 + ((r - 12.0) / 0.8).exp())) as f32);
        let found = ball.suggestions(&Job::default()).unwrap();
        assert!((found[0].iso - 50.0).abs() < 30.0 && found[0].score > 0.5, "{found:?}");
    }

    #[test]
    fn samples_of_one_value_or_none_suggest_nothing() {
        for flat in [scan(|_| 3.0_f32), scan(|_| f32::NAN)] {
            assert_eq!(flat.suggestions(&Job::default()).unwrap(), []);
        }
    }
}
