//! The pieces joined against the surface in memory, bit by bit.

mod bricks;

use super::{Budget, Making, Slabs, Surface, Window, extract_slabs, precision};
use crate::{
    Boundary, Degenerate, ExtractError, ExtractOptions, Extracted, Gradient, Nan, Placement,
    SlabError, Source, Topology, extract, extract_into,
};
use isokit_geom::{Affine, Frame};
use isokit_job::{Job, Stopped};
use isokit_mesh::{Gauged, Positions, TriMesh, topology};
use isokit_volume::{Formula, Grid, Sample, Scaling, SlabSource, Slices, Volume, collect};
use proptest::prelude::*;
use std::convert::Infallible;

/// The most that a slice of the lattice makes.
fn greatest_slice(grid: &Grid, topology: Topology) -> u64 {
    let of_cell = match topology {
        Topology::Table => 3 * 36 + 5 * 12,
        // A waist of six vertices, and as many triangles as it and all edges have sides.
        Topology::Trilinear => (3 + 6) * 36 + (2 * 6 + 12) * 12,
    };
    (grid.dims()[0] + 2) * (grid.dims()[1] + 2) * of_cell
}

fn bits(mesh: &TriMesh) -> (Vec<u64>, Vec<u32>, &[[u32; 3]]) {
    let positions = match &mesh.positions {
        Positions::F32(all) => all.as_flattened().iter().map(|c| c.to_bits().into()).collect(),
        Positions::F64(all) => all.as_flattened().iter().map(|c| c.to_bits()).collect(),
    };
    let normals = mesh.normals.iter().flat_map(|all| all.as_flattened());
    (positions, normals.map(|c| c.to_bits()).collect(), &mesh.triangles)
}

fn check<T: Sample>(volume: &Volume<T>, isos: &[f64], options: &ExtractOptions) {
    let job = Job::default();
    let whole = |&iso: &f64| {
        let mut mesh = TriMesh::with_normals();
        let told = extract_into(&volume.view(), iso, options, &mut mesh.refill(), &job)?;
        Ok::<_, ExtractError>((mesh, told))
    };
    let expected: Result<Vec<_>, _> = isos.iter().map(whole).collect();
    let least = greatest_slice(volume.grid(), options.topology);
    let least_window = options.placement.least_window();
    for window in least_window..=volume.view().dims()[2].max(least_window) {
        for piece_bytes in [least, 3 * least, u64::MAX] {
            let slabs = Slabs { isos, options, budget: Budget { window, piece_bytes } };
            let mut meshes = vec![TriMesh::with_normals(); isos.len()];
            let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
            let source = &mut Slices::new(volume.view());
            let found = extract_slabs(source, &slabs, &mut sinks, &job);
            drop(sinks);
            match &expected {
                Err(error) => {
                    assert_eq!(found, Err(SlabError::Extract(error.clone())), "window {window}");
                }
                Ok(expected) => {
                    for ((mesh, (expected, told)), found) in
                        meshes.iter().zip(expected).zip(found.unwrap())
                    {
                        assert!(bits(mesh) == bits(expected), "window {window}, {piece_bytes}");
                        assert_eq!(Extracted { skipped: told.skipped, ..found }, *told);
                        assert_eq!(found.counts, mesh.counts());
                    }
                }
            }
        }
    }
}

/// Few values, so that many samples are the isovalue, and where there are any NaN and infinities.
fn samples<T: Sample>(grid: Grid, mut seed: u64, sample: impl Fn(u64) -> T) -> Volume<T> {
    let mut next = || {
        seed = seed.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        seed ^= seed >> 31;
        seed >> 20
    };
    let samples = (0..grid.count()).map(|_| sample(next())).collect();
    let scaling = Scaling::new(0.5, 1.0).unwrap();
    Volume::new(grid, samples).unwrap().with_scaling(scaling)
}

