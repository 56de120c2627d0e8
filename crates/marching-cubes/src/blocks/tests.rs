//! The surface of samples made near it against that of all, bit by bit.

use super::extract_sparse;
use crate::{
    Boundary, Degenerate, ExtractError, ExtractOptions, Extracted, Gradient, Nan, Placement,
    Topology, extract_into,
};
use isokit_geom::{Affine, Frame};
use isokit_job::{Job, Threads};
use isokit_lanes::Extent;
use isokit_mesh::{Positions, TriMesh};
use isokit_volume::{Grid, Points, Sample, SampleSource, View, Volume};
use proptest::prelude::*;
use std::num::NonZero;

/// A volume of which extents are known exactly, or within a box nothing more is asked.
struct Known<'a, T> {
    view: View<'a, T>,
    /// Where questions may still be asked.
    within: Points,
    /// Boxes of more samples are not known.
    most: usize,
}

fn known<T: Sample>(volume: &Volume<T>, most: usize) -> Known<'_, T> {
    let view = volume.view();
    Known { view, within: view.dims().map(|n| 0..n), most }
}

impl<T: Sample> Known<'_, T> {
    #[track_caller]
    fn samples(&self, points: &Points) -> Vec<T> {
        for (range, within) in points.iter().zip(&self.within) {
            assert!(within.start <= range.start && range.end <= within.end && !range.is_empty());
        }
        let mut samples = vec![T::default(); points.iter().map(|range| range.len()).product()];
        self.view.fill(points, &mut samples);
        samples
    }
}

impl<T: Sample> SampleSource<T> for Known<'_, T> {
    fn grid(&self) -> Grid {
        self.view.grid()
    }

    fn extent(&self, points: &Points) -> Option<Extent<T>> {
        let samples = self.samples(points);
        let of = |sample: T| match sample.partial_cmp(&sample) {
            Some(_) => Extent { least: sample, greatest: sample, has_nan: false },
            None => Extent { has_nan: true, ..Extent::EMPTY },
        };
        let all = samples.iter().map(|&sample| of(sample)).fold(Extent::EMPTY, Extent::with);
        (samples.len() <= self.most).then_some(all)
    }

    fn within(&self, points: &Points) -> Option<Box<dyn SampleSource<T> + '_>> {
        self.samples(points);
        Some(Box::new(Known { within: points.clone(), ..*self }))
    }

    fn fill(&self, points: &Points, samples: &mut [T]) {
        samples.copy_from_slice(&self.samples(points));
    }
}

fn bits(mesh: &TriMesh) -> (Vec<u64>, Vec<u32>, &[[u32; 3]]) {
    let positions = match &mesh.positions {
        Positions::F32(all) => all.as_flattened().iter().map(|c| c.to_bits().into()).collect(),
        Positions::F64(all) => all.as_flattened().iter().map(|c| c.to_bits()).collect(),
    };
    let normals = mesh.normals.iter().flat_map(|all| all.as_flattened());
    (positions, normals.map(|c| c.to_bits()).collect(), &mesh.triangles)
}

type Told = Result<(TriMesh, Extracted), ExtractError>;

fn sparse<T: Sample>(
    source: &dyn SampleSource<T>,
    iso: f64,
    options: &ExtractOptions,
    threads: usize,
) -> Told {
    let job =
        Job { threads: Threads::new(NonZero::new(threads).unwrap()).unwrap(), ..Job::default() };
    let mut mesh = TriMesh::with_normals();
    let told = extract_sparse(source, iso, options, &mut mesh.refill(), &job)?;
    Ok((mesh, told))
}

/// The law: it is the surface of all samples.
#[track_caller]
fn check<T: Sample>(volume: &Volume<T>, iso: f64, options: &ExtractOptions) -> Option<Extracted> {
    let mut whole = TriMesh::with_normals();
    let job = Job::default();
    let expected = extract_into(&volume.view(), iso, options, &mut whole.refill(), &job);
    let mut last = None;
    for (threads, most) in [(1, usize::MAX), (2, 512), (7, 9 * 512), (2, 0)] {
        match (sparse(&known(volume, most), iso, options, threads), &expected) {
            (Ok((mesh, told)), Ok(expected)) => {
                assert!(bits(&mesh) == bits(&whole), "{threads} threads, {most} known at most");
                assert_eq!(Extracted { skipped: expected.skipped, ..told }, *expected);
                assert_eq!(told.counts, mesh.counts());
                last = last.or(Some(told));
            }
            (found, expected) => assert_eq!(found.err(), expected.clone().err()),
        }
    }
    last
}

