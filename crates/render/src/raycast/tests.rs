//! Closed forms, and pictures that must be equal.

use super::{Medium, RaycastError, RaycastOptions, raycast};
use crate::{
    Camera, CameraError, Cast, ControlPoint, Image, Light, OpticalModel, Projection, Size,
    TransferFunction,
};
use isokit_geom::{
    Affine, Frame, HalfSpace,
    vector::{dot, length},
};
use isokit_job::{Job, Threads};
use isokit_volume::{Grid, Sample, Scaling, View, Volume};
use std::num::{NonZeroU32, NonZeroUsize};

mod bricks;
mod kernels;
mod steps;

const PLAIN: RaycastOptions = RaycastOptions::DEFAULT.with_light(None).with_opaque(1.0);

fn volume<T: Sample>(dims: [u64; 3], spacing: f64, f: impl Fn([f64; 3]) -> T) -> Volume<T> {
    let index_to_world = Affine::axis_aligned([spacing; 3], [0.0; 3]).unwrap();
    let grid = Grid::new(dims, Frame { index_to_world, ..Frame::default() }).unwrap();
    let at =
        |n: u64| f([n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]].map(|i| i as f64));
    Volume::new(grid, (0..grid.count()).map(at).collect()).unwrap()
}

/// A grey of the same shade for every value, and an opacity of each.
fn opacities(range: [f64; 2], of: impl Fn(f64) -> f64) -> OpticalModel {
    let point = |n: u32| {
        let value = range[0] + (range[1] - range[0]) * f64::from(n) / 4000.0;
        ControlPoint { value, color: [0.5; 3], opacity: of(value) as f32 }
    };
    TransferFunction::new((0..=4000).map(point).collect()).unwrap().into()
}

fn size(n: u32) -> Size {
    let n = NonZeroU32::new(n).unwrap();
    Size { width: n, height: n }
}

fn medium<'a, T>(view: &'a View<'a, T>, model: &'a OpticalModel) -> Medium<'a, T> {
    Medium { view, bricks: None, model, clips: &[] }
}

fn picture<T: Sample>(
    volume: &Volume<T>,
    model: &OpticalModel,
    (camera, n): (&Camera, u32),
    options: &RaycastOptions,
) -> (Image, Cast) {
    let camera = (camera, size(n));
    raycast(&medium(&volume.view(), model), camera, options, &Job::default()).unwrap()
}

/// Along z through the middle of x and y of a volume, as one pixel sees it.
fn through<T: Sample>(
    volume: &Volume<T>,
    model: &OpticalModel,
    options: &RaycastOptions,
) -> [f64; 2] {
    let bounds = volume.grid().bounds();
    let middle = [0, 1, 2].map(|k| bounds.min[k].midpoint(bounds.max[k]));
    let from = [middle[0], middle[1], bounds.min[2] - 3.0];
    let parallel = Projection::Parallel { height: 1e-6 };
    let camera = Camera::new(from, middle, [0.0, 1.0, 0.0], parallel).unwrap();
    let pixel = picture(volume, model, (&camera, 1), options).0.pixel(0, 0);
    [pixel.color[0].into(), pixel.opacity.into()]
}

#[test]
fn a_slab_of_one_substance_gathers_the_same_at_any_step() {
    for (opacity, unit) in [(0.05, 1.0), (0.3, 2.5), (0.6, 0.8)] {
        let slab = volume([4, 4, 9], 1.5, |_| 7_u8);
        let model = opacities([0.0, 10.0], |_| opacity);
        let exact = 1.0 - (1.0 - f64::from(opacity as f32)).powf(12.0 / unit);
        for step in [0.01, 0.03, 0.1, 0.37, 1.0, 3.0, 100.0] {
            let options = PLAIN.with_step(step).with_unit(Some(unit));
            let [color, found] = through(&slab, &model, &options);
            // Beside what is all but opaque 1200 steps lose a little more.
            let unseen = if step < 0.03 { 2e-6 } else { 1e-6 };
            assert!((found - exact).abs() < unseen, "{opacity}, {step}: {found} for {exact}");
            assert!((color - 0.5 * exact).abs() < unseen, "{opacity}, {step}: {color}");
        }
    }
}

