//! Every level against one edge at a time, and against what is plain to see.

use super::{BLOCK, Edges, Field, TAME, Vertices, vertices_at};
use crate::{Lane, Level, Samples, Word, word::OWN};

pub(super) const FIELD: Field = Field {
    iso: 0.5,
    slope: -2.0,
    intercept: -1.0,
    reach: 0.499,
    columns: [[0.9, 0.1, 0.0], [-0.1, 0.8, 0.2], [0.3, 0.0, 1.3]],
    origin: [10.0, -20.0, 0.125],
    covectors: [[1.1, 0.1, -0.2], [0.0, 1.2, 0.1], [0.3, 0.0, 0.8]],
    first_slice: 1000.0,
};

pub(crate) struct Chance(pub(crate) u64);

impl Chance {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        self.0 ^ self.0 >> 31
    }

    pub(crate) fn below(&mut self, n: u32) -> u32 {
        (self.next() % u64::from(n)) as u32
    }
}

/// How two samples are subtracted: as f32 where that holds them exactly, else as f64, and then rounded.
type Difference = fn(f64, f64) -> f32;

fn as_f32(a: f64, b: f64) -> f32 {
    a as f32 - b as f32
}

fn as_f64(a: f64, b: f64) -> f32 {
    (a - b) as f32
}

/// The definition, for one edge. `None` for what the kernel must call odd.
fn one<T: Lane>(
    at: &dyn Fn([u32; 3]) -> T,
    difference: Difference,
    dims: [u32; 3],
    (axis, low): (usize, [u32; 3]),
) -> Option<([f64; 3], [f32; 3])> {
    let mut high = low;
    high[axis] = high[axis].wrapping_add(1);
    if (0..3).any(|k| low[k] >= dims[k] || high[k] >= dims[k]) {
        return None;
    }
    let value = |ijk| at(ijk).into() * FIELD.slope + FIELD.intercept;
    let (a, b) = (value(low) - FIELD.iso, value(high) - FIELD.iso);
    // No edge is cut between equal values; if one were, it would have some place on it.
    let delta = (a + b) / (a - b) * 0.5;
    let delta = if delta.is_nan() { -FIELD.reach } else { delta.clamp(-FIELD.reach, FIELD.reach) };
    let mut ijk = low.map(f64::from);
    ijk[2] += FIELD.first_slice;
    ijk[axis] = ijk[axis] + 0.5 + delta;
    let gradient = |ijk: [u32; 3]| -> [f32; 3] {
        std::array::from_fn(|k| {
            let moved = |to: u32| {
                let mut there = ijk;
                there[k] = to;
                at(there).into()
            };
            let (below, above) = (ijk[k].saturating_sub(1), (ijk[k] + 1).min(dims[k] - 1));
            let factor = if above - below == 2 { 1.0 } else { 2.0 };
            difference(moved(above), moved(below)) * factor
        })
    };
    let (g, h) = (gradient(low), gradient(high));
    let share = (0.5 + delta) as f32;
    let mixed: [f32; 3] = std::array::from_fn(|k| g[k] * (1.0 - share) + h[k] * share);
    // The greatest part of the covectors is 1.2, and the slope is negative.
    let along = |k: usize, axis: usize| (FIELD.covectors[axis][k] / -1.2) as f32 * mixed[axis];
    let world: [f32; 3] = std::array::from_fn(|k| along(k, 0) + along(k, 1) + along(k, 2));
    let greatest = world.iter().fold(0.0_f32, |most, part| most.max(part.abs()));
    if !(TAME.contains(&greatest) && world.iter().all(|c| c.is_finite()) && (a - b).is_finite()) {
        return None;
    }
    let world = world.map(|part| part / 2.0_f32.powi(greatest.log2().floor() as i32));
    let square = world[0] * world[0] + world[1] * world[1] + world[2] * world[2];
    let outward = -1.0 / square.sqrt();
    Some((FIELD.world(ijk), world.map(|part| part * outward)))
}

/// Edges as a row hands them over, one word each.
pub(super) fn edges(level: Level, list: &[(usize, [u32; 2])], z: u32) -> Edges {
    let mut edges = Edges::default();
    edges.begin(z);
    for &(axis, [x, y]) in list {
        let mut word = Word::default();
        word.cuts[OWN[axis]] = 1;
        assert!(!edges.push_at(level, &[axis], [x, y], &[word]));
    }
    edges
}

