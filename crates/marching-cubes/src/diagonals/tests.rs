//! The choice against its definition, polygon by polygon; and that it is the same whoever makes the surface.

use super::CELLS;
use crate::{
    Boundary, Budget, Degenerate, Diagonals, ExtractError, ExtractOptions, Gradient, Nan,
    Placement, SlabError, Slabs, Source, Topology,
    case::{
        TRIANGLES,
        derive::{self, Pairing},
        triangulate,
    },
    extract, extract_into, extract_many, extract_slabs, extract_sparse,
};
use isokit_geom::{
    Affine, Frame,
    cube::Edge,
    vector::{Vector, cross, dot, sub},
};
use isokit_job::{CancelToken, Cancelled, Job, Limits, Stopped, Threads};
use isokit_lanes::Extent;
use isokit_mesh::{Counts, MeshSink, Piece, Precision, Refill, TriMesh};
use isokit_volume::{Bricks, Grid, Points, Sample, SampleSource, Slices, Volume};
use std::{collections::BTreeSet, convert::Infallible, num::NonZeroUsize};

/// What is fitted.
const FITTED: ExtractOptions = ExtractOptions::DEFAULT.with_diagonals(Diagonals::Fitted);

fn frames() -> [Affine; 3] {
    [
        Affine::axis_aligned([1.0; 3], [0.0; 3]).unwrap(),
        Affine::new([[0.9, 0.1, 0.0], [-0.2, 0.8, 0.3], [0.4, 0.0, 1.3]], [5.0; 3]).unwrap(),
        Affine::new([[-1.5, 0.0, 0.0], [0.0, 1.0, 0.2], [0.0, -0.2, 1.0]], [-9.0; 3]).unwrap(),
    ]
}

fn volume<T: Sample>(
    dims: [u64; 3],
    index_to_world: Affine,
    at: impl FnMut([u64; 3]) -> T,
) -> Volume<T> {
    let grid = Grid::new(dims, Frame { index_to_world, ..Frame::default() }).unwrap();
    let place = |n: u64| [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]];
    Volume::new(grid, (0..grid.count()).map(place).map(at).collect()).unwrap()
}

/// Waves along and across all axes.
fn waves(ijk: [u64; 3]) -> f32 {
    let [x, y, z] = ijk.map(|i| i as f32);
    (0.61 * x + 0.3).sin() * (0.47 * y).cos() + (0.53 * z - 0.2 * x).sin() + 0.4 * (0.7 * y).sin()
}

fn chance(state: &mut u64) -> u64 {
    *state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
    *state >> 33
}

/// A mesh's vertices, and the choice that they are there for.
struct Definition<'a> {
    mesh: &'a TriMesh,
    mirrors: bool,
}

impl Definition<'_> {
    fn place(&self, v: u32) -> Vector {
        self.mesh.positions.get(v as usize)
    }

    fn normal(&self, v: u32) -> Vector {
        self.mesh.normals.as_ref().unwrap()[v as usize].map(f64::from)
    }

    fn cost(&self, ring: &[u32], triangles: &[[u32; 3]]) -> f64 {
        let is_side = |a: u32, b: u32| {
            (0..ring.len()).any(|n| (ring[n], ring[(n + 1) % ring.len()]) == (a, b))
        };
        let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let diagonals = sides.filter(|&[a, b]| a < b && !is_side(a, b) && !is_side(b, a));
        let bend = |[a, b]: [u32; 2]| {
            dot(sub(self.normal(b), self.normal(a)), sub(self.place(b), self.place(a)))
        };
        diagonals.map(|ends| bend(ends).powi(2)).sum()
    }

    /// The least area of a triangle along the normal of all corners, as a share of the sum of squares of how far they are from
    /// the first.
    fn least_area(&self, ring: &[u32], triangles: &[[u32; 3]]) -> f64 {
        let mean = |k: usize| ring.iter().map(|&v| self.normal(v)[k]).sum::<f64>();
        let mean = [mean(0), mean(1), mean(2)];
        let first = self.place(ring[0]);
        let away = |v: &u32| sub(self.place(*v), first);
        let size: f64 = ring.iter().map(|v| dot(away(v), away(v))).sum();
        let area = |&[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [a, b, c].map(|v| self.place(v));
            let turned = if self.mirrors { -1.0 } else { 1.0 };
            turned * dot(cross(sub(b, a), sub(c, a)), mean)
        };
        triangles.iter().map(area).fold(f64::INFINITY, f64::min) / (size * ring.len() as f64)
    }
}

type Way = BTreeSet<[u32; 3]>;

