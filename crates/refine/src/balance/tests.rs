//! The offsets against plain sums in f64, and the short way past triangles that nothing spoils.

use super::{
    Kind, Vertices, balance,
    system::{ROOTS, System},
};
use crate::{
    Isosurface, RefineOptions, Subdivision,
    ground::{Ground, is_spoiled},
    kit::FAR,
    refine,
};
use isokit_field::{Jet, Sampled, ScalarField, Slope};
use isokit_geom::{
    Affine, Frame,
    vector::{Vector, dot, length, normal, sub},
};
use isokit_job::{CHUNK, Job, Threads};
use isokit_marching_cubes::{Boundary, ExtractOptions, Gradient, Placement, extract};
use isokit_mesh::{Positions, Precision, TriMesh};
use isokit_volume::{Grid, Volume};
use std::collections::BTreeSet;

/// Numbers that nobody chose, from -1 to 1.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        (self.0 >> 40) as f32 / (1 << 23) as f32 - 1.0
    }
}

fn volume(dims: [u64; 3], f: impl Fn([f32; 3]) -> f32) -> Volume<f32> {
    let [nx, ny, nz] = dims;
    let place = |n: u64| [n % nx, n / nx % ny, n / nx / ny].map(|i| i as f32);
    let samples = (0..nx * ny * nz).map(|n| f(place(n))).collect();
    Volume::new(Grid::new(dims, Default::default()).unwrap(), samples).unwrap()
}

fn ball(points: u64) -> Volume<f32> {
    let middle = points as f32 / 2.0 - 0.46;
    volume([points; 3], |p| {
        0.4 * points as f32 - p.map(|c| c - middle).iter().fold(0.0, |r: f32, c| r.hypot(*c))
    })
}

/// Values that nobody chose; with `steps` they are multiples of its inverse, and many are 0.
fn noise(dims: [u64; 3], steps: Option<f32>, seed: u64) -> Volume<f32> {
    let [nx, ny, nz] = dims;
    let mut chance = Chance(seed);
    let mut value = || {
        let value = chance.next();
        steps.map_or(value, |steps| (value * steps).round() / steps)
    };
    let samples = (0..nx * ny * nz).map(|_| value()).collect();
    Volume::new(Grid::new(dims, Default::default()).unwrap(), samples).unwrap()
}

/// A smooth shape, chance, and ties.
fn volumes() -> [Volume<f32>; 5] {
    let holes = noise([8, 7, 9], None, 4);
    let mut samples = holes.samples().to_vec();
    samples.iter_mut().step_by(83).for_each(|sample| *sample = f32::NAN);
    [
        ball(12),
        volume([11, 9, 10], |[x, y, z]| (0.7 * x).sin() + (0.8 * y).cos() * (0.6 * z + 0.3).sin()),
        noise([7, 8, 6], None, 3),
        noise([8, 6, 7], Some(3.0), 5),
        Volume::new(*holes.grid(), samples).unwrap(),
    ]
}

/// As the pipeline extracts what is then balanced.
const OPTIONS: ExtractOptions =
    ExtractOptions::DEFAULT.with_placement(Placement::Cubic).with_gradient(Gradient::Matching);

fn surface(volume: &Volume<f32>, boundary: Boundary) -> TriMesh {
    extract(&volume.view(), 0.0, &OPTIONS.with_boundary(boundary), &Job::default()).unwrap()
}

fn places(mesh: &TriMesh) -> &[[f32; 3]] {
    match &mesh.positions {
        Positions::F32(places) => places,
        Positions::F64(_) => panic!("the lattice is small"),
    }
}

fn ground<'a>(field: &'a dyn ScalarField) -> Ground<'a> {
    Ground::new(Isosurface { field, iso: 0.0 }, Precision::F32)
}

fn vertices<'a>(mesh: &'a TriMesh, ground: &Ground<'_>) -> Vertices<'a, f32> {
    let normals = mesh.normals.as_ref().unwrap();
    Vertices::new((places(mesh), normals), ground, &Job::default()).unwrap()
}

fn threads(count: usize) -> Job {
    Job { threads: Threads::new(count.try_into().unwrap()).unwrap(), ..Job::default() }
}

/// The equations, written down as they are meant.
struct Plain {
    m: Vec<Vec<f64>>,
    b: Vec<f64>,
    sums: Vec<f64>,
}

