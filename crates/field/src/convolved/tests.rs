//! Convolutions against resampling, against sums over all samples, and by what holds for any kernel.

mod limits;
mod marschner_lobb;

use super::Convolved;
use crate::{
    Filter, ResampleError, ScalarField, SeparableKernel, conformance::check, kit::filters, resample,
};
use isokit_job::Job;
use isokit_volume::{AnyVolume, Grid, Sample, Scaling, Volume};

fn volume<T: Sample>(dims: [usize; 3], sample: impl Fn([f64; 3]) -> T) -> Volume<T> {
    let [nx, ny, nz] = dims;
    let grid = Grid::new(dims.map(|n| n as u64), Default::default()).unwrap();
    let point = |n: usize| [n % nx, n / nx % ny, n / nx / ny].map(|i| i as f64);
    Volume::new(grid, (0..nx * ny * nz).map(|n| sample(point(n))).collect()).unwrap()
}

/// From −500 to 500, as by chance.
fn noise([x, y, z]: [f64; 3]) -> f64 {
    let mut state = (x + 100.0 * y + 10_000.0 * z) as u64 + 17;
    for _ in 0..3 {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        state ^= state >> 29;
    }
    (state >> 40) as f64 % 1000.0 - 500.0
}

fn waves([x, y, z]: [f64; 3]) -> f64 {
    (0.37 * x + 0.3).sin() + 0.5 * (0.41 * y).cos() * z
}

fn convolved<T: Sample>(volume: &Volume<T>, filter: Filter) -> Convolved<'_, T, Filter> {
    Convolved::new(volume.view(), filter, &Job::default()).unwrap()
}

/// Places all over a lattice, on its border, on faces of cells, and a little beyond.
fn places(dims: [usize; 3]) -> impl Iterator<Item = [f64; 3]> {
    (0..250).map(move |n: u32| {
        std::array::from_fn(|axis| {
            let share = f64::from(n * [37, 101, 53][axis] % 211) / 210.0;
            let place = share * (dims[axis] as f64 - 0.5) - 0.25;
            if (n + axis as u32).is_multiple_of(7) { place.round() } else { place }
        })
    })
}

#[test]
fn all_kernels_conform_on_what_is_smooth_and_on_noise() {
    for filter in filters() {
        for dims in [[13, 12, 15], [4, 7, 5], [3, 2, 1], [1, 1, 1]] {
            check(&convolved(&volume(dims, waves), filter));
            let scaling = Scaling::new(-0.5, 3.0).unwrap();
            check(&convolved(&volume(dims, |p| noise(p) as i16).with_scaling(scaling), filter));
            check(&convolved(&volume(dims, |p| noise(p) as f32).with_scaling(scaling), filter));
        }
    }
}

#[test]
fn kernels_conform_on_samples_that_are_no_numbers() {
    let holes = |p| match noise(p) {
        x if x > 485.0 => f64::NAN,
        x if x > 470.0 => f64::INFINITY,
        x if x > 455.0 => 1e300,
        x => x,
    };
    for filter in filters().into_iter().filter(|filter| filter.spline().is_none()) {
        for dims in [[11, 9, 8], [3, 6, 1]] {
            check(&convolved(&volume(dims, holes), filter));
        }
    }
}

/// The samples of f64 that are as many times as far from each other.
fn resampled<T: Sample>(volume: &Volume<T>, filter: Filter, times: [f64; 3]) -> Volume<f64> {
    let made = resample(&volume.view(), &filter, times, &Job::default()).unwrap();
    match made {
        AnyVolume::F64(made) => made,
        AnyVolume::F32(made) => {
            let samples = made.samples().iter().map(|&sample| sample.into()).collect();
            Volume::new(*made.grid(), samples).unwrap().with_scaling(made.scaling())
        }
        other => panic!("{}", other.dtype()),
    }
}

