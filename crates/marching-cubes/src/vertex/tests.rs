//! Places and normals on single edges.

use super::{Cut, Placer, delta, greatest};
use crate::{ExtractOptions, Gradient, Placement};
use isokit_geom::{Affine, Frame};
use isokit_lanes::{Edges, Word};
use isokit_volume::{Grid, Volume, gradient};
use proptest::prelude::*;

mod kernels;

fn check(a: f64, b: f64, iso: f64) {
    let (low, high) = if a >= b { (b, a) } else { (a, b) };
    if !(low < iso && high >= iso) {
        return;
    }
    let there = delta([Some(a), Some(b)], iso);
    let back = delta([Some(b), Some(a)], iso);
    assert!(there.abs() <= 0.5, "{a:e}, {b:e}, {iso:e}: {there}");
    assert_eq!(there.to_bits(), (-back).to_bits(), "{a:e}, {b:e}, {iso:e}");
}

proptest! {
    #[test]
    fn a_crossing_is_on_its_edge_and_the_same_from_both_ends(
        bits in any::<[u64; 3]>(), near in -3_i64..=3
    ) {
        let [a, b, iso] = bits.map(f64::from_bits);
        let [a32, b32, iso32] = bits.map(|bits| f64::from(f32::from_bits(bits as u32)));
        if a.is_finite() && b.is_finite() && iso.is_finite() {
            check(a, b, a / 2.0 + b / 2.0);
            check(a, b, iso);
            check(a, f64::from_bits(a.to_bits().wrapping_add_signed(near)), a);
        }
        if a32.is_finite() && b32.is_finite() && iso32.is_finite() {
            check(a32, b32, iso32);
            check(a32, b32, (a32 + b32) / 2.0);
        }
    }
}

#[test]
fn the_greatest_and_the_least_values_are_crossed_where_they_should_be() {
    assert_eq!(delta([Some(-f64::MAX), Some(f64::MAX)], 0.0), 0.0);
    let half = f64::from_bits(0x7FE0_0000_0000_0000); // of what overflows
    assert_eq!(delta([Some(half), Some(-half)], -half / 2.0), 0.25);
    let tiny = f64::from_bits(1);
    assert_eq!(delta([Some(0.0), Some(3.0 * tiny)], tiny), -1.0 / 6.0);
    assert_eq!(delta([Some(1.0), Some(3.0)], 3.0), 0.5);
}

#[test]
fn what_is_not_finite_leaves_the_crossing_to_the_other_end() {
    let (inf, nan) = (f64::INFINITY, f64::NAN);
    assert_eq!(delta([Some(1.0), Some(nan)], 0.0), -0.5);
    assert_eq!(delta([Some(inf), Some(-1.0)], 0.0), 0.5);
    assert_eq!(delta([Some(inf), Some(nan)], 0.0), 0.0);
    assert_eq!(delta([Some(inf), None], 0.0), -0.5);
    assert_eq!(delta([None, Some(1.0)], 0.0), 0.5);
}

fn plane_normals(affine: Affine, slope: [f64; 3]) {
    // A linear field in world space: its normal is −slope, whatever the frame.
    let frame = Frame { index_to_world: affine, ..Frame::default() };
    let grid = Grid::new([4, 4, 4], frame).unwrap();
    let value = |n: usize| {
        let xyz = affine.point([n % 4, n / 4 % 4, n / 16].map(|i| i as f64));
        (0..3).map(|k| xyz[k] * slope[k]).sum::<f64>()
    };
    let volume = Volume::new(grid, (0..64).map(value).collect::<Vec<f64>>()).unwrap();
    let placer = Placer::new(volume.view(), value(0).midpoint(value(1)), 0.0, 0.0);
    let cut = placer.cut(0, [0, 0, 0]);
    let length = slope.iter().map(|c| c * c).sum::<f64>().sqrt();
    for (found, part) in placer.central_normal(&cut).into_iter().zip(slope) {
        assert!((f64::from(found) + part / length).abs() < 1e-6, "{found}, {part}");
    }
}