impl Plain {
    fn new(mesh: &TriMesh, kinds: &[Kind]) -> Self {
        let count = kinds.len();
        let (mut m, mut b) = (vec![vec![0.0; count]; count], vec![0.0; count]);
        let normals = mesh.normals.as_ref().unwrap();
        let h = |i: usize, j: usize| {
            let [from, to] = [i, j].map(|v| normals[v].map(f64::from));
            dot(sub(to, from), sub(mesh.positions.get(j), mesh.positions.get(i)))
        };
        for &triangle in &mesh.triangles {
            if triangle.iter().any(|&v| matches!(kinds[v as usize], Kind::Unknown | Kind::Cap)) {
                continue;
            }
            let area = 0.5 * length(normal(mesh.corners(triangle)));
            let corners = triangle.map(|v| v as usize);
            for n in 0..3 {
                let [i, j, k] = [0, 1, 2].map(|other| corners[(n + other) % 3]);
                m[i][i] += area / 6.0;
                m[i][j] += area / 12.0;
                m[i][k] += area / 12.0;
                b[i] += area * (2.0 * h(i, j) + 2.0 * h(i, k) + h(j, k)) / 120.0;
            }
        }
        let sums = m.iter().map(|row| row.iter().sum()).collect();
        Self { m, b, sums }
    }

    /// Goes so many steps from 0.
    fn after(&self, roots: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let mut d = vec![0.0; self.b.len()];
        for root in roots {
            let md: Vec<f64> =
                self.m.iter().map(|row| row.iter().zip(&d).map(|(m, d)| m * d).sum()).collect();
            for v in 0..d.len() {
                if self.sums[v] > 0.0 {
                    d[v] += (self.b[v] - md[v]) / self.sums[v] / root;
                }
            }
        }
        d
    }

    /// The length of a vector, in which those of L⁻¹M are at right angles.
    fn length(&self, d: &[f64]) -> f64 {
        self.sums.iter().zip(d).map(|(sum, d)| sum * d * d).sum::<f64>().sqrt()
    }
}

#[test]
fn offsets_are_those_of_plain_sums_and_nearly_those_that_solve_the_equations() {
    for (n, volume) in volumes().iter().enumerate() {
        let field = Sampled::new(volume.view());
        let ground = ground(&field);
        for boundary in [Boundary::Closed, Boundary::Open] {
            let mesh = surface(volume, boundary);
            let vertices = vertices(&mesh, &ground);
            let mut system = System::new(&vertices, &mesh.triangles, &Job::default()).unwrap();
            let found = system.solved(&mesh.triangles, &Job::default()).unwrap();
            let plain = Plain::new(&mesh, &vertices.kinds);
            for (sum, offset) in plain.sums.iter().zip(&found) {
                assert_eq!(*sum > 0.0, !offset.is_nan(), "{n}, {boundary:?}");
            }
            let known = |d: f32| if d.is_nan() { 0.0 } else { f64::from(d) * ground.unit() };
            let found: Vec<f64> = found.into_iter().map(known).collect();
            let expected = plain.after(ROOTS.map(f64::from));
            let off = less(&found, &expected).iter().fold(0.0_f64, |most, off| most.max(off.abs()));
            let most = expected.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
            assert!(off < 1e-4 * most, "{n}, {boundary:?}: {off:e} of {most:e}");
            let solution = plain.after([1.0; 200]);
            let left = plain.length(&less(&found, &solution)) / plain.length(&solution);
            assert!(left < 1.001 * most_left(), "{n}, {boundary:?}: {left}");
            // The mean of what remains is 0.
            let raised: Vec<f64> = plain.sums.iter().zip(&found).map(|(sum, d)| sum * d).collect();
            let [wanted, is] = [&plain.b, &raised].map(|all| all.iter().sum::<f64>());
            let all: f64 = raised.iter().map(|raised| raised.abs()).sum();
            assert!((wanted - is).abs() < 1e-6 * all, "{n}, {boundary:?}: {wanted} and {is}");
        }
    }
}

#[test]
fn the_roots_are_those_of_the_polynomial_that_is_least() {
    // Of T₂ at (λ − m) / r, which is at its least value at λ = m and has the value 1 at ¼.
    let [low, high] = ROOTS.map(f64::from);
    let (m, r) = ((low + high) / 2.0, (high - low) / 2.0_f64.sqrt());
    assert!((m - r - 0.25).abs() < 1e-7, "{m}, {r}");
    assert_eq!(high, 1.0, "or the volume is not kept");
    let at = |value: f64| (1.0 - value / low) * (1.0 - value / high);
    assert!((most_left() - at(0.25)).abs() < 1e-5 && (at(0.25) + at(m)).abs() < 1e-6);
}

