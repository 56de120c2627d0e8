//! The sweep against the passes, which several isovalues at once go through.

use crate::{
    Boundary, Degenerate, Diagonals, ExtractError, ExtractOptions, Gradient, Nan, Placement,
    Skipped, Source, Topology, extract, extract_into, extract_many,
};
use isokit_geom::Frame;
use isokit_job::{Job, Limits, Stopped, Threads};
use isokit_mesh::{Counts, MeshSink, Piece, Positions, Precision, TriMesh};
use isokit_volume::{Bricks, Grid, Sample, View, Volume};
use proptest::prelude::*;
use std::{convert::Infallible, num::NonZeroUsize};

fn job(threads: usize) -> Job {
    let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
    Job { threads, ..Job::default() }
}

/// A mesh that holds so much that means nothing.
fn used(vertices: usize, triangles: usize, precision: Precision) -> TriMesh {
    let positions = match precision {
        Precision::F32 => Positions::F32(vec![[7.5; 3]; vertices]),
        Precision::F64 => Positions::F64(vec![[7.5; 3]; vertices]),
    };
    let (normals, triangles) = (Some(vec![[0.5; 3]; vertices]), vec![[9; 3]; triangles]);
    TriMesh { positions, normals, triangles, ..TriMesh::default() }
}

/// What the passes make.
fn by_passes<T: Sample>(view: &View<'_, T>, iso: f64, options: &ExtractOptions) -> TriMesh {
    let mut meshes = [TriMesh::with_normals(), TriMesh::with_normals()];
    let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
    extract_many(view, &[iso; 2], options, &mut sinks, &Job::default()).unwrap();
    drop(sinks);
    let [mesh, same] = meshes;
    assert!(mesh == same);
    mesh
}

/// Into new memory and into used memory of all sizes, on one thread and on several.
#[track_caller]
fn check<T: Sample>(view: &View<'_, T>, iso: f64, options: &ExtractOptions) {
    let expected = by_passes(view, iso, options);
    for threads in 1..4 {
        let new = extract(view, iso, options, &job(threads)).unwrap();
        assert!(new == expected, "{:?}, {iso}, on {threads} threads, {options:?}", view.dims());
        assert_eq!(new.triangles.capacity(), new.triangles.len());
    }
    let told = extract_into(view, iso, options, &mut TriMesh::with_normals().refill(), &job(1));
    let (vertices, triangles) = (expected.positions.len(), expected.triangles.len());
    let sizes = [
        (vertices, triangles),
        (2 * vertices + 9, triangles),
        (vertices / 2, 2 * triangles + 9),
        (vertices.max(1) - 1, triangles),
        (vertices, triangles / 3),
    ];
    for (threads, (vertices, triangles)) in (0..).map(|n| 1 + n % 3).zip(sizes.repeat(2)) {
        for precision in [Precision::F32, Precision::F64] {
            let mut mesh = used(vertices, triangles, precision);
            let mut refill = mesh.refill();
            let found = extract_into(view, iso, options, &mut refill, &job(threads));
            assert_eq!(found, told, "{options:?}");
            drop(refill);
            let place = format!("{vertices} {triangles} on {threads} threads, {options:?}");
            assert!(mesh == expected, "{:?}, {iso}, into {place}", view.dims());
        }
    }
    for (threads, (vertices, triangles)) in (0..).map(|n| 1 + n % 3).zip(sizes) {
        let mut mesh = used(vertices, triangles, Precision::F32);
        with_bricks(view, iso, options, &mut [&mut mesh], &job(threads));
        let place = format!("{vertices} {triangles} on {threads} threads, {options:?}");
        assert!(mesh == expected, "{:?}, {iso}, with bricks, into {place}", view.dims());
    }
}

/// The surface where bricks tell that it may be, into each of some meshes.
fn with_bricks<T: Sample>(
    view: &View<'_, T>,
    iso: f64,
    options: &ExtractOptions,
    meshes: &mut [&mut TriMesh],
    job: &Job,
) -> Skipped {
    let bricks = Bricks::of(view, job).unwrap();
    let source = Source::with_bricks(view, &bricks).unwrap();
    let isos = vec![iso; meshes.len()];
    let mut sinks: Vec<_> = meshes.iter_mut().map(|mesh| mesh.refill()).collect();
    extract_many(source, &isos, options, &mut sinks, job).unwrap()[0].skipped
}