fn way(triangles: &[[u32; 3]]) -> Way {
    let named = |triangle: &[u32; 3]| {
        let mut triangle = *triangle;
        let least = (0..3).min_by_key(|&n| triangle[n]).unwrap();
        triangle.rotate_left(least);
        triangle
    };
    triangles.iter().map(named).collect()
}

/// How many polygons were looked at, and how many of them are cut otherwise than by the table.
#[track_caller]
fn check<T: Sample>(volume: &Volume<T>, iso: f64, options: &ExtractOptions) -> [usize; 2] {
    let (view, job) = (volume.view(), Job::default());
    let options = options.clone().with_boundary(Boundary::Open).with_topology(Topology::Table);
    let of_table = options.clone().with_diagonals(Diagonals::Table);
    let plain = extract(&view, iso, &of_table, &job).unwrap();
    let fitted = extract(&view, iso, &options, &job).unwrap();
    assert_eq!((&plain.positions, &plain.normals), (&fitted.positions, &fitted.normals));
    assert_eq!(plain.triangles.len(), fitted.triangles.len());

    let mirrors = view.frame().index_to_world.determinant() < 0.0;
    let definition = Definition { mesh: &plain, mirrors };
    let turned = |&[a, b, c]: &[u32; 3]| if mirrors { [a, c, b] } else { [a, b, c] };
    let plain: Vec<_> = plain.triangles.iter().map(turned).collect();
    let fitted: Vec<_> = fitted.triangles.iter().map(turned).collect();
    let dims = view.dims();
    let (mut at, mut found) = (0, [0, 0]);
    for cell in 0..dims.iter().map(|n| n - 1).product() {
        let [nx, ny, _] = dims.map(|n| n - 1);
        let low = [cell % nx, cell / nx % ny, cell / nx / ny];
        let corner = |k: usize| [0, 1, 2].map(|axis| low[axis] + (k >> axis & 1));
        let case = (0..8).fold(0, |case, k| case | u8::from(view.value(corner(k)) >= iso) << k);
        let own = TRIANGLES[usize::from(case)];
        let [plain, fitted] = [&plain, &fitted].map(|all| &all[at..at + own.len()]);
        let vertex = |edge: &Edge| {
            let is_it = |&e: &u8| usize::from(e) == edge.index();
            plain.as_flattened()[own.as_flattened().iter().position(is_it).unwrap()]
        };
        let mut first = 0;
        for ring in derive::loops(case, Pairing::SeparateInside) {
            let corners: Vec<u32> = ring.iter().map(vertex).collect();
            let [plain, fitted] = [plain, fitted].map(|all| &all[first..][..ring.len() - 2]);
            let ways = triangulate::face_safe(&ring).into_iter();
            let ways =
                ways.map(|way| way.iter().map(|t| t.map(|e| vertex(&e))).collect::<Vec<_>>());
            let ways: Vec<_> = ways.map(|way| (definition.cost(&corners, &way), way)).collect();
            found[0] += usize::from(ring.len() > 3);
            found[1] += usize::from(way(plain) != way(fitted));
            let area =
                |triangles: &[[u32; 3]]| 65536.0 * definition.least_area(&corners, triangles);
            let chosen = definition.cost(&corners, fitted);
            let is_own = way(plain) == way(fitted);
            let is_one = ways.iter().any(|(_, own)| way(own) == way(fitted));
            let is_less = area(fitted) > 0.999 && chosen < 1.001 * definition.cost(&corners, plain);
            // None that is sound for certain has less.
            let is_least =
                ways.iter().all(|(cost, own)| *cost >= 0.999 * chosen || area(own) < 1.001);
            assert!(
                is_one && (is_own || is_less) && is_least && chosen.is_finite(),
                "{case:#010b}: {fitted:?} of {ways:?}, {options:?}"
            );
            first += ring.len() - 2;
        }
        at += own.len();
    }
    assert_eq!(at, plain.len());
    found
}

#[test]
fn polygons_are_cut_with_the_least_sum_of_squares_that_normals_tell() {
    let mut found = [0; 2];
    let mut add = |[all, cut]: [usize; 2]| found = [found[0] + all, found[1] + cut];
    for frame in frames() {
        for precision in [Precision::F32, Precision::F64] {
            let options = FITTED.with_precision(Some(precision));
            add(check(&volume([19, 14, 16], frame, waves), 0.1, &options));
            let matching = options.with_gradient(Gradient::Matching);
            let matching = matching.with_placement(Placement::Linear);
            add(check(&volume([9, 14, 16], frame, waves), -0.3, &matching));
        }
    }
    assert!(found[1] > found[0] / 3 && found[1] < found[0], "{found:?}");
}