fn odd(r: u64) -> f64 {
    match r % 50 {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => f64::NEG_INFINITY,
        n => n as f64 / 10.0,
    }
}

fn options() -> impl Strategy<Value = ExtractOptions> {
    let boundary = prop_oneof![Just(Boundary::Closed), Just(Boundary::Open)];
    let degenerate = prop_oneof![Just(Degenerate::Never), Just(Degenerate::Exact)];
    let nan = prop_oneof![Just(Nan::Outside), Just(Nan::Mask), Just(Nan::Error)];
    let topology = prop_oneof![Just(Topology::Table), Just(Topology::Trilinear)];
    let placement =
        prop_oneof![Just(Placement::Linear), Just(Placement::Cubic), Just(Placement::Quintic)];
    let all = (boundary, degenerate, nan, (topology, placement));
    all.prop_map(|(boundary, degenerate, nan, (topology, placement))| {
        let options = ExtractOptions::DEFAULT.with_boundary(boundary);
        let options = options.with_topology(topology).with_placement(placement);
        options.with_degenerate(degenerate).with_nan(nan)
    })
}

fn frame() -> impl Strategy<Value = Frame> {
    let shear = [[0.7, 0.1, 0.0], [0.2, -0.7, 0.0], [0.1, -0.9, 2.5]];
    prop_oneof![
        Just(Affine::IDENTITY),
        Just(Affine::axis_aligned([0.3, 0.7, 1.1], [-179.3, 4.1, 1e-3]).unwrap()),
        Just(Affine::new(shear, [3.3, -1e3, 12.7]).unwrap()),
        Just(Affine::new(shear, [6.4e6, -5e6, 1e7]).unwrap()),
    ]
    .prop_map(|index_to_world| Frame { index_to_world, ..Frame::default() })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    #[test]
    fn for_every_height_of_the_window_the_pieces_are_the_surface(
        dims in [1_u64..20, 1_u64..12, 1_u64..30],
        kind in 0..8, seed in any::<u64>(), options in options(), frame in frame(),
        gradient in prop_oneof![Just(Gradient::Central), Just(Gradient::Matching)],
    ) {
        let options = options.with_gradient(gradient);
        let grid = Grid::new(dims, frame).unwrap();
        let isos = [2.0, 3.25]; // the stored samples 2 and 4.5
        match kind {
            0 => check(&samples(grid, seed, |r| (r % 5) as u8), &isos, &options),
            1 => check(&samples(grid, seed, |r| (r % 9) as i8 - 3), &isos, &options),
            2 => check(&samples(grid, seed, |r| (r % 2) as u16 * 9), &isos, &options),
            3 => check(&samples(grid, seed, |r| (r % 7) as i16 - 1), &isos, &options),
            4 => check(&samples(grid, seed, |r| (r % 5) as u32), &isos, &options),
            5 => check(&samples(grid, seed, |r| r as i32 % 7), &isos, &options),
            6 => check(&samples(grid, seed, |r| odd(r) as f32), &isos, &options),
            _ => check(&samples(grid, seed, odd), &isos, &options),
        }
    }
}

/// With a window of few slices.
const LINEAR: ExtractOptions = ExtractOptions::DEFAULT.with_placement(Placement::Linear);

#[test]
fn rows_of_several_words_are_no_different() {
    for (options, nz) in [(LINEAR, 9), (ExtractOptions::DEFAULT, 16)] {
        for nan in [Nan::Outside, Nan::Mask] {
            for topology in [Topology::Table, Topology::Trilinear] {
                let options = options.clone().with_nan(nan).with_topology(topology);
                for nx in [62, 63, 64, 65, 130] {
                    let grid = Grid::new([nx, 3, nz], Frame::default()).unwrap();
                    check(&samples(grid, nx, odd), &[2.0], &options);
                }
            }
        }
    }
}