/// Compares a field with what is resampled at the same places.
fn compare<T: Sample>(volume: &Volume<T>, filter: Filter, near: f64) {
    for times in [[0.3, 0.5, 0.7], [1.0, 0.25, 0.9], [1.0; 3]] {
        let (field, made) = (convolved(volume, filter), resampled(volume, filter, times));
        let [nx, ny, _] = made.view().dims();
        for n in 0..made.samples().len() {
            let ijk = [n % nx, n / nx % ny, n / nx / ny];
            let place = [0, 1, 2]
                .map(|k| (ijk[k] as f64 * times[k]).min((volume.view().dims()[k] - 1) as f64));
            let (found, expected) = (field.value(place), made.view().value(ijk));
            let off = (found - expected).abs();
            assert!(off <= near, "{filter:?}, {times:?}, {ijk:?}: {found} for {expected}");
        }
    }
}

#[test]
fn values_are_those_of_resampling_to_the_bit_but_for_splines_and_single_precision() {
    for filter in filters() {
        for dims in [[9, 7, 8], [2, 3, 1]] {
            let is_spline = filter.spline().is_some();
            compare(&volume(dims, noise), filter, if is_spline { 1e-9 } else { 0.0 });
            compare(&volume(dims, |p| noise(p) as i32), filter, if is_spline { 1e-9 } else { 0.0 });
            // 2⁻²⁴ of 500 for each of a few operations along three axes.
            compare(&volume(dims, |p| noise(p) as f32), filter, 1e-3);
            compare(&volume(dims, |p| noise(p) as i16), filter, 1e-3);
        }
    }
}

/// The weights of all samples of a line for a value at a place, as the definition has them, of a line that goes on as it should.
fn all_weights(filter: Filter, x: f64, size: usize) -> Vec<f64> {
    let mut weights = vec![0.0; size];
    let beyond = 12 + size as i64;
    let of = |i: i64| filter.weight(x - i as f64);
    let sum: f64 = (-beyond..beyond + size as i64).map(of).sum();
    for i in -beyond..beyond + size as i64 {
        let weight = of(i) / sum;
        let last = size as i64 - 1;
        match i {
            i if (0..=last).contains(&i) => weights[i as usize] += weight,
            i => {
                let [end, inner]: [i64; 2] = if i < 0 { [0, 1] } else { [last, -1] };
                let steps = if i < 0 { -i } else { i - last };
                if filter.radius() > 2.0 {
                    weights[end as usize] += 2.0 * weight;
                    weights[(end + inner * steps.min(last)) as usize] -= weight;
                    continue;
                }
                // Lagrange's polynomials of the last four.
                let nodes = size.min(4) as i64;
                for node in 0..nodes {
                    let others = (0..nodes).filter(|other| *other != node);
                    let factors = others.map(|o| (-steps - o) as f64 / (node - o) as f64);
                    weights[(end + inner * node) as usize] += weight * factors.product::<f64>();
                }
            }
        }
    }
    weights
}

#[test]
fn values_are_sums_over_all_samples() {
    for filter in filters().into_iter().filter(|filter| filter.spline().is_none()) {
        for dims in [[9, 7, 8], [2, 3, 1], [5, 12, 4]] {
            let (volume, scaling) = (volume(dims, noise), Scaling::new(0.25, -7.0).unwrap());
            let volume = volume.with_scaling(scaling);
            let field = convolved(&volume, filter);
            for ijk in places(dims) {
                let [x, y, z] = [0, 1, 2].map(|axis| all_weights(filter, ijk[axis], dims[axis]));
                let mut sum = 0.0;
                for (k, z) in z.iter().enumerate() {
                    for (j, y) in y.iter().enumerate() {
                        for (i, x) in x.iter().enumerate() {
                            sum += x * y * z * noise([i, j, k].map(|i| i as f64));
                        }
                    }
                }
                let (found, expected) = (field.value(ijk), scaling.value(sum));
                assert!((found - expected).abs() < 1e-10, "{filter:?}, {ijk:?}: {found}");
            }
        }
    }
}

