//! Splats against rays, closed forms, and pictures that must be equal.

use super::splat;
use crate::{
    Camera, ControlPoint, Gathered, Image, Light, Material, Medium, Mixture, OpticalModel,
    Projection, RaycastOptions, Size, SlopeFunction, TransferFunction, raycast,
};
use isokit_geom::{Affine, Frame, HalfSpace};
use isokit_job::{Job, Threads};
use isokit_volume::{Bricks, Grid, Sample, Volume};
use std::num::{NonZeroU32, NonZeroUsize};

const PLAIN: RaycastOptions = RaycastOptions::DEFAULT.with_light(None);

fn volume<T: Sample>(dims: [u64; 3], spacing: [f64; 3], f: impl Fn([f64; 3]) -> T) -> Volume<T> {
    let index_to_world = Affine::axis_aligned(spacing, [0.0; 3]).unwrap();
    let grid = Grid::new(dims, Frame { index_to_world, ..Frame::default() }).unwrap();
    let at =
        |n: u64| f([n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]].map(|i| i as f64));
    Volume::new(grid, (0..grid.count()).map(at).collect()).unwrap()
}

fn size(width: u32, height: u32) -> Size {
    let [width, height] = [width, height].map(|n| NonZeroU32::new(n).unwrap());
    Size { width, height }
}

fn function(points: &[(f64, f32, f32)]) -> TransferFunction {
    let point = |&(value, shade, opacity): &(f64, f32, f32)| ControlPoint {
        value,
        color: [shade, 0.6 * shade, 1.0 - shade],
        opacity,
    };
    TransferFunction::new(points.iter().map(point).collect()).unwrap()
}

/// From aside, with all of it in the picture.
fn camera<T: Sample>(volume: &Volume<T>, fov: Option<f64>, degrees: f64) -> Camera {
    let towards = ([0.3, 1.0, -0.4], [0.0, 0.0, 1.0]);
    Camera::framing(volume.grid().bounds(), towards, fov, 1.0).unwrap().orbited(degrees)
}

fn pictures<T: Sample>(
    volume: &Volume<T>,
    model: &OpticalModel,
    (camera, size): (&Camera, Size),
    options: &RaycastOptions,
) -> [Image; 2] {
    let view = volume.view();
    let medium = Medium { view: &view, bricks: None, model, clips: &[] };
    let job = Job::default();
    let by_rays = raycast(&medium, (camera, size), options, &job).unwrap().0;
    [splat(&medium, (camera, size), options, &job).unwrap().0, by_rays]
}

/// How much two pictures differ on the mean, as a share of what a part of a colour or an opacity can be, over the pixels
/// that show something in either.
fn mean([a, b]: &[Image; 2]) -> f64 {
    let parts = |p: &Gathered| [p.color[0], p.color[1], p.color[2], p.opacity];
    let pairs = a.pixels().iter().zip(b.pixels());
    let shown = pairs.filter(|(a, b)| a.opacity.max(b.opacity) > 0.0);
    let (mut sum, mut count) = (0.0, 0);
    for (a, b) in shown {
        let pairs = parts(a).into_iter().zip(parts(b));
        sum += pairs.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / 4.0;
        count += 1;
    }
    assert!(count > 1000, "only {count} pixels show something");
    sum / f64::from(count)
}

/// Waves of 16 samples and more.
fn waves([x, y, z]: [f64; 3]) -> f32 {
    let wave = |c: f64, long: f64| (c * std::f64::consts::TAU / long).sin();
    (wave(x + 0.4 * y, 17.0) + wave(y - 0.3 * z, 23.0) + wave(z + 0.2 * x, 19.0)) as f32
}

#[test]
fn splats_of_band_limited_volumes_are_what_rays_see_but_for_a_hundredth() {
    let model = function(&[(-0.5, 0.2, 0.0), (0.6, 0.5, 0.1), (1.5, 1.0, 0.4)]).into();
    for (fov, spacing) in [
        (None, [1.0; 3]),
        (None, [0.7, 1.3, 1.0]),
        (Some(35.0), [1.0; 3]),
        (Some(50.0), [1.0, 1.0, 2.0]),
    ] {
        let volume = volume([40, 36, 32], spacing, waves);
        for options in [PLAIN.with_step(0.25), RaycastOptions::DEFAULT] {
            let found =
                pictures(&volume, &model, (&camera(&volume, fov, 0.0), size(110, 110)), &options);
            let off = mean(&found);
            assert!(off <= 0.01, "{fov:?}, {spacing:?}: {off}");
        }
    }
}

