//! Trilinear topology against the certified oracle: what the surface connects, cell by cell and as a whole.
//!
//! With `CELLS=1000000`, as `scripts/sweep` has it, so many cells are looked at, a thousandth as many of each class, and a
//! hundredth as many volumes.

use isokit::{
    geom::Frame,
    job::Job,
    marching_cubes::{
        Boundary, Degenerate, ExtractOptions, Extracted, Nan, Topology, extract, extract_into,
    },
    mesh::{Precision, TriMesh},
    volume::{Grid, Sample, Scaling, Volume},
};
use isokit_tests::{
    certified::{self, Class},
    chance::{Chance, looked_at, many},
    check::{Census, assert_closed, assert_sound, sides_of},
};
use std::collections::BTreeMap;

fn trilinear(boundary: Boundary) -> ExtractOptions {
    ExtractOptions::DEFAULT.with_topology(Topology::Trilinear).with_boundary(boundary)
}

fn volume<T: Sample>(dims: [usize; 3], samples: impl IntoIterator<Item = T>) -> Volume<T> {
    let grid = Grid::new(dims.map(|n| n as u64), Frame::default()).unwrap();
    Volume::new(grid, samples.into_iter().collect()).unwrap()
}

fn surface<T: Sample>(volume: &Volume<T>, iso: f64, options: &ExtractOptions) -> TriMesh {
    extract(&volume.view(), iso, options, &Job::default()).unwrap()
}

fn told<T: Sample>(volume: &Volume<T>, iso: f64, options: &ExtractOptions) -> Extracted {
    let mut mesh = TriMesh::default();
    extract_into(&volume.view(), iso, options, &mut mesh.refill(), &Job::default()).unwrap()
}

/// How many cells are looked at, where it is so many by default.
fn cells(default: usize) -> usize {
    many("CELLS", default)
}

/// The pieces of a mesh: to which each vertex belongs, and the Euler characteristic of each.
fn pieces(mesh: &TriMesh) -> (Vec<usize>, BTreeMap<usize, i64>) {
    let mut piece: Vec<usize> = (0..mesh.positions.len()).collect();
    fn root(piece: &mut [usize], mut v: usize) -> usize {
        while piece[v] != v {
            piece[v] = piece[piece[v]];
            v = piece[v];
        }
        v
    }
    let sides = || mesh.triangles.iter().flat_map(|&triangle| sides_of(triangle));
    for [a, b] in sides() {
        let [a, b] = [a, b].map(|v| root(&mut piece, v as usize));
        piece[a] = b;
    }
    let piece: Vec<usize> = (0..piece.len()).map(|v| root(&mut piece, v)).collect();
    let mut eulers = BTreeMap::new();
    let mut add = |v: usize, count: i64| *eulers.entry(piece[v]).or_insert(0) += count;
    (0..piece.len()).for_each(|v| add(v, 1));
    mesh.triangles.iter().for_each(|triangle| add(triangle[0] as usize, 1));
    let mut each: Vec<_> = sides().map(|[a, b]| [a.min(b), a.max(b)]).collect();
    each.sort_unstable();
    each.dedup();
    each.iter().for_each(|side| add(side[0] as usize, -1));
    (piece, eulers)
}

/// The patches of the surface of a single cell: the Euler characteristic and the cell edges of each.
fn patches(mesh: &TriMesh) -> Vec<(Vec<usize>, i64)> {
    let (piece, eulers) = pieces(mesh);
    let mut edges: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (v, place) in mesh.positions.iter().enumerate() {
        let within: Vec<usize> = (0..3).filter(|&k| place[k] != place[k].round()).collect();
        match within[..] {
            [axis] => {
                let others = (0..3).filter(|&k| k != axis).enumerate();
                let number: usize = others.map(|(n, k)| (place[k] as usize) << n).sum();
                edges.entry(piece[v]).or_default().push(4 * axis + number);
            }
            [_, _, _] => {}
            _ => panic!("{place:?} lies in a face"),
        }
    }
    let mut patches: Vec<_> = eulers
        .iter()
        .map(|(piece, &euler)| {
            let mut edges = edges.remove(piece).expect("no patch is all within the cell");
            edges.sort_unstable();
            (edges, euler)
        })
        .collect();
    patches.sort_unstable();
    patches
}

