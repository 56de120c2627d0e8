//! Instructions that an extraction takes, counted by Valgrind: a regression shows at once, on any
//! machine, however busy.
//!
//! `scripts/instructions` runs it and compares with the counts that are kept; by hand it is
//! `cargo bench -p isokit-marching-cubes --bench instructions`, with Valgrind and the `gungraun-runner`
//! of the same version as `gungraun`. Valgrind knows no AVX-512, so the counts are of the code for AVX2.

#![expect(missing_docs, reason = "the macros that make a benchmark document nothing")]

use gungraun::{LibraryBenchmarkConfig, library_benchmark, library_benchmark_group, main};
use isokit_job::Job;
use isokit_marching_cubes::{
    Boundary, Budget, ExtractOptions, Gradient, Placement, Slabs, Source, Topology, extract_many,
    extract_slabs,
};
use isokit_mesh::{Counts, TriMesh};
use isokit_volume::{Bricks, Grid, Slices, Volume};
use rayon::ThreadPoolBuilder;
use std::hint::black_box;

/// Points along an axis: more than a word of 64.
const N: usize = 80;

/// What the counts of one choice differ by from those of another is what that choice takes.
const PLAIN: ExtractOptions = ExtractOptions::DEFAULT
    .with_topology(Topology::Table)
    .with_placement(Placement::Linear)
    .with_boundary(Boundary::Open);

struct Work {
    volume: Volume<f32>,
    bricks: Bricks<f32>,
    isos: &'static [f64],
    options: ExtractOptions,
    meshes: Vec<TriMesh>,
}

/// A volume, and meshes that are large enough already.
fn prepared(value: fn([f32; 3]) -> f32, isos: &'static [f64], options: ExtractOptions) -> Work {
    // Only this thread is counted, so it does all the work.
    let here = ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    here.build_global().expect("no pool before");
    let grid = Grid::new([N as u64; 3], Default::default()).expect("a lattice");
    let place = |i: usize| [i % N, i / N % N, i / N / N].map(|c| c as f32 / (N - 1) as f32);
    let samples = (0..N * N * N).map(|i| value(place(i))).collect();
    let volume = Volume::new(grid, samples).expect("one sample per point");
    let bricks = Bricks::of(&volume.view(), &Job::default()).expect("bricks");
    let meshes = vec![TriMesh::with_normals(); isos.len()];
    let mut work = Work { volume, bricks, isos, options, meshes };
    extracted(&mut work);
    work
}

fn extracted(work: &mut Work) -> Vec<Counts> {
    let Work { volume, isos, options, meshes, .. } = work;
    of_source((&volume.view()).into(), isos, options, meshes)
}

fn of_source(
    source: Source<'_, f32>,
    isos: &[f64],
    options: &ExtractOptions,
    meshes: &mut [TriMesh],
) -> Vec<Counts> {
    let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
    let done = extract_many(source, isos, options, &mut sinks, &Job::default());
    done.expect("surfaces").iter().map(|one| one.counts).collect()
}

/// No surface: what remains is classification.
fn empty(_: [f32; 3]) -> f32 {
    -1.0
}

fn sphere(p: [f32; 3]) -> f32 {
    0.16 - p.iter().map(|c| (c - 0.5) * (c - 0.5)).sum::<f32>()
}

/// Waves whose crests are some cells apart.
fn waves([x, y, z]: [f32; 3]) -> f32 {
    let wave = |c: f32| (c * 20.0).sin();
    wave(x + 0.3 * y) + wave(y + 0.3 * z) + wave(z + 0.3 * x)
}

#[library_benchmark]
#[bench::empty(prepared(empty, &[0.0], PLAIN))]
#[bench::sphere(prepared(sphere, &[0.0], PLAIN))]
#[bench::waves(prepared(waves, &[0.0], PLAIN))]
#[bench::closed(prepared(waves, &[0.0], PLAIN.with_boundary(Boundary::Closed)))]
#[bench::trilinear(prepared(waves, &[0.0], PLAIN.with_topology(Topology::Trilinear)))]
#[bench::cubic(prepared(waves, &[0.0], PLAIN.with_placement(Placement::Cubic)))]
#[bench::quintic(prepared(waves, &[0.0], PLAIN.with_placement(Placement::Quintic)))]
#[bench::matching(prepared(
    waves,
    &[0.0],
    PLAIN.with_placement(Placement::Quintic).with_gradient(Gradient::Matching)
))]
#[bench::defaults(prepared(waves, &[0.0], ExtractOptions::DEFAULT))]
#[bench::four_values(prepared(sphere, &[0.0, 0.03, 0.06, 0.09], PLAIN))]
fn warm(mut work: Work) -> (Vec<Counts>, Work) {
    // The work comes back, so that dropping it is not counted.
    (black_box(extracted(&mut work)), work)
}

#[library_benchmark]
#[bench::sphere(prepared(sphere, &[0.1], PLAIN))]
#[bench::waves(prepared(waves, &[2.9], PLAIN))]
fn with_bricks(mut work: Work) -> (Vec<Counts>, Work) {
    let Work { volume, bricks, isos, options, meshes } = &mut work;
    let source = Source::with_bricks(&volume.view(), bricks).expect("its own bricks");
    (black_box(of_source(source, isos, options, meshes)), work)
}

#[library_benchmark]
#[bench::waves(prepared(waves, &[0.0], PLAIN))]
fn bricks(work: Work) -> (Bricks<f32>, Work) {
    (black_box(Bricks::of(&work.volume.view(), &Job::default()).expect("bricks")), work)
}

#[library_benchmark]
#[bench::sphere(prepared(sphere, &[0.0], PLAIN))]
#[bench::waves(prepared(waves, &[0.0], PLAIN))]
#[bench::two_values(prepared(waves, &[0.0, 0.5], PLAIN))]
fn slabs(mut work: Work) -> Work {
    let Work { volume, isos, options, meshes, .. } = &mut work;
    let budget = Budget { window: 16, piece_bytes: u64::MAX };
    let slabs = Slabs { isos, options, budget };
    let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
    let mut source = Slices::new(volume.view());
    extract_slabs(&mut source, &slabs, &mut sinks, &Job::default()).expect("surfaces");
    drop(sinks);
    black_box(work)
}

library_benchmark_group!(name = extraction, benchmarks = [warm, with_bricks, bricks, slabs]);
main!(
    config = LibraryBenchmarkConfig::default().env("ISOKIT_SIMD", "avx2"),
    library_benchmark_groups = extraction
);
