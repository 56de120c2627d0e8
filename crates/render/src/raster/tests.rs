//! Pictures of meshes against rays through all of their triangles, and against what is known of balls.

mod colors;

use super::{Cap, Drawn, Paint, Painted, RasterError, RasterOptions, Smoothing, rasterize};
use crate::{Camera, Gathered, Image, Light, Projection, Size};
use isokit_geom::{
    HalfSpace,
    vector::{Vector, cross, dot, sub},
};
use isokit_job::{Job, Limits, Threads};
use isokit_mesh::{Positions, TriMesh};
use std::{
    f64::consts::PI,
    num::{NonZeroU32, NonZeroUsize},
};

const PLAIN: RasterOptions =
    RasterOptions::DEFAULT.with_light(None).with_smoothing(Smoothing::None);
const PARALLEL: Projection = Projection::Parallel { height: 3.0 };
const PERSPECTIVE: Projection = Projection::Perspective { fov: 50.0 };

/// A mesh with an outline of degrees: as many stripes from pole to pole, and twice as many around. Its normals are the
/// ball's.
fn ball(middle: Vector, radius: f64, stripes: u32) -> TriMesh {
    let around = 2 * stripes;
    let mut normals: Vec<Vector> = vec![[0.0, 0.0, 1.0]];
    for ring in 1..stripes {
        let (s, c) = (PI * f64::from(ring) / f64::from(stripes)).sin_cos();
        let at = |n| 2.0 * PI * f64::from(n) / f64::from(around);
        normals.extend((0..around).map(|n| [s * at(n).cos(), s * at(n).sin(), c]));
    }
    normals.push([0.0, 0.0, -1.0]);
    let (last, at) = (normals.len() as u32 - 1, |ring, n| 1 + ring * around + n % around);
    let mut triangles = vec![];
    for n in 0..around {
        triangles.push([0, at(0, n), at(0, n + 1)]);
        triangles.push([last, at(stripes - 2, n + 1), at(stripes - 2, n)]);
        for ring in 0..stripes - 2 {
            let [a, b] = [at(ring, n), at(ring, n + 1)];
            let [c, d] = [at(ring + 1, n), at(ring + 1, n + 1)];
            triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    let place = |normal: &Vector| std::array::from_fn(|k| middle[k] + radius * normal[k]);
    TriMesh {
        positions: Positions::F64(normals.iter().map(place).collect()),
        normals: Some(normals.iter().map(|normal| normal.map(|c| c as f32)).collect()),
        triangles,
        ..TriMesh::default()
    }
}

/// Triangles anywhere, through each other, from a generator with a fixed beginning.
fn soup(count: u32, mut state: u64) -> TriMesh {
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f64 / f64::from(1 << 24) * 2.0 - 1.0
    };
    let positions = (0..3 * count).map(|_| [next(), next(), next()]).collect();
    let triangles = (0..count).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
    TriMesh { positions: Positions::F64(positions), normals: None, triangles, ..TriMesh::default() }
}

fn painted(mesh: &TriMesh, color: [f32; 3], opacity: f32) -> Painted<'_> {
    Painted { mesh, paint: Paint::Plain(color), opacity, clips: &[] }
}

fn camera(from: Vector, projection: Projection) -> Camera {
    Camera::new(from, [0.0; 3], [0.0, 0.0, 1.0], projection).unwrap()
}

fn size(width: u32, height: u32) -> Size {
    let [width, height] = [width, height].map(|n| NonZeroU32::new(n).unwrap());
    Size { width, height }
}

