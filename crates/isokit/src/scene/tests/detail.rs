//! Pictures of as few samples as pixels show.

use super::{scan, scene};
use crate::{
    pipeline::Scan,
    scene::{Scene, Viewpoint},
};
use isokit_geom::{Affine, Frame};
use isokit_job::Job;
use isokit_render::{Cast, ControlPoint, Image, Projection, Size, TransferFunction};
use isokit_volume::{Grid, Volume};
use std::num::NonZeroU32;

fn size(n: u32) -> Size {
    let n = NonZeroU32::new(n).unwrap();
    Size { width: n, height: n }
}

fn from(place: [f64; 3], projection: Projection) -> Viewpoint {
    Viewpoint::At { from: place, at: Some([0.0; 3]), up: [0.0, 0.0, 1.0], orbit: 0.0, projection }
}

/// The mean of what parts of colours differ by.
fn mean_difference(a: &Image, b: &Image) -> f32 {
    let pairs = a.pixels().iter().zip(b.pixels());
    let parts = pairs.map(|(a, b)| (0..3).map(|k| (a.color[k] - b.color[k]).abs()).sum::<f32>());
    parts.sum::<f32>() / (3 * a.pixels().len()) as f32
}

#[test]
fn samples_are_halved_as_long_as_they_are_no_farther_apart_than_pixels() {
    let (scan, parallel) = (scan(), Projection::Parallel { height: 60.0 });
    // Samples are 1, 0.8 and 1.25 apart.
    for (pixels, expected) in
        [(300, [0; 3]), (37, [0, 1, 0]), (29, [1, 1, 0]), (18, [1, 2, 1]), (11, [2, 2, 2])]
    {
        let viewpoints = [from([0.0, 60.0, 0.0], parallel)];
        let camera = (&viewpoints[..], size(pixels));
        let found = Scene::halvings(scan.lattice(), scan.around().0, camera).unwrap();
        assert_eq!(found, expected, "{pixels}");
    }
    // Of two viewpoints the nearer one counts, and in a perspective the nearest corner.
    let perspective = Projection::Perspective { fov: 60.0 };
    let [far, near] = [400.0, 60.0].map(|y| from([0.0, y, 0.0], perspective));
    let of = |viewpoints: &[Viewpoint]| {
        Scene::halvings(scan.lattice(), scan.around().0, (viewpoints, size(60))).unwrap()
    };
    assert_eq!(of(&[far]), [2, 3, 2]);
    assert_eq!([of(&[near]), of(&[far, near])], [[0; 3]; 2]);
    assert_eq!(of(&[from([1.0; 3], perspective)]), [0; 3], "from within");
}

#[test]
fn samples_are_not_halved_beyond_what_has_a_place_in_the_world() {
    // Distances of samples are below 1e75.
    let columns = [[1e74, 0.0, 0.0], [0.0, 4e74, 0.0], [0.0, 0.0, 9e74]];
    let index_to_world = Affine::new(columns, [0.0; 3]).unwrap();
    let grid = Grid::new([20; 3], Frame { index_to_world, ..Frame::default() }).unwrap();
    let far = Scan::new(Volume::new(grid, vec![0_u8; 8000]).unwrap());
    let viewpoints = [from([0.0, 1e77, 0.0], Projection::Parallel { height: 1e77 })];
    let camera = (&viewpoints[..], size(1));
    let halvings = Scene::halvings(far.lattice(), far.around().0, camera).unwrap();
    assert_eq!(halvings, [2, 1, 0]);
    assert!(far.halved(halvings, &Job::default()).unwrap().is_some());
}

#[test]
fn surfaces_of_fewer_samples_look_the_same_in_a_small_picture() {
    let (scan, scene, job) = (scan(), scene(), Job::default());
    let viewpoints = [scene.viewpoint];
    let full = scene.meshes(&scan, (&viewpoints, size(300)), &job).unwrap();
    for (pixels, is_less) in [(300, false), (11, true)] {
        let size = size(pixels);
        let seen = scene.meshes_on_screen(&scan, (&viewpoints, size), &job).unwrap();
        assert_eq!((seen.bricks_lost, seen.halvings != [0; 3]), (0, is_less));
        if !is_less {
            assert!(seen.meshes == full);
            continue;
        }
        for (few, all) in seen.meshes.iter().zip(&full) {
            assert!(few.triangles.len() * 8 < all.triangles.len() && !few.triangles.is_empty());
        }
        let draw = |meshes| scene.draw(meshes, (Some(&scan), scan.around()), size, &job).unwrap().0;
        let difference = mean_difference(&draw(&seen.meshes), &draw(&full));
        assert!(difference < 0.01, "{difference}");
    }
}

#[test]
fn what_is_smaller_than_pixels_is_counted_where_it_is_lost() {
    let grid = Grid::new([64, 32, 32], Default::default()).unwrap();
    let at = |n: u64| [n % 64, n / 64 % 32, n / 2048].map(|i| i as f64);
    // A ball of radius 9, and one sample at a distance.
    let sample = |n: u64| match at(n) {
        [45.0, 15.0, 17.0] => 5.0_f32,
        [x, y, z] => {
            9.0 - ((x - 16.0).powi(2) + (y - 16.0).powi(2) + (z - 16.0).powi(2)).sqrt() as f32
        }
    };
    let scan = Scan::new(Volume::new(grid, (0..grid.count()).map(sample).collect()).unwrap());
    let mut scene = scene();
    scene.surfaces.truncate(1);
    let viewpoints = [from([16.0, 90.0, 16.0], Projection::Parallel { height: 40.0 })];
    let small = (&viewpoints[..], size(10));
    let seen = scene.meshes_on_screen(&scan, small, &Job::default()).unwrap();
    assert_eq!(seen.halvings, [2, 2, 2]);
    assert!(seen.bricks_lost == 0, "the ball is in the same brick along x");
    scene.surfaces[0].iso = Some(4.5);
    let far = Scan::new({
        let sample = |n| if at(n)[0] < 33.0 { -1.0 } else { sample(n) };
        Volume::new(grid, (0..grid.count()).map(sample).collect()).unwrap()
    });
    let seen = scene.meshes_on_screen(&far, small, &Job::default()).unwrap();
    assert!(seen.bricks_lost > 0 && seen.bricks_lost == seen.bricks, "{seen:?}");
    assert!(seen.meshes[0].triangles.is_empty());
}

#[test]
fn values_of_fewer_samples_look_the_same_in_a_small_picture() {
    let (scan, job, size) = (scan(), Job::default(), size(11));
    let mut scene = scene();
    let point = |value, opacity| ControlPoint { value, color: [1.0, 0.5, 0.0], opacity };
    let points = vec![point(0.0, 0.0), point(20.0, 0.1)];
    scene.model = Some(TransferFunction::new(points).unwrap().into());
    scene.raycast = scene.raycast.with_unit(Some(1.0)).with_light(None);
    let coarse = scan.halved([2, 2, 2], &job).unwrap().unwrap();
    let (few, done) = scene.cast(&coarse, size, &job).unwrap();
    let (all, of_all) = scene.cast(&scan, size, &job).unwrap();
    let steps = |cast: &Cast| cast.steps + cast.steps_leapt;
    assert!(4 * steps(&done) < steps(&of_all), "{done:?}, {of_all:?}");
    let difference = mean_difference(&few, &all);
    assert!(difference < 0.01, "{difference}");
    assert!(scan.halved([0; 3], &job).unwrap().is_none());
}