#[test]
fn a_slab_of_one_substance_gathers_its_closed_form() {
    for fov in [None, Some(40.0)] {
        let slab = volume([20, 20, 9], [1.0, 1.0, 1.5], |_| 7_u8);
        let model = function(&[(0.0, 1.0, 0.2)]).into();
        let (from, at) = ([9.5, 9.5, -30.0], [9.5, 9.5, 0.0]);
        let projection = match fov {
            Some(fov) => Projection::Perspective { fov },
            None => Projection::Parallel { height: 16.0 },
        };
        let camera = Camera::new(from, at, [0.0, 1.0, 0.0], projection).unwrap();
        for step in [0.3, 0.5, 1.0] {
            let options = PLAIN.with_step(step).with_unit(Some(2.0)).with_opaque(1.0);
            let [image, _] = pictures(&slab, &model, (&camera, size(64, 64)), &options);
            for (column, row) in [(32, 32), (20, 40), (31, 25)] {
                let ray = camera.pixel_ray(size(64, 64), [column, row].map(|n| f64::from(n) + 0.5));
                let long = 12.0 / ray.direction[2];
                let exact = 1.0 - 0.8_f64.powf(long / 2.0);
                let found = f64::from(image.pixel(column, row).opacity);
                assert!((found - exact).abs() < 1e-5, "{fov:?}, {step}: {found} for {exact}");
            }
        }
    }
}

#[test]
fn nothing_pops_where_the_nearest_axis_changes() {
    let volume = volume([33; 3], [1.0; 3], waves);
    let model = function(&[(-0.5, 0.2, 0.0), (1.5, 1.0, 0.3)]).into();
    // How much a picture changes in a fifth of a degree.
    let change = |degrees: f64| {
        let [before, after] = [-0.1, 0.1].map(|by| {
            let camera = camera(&volume, None, degrees + by);
            let [image, _] = pictures(&volume, &model, (&camera, size(64, 64)), &PLAIN);
            image
        });
        mean(&[before, after])
    };
    // The camera of 0 looks 16.7 degrees aside of y.
    for middle in [28.3, 118.3] {
        let beside = [-4.0, -2.0, 2.0, 4.0].map(|by| change(middle + by));
        let most = beside.into_iter().fold(0.0, f64::max);
        let found = change(middle);
        assert!(found < 1.2 * most, "{middle}: {found} beside {beside:?}");
    }
}

#[test]
fn what_is_even_looks_alike_everywhere_whatever_its_value() {
    for value in [1.0_f32, 3.0, 7.0, 0.1, -1e-3, 1e30] {
        let even = volume([14, 13, 12], [1.0, 1.0, 1.3], |_| value);
        // A step right where the value is.
        let low = (f64::from(value) - 1e-3).min(f64::from(value.next_down()));
        let step = [(low, 0.0, 0.0), (value.into(), 0.0, 0.0), (value.into(), 0.7, 0.3)];
        let (step, alike) = (function(&step).into(), function(&[(0.0, 0.7, 0.3)]).into());
        for fov in [None, Some(50.0)] {
            let camera = camera(&even, fov, 20.0);
            let of = |model: &OpticalModel, options: &RaycastOptions| {
                pictures(&even, model, (&camera, size(60, 60)), options)[0].clone()
            };
            let plain = of(&alike, &PLAIN);
            assert!(plain.pixels().iter().any(|pixel| pixel.opacity > 0.9), "{value}");
            assert!(of(&step, &PLAIN) == plain, "{value}: a step leaves speckles");
            assert!(of(&alike, &RaycastOptions::DEFAULT) == plain, "{value}: noise is lit");
        }
    }
}

fn models() -> [OpticalModel; 3] {
    let hill = function(&[(-0.2, 0.2, 0.0), (0.6, 0.5, 0.3), (1.5, 1.0, 0.9)]);
    let material = |values, shade: f32, opacity, density| Material {
        values,
        color: [shade, 0.5, 1.0 - shade],
        opacity,
        density,
    };
    let body = vec![material([-9.0, -0.3], 0.0, 0.0, 0.0), material([0.8, 9.0], 1.0, 0.1, 1.0)];
    [
        hill.clone().into(),
        SlopeFunction::fading(hill, 0.8).unwrap().into(),
        Mixture::new(body, 0.8).unwrap().into(),
    ]
}

#[test]
fn splats_of_slopes_and_mixtures_are_what_rays_see() {
    let volume = volume([40, 36, 32], [1.0, 0.8, 1.2], |ijk| (1000.0 * waves(ijk)) as i16);
    let scaling = isokit_volume::Scaling::new(0.001, 0.0).unwrap();
    let volume = volume.with_scaling(scaling);
    for model in models() {
        let camera = camera(&volume, Some(30.0), 0.0);
        let found = pictures(&volume, &model, (&camera, size(110, 110)), &RaycastOptions::DEFAULT);
        let off = mean(&found);
        assert!(off <= 0.02, "{model:?}: {off}");
    }
}

