//! Against closed forms, against a mesh's vertices, and against the plain sums that are meant.

use super::{Contour, ContourSpectrum};
use crate::Levels;
use isokit_geom::{Affine, Frame};
use isokit_job::{Job, Threads};
use isokit_volume::{Grid, Sample, Scaling, Volume};
use std::{f64::consts::PI, num::NonZeroUsize};

fn volume<T: Sample>(
    dims: [u64; 3],
    columns: [[f64; 3]; 3],
    value: impl Fn([f64; 3], [u64; 3]) -> T,
) -> Volume<T> {
    let middle: [f64; 3] = std::array::from_fn(|r| {
        (0..3).map(|k| -0.5 * (dims[k] - 1) as f64 * columns[k][r]).sum::<f64>() + 0.1
    });
    let index_to_world = Affine::new(columns, middle).unwrap();
    let grid = Grid::new(dims, Frame { index_to_world, ..Frame::default() }).unwrap();
    let [nx, ny, _] = dims;
    let at = |n: u64| {
        let ijk = [n % nx, n / nx % ny, n / nx / ny];
        value(index_to_world.point(ijk.map(|i| i as f64)), ijk)
    };
    Volume::new(grid, (0..grid.count()).map(at).collect()).unwrap()
}

fn spectrum<T: Sample>(volume: &Volume<T>, range: [f64; 2], count: usize) -> Vec<Contour> {
    let levels = Levels::between(range, count).unwrap();
    ContourSpectrum::of(&volume.view(), levels, &Job::default()).unwrap().contours().to_vec()
}

const CUBES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

#[track_caller]
fn assert_near(found: f64, exact: f64, share: f64, what: &str) {
    assert!((found / exact - 1.0).abs() <= share, "{what}: {found} for {exact}");
}

#[test]
fn balls_have_the_area_the_volume_and_the_gradient_of_balls() {
    let bricks = [[0.8, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.25]];
    let sheared = [[0.9, 0.2, 0.0], [-0.1, 1.0, 0.1], [0.1, 0.2, 1.0]];
    for columns in [CUBES, bricks, sheared] {
        let ball = volume([100, 90, 72], columns, |place, _| (30.0 - length(place)) as f32);
        for contour in spectrum(&ball, [0.0, 20.0], 16) {
            let radius = 30.0 - contour.iso;
            assert_near(contour.area, 4.0 * PI * radius * radius, 3e-3, "area");
            assert_near(contour.volume, 4.0 / 3.0 * PI * radius.powi(3), 4e-3, "volume");
            assert_near(contour.mean_gradient().unwrap(), 1.0, 2e-3, "gradient");
        }
    }
}

#[test]
fn a_torus_has_the_area_the_volume_and_the_gradient_of_a_torus() {
    let torus = volume([112, 112, 48], CUBES, |[x, y, z], _| {
        5.0 * (18.0 - length([(x * x + y * y).sqrt() - 35.0, z, 0.0]))
    });
    for contour in spectrum(&torus, [0.0, 50.0], 20) {
        let radius = 18.0 - contour.iso / 5.0;
        assert_near(contour.area, 4.0 * PI * PI * 35.0 * radius, 4e-3, "area");
        assert_near(contour.volume, 2.0 * PI * PI * 35.0 * radius * radius, 8e-3, "volume");
        assert_near(contour.mean_gradient().unwrap(), 5.0, 2e-3, "gradient");
    }
}

/// Numbers from a generator with a fixed beginning.
fn noise() -> impl FnMut() -> u64 {
    let mut state = 5_u64;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        state >> 33
    }
}

