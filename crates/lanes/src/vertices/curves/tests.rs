//! Every level against the portable one, whose bits `marching-cubes` compares with those of one at a time.

use super::{Crossings, cubic_crossings_at};
use crate::{
    Edges, Lane, Level, Samples,
    vertices::tests::{Chance, FIELD, edges},
};

/// For each edge the bits of its place, of the same rounded, and from the middle of the edge, but for odd ones;
/// and their numbers.
type Placed = (Vec<Vec<u64>>, Vec<u32>);

fn placed<T: Lane>(level: Level, samples: &Samples<'_, T>, edges: &Edges) -> Placed {
    let count = edges.len();
    let (mut positions, mut rounded) = (vec![[0.0_f64; 3]; count], vec![[0.0_f32; 3]; count]);
    let (mut deltas, mut odd, mut same) = (vec![0.0; count], vec![], vec![]);
    let out = Crossings { positions: &mut rounded, deltas: None, odd: &mut same };
    cubic_crossings_at(level, samples, &FIELD, edges, out);
    let out = Crossings { positions: &mut positions, deltas: Some(&mut deltas), odd: &mut odd };
    cubic_crossings_at(level, samples, &FIELD, edges, out);
    assert_eq!(odd, same);
    let bits = |n: usize| {
        let mut bits = vec![];
        if !odd.contains(&(n as u32)) {
            assert_eq!(positions[n].map(|c| c as f32), rounded[n]);
            bits.extend(positions[n].map(f64::to_bits));
            bits.push(deltas[n].to_bits());
        }
        bits
    };
    ((0..count).map(bits).collect(), odd)
}

/// Whether both ends of an edge have both neighbours along every axis.
fn is_inner(dims: [u32; 3], (axis, low): (usize, [u32; 3])) -> bool {
    (0..3).all(|k| {
        let (low, end) = (i64::from(low[k] as i32), i64::from(k == axis));
        low >= 1 && low + end + 1 < i64::from(dims[k])
    })
}

/// The share of inner edges that are placed.
fn check<T: Lane>(sample: fn(&mut Chance) -> T) -> f64 {
    let (mut chance, mut inner, mut kept) = (Chance(5), 0, 0);
    for dims in [[15, 13, 14], [8, 8, 8], [12, 12, 12], [7, 6, 8], [3, 4, 5], [1, 9, 9]] {
        let count = dims.iter().product::<u32>() as usize;
        let all: Vec<T> = (0..count).map(|_| sample(&mut chance)).collect();
        let [nx, ny, nz] = dims.map(|n| n as usize);
        let usual = [1, nx as isize, (nx * ny) as isize];
        let slowest_first = [(ny * nz) as isize, nz as isize, 1];
        let layouts = [(0, usual), (count - 1, usual.map(|step| -step)), (0, slowest_first)];
        for (first, strides) in layouts {
            let samples = Samples::new(&all, first, strides, [nx, ny, nz]).unwrap();
            for count in [0, 1, 15, 16, 17, 100, 200, 600] {
                // Half of the time all edges are inner ones, if the lattice has such.
                let is_far = count % 2 == 0 && dims.iter().all(|&n| n > 3);
                let mut place = |n: u32| match is_far {
                    true => 1 + chance.below(n - 3),
                    false => chance.below(n + 1).wrapping_sub(1),
                };
                let z = place(dims[2]);
                let places: Vec<_> = (0..count).map(|_| [place(dims[0]), place(dims[1])]).collect();
                let list: Vec<_> =
                    places.into_iter().map(|place| (chance.below(3) as usize, place)).collect();
                let edges = edges(Level::Portable, &list, z);
                let expected = placed(Level::Portable, &samples, &edges);
                for &level in Level::available() {
                    assert!(placed(level, &samples, &edges) == expected, "{level}: {list:?}");
                }
                for n in 0..edges.len() {
                    let is_odd = expected.1.contains(&(n as u32));
                    let is_inner = is_inner(dims, edges.get(n));
                    assert!(is_inner || is_odd, "{:?} is at the border", edges.get(n));
                    inner += usize::from(is_inner);
                    kept += usize::from(!is_odd);
                }
            }
        }
    }
    assert!(inner > 2000, "{inner} inner edges");
    kept as f64 / inner as f64
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