#[test]
fn so_are_those_of_chance_and_of_ties() {
    let mut found = [0; 2];
    for round in 0..30 {
        let (mut state, frame) = (round, frames()[round as usize % 3]);
        let noise = volume([6, 7, 5], frame, |_| (chance(&mut state) % 2001) as f32 / 1000.0 - 1.0);
        let ties = volume([6, 7, 5], frame, |_| (chance(&mut state) % 5) as i8 - 2);
        for degenerate in [Degenerate::Never, Degenerate::Exact] {
            let options = FITTED.with_degenerate(degenerate);
            for [all, cut] in [check(&noise, 0.0, &options), check(&ties, 0.0, &options)] {
                found = [found[0] + all, found[1] + cut];
            }
        }
    }
    // More cells in a slice than are sorted at a time.
    let mut state = 77;
    let [.., frame] = frames();
    let wide = volume([90, 80, 3], frame, |_| chance(&mut state) as f32 / (1 << 30) as f32 - 1.0);
    let [all, cut] = check(&wide, 0.0, &FITTED);
    found = [found[0] + all, found[1] + cut];
    assert!(found[1] > found[0] / 20 && found[1] < found[0] && all > 2 * CELLS, "{found:?}");
}

/// Samples that are there, as if they were made.
struct Made<'a>(&'a Volume<f32>);

impl SampleSource<f32> for Made<'_> {
    fn grid(&self) -> Grid {
        *self.0.grid()
    }

    fn extent(&self, _: &Points) -> Option<Extent<f32>> {
        None
    }

    fn fill(&self, [x, y, z]: &Points, samples: &mut [f32]) {
        let places = z.clone().flat_map(|k| y.clone().map(move |j| (j, k)));
        let places = places.flat_map(|(j, k)| x.clone().map(move |i| [i, j, k]));
        let view = self.0.view();
        samples.iter_mut().zip(places).for_each(|(sample, ijk)| *sample = view.value(ijk) as f32);
    }
}

#[test]
fn the_choice_is_the_same_however_the_surface_is_made() {
    // Large enough for a sweep, with what is decided, noise, and a hole.
    let mut state = 3;
    let [_, frame, mirrored] = frames();
    let rough = volume([70, 60, 130], frame, |ijk| {
        let noise = (chance(&mut state) % 1000) as f32 / 1000.0 - 0.5;
        match ijk {
            [30, 20, 40] => f32::NAN,
            [0..30, ..] => waves(ijk),
            _ => waves(ijk) + noise,
        }
    });
    let smooth = volume([50, 40, 45], mirrored, waves);
    let threads = |n| Threads::new(NonZeroUsize::new(n).unwrap()).unwrap();
    for (volume, nan) in [(&rough, Nan::Outside), (&rough, Nan::Mask), (&smooth, Nan::Outside)] {
        let (view, options) = (volume.view(), FITTED.with_nan(nan));
        let one = Job { threads: threads(1), ..Job::default() };
        let expected = extract(&view, 0.1, &options, &one).unwrap();
        let table = options.clone().with_diagonals(Diagonals::Table);
        assert_ne!(extract(&view, 0.1, &table, &one).unwrap(), expected);
        for count in [2, 5] {
            let job = Job { threads: threads(count), ..Job::default() };
            let small = options.clone().with_layers_per_task(NonZeroUsize::MIN);
            assert!(extract(&view, 0.1, &small, &job).unwrap() == expected, "{count} threads");
        }
        let job = Job::default();
        let mut used = extract(&view, -0.4, &options, &job).unwrap();
        extract_into(&view, 0.1, &options, &mut used.refill(), &job).unwrap();
        assert!(used == expected, "used memory, {nan:?}");
        let bricks = Bricks::of(&view, &job).unwrap();
        for source in [Source::with_bricks(&view, &bricks).unwrap(), Source::from(&view)] {
            let mut meshes = [TriMesh::with_normals(), TriMesh::with_normals()];
            let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
            extract_many(source, &[-0.4, 0.1], &options, &mut sinks, &job).unwrap();
            drop(sinks);
            assert!(meshes[1] == expected, "with bricks or another isovalue, {nan:?}");
        }
        for window in [7, 20] {
            let budget = Budget { window, piece_bytes: u64::MAX };
            let slabs = Slabs { isos: &[0.1], options: &options, budget };
            let mut mesh = TriMesh::with_normals();
            let mut slices = Slices::new(view);
            extract_slabs(&mut slices, &slabs, &mut vec![mesh.refill()], &job).unwrap();
            assert!(mesh == expected, "{window} slices, {nan:?}");
        }
        if nan == Nan::Outside {
            let mut mesh = TriMesh::with_normals();
            extract_sparse(&Made(volume), 0.1, &options, &mut mesh.refill(), &job).unwrap();
            assert!(mesh == expected, "of blocks");
        }
    }
}

