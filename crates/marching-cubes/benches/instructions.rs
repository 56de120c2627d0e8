//! Instructions that an extraction takes, counted by Valgrind: a regression shows at once, on any
//! machine, however busy.
//!
//! `cargo bench -p isokit-marching-cubes --bench instructions`, with Valgrind and the `gungraun-runner`
//! of the same version as `gungraun`. Valgrind knows no AVX-512, so the counts are of narrower code.

#![expect(missing_docs, reason = "the macros that make a benchmark document nothing")]

use gungraun::{library_benchmark, library_benchmark_group, main};
use isokit_job::Job;
use isokit_marching_cubes::{Boundary, ExtractOptions, Placement, Topology, extract_into};
use isokit_mesh::{Counts, TriMesh};
use isokit_volume::{Grid, Volume};
use rayon::ThreadPoolBuilder;
use std::hint::black_box;

/// Points along an axis: more than a word of 64.
const N: usize = 80;

struct Work {
    volume: Volume<f32>,
    mesh: TriMesh,
}

/// A volume, and a mesh that is large enough already.
fn prepared(value: fn([f32; 3]) -> f32) -> Work {
    // Only this thread is counted, so it does all the work.
    let here = ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    here.build_global().expect("no pool before");
    let grid = Grid::new([N as u64; 3], Default::default()).expect("a lattice");
    let place = |i: usize| [i % N, i / N % N, i / N / N].map(|c| c as f32 / (N - 1) as f32);
    let samples = (0..N * N * N).map(|i| value(place(i))).collect();
    let volume = Volume::new(grid, samples).expect("one sample per point");
    let mut work = Work { volume, mesh: TriMesh::with_normals() };
    extracted(&mut work);
    work
}

fn extracted(work: &mut Work) -> Counts {
    let options =
        ExtractOptions::DEFAULT.with_topology(Topology::Table).with_placement(Placement::Linear);
    let options = options.with_boundary(Boundary::Open);
    let view = work.volume.view();
    let done = extract_into(&view, 0.0, &options, &mut work.mesh.refill(), &Job::default());
    done.expect("a surface").counts
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
#[bench::empty(prepared(empty))]
#[bench::sphere(prepared(sphere))]
#[bench::waves(prepared(waves))]
fn warm(mut work: Work) -> (Counts, Work) {
    // The work comes back, so that dropping it is not counted.
    (black_box(extracted(&mut work)), work)
}

library_benchmark_group!(name = extraction, benchmarks = [warm]);
main!(library_benchmark_groups = extraction);