/// Asserts that samples which 15 bits hold have the same triangles as integers, of which other arithmetic decides, and as
/// halves of integers.
#[track_caller]
fn assert_same_of_integers(dims: [usize; 3], samples: &[i64], mesh: &TriMesh, boundary: Boundary) {
    let doubled = samples.iter().map(|&sample| i16::try_from(2 * sample));
    let Ok(doubled) = doubled.collect::<Result<Vec<_>, _>>() else { return };
    let doubled = volume(dims, doubled);
    let whole = volume(dims, doubled.samples().iter().map(|sample| sample / 2));
    let found = surface(&whole, 0.0, &trilinear(boundary));
    assert_eq!(found.triangles, mesh.triangles, "{samples:?}");
    let halves = doubled.view().with_scaling(Scaling::new(0.5, 0.0).unwrap());
    let found = extract(&halves, 0.0, &trilinear(boundary), &Job::default()).unwrap();
    assert_eq!(found.triangles, mesh.triangles, "{samples:?}");
}

/// Asserts that samples which are as far from another isovalue have the same triangles: as f64, as integers of 32 and of 16
/// bits, scaled, and as bytes on both sides of a half. In how many of these ways there are such.
#[track_caller]
fn assert_same_at_isovalues(
    dims: [usize; 3],
    samples: &[i64],
    mesh: &TriMesh,
    boundary: Boundary,
) -> usize {
    let (options, mut count) = (trilinear(boundary), 0);
    let mut check = |found: TriMesh, iso: f64| {
        count += 1;
        assert_eq!(found.triangles, mesh.triangles, "{samples:?}, {iso} higher");
    };
    let iso = [-0.75, 1000.25, -2_f64.powi(40)][samples.iter().sum::<i64>().rem_euclid(3) as usize];
    let higher = volume(dims, samples.iter().map(|&sample| sample as f64 + iso));
    check(surface(&higher, iso, &options), iso);
    let higher = samples.iter().map(|sample| i32::try_from(sample + 1_500_000_000));
    if let Ok(higher) = higher.collect::<Result<Vec<_>, _>>() {
        check(surface(&volume(dims, higher), 1.5e9, &options), 1.5e9);
    }
    let higher = samples.iter().map(|sample| u16::try_from(sample + 30_000));
    if let Ok(higher) = higher.collect::<Result<Vec<_>, _>>() {
        let higher = volume(dims, higher);
        check(surface(&higher, 30_000.0, &options), 30_000.0);
        let (scaled, iso) = (higher.view().with_scaling(Scaling::new(0.25, 3.5).unwrap()), 7503.5);
        check(extract(&scaled, iso, &options, &Job::default()).unwrap(), iso);
    }
    let halved = samples.iter().map(|sample| u8::try_from((sample + 201).div_euclid(2)));
    let are_odd = samples.iter().all(|sample| sample % 2 != 0);
    if let (true, Ok(halved)) = (are_odd, halved.collect::<Result<Vec<_>, _>>()) {
        check(surface(&volume(dims, halved), 100.5, &options), 100.5);
    }
    count
}

#[track_caller]
fn check_cell(corners: [i64; 8]) -> Class {
    let Some(certain) = certified::cell(corners) else { panic!("{corners:?} is undecided") };
    let class = Class::of_cell(corners, &certain);
    let mut expected: Vec<_> = certain.patches.into_iter().map(|p| (p.edges, p.euler)).collect();
    expected.sort_unstable();
    let made = volume([2; 3], corners.map(|c| c as f64));
    let mesh = surface(&made, 0.0, &trilinear(Boundary::Open));
    assert_eq!(patches(&mesh), expected, "{corners:?}");
    assert_sound(&mesh);
    assert_same_of_integers([2; 3], &corners, &mesh, Boundary::Open);
    assert_same_at_isovalues([2; 3], &corners, &mesh, Boundary::Open);
    assert_closed(&surface(&made, 0.0, &trilinear(Boundary::Closed)));
    class
}