fn each_option() -> impl Iterator<Item = ExtractOptions> {
    let placements = [Placement::Linear, Placement::Cubic, Placement::Quintic];
    let gradients = [Gradient::Central, Gradient::Matching];
    let all = placements.into_iter().flat_map(move |p| gradients.map(|g| (p, g)));
    all.flat_map(|(placement, gradient)| {
        [Boundary::Closed, Boundary::Open].map(|boundary| {
            let options = ExtractOptions::DEFAULT.with_boundary(boundary);
            options.with_placement(placement).with_gradient(gradient)
        })
    })
}

fn volume<T>(dims: [u64; 3], value: impl Fn([f64; 3]) -> T) -> Volume<T>
where
    T: Sample,
{
    let grid = Grid::new(dims, Frame::default()).unwrap();
    let all = (0..grid.count()).map(|n| {
        value([n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]].map(|i| i as f64))
    });
    Volume::new(grid, all.collect()).unwrap()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

#[test]
fn of_a_ball_only_blocks_near_its_surface_are_made() {
    let ball = volume([150, 70, 90], |p| (30.3 - distance(p, [80.2, 33.4, 45.1])) as f32);
    for options in each_option() {
        let told = check(&ball, 0.0, &options).unwrap().skipped;
        assert_eq!(told.bricks, 19 * 9 * 12);
        assert!((200..900).contains(&(told.bricks - told.bricks_skipped)), "{told:?}");
        assert!(told.samples_read <= 512 * (told.bricks - told.bricks_skipped));
    }
}

#[test]
fn sheets_that_lie_between_blocks_or_in_one_are_no_different() {
    for axis in 0..3 {
        for place in [7.0, 7.5, 8.0, 8.25, 14.9, 15.0, 23.5, 24.0] {
            let mut dims = [9; 3];
            dims[axis] = 26;
            let sheet = volume(dims, |p| 0.7 - (p[axis] - place).abs());
            let step = volume(dims, |p| if p[axis] < place { -1.0_f32 } else { 2.0 });
            for options in each_option() {
                check(&sheet, 0.0, &options);
                check(&step, 0.0, &options);
                check(&step, 2.0, &options);
            }
        }
    }
}

#[test]
fn what_touches_the_border_is_closed_or_open_alike() {
    for dims in
        [[1, 1, 1], [1, 20, 17], [20, 1, 9], [9, 16, 1], [8, 8, 8], [17, 24, 33], [65, 9, 8]]
    {
        let middle = dims.map(|n| n as f64 / 2.0);
        for radius in [3.0, 7.2, 20.0, 100.0] {
            let ball = volume(dims, |p| radius - distance(p, middle));
            let hole = volume(dims, |p| (distance(p, middle) - radius) as f32);
            for options in each_option() {
                check(&ball, 0.0, &options);
                check(&hole, 0.0, &options);
            }
        }
    }
}

#[test]
fn nothing_and_everything_make_no_samples() {
    let flat = volume([40, 30, 20], |_| 1_u8);
    let told = check(&flat, 2.0, &ExtractOptions::DEFAULT).unwrap();
    assert_eq!((told.skipped.bricks_skipped, told.skipped.samples_read), (60, 0));
    let told = check(&flat, 1.0, &ExtractOptions::DEFAULT).unwrap();
    assert_eq!((told.skipped.bricks_skipped, told.counts.vertices > 0), (60, true));
    check(&flat, f64::INFINITY, &ExtractOptions::DEFAULT);
}