fn check<T: Lane>(difference: Difference, sample: fn(&mut Chance) -> T) {
    let mut chance = Chance(11);
    for dims in [[9, 7, 6], [1, 4, 3], [2, 2, 2], [5, 1, 1], [3, 4, 3], [4, 3, 5]] {
        let count = dims.iter().product::<u32>() as usize;
        let all: Vec<T> = (0..count).map(|_| sample(&mut chance)).collect();
        let [nx, ny, nz] = dims.map(|n| n as usize);
        let [x, xy, xz] = [nx, nx * ny, nx * nz].map(|n| n as isize);
        for (first, strides) in [
            (0, [1, x, xy]),
            (count - 1, [-1, -x, -xy]),
            (0, [(ny * nz) as isize, nz as isize, 1]),
            (nx * (ny - 1), [1, -x, xy]),
            (0, [1, xz, x]),
            // Rows that share samples, too near for four in a row, and no room behind the last.
            (0, [1, 1, 1]),
            (0, [1, 2, 1]),
            (0, [1, 0, x]),
        ] {
            let reach = [0, 1, 2].map(|k| ((dims[k] as isize - 1) * strides[k]).max(0));
            let all = &all[..=first.checked_add_signed(reach.iter().sum()).unwrap()];
            let samples = Samples::new(all, first, strides, [nx, ny, nz]).unwrap();
            let at = |ijk: [u32; 3]| {
                let offset: isize = (0..3).map(|k| ijk[k] as isize * strides[k]).sum();
                all[first.checked_add_signed(offset).unwrap()]
            };
            // As many as rows have at the most, once.
            let most = if dims[0] == 9 && strides == [1, x, xy] { 200 } else { 40 };
            for count in (0..=most).chain([64; 10]) {
                // Half of the time all ends have all neighbours, if the lattice has such edges.
                let is_inner = count % 2 == 0 && dims.iter().all(|&n| n > 3);
                let mut place = |n: u32| match is_inner {
                    true => 1 + chance.below(n - 3),
                    false => chance.below(n + 1).wrapping_sub(1),
                };
                let z = place(dims[2]);
                let place = |_| [place(dims[0]), place(dims[1])];
                let places: Vec<[u32; 2]> = (0..count).map(place).collect();
                let list: Vec<_> =
                    places.into_iter().map(|place| (chance.below(3) as usize, place)).collect();
                let mut usual = None;
                for &level in Level::available() {
                    let found = compare(level, &samples, &edges(level, &list, z), |edge| {
                        one(&at, difference, dims, edge)
                    });
                    assert!(*usual.get_or_insert_with(|| found.clone()) == found, "{level}");
                }
            }
        }
    }
}

/// The bits of the vertices of edges that are not odd, and the numbers of those that are.
fn compare<T: Lane>(
    level: Level,
    samples: &Samples<'_, T>,
    edges: &Edges,
    expected: impl Fn((usize, [u32; 3])) -> Option<([f64; 3], [f32; 3])>,
) -> (Vec<u64>, Vec<u32>) {
    let mut bits = vec![];
    let (mut positions, mut normals) = (vec![[0.0; 3]; edges.len()], vec![[0.0; 3]; edges.len()]);
    let (mut rounded, mut odd, mut odd_places) = (vec![[0_f32; 3]; edges.len()], vec![], vec![]);
    let out =
        Vertices { positions: &mut positions, normals: Some(&mut normals[..]), odd: &mut odd };
    vertices_at(level, samples, &FIELD, edges, out);
    let out = Vertices { positions: &mut rounded, normals: None, odd: &mut odd_places };
    vertices_at(level, samples, &FIELD, edges, out);
    for n in 0..edges.len() {
        let edge = edges.get(n);
        match expected(edge) {
            None => assert!(odd.contains(&(n as u32)), "{level}: {edge:?}"),
            Some((position, normal)) => {
                assert!(!odd.contains(&(n as u32)), "{level}: {edge:?}");
                assert_eq!(positions[n], position, "{level}: {edge:?}");
                assert_eq!(rounded[n], position.map(|c| c as f32), "{level}: {edge:?}");
                assert_eq!(normals[n], normal, "{level}: {edge:?}");
                bits.extend(positions[n].map(f64::to_bits));
                let narrow = [rounded[n], normals[n]].into_iter().flatten();
                bits.extend(narrow.map(|c| u64::from(c.to_bits())));
            }
        }
    }
    assert!(odd.is_sorted() && odd.iter().all(|&n| (n as usize) < edges.len()), "{odd:?}");
    assert!(odd_places.iter().all(|n| odd.contains(n)), "{odd_places:?} of {odd:?}");
    (bits, odd)
}

