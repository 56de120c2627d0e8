//! Boxes with something in them behind surfaces, against pictures of both.

use super::{are_behind, boxes_in_sight, hides_within};
use crate::{
    Camera, Projection, Size,
    raster::{Paint, Painted, RasterOptions, Smoothing, rasterize},
};
use isokit_geom::{Aabb, vector::Vector};
use isokit_job::Job;
use isokit_mesh::{Positions, TriMesh};
use std::num::NonZeroU32;

/// Numbers from 0 to 1, from a generator with a fixed beginning.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }

    fn within(&mut self, bounds: Aabb) -> Vector {
        std::array::from_fn(|k| bounds.min[k] + self.next() * (bounds.max[k] - bounds.min[k]))
    }

    /// Triangles with corners anywhere in a box.
    fn triangles(&mut self, bounds: Aabb, count: u32) -> TriMesh {
        let places = (0..3 * count).map(|_| self.within(bounds)).collect();
        let triangles = (0..count).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
        TriMesh { positions: Positions::F64(places), triangles, ..TriMesh::default() }
    }
}

/// The six sides of a box.
fn closed(bounds: Aabb) -> TriMesh {
    let sides: [[u32; 4]; 6] =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let positions = Positions::F64(bounds.corners().to_vec());
    TriMesh { positions, triangles, ..TriMesh::default() }
}

fn cube(middle: Vector, half: f64) -> Aabb {
    Aabb { min: middle.map(|c| c - half), max: middle.map(|c| c + half) }
}

fn size(width: u32, height: u32) -> Size {
    let [width, height] = [width, height].map(|n| NonZeroU32::new(n).unwrap());
    Size { width, height }
}

fn camera(from: Vector, projection: Projection) -> Camera {
    Camera::new(from, [0.0; 3], [0.0, 0.0, 1.0], projection).unwrap()
}

/// Whether a picture of a surface changes with another one.
fn is_seen(wall: &TriMesh, other: &TriMesh, view: (&Camera, Size), smoothing: Smoothing) -> bool {
    let of =
        |mesh, color, opacity| Painted { mesh, paint: Paint::Plain(color), opacity, clips: &[] };
    let wall = of(wall, [0.9, 0.5, 0.1], 1.0);
    let options = RasterOptions::DEFAULT.with_smoothing(smoothing);
    let draw = |surfaces: &[Painted<'_>]| {
        rasterize(surfaces, &[], view, &options, &Job::default()).unwrap().0
    };
    let alone = draw(&[wall]);
    [0.4, 1.0].iter().any(|&opacity| {
        let other = of(other, [0.1, 0.2, 1.0], opacity);
        draw(&[wall, other]) != alone || draw(&[other, wall]) != alone
    })
}

fn is_behind(wall: &TriMesh, bounds: Aabb, view: (&Camera, Size), smoothing: Smoothing) -> bool {
    let wall = Painted { mesh: wall, paint: Paint::Plain([1.0; 3]), opacity: 1.0, clips: &[] };
    let boxes = (|_| bounds.corners(), 1, 1);
    boxes_in_sight(&wall, boxes, view, smoothing, &Job::default()).unwrap() == Some(vec![])
}

#[test]
fn of_what_is_in_boxes_behind_a_surface_no_picture_shows_anything() {
    let (mut chance, mut hidden) = (Chance(7), 0);
    for n in 0..300 {
        // A wall with gaps, or a closed box.
        let wall = match n % 3 {
            0 => closed(cube(chance.within(cube([0.0; 3], 0.3)), 0.3 + 0.7 * chance.next())),
            _ => chance.triangles(Aabb { min: [-2.0, -1.2, -2.0], max: [2.0, -0.3, 2.0] }, 60),
        };
        let bounds = cube(chance.within(cube([0.0; 3], 0.8)), 0.02 + 0.2 * chance.next());
        let projection = match n % 2 {
            0 => Projection::Parallel { height: 2.0 },
            _ => Projection::Perspective { fov: 40.0 },
        };
        let from = [[0.0, -4.0, 0.0], [1.0, -3.0, 1.5], [0.1, -1.0, 0.0]][n % 5 % 3];
        let camera = camera(from, projection);
        let smoothing = [Smoothing::None, Smoothing::Four, Smoothing::Sixteen][n % 7 % 3];
        let view = (&camera, [size(90, 70), size(33, 60)][n % 2]);
        if is_behind(&wall, bounds, view, smoothing) {
            hidden += 1;
            let other = chance.triangles(bounds, 40);
            assert!(!is_seen(&wall, &other, view, smoothing), "{n}: {bounds:?}");
        }
    }
    assert!((40..260).contains(&hidden), "{hidden}");
}