/// Code by code: of the whole list only cells by chance of one code can find what is missing.
#[test]
fn cells_of_every_class_there_is_have_the_patches_that_are_certified_and_no_other_class_is_met() {
    let (each, mut chance) = (cells(10_000) / 1000, Chance::new(7));
    let mut met = BTreeMap::new();
    let all = certified::classes();
    for code in 0..256 {
        let of_code = all.iter().filter(|class| class.code == code).count();
        let (mut full, mut tries) = (0, 0);
        while full < of_code {
            assert!(tries < 20_000 * each, "{code:08b}: {full} of {of_code} in {tries} cells");
            let reach = [4, 50, 1000, 1 << 20][tries % 4];
            let corners = certified::random_for_classes(code, reach, &mut chance);
            let class = Class::of(corners).expect("it is decided");
            assert!(all.contains(&class), "{corners:?}: {class:?}");
            let count = met.entry(class).or_insert(0);
            if *count < each {
                assert_eq!(check_cell(corners), class);
                *count += 1;
                full += usize::from(*count == each);
            }
            tries += 1;
        }
    }
    assert_eq!(met.len(), 768);
    looked_at(met.values().sum(), "cells, as many of each of the 768 classes");
}

#[test]
fn every_code_of_a_cell_has_the_patches_that_are_certified() {
    let mut chance = Chance::new(1);
    for reach in [2, 4, 50, 1 << 20] {
        for code in 0..256 {
            for _ in 0..cells(10_000) / 1000 {
                check_cell(certified::random_with_code(code, reach, &mut chance));
            }
        }
    }
    looked_at(4 * 256 * (cells(10_000) / 1000), "cells, as many of each code");
}

#[test]
fn cells_by_chance_with_and_without_ties_have_the_patches_that_are_certified() {
    let mut chance = Chance::new(2);
    for n in 0..cells(10_000) {
        let reach = [2, 3, 5, 1000, 1 << 24][n % 5];
        check_cell(certified::random(reach, &mut chance));
    }
    looked_at(cells(10_000), "cells by chance");
}

/// Cells with a tunnel are rare by chance; two far corners against the rest have one often.
#[test]
fn cells_with_tunnels_have_the_patches_that_are_certified() {
    let mut chance = Chance::new(3);
    let mut tunnels = 0;
    for n in 0..cells(10_000) {
        let mut corners = certified::random([3, 9, 500][n % 3], &mut chance);
        let far = n % 8;
        for (k, value) in corners.iter_mut().enumerate() {
            let large = if k == far || k == 7 - far { 4 } else { 1 };
            *value = if n % 2 == 0 { large * value.abs() } else { -large * value.abs() };
            if large == 1 && chance.below(5) > 0 {
                *value = -*value;
            }
        }
        tunnels += usize::from(check_cell(corners).tunnel.is_some());
    }
    assert!(tunnels > cells(10_000) / 100, "{tunnels} tunnels");
    looked_at(tunnels, "cells with a tunnel");
}

/// Samples are so many units.
#[track_caller]
fn check_volume(dims: [usize; 3], samples: &[i64], unit: f32) {
    let exact = |sample: &i64| (*sample as f32) as i64 == *sample;
    assert!(samples.iter().all(exact), "what is certified is not what is extracted");
    let made = volume(dims, samples.iter().map(|&sample| sample as f32 * unit));
    let eulers = |boundary| {
        let mesh = surface(&made, 0.0, &trilinear(boundary));
        assert_sound(&mesh);
        if unit == 1.0 {
            assert_same_of_integers(dims, samples, &mesh, boundary);
            assert_same_at_isovalues(dims, samples, &mesh, boundary);
        }
        let mut eulers: Vec<i64> = pieces(&mesh).1.into_values().collect();
        eulers.sort_unstable();
        eulers
    };
    assert_eq!(Some(eulers(Boundary::Open)), certified::volume(dims, samples), "{samples:?}");
    let (larger, enclosed) = certified::enclosed(dims, samples);
    assert_eq!(Some(eulers(Boundary::Closed)), certified::volume(larger, &enclosed), "{samples:?}");
}