#[test]
fn every_level_agrees_with_one_edge_at_a_time() {
    check(as_f32, |chance| chance.next() as u8);
    check(as_f32, |chance| chance.next() as i8);
    check(as_f32, |chance| chance.next() as u16);
    check(as_f32, |chance| chance.next() as i16);
    check(as_f64, |chance| chance.next() as u32);
    check(as_f64, |chance| chance.next() as i32);
    check(as_f32, |chance| chance.below(5) as f32 * 0.25);
    check(as_f32, |chance| chance.next() as i32 as f32 / (1_u64 << chance.below(40)) as f32);
    check(as_f32, |chance| match chance.below(4) {
        0 => 1.0,
        1 => -0.0,
        _ => f32::from_bits(chance.below(1 << 23) | chance.below(2) << 31),
    });
    check(as_f64, |chance| chance.below(1000) as f64 * 1e-3);
}

#[test]
fn what_is_not_finite_is_odd_at_every_level() {
    check(as_f32, |chance| {
        [f32::NAN, f32::INFINITY, 1.0, 2.0, -3.0, 0.5][chance.below(6) as usize]
    });
    check(as_f32, |chance| [f32::MAX, -f32::MAX, 1e-30, 3.0, -2.0][chance.below(5) as usize]);
    check(as_f64, |chance| [f64::MAX, -f64::MAX, 1e-300, 3.0, -2.0][chance.below(5) as usize]);
}

#[test]
fn edges_come_row_by_row_axis_by_axis_in_the_order_of_their_bits() {
    let mut chance = Chance(3);
    for density in 0..5 {
        let mut word = |n: usize| {
            let cuts =
                std::array::from_fn(|_| (0..density).fold(u64::MAX, |w, _| w & chance.next()));
            Word { cuts, row: n / 4, first: 64 * (n % 4), ..Word::default() }
        };
        let words: Vec<Word> = (0..BLOCK).map(&mut word).collect();
        for (&level, axes) in Level::available()
            .iter()
            .flat_map(|l| [&[0_usize, 1][..], &[2], &[1], &[]].map(|axes| (l, axes)))
        {
            let mut edges = Edges::default();
            edges.begin(7);
            let mut expected = vec![];
            for (row, axis) in
                (0..BLOCK / 4).flat_map(|row| axes.iter().map(move |&axis| (row, axis)))
            {
                for i in 0..256 {
                    if words[4 * row + i / 64].owned()[axis] >> (i % 64) & 1 == 1 {
                        expected.push((axis, [(i as u32).wrapping_sub(1), 5 + row as u32, 7]));
                    }
                }
            }
            let is_full = edges.push_at(level, axes, [u32::MAX, 5], &words);
            let found: Vec<_> = (0..edges.len()).map(|n| edges.get(n)).collect();
            assert_eq!(found, expected, "{level}");
            assert_eq!(is_full, expected.len() >= 1024, "{level}");
        }
    }
}

#[test]
fn a_queue_one_edge_from_full_takes_the_fullest_block() {
    let word = |cuts: u64, n: usize| Word { cuts: [cuts; 8], row: n, ..Word::default() };
    let before: Vec<Word> = (0..16).map(|n| word(u64::MAX >> (n / 15), n)).collect();
    // The block ends with words that cut something, or with words that do not.
    for blank in [0, 1, 5] {
        let cuts = |n: usize| if n + blank < BLOCK { u64::MAX } else { 0 };
        let block: Vec<Word> = (0..BLOCK).map(|n| word(cuts(n), 20 + n)).collect();
        for &level in Level::available() {
            let mut edges = Edges::default();
            assert!(!edges.push_at(level, &[2], [0; 2], &before));
            assert_eq!(edges.len(), 1023);
            assert!(edges.push_at(level, &[0, 1], [0; 2], &block));
            let expected = 1023 + 128 * (BLOCK - blank);
            assert_eq!(edges.len(), expected, "{level}");
            for n in 1023..expected {
                let at = n - 1023;
                let place = [at as u32 % 64, 20 + at as u32 / 128, 0];
                assert_eq!(edges.get(n), (at / 64 % 2, place), "{level}, {n}");
            }
        }
    }
}

#[test]
fn samples_are_refused_that_do_not_fill_their_lattice() {
    let all = [0_u8; 24];
    assert!(Samples::new(&all, 0, [1, 2, 6], [2, 3, 4]).is_some());
    assert!(Samples::new(&all, 1, [1, 2, 6], [2, 3, 4]).is_none());
    assert!(Samples::new(&all, 0, [-1, 2, 6], [2, 3, 4]).is_none());
    assert!(Samples::new(&all, 0, [1, 2, 6], [2, 0, 4]).is_none());
    assert!(Samples::new(&all, 0, [0, 0, 0], [1 << 31, 3, 4]).is_none());
    assert!(Samples::new(&all, 0, [isize::MAX; 3], [1 << 30; 3]).is_none());
}
