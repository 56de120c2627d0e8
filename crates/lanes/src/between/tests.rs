//! Every level against one place at a time.

use super::{BENT, Between, Facing, Found, LINES, Lines, SEEN, Table, found::TAME};
use crate::{Lane, Level, Samples, vertices::tests::Chance};

fn mix(a: f32, b: f32, share: f32) -> f32 {
    a + (b - a) * share
}

/// What is at lattice points, interpolated.
fn interpolated(at: impl Fn([i64; 3]) -> f32, [x, y, z]: [f32; 3]) -> f32 {
    let edge = |j, k| mix(at([0, j, k]), at([1, j, k]), x);
    mix(mix(edge(0, 0), edge(1, 0), y), mix(edge(0, 1), edge(1, 1), y), z)
}

/// Places in all cells, on samples, beyond the lattice and nowhere.
pub(super) fn lines(chance: &mut Chance, dims: [usize; 3]) -> (Lines, [f64; LINES]) {
    let mut lines = Lines::default();
    let steps = std::array::from_fn(|_| f64::from(chance.below(400)) / 16.0);
    for (k, size) in dims.into_iter().enumerate() {
        for n in 0..LINES {
            let place = f64::from(chance.below(64 * size as u32 + 128)) / 64.0 - 1.0;
            let place = [place, place, place, place.round(), f64::NAN][chance.below(5) as usize];
            let step = f64::from(chance.below(200)) / 64.0 - 1.5;
            let steps: [f64; LINES] = steps;
            (lines.step[k][n], lines.start[k][n]) = (step, place - steps[n] * step);
        }
    }
    (lines, steps)
}

fn check<T: Lane>(sample: fn(&mut Chance) -> T) {
    let mut chance = Chance(7);
    for dims in [[9, 7, 6], [2, 2, 2], [4, 4, 4], [3, 5, 4], [30, 4, 5]] {
        let count: usize = dims.iter().product();
        let all: Vec<T> = (0..count).map(|_| sample(&mut chance)).collect();
        let [nx, ny, nz] = dims;
        let [x, xy, yz, z] = [nx, nx * ny, ny * nz, nz].map(|n| n as isize);
        for (first, strides) in
            [(0, [1, x, xy]), (count - 1, [-1, -x, -xy]), (0, [yz, z, 1]), (0, [1, 1, 1])]
        {
            let reach = [0, 1, 2].map(|k| ((dims[k] as isize - 1) * strides[k]).max(0));
            let all = &all[..=first.checked_add_signed(reach.iter().sum()).unwrap()];
            let between = Between::new(Samples::new(all, first, strides, dims).unwrap()).unwrap();
            let has_room = strides != [1; 3] && dims.iter().all(|&n| n > 3);
            assert!(!has_room || between.samples.is_near(dims[2] as i64), "{strides:?}");
            let at = |ijk: [i64; 3]| -> f32 {
                let along = |k: usize| ijk[k] as isize * strides[k];
                let number = first.checked_add_signed(along(0) + along(1) + along(2)).unwrap();
                let exact: f64 = all[number].into();
                exact as f32
            };
            for _ in 0..60 {
                let towards = [(); 3]
                    .map(|()| [(); LINES].map(|()| chance.below(2001) as f32 / 1000.0 - 1.0));
                let places = lines(&mut chance, dims);
                compare(&between, at, &places, (chance.next() as u16, towards));
            }
        }
    }
}

/// What is found one by one, in f64 where that changes nothing but rounding.
struct Expected {
    value: f32,
    /// Along x, y, z, where there are samples on all sides.
    gradient: Option<[f32; 3]>,
    /// By how much rounding may change a part of the gradient.
    slack: f32,
}

fn expected(
    at: impl Fn([i64; 3]) -> f32,
    dims: [u32; 3],
    (lines, steps): &(Lines, [f64; LINES]),
    n: usize,
) -> Expected {
    let mut part = [0.0; 3];
    let low: [i64; 3] = std::array::from_fn(|k| {
        let last = f64::from(dims[k]) - 1.0;
        let place = lines.start[k][n] + steps[n] * lines.step[k][n];
        let place = if place > 0.0 { place.min(last) } else { 0.0 };
        let low = place.floor().min(last - 1.0);
        part[k] = (place - low) as f32;
        low as i64
    });
    let moved = |by: [i64; 3]| at([0, 1, 2].map(|k| low[k] + by[k]));
    let value = interpolated(moved, part);
    if !(0..3).all(|k| low[k] >= 1 && low[k] + 2 < i64::from(dims[k])) {
        return Expected { value, gradient: None, slack: 0.0 };
    }
    let gradient = std::array::from_fn(|k| {
        let side = |mut corner: [i64; 3], by: i64| {
            corner[k] += by;
            moved(corner)
        };
        interpolated(|corner| side(corner, 1) - side(corner, -1), part)
    });
    let around = (0..64).map(|n| moved([n & 3, n >> 2 & 3, n >> 4].map(|c| c - 1)).abs());
    let slack = 8.0 * f32::EPSILON * around.fold(0.0, f32::max);
    Expected { value, gradient: Some(gradient), slack }
}

