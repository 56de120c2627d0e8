//! Against the definition, sample by sample; and what must hold of any kernel.

use super::{ResampleError, resample, resample_nearest};
use crate::{Filter, SeparableKernel, kit::filters};
use isokit_geom::{Affine, Frame};
use isokit_job::{CancelToken, Job, Limits, Threads};
use isokit_volume::{AnyVolume, Grid, Sample, Scaling, Volume};
use std::num::NonZeroUsize;

/// Samples of a function of index space, 0.5, 1 and 2 from each other.
fn volume<T: Sample>(dims: [u64; 3], sample: impl Fn([f64; 3]) -> T) -> Volume<T> {
    let index_to_world = Affine::axis_aligned(SPACING, [3.0, -1.0, 0.0]).unwrap();
    let grid = Grid::new(dims, Frame { index_to_world, ..Frame::default() }).unwrap();
    let [nx, ny, _] = dims;
    let at = |n: u64| [n % nx, n / nx % ny, n / nx / ny].map(|i| i as f64);
    Volume::new(grid, (0..grid.count()).map(|n| sample(at(n))).collect()).unwrap()
}

const SPACING: [f64; 3] = [0.5, 1.0, 2.0];

fn chance<T>(number: fn(u64) -> T) -> impl Fn([f64; 3]) -> T {
    move |[x, y, z]| {
        let mut state = (x + 100.0 * y + 10_000.0 * z) as u64 + 17;
        for _ in 0..3 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            state ^= state >> 29;
        }
        number(state >> 40)
    }
}

/// The samples of f64 that are as many times as far from each other.
fn resampled<T: Sample>(volume: &Volume<T>, filter: Filter, times: [f64; 3]) -> (Grid, Vec<f64>) {
    let spacing = std::array::from_fn(|k| SPACING[k] * times[k]);
    match resample(&volume.view(), &filter, spacing, &Job::default()).unwrap() {
        AnyVolume::F32(made) => {
            (*made.grid(), made.samples().iter().map(|&sample| sample.into()).collect())
        }
        AnyVolume::F64(made) => (*made.grid(), made.samples().to_vec()),
        other => panic!("{}", other.dtype()),
    }
}

#[test]
fn the_lattice_begins_where_it_was_and_ends_no_farther() {
    let flat = volume([9, 5, 1], |_| 1.0_f32);
    for (times, dims) in [
        ([1.0; 3], [9, 5, 1]),
        ([0.5, 0.25, 0.1], [17, 17, 1]),
        ([3.0, 1.5, 7.0], [3, 3, 1]),
        // A tenth is no number of two digits: eight steps of it are 80 all the same.
        ([0.1, 0.3, 1.0], [81, 14, 1]),
        ([8.0, 4.0, 1.0], [2, 2, 1]),
        ([8.1, 9.0, 1.0], [1, 1, 1]),
        ([1e30, 1e12, 1e9], [1, 1, 1]),
    ] {
        let (grid, samples) = resampled(&flat, Filter::Linear, times);
        assert_eq!(grid.dims(), dims, "{times:?}");
        assert!(samples.iter().all(|sample| (sample - 1.0).abs() < 1e-6));
        let affine = grid.frame.index_to_world;
        assert_eq!(affine.origin(), [3.0, -1.0, 0.0]);
        for k in 0..3 {
            assert!((affine.spacing()[k] - times[k] * SPACING[k]).abs() < 1e-12);
        }
    }
}