#[test]
fn the_total_gradient_is_the_sum_of_the_laplacian_inside_in_noise_with_ties_too() {
    let mut next = noise();
    let [nx, ny, nz] = [9_usize, 8, 7];
    let samples: Vec<i16> = (0..nx * ny * nz).map(|_| (next() % 5) as i16 - 2).collect();
    // Around it is a shell of the least value, so that all surfaces are closed.
    let at = |place: [usize; 3]| {
        let is_within = place.iter().zip([nx, ny, nz]).all(|(&i, n)| (1..=n).contains(&i));
        let [i, j, k] = place.map(|i| i.wrapping_sub(1));
        if is_within { samples[i + nx * (j + ny * k)] } else { -2 }
    };
    let closed = volume([11, 10, 9], CUBES, |_, ijk| at(ijk.map(|i| i as usize)));
    let laplacian = |[i, j, k]: [usize; 3]| {
        let mut around = 0;
        for axis in 0..3 {
            for step in [-1_isize, 1] {
                let mut there = [i, j, k];
                there[axis] = there[axis].wrapping_add_signed(step);
                around += i64::from(at(there)) - i64::from(at([i, j, k]));
            }
        }
        around
    };
    for contour in spectrum(&closed, [-2.5, 2.5], 10) {
        let (mut inside, mut sum, mut crossings) = (0, 0, 0);
        for n in 0..nx * ny * nz {
            let place = [n % nx + 1, n / nx % ny + 1, n / nx / ny + 1];
            let is_inside = |place| f64::from(at(place)) >= contour.iso;
            if is_inside(place) {
                inside += 1;
                sum -= laplacian(place);
                for axis in 0..3 {
                    let [mut low, mut high] = [place; 2];
                    (low[axis], high[axis]) = (low[axis] - 1, high[axis] + 1);
                    crossings += u64::from(!is_inside(low)) + u64::from(!is_inside(high));
                }
            }
        }
        if contour.iso > -2.0 {
            assert_eq!(contour.volume, f64::from(inside), "{}", contour.iso);
            assert_eq!(contour.crossings, crossings, "{}", contour.iso);
            assert!((contour.total_gradient - sum as f64).abs() < 1e-9, "{}", contour.iso);
        }
    }
}

#[test]
fn any_number_of_threads_finds_the_same_numbers() {
    let mut next = noise();
    let samples: Vec<u64> = (0..40 * 30 * 70).map(|_| next()).collect();
    let noisy = volume([40, 30, 70], CUBES, |_, [i, j, k]| {
        (samples[(i + 40 * (j + 30 * k)) as usize] % 1000) as f32 / 7.0
    });
    let of = |threads: usize| {
        let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
        let levels = Levels::between([0.0, 143.0], 200).unwrap();
        let job = Job { threads, ..Job::default() };
        ContourSpectrum::of(&noisy.view(), levels, &job).unwrap()
    };
    let one = of(1);
    assert!(one.contours().iter().all(|contour| contour.area > 0.0));
    assert_eq!([of(2), of(7)], [one.clone(), one]);
}

/// Of noise and of a smooth field, as bytes and as the same numbers in floats.
#[test]
fn samples_of_one_byte_have_the_crossings_the_volume_and_the_total_gradient_of_the_same_numbers() {
    let bricks = [[0.8, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.25]];
    let sheared = [[0.9, 0.2, 0.0], [-0.1, 1.0, 0.1], [0.1, 0.2, 1.0]];
    for (dims, columns) in [
        ([50, 41, 70], CUBES),
        ([50, 41, 70], bricks),
        ([30, 20, 10], sheared),
        ([32, 1, 9], CUBES),
        ([1, 64, 2], bricks),
        ([97, 3, 1], CUBES),
        ([257, 65, 66], CUBES), // two parts along y and along z
    ] {
        let mut next = noise();
        let all: Vec<u8> = (0..dims.iter().product::<u64>()).map(|_| (next() % 9) as u8).collect();
        let at = |[i, j, k]: [u64; 3]| all[(i + dims[0] * (j + dims[1] * k)) as usize];
        let smooth = |place: [f64; 3]| (140.0 - 4.0 * length(place)).max(9.0) as u8;
        type Of<'a> = &'a dyn Fn([f64; 3], [u64; 3]) -> u8;
        let chance: Of<'_> = &|_, ijk| at(ijk);
        let ball: Of<'_> = &|place, _| smooth(place);
        for of in [chance, ball] {
            let scaling = Scaling::new(-0.5, 3.0).unwrap();
            let bytes = volume(dims, columns, of);
            let signed = volume(dims, columns, |place, ijk| (of(place, ijk) ^ 128).cast_signed());
            let floats = volume(dims, columns, |place, ijk| f32::from(of(place, ijk)));
            let lower = signed.clone().with_scaling(Scaling::new(1.0, 128.0).unwrap());
            for (found, exact) in [
                (spectrum(&bytes, [0.0, 140.0], 140), spectrum(&floats, [0.0, 140.0], 140)),
                (spectrum(&lower, [0.0, 140.0], 33), spectrum(&floats, [0.0, 140.0], 33)),
                (
                    spectrum(&bytes.clone().with_scaling(scaling), [-67.0, 3.0], 70),
                    spectrum(&floats.clone().with_scaling(scaling), [-67.0, 3.0], 70),
                ),
            ] {
                for (found, exact) in found.iter().zip(&exact) {
                    assert_eq!((found.iso, found.crossings), (exact.iso, exact.crossings));
                    assert!((found.volume - exact.volume).abs() <= 1e-9 * exact.volume);
                    let flux = [found.total_gradient, exact.total_gradient];
                    assert!((flux[0] - flux[1]).abs() <= 1e-9 * (1.0 + flux[1]), "{flux:?}");
                }
            }
        }
    }
}