#[test]
fn what_lies_beyond_every_sample_has_an_empty_surface() {
    for (options, nz) in [(LINEAR, 9), (ExtractOptions::DEFAULT, 16)] {
        let grid = Grid::new([3, 4, nz], Frame::default()).unwrap();
        let volume = samples(grid, 1, |r| (r % 5) as u8);
        check(&volume, &[1000.0, -1000.0, 2.0], &options);
        check(&volume, &[f64::INFINITY], &options);
        let flat = Grid::new([1, 4, nz], Frame::default()).unwrap();
        let open = options.with_boundary(Boundary::Open);
        check(&samples(flat, 1, odd), &[2.0], &open.with_nan(Nan::Error));
    }
}

#[test]
fn a_slice_that_makes_more_than_a_piece_may_hold_is_refused() {
    let grid = Grid::new([8, 8, 8], Frame::default()).unwrap();
    let volume = samples(grid, 1, |r| (r % 5) as u8);
    let options = &LINEAR;
    let slabs = Slabs { isos: &[2.0], options, budget: Budget { window: 4, piece_bytes: 100 } };
    let (mut mesh, source) = (TriMesh::default(), &mut Slices::new(volume.view()));
    let found = extract_slabs(source, &slabs, &mut vec![mesh.refill()], &Job::default());
    let Err(SlabError::Extract(ExtractError::Stopped(Stopped::OverLimit(over)))) = found else {
        panic!("{found:?}");
    };
    assert_eq!((over.what, over.limit), ("the surface of one slice", 100));
}

#[test]
fn a_surface_that_32_bits_cannot_number_is_counted_to_its_end() {
    let grid = Grid::new([8, 8, 8], Frame::default()).unwrap();
    let volume = samples(grid, 1, |r| (r % 5) as u8);
    let (options, job) = (&LINEAR, Job::default());
    let budget = Budget { window: 5, piece_bytes: u64::MAX };
    let slabs = Slabs { isos: &[2.0], options, budget };
    let making = Making {
        slabs: &slabs,
        precision: precision::<Infallible>(&grid, options).unwrap(),
        job: &job,
    };
    let source = &mut Slices::new(volume.view());
    let mut window = Window::new(&*source, &slabs, &job).unwrap();
    let mut surface = Surface::new(2.0, None);
    surface.counts.vertices = u64::from(u32::MAX) - 100;
    let (mut mesh, mut windows) = (TriMesh::default(), 0);
    while !window.is_last() {
        window.advance(source, &job).unwrap();
        windows += 1;
        let mut planes = making.planes::<u8, Infallible>(&Source::from(&window.view())).unwrap();
        let held = window.held(planes[0].lattice);
        making.part(&held, &mut planes[0], &mut surface, &mut mesh.refill()).unwrap();
    }
    let whole = extract(&volume.view(), 2.0, options, &job).unwrap().counts();
    assert!(surface.is_too_large && windows > 1, "{windows} windows");
    assert_eq!(surface.counts.vertices, u64::from(u32::MAX) - 100 + whole.vertices);
    assert_eq!(surface.counts.triangles, whole.triangles);
}

#[test]
fn what_a_surface_is_can_be_found_out_while_it_passes_by() {
    let job = Job::default();
    for seed in 0..60 {
        let grid = Grid::new([9, 8, 5 + seed % 11], Frame::default()).unwrap();
        let volume = samples(grid, seed, odd);
        for nan in [Nan::Outside, Nan::Mask] {
            let options = &LINEAR.with_nan(nan).with_boundary(match seed % 2 {
                0 => Boundary::Open,
                _ => Boundary::Closed,
            });
            let budget = Budget { window: 4, piece_bytes: greatest_slice(&grid, Topology::Table) };
            let mut mesh = TriMesh::with_normals();
            let mut sinks = Gauged::new(vec![mesh.refill()], 1, &job);
            let slabs = Slabs { isos: &[2.0], options, budget };
            extract_slabs(&mut Slices::new(volume.view()), &slabs, &mut sinks, &job).unwrap();
            let found = sinks.finish().unwrap().1.remove(0);
            let whole = extract(&volume.view(), 2.0, options, &job).unwrap();
            assert!(bits(&mesh) == bits(&whole));
            let expected = topology(&whole, &job).unwrap();
            assert_eq!(found.components, expected.components.len() as u64);
            assert_eq!(found.euler(), expected.euler());
            assert_eq!(found.boundary_edges, expected.boundary_edges);
            assert_eq!(found.nonmanifold_edges, expected.nonmanifold_edges);
            assert_eq!(found.measure.bounds, expected.measure.bounds);
        }
    }
}