#[test]
fn triangles_behind_a_surface_may_be_a_little_elsewhere() {
    let (mut chance, mut hidden) = (Chance(19), 0);
    for n in 0..120 {
        // So near behind the wall that a box around them would not be.
        let slope = [chance.next() - 0.5, chance.next() - 0.5];
        let wall = chance.triangles(cube([0.0; 3], 2.0), 9);
        let flat = |place: Vector, behind: f64| {
            [place[0], slope[0] * place[0] + slope[1] * place[2] + behind, place[2]]
        };
        let flattened = |mesh: &TriMesh, behind: f64| {
            let places = mesh.positions.iter().map(|place| flat(place, behind)).collect();
            TriMesh { positions: Positions::F64(places), ..mesh.clone() }
        };
        let count = 1 + n % 3;
        let behind = 0.02 * chance.next() - 0.004;
        let wall = flattened(&wall, 0.0);
        let others = flattened(&chance.triangles(cube([0.0; 3], 0.6), count), behind);
        let projection = match n % 2 {
            0 => Projection::Parallel { height: 2.0 },
            _ => Projection::Perspective { fov: 40.0 },
        };
        let camera = camera([chance.next(), -4.0, chance.next()], projection);
        let smoothing = [Smoothing::None, Smoothing::Four][n as usize % 4 / 2];
        let view = (&camera, size(80, 60));
        let off = [0.0, 1e-5, 1e-3][n as usize % 5 % 3];
        let triangles = others.triangles.iter().map(|&triangle| others.corners(triangle));
        let plain =
            Painted { mesh: &wall, paint: Paint::Plain([1.0; 3]), opacity: 1.0, clips: &[] };
        let job = Job::default();
        if are_behind(&plain, (triangles, off), view, smoothing, &job).unwrap() {
            hidden += 1;
            for _ in 0..2 {
                let moved = |place: Vector| chance.within(cube(place, 0.5 * off));
                let places = others.positions.iter().map(moved).collect();
                let others = TriMesh { positions: Positions::F64(places), ..others.clone() };
                assert!(!is_seen(&wall, &others, view, smoothing), "{n}: {behind}");
            }
        }
    }
    assert!((12..108).contains(&hidden), "{hidden}");
}

#[test]
fn a_box_that_is_before_or_beside_a_wall_or_that_touches_it_is_not_behind() {
    let wall = closed(Aabb { min: [-1.0, 0.0, -1.0], max: [1.0, 0.5, 1.0] });
    let at = |y: f64| Aabb { min: [-0.3, y, -0.3], max: [0.3, y + 0.2, 0.3] };
    for projection in [Projection::Parallel { height: 3.0 }, Projection::Perspective { fov: 60.0 }]
    {
        let camera = camera([0.0, -4.0, 0.0], projection);
        let view = (&camera, size(60, 60));
        for (y, expected) in
            [(-1.0, false), (-0.1, false), (0.0, false), (0.001, true), (2.0, true)]
        {
            assert_eq!(is_behind(&wall, at(y), view, Smoothing::Four), expected, "{y}");
        }
        let beside = Aabb { min: [0.8, 1.0, 0.0], max: [1.6, 1.2, 0.1] };
        assert!(!is_behind(&wall, beside, view, Smoothing::Four));
        // Behind the camera nothing is known; what is beside the picture is not in it.
        assert!(!is_behind(&wall, at(-5.0), view, Smoothing::Four));
        let away = Aabb { min: [50.0, 1.0, 0.0], max: [51.0, 2.0, 1.0] };
        assert!(is_behind(&wall, away, view, Smoothing::Four));
        let far = away.corners().map(|corner| corner.map(|c| c * 1e308));
        let wall = Painted { mesh: &wall, paint: Paint::Plain([1.0; 3]), opacity: 1.0, clips: &[] };
        let boxes = [at(2.0).corners(), at(-1.0).corners()];
        let (two, job) = (|n: usize| boxes[n], Job::default());
        let found = |most| boxes_in_sight(&wall, (two, 2, most), view, Smoothing::Four, &job);
        assert_eq!([found(1).unwrap(), found(0).unwrap()], [Some(vec![1]), None]);
        let found = boxes_in_sight(&wall, (|_| far, 1, 1), view, Smoothing::Four, &job);
        assert_eq!(found.unwrap(), None);
    }
}

#[test]
fn what_a_closed_surface_encloses_is_seen_in_no_picture() {
    let (mut chance, mut hidden) = (Chance(3), 0);
    let bounds = cube([0.0; 3], 1.0);
    let wall = closed(bounds);
    for n in 0..200 {
        let gap = 0.3 * chance.next().powi(4);
        let projection = match n % 2 {
            0 => Projection::Parallel { height: 3.0 },
            _ => Projection::Perspective { fov: 60.0 },
        };
        let camera = camera(chance.within(cube([0.0; 3], 5.0)), projection);
        let view = (&camera, [size(80, 70), size(5, 4)][n % 4 / 2]);
        if hides_within(bounds.corners(), gap, view) {
            hidden += 1;
            let other = chance.triangles(cube([0.0; 3], 1.0 - gap), 100);
            assert!(!is_seen(&wall, &other, view, Smoothing::Four), "{n}: {gap}, {camera:?}");
        }
    }
    assert!((40..160).contains(&hidden), "{hidden}");
}

#[test]
fn a_surface_hides_nothing_from_within_nor_in_a_picture_that_is_too_small() {
    let bounds = cube([0.0; 3], 1.0).corners();
    let perspective = Projection::Perspective { fov: 60.0 };
    let hides = |from, projection, gap, n| {
        hides_within(bounds, gap, (&camera(from, projection), size(n, n)))
    };
    assert!(hides([0.0, -3.0, 0.0], perspective, 0.1, 60));
    assert!(!hides([0.0, -0.5, 0.0], perspective, 0.1, 60));
    // The eye is beside the box, and a corner of that is behind it.
    assert!(!hides([0.9, -1.05, 0.9], perspective, 0.1, 60));
    assert!(!hides([0.0, -3.0, 0.0], perspective, 1e-4, 60));
    assert!(!hides([0.0, -3.0, 0.0], Projection::Parallel { height: 1e4 }, 0.1, 60));
    assert!(!hides([0.0, -1e9, 0.0], Projection::Parallel { height: 3.0 }, 1e-9, 60));
}