fn options() -> impl Strategy<Value = ExtractOptions> {
    let boundary = prop_oneof![Just(Boundary::Closed), Just(Boundary::Open)];
    let degenerate = prop_oneof![Just(Degenerate::Never), Just(Degenerate::Exact)];
    let nan = prop_oneof![Just(Nan::Outside), Just(Nan::Mask), Just(Nan::Error)];
    let topology = prop_oneof![Just(Topology::Table), Just(Topology::Trilinear)];
    let placement =
        prop_oneof![Just(Placement::Linear), Just(Placement::Cubic), Just(Placement::Quintic)];
    let gradient = prop_oneof![Just(Gradient::Central), Just(Gradient::Matching)];
    let all = (boundary, degenerate, nan, (topology, placement, gradient));
    all.prop_map(|(boundary, degenerate, nan, (topology, placement, gradient))| {
        let options = ExtractOptions::DEFAULT.with_boundary(boundary).with_gradient(gradient);
        let options = options.with_topology(topology).with_placement(placement);
        options.with_degenerate(degenerate).with_nan(nan)
    })
}

fn frame() -> impl Strategy<Value = Frame> {
    let shear = [[0.7, 0.1, 0.0], [0.2, -0.7, 0.0], [0.1, -0.9, 2.5]];
    prop_oneof![
        Just(Affine::IDENTITY),
        Just(Affine::axis_aligned([0.3, 0.7, 1.1], [-179.3, 4.1, 1e-3]).unwrap()),
        Just(Affine::new(shear, [6.4e6, -5e6, 1e7]).unwrap()),
    ]
    .prop_map(|index_to_world| Frame { index_to_world, ..Frame::default() })
}

/// A few balls, some of them hollow, in a field that is cut off on both sides; a few samples are another.
fn balls(dims: [u64; 3], mut seed: u64, odd: &[f64]) -> Volume<f64> {
    let mut next = move || {
        seed = seed.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        seed ^= seed >> 31;
        (seed >> 20) as f64 / (1_u64 << 44) as f64
    };
    let balls: Vec<_> = (0..1 + (next() * 6.0) as usize)
        .map(|_| (dims.map(|n| next() * n as f64), next() * 9.0, next() - 0.4))
        .collect();
    let strange: Vec<_> = (0..(odd.len() as f64 * 3.0 * next()) as usize)
        .map(|n| (dims.map(|n| (next() * n as f64).floor()), odd[n % odd.len()]))
        .collect();
    let mut sharp = (next() * 4.0).exp2();
    if next() < 0.3 {
        sharp = 0.0;
    }
    volume(dims, |p| {
        if let Some((_, value)) = strange.iter().find(|(at, _)| *at == p) {
            return *value;
        }
        let each =
            balls.iter().map(|(at, radius, sign)| sign * (radius - distance(*at, p)).max(-1.0));
        let sum: f64 = each.sum();
        // Of a field that is stepped many samples are the isovalue.
        if sharp == 0.0 { sum.round() } else { (sharp * sum).clamp(-1.5, 1.5) }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(160))]
    #[test]
    fn by_chance_too_it_is_the_surface_of_all_samples(
        dims in [1_u64..40, 1_u64..30, 1_u64..40],
        seed in any::<u64>(), options in options(), frame in frame(), is_narrow in any::<bool>(),
        is_odd in any::<bool>(), iso in prop_oneof![Just(0.0), Just(1.0), Just(0.3)],
    ) {
        let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0];
        let mut volume = balls(dims, seed, if is_odd { &odd } else { &[] });
        volume.set_frame(frame);
        if is_narrow {
            let samples = volume.samples().iter().map(|&sample| sample as f32);
            check(&Volume::new(*volume.grid(), samples.collect()).unwrap(), iso, &options);
        } else {
            check(&volume, iso, &options);
        }
    }
}

#[test]
fn a_job_may_forbid_or_stop_it() {
    use isokit_job::{Limits, Stopped};
    let ball = volume([40, 40, 40], |p| 9.0 - distance(p, [20.0; 3]));
    let source = known(&ball, usize::MAX);
    let run = |job: &Job| {
        let sink = &mut TriMesh::default();
        extract_sparse(&source, 0.0, &ExtractOptions::DEFAULT, &mut sink.refill(), job)
    };
    let limited = Job { limits: Limits { bytes: 1000 }, ..Job::default() };
    assert!(matches!(run(&limited), Err(ExtractError::Stopped(Stopped::OverLimit(_)))));
    let cancelled = Job::default();
    cancelled.cancel.cancel();
    assert!(matches!(run(&cancelled), Err(ExtractError::Stopped(Stopped::Cancelled(_)))));
}
