//! How often each value occurs.

use crate::{
    Sample, Scaling, Statistics, View,
    ranks::{Ranks, of_parts},
};
use isokit_job::{Cancelled, Job};
use isokit_lanes::exactly;
use std::ops::Range;

/// Counts of values in bins of equal width, from the least finite value to the greatest.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Least and greatest finite value.
    pub range: [f64; 2],
    /// Value at the middle of the first bin.
    pub first: f64,
    /// Distance between the middles of neighbouring bins.
    pub width: f64,
    /// Samples in each bin. NaN and infinite samples are in none.
    pub counts: Vec<u64>,
}

/// Bins for samples that have no natural ones.
const BINS: usize = 4096;

/// Widest range of whole numbers that get a bin each.
const WHOLE_BINS: f64 = 65536.0;

impl Histogram {
    /// Counts every sample once. Whole-number samples over a range of up to 65 536 get a bin each,
    /// others 4096 bins in all. `None` if no sample is finite.
    ///
    /// # Errors
    ///
    /// [`Cancelled`] if the job was.
    pub fn of<T: Sample>(
        view: &View<'_, T>,
        statistics: &Statistics,
        job: &Job,
    ) -> Result<Option<Self>, Cancelled> {
        exactly(|| {
            let Some(range) = finite_range(view, statistics) else { return Ok(None) };
            let mut histogram = Self::empty::<T>(range, view.scaling());
            histogram.count(view, job)?;
            Ok(Some(histogram))
        })
    }

    /// The same, and the statistics, which may be `known`; else samples of one or two bytes are looked at only once for both.
    ///
    /// # Errors
    ///
    /// [`Cancelled`] if the job was.
    pub fn with_statistics<T: Sample>(
        view: &View<'_, T>,
        known: Option<&Statistics>,
        job: &Job,
    ) -> Result<(Statistics, Option<Self>), Cancelled> {
        if known.is_some() || !Ranks::suit::<T>() {
            let statistics = known.map_or_else(|| Statistics::of(view, job), |known| Ok(*known))?;
            return Ok((statistics, Self::of(view, &statistics, job)?));
        }
        job.progress.begin("scan", view.dims()[2] as u64);
        let ranks = Ranks::of(view, job, || job.progress.advance(1))?;
        exactly(|| {
            let statistics = Statistics::of_ranks(&ranks, view);
            let histogram = finite_range(view, &statistics).map(|range| {
                let mut histogram = Self::empty::<T>(range, view.scaling());
                histogram.enter::<T>(&ranks, view.scaling());
                histogram
            });
            Ok((statistics, histogram))
        })
    }

    /// The bins for finite values in a range.
    pub(crate) fn empty<T: Sample>([least, greatest]: [f64; 2], scaling: Scaling) -> Self {
        let step = scaling.slope().abs();
        let whole = T::DTYPE.is_integer() && (greatest - least) / step < WHOLE_BINS;
        // Half of each end first: the difference of two finite values may not be finite.
        let span = (greatest / 2.0 - least / 2.0).min(f64::MAX / 4.0) * 2.0;
        let (first, width, bins) = match (whole, span == 0.0) {
            (true, _) => (least, step, ((greatest - least) / step).round() as usize + 1),
            (false, true) => (least, 1.0, 1),
            (false, false) => {
                let width = span / BINS as f64;
                (least + width / 2.0, width, BINS)
            }
        };
        Self { range: [least, greatest], first, width, counts: vec![0; bins] }
    }

    /// Counts every sample once.
    pub(crate) fn count<T: Sample>(
        &mut self,
        view: &View<'_, T>,
        job: &Job,
    ) -> Result<(), Cancelled> {
        if Ranks::suit::<T>() {
            self.enter::<T>(&Ranks::of(view, job, || ())?, view.scaling());
            return Ok(());
        }
        let (rows, bin) = (view.dims()[1], self.bins(view.scaling()));
        let of_slices = |slices: Range<usize>| {
            let (mut counts, mut scratch) = (vec![0; self.counts.len()], vec![]);
            for k in slices {
                job.check()?;
                for j in 0..rows {
                    let row = view.row(j, k).gather(&mut scratch);
                    row.iter().filter_map(|&sample| bin(sample)).for_each(|n| counts[n] += 1);
                }
            }
            Ok(counts)
        };
        for part in of_parts(view.dims()[2], job, |slices| exactly(|| of_slices(slices)))? {
            self.counts.iter_mut().zip(part).for_each(|(all, more)| *all += more);
        }
        Ok(())
    }

