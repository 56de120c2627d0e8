//! Lines that leave the lattice.

use super::{Told, curved_vertices_at};
use crate::{
    Edges, Level, Samples,
    vertices::{
        Field, Vertices,
        curves::{Curve, Gradient, ONE_BEFORE},
        tests::{Chance, FIELD, edges},
    },
};

const UNIT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

#[test]
fn lines_that_leave_the_lattice_are_continued_and_those_too_short_for_that_are_told() {
    leave_the_lattice(Curve::Cubic);
    leave_the_lattice(Curve::Quintic);
}

/// Edges of a lattice whose lines along z are too short, and the same ones in a larger lattice, where nothing is missing.
fn leave_the_lattice(curve: Curve) {
    let (dims, beyond) = ([9_usize, 8, 3], curve.pairs() - 1);
    let held = 2 * curve.pairs();
    let mut chance = Chance(2);
    let all: Vec<i32> = (0..216).map(|_| chance.below(200) as i32 - 100).collect();
    let samples = Samples::new(&all, 0, [1, 9, 72], dims).unwrap();
    // The samples on each line, and what continues them; whole numbers, of which no digit is lost.
    let sizes = dims.map(|n| n + 2 * beyond);
    let strides = [1, sizes[0], sizes[0] * sizes[1]];
    let mut larger = vec![0; strides[2] * sizes[2]];
    let at = |ijk: [usize; 3]| (0..3).map(|k| (ijk[k] + beyond) * strides[k]).sum::<usize>();
    for (n, &sample) in all.iter().enumerate() {
        larger[at([n % 9, n / 9 % 8, n / 72])] = sample;
    }
    for axis in 0..3 {
        let lines = (0..216).map(|n| [n % 9, n / 9 % 8, n / 72]).filter(|ijk| ijk[axis] == 0);
        for first in lines.map(at) {
            let (size, step) = (dims[axis], strides[axis]);
            let count = held.min(size);
            let factors: Vec<i32> = ONE_BEFORE[count][..count].iter().map(|&f| f as i32).collect();
            for n in 1..=beyond {
                let last = first + (size - 1) * step;
                let sum = |place: &dyn Fn(usize) -> usize| -> i32 {
                    factors.iter().enumerate().map(|(k, factor)| factor * larger[place(k)]).sum()
                };
                let low = sum(&|k| first + (k + 1) * step - n * step);
                let high = sum(&|k| last + n * step - (k + 1) * step);
                (larger[first - n * step], larger[last + n * step]) = (low, high);
            }
        }
    }
    let around = Samples::new(&larger, 0, strides.map(|n| n as isize), sizes).unwrap();
    for z in 0..2 {
        let mut list = vec![];
        for (axis, y) in (0..3).flat_map(|axis| (0..7).map(move |y| (axis, y))) {
            list.extend((0..8).map(|x| (axis, [x, y])));
        }
        let inside = edges(Level::Portable, &list, z);
        let (by, more) = (beyond as u32, beyond as f64);
        let moved: Vec<_> = list.iter().map(|&(axis, [x, y])| (axis, [x + by, y + by])).collect();
        let moved = edges(Level::Portable, &moved, z + by);
        let told = Told(|n: usize, values: &mut [f64]| {
            let (axis, low) = moved.get(n);
            assert!(dims[axis] < held, "lines of {} samples are continued", dims[axis]);
            let low: usize = (0..3).map(|k| low[k] as usize * strides[k]).sum();
            for (k, to) in values.iter_mut().enumerate() {
                let sample = larger[low + k * strides[axis] - beyond * strides[axis]];
                *to = f64::from(sample) * FIELD.slope + FIELD.intercept - FIELD.iso;
            }
            true
        });
        for &level in Level::available() {
            let place = |samples, edges: &Edges, field| {
                let (mut positions, mut odd) = (vec![[0.0_f32; 3]; list.len()], vec![]);
                let out = Vertices { positions: &mut positions, normals: None, odd: &mut odd };
                let made = (curve, Gradient::Matching);
                curved_vertices_at(level, (samples, field), made, edges, &told, out);
                odd.iter().for_each(|&n| positions[n as usize] = [0.0; 3]);
                (positions, odd)
            };
            // So many steps back along each axis, which whole numbers let one see to the last bit.
            let index = Field { columns: UNIT, origin: [0.0; 3], first_slice: 0.0, ..FIELD };
            let back = Field { origin: [-more; 3], ..index };
            let found = place(&samples, &inside, &index);
            assert_eq!(found, place(&around, &moved, &back), "{level}, {curve:?}");
            assert!(found.1.len() < list.len() / 2, "{} are odd", found.1.len());
        }
    }
}

#[test]
fn lines_are_continued_only_where_no_sample_is_so_far_away_that_its_number_wraps() {
    // Slices so far apart that numbers of samples fit for two, not for three; what is between is never written.
    let (dims, apart) = ([4_usize; 3], 800_000_000_usize);
    let mut all = vec![0_u8; 3 * apart + 16];
    let mut chance = Chance(9);
    for n in 0..64 {
        all[n % 16 + n / 16 * apart] = chance.next() as u8;
    }
    let samples = Samples::new(&all, 0, [1, 4, apart as isize], dims).unwrap();
    assert!(samples.is_near(2) && !samples.is_near(3));
    let place = |level, samples: &Samples<'_, u8>, edges: &Edges| {
        let (mut positions, mut odd) = (vec![[0.0_f32; 3]; edges.len()], vec![]);
        let out = Vertices { positions: &mut positions, normals: None, odd: &mut odd };
        let (told, made) = (Told(|_, _: &mut [f64]| false), (Curve::Cubic, Gradient::Central));
        curved_vertices_at(level, (samples, &FIELD), made, edges, &told, out);
        (positions, odd)
    };
    for z in 0..3 {
        let list: Vec<_> = (0..16).map(|n| (2, [n % 4, n / 4])).collect();
        let edges = edges(Level::Portable, &list, z);
        for &level in Level::available() {
            let odd = place(level, &samples, &edges).1;
            assert!(if z == 1 { odd.len() < 4 } else { odd.len() == 16 }, "{level}: {odd:?}");
        }
    }
    // Far from the border along all axes, as no batch is above.
    let near: Vec<u8> = (0..64).map(|n| all[n % 16 + n / 16 * apart]).collect();
    let near = Samples::new(&near, 0, [1, 4, 16], dims).unwrap();
    let list: Vec<_> = (0..32).map(|n| (2, [1 + n % 2, 1 + n / 2 % 2])).collect();
    let inner = edges(Level::Portable, &list, 1);
    for &level in Level::available() {
        let found = place(level, &samples, &inner);
        assert_eq!(found, place(level, &near, &inner), "{level}");
        assert!(found.1.len() < 32, "{level}: all are odd");
    }
}