fn compare<T: Lane>(
    between: &Between<'_, T>,
    at: impl Fn([i64; 3]) -> f32,
    places: &(Lines, [f64; LINES]),
    (wanted, towards): (u16, [[f32; LINES]; 3]),
) {
    let (dims, marks) = (between.samples.dims(), [SEEN, BENT, SEEN | BENT, SEEN, 0]);
    let table = Table { slope: -0.5, intercept: 3.0, base: -60.0, scale: 0.03, marks: &marks };
    let covectors = [[0.9, 0.1, 0.0], [-0.1, 0.8, 0.2], [0.3, 0.0, 1.0]];
    let facing = Facing { covectors, towards };
    let look = |level, facing| {
        let mut found = Found::default();
        between.look_at(level, (&places.0, &places.1), wanted, &table, facing, &mut found);
        found
    };
    let plain = look(Level::Portable, Some(&facing));
    for n in (0..LINES).filter(|n| wanted >> n & 1 == 1) {
        let expected = expected(&at, dims, places, n);
        let value = expected.value * table.slope + table.intercept;
        let place = ((value - table.base) * table.scale).max(0.0).min(marks.len() as f32);
        let part = (place as usize).min(marks.len() - 1);
        let is_seen = marks[part] & SEEN != 0 && !value.is_nan();
        assert_eq!((plain.parts[n] as usize, plain.seen >> n & 1 == 1), (part, is_seen));
        let is_bent = is_seen && marks[part] & BENT != 0;
        assert_eq!(plain.bent >> n & 1 == 1, is_bent);
        assert_eq!(plain.shares[n], place - part as f32, "{value}");
        assert!(plain.values[n] == value || plain.values[n].is_nan() && value.is_nan());
        // Of rows that share samples four bytes may not be there.
        let gradient = expected.gradient.filter(|_| between.samples.is_near(dims[2].into()));
        let world = gradient.map(|gradient| {
            [0, 1, 2].map(|k| (0..3).map(|axis| covectors[axis][k] * gradient[axis]).sum::<f32>())
        });
        let square = world.map_or(0.0, |world| world.iter().map(|c| c * c).sum());
        let is_odd = is_seen && !TAME.contains(&square);
        // Where all differences vanish but for rounding, either is right.
        if square > expected.slack * expected.slack || square == 0.0 || square.is_nan() {
            assert_eq!(plain.odd >> n & 1 == 1, is_odd, "{square}");
        }
        if let (Some(world), true) = (world, is_seen && !is_odd) {
            let along: f32 = (0..3).map(|k| world[k] * towards[k][n]).sum();
            let (cosine, off) =
                ((along / square.sqrt()).abs().min(1.0), 4.0 * expected.slack / square.sqrt());
            let found = plain.cosines[n];
            assert!((found - cosine).abs() <= off + 1e-6, "{found} for {cosine}");
            let (found, long) = (plain.slopes[n], square.sqrt());
            assert!((found - long).abs() <= (off + 1e-6) * long, "{found} for {long}");
        }
    }
    for &level in Level::available() {
        let found = look(level, Some(&facing));
        assert_eq!(
            (found.seen, found.bent, found.odd),
            (plain.seen, plain.bent, plain.odd),
            "{level}"
        );
        let dark = look(level, None);
        assert_eq!((dark.seen, dark.odd), (plain.seen, 0), "{level}");
        for n in (0..LINES).filter(|n| wanted >> n & 1 == 1) {
            let bits = |x: f32| if x.is_nan() { u32::MAX } else { x.to_bits() };
            let of = |found: &Found| (bits(found.values[n]), found.parts[n], bits(found.shares[n]));
            assert_eq!([of(&found), of(&dark)], [of(&plain); 2], "{level}");
            if plain.seen & !plain.odd & 1 << n != 0 {
                let of = |found: &Found| [found.cosines[n], found.slopes[n]].map(bits);
                assert_eq!(of(&found), of(&plain), "{level}");
            }
        }
    }
}

#[test]
fn every_level_finds_what_is_between_samples_of_every_type() {
    check::<u8>(|chance| chance.next() as u8);
    check::<i8>(|chance| chance.next() as i8);
    check::<u16>(|chance| chance.next() as u16);
    check::<i16>(|chance| chance.next() as i16);
    check::<u32>(|chance| chance.next() as u32);
    check::<i32>(|chance| chance.next() as i32);
    check::<f32>(|chance| match chance.below(40) {
        0 => f32::NAN,
        _ => chance.below(1000) as f32 / 7.0 - 50.0,
    });
    check::<f64>(|chance| f64::from(chance.below(100_000)) / 7.0 - 50.0);
}

#[test]
fn there_is_nothing_between_samples_in_a_plane() {
    let samples = |dims| Samples::new(&[0_u8; 9], 0, [1, 3, 9], dims).unwrap();
    assert!(Between::new(samples([3, 3, 1])).is_none());
}