/// A sink that keeps nothing.
struct Passing(TriMesh);

impl MeshSink for Passing {
    type Error = Infallible;

    fn wants_normals(&self) -> bool {
        true
    }

    fn piece(&mut self, counts: Counts, precision: Precision) -> Result<Piece<'_>, Infallible> {
        Ok(self.0.renew(counts, precision))
    }
}

/// A mesh whose job is cancelled when the surface is there.
struct Stopping<'a>(Refill<'a>, CancelToken);

impl MeshSink for Stopping<'_> {
    type Error = Infallible;

    fn wants_normals(&self) -> bool {
        true
    }

    fn piece(&mut self, counts: Counts, precision: Precision) -> Result<Piece<'_>, Infallible> {
        self.0.piece(counts, precision)
    }

    fn held(&mut self) -> Option<Piece<'_>> {
        let held = self.0.held();
        if held.as_ref().is_some_and(|held| !held.triangles.is_empty()) {
            self.1.cancel();
        }
        held
    }
}

#[test]
fn who_cancels_while_diagonals_are_fitted_or_has_no_memory_for_them_is_heard() {
    let volume = volume([19, 14, 16], frames()[0], waves);
    let (view, job) = (volume.view(), Job::default());
    let mut mesh = TriMesh::with_normals();
    let mut sink = Stopping(mesh.refill(), job.cancel.clone());
    let stopped = extract_into(&view, 0.1, &FITTED, &mut sink, &job);
    assert_eq!(stopped, Err(ExtractError::Stopped(Stopped::Cancelled(Cancelled))));
    drop(sink);
    // Exactly what the surface takes. The cases of cells take more.
    let bytes = 24 * mesh.positions.len() as u64 + 12 * mesh.triangles.len() as u64;
    let job = Job { limits: Limits { bytes }, ..Job::default() };
    let table = FITTED.with_diagonals(Diagonals::Table);
    for count in [1, 2] {
        let (isos, mut meshes) = (vec![0.1; count], vec![mesh.clone(); count]);
        let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
        assert!(extract_many(&view, &isos, &table, &mut sinks, &job).is_ok());
        drop(sinks);
        let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
        let over = extract_many(&view, &isos, &FITTED, &mut sinks, &job).unwrap_err();
        assert!(over.to_string().starts_with("surface needs"), "{over}, of {count}");
    }
    let in_one_slab = |options: &ExtractOptions| {
        let budget = Budget { window: 16, piece_bytes: u64::MAX };
        let slabs = Slabs { isos: &[0.1], options, budget };
        let mut mesh = mesh.clone();
        extract_slabs(&mut Slices::new(view), &slabs, &mut vec![mesh.refill()], &job).map(|_| ())
    };
    assert_eq!(in_one_slab(&table), Ok(()));
    let over = in_one_slab(&FITTED).unwrap_err();
    assert!(over.to_string().starts_with("surface needs"), "{over}, of a slab");
}

#[test]
fn a_surface_that_is_handed_on_or_has_no_normals_is_refused_before_it_is_made() {
    let volume = volume([9, 8, 7], frames()[0], waves);
    let (view, job) = (volume.view(), Job::default());
    let mut passing = Passing(TriMesh::with_normals());
    let passed = extract_into(&view, 0.1, &FITTED, &mut passing, &job);
    assert_eq!(passed, Err(ExtractError::Unfitted { is_kept: false }));
    let mut bare = TriMesh::default();
    let without = extract_into(&view, 0.1, &FITTED, &mut bare.refill(), &job);
    assert_eq!(without, Err(ExtractError::Unfitted { is_kept: true }));
    assert_eq!(passing.0.triangles.len() + bare.triangles.len(), 0);
    let budget = Budget { window: 9, piece_bytes: u64::MAX };
    let slabs = Slabs { isos: &[0.1], options: &FITTED, budget };
    let mut sinks = vec![Passing(TriMesh::with_normals())];
    let slabs = extract_slabs(&mut Slices::new(view), &slabs, &mut sinks, &job);
    assert_eq!(slabs, Err(SlabError::Extract(ExtractError::Unfitted { is_kept: false })));
    let says = ExtractError::<Infallible>::Unfitted { is_kept: false }.to_string();
    assert!(says.contains("handed on in pieces"), "{says}");
    let table = ExtractOptions::DEFAULT;
    assert!(extract_into(&view, 0.1, &table, &mut bare.refill(), &job).is_ok());
}
