//! What rays meet, against walks in small steps and what is known of balls.

use super::{Isosurface, Isosurfaces, Traced, isocast};
use crate::{
    Camera, Cap, Channel, Gathered, Image, Interpolant, Kernel, Light, Paint, Projection,
    RasterOptions, Size, Smoothing,
};
use isokit_geom::{Affine, Frame, HalfSpace, vector::Vector};
use isokit_job::{Job, Threads};
use isokit_volume::{Bricks, Grid, Sample, Scaling, View, Volume};
use std::num::{NonZeroU32, NonZeroUsize};

const PLAIN: RasterOptions =
    RasterOptions::DEFAULT.with_light(None).with_smoothing(Smoothing::None);
const PARALLEL: Projection = Projection::Parallel { height: 32.0 };
const PERSPECTIVE: Projection = Projection::Perspective { fov: 40.0 };

fn volume<T: Sample>(dims: [u64; 3], value: impl Fn(Vector) -> T) -> Volume<T> {
    let middle = dims.map(|n| (n as f64 - 1.0) / -2.0);
    let affine = Affine::axis_aligned([1.0; 3], middle).unwrap();
    let grid = Grid::new(dims, Frame { index_to_world: affine, ..Frame::default() }).unwrap();
    let at = |n: u64| [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]];
    let sample = |n: u64| value(affine.point(at(n).map(|i| i as f64)));
    Volume::new(grid, (0..grid.count()).map(sample).collect()).unwrap()
}

fn length([x, y, z]: Vector) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// How deep a place lies in a ball of radius 10.
fn ball() -> Volume<f32> {
    volume([30, 33, 28], |place| (10.0 - length(place)) as f32)
}

/// Numbers from −1 to 1 that look like chance.
fn noise(seed: f64) -> impl Fn(Vector) -> f32 {
    move |[x, y, z]| {
        ((x * 12.9898 + y * 78.233 + z * 37.719 + seed).sin() * 43758.5453).sin() as f32
    }
}

fn glass(iso: f64, opacity: f32) -> Isosurface<'static> {
    Isosurface { iso, paint: Paint::Plain([1.0; 3]), opacity, clips: &[] }
}

fn camera(from: Vector, projection: Projection) -> Camera {
    Camera::new(from, [0.0; 3], [0.0, 0.0, 1.0], projection).unwrap()
}

fn size(n: u32) -> Size {
    let n = NonZeroU32::new(n).unwrap();
    Size { width: n, height: n }
}