#[test]
fn what_is_flat_or_rises_evenly_stays_so_up_to_the_border() {
    let ramp = |[x, y, z]: [f64; 3]| 3.0 + 2.0 * x - y + 0.5 * z;
    for filter in filters() {
        for dims in [[12, 9, 7], [2, 3, 4], [1, 1, 5], [1, 1, 1]] {
            for times in [[0.3, 0.5, 0.7], [1.0; 3], [0.4, 1.9, 1.0], [2.0, 3.0, 1.3]] {
                let (_, samples) = resampled(&volume(dims, |_| -7.25), filter, times);
                assert!(samples.iter().all(|sample| (sample + 7.25).abs() < 1e-12), "{filter:?}");
                // With kernels whose weights are balanced at every place, and not only where all are.
                let is_wider = times.iter().any(|times| *times > 1.0);
                let is_balanced =
                    !matches!(filter, Filter::Nearest | Filter::Sinc { .. }) && !is_wider;
                if !is_balanced || dims == [1; 3] {
                    continue;
                }
                let (grid, samples) = resampled(&volume(dims, ramp), filter, times);
                let [nx, ny, _] = grid.dims();
                for (n, sample) in (0..).zip(&samples) {
                    let ijk = [n % nx, n / nx % ny, n / nx / ny].map(|i| i as f64);
                    let expected = ramp([0, 1, 2].map(|k| ijk[k] * times[k]));
                    assert!(
                        (sample - expected).abs() < 1e-11,
                        "{filter:?}, {dims:?}, {times:?}, {ijk:?}: {sample} for {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn splines_keep_cubics_and_parabolas_up_to_the_border() {
    for (filter, degree) in
        [(Filter::CubicBSpline, 3), (Filter::QuadraticBSpline, 2), (Filter::CATMULL_ROM, 2)]
    {
        for size in degree as u64 + 1..15 {
            let of = |x: f64| 0.3 * x.powi(degree) - 2.0 * x * x + 4.0 * x - 1.0;
            let line = volume([1, size, 1], |[_, y, _]| of(y));
            let (_, samples) = resampled(&line, filter, [1.0, 0.125, 1.0]);
            for (n, sample) in samples.iter().enumerate() {
                let expected = of(n as f64 * 0.125);
                let off = (sample - expected).abs() / (1.0 + expected.abs());
                assert!(off < 1e-11, "{filter:?}, {size}, {n}: {sample} for {expected}");
            }
        }
    }
}

#[test]
fn filters_that_interpolate_go_through_the_samples() {
    let noise = volume([13, 8, 9], chance(|n| (n % 1000) as f64));
    for filter in filters() {
        let smooths = [Filter::SmoothQuadratic, Filter::MITCHELL, Filter::CubicBSpline.smoothing()];
        if smooths.contains(&filter) {
            continue;
        }
        assert_eq!(resampled(&noise, filter, [1.0; 3]).1, noise.samples(), "{filter:?}");
        let (grid, samples) = resampled(&noise, filter, [0.5, 0.25, 0.5]);
        let [nx, ny, _] = grid.dims();
        for (n, sample) in (0..).zip(&samples) {
            let ijk = [n % nx, n / nx % ny, n / nx / ny];
            if ijk[0] % 2 == 0 && ijk[1] % 4 == 0 && ijk[2] % 2 == 0 {
                let own =
                    noise.view().stored([ijk[0] / 2, ijk[1] / 4, ijk[2] / 2].map(|i| i as usize));
                assert!((sample - own).abs() < 1e-11, "{filter:?}, {ijk:?}: {sample} for {own}");
            }
        }
    }
}

/// The definition inside: the sum over all samples, weighed by three products.
fn sum(
    noise: &Volume<f64>,
    weight: &dyn Fn(f64) -> f64,
    place: [f64; 3],
    stretch: [f64; 3],
) -> f64 {
    let dims = noise.view().dims();
    let of = |axis: usize| -> Vec<f64> {
        let weights: Vec<f64> =
            (0..dims[axis]).map(|i| weight((place[axis] - i as f64) / stretch[axis])).collect();
        let sum: f64 = weights.iter().sum();
        weights.iter().map(|weight| weight / sum).collect()
    };
    let [x, y, z] = [of(0), of(1), of(2)];
    let mut sum = 0.0;
    for (k, z) in z.iter().enumerate() {
        for (j, y) in y.iter().enumerate() {
            for (i, x) in x.iter().enumerate() {
                sum += x * y * z * noise.view().stored([i, j, k]);
            }
        }
    }
    sum
}

#[test]
fn far_from_the_border_samples_are_sums_of_all_weighed_by_the_kernel() {
    let noise = volume([19, 34, 23], chance(|n| (n % 1000) as f64));
    for filter in filters().into_iter().filter(|filter| filter.spline().is_none()) {
        for times in [[0.7, 0.9, 0.3], [1.0, 1.7, 0.6], [1.3, 2.5, 1.9]] {
            let stretch = times.map(|times: f64| times.max(1.0));
            let (grid, samples) = resampled(&noise, filter, times);
            let [nx, ny, _] = grid.dims();
            let mut found = 0;
            for (n, sample) in (0..).zip(&samples) {
                let ijk = [n % nx, n / nx % ny, n / nx / ny];
                let place = [0, 1, 2].map(|k| ijk[k] as f64 * times[k]);
                let is_within = (0..3).all(|k| {
                    let reach = filter.radius() * stretch[k];
                    let last = noise.view().dims()[k] as f64 - 1.0;
                    place[k] > reach && place[k] < last - reach
                });
                if !is_within || n % 61 != 0 {
                    continue;
                }
                let expected = sum(&noise, &|t| filter.weight(t), place, stretch);
                assert!((sample - expected).abs() < 1e-9, "{filter:?}, {times:?}, {ijk:?}");
                found += 1;
            }
            assert!(found > 0 || filter.radius() > 4.0, "{filter:?}, {times:?}");
        }
    }
}

#[test]
fn splines_of_farther_samples_are_wider_splines() {
    // What one sample makes is the spline through it and zeros, as wide as new samples are from each other.
    let dims = [1, 1, 401];
    let one = volume(dims, |[_, _, z]| if z == 200.0 { 1.0_f64 } else { 0.0 });
    for filter in [Filter::CubicBSpline, Filter::QuadraticBSpline] {
        let narrow = volume([1, 1, 101], |[_, _, z]| if z == 50.0 { 1.0_f64 } else { 0.0 });
        let (_, spline) = resampled(&narrow, filter, [1.0, 1.0, 0.25]);
        let (_, wide) = resampled(&one, filter, [1.0, 1.0, 4.0]);
        assert_eq!(wide.len(), 101);
        for (n, wide) in wide.iter().enumerate() {
            let distance = n as f64 - 50.0;
            let place = (200.0 + 4.0 * distance) as usize;
            assert!((wide - 0.25 * spline[place]).abs() < 1e-8, "{filter:?}, {n}: {wide}");
        }
    }
}

#[test]
fn waves_that_new_samples_cannot_hold_are_left_out() {
    // Three samples to a wave, of which every fourth is kept: told plainly, it would be one of other length.
    let waves = volume([120, 1, 1], |[x, _, _]| (x * std::f64::consts::TAU / 3.0).cos());
    for filter in filters().into_iter().filter(|filter| *filter != Filter::Nearest) {
        let (_, samples) = resampled(&waves, filter, [4.0, 1.0, 1.0]);
        let inner = &samples[8..samples.len() - 8];
        let most = inner.iter().fold(0.0_f64, |most, sample| most.max(sample.abs()));
        assert!(most < 0.08, "{filter:?}: {most}");
    }
}

/// The greatest error of a filter, of samples so far from each other of a wave.
fn error(filter: Filter, apart: f64) -> f64 {
    let of = |x: f64| (2.0 * x + 0.3).sin();
    let size = (3.0 / apart).round() as u64 + 1;
    let line = volume([size, 1, 1], |[x, _, _]| of(x * apart));
    let (_, samples) = resampled(&line, filter, [0.2, 1.0, 1.0]);
    let off =
        samples.iter().enumerate().map(|(n, sample)| (sample - of(n as f64 * 0.2 * apart)).abs());
    off.fold(0.0, f64::max)
}

#[test]
fn errors_fall_with_the_distance_of_samples_as_fast_as_said_up_to_the_border() {
    for (filter, order) in [
        (Filter::Linear, 2.0),
        (Filter::QuadraticBSpline, 3.0),
        (Filter::CATMULL_ROM, 3.0),
        (Filter::CubicBSpline, 4.0),
    ] {
        let [coarse, fine] = [error(filter, 0.05), error(filter, 0.0125)];
        let found = (coarse / fine).log2() / 2.0;
        assert!((found - order).abs() < 0.3, "{filter:?}: {found}, from {coarse} to {fine}");
    }
    assert!(error(Filter::CubicBSpline, 0.05) < 0.2 * error(Filter::CATMULL_ROM, 0.05));
}

#[test]
fn meaning_and_type_stay_and_labels_stay_labels() {
    let stored = chance(|n| (n % 200) as u8);
    let labels = volume([9, 7, 5], stored).with_scaling(Scaling::new(-0.5, 3.0).unwrap());
    let job = Job::default();
    let AnyVolume::F32(made) =
        resample(&labels.view(), &Filter::CubicBSpline, SPACING, &job).unwrap()
    else {
        panic!("u8 becomes f32");
    };
    assert_eq!(made.scaling(), labels.scaling());
    assert!(
        made.samples().iter().zip(labels.samples()).all(|(made, own)| *made == f32::from(*own))
    );
    let wide = volume([4, 4, 4], chance(|n| n as i32 - (1 << 23)));
    let made = resample(&wide.view(), &Filter::Linear, SPACING, &job).unwrap();
    assert!(matches!(made, AnyVolume::F64(made) if made.samples().len() == 64));
    let spacing = [0.2, 2.2, 2.0];
    let few = resample_nearest(&labels.view(), spacing, &job).unwrap();
    assert_eq!((few.grid().dims(), few.scaling()), ([21, 3, 5], labels.scaling()));
    for (n, sample) in few.samples().iter().enumerate() {
        let ijk = [n % 21, n / 21 % 3, n / 63];
        let nearest = [0, 1, 2].map(|k| (ijk[k] as f64 * spacing[k] / SPACING[k]).round() as usize);
        assert_eq!(*sample, labels.view().stored(nearest), "{ijk:?}");
    }
}

#[test]
fn the_bytes_are_the_same_for_any_number_of_threads_and_order_of_axes() {
    let noise = volume([37, 21, 18], chance(|n| n as f32));
    let spacing = [0.3, 1.7, 1.1];
    let of = |filter: Filter, threads: usize| {
        let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
        let job = Job { threads, ..Job::default() };
        resample(&noise.view(), &filter, spacing, &job).unwrap()
    };
    for filter in filters() {
        let one = of(filter, 1);
        assert!([2, 7].map(|threads| of(filter, threads)).iter().all(|other| *other == one));
    }
    // Samples that lie z fastest.
    let turned =
        volume([18, 21, 37], |[z, y, x]| noise.view().stored([x, y, z].map(|i| i as usize)));
    let (grid, strides) = (*noise.grid(), [378, 18, 1]);
    let view = isokit_volume::View::strided(turned.samples(), 0, strides, &grid).unwrap();
    let made = resample(&view, &Filter::CubicBSpline, spacing, &Job::default()).unwrap();
    assert!(made == of(Filter::CubicBSpline, 1));
}

#[test]
fn a_sample_that_is_no_number_is_missed_near_it_and_refused_by_splines() {
    let hole = volume([20, 20, 20], |ijk| if ijk == [9.0, 10.0, 11.0] { f32::NAN } else { 1.0 });
    let job = Job::default();
    let refused = resample(&hole.view(), &Filter::CubicBSpline, [0.2, 0.5, 1.0], &job).unwrap_err();
    assert!(
        matches!(refused, ResampleError::NotFinite { at: [9, 10, 11], value } if value.is_nan())
    );
    for filter in [Filter::CATMULL_ROM, Filter::Linear, Filter::CubicBSpline.smoothing()] {
        let (grid, samples) = resampled(&hole, filter, [0.5; 3]);
        let [nx, ny, _] = grid.dims();
        for (n, sample) in (0..).zip(&samples) {
            let ijk = [n % nx, n / nx % ny, n / nx / ny];
            let is_near = (0..3).all(|k| {
                let off = 0.5 * ijk[k] as f64 - [9.0, 10.0, 11.0][k];
                filter.weight(off) != 0.0
            });
            assert_eq!(sample.is_nan(), is_near, "{filter:?}, {ijk:?}");
        }
    }
}

#[test]
fn what_cannot_be_is_refused_before_memory_is_taken() {
    let small = volume([9, 9, 9], |_| 0_i16);
    let of = |spacing, job: &Job| {
        resample(&small.view(), &Filter::Linear, spacing, job).unwrap_err().to_string()
    };
    let job = Job::default();
    for (spacing, says) in [
        ([0.0, 1.0, 1.0], "samples are to be 0 from each other along x"),
        ([1.0, -2.0, 1.0], "-2 from each other along y"),
        ([1.0, 1.0, f64::NAN], "NaN from each other along z"),
        ([1.0, f64::INFINITY, 1.0], "inf from each other along y"),
        ([1e-12, 1.0, 1.0], "along x are more than"),
        ([1.0, 1e-300, 1.0], "along y are more than"),
    ] {
        let said = of(spacing, &job);
        assert!(said.contains(says), "{said}");
        let nearest = resample_nearest(&small.view(), spacing, &job).unwrap_err().to_string();
        assert!(nearest.contains(says), "{nearest}");
    }
    let limited = Job { limits: Limits { bytes: 1 << 20 }, ..Job::default() };
    assert!(of([1e-3, 1e-3, 1e-3], &limited).contains("bytes"));
    let cancel = CancelToken::default();
    cancel.cancel();
    let cancelled = Job { cancel, ..Job::default() };
    assert!(of([1.0; 3], &cancelled).contains("cancelled"));
}
