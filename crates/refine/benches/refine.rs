//! Times of bringing a surface nearer to its field, by each of the ways.
//!
//! `cargo bench -p isokit-refine --bench refine`. One thread: what is compared is the work.

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use isokit_field::Sampled;
use isokit_job::{Job, Threads};
use isokit_marching_cubes::{ExtractOptions, Gradient, Placement, extract};
use isokit_refine::{Isosurface, RefineOptions, Subdivision, refine};
use isokit_volume::{Grid, Volume};
use std::num::NonZeroUsize;

/// A ball with waves on it.
fn waves(n: usize) -> Volume<f32> {
    let grid = Grid::new([n as u64; 3], Default::default()).expect("a lattice");
    let middle = n as f32 / 2.0;
    let value = |i: usize| {
        let place = [i % n, i / n % n, i / n / n].map(|c| c as f32 - middle);
        let radius = place.iter().map(|c| c * c).sum::<f32>().sqrt();
        0.35 * n as f32 - radius + (0.4 * place[0]).sin() * (0.3 * place[1]).cos()
    };
    Volume::new(grid, (0..n.pow(3)).map(value).collect()).expect("a sample per point")
}

fn ways(criterion: &mut Criterion) {
    let one = Threads::new(NonZeroUsize::MIN).expect("a thread");
    let job = Job { threads: one, ..Job::default() };
    let placed = ExtractOptions::DEFAULT.with_placement(Placement::Cubic);
    let placed = placed.with_gradient(Gradient::Matching);
    let plain = RefineOptions::default();
    let mut group = criterion.benchmark_group("waves");
    group.sample_size(10);
    for n in [64, 128] {
        let volume = waves(n);
        let field = Sampled::new(volume.view());
        let surface = Isosurface { field: &field, iso: 0.0 };
        let mesh = extract(&volume.view(), 0.0, &placed, &job).expect("a surface");
        group.throughput(Throughput::Elements(mesh.triangles.len() as u64));
        for (name, options) in [
            ("one level", plain.with_subdivision(Subdivision::Levels(1))),
            ("max error", plain.with_subdivision(Subdivision::MaxError(0.01))),
            ("balance", plain.with_balance(true)),
        ] {
            group.bench_function(BenchmarkId::new(name, n), |bencher| {
                bencher.iter_batched_ref(
                    || mesh.clone(),
                    |mesh| refine(mesh, &surface, &options, &job).expect("a surface"),
                    BatchSize::LargeInput,
                );
            });
        }
    }
    group.finish();
}

criterion_group!(benches, ways);
criterion_main!(benches);
