//! Instructions that it takes to bring a surface nearer to its field, counted by Valgrind.
//!
//! `scripts/instructions` runs it and compares with the counts that are kept; by hand it is
//! `cargo bench -p isokit-refine --bench instructions`. What Valgrind and `gungraun` are for, and which code is
//! counted, is said in the benchmark of the same name of `isokit-marching-cubes`.

#![expect(missing_docs, reason = "the macros that make a benchmark document nothing")]

use gungraun::{LibraryBenchmarkConfig, library_benchmark, library_benchmark_group, main};
use isokit_field::Sampled;
use isokit_job::Job;
use isokit_marching_cubes::{ExtractOptions, Gradient, Placement, extract};
use isokit_mesh::TriMesh;
use isokit_refine::{Isosurface, RefineOptions, Refined, Subdivision, refine};
use isokit_volume::{Grid, Volume};
use rayon::ThreadPoolBuilder;
use std::hint::black_box;

/// Points along an axis.
const N: usize = 24;

/// A ball with waves on it, and its surface.
fn prepared() -> (Volume<f32>, TriMesh) {
    // Only this thread is counted, so it does all the work.
    let here = ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    here.build_global().expect("no pool before");
    let grid = Grid::new([N as u64; 3], Default::default()).expect("a lattice");
    let value = |i: usize| {
        let place = [i % N, i / N % N, i / N / N].map(|c| c as f32 - 11.7);
        let radius = place.iter().map(|c| c * c).sum::<f32>().sqrt();
        8.0 - radius + (0.9 * place[0]).sin() * (0.7 * place[1]).cos()
    };
    let volume = Volume::new(grid, (0..N.pow(3)).map(value).collect()).expect("a sample per point");
    let options =
        ExtractOptions::DEFAULT.with_placement(Placement::Cubic).with_gradient(Gradient::Matching);
    let mesh = extract(&volume.view(), 0.0, &options, &Job::default()).expect("a surface");
    (volume, mesh)
}

#[library_benchmark]
#[bench::one_level(prepared(), RefineOptions::default().with_subdivision(Subdivision::Levels(1)))]
#[bench::max_error(prepared(), RefineOptions::default().with_subdivision(Subdivision::MaxError(0.01)))]
#[bench::balance(prepared(), RefineOptions::default().with_balance(true))]
fn refined(
    (volume, mut mesh): (Volume<f32>, TriMesh),
    options: RefineOptions,
) -> (Refined, Volume<f32>, TriMesh) {
    let field = Sampled::new(volume.view());
    let surface = Isosurface { field: &field, iso: 0.0 };
    let done = refine(&mut mesh, &surface, &options, &Job::default()).expect("a surface");
    // All come back, so that dropping them is not counted.
    (black_box(done), volume, mesh)
}

library_benchmark_group!(name = refinement, benchmarks = [refined]);
main!(
    config = LibraryBenchmarkConfig::default().env("ISOKIT_SIMD", "avx2"),
    library_benchmark_groups = refinement
);