/// The slope of a line through the logarithms of errors at steps that are halved.
fn order(errors: &[f64]) -> f64 {
    let n = errors.len() as f64 - 1.0;
    (errors[0] / errors[errors.len() - 1]).log2() / n
}

#[test]
fn a_ramp_gathers_its_closed_form_at_any_step() {
    // σ = k x: 1 − e^(−k L² / 2).
    let (k, length) = (0.02_f64, 16.0_f64);
    let ramp = volume([3, 3, 17], 1.0, |[_, _, z]| z as f32);
    let model = opacities([0.0, 16.0], |value| -(-k * value).exp_m1());
    let exact = 1.0 - (-k * length * length / 2.0).exp();
    let bent = volume([3, 3, 17], 1.0, |[_, _, z]| (z * z / 16.0) as f32);
    // Piecewise linear between samples: the sum of trapezoids is what trilinear interpolation has.
    let sum: f64 = (0..16).map(|z| f64::from(z * z + (z + 1) * (z + 1)) / 32.0).sum();
    for (volume, exact) in [(ramp, exact), (bent, 1.0 - (-k * sum).exp())] {
        let off = |step: f64| {
            (through(&volume, &model, &PLAIN.with_step(step).with_unit(Some(1.0)))[1] - exact).abs()
        };
        for step in [0.5, 0.25, 0.125] {
            assert!(off(step) < 2e-4, "{step}: {}", off(step));
        }
    }
}

#[test]
fn step_halving_is_of_order_two_where_values_bend() {
    let wave = |z: f64| (z * 0.4).sin();
    let fine = volume([3, 3, 1601], 0.01, |[_, _, z]| wave(z * 0.01) as f32);
    let model = opacities([-1.0, 1.0], |value| 0.1 * (value + 1.0));
    let exact = {
        // The midpoint rule with steps so small that nothing is left.
        let n = 400_000;
        let sum: f64 = (0..n)
            .map(|i| {
                let value = wave((f64::from(i) + 0.5) * 16.0 / f64::from(n));
                (1.0 - 0.1 * (value + 1.0)).ln() * 16.0 / f64::from(n)
            })
            .sum();
        1.0 - sum.exp()
    };
    let steps = [400.0, 200.0, 100.0, 50.0];
    let errors = steps.map(|step| {
        let options = PLAIN.with_step(step).with_unit(Some(1.0));
        (through(&fine, &model, &options)[1] - exact).abs()
    });
    assert!((1.7..2.4).contains(&order(&errors)), "{errors:?}");
}

#[test]
fn the_middle_of_a_gaussian_ball_gathers_what_the_error_function_says() {
    let (radius, n) = (6.0_f64, 49);
    let middle = f64::from(n - 1) / 2.0;
    let ball = volume([n as u64; 3], 1.0, |ijk| {
        let square: f64 = ijk.iter().map(|c| (c - middle) * (c - middle)).sum();
        (-square / (radius * radius)).exp() as f32
    });
    let density = 0.05;
    let model = opacities([0.0, 1.0], |value| -(-density * value).exp_m1());
    // From −24 to 24 the error function is 1 to 2·10⁻⁸.
    let exact = 1.0 - (-density * radius * std::f64::consts::PI.sqrt()).exp();
    let [_, found] = through(&ball, &model, &PLAIN.with_step(0.25).with_unit(Some(1.0)));
    assert!((found - exact).abs() < 1e-3, "{found} for {exact}");
}

/// Blobs of bytes, most of which is 0.
fn blobs() -> Volume<u8> {
    volume([150, 40, 44], 0.8, |[x, y, z]| {
        let blob = |at: [f64; 3], radius: f64| {
            let from = [x - at[0], y - at[1], z - at[2]];
            let square: f64 = from.iter().map(|c| c * c).sum();
            (200.0 * (1.0 - square / (radius * radius))).max(0.0)
        };
        (blob([30.0, 20.0, 20.0], 12.0) + blob([110.0, 15.0, 30.0], 9.0)) as u8
    })
}

