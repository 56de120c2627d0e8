//! Depths, normals, shadows and corners, of meshes and of isosurfaces.

use super::{Channel, DIRECTIONS, direction};
use crate::{
    Camera, Cap, Gathered, Image, Isosurface, Isosurfaces, Kernel, Light, Paint, Painted,
    Projection, RasterOptions, Size, Smoothing, isocast, rasterize,
};
use isokit_geom::{
    Frame, HalfSpace,
    vector::{Vector, cross, dot, length},
};
use isokit_job::Job;
use isokit_mesh::{Positions, TriMesh};
use isokit_volume::{Grid, Volume};
use std::num::NonZeroU32;

const ONE: RasterOptions = RasterOptions::DEFAULT.with_smoothing(Smoothing::None);
/// Light that comes from all sides alike, but where something is in its way.
const EVEN: Light = Light { ambient: 1.0, diffuse: 0.0, specular: 0.0, shininess: 1 };

#[test]
fn directions_are_spread_evenly() {
    let all: Vec<_> = (0..DIRECTIONS).map(direction).collect();
    for k in 0..3 {
        let mean: f64 = all.iter().map(|d| d[k]).sum::<f64>() / f64::from(DIRECTIONS);
        let square: f64 = all.iter().map(|d| d[k] * d[k]).sum::<f64>() / f64::from(DIRECTIONS);
        assert!(mean.abs() < 0.02 && (square - 1.0 / 3.0).abs() < 0.01, "{k}: {mean}, {square}");
    }
    for (n, a) in all.iter().enumerate() {
        assert!((length(*a) - 1.0).abs() < 1e-12);
        let near = all[..n].iter().map(|b| length(cross(*a, *b)).atan2(dot(*a, *b)));
        assert!(near.fold(f64::INFINITY, f64::min) > 0.2, "{n}");
    }
}

/// Squares, each from a corner along two edges.
fn squares(all: &[[Vector; 3]]) -> TriMesh {
    let mut mesh = TriMesh::default();
    let mut positions = vec![];
    for &[corner, first, second] in all {
        let n = positions.len() as u32;
        for (a, b) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            let at = |k: usize| corner[k] + a * first[k] + b * second[k];
            positions.push([at(0), at(1), at(2)]);
        }
        mesh.triangles.extend([[n, n + 1, n + 2], [n, n + 2, n + 3]]);
    }
    mesh.positions = Positions::F64(positions);
    mesh
}

fn size(n: u32) -> Size {
    let n = NonZeroU32::new(n).unwrap();
    Size { width: n, height: n }
}

fn draw(mesh: &TriMesh, opacity: f32, camera: &Camera, options: &RasterOptions) -> Image {
    let painted = [Painted { mesh, paint: Paint::Plain([0.5; 3]), opacity, clips: &[] }];
    rasterize(&painted, &[], (camera, size(81)), options, &Job::default()).unwrap().0
}

/// From above, on what is between −4 and 4.
fn above() -> Camera {
    let parallel = Projection::Parallel { height: 8.0 };
    Camera::new([0.0, 0.0, 20.0], [0.0; 3], [0.0, 1.0, 0.0], parallel).unwrap()
}

const FLOOR: [Vector; 3] = [[-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]];

#[test]
fn depths_and_normals_of_a_plane_are_those_of_the_plane() {
    // z = x / 2.
    let ramp = squares(&[[[-9.0, -9.0, -4.5], [18.0, 0.0, 9.0], [0.0, 18.0, 0.0]]]);
    let perspective = Projection::Perspective { fov: 40.0 };
    let near = Camera::new([1.0, 0.0, 8.0], [0.0; 3], [0.0, 1.0, 0.0], perspective).unwrap();
    for (camera, opacity) in [(above(), 1.0), (near, 0.25)] {
        let depths = draw(&ramp, opacity, &camera, &ONE.with_channel(Channel::Depth));
        let normals = draw(&ramp, opacity, &camera, &ONE.with_channel(Channel::Normal));
        for (column, row) in [(40, 40), (10, 70), (66, 12)] {
            let ray = camera.pixel_ray(size(81), [column, row].map(|n| f64::from(n) + 0.5));
            let [origin, towards] = [ray.origin, ray.direction];
            let far = (0.5 * origin[0] - origin[2]) / (towards[2] - 0.5 * towards[0]);
            let place = std::array::from_fn(|k| origin[k] + far * towards[k]);
            let [_, _, ahead] = camera.view(place);
            let found = depths.pixel(column, row);
            assert!((f64::from(found.color[0]) - ahead).abs() < 1e-5, "{found:?} for {ahead}");
            assert_eq!(found.opacity, 1.0);
            let [right, up, ahead] = camera.turned([-0.5, 0.0, 1.0]);
            let found = normals.pixel(column, row).color;
            for (found, expected) in found.into_iter().zip([right, up, -ahead]) {
                let expected = expected / 1.25_f64.sqrt();
                assert!((f64::from(found) - expected).abs() < 1e-6, "{found} for {expected}");
            }
        }
    }
}

