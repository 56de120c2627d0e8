//! Times of an extraction and of its parts, on a sparse and on a dense surface.
//!
//! `cargo bench -p isokit-marching-cubes --bench passes`. One thread: what is compared is the work.
//! `scripts/bench` compares with other programs.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use isokit_job::{Job, Threads};
use isokit_marching_cubes::{
    Boundary, Budget, Diagonals, ExtractOptions, Gradient, Placement, Slabs, Source, Topology,
    count, count_many, extract_into, extract_many, extract_slabs,
};
use isokit_mesh::TriMesh;
use isokit_volume::{Bricks, Grid, Slices, Volume};
use std::{f64::consts::PI, hint::black_box, num::NonZeroUsize};

/// A ball that fills most of the cube: few cells hold the surface.
fn sphere(n: usize) -> Volume<f32> {
    let middle = (n - 1) as f64 / 2.0;
    sampled(n, |p| {
        let square: f64 = p.iter().map(|c| (c - middle) * (c - middle)).sum();
        0.4 * n as f64 - square.sqrt()
    })
}

/// Six periods across the cube: many cells hold the surface.
fn gyroid(n: usize) -> Volume<f32> {
    let waves: Vec<_> = (0..n).map(|i| (12.0 * PI * i as f64 / n as f64).sin_cos()).collect();
    sampled(n, |p| {
        let [(sx, cx), (sy, cy), (sz, cz)] = p.map(|c| waves[c as usize]);
        sx * cy + sy * cz + sz * cx
    })
}

fn sampled(n: usize, value: impl Fn([f64; 3]) -> f64) -> Volume<f32> {
    let grid = Grid::new([n as u64; 3], Default::default()).expect("a lattice");
    let place = |i: usize| [i % n, i / n % n, i / n / n].map(|c| c as f64);
    let samples = (0..n * n * n).map(|i| value(place(i)) as f32).collect();
    Volume::new(grid, samples).expect("one sample per point")
}

fn passes(criterion: &mut Criterion) {
    let one = Threads::new(NonZeroUsize::MIN).expect("a thread");
    let job = Job { threads: one, ..Job::default() };
    let options =
        ExtractOptions::DEFAULT.with_topology(Topology::Table).with_placement(Placement::Linear);
    let options = options.with_boundary(Boundary::Open);
    for (name, make) in [("sphere", sphere as fn(usize) -> _), ("gyroid", gyroid)] {
        let mut group = criterion.benchmark_group(name);
        group.sample_size(10);
        for n in [128, 256] {
            let volume = make(n);
            let view = volume.view();
            group.throughput(Throughput::Elements((n * n * n) as u64));
            group.bench_function(BenchmarkId::new("count", n), |bencher| {
                bencher.iter(|| count(black_box(&view), 0.0, &options, &job));
            });
            let isos: Vec<f64> = (-4..4).map(|k| 0.2 * f64::from(k)).collect();
            group.bench_function(BenchmarkId::new("count of 8", n), |bencher| {
                bencher.iter(|| count_many(black_box(&view), &isos, &options, &job));
            });
            for (with, empty) in
                [("normals", TriMesh::with_normals()), ("no normals", TriMesh::default())]
            {
                let extract = |mesh: &mut TriMesh| {
                    extract_into(black_box(&view), 0.0, &options, &mut mesh.refill(), &job)
                        .expect("a surface");
                };
                group.bench_function(BenchmarkId::new(format!("cold, {with}"), n), |bencher| {
                    // What comes out is dropped off the clock.
                    bencher.iter_with_large_drop(|| {
                        let mut mesh = empty.clone();
                        extract(&mut mesh);
                        mesh
                    });
                });
                let mut kept = empty.clone();
                group.bench_function(BenchmarkId::new(format!("warm, {with}"), n), |bencher| {
                    bencher.iter(|| extract(&mut kept));
                });
            }
        }
        group.finish();
    }
}

/// Samples along an axis where choices are compared.
const N: usize = 128;

/// Each choice alone against the plainest, into memory that was used before.
fn choices(criterion: &mut Criterion) {
    let one = Threads::new(NonZeroUsize::MIN).expect("a thread");
    let job = Job { threads: one, ..Job::default() };
    let plain = ExtractOptions::DEFAULT
        .with_topology(Topology::Table)
        .with_placement(Placement::Linear)
        .with_boundary(Boundary::Open);
    let quintic = plain.clone().with_placement(Placement::Quintic);
    for (name, make) in [("sphere", sphere as fn(usize) -> _), ("gyroid", gyroid)] {
        let mut group = criterion.benchmark_group(format!("{name}, choices"));
        group.sample_size(10);
        group.throughput(Throughput::Elements((N * N * N) as u64));
        let volume = make(N);
        let view = volume.view();
        let mut kept = TriMesh::with_normals();
        for (choice, options) in [
            ("plain", plain.clone()),
            ("closed", plain.clone().with_boundary(Boundary::Closed)),
            ("trilinear", plain.clone().with_topology(Topology::Trilinear)),
            ("fitted", plain.clone().with_diagonals(Diagonals::Fitted)),
            ("cubic", plain.clone().with_placement(Placement::Cubic)),
            ("quintic", quintic.clone()),
            ("quintic, matching normals", quintic.clone().with_gradient(Gradient::Matching)),
            ("defaults", ExtractOptions::DEFAULT),
        ] {
            group.bench_function(BenchmarkId::new(choice, N), |bencher| {
                bencher.iter(|| {
                    extract_into(black_box(&view), 0.0, &options, &mut kept.refill(), &job)
                });
            });
        }
        let slabs = Slabs {
            isos: &[0.0],
            options: &plain,
            budget: Budget { window: 32, piece_bytes: u64::MAX },
        };
        group.bench_function(BenchmarkId::new("slabs", N), |bencher| {
            bencher.iter(|| {
                let mut source = Slices::new(black_box(view));
                extract_slabs(&mut source, &slabs, &mut vec![kept.refill()], &job)
            });
        });
        group.bench_function(BenchmarkId::new("bricks made", N), |bencher| {
            bencher.iter(|| Bricks::of(black_box(&view), &job));
        });
        let bricks = Bricks::of(&view, &job).expect("bricks");
        let source = Source::with_bricks(&view, &bricks).expect("its own bricks");
        // Near the greatest value, where the surface is small.
        let iso = if name == "sphere" { 0.3 * N as f64 } else { 1.49 };
        for (how, source) in [("with bricks", source), ("without bricks", Source::from(&view))] {
            group.bench_function(BenchmarkId::new(format!("little surface {how}"), N), |bencher| {
                bencher.iter(|| {
                    let sinks = &mut [kept.refill()];
                    extract_many(black_box(source), &[iso], &plain, sinks, &job)
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, passes, choices);
criterion_main!(benches);
