//! How much weights are together, bounds, and what cannot be.

use super::{convolved, noise, places, volume};
use crate::{Convolved, Filter, Interval, ScalarField, SeparableKernel, Window, kit::filters};
use isokit_geom::Aabb;
use isokit_job::{CancelToken, Job, Limits, Threads};
use std::num::NonZeroUsize;

#[test]
fn weights_are_together_no_more_than_is_said() {
    for filter in filters() {
        for size in [1, 2, 3, 4, 5, 7, 11, 24] {
            let line = volume([size, 1, 1], |_| 0.0);
            let field = convolved(&line, filter);
            let line = field.line(0);
            let [inner, any] = line.stretches();
            let last = (size - 1) as f64;
            let mut most = [0.0_f64; 2];
            for n in 0..=2000 {
                let x = last * f64::from(n) / 2000.0;
                let stencil = line.stencil(x, 0);
                let ones = vec![1.0; stencil.numbers().len()];
                assert!((stencil.sum(0, &ones) - 1.0).abs() < 1e-13, "{filter:?}, {size}, {x}");
                let together: f64 =
                    (0..ones.len()).filter_map(|n| stencil.weight(0, n)).map(f64::abs).sum();
                let is_border = x < line.reach() || x > last - line.reach();
                most[usize::from(is_border)] = most[usize::from(is_border)].max(together);
                assert!(
                    together <= [inner, any][usize::from(is_border)] + 1e-14,
                    "{filter:?}, {size}, {x}"
                );
            }
            // And hardly less.
            assert!(size < 24 || inner - most[0] < 0.01, "{filter:?}: {inner}, {most:?}");
            assert!(size < 24 || line.reach() == 0.0 || any - most[1] < 0.02, "{filter:?}: {any}");
        }
    }
}

#[test]
fn bounds_are_those_of_the_samples_where_weights_are_balanced_and_unknown_of_wide_kernels() {
    let volume = volume([20, 20, 20], noise);
    let ijk = Aabb { min: [8.0; 3], max: [9.0; 3] };
    let bounds = convolved(&volume, Filter::Linear).bounds(ijk);
    let around = |ijk: [usize; 3]| ijk.iter().all(|c| (8..10).contains(c));
    let places = (0..8000).map(|n| [n % 20, n / 20 % 20, n / 400]).filter(|ijk| around(*ijk));
    let samples: Vec<f64> = places.map(|ijk| volume.view().stored(ijk)).collect();
    let least = samples.iter().copied().fold(f64::INFINITY, f64::min);
    let most = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert!(bounds.low <= least && bounds.low > least - 1e-9, "{bounds:?}, {least}");
    assert!(bounds.high >= most && bounds.high < most + 1e-9, "{bounds:?}, {most}");
    let wide = convolved(&volume, Filter::Sinc { window: Window::Hann, lobes: 17 });
    assert_eq!(wide.bounds(ijk), Interval::EVERYTHING);
}

#[test]
fn a_spline_is_the_same_for_any_number_of_threads_and_as_a_borrowed_kernel() {
    let volume = volume([37, 21, 18], |p| noise(p) as f32);
    let of = |threads: usize| {
        let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
        let kernel: &dyn SeparableKernel = &Filter::CubicBSpline;
        let job = Job { threads, ..Job::default() };
        let field = Convolved::new(volume.view(), kernel, &job).unwrap();
        places([37, 21, 18]).map(|ijk| field.value(ijk).to_bits()).collect::<Vec<_>>()
    };
    let one = of(1);
    assert!([2, 5].into_iter().all(|threads| of(threads) == one));
    let own = convolved(&volume, Filter::CubicBSpline);
    assert!(places([37, 21, 18]).map(|ijk| own.value(ijk).to_bits()).eq(one));
}

/// A kernel that reaches as far as is said.
struct Reaching(f64);

impl SeparableKernel for Reaching {
    fn radius(&self) -> f64 {
        self.0
    }

    fn weight(&self, distance: f64) -> f64 {
        Filter::Linear.weight(distance)
    }

    fn slope(&self, distance: f64) -> f64 {
        Filter::Linear.slope(distance)
    }

    fn bend(&self, _: f64) -> f64 {
        0.0
    }
}

#[test]
fn what_cannot_be_is_refused_and_kernels_that_make_no_sense_make_no_values() {
    let small = volume([9, 9, 9], |p| noise(p) as i16);
    let of = |kernel: &dyn SeparableKernel, job: &Job| {
        Convolved::new(small.view(), kernel, job).err().unwrap().to_string()
    };
    let limited = Job { limits: Limits { bytes: 4 * 9 * 9 * 11 - 1 }, ..Job::default() };
    assert!(of(&Filter::CubicBSpline, &limited).contains("bytes"));
    // Nothing is kept of samples.
    assert!(Convolved::new(small.view(), Filter::MITCHELL, &limited).is_ok());
    let cancel = CancelToken::default();
    cancel.cancel();
    let cancelled = Job { cancel, ..Job::default() };
    assert!(of(&Filter::QuadraticBSpline, &cancelled).contains("cancelled"));
    for radius in [2e9, f64::INFINITY] {
        assert!(of(&Reaching(radius), &Job::default()).contains("along x"));
    }
    for radius in [f64::NAN, -3.0, f64::NEG_INFINITY, 0.0, 0.3] {
        let field = Convolved::new(small.view(), Reaching(radius), &Job::default()).unwrap();
        let everywhere = Aabb { min: [0.0; 3], max: [8.0; 3] };
        let bounds = field.bounds(everywhere);
        for place in [[2.5, 0.25, 8.0], [2.5, 2.0, 2.0], [3.1, 4.0, 4.9], [1.0, 2.0, 3.0]] {
            let value = field.jet(place).value;
            let is_within = value.is_nan() || bounds.contains(value);
            assert!(is_within, "{radius}, {place:?}: {value} beyond {bounds:?}");
        }
        let between = field.bounds(Aabb { min: [2.4, 2.0, 2.0], max: [2.6, 3.0, 3.0] });
        assert_eq!(between, Interval::EVERYTHING, "{radius}");
    }
    // Wider than it says, it is the same but for the border.
    let (wide, plain) = (Reaching(1.5), convolved(&small, Filter::Linear));
    let wide = Convolved::new(small.view(), wide, &Job::default()).unwrap();
    assert_eq!(wide.value([2.25, 3.5, 4.75]), plain.value([2.25, 3.5, 4.75]));
}