fn scene_of<'a, T>(view: &'a View<'a, T>, surfaces: &'a [Isosurface<'a>]) -> Isosurfaces<'a, T> {
    Isosurfaces { view, bricks: None, kernel: Kernel::Linear, surfaces, caps: &[] }
}

fn picture<T: Sample>(
    volume: &Volume<T>,
    surfaces: &[Isosurface<'_>],
    (camera, n): (&Camera, u32),
    options: &RasterOptions,
) -> (Image, Traced) {
    let view = volume.view();
    let scene = scene_of(&view, surfaces);
    isocast(&scene, (camera, size(n)), options, &Job::default()).unwrap()
}

/// How many walls of an opacity of a half make an opacity.
fn walls(opacity: f32) -> f32 {
    -(1.0 - opacity).log2()
}

#[test]
fn a_ray_meets_a_ball_twice_or_not_at_all() {
    for projection in [PARALLEL, PERSPECTIVE] {
        let camera = camera([30.0, -40.0, 20.0], projection);
        let (image, _) = picture(&ball(), &[glass(0.0, 0.5)], (&camera, 61), &PLAIN);
        for (x, y) in (0..61).flat_map(|y| (0..61).map(move |x| (x, y))) {
            let ray = camera.pixel_ray(size(61), [x, y].map(|n| f64::from(n) + 0.5));
            let along: f64 = (0..3).map(|k| -ray.origin[k] * ray.direction[k]).sum();
            let nearest = std::array::from_fn(|k| ray.origin[k] + along * ray.direction[k]);
            let away = length(nearest);
            let expected = match away {
                a if a < 9.9 => 2.0,
                a if a > 10.1 => 0.0,
                _ => continue,
            };
            assert_eq!(walls(image.pixel(x, y).opacity), expected, "{x}, {y}: {away}");
        }
    }
}

#[test]
fn in_noise_a_ray_meets_what_a_walk_in_small_steps_goes_through() {
    let mut met = 0.0;
    for (seed, kernel) in [(0, Kernel::Linear), (1, Kernel::Linear), (0, Kernel::CatmullRom)] {
        let volume = volume([6, 5, 7], noise(f64::from(seed)));
        let view = volume.view();
        let field = Interpolant::new(view, kernel);
        let camera = camera([9.0, -14.0, 6.0], PERSPECTIVE);
        let surfaces = [glass(0.3, 0.5)];
        let scene = Isosurfaces { kernel, ..scene_of(&view, &surfaces) };
        let (image, _) = isocast(&scene, (&camera, size(17)), &PLAIN, &Job::default()).unwrap();
        for (x, y) in (0..17).flat_map(|y| (0..17).map(move |x| (x, y))) {
            let ray = camera.pixel_ray(size(17), [x, y].map(|n| f64::from(n) + 0.5));
            let inside = (0..100_000).map(|n| {
                let far = 5.0 + f64::from(n) * 2e-4;
                let place = std::array::from_fn(|k| ray.origin[k] + far * ray.direction[k]);
                field.at(place).is_some_and(|value| value >= 0.3)
            });
            let mut before = false;
            let changes = inside.filter(|&now| std::mem::replace(&mut before, now) != now).count();
            let opacity = image.pixel(x, y).opacity;
            // As far as so many walls can be told apart.
            if changes <= 10 {
                let found = walls(opacity).round() as usize;
                assert_eq!(found, changes, "{kernel:?}, {seed}, {x}, {y}: {opacity}");
            }
            met += walls(opacity);
        }
    }
    assert!(met > 250.0, "{met}");
}

#[test]
fn bricks_and_threads_change_no_bit() {
    let volume = volume([150, 40, 30], |place| {
        let wave = (0.2 * place[0]).sin() + (0.3 * place[1]).cos();
        if place[0] > 20.0 { -3.0 } else { (wave * 100.0) as i16 as f32 }
    });
    let bricks = Bricks::of(&volume.view(), &Job::default()).unwrap();
    let surfaces = [glass(30.0, 0.3), glass(120.0, 1.0), glass(-90.0, 0.0)];
    let mut passed = 0;
    let view = volume.view();
    let eyes = [[90.0, -80.0, 50.0], [3.0, 2.0, 1.0], [-200.0, 0.1, 0.0]];
    let kernels = [Kernel::Linear, Kernel::CatmullRom];
    for (from, kernel) in eyes.into_iter().flat_map(|from| kernels.map(|kernel| (from, kernel))) {
        let camera = camera(from, Projection::Perspective { fov: 60.0 });
        let plain = Isosurfaces { kernel, ..scene_of(&view, &surfaces) };
        let cast = |scene: &_, job: &_| isocast(scene, (&camera, size(41)), &PLAIN, job).unwrap();
        let (expected, walked) = cast(&plain, &Job::default());
        assert_eq!(walked.bricks_passed, 0);
        assert!(expected.pixels().iter().any(|pixel| pixel.opacity > 0.5));
        for threads in [1, 3] {
            let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
            let job = Job { threads, ..Job::default() };
            let (image, traced) = cast(&Isosurfaces { bricks: Some(&bricks), ..plain }, &job);
            assert!(image == expected, "{from:?}, {kernel:?}");
            assert!(traced.cells <= walked.cells, "{traced:?}");
            passed += traced.bricks_passed;
        }
    }
    assert!(passed > 1000, "{passed}");
}

#[test]
fn a_ball_is_lit_by_its_gradient_whatever_samples_mean() {
    let light = Light { specular: 0.0, ..Light::DEFAULT };
    let scaling = Scaling::new(-0.5, 100.0).unwrap();
    let camera = camera([0.0, -50.0, 0.0], PARALLEL);
    let options = PLAIN.with_light(Some(light));
    let plain = picture(&ball(), &[glass(0.0, 1.0)], (&camera, 41), &options).0;
    let turned = volume([30, 33, 28], |place| 200.0 - 2.0 * (10.0 - length(place)));
    let turned = turned.with_scaling(scaling);
    let other = picture(&turned, &[glass(0.0, 1.0)], (&camera, 41), &options).0;
    for (x, y) in (0..41).flat_map(|y| (0..41).map(move |x| (x, y))) {
        let [right, up] = [f64::from(x) - 20.0, 20.0 - f64::from(y)].map(|c| c * 32.0 / 41.0);
        let square = 1.0 - (right * right + up * up) / 100.0;
        if square > 0.1 {
            let expected = 0.25 + 0.75 * square.sqrt();
            for image in [&plain, &other] {
                let found = f64::from(image.pixel(x, y).color[0]);
                assert!((found - expected).abs() < 0.01, "{x}, {y}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn the_border_of_the_volume_closes_a_surface() {
    let full = volume([8, 8, 8], |_| 1.0_f32);
    let slanted = camera([20.0, -30.0, 15.0], PERSPECTIVE);
    let (image, _) = picture(&full, &[glass(0.5, 0.5)], (&slanted, 33), &PLAIN);
    let (middle, walled) = (image.pixel(16, 16), |pixel: &Gathered| walls(pixel.opacity) == 2.0);
    assert!(walled(&middle));
    assert!(image.pixels().iter().all(|pixel| walled(pixel) || *pixel == Gathered::NOTHING));
    // Lit by the direction of the side that it faces.
    let front = camera([0.0, -30.0, 0.0], PARALLEL);
    let options = PLAIN.with_light(Some(Light { specular: 0.0, ..Light::DEFAULT }));
    let (image, _) = picture(&full, &[glass(0.5, 1.0)], (&front, 33), &options);
    assert_eq!(image.pixel(16, 16).color, [1.0; 3]);
}

#[test]
fn from_within_there_is_one_wall_all_around() {
    let camera = camera([1.0, 2.0, -1.0], Projection::Perspective { fov: 120.0 });
    let (image, _) = picture(&ball(), &[glass(0.0, 0.5)], (&camera, 21), &PLAIN);
    assert!(image.pixels().iter().all(|pixel| pixel.opacity == 0.5));
}

#[test]
fn planes_cut_and_caps_close() {
    let half = HalfSpace::new([0.0, -1.0, 0.0], 3.0).unwrap();
    let volume = ball();
    let view = volume.view();
    let field = Interpolant::new(view, Kernel::Linear);
    let look = |place: Vector| match field.at(place) {
        Some(0.0..) => Gathered::new([0.0, 1.0, 0.0], 1.0),
        _ => Gathered::NOTHING,
    };
    let (clips, cap) = ([half], Cap { half, look: &look });
    let surfaces = [Isosurface { clips: &clips, ..glass(0.0, 0.5) }];
    let camera = camera([0.0, -50.0, 0.0], PARALLEL);
    let draw = |caps: &[Cap<'_>]| {
        let scene = Isosurfaces { caps, ..scene_of(&view, &surfaces) };
        isocast(&scene, (&camera, size(101)), &PLAIN, &Job::default()).unwrap().0
    };
    assert_eq!(walls(draw(&[]).pixel(50, 50).opacity), 1.0);
    let capped = draw(&[cap]);
    assert_eq!(capped.pixel(50, 50), Gathered::new([0.0, 1.0, 0.0], 1.0));
    // Beside the cap's rim both walls are left: 9.54 is its radius.
    assert_eq!(walls(capped.pixel(50, 50 + 31).opacity), 2.0);
    assert_eq!(capped.pixel(50, 0), Gathered::NOTHING);
}

#[test]
fn on_cubics_a_ball_of_few_samples_is_round() {
    // Seven samples across.
    let ball = volume([15; 3], |[x, y, z]| 12.25 - x * x - y * y - z * z);
    let (view, surfaces) = (ball.view(), [glass(0.0, 1.0)]);
    let camera = camera([9.0, -14.0, 6.0], Projection::Parallel { height: 8.0 });
    let off = |kernel| {
        let scene = Isosurfaces { kernel, ..scene_of(&view, &surfaces) };
        let options = PLAIN.with_channel(Channel::Depth);
        let (image, _) = isocast(&scene, (&camera, size(64)), &options, &Job::default()).unwrap();
        let depths = image.pixels().iter().enumerate().filter_map(|(n, pixel)| {
            let at = [n % 64, n / 64].map(|c| (c as f64 - 31.5) / 8.0);
            let square = 12.25 - at[0] * at[0] - at[1] * at[1];
            let far = length([9.0, -14.0, 6.0]) - square.max(0.0).sqrt();
            (square > 1.0).then(|| (f64::from(pixel.color[0]) - far).abs())
        });
        depths.fold(0.0, f64::max)
    };
    let [linear, cubic] = [Kernel::Linear, Kernel::CatmullRom].map(off);
    // Values are parabolas, which these cubics are exact for.
    assert!(cubic < 1e-5 && linear > 0.02, "{cubic}, {linear}");
}

#[test]
fn cells_without_a_number_are_outside_and_flat_volumes_have_no_inside() {
    let holed = volume([9, 9, 9], |place| if length(place) < 1.1 { f32::NAN } else { 1.0 });
    let front = camera([0.3, -30.0, 0.2], PARALLEL);
    let (image, _) = picture(&holed, &[glass(0.5, 0.5)], (&front, 65), &PLAIN);
    // In, out of it at the hole, in behind it, out.
    assert_eq!(walls(image.pixel(32, 32).opacity), 4.0);
    let flat = volume([9, 9, 1], |_| 1.0_f32);
    let (image, _) = picture(&flat, &[glass(0.5, 0.5)], (&front, 9), &PLAIN);
    assert!(image.pixels().iter().all(|pixel| *pixel == Gathered::NOTHING));
}