#[test]
fn normals_are_covectors_in_sheared_stretched_and_mirrored_frames() {
    let slope = [1.0, -2.0, 0.5];
    let shear = [[0.5, 0.0, 0.0], [0.2, 0.7, 0.0], [0.1, -0.9, 2.5]];
    plane_normals(Affine::new(shear, [0.0; 3]).unwrap(), slope);
    plane_normals(Affine::axis_aligned([1.0, 3.0, -9.0], [5.0; 3]).unwrap(), slope);
    plane_normals(Affine::axis_aligned([1e-12, 1.0, 1e6], [0.0; 3]).unwrap(), [1e12, 1.0, 1e-6]);
}

/// Sixteen steps of f32, for gradients at the ends that cancel no more than half.
#[test]
fn normals_made_sixteen_at_a_time_are_right_to_a_few_units_of_their_last_place() {
    let frame = Affine::new([[0.5, 0.1, 0.0], [0.2, 0.7, 0.0], [0.1, -0.9, 2.5]], [0.0; 3]);
    let frame = Frame { index_to_world: frame.unwrap(), ..Frame::default() };
    let grid = Grid::new([20, 20, 20], frame).unwrap();
    let mut state = 9_u64;
    let mut chance = |_| {
        state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
        (state >> 40) as f32 / 1e5 - 80.0
    };
    let volume = Volume::new(grid, (0..8000).map(&mut chance).collect::<Vec<f32>>()).unwrap();
    let placer = Placer::new(volume.view(), 0.0, 0.0, 0.0);
    let mut compared = 0;
    for (axis, y) in (0..3).flat_map(|axis| (0..19).map(move |y| (axis, y))) {
        let mut edges = Edges::default();
        edges.begin(9);
        edges.push(&[axis], [0, y], &[Word { cuts: [(1 << 19) - 1; 8], ..Word::default() }]);
        let (mut positions, mut normals) = ([[0_f32; 3]; 19], [[0.0; 3]; 19]);
        placer.place(&edges, &mut positions, Some(&mut normals), &mut vec![]);
        for (n, normal) in normals.into_iter().enumerate() {
            let (axis, low) = edges.get(n);
            let cut = placer.cut(axis, low);
            assert_eq!(placer.central_normal(&cut), normal, "one by one as all at once");
            let [low, high] = cut.ends.map(|end| gradient(&volume.view(), end.unwrap()));
            let share = 0.5 + cut.delta;
            let mixed = [0, 1, 2].map(|k| low[k] * (1.0 - share) + high[k] * share);
            if greatest(mixed) < 0.5 * greatest(low).max(greatest(high)) {
                continue;
            }
            compared += 1;
            let exact = placer.outward(mixed).unwrap();
            for (found, exact) in normal.into_iter().zip(exact) {
                assert!((found - exact).abs() < 16.0 * f32::EPSILON, "{found}, {exact}");
            }
        }
    }
    assert!(compared > 300, "{compared} normals");
}

/// The sum of all products of powers of x, y and z up to a degree, each with a factor of its own, and its gradient.
fn powers(degree: i32, [x, y, z]: [f64; 3]) -> (f64, [f64; 3]) {
    let (mut value, mut gradient) = (0.0, [0.0; 3]);
    for [a, b, c] in (0..343).map(|n| [n % 7, n / 7 % 7, n / 49]) {
        if a + b + c > degree {
            continue;
        }
        let factor = 1.0 / f64::from(1 + a + 2 * b + 3 * c);
        let power = |x: f64, n: i32| if n < 0 { 0.0 } else { x.powi(n) };
        let product = |a, b, c| factor * power(x, a) * power(y, b) * power(z, c);
        value += product(a, b, c);
        gradient[0] += f64::from(a) * product(a - 1, b, c);
        gradient[1] += f64::from(b) * product(a, b - 1, c);
        gradient[2] += f64::from(c) * product(a, b, c - 1);
    }
    (value, gradient)
}