fn less(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// What the steps leave of an eigenvector at most.
fn most_left() -> f64 {
    let left = |value: f64| ROOTS.iter().map(|&root| 1.0 - value / f64::from(root)).product();
    (250..=1000)
        .map(|n| f64::from(n) / 1000.0)
        .map(left)
        .fold(0.0, |most, left: f64| most.max(left.abs()))
}

#[test]
fn any_number_of_threads_makes_the_same_offsets() {
    // More than a chunk of triangles, in the order they are made in and in none.
    let (volume, mut chance) = (ball(64), Chance(7));
    let field = Sampled::new(volume.view());
    let ground = ground(&field);
    let mut mesh = surface(&volume, Boundary::Closed);
    assert!(mesh.triangles.len() > CHUNK);
    for _ in 0..2 {
        let vertices = vertices(&mesh, &ground);
        let offsets = |job: &Job| {
            let mut system = System::new(&vertices, &mesh.triangles, job).unwrap();
            let offsets = system.solved(&mesh.triangles, job).unwrap();
            offsets.into_iter().map(f32::to_bits).collect::<Vec<_>>()
        };
        let one = offsets(&threads(1));
        assert!([2, 3, 7].into_iter().all(|count| offsets(&threads(count)) == one));
        mesh.triangles.sort_by_cached_key(|_| (chance.next() * 1e6) as i32);
    }
}

#[test]
fn what_is_not_doubted_is_not_spoiled() {
    let mut chance = Chance(11);
    let (mut spoiled, mut passed, mut in_file_only) = (0, 0, 0);
    let far = |volume: Volume<f32>| {
        let frame = Frame {
            index_to_world: Affine::axis_aligned([1.0; 3], FAR).unwrap(),
            ..Frame::default()
        };
        let grid = Grid::new(volume.grid().dims(), frame).unwrap();
        (Volume::new(grid, volume.samples().to_vec()).unwrap(), Some(1.0025e-3))
    };
    let near = volumes().map(|volume| (volume, None));
    for (volume, scale) in &near.into_iter().chain(volumes().map(far)).collect::<Vec<_>>() {
        let field = Sampled::new(volume.view());
        let ground = ground(&field).with_file_scale(*scale);
        let mut mesh = surface(volume, Boundary::Closed);
        if scale.is_some() {
            // Triangles about as small as steps.
            let options = RefineOptions::DEFAULT.with_subdivision(Subdivision::Levels(3));
            let surface = Isosurface { field: &field, iso: 0.0 };
            refine(&mut mesh, &surface, &options.with_file_scale(*scale), &Job::default()).unwrap();
        }
        let vertices = vertices(&mesh, &ground);
        let system = System::new(&vertices, &mesh.triangles, &Job::default()).unwrap();
        for most in [1e-7, 1e-3, 1e-2, 0.1, 0.5_f32] {
            let step = || [(); 3].map(|()| f64::from(most * chance.next()));
            let steps: Vec<Vector> =
                std::iter::repeat_with(step).take(places(&mesh).len()).collect();
            let ways: Vec<f32> =
                steps.iter().map(|step| (length(*step) / ground.unit()) as f32).collect();
            let ways = (&ways[..], ground.way_in_file());
            let doubted = system.doubted(&mesh.triangles, ways, &Job::default()).unwrap();
            let doubted: BTreeSet<_> = doubted.into_iter().collect();
            for &triangle in &mesh.triangles {
                let before = mesh.corners(triangle);
                let after = triangle.map(|v| {
                    let (from, step) = (mesh.positions.get(v as usize), steps[v as usize]);
                    [0, 1, 2].map(|k| from[k] + step[k])
                });
                let is_doubted = doubted.contains(&triangle);
                let is_bad = ground.is_spoiled(after, normal(before));
                assert!(is_doubted || !is_bad, "{most}: {before:?}, {after:?}");
                passed += usize::from(!is_doubted);
                spoiled += usize::from(is_bad);
                in_file_only += usize::from(is_bad && !is_spoiled(after, normal(before)));
            }
        }
    }
    assert!(
        spoiled > 100 && passed > 100 && in_file_only > 0,
        "{spoiled}, {passed}, {in_file_only}"
    );
}

#[test]
fn a_world_at_any_scale_is_balanced_alike() {
    let balanced = |scale: f64| {
        let small = ball(14);
        let affine = Affine::axis_aligned([scale, 2.0 * scale, scale], [0.0; 3]).unwrap();
        let frame = Frame { index_to_world: affine, ..Frame::default() };
        let grid = Grid::new(small.grid().dims(), frame).unwrap();
        let volume = Volume::new(grid, small.samples().to_vec()).unwrap();
        let (options, job) = (OPTIONS.with_precision(Some(Precision::F64)), Job::default());
        let mut mesh = extract(&volume.view(), 0.0, &options, &job).unwrap();
        let (before, field) = (mesh.clone(), Sampled::new(volume.view()));
        let ground = Ground::new(Isosurface { field: &field, iso: 0.0 }, Precision::F64);
        let found = balance(&mut mesh, &ground, &job).unwrap();
        assert_eq!(found, (before.positions.len() as u64, 0));
        assert_ne!(mesh, before);
        mesh.positions.iter().map(|place| place.map(|c| c / scale)).collect::<Vec<_>>()
    };
    let usual = balanced(1.0);
    assert!(balanced(2.0_f64.powi(-150)) == usual && balanced(2.0_f64.powi(140)) == usual);
}

/// A field that is asked for values alone.
struct Flat<'a>(Sampled<'a, f32>);