    /// What bin a sample is in.
    fn bins<T: Sample>(&self, scaling: Scaling) -> impl Fn(T) -> Option<usize> + use<T> {
        let (first, per_width, last) = (self.first, 1.0 / self.width, self.counts.len() - 1);
        move |sample| {
            let value = scaling.value(sample.to_f64());
            let bin = ((value - first) * per_width).round();
            value.is_finite().then(|| (bin.max(0.0) as usize).min(last))
        }
    }

    /// Adds samples that were counted one by one: what bin they are in is asked once for each that occurs.
    fn enter<T: Sample>(&mut self, ranks: &Ranks, scaling: Scaling) {
        let bin = self.bins::<T>(scaling);
        for (sample, count) in ranks.occurring() {
            if let Some(n) = bin(sample) {
                self.counts[n] += count;
            }
        }
    }

    /// The value at the middle of a bin.
    pub fn middle(&self, bin: usize) -> f64 {
        self.first + bin as f64 * self.width
    }

    /// The mean of the samples, each taken for the middle of its bin, and their standard deviation. NaN if there are
    /// none.
    pub fn mean_and_deviation(&self) -> [f64; 2] {
        let total = self.counts.iter().sum::<u64>() as f64;
        let mean_of = |of: &dyn Fn(f64) -> f64| {
            let parts =
                self.counts.iter().enumerate().map(|(n, &count)| count as f64 * of(n as f64));
            parts.sum::<f64>() / total
        };
        let mean = mean_of(&|bin| bin);
        let variance = mean_of(&|bin| (bin - mean) * (bin - mean));
        [self.first + mean * self.width, variance.sqrt() * self.width]
    }

    /// The middle of the first bin up to which a share of the samples lies, from 0 to 1.
    pub fn quantile(&self, share: f64) -> f64 {
        let wanted = share * self.counts.iter().sum::<u64>() as f64;
        let mut below = 0;
        let is_reached = |&count: &u64| {
            below += count;
            count > 0 && below as f64 >= wanted
        };
        let last = self.counts.iter().rposition(|&count| count > 0).unwrap_or(0);
        self.middle(self.counts.iter().position(is_reached).unwrap_or(last))
    }

    /// The value that splits the samples into two classes of the least spread (Otsu 1979, *A threshold
    /// selection method from gray-level histograms*). It lies midway between two occupied bins, so
    /// that no sample in the middle of a bin is on it. `None` if all samples share a bin.
    pub fn otsu(&self) -> Option<f64> {
        let weight = |bin: usize| self.counts[bin] as f64;
        let occupied: Vec<usize> = (0..self.counts.len()).filter(|&b| self.counts[b] > 0).collect();
        let total: f64 = occupied.iter().map(|&b| weight(b)).sum();
        let mean = occupied.iter().map(|&b| weight(b) * b as f64).sum::<f64>() / total;
        let (mut below, mut moment) = (0.0, 0.0);
        let mut best: Option<(f64, f64)> = None;
        for pair in occupied.windows(2) {
            below += weight(pair[0]);
            moment += weight(pair[0]) * pair[0] as f64;
            let share = below / total;
            let lag = mean * share - moment / total;
            let between = lag * lag / (share * (1.0 - share));
            if best.is_none_or(|(greatest, _)| between > greatest) {
                best = Some((between, (pair[0] as f64).midpoint(pair[1] as f64)));
            }
        }
        best.map(|(_, bin)| self.first + bin * self.width)
    }
}

/// The least and greatest finite value, if any. Infinities are rare: only then is every sample asked again.
pub(crate) fn finite_range<T: Sample>(
    view: &View<'_, T>,
    statistics: &Statistics,
) -> Option<[f64; 2]> {
    if statistics.infinite == 0 {
        return statistics.range;
    }
    let [_, ny, nz] = view.dims();
    let (mut range, mut scratch) = (None, vec![]);
    for (j, k) in (0..nz).flat_map(|k| (0..ny).map(move |j| (j, k))) {
        for sample in view.row(j, k).gather(&mut scratch) {
            let value = view.scaling().value(sample.to_f64());
            if value.is_finite() {
                let [least, greatest] = range.unwrap_or([value; 2]);
                range = Some([value.min(least), value.max(greatest)]);
            }
        }
    }
    range
}