/// 2048 × 2048 slices of u8 around a formula that is asked for a few of them.
struct Deep<F> {
    grid: Grid,
    next: u64,
    is_full: std::ops::Range<u64>,
    formula: F,
}

impl<F: Fn([u64; 3]) -> u8> SlabSource<u8> for Deep<F> {
    type Error = Stopped;

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn fill(&mut self, slices: &mut [u8]) -> Result<(), Stopped> {
        let slice = self.grid.slice_count() as usize;
        for slice in slices.chunks_mut(slice) {
            slice.fill(0);
            if self.is_full.contains(&self.next) {
                let [nx, _, _] = self.grid.dims();
                for (n, sample) in (0..).zip(slice) {
                    *sample = (self.formula)([n % nx, n / nx, self.next]);
                }
            }
            self.next += 1;
        }
        Ok(())
    }
}

#[test]
fn more_samples_than_32_bits_count_are_no_different() {
    let dims = [2048, 2048, 1056];
    let index_to_world = Affine::axis_aligned([0.5, 0.5, 0.75], [-3.0, 9.0, 100.0]).unwrap();
    let frame = Frame { index_to_world, ..Frame::default() };
    let grid = Grid::new(dims, frame).unwrap();
    assert!(grid.count() > 1 << 32);
    // A ball of radius 9 whose middle has a number beyond 2³² − 1.
    let centre = [2030.0, 2030.0, 1040.0];
    let ball = move |ijk: [u64; 3]| {
        let square: f64 = (0..3).map(|k| (ijk[k] as f64 - centre[k]).powi(2)).sum();
        (20.0 - square.sqrt()).max(0.0) as u8
    };
    let around = 1019..1056;
    let source = &mut Deep { grid, next: 0, is_full: around.clone(), formula: ball };
    let options = &ExtractOptions::DEFAULT;
    let budget = Budget { window: 16, piece_bytes: 1 << 24 };
    let slabs = Slabs { isos: &[11.0], options, budget };
    let (mut mesh, job) = (TriMesh::with_normals(), Job::default());
    extract_slabs(source, &slabs, &mut vec![mesh.refill()], &job).unwrap();
    let depth = around.end - around.start;
    let near_ball = |[i, j, k]: [u64; 3]| ball([i + 1948, j + 1948, k + around.start]);
    let mut part = Formula::new(Grid::new([100, 100, depth], frame).unwrap(), near_ball);
    let part = collect(&mut part, &job).unwrap();
    let mut expected = TriMesh::with_normals();
    extract_into(&part.view(), 11.0, options, &mut expected.refill(), &job).unwrap();
    assert_eq!((&mesh.triangles, &mesh.normals), (&expected.triangles, &expected.normals));
    let moved = [1948.0 * 0.5, 1948.0 * 0.5, around.start as f64 * 0.75];
    for (found, expected) in mesh.positions.iter().zip(expected.positions.iter()) {
        let near = (0..3).all(|k| (found[k] - expected[k] - moved[k]).abs() < 1e-3);
        assert!(near, "{found:?}, {expected:?}");
    }
    let bounds = mesh.bounds().unwrap();
    let last = index_to_world.point([centre[0] + 9.0, centre[1] + 9.0, centre[2] + 9.0]);
    assert!((0..3).all(|k| (bounds.max[k] - last[k]).abs() < 0.5), "{bounds:?}");
}