impl ScalarField for Flat<'_> {
    fn dims(&self) -> [usize; 3] {
        self.0.dims()
    }

    fn index_to_world(&self) -> Affine {
        self.0.index_to_world()
    }

    fn value(&self, ijk: [f64; 3]) -> f64 {
        self.0.value(ijk)
    }

    fn slope(&self, _: [f64; 3]) -> Slope {
        panic!("the mesh has normals")
    }

    fn jet(&self, _: [f64; 3]) -> Jet {
        panic!("the mesh has normals")
    }
}

#[test]
fn a_mesh_with_normals_asks_the_field_for_none_and_stays_where_they_are_none() {
    for volume in &volumes() {
        let field = Flat(Sampled::new(volume.view()));
        for boundary in [Boundary::Closed, Boundary::Open] {
            let mut mesh = surface(volume, boundary);
            let normals = mesh.normals.as_mut().unwrap();
            let bad = [[f32::NAN; 3], [0.0; 3], [f32::INFINITY; 3], [3.0; 3]];
            for (normal, bad) in normals.iter_mut().step_by(29).zip(bad.into_iter().cycle()) {
                *normal = bad;
            }
            let before = mesh.clone();
            let (balanced, kept) = balance(&mut mesh, &ground(&field), &Job::default()).unwrap();
            assert!(balanced > 0 && kept > 0);
            let stays = |v: &usize| mesh.positions.get(*v) == before.positions.get(*v);
            assert!((0..mesh.positions.len()).step_by(29).all(|v| stays(&v)));
            assert!(mesh.positions.iter().flatten().all(f64::is_finite));
        }
    }
}

/// A pointed solid, and its mirror image in the plane that its tip moves to.
#[test]
fn tips_that_would_meet_stay_and_all_else_moves() {
    let zeros = volume([20; 3], |_| 0.0);
    let field = Sampled::new(zeros.view());
    let ground = Ground::new(Isosurface { field: &field, iso: 0.0 }, Precision::F64);
    let corners: [Vector; 4] = [[8.0, 5.0, 5.0], [4.0, 3.0, 4.0], [4.0, 7.0, 4.0], [4.0, 5.0, 7.0]];
    let solid = |turn: usize| {
        [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]].map(|t: [u32; 3]| {
            let corner = |k: usize| t[(k * (1 + turn)) % 3] + 4 * turn as u32;
            [corner(0), corner(1), corner(2)]
        })
    };
    let outward =
        |sign: f32| [[sign, 0.0, 0.0], [-sign, 0.0, 0.0], [-sign, 0.0, 0.0], [-sign, 0.0, 0.0]];
    let balanced = |corners: Vec<Vector>, signs: &[f32]| {
        let triangles = (0..signs.len()).flat_map(solid).collect();
        let normals = Some(signs.iter().flat_map(|&sign| outward(sign)).collect());
        let positions = Positions::F64(corners);
        let mut mesh = TriMesh { positions, normals, triangles, ..TriMesh::default() };
        let counts = balance(&mut mesh, &ground, &Job::default()).unwrap();
        (mesh.positions, counts)
    };
    let (alone, counts) = balanced(corners.into(), &[1.0]);
    assert_eq!(counts, (4, 0));
    let tip = alone.get(0)[0];
    assert!(tip > 8.0);
    let both = |plane: f64| {
        let mirrored = corners.map(|[x, y, z]| [2.0 * plane - x, y, z]);
        balanced([corners, mirrored].concat(), &[1.0, -1.0])
    };
    let (near, counts) = both(tip + 1e-9);
    assert_eq!((near.get(0), counts), (alone.get(0), (8, 0)));
    let (met, counts) = both(tip);
    assert_eq!(counts, (6, 2));
    assert_eq!((met.get(0), met.get(1)), (corners[0], alone.get(1)));
    assert_eq!(met.get(4), [2.0 * tip - 8.0, 5.0, 5.0]);
}