fn glowing() -> Vec<ControlPoint> {
    let point = |value: f64, color: &str| ControlPoint::new(value, color.parse().unwrap());
    [point(0.0, "#00000000"), point(40.0, "#20406000"), point(80.0, "#ffc080c0")].into()
}

fn glow() -> OpticalModel {
    TransferFunction::new(glowing()).unwrap().into()
}

fn cameras(volume: &Volume<u8>) -> Vec<Camera> {
    let bounds = volume.grid().bounds();
    let directions =
        [([1.0, 0.0, 0.0], None), ([0.3, -1.0, 0.4], None), ([-0.5, 0.2, 0.9], Some(40.0))];
    let camera =
        |(forward, fov)| Camera::framing(bounds, (forward, [0.1, 0.3, 1.0]), fov, 1.0).unwrap();
    directions.into_iter().map(camera).collect()
}

#[test]
fn any_number_of_threads_makes_the_same_picture() {
    let volume = blobs();
    for camera in cameras(&volume) {
        let (expected, cast) = picture(&volume, &glow(), (&camera, 50), &RaycastOptions::DEFAULT);
        for threads in [1, 2, 7] {
            let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
            let job = Job { threads, ..Job::default() };
            let found = raycast(
                &medium(&volume.view(), &glow()),
                (&camera, size(50)),
                &RaycastOptions::DEFAULT,
                &job,
            );
            assert!(found == Ok((expected.clone(), cast)));
        }
    }
}

#[test]
fn a_ray_that_ends_early_is_off_by_no_more_than_what_was_left() {
    let volume = blobs();
    let camera = &cameras(&volume)[1];
    let (exact, whole) = picture(&volume, &glow(), (camera, 60), &PLAIN);
    for left in [0.25, 0.01, 1.0 / 1024.0] {
        let options = PLAIN.with_opaque(1.0 - left);
        let (found, cast) = picture(&volume, &glow(), (camera, 60), &options);
        assert_eq!(cast.steps + cast.steps_hidden, whole.steps + whole.steps_hidden);
        assert!(cast.steps_hidden > whole.steps_hidden, "{left}: {cast:?}");
        for (found, exact) in found.pixels().iter().zip(exact.pixels()) {
            let off = (0..3).map(|k| (found.color[k] - exact.color[k]).abs()).fold(0.0, f32::max);
            assert!(off <= left && exact.opacity - found.opacity <= left, "{off}, {left}");
        }
    }
}

#[test]
fn samples_of_every_type_and_scaling_look_the_same() {
    fn same<T: Sample>(expected: &Image, camera: &Camera, sample: impl Fn(f64) -> T) {
        let blobs = blobs();
        let samples: Vec<T> = blobs.samples().iter().map(|&byte| sample(byte.into())).collect();
        for (slope, intercept) in [(1.0, 0.0), (-0.5, 8.0)] {
            // What a sample means, and the function of it, change together.
            let scaling = Scaling::new(slope, intercept).unwrap();
            let place = |point: &ControlPoint| scaling.value(point.value);
            let points = glowing().into_iter();
            let points = points.map(|point| ControlPoint { value: place(&point), ..point });
            let mut points: Vec<_> = points.collect();
            points.sort_by(|a, b| a.value.total_cmp(&b.value));
            let glow = TransferFunction::new(points).unwrap().into();
            let volume = Volume::new(*blobs.grid(), samples.clone()).unwrap().with_scaling(scaling);
            let found = picture(&volume, &glow, (camera, 30), &RaycastOptions::DEFAULT).0;
            let pairs = found.pixels().iter().zip(expected.pixels());
            let off = pairs.map(|(a, b)| (a.opacity - b.opacity).abs()).fold(0.0, f32::max);
            assert!(if slope == 1.0 { found == *expected } else { off < 1e-3 }, "{slope}: {off}");
        }
    }
    let volume = blobs();
    let camera = &cameras(&volume)[2];
    let expected = picture(&volume, &glow(), (camera, 30), &RaycastOptions::DEFAULT).0;
    same(&expected, camera, |v| v as u8);
    same(&expected, camera, |v| v as u16);
    same(&expected, camera, |v| v as u32);
    same(&expected, camera, |v| v as i16);
    same(&expected, camera, |v| v as i32);
    same(&expected, camera, |v| v as f32);
    same(&expected, camera, |v| v);
}