#[test]
fn normals_on_curves_are_exact_for_polynomials_of_their_degree_up_to_the_border() {
    let size = [8, 9, 10];
    let place = |ijk: [f64; 3]| ijk.map(|i| i / 4.0 - 1.0);
    for (placement, degree) in [(Placement::Cubic, 4), (Placement::Quintic, 6)] {
        let value = |n: usize| {
            let ijk = [n % 8, n / 8 % 9, n / 72].map(|i| i as f64);
            powers(degree, place(ijk)).0
        };
        let grid = Grid::new(size, Frame::default()).unwrap();
        let volume = Volume::new(grid, (0..720).map(value).collect::<Vec<f64>>()).unwrap();
        let options = ExtractOptions::DEFAULT.with_placement(placement);
        let placer = Placer::new(volume.view(), 0.0, 0.0, 0.0)
            .with_options(&options.with_gradient(Gradient::Matching));
        for (axis, n) in (0..3).flat_map(|axis| (0..720).map(move |n| (axis, n))) {
            let low = [n % 8, n / 8 % 9, n / 72];
            if low[axis] as u64 + 1 == size[axis] {
                continue;
            }
            for delta in [-0.5, -0.2, 0.0, 0.3] {
                let cut = Cut { delta, ..placer.cut(axis, low) };
                let mut ijk = low.map(f64::from);
                ijk[axis] += 0.5 + delta;
                let exact = placer.outward(powers(degree, place(ijk)).1).unwrap();
                for (found, exact) in placer.normal(&cut).into_iter().zip(exact) {
                    assert!((found - exact).abs() < 1e-6, "{placement:?}, {axis}, {low:?}");
                }
            }
        }
    }
}

#[test]
fn next_to_a_sample_without_a_value_the_other_differences_tell_the_normal() {
    let grid = Grid::new([7, 7, 7], Frame::default()).unwrap();
    for hole in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let value = |n: usize| match [n % 7, n / 7 % 7, n / 49] {
            [3, 3, 3] => hole,
            [x, y, z] => 2.0 * x as f32 - y as f32 + 2.0 * z as f32,
        };
        let volume = Volume::new(grid, (0..343).map(value).collect::<Vec<f32>>()).unwrap();
        // Beside the hole, and to it: no vertex there looks along the edge.
        for (axis, low) in [(1, [2, 3, 3]), (0, [3, 4, 3]), (2, [3, 3, 2]), (0, [3, 3, 3])] {
            let placer = Placer::new(volume.view(), 8.5, 0.0, 0.0);
            let normal = placer.central_normal(&placer.cut(axis, low));
            for (found, part) in normal.into_iter().zip([-2.0, 1.0, -2.0]) {
                assert!((found - part / 3.0).abs() < 1e-6, "{hole}, {axis}, {low:?}: {normal:?}");
            }
        }
    }
}

#[test]
fn the_vertices_of_caps_are_those_of_any_edge_to_a_guard() {
    let oblique = Affine::new([[0.5, 0.1, 0.0], [0.2, 0.7, 0.0], [0.1, -0.9, 2.5]], [3.0; 3]);
    let mirrored = Affine::axis_aligned([-1.5, 0.3, 1e3], [0.1, -7.0, 1e6]);
    for index_to_world in [oblique.unwrap(), mirrored.unwrap()] {
        let size = [3, 4, 5];
        let frame = Frame { index_to_world, ..Frame::default() };
        let grid = Grid::new(size, frame).unwrap();
        let volume = Volume::new(grid, (1..=60).collect::<Vec<u8>>()).unwrap();
        for (margin, first_slice) in [(0.0, 0.0), (2_f64.powi(-10), 7.0)] {
            let placer = Placer::new(volume.view(), 0.5, margin, first_slice);
            for axis in 0..3 {
                for low in [u32::MAX, size[axis] as u32 - 1] {
                    let mut place = [1, 2, 1];
                    place[axis] = low;
                    let cut = placer.cut(axis, place);
                    let expected = (placer.position::<f64>(&cut), placer.central_normal(&cut));
                    assert_eq!(placer.cap(axis, place), Some(expected), "{axis}, {low}");
                    place[axis] = 0;
                    assert_eq!(placer.cap::<f64>(axis, place), None, "{axis} is no cap");
                }
            }
        }
    }
}

#[test]
fn where_all_differences_cancel_the_normal_follows_the_edge() {
    let grid = Grid::new([4, 4, 4], Frame::default()).unwrap();
    let checker = |n: usize| if (n + n / 4 + n / 16) % 2 == 1 { -1.0 } else { 1.0 };
    let volume = Volume::new(grid, (0..64).map(checker).collect::<Vec<f32>>()).unwrap();
    let placer = Placer::new(volume.view(), 0.0, 0.0, 0.0);
    assert_eq!(placer.central_normal(&placer.cut(1, [1, 1, 1])), [0.0, -1.0, 0.0]);
    assert_eq!(placer.central_normal(&placer.cut(1, [2, 1, 1])), [0.0, 1.0, 0.0]);
}
