//! Times of the loops over rows, on one thread and in memory that is in the caches.
//!
//! `cargo bench -p isokit-lanes --bench kernels`. A process runs the widest loops that its machine has;
//! `ISOKIT_SIMD=portable|avx2|avx512` in the environment holds it to one level.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use isokit_lanes::{
    BitRows, CaseTable, Edges, Field, FirstVertices, Lane, Level, RowCounts, Samples, Threshold,
    Thresholds, Vertices, Word, count_rows, signs_of_many, triangles, vertices, words,
    words_of_rows,
};
use std::hint::black_box;

/// Samples per row, and rows: 512 KiB of f32, which a second level of cache holds.
const ROW: usize = 512;
const ROWS: usize = 256;

/// Numbers without a pattern, the same every time.
fn chance() -> impl FnMut() -> u64 {
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    }
}

/// The bits of samples, against the mere reading of them.
fn signs_of<T: Lane>(criterion: &mut Criterion, name: &str, sample: fn(u64) -> T, bound: T) {
    let mut group = criterion.benchmark_group(format!("signs/{}", Level::current()));
    let mut chance = chance();
    let samples: Vec<T> = (0..ROW * ROWS).map(|_| sample(chance())).collect();
    let mut bits = vec![0; words(ROW)];
    let threshold = Thresholds::new(&[Threshold::AtLeast(bound)]).expect("a bound");
    group.throughput(Throughput::Bytes(size_of_val(&samples[..]) as u64));
    group.bench_function(BenchmarkId::new("signs", name), |bencher| {
        bencher.iter(|| {
            for row in samples.chunks_exact(ROW) {
                signs_of_many(black_box(row), &threshold, black_box(&mut bits), words(ROW));
            }
        });
    });
    // As words, whatever the samples are: how fast bytes come does not depend on what they mean.
    let words: Vec<u64> = (0..size_of_val(&samples[..]) / 8).map(|_| chance()).collect();
    group.bench_function(BenchmarkId::new("read", name), |bencher| {
        bencher.iter(|| sum(black_box(&words)));
    });
    group.finish();
}

/// Sums 32 words side by side, so that no addition waits for the one before.
fn sum(words: &[u64]) -> [u64; 32] {
    let (chunks, _) = words.as_chunks::<32>();
    chunks.iter().fold([0; 32], |mut sums, chunk| {
        sums.iter_mut().zip(chunk).for_each(|(sum, word)| *sum = sum.wrapping_add(*word));
        sums
    })
}

fn every_type(criterion: &mut Criterion) {
    signs_of(criterion, "u8", |n| n as u8, 99);
    signs_of(criterion, "i8", |n| n as i8, 9);
    signs_of(criterion, "u16", |n| n as u16, 999);
    signs_of(criterion, "i16", |n| n as i16, 99);
    signs_of(criterion, "u32", |n| n as u32, 99_999);
    signs_of(criterion, "i32", |n| n as i32, 9_999);
    signs_of(criterion, "f32", |n| n as i32 as f32, 0.5);
    signs_of(criterion, "f64", |n| n as i64 as f64, 0.5);
}

/// Five rows of bits in runs of the given length, as a surface leaves them.
fn slice_in_runs(run: u64) -> Vec<u64> {
    let mut chance = chance();
    let mut row = || -> Vec<u64> {
        let mut inside = false;
        let mut left = 0;
        let mut bit = || {
            if left == 0 {
                (inside, left) = (!inside, 1 + chance() % (2 * run));
            }
            left -= 1;
            u64::from(inside)
        };
        (0..words(ROW)).map(|_| (0..64).fold(0, |word, i| word | bit() << i)).collect()
    };
    (0..5).flat_map(|_| row()).collect()
}

/// Counting and making the triangles of rows that are dense, and less so.
fn cells(criterion: &mut Criterion) {
    let mut table = CaseTable { counts: [0; 256], edges: [[0; 16]; 256] };
    for case in 1..255 {
        // The usual number, of some edges: which ones costs nothing.
        table.counts[case] = 2 + (case % 3) as u8;
        table.edges[case] = std::array::from_fn(|n| ((case + 5 * n) % 12) as u8);
    }
    let mut group = criterion.benchmark_group(format!("cells/{}", Level::current()));
    for run in [2, 16] {
        let (low, high) = (slice_in_runs(run), slice_in_runs(run));
        let bits = BitRows::new(&low, Some(&high), ROW);
        let (mut found, mut counts) = (vec![], [RowCounts::default(); 4]);
        words_of_rows(&bits, 0..4, &mut found);
        count_rows(&bits, 0..4, &mut counts);
        let total: u32 = counts.iter().map(|row| row.triangles).sum();
        group.throughput(Throughput::Elements(total.into()));
        group.bench_function(BenchmarkId::new("count", run), |bencher| {
            bencher.iter(|| count_rows(black_box(&bits), 0..4, &mut counts));
        });
        group.bench_function(BenchmarkId::new("words", run), |bencher| {
            bencher.iter(|| words_of_rows(black_box(&bits), 0..4, &mut found));
        });
        let mut out = vec![[0; 3]; total as usize + 64];
        group.bench_function(BenchmarkId::new("triangles", run), |bencher| {
            bencher.iter(|| {
                triangles(black_box(&found), |_| FirstVertices::default(), &table, &mut out)
            });
        });
    }
    group.finish();
}

/// Placing vertices, with their normals and without.
fn crossings(criterion: &mut Criterion) {
    const N: usize = 64;
    let plane = |n: usize| (n % N + n / N % N + n / N / N) as f32;
    let all: Vec<f32> = (0..N * N * N).map(plane).collect();
    let samples = Samples::new(&all, 0, [1, N as isize, (N * N) as isize], [N; 3])
        .expect("the samples are there");
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let field = Field {
        iso: 94.5,
        slope: 1.0,
        intercept: 0.0,
        reach: 0.5 - 1.0 / 1024.0,
        columns: unit,
        origin: [0.0; 3],
        first_slice: 0.0,
        covectors: unit,
    };
    let mut edges = Edges::default();
    edges.begin(32);
    for (y, axis) in (1..62_u32).flat_map(|y| (0..3).map(move |axis| (y, axis))) {
        // On the plane where the three numbers sum up to 94.
        let word = Word { cuts: [1 << (62 - y); 8], ..Word::default() };
        edges.push(&[axis], [0, y], &[word]);
    }
    let mut positions = vec![[0_f32; 3]; edges.len()];
    let mut normals = vec![[0.0; 3]; edges.len()];
    let mut odd = vec![];
    let mut group = criterion.benchmark_group(format!("vertices/{}", Level::current()));
    group.throughput(Throughput::Elements(edges.len() as u64));
    for (name, with_normals) in [("normals", true), ("no normals", false)] {
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let normals = with_normals.then_some(&mut normals[..]);
                let out = Vertices { positions: &mut positions, normals, odd: &mut odd };
                vertices(&samples, &field, black_box(&edges), out);
            });
        });
    }
    group.finish();
}

criterion_group!(benches, every_type, cells, crossings);
criterion_main!(benches);