#[test]
fn what_is_flat_stays_flat_with_no_slope_and_no_bend() {
    for filter in filters() {
        for dims in [[8, 9, 7], [2, 1, 3]] {
            let flat = volume(dims, |_| -7.25);
            let field = convolved(&flat, filter);
            for ijk in places(dims) {
                let jet = field.jet(ijk);
                let parts = jet.gradient.iter().chain(jet.hessian.as_flattened());
                let most = parts.fold((jet.value + 7.25).abs(), |most, x| most.max(x.abs()));
                assert!(most < 1e-12, "{filter:?}, {ijk:?}: {jet:?}");
            }
        }
    }
}

/// A polynomial with two derivatives.
fn polynomial(degree: usize, x: f64) -> [f64; 3] {
    let c = [0.7, -1.3, 0.45, 0.031];
    let term = |order: usize| {
        let of = |n: usize| {
            let factor: usize = (n + 1 - order..=n).product();
            factor as f64 * c[n] * x.powi((n - order) as i32)
        };
        (order..=degree).map(of).sum()
    };
    [term(0), term(1), term(2)]
}

#[test]
fn polynomials_of_their_degree_are_kept_with_derivatives_up_to_the_border_and_beyond() {
    for (filter, degree, derivatives) in [
        (Filter::Linear, 1, 1),
        (Filter::QuadraticBSpline, 2, 2),
        (Filter::CubicBSpline, 3, 2),
        (Filter::CATMULL_ROM, 2, 2),
        (Filter::SmoothQuadratic, 1, 2),
        (Filter::MITCHELL, 1, 2),
    ] {
        for size in degree + 1..10 {
            let dims = [size, size + 1, size + 2];
            let of = |p: [f64; 3]| p.map(|x| polynomial(degree, x)[0]).iter().product::<f64>();
            let volume = volume(dims, of);
            let field = convolved(&volume, filter);
            for ijk in places(dims) {
                let jet = field.jet(ijk);
                let parts = ijk.map(|x| polynomial(degree, x));
                let expected = |orders: [usize; 3]| -> f64 {
                    (0..3).map(|axis| parts[axis][orders[axis]]).product()
                };
                let scale: f64 =
                    dims.iter().map(|&n| 1.0 + polynomial(degree, n as f64)[0].abs()).product();
                let near = |found: f64, orders: [usize; 3]| {
                    let off = (found - expected(orders)).abs();
                    assert!(off < 1e-11 * scale, "{filter:?}, {ijk:?}, {orders:?}: {found}");
                };
                near(jet.value, [0; 3]);
                for a in 0..3 {
                    near(jet.gradient[a], [0, 1, 2].map(|k| usize::from(k == a)));
                    for b in 0..3 {
                        let orders = [0, 1, 2].map(|k| usize::from(k == a) + usize::from(k == b));
                        if orders.iter().all(|order| *order <= derivatives) {
                            near(jet.hessian[a][b], orders);
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn kernels_that_interpolate_go_through_the_samples() {
    let dims = [9, 6, 7];
    let noise = volume(dims, noise);
    for filter in filters() {
        let smooths = [Filter::SmoothQuadratic, Filter::MITCHELL, Filter::CubicBSpline.smoothing()];
        let field = convolved(&noise, filter);
        let mut most = 0.0_f64;
        for n in 0..dims.iter().product() {
            let ijk = [n % 9, n / 9 % 6, n / 54];
            let off = field.value(ijk.map(|i| i as f64)) - noise.view().stored(ijk);
            most = most.max(off.abs());
        }
        let is_near = if filter.spline().is_some() { most < 1e-9 } else { most == 0.0 };
        assert_eq!(is_near, !smooths.contains(&filter), "{filter:?}: {most}");
    }
}

#[test]
fn gradients_and_hessians_are_those_of_differences() {
    let dims = [9, 8, 10];
    let volume = volume(dims, noise);
    for filter in filters().into_iter().filter(|filter| *filter != Filter::Nearest) {
        let field = convolved(&volume, filter);
        // Away from edges of the kernels.
        for ijk in places(dims).map(|p| p.map(|c| (c * 8.0).floor() / 8.0 + 0.0573)) {
            let jet = field.jet(ijk);
            for axis in 0..3 {
                let [low, high] = [-1e-5, 1e-5].map(|step| {
                    let mut place = ijk;
                    place[axis] += step;
                    field.jet(place)
                });
                let near = |low: f64, high: f64, slope: f64| {
                    let found = (high - low) / 2e-5;
                    assert!((found - slope).abs() < 1e-3, "{filter:?}, {ijk:?}: {slope}, {found}");
                };
                near(low.value, high.value, jet.gradient[axis]);
                for part in 0..3 {
                    near(low.gradient[part], high.gradient[part], jet.hessian[part][axis]);
                }
            }
        }
    }
}

#[test]
fn what_is_mirrored_or_turned_has_mirrored_or_turned_derivatives() {
    let dims = [7, 8, 9];
    let plain = volume(dims, noise);
    let mirrored = volume(dims, |[x, y, z]| noise([6.0 - x, y, z]));
    let turned = volume([9, 7, 8], |[z, x, y]| noise([x, y, z]));
    for filter in filters().into_iter().filter(|filter| *filter != Filter::Nearest) {
        let fields = [&plain, &mirrored, &turned].map(|volume| convolved(volume, filter));
        for ijk @ [x, y, z] in places(dims) {
            let jet = fields[0].jet(ijk);
            let near =
                |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{filter:?}, {ijk:?}: {a} {b}");
            let other = fields[1].jet([6.0 - x, y, z]);
            let sign = |axis: usize| if axis == 0 { -1.0 } else { 1.0 };
            near(jet.value, other.value);
            let around = fields[2].jet([z, x, y]);
            near(jet.value, around.value);
            for a in 0..3 {
                near(jet.gradient[a], sign(a) * other.gradient[a]);
                near(jet.gradient[a], around.gradient[(a + 1) % 3]);
                for b in 0..3 {
                    near(jet.hessian[a][b], sign(a) * sign(b) * other.hessian[a][b]);
                    near(jet.hessian[a][b], around.hessian[(a + 1) % 3][(b + 1) % 3]);
                }
            }
        }
    }
}

#[test]
fn a_sample_that_is_no_number_is_missed_where_it_counts_and_nowhere_else() {
    let hole = volume([12; 3], |ijk| if ijk == [5.0, 6.0, 4.0] { f64::NAN } else { ijk[0] });
    for filter in filters().into_iter().filter(|filter| filter.spline().is_none()) {
        let field = convolved(&hole, filter);
        // As far from the border as no stencil leads over it.
        for n in 0..729 {
            let ijk = [n % 9, n / 9 % 9, n / 81].map(|i| f64::from(i) * 0.5 + 3.25);
            let off = |k: usize| ijk[k] - [5.0, 6.0, 4.0][k];
            let counts = (0..3).all(|k| filter.weight(off(k)) != 0.0);
            let is_inner =
                ijk.iter().all(|c| *c >= filter.radius() && *c <= 11.0 - filter.radius());
            if is_inner {
                assert_eq!(field.value(ijk).is_nan(), counts, "{filter:?}, {ijk:?}");
                assert_eq!(field.is_known(ijk), !counts, "{filter:?}, {ijk:?}");
                let jet = field.jet(ijk);
                assert!(!counts || jet.gradient.iter().all(|part| part.is_nan()), "{filter:?}");
            }
        }
        // At another sample it counts for nothing but derivatives.
        let beside = field.jet([6.0, 6.0, 4.0]);
        let interpolates = filter.weight(1.0) == 0.0;
        assert_eq!(beside.value.is_finite(), interpolates, "{filter:?}");
        assert_eq!(beside.gradient[0].is_nan(), filter != Filter::Nearest, "{filter:?}");
    }
    let refused = Convolved::new(hole.view(), Filter::CubicBSpline, &Job::default()).unwrap_err();
    assert!(matches!(refused, ResampleError::NotFinite { at: [5, 6, 4], value } if value.is_nan()));
}
