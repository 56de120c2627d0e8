//! Every level against the portable one, whose bits `marching-cubes` compares with those of one at a time.

use super::{Curve, Gradient, OneByOne, Vertices, curved_vertices_at};
use crate::{
    Edges, Lane, Level, Samples,
    vertices::{
        Field,
        tests::{Chance, FIELD, edges},
    },
};

mod continued;

/// So near to the origin that what f32 rounds of a place is little.
const SCALED: Field = Field { origin: [0.0; 3], first_slice: 0.0, ..FIELD };

/// Values are the samples as they are stored, and the isovalue is an f32.
const STORED: Field = Field { slope: 1.0, intercept: 0.0, iso: 100.5, ..SCALED };

/// Edges at a time, and how many samples they are away from the border, if the lattice has such.
const COUNTS: [(usize, u32); 9] =
    [(0, 1), (1, 0), (15, 0), (16, 1), (17, 0), (100, 1), (200, 1), (600, 1), (200, 2)];

/// Tells lines by a function, and of normals from where it was asked for one.
struct Told<F>(F);

impl<F: Fn(usize, &mut [f64]) -> bool> OneByOne for Told<F> {
    fn line(&self, edge: usize, values: &mut [f64]) -> bool {
        self.0(edge, values)
    }

    fn normal(&self, edge: usize, delta: f64) -> [f32; 3] {
        [edge as f32, delta as f32, 2.0]
    }
}

/// For each edge the bits of its place in both types and of its normal, but for odd ones; and their numbers, of f64 first.
type Placed = (Vec<Vec<u64>>, [Vec<u32>; 2]);

/// How far apart places in both types may be: what f32 leaves of a root, on the longest column, and what it rounds.
fn may_be_apart(place: f64) -> f64 {
    1.4 / f64::from(1 << 18) + place.abs() * f64::from(f32::EPSILON)
}

fn placed<T: Lane>(
    level: Level,
    samples: &Samples<'_, T>,
    field: &Field,
    made: (Curve, Gradient),
    edges: &Edges,
) -> Placed {
    let count = edges.len();
    let (mut positions, mut rounded) = (vec![[0.0_f64; 3]; count], vec![[0.0_f32; 3]; count]);
    let (mut normals, mut odd) = (vec![[0.0; 3]; count], [vec![], vec![]]);
    let (samples, told) = ((samples, field), Told(|_, _: &mut [f64]| false));
    let out = Vertices { positions: &mut rounded, normals: None, odd: &mut odd[1] };
    curved_vertices_at(level, samples, made, edges, &told, out);
    let out = Vertices { positions: &mut positions, normals: Some(&mut normals), odd: &mut odd[0] };
    curved_vertices_at(level, samples, made, edges, &told, out);
    let bits = |n: usize| {
        let [is_odd, is_odd_rounded] = odd.each_ref().map(|odd| odd.contains(&(n as u32)));
        let mut bits = vec![];
        if !is_odd {
            bits.extend(positions[n].map(f64::to_bits));
            bits.extend(normals[n].map(|c| u64::from(c.to_bits())));
        }
        if !is_odd_rounded {
            bits.extend(rounded[n].map(|c| u64::from(c.to_bits())));
        }
        if !(is_odd || is_odd_rounded) {
            for (exact, rounded) in positions[n].into_iter().zip(rounded[n]) {
                let apart = (exact - f64::from(rounded)).abs();
                assert!(apart <= may_be_apart(exact), "{exact}, {rounded}");
            }
        }
        bits
    };
    ((0..count).map(bits).collect(), odd)
}

/// Whether an edge is in the lattice, and on its line as many samples as the curve goes through, of which the nearest
/// are not so near to the end of memory that four bytes cannot be read from them on.
fn has_line<T: Lane>(
    samples: &Samples<'_, T>,
    (axis, low): (usize, [u32; 3]),
    on_line: u32,
) -> bool {
    let (dims, strides) = (samples.dims(), samples.strides());
    let is_within = |k: usize| low[k] < dims[k] && low[k] + u32::from(k == axis) < dims[k];
    if !(0..3).all(is_within) || dims[axis] < on_line {
        return false;
    }
    let first = (low[axis] + 1).saturating_sub(on_line / 2).min(dims[axis] - on_line);
    [first, first + on_line - 1].into_iter().all(|end| {
        let along = |k: usize| i64::from(if k == axis { end } else { low[k] }) * strides[k];
        let number = samples.first() + along(0) + along(1) + along(2);
        number as usize * size_of::<T>() + 4 <= size_of_val(samples.all())
    })
}

/// The share of edges with a line that are placed, on the curve where fewer are.
fn check<T: Lane>(sample: fn(&mut Chance) -> T) -> f64 {
    check_one(sample, Curve::Cubic, 4).min(check_one(sample, Curve::Quintic, 6))
}