#[test]
fn a_picture_has_the_same_bytes_for_any_number_of_threads_and_with_bricks_or_without() {
    let ball = |ijk: [f64; 3]| {
        let from: f64 = ijk.iter().zip([30.0, 22.0, 20.0]).map(|(c, m)| (c - m) * (c - m)).sum();
        (15.0 - from.sqrt()).max(-2.0) as f32
    };
    let volume = volume([90, 44, 50], [1.0; 3], ball);
    let hill = function(&[(0.0, 0.2, 0.0), (2.0, 0.5, 0.3), (15.0, 1.0, 0.9)]);
    let model = SlopeFunction::fading(hill, 1.0).unwrap().into();
    let (view, clips) = (volume.view(), [HalfSpace::new([1.0, 0.2, 0.1], 40.0).unwrap()]);
    // Of the last a pixel is wider than many blocks; before it sheets are far apart.
    for (fov, n, step) in [
        (None, 130, 0.5),
        (Some(60.0), 90, 0.5),
        (None, 17, 0.5),
        (Some(110.0), 90, 4.0),
        (None, 1, 0.5),
    ] {
        let (camera, size) = (camera(&volume, fov, 0.0), size(n, n + 5));
        let options = RaycastOptions::DEFAULT.with_step(step);
        let of = |bricks, threads: usize| {
            let medium = Medium { view: &view, bricks, model: &model, clips: &clips };
            let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
            let job = Job { threads, ..Job::default() };
            splat(&medium, (&camera, size), &options, &job).unwrap()
        };
        let bricks = Bricks::of(&view, &Job::default()).unwrap();
        let (plain, with_bricks) = (of(None, 1), of(Some(&bricks), 1));
        assert!(plain.0 == with_bricks.0, "{fov:?}, {n}: bricks change the picture");
        assert!(n < 20 || with_bricks.1.samples_skipped > plain.1.samples_skipped + 10_000);
        for threads in [2, 7] {
            assert!(of(Some(&bricks), threads) == with_bricks, "{fov:?}: {threads} threads");
        }
        assert!(n < 20 || plain.0.pixels().iter().any(|pixel| pixel.opacity > 0.5), "{fov:?}");
    }
}

#[test]
fn a_place_beside_a_sample_that_is_no_number_is_not_seen() {
    for hole in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let holed = volume([17; 3], [1.0; 3], |ijk| if ijk == [8.0; 3] { hole } else { 1.0 });
        let model = function(&[(0.0, 1.0, 1.0)]).into();
        let wall = HalfSpace::new([0.0, 0.0, 1.0], 8.0).unwrap();
        let (from, at) = ([8.0, 8.0, 40.0], [8.0; 3]);
        let parallel = Projection::Parallel { height: 12.0 };
        let camera = Camera::new(from, at, [0.0, 1.0, 0.0], parallel).unwrap();
        let view = holed.view();
        // One sheet before the plane behind which is nothing: all of it is a hole there.
        let below = HalfSpace::new([0.0, 0.0, -1.0], -7.5).unwrap();
        let medium = Medium { view: &view, bricks: None, model: &model, clips: &[wall, below] };
        let job = Job::default();
        let image = splat(&medium, (&camera, size(48, 48)), &PLAIN, &job).unwrap().0;
        assert_eq!(image.pixel(24, 24).opacity, 0.0, "{hole}");
        assert!(image.pixel(4, 4).opacity > 0.9);
        assert!(image.pixels().iter().all(|pixel| (0.0..=1.0).contains(&pixel.opacity)));
    }
}

#[test]
fn what_is_behind_the_camera_or_a_plane_is_not_seen() {
    let model = function(&[(0.0, 1.0, 0.5)]).into();
    let slab = volume([16; 3], [1.0; 3], |_| 1_u8);
    let projection = Projection::Perspective { fov: 40.0 };
    let [away, within] = [40.0, 7.5].map(|z| {
        let camera = Camera::new([7.5, 7.5, z], [7.5, 7.5, z + 9.0], [0.0, 1.0, 0.0], projection);
        pictures(&slab, &model, (&camera.unwrap(), size(40, 40)), &RaycastOptions::DEFAULT)
    });
    assert!(away[0].pixels().iter().all(|pixel| *pixel == Gathered::NOTHING));
    assert!(mean(&within) < 0.01);
    let light = Light { ambient: 1.0, diffuse: 0.0, specular: 0.0, shininess: 1 };
    let lit = RaycastOptions::DEFAULT.with_light(Some(light));
    let camera = camera(&slab, None, 0.0);
    let [bright, _] = pictures(&slab, &model, (&camera, size(60, 60)), &lit);
    let [plain, _] = pictures(&slab, &model, (&camera, size(60, 60)), &PLAIN);
    assert!(bright == plain, "what is even has no gradient to be lit by");
}

#[test]
fn sheets_are_hidden_behind_what_is_opaque_and_nowhere_else() {
    let slab = volume([16; 3], [1.0; 3], |_| 1_u8);
    let view = slab.view();
    let parallel = Projection::Parallel { height: 6.0 };
    let camera = Camera::new([7.5, 7.5, -9.0], [7.5; 3], [0.0, 1.0, 0.0], parallel).unwrap();
    let hidden = |opacity: f32| {
        let model = function(&[(0.0, 1.0, opacity)]).into();
        let medium = Medium { view: &view, bricks: None, model: &model, clips: &[] };
        splat(&medium, (&camera, size(50, 50)), &PLAIN, &Job::default()).unwrap().1.sheets_hidden
    };
    // Two sheets for each of 15 edges; a tenth of light is left behind each, and less than is seen behind four.
    assert_eq!(hidden(0.001), 0);
    assert!((20..=22).contains(&hidden(0.9)), "{}", hidden(0.9));
}
