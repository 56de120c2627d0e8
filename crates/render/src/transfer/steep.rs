//! How steep values are.

use crate::TransferFunction;
use isokit_geom::vector::{Vector, length};
use isokit_job::{Cancelled, Job, Work};
use isokit_lanes::exactly;
use isokit_volume::{Sample, View, gradient};
use rayon::prelude::*;

/// Slopes with the same exponent and first digits are counted together.
const SHIFT: u32 = 49;
const COUNTS: usize = 1 << (63 - SHIFT);

/// The slope above which only one in a hundred of the samples is that `function` shows, in values per world unit, but for
/// an eighth: as steep as the borders of what is seen. 1 where nothing is steep.
///
/// # Errors
///
/// If the job is cancelled.
pub fn full_slope<T: Sample>(
    view: &View<'_, T>,
    function: &TransferFunction,
    job: &Job,
) -> Result<f64, Cancelled> {
    let columns = view.frame().index_to_world.covector_columns();
    let [nx, ny, nz] = view.dims();
    let slice: Work<'_, _, _> = &|k: usize| {
        exactly(|| {
            job.check()?;
            let mut counts = none();
            for (j, i) in (0..ny).flat_map(|j| (0..nx).map(move |i| (j, i))) {
                let value = view.value([i, j, k]);
                if function.at(value).opacity > 0.0 {
                    let slope = slope_at(view, &columns, [i, j, k]).min(f64::MAX);
                    counts[(slope.to_bits() >> SHIFT) as usize % COUNTS] += u64::from(slope > 0.0);
                }
            }
            Ok(counts)
        })
    };
    let counts = job.threads.run(|| (0..nz).into_par_iter().map(slice).try_reduce(none, sum))?;
    let all: u64 = counts.iter().sum();
    let mut left = all / 100;
    for (bits, &count) in counts.iter().enumerate().rev() {
        if count > left {
            return Ok(f64::from_bits((bits as u64) << SHIFT).max(f64::MIN_POSITIVE));
        }
        left -= count;
    }
    Ok(1.0)
}

fn none() -> Vec<u64> {
    vec![0; COUNTS]
}

fn sum(mut a: Vec<u64>, b: Vec<u64>) -> Result<Vec<u64>, Cancelled> {
    a.iter_mut().zip(&b).for_each(|(a, b)| *a += b);
    Ok(a)
}

/// How steep values are at a sample, in values per world unit, where `columns` take a gradient to the world.
pub(crate) fn slope_at<T: Sample>(
    view: &View<'_, T>,
    columns: &[Vector; 3],
    ijk: [usize; 3],
) -> f64 {
    let part = gradient(view, ijk);
    length([0, 1, 2].map(|k| (0..3).map(|axis| columns[axis][k] * part[axis]).sum::<f64>()))
}

#[cfg(test)]
mod tests {
    use super::full_slope;
    use crate::{ControlPoint, TransferFunction};
    use isokit_geom::{Affine, Frame};
    use isokit_job::{Job, Threads};
    use isokit_volume::{Grid, Volume};
    use std::num::NonZeroUsize;

    #[test]
    fn the_full_slope_is_that_of_the_steepest_that_is_seen() {
        let index_to_world = Affine::axis_aligned([0.5, 1.0, 1.0], [0.0; 3]).unwrap();
        let grid = Grid::new([100, 9, 8], Frame { index_to_world, ..Frame::default() }).unwrap();
        // Steeper from 60 on, by 5 instead of 2 for each sample.
        let value = |n: u64| {
            let i = (n % 100) as f32;
            if i < 60.0 { 2.0 * i } else { 120.0 + 5.0 * (i - 60.0) }
        };
        let volume = Volume::new(grid, (0..grid.count()).map(value).collect()).unwrap();
        let view = volume.view();
        let below = |end: f64, opacity| ControlPoint { value: end, color: [1.0; 3], opacity };
        for (end, expected) in [(100.0, 4.0), (1000.0, 10.0)] {
            let points = vec![below(0.0, 0.5), below(end, 0.5), below(end, 0.0)];
            let function = TransferFunction::new(points).unwrap();
            let of = |threads: usize| {
                let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
                full_slope(&view, &function, &Job { threads, ..Job::default() }).unwrap()
            };
            let found = of(1);
            assert!((0.87 * expected..=expected).contains(&found), "{end}: {found}");
            assert_eq!(of(3), found);
        }
        let clear = TransferFunction::new(vec![below(0.0, 0.0)]).unwrap();
        assert_eq!(full_slope(&view, &clear, &Job::default()).unwrap(), 1.0);
    }
}
