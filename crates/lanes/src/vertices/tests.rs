//! Every level against one edge at a time, and against what is plain to see.

use super::{BATCH, Edges, Field, Normals, TAME, Vertices, vertices_at};
use crate::{Lane, Level, Samples};

const FIELD: Field = Field {
    iso: 0.5,
    slope: 2.0,
    intercept: -1.0,
    reach: 0.499,
    columns: [[0.9, 0.1, 0.0], [-0.1, 0.8, 0.2], [0.3, 0.0, 1.3]],
    origin: [10.0, -20.0, 0.125],
    first_slice: 40.0,
    covectors: [[1.1, 0.1, -0.2], [0.0, 1.2, 0.1], [0.3, 0.0, 0.8]],
};

struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        self.0 ^ self.0 >> 31
    }

    fn below(&mut self, n: u32) -> u32 {
        (self.next() % u64::from(n)) as u32
    }
}

/// The definition, for one edge. `None` for what the kernel must call odd.
fn one<T: Lane>(
    at: &dyn Fn([u32; 3]) -> T,
    dims: [u32; 3],
    (axis, low): (usize, [u32; 3]),
) -> Option<([f64; 3], [f32; 3])> {
    let mut high = low;
    high[axis] += 1;
    if (0..3).any(|k| high[k] >= dims[k]) {
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
    let gradient = |ijk: [u32; 3]| -> [f64; 3] {
        std::array::from_fn(|k| {
            let moved = |to: u32| {
                let mut there = ijk;
                there[k] = to;
                at(there).into()
            };
            let (below, above) = (ijk[k].saturating_sub(1), (ijk[k] + 1).min(dims[k] - 1));
            let factor = if above - below == 2 { 0.5 } else { 1.0 };
            (moved(above) - moved(below)) * factor * FIELD.slope
        })
    };
    let (g, h) = (gradient(low), gradient(high));
    let share = 0.5 + delta;
    let mixed = std::array::from_fn(|k| g[k] * (1.0 - share) + h[k] * share);
    let world = FIELD.world_gradient(mixed);
    let greatest = world.iter().fold(0.0, |most: f64, part| most.max(part.abs()));
    let finite = (a - b).is_finite() && g.iter().chain(&h).all(|part| part.is_finite());
    if !finite || !TAME.contains(&greatest) {
        return None;
    }
    let outward = -1.0 / (world[0] * world[0] + world[1] * world[1] + world[2] * world[2]).sqrt();
    Some((FIELD.world(ijk), world.map(|part| (part * outward) as f32)))
}

fn check<T: Lane>(sample: fn(&mut Chance) -> T) {
    let mut chance = Chance(11);
    for dims in [[7, 5, 6], [1, 4, 3], [2, 2, 2], [5, 1, 1]] {
        let count = dims.iter().product::<u32>() as usize;
        let all: Vec<T> = (0..count).map(|_| sample(&mut chance)).collect();
        let [nx, ny, nz] = dims.map(|n| n as usize);
        let backwards = [-1, -(nx as isize), -((nx * ny) as isize)];
        let slowest_first = [(ny * nz) as isize, nz as isize, 1];
        for (first, strides) in
            [(0, [1, nx as isize, (nx * ny) as isize]), (count - 1, backwards), (0, slowest_first)]
        {
            let samples = Samples::new(&all, first, strides, [nx, ny, nz]).unwrap();
            let at = |ijk: [u32; 3]| {
                let offset: isize = (0..3).map(|k| ijk[k] as isize * strides[k]).sum();
                all[first.checked_add_signed(offset).unwrap()]
            };
            for count in (1..=BATCH).chain([BATCH; 20]) {
                let mut edges = Edges::default();
                for n in 0..count {
                    let axis = chance.below(3) as usize;
                    let low = dims.map(|n| chance.below(n + 1).wrapping_sub(1));
                    assert_eq!(edges.push(axis, low), n + 1 == BATCH);
                }
                for &level in Level::available() {
                    let mut found = Vertices::<f64>::default();
                    vertices_at(level, &samples, &FIELD, &edges, Normals::Gradient, &mut found);
                    for n in 0..count {
                        let (axis, low) = edges.get(n);
                        let whole = (0..3).all(|k| low[k] < dims[k]);
                        let expected = if whole { one(&at, dims, (axis, low)) } else { None };
                        let is_odd = found.odd >> n & 1 == 1;
                        assert_eq!(is_odd, expected.is_none(), "{level}: {axis}, {low:?}");
                        if let Some((position, normal)) = expected {
                            assert_eq!(found.positions[n], position, "{level}");
                            assert_eq!(found.normals[n], normal, "{level}");
                        }
                    }
                    assert_eq!(found.odd >> count, 0, "no more bits than edges");
                }
            }
        }
    }
}

#[test]
fn every_level_agrees_with_one_edge_at_a_time() {
    check(|chance| chance.next() as u8);
    check(|chance| chance.next() as i8);
    check(|chance| chance.next() as u16);
    check(|chance| chance.next() as i16);
    check(|chance| chance.next() as u32);
    check(|chance| chance.next() as i32);
    check(|chance| chance.below(5) as f32 * 0.25);
    check(|chance| chance.below(1000) as f64 * 1e-3);
}

#[test]
fn what_is_not_finite_is_odd_at_every_level() {
    check(|chance| [f32::NAN, f32::INFINITY, 1.0, 2.0, -3.0, 0.5][chance.below(6) as usize]);
    check(|chance| [f64::MAX, -f64::MAX, 1e-300, 3.0, -2.0][chance.below(5) as usize]);
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
