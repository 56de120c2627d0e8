//! Volumes with fewer samples, of which each is a mean of those around it.

use crate::{AnyVolume, Dtype, Grid, Sample, View, Volume};
use isokit_geom::Frame;
use isokit_job::{Job, Stopped, Work};
use isokit_lanes::exactly;
use rayon::prelude::*;

/// Every second sample of a volume along some of its axes, from the first on, and of each with its neighbours there the
/// mean that counts it twice: a tent, the least that lets a wave as long as two of the new distances vanish. A
/// neighbour that is not there, or is NaN, does not count; where the sample is NaN itself, so is the mean. What samples
/// mean stays. They are f32; of i32, u32 and f64, f64.
///
/// Of an even number of samples the last one is not in the box of the new ones.
///
/// # Errors
///
/// If the job is cancelled or does not allow the samples' memory.
///
/// # Panics
///
/// If samples are so far apart along one of the axes that no [`Affine`](isokit_geom::Affine) has twice their distance.
pub fn halved<T: Sample>(
    view: &View<'_, T>,
    axes: [bool; 3],
    job: &Job,
) -> Result<AnyVolume, Stopped> {
    match T::DTYPE {
        Dtype::I32 | Dtype::U32 | Dtype::F64 => Ok(means(view, axes, |mean| mean, job)?.into()),
        _ => Ok(means(view, axes, |mean| mean as f32, job)?.into()),
    }
}

/// The same, of which each mean becomes a sample.
fn means<T: Sample, M: Sample>(
    view: &View<'_, T>,
    axes: [bool; 3],
    sample: fn(f64) -> M,
    job: &Job,
) -> Result<Volume<M>, Stopped> {
    let (old, steps) = (view.dims(), axes.map(|is_halved| if is_halved { 2 } else { 1 }));
    let dims: [usize; 3] = std::array::from_fn(|k| old[k].div_ceil(steps[k]));
    let [nx, ny, _] = dims;
    let count = dims.iter().map(|&n| n as u64).product();
    let mut samples: Vec<M> = job.limits.zeroed("fewer samples", Some(count))?;
    // The samples along an axis that a mean is of, and how much each counts.
    let around = |axis: usize, n: usize| {
        let (middle, reach) = (n * steps[axis], steps[axis] - 1);
        let range = middle.saturating_sub(reach)..(middle + reach + 1).min(old[axis]);
        range.map(move |at| (at, if at == middle { 2.0 } else { 1.0 }))
    };
    let row: Work<'_, _, _> = &|(number, row): (usize, &mut [M])| {
        exactly(|| {
            let (y, z) = (number % ny, number / ny);
            let (mut sums, mut weights) = (vec![0.0; old[0]], vec![0.0; old[0]]);
            let mut scratch = vec![];
            for (k, in_z) in around(2, z) {
                for (j, in_y) in around(1, y) {
                    let stored = view.row(j, k).gather(&mut scratch);
                    for ((sum, weight), stored) in sums.iter_mut().zip(&mut weights).zip(stored) {
                        let stored = stored.to_f64();
                        // Without a branch.
                        let is_number = f64::from(u8::from(!stored.is_nan()));
                        *sum += in_z * in_y * if stored.is_nan() { 0.0 } else { stored };
                        *weight += in_z * in_y * is_number;
                    }
                }
            }
            for (n, mean) in row.iter_mut().enumerate() {
                let own = view.stored([n * steps[0], y * steps[1], z * steps[2]]);
                let parts = around(0, n).map(|(i, in_x)| [in_x * sums[i], in_x * weights[i]]);
                let [sum, weight] =
                    parts.fold([0.0; 2], |[a, b], [sum, weight]| [a + sum, b + weight]);
                let is_number = !own.to_f64().is_nan();
                *mean = sample(if is_number { sum / weight } else { f64::NAN });
            }
        });
        job.check()
    };
    let rows = samples.par_chunks_mut(nx).enumerate();
    job.threads.run(|| rows.try_for_each(row))?;
    let frame = view.frame();
    let index_to_world = frame.index_to_world.scaled_steps(steps.map(|n| n as f64));
    let index_to_world = index_to_world.expect("no axis has the steps that are too long to double");
    let grid = Grid::new(dims.map(|n| n as u64), Frame { index_to_world, ..*frame });
    let grid = grid.expect("no more samples than there were");
    Ok(Volume::new(grid, samples).expect("one for each point").with_scaling(view.scaling()))
}