/// All choices; of those that share any one of them half have fitted diagonals.
fn all_options() -> Vec<ExtractOptions> {
    let mut all = vec![];
    for boundary in [Boundary::Closed, Boundary::Open] {
        for topology in [Topology::Table, Topology::Trilinear] {
            for (placement, gradient) in [
                (Placement::Linear, Gradient::Central),
                (Placement::Cubic, Gradient::Matching),
                (Placement::Quintic, Gradient::Central),
                (Placement::Quintic, Gradient::Matching),
            ] {
                for degenerate in [Degenerate::Never, Degenerate::Exact] {
                    let is_fitted = all.len().count_ones() % 2 == 1;
                    let diagonals = [Diagonals::Table, Diagonals::Fitted][usize::from(is_fitted)];
                    let options = ExtractOptions::DEFAULT.with_diagonals(diagonals);
                    let options = options.with_boundary(boundary);
                    let options = options.with_topology(topology).with_placement(placement);
                    all.push(options.with_gradient(gradient).with_degenerate(degenerate));
                }
            }
        }
    }
    all
}

fn volume<T: Sample>(dims: [u64; 3], sample: impl FnMut(u64) -> T) -> Volume<T> {
    let grid = Grid::new(dims, Frame::default()).unwrap();
    Volume::new(grid, (0..grid.count()).map(sample).collect()).unwrap()
}

/// Numbers without a pattern.
fn chance(n: u64) -> u64 {
    let mixed = (n + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    (mixed ^ mixed >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 40
}

#[test]
fn a_ball_is_the_same_in_used_memory() {
    for options in all_options() {
        let dims = [20, 17, 40];
        let ball = volume(dims, |n| {
            let ijk = [n % 20, n / 20 % 17, n / 340].map(|i| i as f64);
            let from = [ijk[0] - 9.5, ijk[1] - 8.0, (ijk[2] - 19.0) / 2.0];
            (7.3 - from.iter().map(|c| c * c).sum::<f64>().sqrt()) as f32
        });
        check(&ball.view(), 0.0, &options);
        check(&ball.view(), 1e9, &options);
    }
}

#[test]
fn slabs_of_which_bricks_tell_that_they_are_empty_or_full_leave_the_others_as_they_are() {
    // Full below, then nothing, a ball, nothing, a ball of nothing in what is full, nothing.
    let sample = |n: u64| {
        let [i, j, k] = [n % 70, n / 70 % 30, n / 2100].map(|i| i as f64);
        let is_near = |z: f64| (i - 40.0).powi(2) + (j - 14.5).powi(2) + (k - z).powi(2) < 20.0;
        u8::from(match k as u64 {
            0..30 => true,
            60..160 => is_near(110.0),
            160..240 => !is_near(200.5),
            _ => false,
        })
    };
    let volume = volume([70, 30, 290], sample);
    for options in all_options() {
        let (view, expected) = (volume.view(), by_passes(&volume.view(), 0.5, &options));
        assert!(!expected.triangles.is_empty());
        let [mut one, mut other] = [TriMesh::with_normals(), TriMesh::with_normals()];
        let meshes = &mut [&mut one, &mut other];
        let by_passes = with_bricks(&view, 0.5, &options, meshes, &job(1));
        assert!(one == expected && other == expected, "{options:?}");
        let (vertices, triangles) = (expected.positions.len(), expected.triangles.len());
        // All fits, and all but what comes last.
        let sizes = [(vertices, triangles), (vertices - 1, triangles)];
        for (threads, (vertices, triangles)) in (1..4).flat_map(|n| sizes.map(|size| (n, size))) {
            let mut mesh = used(vertices, triangles, Precision::F32);
            let skipped = with_bricks(&view, 0.5, &options, &mut [&mut mesh], &job(threads));
            assert!(mesh == expected, "{vertices} on {threads} threads, {options:?}");
            assert_eq!(skipped, by_passes);
            assert!(skipped.samples_read < 70 * 30 * 100, "{skipped:?}");
        }
    }
}

#[test]
fn chance_and_ties_are_the_same_in_used_memory_whatever_the_shape() {
    let shapes = [
        [1, 1, 1],
        [3, 3, 1],
        [2, 2, 2],
        [66, 3, 5],
        [5, 4, 33],
        [63, 2, 19],
        [64, 4, 9],
        [3, 64, 18],
    ];
    for (shape, dims) in shapes.into_iter().enumerate() {
        for (n, options) in all_options().into_iter().enumerate() {
            // Ties for half of the options that share any one choice, and for the others in the next shape.
            match (shape as u32 + (n & 0b10101).count_ones()).is_multiple_of(2) {
                true => check(&volume(dims, |n| (chance(n) % 5) as u8).view(), 2.0, &options),
                false => check(&volume(dims, |n| chance(n) as f64).view(), 3e6, &options),
            }
        }
    }
}

#[test]
fn slices_larger_than_a_slab_are_the_same_in_used_memory() {
    // Slabs of one slice; then, on one thread, of two.
    let large = volume([640, 600, 5], |n| (chance(n / 37) % 7) as f32);
    check(&large.view(), 3.0, &ExtractOptions::DEFAULT);
    let large = volume([300, 220, 17], |n| (chance(n / 37) % 7) as f64);
    check(&large.view(), 3.0, &ExtractOptions::DEFAULT);
    // Slices that are filled two at a time, band by band.
    let large = volume([700, 400, 17], |n| (chance(n / 900) % 64 / 62) as f64);
    check(&large.view(), 0.5, &ExtractOptions::DEFAULT);
}

#[test]
fn large_surfaces_are_the_same_in_new_memory_of_whatever_size_is_allowed() {
    let options = ExtractOptions::DEFAULT;
    for values in [2, 900] {
        let volume = volume([101, 80, 90], |n| (chance(n / 7) % values) as u16);
        let (view, iso) = (volume.view(), values as f64 / 2.0);
        check(&view, iso, &options);
        let expected = by_passes(&view, iso, &options);
        let limits = Limits { bytes: 100_000_000 };
        let little = extract(&view, iso, &options, &Job { limits, ..job(2) }).unwrap();
        assert!(little == expected);
    }
    let hole = |n| if n == 700_000 { f32::NAN } else { (chance(n / 7) % 5) as f32 };
    let volume = volume([101, 80, 90], hole);
    for nan in [Nan::Outside, Nan::Mask] {
        check(&volume.view(), 2.0, &options.clone().with_nan(nan));
    }
}

#[test]
fn a_surface_that_new_memory_does_not_suffice_for_is_the_same() {
    // A vertex on every edge: more than a quarter of 2²⁴.
    let volume = volume([130, 130, 130], |n| (n % 130 + n / 130 % 130 + n / 16_900) as u8 % 2);
    let options = ExtractOptions::DEFAULT.with_boundary(Boundary::Open);
    let expected = by_passes(&volume.view(), 0.5, &options);
    assert!(expected.positions.len() > 1 << 22);
    let new = extract(&volume.view(), 0.5, &options, &job(2)).unwrap();
    assert!(new == expected);
}

/// A mesh that tells what it was said to be likely.
struct Told(TriMesh, Option<Counts>);

impl MeshSink for Told {
    type Error = Infallible;

    fn wants_normals(&self) -> bool {
        true
    }

    fn piece(&mut self, counts: Counts, precision: Precision) -> Result<Piece<'_>, Infallible> {
        Ok(self.0.renew(counts, precision))
    }

    fn spare(&mut self, likely: Counts, _: Precision) -> Option<Piece<'_>> {
        self.1 = Some(likely);
        None
    }
}