#[test]
fn the_top_of_a_picture_is_up_and_its_left_is_left() {
    let corner = volume([9, 9, 9], 1.0, |[x, y, _]| if x < 4.0 && y > 4.0 { 60_u8 } else { 0 });
    // Along z, with y up: x goes to the left.
    let along = ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);
    for fov in [None, Some(40.0)] {
        let camera = Camera::framing(corner.grid().bounds(), along, fov, 1.0).unwrap();
        let image = picture(&corner, &glow(), (&camera, 16), &RaycastOptions::DEFAULT).0;
        let seen =
            [(4, 4), (11, 4), (4, 11), (11, 11)].map(|(x, y)| image.pixel(x, y).opacity > 0.1);
        assert_eq!(seen, [false, true, false, false], "{fov:?}");
    }
}

#[test]
fn a_camera_within_a_volume_sees_what_is_before_it() {
    let slab = volume([9, 9, 21], 1.0, |_| 7_u8);
    let model = opacities([0.0, 10.0], |_| 0.1);
    let up = [0.0, 1.0, 0.0];
    let inside = Projection::Perspective { fov: 1e-6 };
    let camera = Camera::new([4.0, 4.0, 8.0], [4.0, 4.0, 9.0], up, inside).unwrap();
    let found = picture(&slab, &model, (&camera, 1), &PLAIN.with_unit(Some(1.0))).0.pixel(0, 0);
    assert!((found.opacity - (1.0 - 0.9_f32.powi(12))).abs() < 1e-5, "{found:?}");
}

#[test]
fn what_is_not_a_number_is_not_seen_and_flat_volumes_have_no_depth() {
    let holes = volume([9, 9, 9], 1.0, |[x, ..]| if x < 5.0 { f32::NAN } else { 60.0 });
    let camera =
        Camera::framing(holes.grid().bounds(), ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]), None, 1.0)
            .unwrap();
    let model = opacities([0.0, 100.0], |_| 0.5);
    let image = picture(&holes, &model, (&camera, 16), &RaycastOptions::DEFAULT).0;
    // Looking along z with y up, x goes to the left.
    assert!(image.pixel(3, 8).opacity > 0.9 && image.pixel(12, 8).opacity == 0.0);
    let flat = volume([9, 9, 1], 1.0, |_| 60_u8);
    let image = picture(&flat, &model, (&camera, 16), &RaycastOptions::DEFAULT).0;
    assert!(image.pixels().iter().all(|pixel| pixel.opacity == 0.0));
    let none = volume([3, 3, 3], 1.0, |_| f64::NAN);
    let image = picture(&none, &model, (&camera, 4), &RaycastOptions::DEFAULT).0;
    assert!(image.pixels().iter().all(|pixel| pixel.opacity == 0.0));
}

#[test]
fn lengths_of_no_use_are_refused() {
    let volume = volume([4, 4, 4], 2.0, |[x, ..]| x as f32);
    let camera = cameras(&blobs()).remove(0);
    let cast = |options: RaycastOptions| {
        let view = volume.view();
        raycast(&medium(&view, &glow()), (&camera, size(2)), &options, &Job::default()).unwrap_err()
    };
    for step in [0.0, -1.0, f64::NAN, 1e-9, f64::INFINITY] {
        let error = cast(PLAIN.with_step(step));
        assert!(matches!(error, RaycastError::Length { what: "the step", .. }), "{error}");
    }
    let error = cast(PLAIN.with_unit(Some(0.0)));
    assert!(matches!(error, RaycastError::Length { what: "the reference length", .. }), "{error}");
    let job = Job::default();
    job.cancel.cancel();
    let view = volume.view();
    assert!(raycast(&medium(&view, &glow()), (&camera, size(2)), &PLAIN, &job).is_err());
}