#[test]
fn what_is_in_the_way_of_light_throws_a_shadow_where_light_leads() {
    // A square two above the floor: light from 45 degrees aside throws its shadow two to the left.
    let roof = [[-1.0, -1.0, 2.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    let light = ONE.with_light_from(Some([1.0, 0.0, 1.0]), true);
    let lit = draw(&squares(&[FLOOR]), 1.0, &above(), &light);
    let shadowed = draw(&squares(&[FLOOR, roof]), 1.0, &above(), &light);
    let pixel = |place: f64| ((place + 4.0) / 8.0 * 81.0) as u32;
    for (x, is_dark) in [(-2.2, true), (-1.5, true), (-3.4, false), (2.0, false)] {
        for y in [-0.5, 0.0, 0.7] {
            let (column, row) = (pixel(x), 80 - pixel(y));
            let ratio = shadowed.pixel(column, row).color[0] / lit.pixel(column, row).color[0];
            assert_eq!(ratio < 0.6, is_dark, "{x}, {y}: {ratio}");
            assert!(is_dark || ratio == 1.0, "{x}, {y}: {ratio}");
        }
    }
    let bright = draw(
        &squares(&[FLOOR, roof]),
        1.0,
        &above(),
        &light.with_light_from(Some([1.0, 0.0, 1.0]), false),
    );
    assert_eq!(bright.pixel(pixel(-2.0), 40), lit.pixel(pixel(-2.0), 40));
    // What is translucent is in nobody's way.
    let glass = draw(&squares(&[FLOOR, roof]), 0.5, &above(), &light);
    let other = draw(&squares(&[FLOOR]), 0.5, &above(), &light);
    assert_eq!(glass.pixel(pixel(-2.0), 40), other.pixel(pixel(-2.0), 40));
}

#[test]
fn corners_are_darker_than_what_is_open_and_convex_things_are_not() {
    let walls = [
        FLOOR,
        [[1.0, -9.0, 0.0], [0.0, 18.0, 0.0], [0.0, 0.0, 6.0]],
        [[-1.0, -9.0, 0.0], [0.0, 18.0, 0.0], [0.0, 0.0, 6.0]],
    ];
    let options = ONE.with_light(Some(EVEN)).with_occlusion(1.0);
    let gap = draw(&squares(&walls), 1.0, &above(), &options);
    let [middle, side, open] = [40, 31, 12].map(|column| gap.pixel(column, 40).color[0] / 0.5);
    assert!(middle < 0.5 && open > 0.55, "{side}, {middle}, {open}");
    let plain = draw(&squares(&[FLOOR]), 1.0, &above(), &options);
    assert!(plain.pixel(40, 40).color[0] / 0.5 > 0.99);
    let half = draw(&squares(&walls), 1.0, &above(), &options.with_occlusion(0.5));
    let found = half.pixel(40, 40).color[0] / 0.5;
    assert!((found - 0.5 * (1.0 + middle)).abs() < 1e-6, "{found}, {middle}");
}

#[test]
fn isosurfaces_have_the_depths_shadows_and_corners_of_what_they_are() {
    // A floor with a ball above it, as distances.
    let grid = Grid::new([41, 41, 31], Frame::default()).unwrap();
    let value = |n: u64| {
        let [x, y, z] = [n % 41, n / 41 % 41, n / 1681].map(|c| c as f64);
        let ball = 6.0 - length([x - 20.0, y - 20.0, z - 16.0]);
        ball.max(5.25 - z) as f32
    };
    let volume = Volume::new(grid, (0..grid.count()).map(value).collect()).unwrap();
    let view = volume.view();
    let paint = Paint::Plain([0.5; 3]);
    let surfaces = [Isosurface { iso: 0.0, paint, opacity: 1.0, clips: &[] }];
    let scene = Isosurfaces {
        view: &view,
        bricks: None,
        kernel: Kernel::Linear,
        surfaces: &surfaces,
        caps: &[],
    };
    let parallel = Projection::Parallel { height: 38.0 };
    let camera =
        Camera::new([20.0, 20.0, 60.0], [20.0, 20.0, 0.0], [0.0, 1.0, 0.0], parallel).unwrap();
    let of = |options: &RasterOptions| {
        isocast(&scene, (&camera, size(76)), options, &Job::default()).unwrap().0
    };
    let depths = of(&ONE.with_channel(Channel::Depth));
    assert!((depths.pixel(4, 4).color[0] - 54.75).abs() < 1e-4);
    assert!((depths.pixel(38, 38).color[0] - 38.0).abs() < 0.1);
    let normals = of(&ONE.with_channel(Channel::Normal));
    assert!(normals.pixel(4, 4).color[2] > 0.999);
    // Light from the right and above: 11 above the floor the ball's shadow is 11 to the left.
    let light = ONE.with_light_from(Some([1.0, 0.0, 1.0]), true);
    let (lit, free) = (of(&light), of(&light.with_light_from(Some([1.0, 0.0, 1.0]), false)));
    let ratio = |column: u32| lit.pixel(column, 38).color[0] / free.pixel(column, 38).color[0];
    assert!(ratio(16) < 0.6 && ratio(66) == 1.0, "{}, {}", ratio(16), ratio(66));
    let open = of(&ONE.with_light(Some(EVEN)).with_occlusion(1.0));
    let [under, far] = [53, 74].map(|column| open.pixel(column, 38).color[0]);
    assert!(under < far, "{under}, {far}");
}

#[test]
fn shadows_fall_alike_whatever_the_unit_of_the_world() {
    let roof = [[-1.0, -1.0, 2.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    let of = |factor: f64| {
        let scaled = [FLOOR, roof].map(|square| square.map(|edge| edge.map(|c| c * factor)));
        let parallel = Projection::Parallel { height: 8.0 * factor };
        let from = [0.0, 0.0, 20.0 * factor];
        let above = Camera::new(from, [0.0; 3], [0.0, 1.0, 0.0], parallel).unwrap();
        let light = ONE.with_light_from(Some([1.0, 0.0, 1.0]), true).with_occlusion(0.5);
        draw(&squares(&scaled), 1.0, &above, &light)
    };
    for factor in [2.0_f64.powi(100), 2.0_f64.powi(-100)] {
        let (found, plain) = (of(factor), of(1.0));
        let pairs = found.pixels().iter().zip(plain.pixels());
        let off: Vec<f32> = pairs.map(|(a, b)| a.differs(*b)).filter(|off| *off > 1e-5).collect();
        assert!(off.is_empty(), "{factor}: {off:?}");
    }
}

#[test]
fn the_cap_of_what_is_translucent_throws_a_shadow() {
    let light = ONE.with_light_from(Some([1.0, 0.0, 1.0]), true);
    let (floor, wide) = (squares(&[FLOOR]), squares(&[[[-9.0, -9.0, 2.0], [18.0; 3], [0.0; 3]]]));
    // A square cap two above the floor, as in the test of shadows.
    let look = |place: Vector| {
        let is_in = place[0].abs() <= 1.0 && place[1].abs() <= 1.0;
        if is_in { Gathered::new([0.5; 3], 1.0) } else { Gathered::NOTHING }
    };
    let half = HalfSpace::new([0.0, 0.0, 1.0], 2.0).unwrap();
    let paint = Paint::Plain([0.5; 3]);
    let painted = [
        Painted { mesh: &floor, paint, opacity: 1.0, clips: &[] },
        Painted { mesh: &wide, paint, opacity: 0.01, clips: &[] },
    ];
    let draw = |caps: &[Cap<'_>]| {
        let camera = (&above(), size(81));
        rasterize(&painted, caps, camera, &light, &Job::default()).unwrap().0
    };
    let (lit, shadowed) = (draw(&[]), draw(&[Cap { half, look: &look }]));
    let at = |image: &Image| image.pixel(((-2.0 + 4.0) / 8.0 * 81.0) as u32, 40).color[0];
    assert!(at(&shadowed) < 0.6 * at(&lit), "{} of {}", at(&shadowed), at(&lit));
}