fn picture(
    surfaces: &[Painted<'_>],
    (camera, size): (&Camera, Size),
    options: &RasterOptions,
) -> (Image, Drawn) {
    rasterize(surfaces, &[], (camera, size), options, &Job::default()).unwrap()
}

/// What a ray meets, by looking at every triangle; none if it passes so near to a side that rounding may decide.
fn met(surfaces: &[Painted<'_>], camera: &Camera, [x, y]: [f64; 2]) -> Option<Gathered> {
    let ray = camera.ray([x, y]);
    let mut hits: Vec<(f64, Gathered)> = vec![];
    for surface in surfaces {
        let Paint::Plain(color) = surface.paint else { panic!("of one colour") };
        for &triangle in &surface.mesh.triangles {
            let [a, b, c] = surface.mesh.corners(triangle);
            let (first, second) = (sub(b, a), sub(c, a));
            let across = cross(ray.direction, second);
            let determinant = dot(first, across);
            let from = sub(ray.origin, a);
            let u = dot(from, across) / determinant;
            let v = dot(ray.direction, cross(from, first)) / determinant;
            let far = dot(second, cross(from, first)) / determinant;
            let least = u.min(v).min(1.0 - u - v);
            if !(least.abs() > 0.02 && far.abs() > 0.01) {
                return None;
            }
            if least > 0.0 && far > 0.0 {
                hits.push((far, Gathered::new(color, surface.opacity)));
            }
        }
    }
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    let are_apart = hits.windows(2).all(|pair| pair[1].0 - pair[0].0 > 0.01);
    are_apart.then(|| hits.iter().fold(Gathered::NOTHING, |all, (_, hit)| all.over(*hit)))
}

#[test]
fn each_pixel_gathers_what_a_ray_through_all_triangles_meets() {
    let meshes = [soup(5, 1), soup(6, 2), soup(4, 3)];
    let surfaces = [
        painted(&meshes[0], [1.0, 0.2, 0.1], 0.3),
        painted(&meshes[1], [0.1, 0.9, 0.3], 1.0),
        painted(&meshes[2], [0.2, 0.3, 1.0], 0.6),
    ];
    let (mut compared, size) = (0, size(90, 70));
    for projection in [PARALLEL, PERSPECTIVE] {
        // From outside, and from among the triangles.
        for from in [[2.0, -3.0, 1.0], [0.3, 2.5, -0.4], [0.2, 0.1, 0.15]] {
            let camera = camera(from, projection);
            let (image, _) = picture(&surfaces, (&camera, size), &PLAIN);
            for (x, y) in (0..70).flat_map(|y| (0..90).map(move |x| (x, y))) {
                let place = [2.0 * f64::from(x) - 89.0, 69.0 - 2.0 * f64::from(y)];
                let Some(expected) = met(&surfaces, &camera, place.map(|c| c / 70.0)) else {
                    continue;
                };
                let found = image.pixel(x, y);
                let off = (0..3).map(|n| (found.color[n] - expected.color[n]).abs());
                let off = off.fold((found.opacity - expected.opacity).abs(), f32::max);
                assert!(off < 3e-4, "{from:?}, {x}, {y}: {found:?} for {expected:?}");
                compared += 1;
            }
        }
    }
    assert!(compared > 6000, "{compared}");
}

#[test]
fn a_closed_surface_is_met_twice_at_every_point() {
    let ball = ball([0.0; 3], 1.0, 40);
    let glass = [painted(&ball, [1.0; 3], 0.25)];
    for projection in [PARALLEL, PERSPECTIVE] {
        for smoothing in [Smoothing::None, Smoothing::Four, Smoothing::Sixteen] {
            let view = (&camera([1.0, -4.0, 0.7], projection), size(120, 120));
            let (image, _) = picture(&glass, view, &PLAIN.with_smoothing(smoothing));
            let twice = 1.0 - 0.75_f32 * 0.75;
            let steps = match smoothing {
                Smoothing::None => 1.0,
                Smoothing::Four => 4.0,
                Smoothing::Sixteen => 16.0,
            };
            for pixel in image.pixels() {
                // Each point is seen through two walls, or none.
                let points = pixel.opacity / twice * steps;
                assert!((points - points.round()).abs() < 1e-4, "{pixel:?}");
            }
            assert!(image.pixel(60, 60).opacity == twice);
        }
    }
}

#[test]
fn from_within_a_ball_all_around_is_its_wall() {
    let ball = ball([0.0; 3], 1.0, 20);
    let glass = [painted(&ball, [1.0; 3], 0.5)];
    for fov in [20.0, 90.0, 170.0] {
        let within = camera([0.3, 0.2, -0.1], Projection::Perspective { fov });
        let (image, _) = picture(&glass, (&within, size(64, 48)), &PLAIN);
        assert!(image.pixels().iter().all(|pixel| pixel.opacity == 0.5), "{fov}");
    }
}

#[test]
fn the_picture_depends_on_nothing_but_the_scene() {
    let meshes = [soup(300, 5), ball([0.2, 0.0, 0.0], 0.8, 30)];
    let surfaces =
        [painted(&meshes[0], [1.0, 0.2, 0.1], 0.4), painted(&meshes[1], [0.1, 0.9, 0.3], 0.7)];
    let camera = camera([2.0, -3.0, 1.0], PERSPECTIVE);
    let options = RasterOptions::DEFAULT;
    let (expected, drawn) = picture(&surfaces, (&camera, size(150, 97)), &options);
    for threads in [1, 2, 7] {
        let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
        let job = Job { threads, ..Job::default() };
        let found = rasterize(&surfaces, &[], (&camera, size(150, 97)), &options, &job).unwrap();
        assert!(found == (expected.clone(), drawn));
    }
    // Triangles of chance do not lie at one depth.
    let turned = TriMesh {
        triangles: meshes[0].triangles.iter().rev().map(|&[a, b, c]| [c, b, a]).collect(),
        ..meshes[0].clone()
    };
    let other = [surfaces[1], painted(&turned, [1.0, 0.2, 0.1], 0.4)];
    let found = picture(&other, (&camera, size(150, 97)), &options);
    let pairs = found.0.pixels().iter().zip(expected.pixels());
    let off = pairs.flat_map(|(a, b)| (0..3).map(|n| (a.color[n] - b.color[n]).abs()));
    assert!(off.fold(0.0, f32::max) < 1e-5);
}

#[test]
fn an_edge_is_as_smooth_as_the_area_that_it_leaves() {
    let ball = ball([0.0; 3], 1.0, 300);
    let camera = camera([0.0, -5.0, 0.0], PARALLEL);
    let area = |smoothing, n: u32| {
        let options = PLAIN.with_smoothing(smoothing);
        let (image, _) = picture(&[painted(&ball, [1.0; 3], 1.0)], (&camera, size(n, n)), &options);
        let sum: f64 = image.pixels().iter().map(|pixel| f64::from(pixel.opacity)).sum();
        sum * (3.0 / f64::from(n)).powi(2)
    };
    assert!((area(Smoothing::Sixteen, 200) - PI).abs() < 1e-3);
    assert!((area(Smoothing::Four, 200) - PI).abs() < 2e-3);
}

#[test]
fn a_ball_is_lit_by_its_normals() {
    let ball = ball([0.0; 3], 1.0, 100);
    let camera = camera([0.0, -5.0, 0.0], PARALLEL);
    let light = Light { specular: 0.0, ..Light::DEFAULT };
    let surface = [painted(&ball, [1.0, 0.5, 0.0], 1.0)];
    let (image, _) = picture(&surface, (&camera, size(61, 61)), &PLAIN.with_light(Some(light)));
    for (x, y) in (0..61).flat_map(|y| (0..61).map(move |x| (x, y))) {
        let [right, up] = [f64::from(x) - 30.0, 30.0 - f64::from(y)].map(|c| c * 3.0 / 61.0);
        let square = 1.0 - right * right - up * up;
        if square > 0.1 {
            let expected = 0.25 + 0.75 * square.sqrt();
            let found = image.pixel(x, y).color;
            assert!((f64::from(found[0]) - expected).abs() < 2e-3, "{x}, {y}: {found:?}");
            assert_eq!(found[1], 0.5 * found[0]);
        }
    }
}

#[test]
fn a_plane_cuts_and_its_cap_closes() {
    let ball = ball([0.0; 3], 1.0, 60);
    // What is left lies behind the plane.
    let half = HalfSpace::new([0.0, -1.0, 0.0], 0.25).unwrap();
    let camera = camera([0.0, -5.0, 0.0], PARALLEL);
    let surface = [Painted { clips: &[half], ..painted(&ball, [1.0, 0.0, 0.0], 1.0) }];
    let (open, drawn) = picture(&surface, (&camera, size(61, 61)), &PLAIN);
    assert!(drawn.triangles > 0 && drawn.triangles_skipped > 1000, "{drawn:?}");
    assert_eq!(drawn.triangles + drawn.triangles_skipped, ball.triangles.len() as u64);
    assert_eq!(open.pixel(30, 30), Gathered::new([1.0, 0.0, 0.0], 1.0));
    let look = |place: Vector| match dot(place, place) < 1.0 {
        true => Gathered::new([0.0, place[0] as f32 + 1.0, 1.0], 0.5),
        false => Gathered::NOTHING,
    };
    let cap = Cap { half, look: &look };
    let view = (&camera, size(61, 61));
    let (capped, _) = rasterize(&surface, &[cap], view, &PLAIN, &Job::default()).unwrap();
    let middle = capped.pixel(30, 30).color;
    assert!((middle[0] - 0.5).abs() < 1e-6 && (middle[1] - 0.5).abs() < 1e-6, "{middle:?}");
    // The rim is within the ball's outline, and there the wall alone is seen.
    assert_eq!(capped.pixel(30, 50), open.pixel(30, 50));
    assert_eq!(open.pixel(30, 50).opacity, 1.0);
    // From behind the wall hides the cap.
    let behind = super::tests::camera([0.0, 5.0, 0.0], PARALLEL);
    let view = (&behind, size(61, 61));
    let (found, _) = rasterize(&surface, &[cap], view, &PLAIN, &Job::default()).unwrap();
    assert!(found == picture(&surface, view, &PLAIN).0);
}

#[test]
fn a_solid_texture_does_not_depend_on_the_triangles() {
    let stripes = |place: Vector| {
        [(place[0] * 9.0).sin() as f32 * 0.5 + 0.5, 0.3, place[2] as f32 * 0.5 + 0.5]
    };
    let camera = camera([1.0, -4.0, 0.7], PERSPECTIVE);
    let look = |n| {
        let ball = ball([0.0; 3], 1.0, n);
        let surface = Painted { paint: Paint::Solid(&stripes), ..painted(&ball, [0.0; 3], 1.0) };
        picture(&[surface], (&camera, size(80, 80)), &PLAIN).0
    };
    let (coarse, fine) = (look(90), look(200));
    let pairs = coarse.pixels().iter().zip(fine.pixels());
    let inner = pairs.filter(|(a, b)| a.opacity == b.opacity);
    let off = inner.flat_map(|(a, b)| (0..3).map(|n| (a.color[n] - b.color[n]).abs()));
    assert!(off.fold(0.0, f32::max) < 0.05);
}

#[test]
fn what_cannot_be_seen_is_not_drawn() {
    let ball = ball([0.0; 3], 1.0, 30);
    let hidden = painted(&ball, [1.0; 3], 0.0);
    let camera = camera([0.0, -5.0, 0.0], PARALLEL);
    let (image, drawn) = picture(&[hidden], (&camera, size(20, 20)), &PLAIN);
    assert!(image.pixels().iter().all(|pixel| *pixel == Gathered::NOTHING));
    let triangles_skipped = ball.triangles.len() as u64;
    assert_eq!(drawn, Drawn { triangles_skipped, ..Drawn::default() });
    // Behind a wall nothing is lit.
    let wall = super::tests::ball([0.0; 3], 1.4, 30);
    let inner = painted(&ball, [1.0; 3], 0.5);
    let surfaces = [inner, painted(&wall, [1.0; 3], 1.0)];
    let (_, drawn) = picture(&surfaces, (&camera, size(20, 20)), &PLAIN);
    assert!(drawn.hidden > 0 && drawn.lit <= 400, "{drawn:?}");
}

#[test]
fn meshes_with_holes_in_their_numbers_are_drawn_without_them() {
    let mut broken = soup(4, 9);
    broken.triangles.extend([[0, 1, 99], [u32::MAX, 0, 1], [0, 0, 0], [0, 1, 1]]);
    broken.normals = Some(vec![[0.0, 1.0, 0.0]; 2]);
    if let Positions::F64(positions) = &mut broken.positions {
        positions[3] = [f64::NAN; 3];
        positions[6] = [f64::INFINITY, 0.0, 0.0];
        positions[9] = [1e300; 3];
    }
    let camera = camera([0.0, -5.0, 0.0], PERSPECTIVE);
    let surface = [painted(&broken, [1.0; 3], 1.0)];
    let (image, drawn) = picture(&surface, (&camera, size(40, 40)), &RasterOptions::DEFAULT);
    assert_eq!(drawn.triangles + drawn.triangles_skipped, 8);
    assert!(drawn.triangles >= 1);
    assert!(image.pixels().iter().all(|pixel| pixel.color.iter().all(|part| part.is_finite())));
}

#[test]
fn a_picture_of_no_use_is_refused_before_it_takes_memory() {
    let ball = ball([0.0; 3], 1.0, 4);
    let (surface, camera) = ([painted(&ball, [1.0; 3], 1.0)], camera([0.0, -5.0, 0.0], PARALLEL));
    let refused =
        |size, job: &Job| rasterize(&surface, &[], (&camera, size), &PLAIN, job).unwrap_err();
    let error = refused(size(70_000, 1), &Job::default());
    assert!(error.to_string().contains("70000 by 1 pixels"), "{error}");
    let job = Job { limits: Limits { bytes: 1 << 10 }, ..Job::default() };
    assert!(matches!(refused(size(64, 64), &job), RasterError::Stopped(_)));
    let job = Job::default();
    job.cancel.cancel();
    assert!(matches!(refused(size(64, 64), &job), RasterError::Stopped(_)));
}

#[test]
fn memory_for_triangles_that_are_everywhere_is_asked_for_as_it_grows() {
    let corners = vec![[-50.0, 0.0, -50.0], [50.0, 0.0, -50.0], [0.0, 0.0, 90.0]];
    let positions = Positions::F64(corners);
    let mesh = TriMesh { positions, triangles: vec![[0, 1, 2]; 3000], ..TriMesh::default() };
    let surface = [painted(&mesh, [1.0; 3], 0.5)];
    let camera = camera([0.0, -5.0, 0.0], PARALLEL);
    // The picture takes 16 MiB, and its tiles 8 bytes for each of 6 million entries.
    let job = Job { limits: Limits { bytes: 30 << 20 }, ..Job::default() };
    let error = rasterize(&surface, &[], (&camera, size(1024, 1024)), &PLAIN, &job).unwrap_err();
    assert!(error.to_string().contains("triangles by tiles"), "{error}");
}

#[test]
fn from_any_distance_a_parallel_picture_is_the_same() {
    let (skin, core) = (ball([0.0; 3], 10.0, 24), ball([0.0; 3], 9.7, 24));
    let surfaces = [painted(&skin, [1.0, 0.0, 0.0], 0.4), painted(&core, [0.0, 0.0, 1.0], 0.4)];
    let parallel = Projection::Parallel { height: 24.0 };
    let from = |away: f64| {
        let camera = camera([0.0, -away, 0.0], parallel);
        rasterize(&surfaces, &[], (&camera, size(60, 60)), &PLAIN, &Job::default()).unwrap().0
    };
    assert!(from(30.0) == from(2.0_f64.powi(30)));
}