#[test]
#[cfg(all(target_os = "linux", target_pointer_width = "64"))]
fn new_memory_is_offered_for_large_volumes_where_it_is_allowed_and_of_use() {
    let likely = |dims, bytes, nan| {
        let volume = volume(dims, |n| n as f32);
        let options = ExtractOptions::DEFAULT.with_nan(nan);
        let (mut told, limits) = (Told(TriMesh::with_normals(), None), Limits { bytes });
        extract_into(&volume.view(), 9.5, &options, &mut told, &Job { limits, ..job(1) }).unwrap();
        told.1.unwrap_or_default() != Counts::default()
    };
    assert!(likely([101, 80, 90], u64::MAX, Nan::Outside));
    assert!(likely([101, 80, 90], u64::MAX, Nan::Error));
    assert!(!likely([101, 80, 90], u64::MAX, Nan::Mask), "one NaN, and all is done again");
    assert!(!likely([101, 80, 90], 200_000_000, Nan::Outside), "it is not allowed");
    assert!(!likely([50, 40, 45], u64::MAX, Nan::Outside), "the samples stay in the cache");
}

#[test]
fn samples_in_any_order_are_the_same_in_used_memory() {
    let samples: Vec<i16> = (0..4000).map(|n| (chance(n) % 9) as i16).collect();
    let grid = Grid::new([10, 8, 20], Frame::default()).unwrap();
    for (first, strides) in [(0, [1, 10, 80]), (1999, [-1, -10, -80]), (5, [160, 1, 8])] {
        let view = View::strided(&samples, first, strides, &grid).unwrap();
        check(&view, 4.0, &ExtractOptions::DEFAULT);
    }
}

#[test]
fn samples_without_a_value_are_the_same_in_used_memory_and_forbidden_ones_an_error() {
    let of = |boundary| ExtractOptions::DEFAULT.with_boundary(boundary);
    for (holes, dims, options) in [
        (5, [9, 8, 24], of(Boundary::Closed)),
        (700, [9, 8, 24], of(Boundary::Closed)),
        (5, [64, 3, 9], of(Boundary::Open)),
        (700, [64, 3, 9], of(Boundary::Open)),
    ] {
        let sample = |n| match chance(n) % holes {
            0 => f32::NAN,
            _ => (chance(n) % 11) as f32,
        };
        let volume = volume(dims, sample);
        for nan in [Nan::Outside, Nan::Mask] {
            check(&volume.view(), 5.0, &options.clone().with_nan(nan));
        }
        let options = options.clone().with_nan(Nan::Error);
        let mut mesh = used(9000, 9000, Precision::F32);
        let found = extract_into(&volume.view(), 5.0, &options, &mut mesh.refill(), &job(2));
        let count = volume.samples().iter().filter(|sample| sample.is_nan()).count() as u64;
        assert!(matches!(found, Err(ExtractError::Nan { count: n, .. }) if n == count));
    }
}