fn check_one<T: Lane>(sample: fn(&mut Chance) -> T, curve: Curve, on_line: u32) -> f64 {
    let (mut chance, mut far, mut lines, mut kept) = (Chance(5), Chance(6), 0, 0);
    for dims in [[15, 13, 14], [8, 8, 8], [12, 12, 12], [7, 6, 8], [3, 4, 5], [1, 9, 9]] {
        let count = dims.iter().product::<u32>() as usize;
        let all: Vec<T> = (0..count).map(|_| sample(&mut chance)).collect();
        let [nx, ny, nz] = dims.map(|n| n as usize);
        let usual = [1, nx as isize, (nx * ny) as isize];
        let slowest_first = [(ny * nz) as isize, nz as isize, 1];
        let (rows_back, slices_first) =
            ([1, -usual[1], usual[2]], [1, (nx * nz) as isize, usual[1]]);
        let layouts = [
            (0, usual),
            (count - 1, usual.map(|step| -step)),
            (0, slowest_first),
            (nx * (ny - 1), rows_back),
            (0, slices_first),
        ];
        for (first, strides) in layouts {
            let samples = Samples::new(&all, first, strides, [nx, ny, nz]).unwrap();
            for (count, margin) in COUNTS {
                let chance = if margin == 2 { &mut far } else { &mut chance };
                let is_far = margin > 0 && dims.iter().all(|&n| n > 2 * margin + 1);
                let mut place = |n: u32| match is_far {
                    true => margin + chance.below(n - 2 * margin - 1),
                    false => chance.below(n + 1).wrapping_sub(1),
                };
                let z = place(dims[2]);
                let places: Vec<_> = (0..count).map(|_| [place(dims[0]), place(dims[1])]).collect();
                let list: Vec<_> =
                    places.into_iter().map(|place| (chance.below(3) as usize, place)).collect();
                let edges = edges(Level::Portable, &list, z);
                let ways = [
                    (SCALED, Gradient::Central),
                    (SCALED, Gradient::Matching),
                    (STORED, Gradient::Central),
                ];
                let [odd, same, of_stored] = ways.map(|(field, gradient)| {
                    let made = (curve, gradient);
                    let expected = placed(Level::Portable, &samples, &field, made, &edges);
                    for &level in Level::available() {
                        let found = placed(level, &samples, &field, made, &edges);
                        assert!(found == expected, "{level}, {made:?}: {list:?}");
                    }
                    expected.1
                });
                assert_eq!(odd, same);
                let odd = [odd, of_stored].concat();
                for n in 0..edges.len() {
                    let is_odd = odd.iter().any(|odd| odd.contains(&(n as u32)));
                    let has_line = has_line(&samples, edges.get(n), on_line);
                    let are_odd = odd.iter().all(|odd| odd.contains(&(n as u32)));
                    assert!(has_line || are_odd, "{:?} has no line", edges.get(n));
                    // The share is of those that may be near the border too.
                    lines += usize::from(has_line && margin < 2);
                    kept += usize::from(!is_odd && margin < 2);
                }
            }
        }
    }
    assert!(lines > 2000, "{lines} lines");
    kept as f64 / lines as f64
}

#[test]
fn every_level_places_the_same_vertices_on_curves_and_nearly_all() {
    let kept = [
        check(|chance| chance.next() as u8),
        check(|chance| chance.next() as i8),
        check(|chance| chance.next() as u16),
        check(|chance| chance.next() as i16),
        check(|chance| chance.next() as u32),
        check(|chance| chance.next() as i32),
        check(|chance| chance.below(1 << 20) as f32 * 0.01),
        check(|chance| f64::from(chance.below(1 << 20)) * 0.01),
    ];
    assert!(kept.iter().all(|&kept| kept > 0.95), "{kept:?}");
}

#[test]
fn what_is_not_finite_is_odd_at_every_level() {
    let kept = [
        check(|chance| match chance.below(60) {
            0 => [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][chance.below(3) as usize],
            n => n as f32 * 0.3,
        }),
        check(|chance| match chance.below(60) {
            0 => [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][chance.below(3) as usize],
            n => f64::from(n) * 0.3,
        }),
        check(|chance| match chance.below(60) {
            0 => [f64::MAX, -f64::MAX][chance.below(2) as usize],
            n => f64::from(n) * 0.3,
        }),
    ];
    assert!(kept.iter().all(|&kept| kept > 0.5 && kept < 0.99), "{kept:?}");
}

#[test]
fn edges_of_a_lattice_whose_slices_are_any_number_apart_are_left_to_the_caller() {
    let all: Vec<i16> = (0..132).collect();
    let list: Vec<_> = (0..132).map(|n| (n as usize % 3, [n % 12, n / 12])).collect();
    let all_odd: Vec<u32> = (0..132).collect();
    // A lattice of one slice; edges from the guard below it as well.
    for (z, apart) in [(0, isize::MAX), (0, isize::MIN), (u32::MAX, isize::MAX)] {
        let samples = Samples::new(&all, 0, [1, 12, apart], [12, 11, 1]).unwrap();
        let edges = edges(Level::Portable, &list, z);
        for gradient in [Gradient::Central, Gradient::Matching] {
            for &level in Level::available() {
                let made = (Curve::Quintic, gradient);
                let (_, odd) = placed(level, &samples, &SCALED, made, &edges);
                assert_eq!(
                    odd,
                    [&all_odd, &all_odd].map(Clone::clone),
                    "{level}, {gradient:?}, {z}, {apart}"
                );
            }
        }
    }
}

