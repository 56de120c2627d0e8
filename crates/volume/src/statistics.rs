//! The least and greatest value, and what has no value.

use crate::{Bricks, Sample, Scaling, View, ranks::Ranks};
use isokit_job::{Cancelled, Job};
use isokit_lanes::{Extent, exactly};
use rayon::prelude::*;

/// What one pass over the samples finds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Least and greatest value, infinities included. `None` if every sample is NaN.
    pub range: Option<[f64; 2]>,
    /// How many samples are NaN.
    pub nan: u64,
    /// The first NaN in storage order, x fastest.
    pub first_nan: Option<[usize; 3]>,
    /// How many samples are infinite.
    pub infinite: u64,
}

#[derive(Clone, Copy)]
struct Part<T> {
    least: Option<T>,
    greatest: Option<T>,
    nan: u64,
    first_nan: Option<[usize; 3]>,
    infinite: u64,
}

impl Statistics {
    /// Looks at every sample once.
    ///
    /// # Errors
    ///
    /// [`Cancelled`] if the job was.
    pub fn of<T: Sample>(view: &View<'_, T>, job: &Job) -> Result<Self, Cancelled> {
        let slices = view.dims()[2];
        job.progress.begin("scan", slices as u64);
        // Few parts, however thin the slices are.
        let per_part = slices.div_ceil(16 * job.threads.count());
        let of_part = |first: usize| {
            (first..slices.min(first + per_part)).try_fold(Part::EMPTY, |part, k| {
                job.check()?;
                job.progress.advance(1);
                Ok(exactly(|| part.with(Part::of_slice(view, k))))
            })
        };
        let parts = job.threads.run(|| {
            let parts = (0..slices).into_par_iter().step_by(per_part).map(of_part);
            parts.collect::<Result<Vec<_>, Cancelled>>()
        })?;
        Ok(exactly(|| Self::from_parts(parts, view.scaling())))
    }

    /// Of all samples, counted one by one.
    pub(crate) fn of_ranks<T: Sample>(ranks: &Ranks, view: &View<'_, T>) -> Self {
        let mut samples = ranks.occurring().map(|(sample, _)| sample);
        let least = samples.next();
        let greatest = samples.next_back().or(least);
        Self::from_parts::<T>(vec![Part { least, greatest, ..Part::EMPTY }], view.scaling())
    }

    /// Of all samples, if what is known of them tells: if none is NaN or infinite, which would have to be counted. The
    /// bricks must be the volume's own, not those of a part, whose ends may be farther off.
    pub fn of_bricks<T: Sample>(bricks: &Bricks<T>, scaling: Scaling) -> Option<Self> {
        let all = exactly(|| bricks.extents().iter().copied().fold(Extent::EMPTY, Extent::with));
        let [least, greatest] = all.range().filter(|_| !all.has_nan)?;
        let is_finite = [least, greatest].iter().all(|end| end.to_f64().is_finite());
        let part = Part { least: Some(least), greatest: Some(greatest), ..Part::EMPTY };
        is_finite.then(|| exactly(|| Self::from_parts(vec![part], scaling)))
    }

    fn from_parts<T: Sample>(parts: Vec<Part<T>>, scaling: Scaling) -> Self {
        let whole = parts.into_iter().fold(Part::EMPTY, Part::with);
        // Which zero of two is met first does not matter.
        let value = |stored: Option<T>| stored.map(|s| scaling.value(s.to_f64()) + 0.0);
        let ends = value(whole.least).zip(value(whole.greatest));
        let range = ends.map(|(a, b)| if a <= b { [a, b] } else { [b, a] });
        let Part { nan, first_nan, infinite, .. } = whole;
        Self { range, nan, first_nan, infinite }
    }
}

impl Statistics {
    /// Of no sample.
    pub(crate) const EMPTY: Self = Self { range: None, nan: 0, first_nan: None, infinite: 0 };

    /// What holds of these slices and those that follow them, `slices` of which came before.
    pub(crate) fn then(self, later: Self, slices: usize) -> Self {
        let range = exactly(|| match (self.range, later.range) {
            (Some([a, b]), Some([c, d])) => {
                Some([if c < a { c } else { a }, if d > b { d } else { b }])
            }
            (a, b) => a.or(b),
        });
        let first_nan = later.first_nan.map(|[i, j, k]| [i, j, k + slices]);
        Self {
            range,
            nan: self.nan + later.nan,
            first_nan: self.first_nan.or(first_nan),
            infinite: self.infinite + later.infinite,
        }
    }
}

impl<T: Sample> Part<T> {
    const EMPTY: Self = Self { least: None, greatest: None, nan: 0, first_nan: None, infinite: 0 };