/// Dozens of volumes of this kind, from 5³ to 9³.
fn check_volumes((kind, seed): (&str, u64), unit: f32, sample: impl Fn(usize, &mut Chance) -> i64) {
    let (mut chance, count) = (Chance::new(seed), (cells(10_000) / 100).div_ceil(3));
    for n in 0..count {
        let dims = [(); 3].map(|()| 5 + chance.below(5) as usize);
        let points = dims.iter().product();
        let samples: Vec<i64> = (0..points).map(|_| sample(n, &mut chance)).collect();
        check_volume(dims, &samples, unit);
    }
    looked_at(count, &format!("volumes of {kind}, closed and open"));
}

/// Numbers of 24 binary digits, each with an exponent of its own, so that nothing but f32 holds them.
#[test]
fn volumes_of_f32_have_the_pieces_that_are_certified() {
    check_volumes(("numbers of 24 bits with exponents", 4), 2_f32.powi(-27), |n, chance| {
        certified::random(1 << 24, chance)[0] << chance.below([1, 4, 10][n % 3])
    });
}

/// No sample is a tie, but saddles are.
#[test]
fn volumes_of_odd_numbers_have_the_pieces_that_are_certified() {
    check_volumes(("odd numbers", 8), 1.0, |n, chance| {
        2 * certified::random([1, 2, 5, 1000][n % 4], chance)[0] + 1
    });
}

#[test]
fn volumes_of_small_numbers_with_ties_have_the_pieces_that_are_certified() {
    check_volumes(("small numbers with ties", 9), 1.0, |n, chance| {
        certified::random([1, 2, 3, 4][n % 4], chance)[0]
    });
}

/// scikit-image 8109 and its like: a saddle on the isovalue, in a face or in the interior.
#[test]
fn ties_of_saddles_have_the_pieces_that_are_certified_and_are_counted() {
    let samples = [13, -1, -1, -7, -1, 1, 7, -7, 15, -9, -3, -1];
    check_volume([2, 2, 3], &samples, 1.0);
    let mesh =
        surface(&volume([2, 2, 3], samples.map(|s| s as f32)), 0.0, &trilinear(Boundary::Open));
    let ways = assert_same_at_isovalues([2, 2, 3], &samples, &mesh, Boundary::Open);
    assert_eq!(ways, 5, "odd numbers that are small are met in every way");
    let face = [1, -1, -1, 1, -1, -1, -1, -1];
    let body = [3, -1, -1, -1, -1, -1, -1, 3];
    for (samples, singular) in [(face, 1), (body, 1), ([2, -1, -1, 1, -1, -1, -1, -1], 0)] {
        check_volume([2; 3], &samples, 1.0);
        check_volume([2; 3], &samples.map(|sample| -sample), 1.0);
        let made = volume([2; 3], samples.map(|sample| sample as i8));
        assert_eq!(told(&made, 0.0, &trilinear(Boundary::Open)).singular_cells, singular);
        let table = trilinear(Boundary::Open).with_topology(Topology::Table);
        assert_eq!(told(&made, 0.0, &table).singular_cells, 0, "which does not ask");
    }
}