#[test]
fn who_cancels_or_allows_too_little_is_heard() {
    let volume = volume([8, 8, 30], |n| (chance(n) % 5) as u8);
    let into_used = |job: &Job| {
        let mut mesh = used(90_000, 90_000, Precision::F32);
        let options = &ExtractOptions::DEFAULT;
        extract_into(&volume.view(), 2.0, options, &mut mesh.refill(), job).unwrap_err()
    };
    let cancelled = job(2);
    cancelled.cancel.cancel();
    assert!(matches!(into_used(&cancelled), ExtractError::Stopped(Stopped::Cancelled(_))));
    let small = Job { limits: Limits { bytes: 1000 }, ..job(2) };
    let ExtractError::Stopped(Stopped::OverLimit(over)) = into_used(&small) else {
        panic!("1000 bytes are too few");
    };
    assert_ne!(over.what, "surface", "it is known before anything is made");
}

#[test]
fn where_slabs_take_more_than_is_allowed_the_passes_do_all() {
    // Rows of one word, of which three slabs hold three slices each, and the passes three in all.
    let volume = volume([2, 40_000, 3], |n| u8::from(chance(n).is_multiple_of(500)));
    let options = ExtractOptions::DEFAULT.with_boundary(Boundary::Open);
    let limits = Limits { bytes: 5 * 40_000 * 24 };
    let expected = by_passes(&volume.view(), 0.5, &options);
    assert!(!expected.triangles.is_empty());
    let mut mesh = used(9, 9, Precision::F32);
    let job = Job { limits, ..job(3) };
    extract_into(&volume.view(), 0.5, &options, &mut mesh.refill(), &job).unwrap();
    assert!(mesh == expected);
}

proptest! {
    #[test]
    fn any_volume_is_the_same_in_memory_of_any_size(
        dims in [1..70_u64, 1..6_u64, 1..40_u64],
        values in 2..300_u64,
        seed in any::<u64>(),
        held in (0..4000_usize, 0..8000_usize),
        threads in 1..4_usize,
        option in 0..32_usize,
    ) {
        let volume = volume(dims, |n| (chance(n ^ seed) % values) as u16);
        let (view, iso, options) = (volume.view(), values as f64 / 2.0, &all_options()[option]);
        let expected = by_passes(&view, iso, options);
        let mut mesh = used(held.0, held.1, Precision::F32);
        extract_into(&view, iso, options, &mut mesh.refill(), &job(threads)).unwrap();
        prop_assert!(mesh == expected);
    }

    #[test]
    fn any_volume_of_mostly_one_value_is_the_same_with_bricks_of_it_or_of_a_larger_one(
        dims in [1..140_u64, 1..50_u64, 1..90_u64],
        cut in [0..70_usize, 0..12_usize, 0..12_usize],
        (rare, most) in (1..40_u64, 0..9_u16),
        seed in any::<u64>(),
        held in (0..9000_usize, 0..18_000_usize),
        threads in 1..4_usize,
        option in 0..32_usize,
    ) {
        // Other values in some blocks only, whose sizes are those of bricks.
        let sample = |n: u64| {
            let [i, j, k] = [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]];
            let block = chance((i / 64 + 8 * (j / 8) + 1000 * (k / 8)) ^ seed);
            if block.is_multiple_of(rare) { (chance(n ^ seed) % 9) as u16 } else { most }
        };
        let (whole, options) = (volume(dims, sample), &all_options()[option]);
        let bricks = Bricks::of(&whole.view(), &Job::default()).unwrap();
        let part = [0, 1, 2].map(|axis| {
            let end = dims[axis] as usize;
            cut[axis].min(end - 1)..end
        });
        let (view, bricks) = (whole.view().part(part.clone()).unwrap(), bricks.part(&part).unwrap());
        let (expected, mut mesh) = (by_passes(&view, 4.0, options), used(held.0, held.1, Precision::F32));
        let source = Source::with_bricks(&view, &bricks).unwrap();
        extract_many(source, &[4.0], options, &mut [mesh.refill()], &job(threads)).unwrap();
        prop_assert!(mesh == expected);
        let mut mesh = used(held.0, held.1, Precision::F32);
        with_bricks(&whole.view(), 4.0, options, &mut [&mut mesh], &job(threads));
        prop_assert!(mesh == by_passes(&whole.view(), 4.0, options));
    }
}