#[test]
fn any_number_of_threads_finds_the_same_of_bytes() {
    let mut next = noise();
    let samples: Vec<u8> = (0..70 * 50 * 130).map(|_| (next() % 200) as u8).collect();
    let noisy =
        volume([70, 50, 130], CUBES, |_, [i, j, k]| samples[(i + 70 * (j + 50 * k)) as usize]);
    let of = |threads: usize| {
        let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
        let levels = Levels::between([0.0, 199.0], 199).unwrap();
        let job = Job { threads, ..Job::default() };
        ContourSpectrum::of(&noisy.view(), levels, &job).unwrap()
    };
    assert_eq!([of(2), of(5)], [of(1), of(1)]);
}

/// By how much the mean gradient of rounded samples is too great, as a share: the square of a rise that was rounded is
/// greater by a sixth on average.
fn rounding_of_gradients(columns: [[f64; 3]; 3], slope: f64) -> f64 {
    let sixths = columns.map(|step| 1.0 / (6.0 * (slope * length(step)).powi(2)));
    sixths.iter().sum()
}

#[test]
fn balls_of_bytes_are_balls_though_their_samples_are_rounded() {
    let bricks = [[0.8, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.25]];
    for columns in [CUBES, bricks] {
        let ball = volume([100, 90, 72], columns, |place, _| {
            // Cut off two samples and more from the surfaces.
            (255.0 - 8.0 * length(place)).round().max(0.0) as u8
        });
        // Between whole numbers: at one, all that was rounded up to it would be inside.
        for contour in spectrum(&ball, [15.5, 175.5], 16) {
            let radius = (255.0 - contour.iso) / 8.0;
            assert_near(contour.area, 4.0 * PI * radius * radius, 6e-3, "area");
            assert_near(contour.volume, 4.0 / 3.0 * PI * radius.powi(3), 8e-3, "volume");
            let gradient = 8.0 * (1.0 + rounding_of_gradients(columns, 8.0));
            assert_near(contour.mean_gradient().unwrap(), gradient, 5e-3, "gradient");
        }
    }
}

#[test]
fn a_torus_of_bytes_is_a_torus_though_its_samples_are_rounded() {
    let torus = volume([112, 112, 48], CUBES, |[x, y, z], _| {
        let depth = 20.0 - length([(x * x + y * y).sqrt() - 35.0, z, 0.0]);
        (12.0 * depth).round().max(0.0) as u8
    });
    for contour in spectrum(&torus, [24.5, 144.5], 20) {
        let radius = 20.0 - contour.iso / 12.0;
        assert_near(contour.area, 4.0 * PI * PI * 35.0 * radius, 4e-3, "area");
        assert_near(contour.volume, 2.0 * PI * PI * 35.0 * radius * radius, 6e-3, "volume");
        let gradient = 12.0 * (1.0 + rounding_of_gradients(CUBES, 12.0));
        assert_near(contour.mean_gradient().unwrap(), gradient, 2e-3, "gradient");
    }
}

#[test]
fn what_is_not_finite_has_no_surface_beside_it_and_is_inside_only_if_it_is_greater() {
    let volume = volume([3, 3, 3], CUBES, |_, ijk| match ijk {
        [1, 1, 1] => f64::NAN,
        [0, 0, 0] => f64::INFINITY,
        [2, 2, 2] => f64::NEG_INFINITY,
        _ => 1.0,
    });
    for contour in spectrum(&volume, [0.0, 2.0], 2) {
        let inside = if contour.iso < 1.0 { 25.0 } else { 1.0 };
        let found = (contour.area, contour.total_gradient, contour.volume, contour.crossings);
        assert_eq!(found, (0.0, 0.0, inside, 0), "{}", contour.iso);
        assert_eq!(contour.mean_gradient(), None);
    }
}

#[test]
fn a_row_of_samples_has_crossings_and_values_of_its_own() {
    let row = volume([4, 1, 1], CUBES, |_, [i, ..]| [0_u8, 4, 4, 1][i as usize]);
    let contours = spectrum(&row, [0.0, 4.0], 2);
    assert_eq!(contours[0].crossings, 1);
    assert_eq!([contours[1].crossings, contours[1].volume as u64], [2, 2]);
    assert_eq!(contours[1].total_gradient, 7.0);
}