#[cfg(test)]
mod tests {
    use super::halved;
    use crate::{AnyVolume, Grid, Scaling, Volume};
    use isokit_geom::{Affine, Frame};
    use isokit_job::{Job, Threads};
    use std::num::NonZeroUsize;

    fn volume<T: crate::Sample>(dims: [u64; 3], sample: impl Fn([f64; 3]) -> T) -> Volume<T> {
        let index_to_world = Affine::axis_aligned([0.5, 1.0, 2.0], [3.0, -1.0, 0.0]).unwrap();
        let grid = Grid::new(dims, Frame { index_to_world, ..Frame::default() }).unwrap();
        let [nx, ny, _] = dims;
        let at = |n: u64| [n % nx, n / nx % ny, n / nx / ny].map(|i| i as f64);
        Volume::new(grid, (0..grid.count()).map(|n| sample(at(n))).collect()).unwrap()
    }

    #[test]
    fn what_rises_evenly_stays_where_it_was() {
        let ramp = volume([9, 6, 5], |[x, y, z]| (2.0 * x - y + 4.0 * z) as i16);
        let ramp = ramp.with_scaling(Scaling::new(-0.5, 1.0).unwrap());
        for axes in [[true; 3], [true, false, false], [false, true, true]] {
            let AnyVolume::F32(half) = halved(&ramp.view(), axes, &Job::default()).unwrap() else {
                panic!("means of i16 are f32")
            };
            let steps = axes.map(|is_halved| if is_halved { 2 } else { 1 });
            let dims: [usize; 3] = std::array::from_fn(|k| [9_usize, 6, 5][k].div_ceil(steps[k]));
            let (view, before) = (half.view(), ramp.view());
            assert_eq!((view.dims(), view.scaling()), (dims, before.scaling()));
            for k in 0..dims[2] {
                for (j, i) in (0..dims[1]).flat_map(|j| (0..dims[0]).map(move |i| (j, i))) {
                    let (new, old) = ([i, j, k], [i * steps[0], j * steps[1], k * steps[2]]);
                    let place = |ijk: [usize; 3], view: &isokit_geom::Affine| {
                        view.point(ijk.map(|i| i as f64))
                    };
                    let world = [
                        place(new, &view.frame().index_to_world),
                        place(old, &before.frame().index_to_world),
                    ];
                    assert_eq!(world[0], world[1]);
                    let is_inner = (0..3).all(|axis| {
                        steps[axis] == 1 || old[axis] > 0 && old[axis] + 1 < [9, 6, 5][axis]
                    });
                    if is_inner {
                        assert_eq!(view.value(new), before.value(old));
                    }
                }
            }
        }
    }

    #[test]
    fn waves_of_two_samples_vanish_and_nothing_is_made_of_what_is_missing() {
        let wave = volume([9, 4, 4], |[x, ..]| if x % 2.0 == 0.0 { 1.0 } else { -1.0 });
        let AnyVolume::F64(half) =
            halved(&wave.view(), [true, false, false], &Job::default()).unwrap()
        else {
            panic!("means of f64 are f64")
        };
        assert_eq!(half.samples()[1..4], [0.0; 3]);
        let holes =
            volume([5, 4, 4], |[x, ..]| [1.0_f32, f32::NAN, 5.0, f32::NAN, f32::NAN][x as usize]);
        let AnyVolume::F32(half) = halved(&holes.view(), [true; 3], &Job::default()).unwrap()
        else {
            panic!("means of f32 are f32")
        };
        assert_eq!(half.samples()[..2], [1.0, 5.0]);
        assert!(half.samples()[2].is_nan());
    }

    #[test]
    fn threads_change_no_bit() {
        let chance =
            volume([33, 20, 17], |[x, y, z]| ((x * 12.9 + y * 78.2 + z * 37.7).sin() * 4e4) as f32);
        let halves = [1, 2, 7].map(|threads| {
            let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
            halved(&chance.view(), [true; 3], &Job { threads, ..Job::default() }).unwrap()
        });
        assert!(halves[0] == halves[1] && halves[0] == halves[2]);
    }
}