/// One sample of a kind, from any 64 bits.
fn by_chance<T: Sample>(seed: u64, sample: fn(u64) -> T, iso: f64) {
    let mut chance = Chance::new(seed);
    let dims = [5 + seed as usize % 5, 5 + seed as usize / 2 % 5, 5 + seed as usize / 3 % 5];
    let count = dims.iter().product::<usize>();
    let made = volume(dims, (0..count).map(|_| sample(chance.bits())));
    for precision in [Precision::F32, Precision::F64] {
        let closed = trilinear(Boundary::Closed).with_precision(Some(precision));
        let mesh = surface(&made, iso, &closed);
        assert!(assert_closed(&mesh).volume > 0.0 || mesh.triangles.is_empty());
        assert_sound(&surface(&made, iso, &closed.clone().with_boundary(Boundary::Open)));
        // A border around cells that are left out may touch itself in a vertex.
        let masked = Census::of(&surface(&made, iso, &closed.with_nan(Nan::Mask)));
        assert_eq!(masked.faults(), masked.pinched_vertices, "{masked:?}");
    }
    let exact = trilinear(Boundary::Closed).with_degenerate(Degenerate::Exact);
    let census = Census::of(&surface(&made, iso, &exact));
    assert_eq!((census.faults_of_topology(), census.boundary_sides), (0, 0));
}

#[test]
fn volumes_of_all_eight_types_are_closed_and_manifold() {
    for seed in 0..40 {
        by_chance(seed, |r| r as u8, 127.5);
        by_chance(seed, |r| (r % 7) as i8 - 3, 0.0);
        by_chance(seed, |r| (r % 5) as u16, 2.0);
        by_chance(seed, |r| r as i16 | 1, 0.0);
        by_chance(seed, |r| r as u32, 2_147_483_648.25);
        by_chance(seed, |r| (r % 3) as i32 * (i32::MAX / 2), 1_000_000_000.1);
        by_chance(seed, |r| f32::from_bits(r as u32), 0.0);
        by_chance(seed, |r| (r % 1000) as f32 * 1e-3 - 0.5, 0.1);
        by_chance(seed, f64::from_bits, 0.0);
        by_chance(seed, f64::from_bits, 1e308);
        by_chance(seed, |r| f64::from_bits(r % 5), 1e-323);
        by_chance(seed, |r| [f64::NAN, 1.0, -1.0, f64::INFINITY, -0.5, 2.0][r as usize % 6], 0.0);
    }
}

#[test]
fn where_every_cell_is_simple_the_bytes_are_those_of_the_table() {
    let ball = |[x, y, z]: [usize; 3]| {
        let square = [x, y, z].map(|c| (c as f32 - 9.3).powi(2)).iter().sum::<f32>();
        8.0 - square.sqrt()
    };
    let places = (0..20 * 20 * 20).map(|n| [n % 20, n / 20 % 20, n / 400]);
    let made = volume([20; 3], places.map(ball));
    for boundary in [Boundary::Closed, Boundary::Open] {
        let table = trilinear(boundary).with_topology(Topology::Table);
        for iso in [0.0, 1.0, 5.5] {
            assert_eq!(surface(&made, iso, &trilinear(boundary)), surface(&made, iso, &table));
        }
    }
}

/// Rotations keep all; reflections too, though the mesh is another.
#[test]
fn pieces_are_the_same_seen_from_48_sides() {
    let mut chance = Chance::new(6);
    let samples: Vec<i64> = (0..343).map(|_| chance.below(9) as i64 - 4).collect();
    let pieces_of = |order: [usize; 3], mirror: usize| {
        let place = |n: usize| {
            let to = [n % 7, n / 7 % 7, n / 49];
            let from = |axis: usize| {
                let c = to[order[axis]];
                if mirror >> axis & 1 == 1 { 6 - c } else { c }
            };
            samples[from(0) + 7 * from(1) + 49 * from(2)] as f32
        };
        let made = volume([7; 3], (0..343).map(place));
        let singular = told(&made, 0.0, &trilinear(Boundary::Closed)).singular_cells;
        let mesh = surface(&made, 0.0, &trilinear(Boundary::Closed));
        let mut eulers: Vec<i64> = pieces(&mesh).1.into_values().collect();
        eulers.sort_unstable();
        (eulers, singular)
    };
    let expected = pieces_of([0, 1, 2], 0);
    assert!(expected.1 > 10, "{} singular cells show little", expected.1);
    for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
        for mirror in 0..8 {
            assert_eq!(pieces_of(order, mirror), expected, "{order:?}, {mirror}");
        }
    }
}