#[test]
fn planes_leave_what_is_within_all_of_them() {
    let slab = volume([9, 9, 41], 0.5, |_| 1.0_f32);
    let model = opacities([0.0, 2.0], |_| 0.1);
    let view = slab.view();
    let along = Projection::Parallel { height: 1e-6 };
    let camera = Camera::new([2.0, 2.0, -3.0], [2.0; 3], [0.0, 1.0, 0.0], along).unwrap();
    let gathered = |halves: &[([f64; 3], f64)]| {
        let clips: Vec<_> = halves.iter().map(|&(n, d)| HalfSpace::new(n, d).unwrap()).collect();
        let medium = Medium { clips: &clips, ..medium(&view, &model) };
        let camera = (&camera, size(1));
        raycast(&medium, camera, &PLAIN, &Job::default()).unwrap().0.pixel(0, 0).opacity
    };
    let of = |length: f64| 1.0 - 0.9_f64.powf(length / 0.5);
    let (front, back) = ([0.0, 0.0, 2.0], [0.0, 0.0, -1.0]);
    for (halves, length) in [
        (&[][..], 20.0),
        (&[(front, 7.3)], 3.65),
        (&[(back, -7.3)], 12.7),
        (&[(front, 20.0), (back, -4.0), ([1.0, 0.0, 0.0], 2.1)], 6.0),
        (&[([1.0, 0.0, 0.0], 1.9)], 0.0),
        (&[(front, 4.0), (back, -4.0)], 0.0),
        (&[([1.0, 0.0, 1.0], 6.0)], 4.0),
    ] {
        let found = f64::from(gathered(halves));
        assert!((found - of(length)).abs() < 1e-5, "{halves:?}: {found} for {}", of(length));
    }
}

#[test]
fn a_camera_where_numbers_end_makes_no_endless_ray() {
    let volume = blobs();
    let parallel = |height| Projection::Parallel { height };
    let far = Camera::new([1e150, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0], parallel(1.0)).unwrap();
    let wide = Camera::new([9.0; 3], [0.0; 3], [0.0, 0.0, 1.0], parallel(1e308)).unwrap();
    for camera in [far, wide] {
        let cast = picture(&volume, &glow(), (&camera, 3), &RaycastOptions::DEFAULT).1;
        assert!(cast.steps + cast.steps_hidden <= 9 * 500, "{cast:?}");
    }
    let beyond = Camera::new([1e308; 3], [-1e308; 3], [0.0, 0.0, 1.0], parallel(1.0));
    assert_eq!(beyond, Err(CameraError::NotFinite));
}

#[test]
fn a_sheared_and_mirrored_lattice_is_lit_by_its_normals_in_the_world() {
    let columns = [[0.7, 0.2, 0.0], [0.1, -0.6, 0.0], [0.2, 0.1, 1.3]];
    let affine = Affine::new(columns, [3.0, -2.0, 1.0]).unwrap();
    let slope = [0.3, -0.2, 0.6];
    let frame = Frame { index_to_world: affine, ..Frame::default() };
    let grid = Grid::new([12, 13, 11], frame).unwrap();
    let value = |n: u64| {
        let place = affine.point([n % 12, n / 12 % 13, n / 156].map(|i| i as f64));
        (0..3).map(|k| slope[k] * place[k]).sum::<f64>()
    };
    let volume = Volume::new(grid, (0..grid.count()).map(value).collect::<Vec<f64>>()).unwrap();
    let model = opacities([-100.0, 100.0], |_| 0.4);
    let light = Light { specular: 0.0, ..Light::DEFAULT };
    let options = RaycastOptions::DEFAULT.with_light(Some(light));
    for forward in [[0.0, 1.0, 0.0], [-0.4, 0.2, 0.8], [1.0, 1.0, -1.0]] {
        let camera = Camera::framing(grid.bounds(), (forward, [0.0, 0.1, 1.0]), None, 1.0).unwrap();
        let pixel = picture(&volume, &model, (&camera, 9), &options).0.pixel(4, 4);
        let cosine = dot(slope, forward).abs() / (length(slope) * length(forward));
        let expected = 0.5 * (0.25 + 0.75 * cosine);
        let found = f64::from(pixel.straight()[0]);
        assert!((found - expected).abs() < 1e-4, "{forward:?}: {found} for {expected}");
    }
}