#[cfg(test)]
mod tests {
    use super::Histogram;
    use crate::{Grid, Sample, Scaling, Statistics, Volume};
    use isokit_geom::Frame;
    use isokit_job::Job;

    fn of<T: Sample>(samples: Vec<T>, scaling: Scaling) -> Option<Histogram> {
        let grid = Grid::new([samples.len() as u64, 1, 1], Frame::default()).unwrap();
        let volume = Volume::new(grid, samples).unwrap().with_scaling(scaling);
        let statistics = Statistics::of(&volume.view(), &Job::default()).unwrap();
        Histogram::of(&volume.view(), &statistics, &Job::default()).unwrap()
    }

    #[test]
    fn whole_numbers_get_a_bin_each_and_keep_their_values() {
        let found = of(vec![5_u16, 7, 7, 5, 5, 8], Scaling::new(2.0, -1.0).unwrap()).unwrap();
        assert_eq!((found.first, found.width), (9.0, 2.0));
        assert_eq!(found.counts, [3, 0, 2, 1]);
        assert_eq!(found.middle(3), 15.0);
    }

    #[test]
    fn samples_of_one_or_two_bytes_are_counted_as_those_of_four() {
        let chance = (0..5000_u64).map(|n| n.wrapping_mul(6364136223846793005) >> 41);
        // With long and short runs of equal ones, as there are in air.
        let number = |(at, n): (usize, u64)| match at % 300 {
            0..100 => (n % 251) as i32 - 125,
            100..290 => 3,
            _ => (at / 5) as i32 % 100,
        };
        let numbers: Vec<i32> = chance.enumerate().map(number).collect();
        for scaling in [Scaling::IDENTITY, Scaling::new(-0.75, 30.0).unwrap()] {
            for count in [1, 2, 3, 4, 5, 4999, 5000] {
                let numbers = &numbers[..count];
                let four = of(numbers.to_vec(), scaling);
                assert!(of(numbers.iter().map(|&n| n as i16).collect(), scaling) == four);
                assert!(of(numbers.iter().map(|&n| n as i8).collect(), scaling) == four);
            }
        }
    }

    #[test]
    fn otsu_parts_two_heaps_between_them() {
        let heaps = (0..100).map(|n| if n < 70 { n % 5 } else { 200 + n % 7 });
        let iso = of(heaps.collect::<Vec<u8>>(), Scaling::IDENTITY).unwrap().otsu().unwrap();
        assert_eq!(iso, 102.0, "midway between 4 and 200");
    }

    #[test]
    fn quantiles_are_values_that_occur() {
        let found = of(vec![10_u8, 20, 20, 20, 40], Scaling::IDENTITY).unwrap();
        let of = [0.0, 0.2, 0.21, 0.5, 0.8, 0.81, 1.0, 2.0].map(|share| found.quantile(share));
        assert_eq!(of, [10.0, 10.0, 20.0, 20.0, 20.0, 40.0, 40.0, 40.0]);
        let [mean, deviation] = found.mean_and_deviation();
        assert!((mean - 22.0).abs() < 1e-12 && (deviation - 96.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_finite_is_in_no_bin() {
        let samples = vec![f64::NAN, f64::INFINITY, -1.0, 3.0, f64::NEG_INFINITY];
        let found = of(samples, Scaling::IDENTITY).unwrap();
        assert_eq!(found.counts.iter().sum::<u64>(), 2);
        assert_eq!((found.counts[0], found.counts[4095]), (1, 1));
        assert_eq!(of(vec![f32::NAN, f32::INFINITY], Scaling::IDENTITY), None);
    }

    #[test]
    fn one_value_has_one_bin_and_no_threshold() {
        assert_eq!(of(vec![2.5_f32; 4], Scaling::IDENTITY).unwrap().otsu(), None);
        let widest = of(vec![f64::MAX, -f64::MAX], Scaling::IDENTITY).unwrap();
        assert_eq!(widest.counts.iter().sum::<u64>(), 2);
    }
}