#[test]
fn matching_normals_are_made_from_samples_whose_numbers_take_more_than_31_bits_too() {
    // Rows so far apart; what is between is never written.
    let (dims, apart) = ([8_usize; 3], 450_000_000_usize);
    let (mut near, mut far) = (vec![0_u8; 512], vec![0_u8; 7 * apart + 64]);
    let mut chance = Chance(12);
    for n in 0..512 {
        near[n] = chance.next() as u8;
        far[n % 8 + n / 64 * 8 + n / 8 % 8 * apart] = near[n];
    }
    let list: Vec<_> = (0..147).map(|n| (n as usize % 3, [n / 3 % 7, n / 21])).collect();
    let edges = edges(Level::Portable, &list, 3);
    let told = Told(|n: usize, values: &mut [f64]| {
        let (axis, low) = edges.get(n);
        let step = [1, 8, 64][axis];
        let first = low[0] as usize + low[1] as usize * 8 + low[2] as usize * 64;
        let is_whole = low[axis] >= 2 && low[axis] < 5;
        for (k, value) in values.iter_mut().enumerate().filter(|_| is_whole) {
            let sample = near[first + k * step - 2 * step];
            *value = f64::from(sample) * FIELD.slope + FIELD.intercept - FIELD.iso;
        }
        is_whole
    });
    for &level in Level::available() {
        let [expected, found] = [
            Samples::new(&near, 0, [1, 8, 64], dims).unwrap(),
            Samples::new(&far, 0, [1, apart as isize, 8], dims).unwrap(),
        ]
        .map(|samples| {
            let (mut positions, mut normals) = (vec![[0.0_f32; 3]; 147], vec![[0.0_f32; 3]; 147]);
            let (mut odd, made) = (vec![], (Curve::Quintic, Gradient::Matching));
            let out =
                Vertices { positions: &mut positions, normals: Some(&mut normals), odd: &mut odd };
            curved_vertices_at(level, (&samples, &FIELD), made, &edges, &told, out);
            (positions, normals, odd)
        });
        let mut made = 0;
        for n in (0..147).filter(|n| !found.2.contains(n)).map(|n| n as usize) {
            assert_eq!(found.0[n], expected.0[n], "{level}: edge {n}");
            assert_eq!(found.1[n], expected.1[n], "{level}: edge {n}");
            made += usize::from(found.1[n][2] != 2.0);
        }
        assert!(made > 0, "{level}: all normals were told");
    }
}

#[test]
fn normals_whose_slopes_leave_the_lattice_are_those_that_the_caller_tells() {
    let dims = [14_usize, 12, 11];
    let mut chance = Chance(4);
    let all: Vec<u8> = (0..dims.iter().product()).map(|_| chance.next() as u8).collect();
    let samples = Samples::new(&all, 0, [1, 14, 14 * 12], dims).unwrap();
    let mut made = [0; 2];
    for (z, gradient) in
        (0..10).flat_map(|z| [Gradient::Central, Gradient::Matching].map(|gradient| (z, gradient)))
    {
        let mut list = vec![];
        for (axis, y) in (0..3).flat_map(|axis| (0..11).map(move |y| (axis, y))) {
            list.extend((0..13).map(|x| (axis, [x, y])));
        }
        let edges = edges(Level::Portable, &list, z);
        for &level in Level::available() {
            let (mut positions, mut odd) = (vec![[0.0_f32; 3]; list.len()], vec![]);
            let mut normals = vec![[0.0_f32; 3]; list.len()];
            let out =
                Vertices { positions: &mut positions, normals: Some(&mut normals), odd: &mut odd };
            let told = Told(|_, values: &mut [f64]| {
                values.copy_from_slice(&[-1.5, -0.5, 0.5, 1.5]);
                true
            });
            let (told_of, way) = ((&samples, &FIELD), (Curve::Cubic, gradient));
            curved_vertices_at(level, told_of, way, &edges, &told, out);
            for n in (0..list.len()).filter(|&n| !odd.contains(&(n as u32))) {
                let (axis, low) = edges.get(n);
                let is_inner = (0..3).all(|k| {
                    let low = low[k] as usize;
                    low >= 2 && low + usize::from(k == axis) + 2 < dims[k]
                });
                // Central differences have one-sided ones in their place at a border.
                let is_made = is_inner || gradient == Gradient::Central;
                let length: f32 = normals[n].iter().map(|c| c * c).sum();
                let is_told = normals[n][0] == n as f32 && normals[n][2] == 2.0;
                assert!(is_told != is_made, "{level}: {axis}, {low:?}: {:?}", normals[n]);
                assert!(is_told || (length - 1.0).abs() < 1e-6, "{level}: {:?}", normals[n]);
                made[gradient as usize] += usize::from(is_made);
            }
        }
    }
    assert!(made[1] > 1000 && made[0] > made[1], "{made:?} normals");
}