    fn of_slice(view: &View<'_, T>, k: usize) -> Self {
        let mut scratch = vec![];
        (0..view.dims()[1]).fold(Self::EMPTY, |part, j| {
            let row = view.row(j, k).gather(&mut scratch);
            part.with(Self::of_row(row, j, k))
        })
    }

    fn of_row(row: &[T], j: usize, k: usize) -> Self {
        let is_nan = |sample: &T| sample.partial_cmp(sample).is_none();
        let Some(first) = row.iter().position(|sample| !is_nan(sample)) else {
            return Self { nan: row.len() as u64, first_nan: Some([0, j, k]), ..Self::EMPTY };
        };
        // No branch in the loop, so that it becomes vector code; NaN compares false and drops out.
        let (mut least, mut greatest, mut nan) = (row[first], row[first], first as u64);
        for &sample in &row[first..] {
            least = if sample < least { sample } else { least };
            greatest = if sample > greatest { sample } else { greatest };
            nan += u64::from(is_nan(&sample));
        }
        let ends = [least, greatest].map(|end| end.to_f64().is_infinite());
        let infinite = match ends.contains(&true) {
            true => row.iter().filter(|sample| sample.to_f64().is_infinite()).count() as u64,
            false => 0,
        };
        let first_nan = match nan {
            0 => None,
            _ => row.iter().position(is_nan).map(|i| [i, j, k]),
        };
        Self { least: Some(least), greatest: Some(greatest), nan, first_nan, infinite }
    }

    /// This part and a later one.
    fn with(self, later: Self) -> Self {
        let choose = |a: Option<T>, b: Option<T>, second: fn(T, T) -> bool| match (a, b) {
            (Some(a), Some(b)) => Some(if second(a, b) { b } else { a }),
            (a, b) => a.or(b),
        };
        Self {
            least: choose(self.least, later.least, |a, b| b < a),
            greatest: choose(self.greatest, later.greatest, |a, b| b > a),
            nan: self.nan + later.nan,
            first_nan: self.first_nan.or(later.first_nan),
            infinite: self.infinite + later.infinite,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Statistics;
    use crate::{Bricks, Grid, Sample, Scaling, Volume};
    use isokit_geom::Frame;
    use isokit_job::Job;

    fn of<T: Sample>(samples: Vec<T>, scaling: Scaling) -> Statistics {
        let grid = Grid::new([3, 2, samples.len() as u64 / 6], Frame::default()).unwrap();
        let volume = Volume::new(grid, samples).unwrap().with_scaling(scaling);
        let found = Statistics::of(&volume.view(), &Job::default()).unwrap();
        let bricks = Bricks::of(&volume.view(), &Job::default()).unwrap();
        let told = Statistics::of_bricks(&bricks, scaling);
        let is_finite = found.nan == 0 && found.infinite == 0;
        assert_eq!(told, is_finite.then_some(found));
        found
    }

    #[test]
    fn a_range_that_ends_at_a_zero_ends_at_the_same_zero_however_it_is_found() {
        for zeros in [[0.0, -0.0], [-0.0, 0.0]] {
            let samples: Vec<f64> = (0..12).map(|n| zeros[n % 2]).collect();
            let range = of(samples, Scaling::IDENTITY).range.unwrap();
            assert_eq!(range.map(f64::to_bits), [0; 2]);
        }
    }

    #[test]
    fn a_negative_slope_turns_the_range_round() {
        let samples = vec![7_i16, -3, 5, 0, 1, 2, 9, 8, 4, 4, 4, 4];
        assert_eq!(of(samples.clone(), Scaling::IDENTITY).range, Some([-3.0, 9.0]));
        let scaling = Scaling::new(-2.0, 1.0).unwrap();
        assert_eq!(of(samples, scaling).range, Some([-17.0, 7.0]));
    }

    #[test]
    fn nan_is_counted_and_named_and_has_no_part_in_the_range() {
        let (nan, inf) = (f32::NAN, f32::INFINITY);
        let samples = vec![nan, 1.0, 2.0, 3.0, -inf, 0.0, nan, nan, nan, 5.0, 4.0, nan];
        let found = of(samples, Scaling::IDENTITY);
        assert_eq!(found.range, Some([f64::NEG_INFINITY, 5.0]));
        assert_eq!((found.nan, found.first_nan, found.infinite), (5, Some([0, 0, 0]), 1));
        let found = of(vec![1.0, 2.0, 3.0, 3.0, nan, 2.0], Scaling::IDENTITY);
        assert_eq!((found.nan, found.first_nan), (1, Some([1, 1, 0])));
        assert_eq!(of(vec![nan; 6], Scaling::IDENTITY).range, None);
    }
}
