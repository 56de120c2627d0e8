//! The surface against its definition, cell by cell and edge by edge, with a map for the numbers.

use super::{check_size, count, extract};
use crate::{
    Boundary, Degenerate, Diagonals, ExtractError, ExtractOptions, Nan, Placement, Topology,
    case::TRIANGLES,
};
use isokit_geom::{Affine, Frame, cube::Edge};
use isokit_job::{Job, Limits, Stopped};
use isokit_mesh::{Counts, Positions, Precision};
use isokit_volume::{Grid, Sample, Scaling, View, Volume};
use std::{
    collections::{BTreeMap, HashSet},
    num::NonZeroUsize,
};

mod bricks;
mod many;
mod placement;
mod progress;

type Point = [i64; 3];

/// A lattice edge: z and the order within a slice first, so that a map's order is the numbers' order.
type Name = (i64, bool, i64, usize, i64);

fn name([x, y, z]: Point, axis: usize) -> Name {
    (z, axis == 2, y, axis, x)
}

struct Definition<'a, T> {
    view: View<'a, T>,
    iso: f64,
    options: &'a ExtractOptions,
}

impl<T: Sample> Definition<'_, T> {
    fn value(&self, point: Point) -> Option<f64> {
        let held = (0..3).all(|axis| (0..self.view.dims()[axis] as i64).contains(&point[axis]));
        held.then(|| self.view.value(point.map(|c| c as usize)))
    }

    fn cells(&self) -> Vec<Point> {
        let reach = i64::from(self.options.boundary == Boundary::Closed);
        let range = |axis: usize| -reach..self.view.dims()[axis] as i64 - 1 + reach;
        let rows = range(2).flat_map(|z| range(1).map(move |y| (y, z)));
        rows.flat_map(|(y, z)| range(0).map(move |x| [x, y, z])).collect()
    }

    fn corner(&self, cell: Point, k: usize) -> Option<f64> {
        self.value(std::array::from_fn(|axis| cell[axis] + (k >> axis & 1) as i64))
    }

    fn case(&self, cell: Point) -> usize {
        let inside = |k: usize| self.corner(cell, k).is_some_and(|value| value >= self.iso);
        let missing = |k: usize| self.corner(cell, k).is_some_and(f64::is_nan);
        if self.options.nan == Nan::Mask && (0..8).any(missing) {
            return 0;
        }
        (0..8).map(|k| usize::from(inside(k)) << k).sum()
    }

    /// The triangles by names of edges, then by the numbers that the names' order gives.
    fn triangles(&self) -> (Vec<[u32; 3]>, Vec<(Point, usize)>) {
        let mut edges = BTreeMap::new();
        let mut triangles = vec![];
        for cell in self.cells() {
            for triangle in TRIANGLES[self.case(cell)] {
                triangles.push(triangle.map(|e| {
                    let (low, axis) = (Edge::new(e).ends()[0].index(), usize::from(e) / 4);
                    let low = std::array::from_fn(|axis| cell[axis] + (low >> axis & 1) as i64);
                    edges.insert(name(low, axis), (low, axis));
                    name(low, axis)
                }));
            }
        }
        let numbers: BTreeMap<_, u32> = edges.keys().copied().zip(0..).collect();
        let triangles = triangles.iter().map(|names| names.map(|name| numbers[&name])).collect();
        (triangles, edges.into_values().collect())
    }
}

/// The surfaces that are defined here.
const TABLE: ExtractOptions =
    ExtractOptions::DEFAULT.with_topology(Topology::Table).with_placement(Placement::Linear);

#[track_caller]
fn check<T: Sample>(volume: &Volume<T>, iso: f64, options: &ExtractOptions) {
    let view = volume.view();
    let mesh = extract(&view, iso, options, &Job::default()).unwrap();
    let definition = Definition { view, iso, options };
    let (triangles, edges) = definition.triangles();
    assert_eq!(mesh.triangles, triangles, "{:?}, {options:?}", view.dims());
    assert_eq!(mesh.positions.len(), edges.len());
    assert_eq!(count(&view, iso, options, &Job::default()), Ok(mesh.counts()));
    for (found, &(low, axis)) in mesh.positions.iter().zip(&edges) {
        let mut high = low;
        high[axis] += 1;
        let t = match [low, high].map(|end| definition.value(end)) {
            [None, _] => 1.0,
            [_, None] => 0.0,
            [Some(a), Some(b)] => match [a, b].map(f64::is_finite) {
                [true, true] => (iso - a) / (b - a),
                [false, true] => 1.0,
                [true, false] => 0.0,
                [false, false] => 0.5,
            },
        };
        let mut ijk = low.map(|c| c as f64);
        ijk[axis] += t;
        let expected = view.frame().index_to_world.point(ijk);
        let near = (0..3).all(|k| (found[k] - expected[k]).abs() < 2e-3);
        assert!(near, "{found:?} on the edge from {low:?} along {axis}, expected {expected:?}");
    }
    for normal in mesh.normals.unwrap() {
        let length = normal.iter().map(|c| c * c).sum::<f32>().sqrt();
        assert!((length - 1.0).abs() < 1e-6, "{normal:?}");
    }
}

struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        self.0 ^ self.0 >> 31
    }
}

fn chance<T: Sample>(dims: [u64; 3], seed: u64, sample: fn(u64) -> T) -> Volume<T> {
    let mut chance = Chance(seed);
    let grid = Grid::new(dims, Frame::default()).unwrap();
    let samples = (0..grid.count()).map(|_| sample(chance.next() >> 20)).collect();
    Volume::new(grid, samples).unwrap()
}

fn all_options() -> Vec<ExtractOptions> {
    let mut all = vec![];
    for boundary in [Boundary::Closed, Boundary::Open] {
        for degenerate in [Degenerate::Never, Degenerate::Exact] {
            for (nan, layers) in [(Nan::Outside, 1), (Nan::Mask, 3), (Nan::Outside, usize::MAX)] {
                let options = TABLE.with_boundary(boundary).with_nan(nan);
                let layers = NonZeroUsize::new(layers).unwrap();
                all.push(options.with_degenerate(degenerate).with_layers_per_task(layers));
            }
        }
    }
    all
}

#[test]
fn a_chance_volume_of_any_shape_has_the_surface_that_is_defined() {
    let sizes = [[1, 1, 1], [1, 5, 2], [2, 2, 2], [3, 1, 4], [6, 5, 4]];
    for (seed, dims) in (0..).zip(sizes.repeat(6)) {
        for options in all_options() {
            check(&chance(dims, seed, |r| (r % 7) as i8 - 3), 0.0, &options);
            check(&chance(dims, seed, |r| (r % 256) as u8), 127.5, &options);
            check(&chance(dims, seed, |r| (r % 1000) as f32 * 1e-3), 0.3, &options);
        }
    }
}

#[test]
fn rows_may_end_anywhere_in_a_word() {
    for nx in [61, 62, 63, 64, 65, 66, 126, 127, 128, 129] {
        for options in all_options() {
            check(&chance([nx, 3, 3], nx, |r| (r % 5) as f64 - 2.0), 0.0, &options);
        }
    }
}

#[test]
fn large_slices_that_are_filled_band_by_band_have_the_surface_that_is_defined() {
    // Of 2.2 MB each, with queues of vertices that are full before a slice ends.
    let sample = |r: u64| f64::from(u8::from(r.is_multiple_of(40)));
    let large = chance([700, 400, 5], 1, sample);
    for (boundary, layers) in [(Boundary::Closed, 3), (Boundary::Open, usize::MAX)] {
        let options = TABLE.with_boundary(boundary).with_nan(Nan::Mask);
        check(&large, 0.5, &options.with_layers_per_task(NonZeroUsize::new(layers).unwrap()));
    }
}

#[test]
fn what_has_no_value_or_no_finite_one_has_the_surface_that_is_defined() {
    let sample = |r: u64| match r % 12 {
        0 | 1 => f32::NAN,
        2 => f32::INFINITY,
        3 => f32::NEG_INFINITY,
        n => n as f32 - 7.5,
    };
    for seed in 0..40 {
        for options in all_options() {
            check(&chance([5, 4, 6], seed, sample), 0.0, &options);
            check(&chance([70, 3, 3], seed, sample), 0.0, &options);
        }
    }
}

#[test]
fn stored_samples_that_fall_where_their_meaning_rises_are_read_as_meant() {
    for seed in 0..10 {
        let volume = chance([6, 5, 4], seed, |r| (r % 64) as u16);
        let scaled = volume.with_scaling(Scaling::new(-0.5, 20.0).unwrap());
        check(&scaled, 4.25, &TABLE);
        check(&scaled, 4.0, &TABLE);
    }
}

#[test]
fn a_frame_that_mirrors_turns_the_triangles_and_nothing_else() {
    let plain = chance([5, 5, 5], 7, |r| (r % 100) as f64);
    let mut mirrored = plain.clone();
    let index_to_world = Affine::axis_aligned([-1.0, 1.0, 1.0], [0.0; 3]).unwrap();
    mirrored.set_frame(Frame { index_to_world, ..Frame::default() });
    let of = |volume: &Volume<f64>| {
        extract(&volume.view(), 50.0, &ExtractOptions::DEFAULT, &Job::default()).unwrap()
    };
    let turned = of(&mirrored).triangles.into_iter().map(|[a, b, c]| [a, c, b]);
    assert_eq!(turned.collect::<Vec<_>>(), of(&plain).triangles);
}

#[test]
fn far_from_the_origin_positions_are_kept_as_f64() {
    let volume = chance([5, 5, 5], 3, |r| (r % 7) as i16);
    let at = |origin: f64, spacing: f64, precision| {
        let index_to_world = Affine::axis_aligned([spacing; 3], [origin; 3]).unwrap();
        let view = volume.view().with_frame(Frame { index_to_world, ..Frame::default() });
        let options = ExtractOptions::DEFAULT.with_precision(precision);
        extract(&view, 3.0, &options, &Job::default()).unwrap().positions
    };
    assert!(matches!(at(0.0, 1.0, None), Positions::F32(_)));
    assert!(matches!(at(1e4, 1.0, None), Positions::F32(_)), "with a wider margin");
    assert!(matches!(at(6.4e6, 0.1, None), Positions::F64(_)));
    // Who asks for f32 there gets it, and vertices that are in one place.
    let Positions::F32(coarse) = at(6.4e6, 0.1, Some(Precision::F32)) else { panic!("f32") };
    let different: HashSet<_> = coarse.iter().map(|place| place.map(f32::to_bits)).collect();
    assert!(different.len() < coarse.len());
    assert!(matches!(at(0.0, 1.0, Some(Precision::F64)), Positions::F64(_)));
}

#[test]
fn where_no_type_tells_samples_apart_is_an_error() {
    let volume = chance([4, 4, 4], 3, |r| (r % 7) as i16);
    for (origin, precision, is_far) in [
        (1e15, None, true),
        (1e300, None, true),
        (1e13, None, false),
        (1e39, Some(Precision::F32), true),
        (3.5e38, Some(Precision::F32), true),
        (1e12, Some(Precision::F32), false),
    ] {
        let index_to_world = Affine::axis_aligned([1.0; 3], [0.0, origin, 0.0]).unwrap();
        let view = volume.view().with_frame(Frame { index_to_world, ..Frame::default() });
        let options = ExtractOptions::DEFAULT.with_precision(precision);
        let found = extract(&view, 3.0, &options, &Job::default());
        assert_eq!(matches!(found, Err(ExtractError::TooFar { .. })), is_far, "{origin:e}");
        assert_eq!(found.is_err(), is_far, "{origin:e}");
    }
}

/// The corners' differences are exact in f64, since they are near each other.
fn has_area([p, q, r]: [[f64; 3]; 3]) -> bool {
    let (u, v): ([f64; 3], [f64; 3]) =
        (std::array::from_fn(|k| q[k] - p[k]), std::array::from_fn(|k| r[k] - p[k]));
    (0..3).any(|k| u[k] * v[(k + 1) % 3] != u[(k + 1) % 3] * v[k])
}

/// Every topology with every placement, open and closed, and the default with fitted diagonals.
fn modes() -> Vec<ExtractOptions> {
    let mut all = vec![ExtractOptions::DEFAULT.with_diagonals(Diagonals::Fitted)];
    for topology in [Topology::Table, Topology::Trilinear] {
        for placement in [Placement::Linear, Placement::Cubic, Placement::Quintic] {
            for boundary in [Boundary::Closed, Boundary::Open] {
                let options = ExtractOptions::DEFAULT.with_topology(topology);
                all.push(options.with_placement(placement).with_boundary(boundary));
            }
        }
    }
    all
}

#[test]
fn however_far_away_no_position_repeats_and_every_triangle_has_an_area() {
    for (seed, exponent) in (0..).zip((0..230).map(|n| f64::from(n) * 0.2)) {
        let volume = chance([8, 7, 9], seed, |r| (r % 3) as u8);
        let origin = exponent.exp2();
        let columns = [[0.9, 0.1, 0.0], [-0.1, 0.8, 0.2], [0.3, 0.0, 1.3]];
        for columns in [columns, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]] {
            let index_to_world = Affine::new(columns, [origin, -origin, origin / 3.0]).unwrap();
            let view = volume.view().with_frame(Frame { index_to_world, ..Frame::default() });
            for options in modes() {
                let mesh = extract(&view, 1.0, &options, &Job::default()).unwrap();
                let places = mesh.positions.iter().map(|p| p.map(f64::to_bits));
                let mut places: Vec<_> = places.collect();
                places.sort_unstable();
                let count = places.len();
                places.dedup();
                assert_eq!(places.len(), count, "at {origin}, {options:?}");
                let flat = mesh.triangles.iter().filter(|&&t| !has_area(mesh.corners(t))).count();
                assert_eq!(flat, 0, "at {origin}, {options:?}, {:?}", mesh.positions.precision());
            }
        }
    }
}

#[test]
fn nothing_inside_is_an_empty_surface_and_everything_inside_a_box() {
    let volume = chance([4, 4, 4], 1, |r| (r % 200) as u8);
    let of = |iso: f64, boundary| {
        let options = ExtractOptions::DEFAULT.with_boundary(boundary);
        count(&volume.view(), iso, &options, &Job::default()).unwrap()
    };
    assert_eq!(of(256.0, Boundary::Closed), Counts::default());
    assert_eq!(of(-1.0, Boundary::Open), Counts::default());
    assert_eq!(of(0.0, Boundary::Closed), Counts { vertices: 6 * 16, triangles: 188 });
}

#[test]
fn errors_say_whose_fault_it_is() {
    let volume = chance([4, 4, 4], 1, |r| if r % 9 == 0 { f64::NAN } else { 1.0 });
    let of = |iso: f64, nan, job: &Job| {
        extract(&volume.view(), iso, &ExtractOptions::DEFAULT.with_nan(nan), job).unwrap_err()
    };
    let error = of(f64::NAN, Nan::Outside, &Job::default());
    assert_eq!(error.to_string(), "the isovalue is NaN, which is no finite number");
    let error = of(0.0, Nan::Error, &Job::default());
    assert!(matches!(error, ExtractError::Nan { count: 1.., .. }), "{error}");
    let endless = Grid::new([1 << 40, 2, 2], Frame::default()).unwrap();
    let repeated = View::strided(&[1.0_f32; 4], 0, [0, 1, 2], &endless).unwrap();
    let error = extract(&repeated, 0.5, &ExtractOptions::DEFAULT, &Job::default()).unwrap_err();
    assert_eq!(error, ExtractError::TooLong { axis: 0, size: 1 << 40 });
    let limited = Job { limits: Limits { bytes: 500 }, ..Job::default() };
    let error = of(0.5, Nan::Outside, &limited);
    assert!(matches!(error, ExtractError::Stopped(Stopped::OverLimit(_))), "{error}");
    let cancelled = Job::default();
    cancelled.cancel.cancel();
    let error = of(0.5, Nan::Outside, &cancelled);
    assert!(matches!(error, ExtractError::Stopped(Stopped::Cancelled(_))), "{error}");
}

#[test]
fn what_32_bits_cannot_number_is_an_error_that_counts_it() {
    let most = u64::from(u32::MAX);
    let sized = |vertices, widest| check_size(Counts { vertices, triangles: 2 * vertices }, widest);
    assert!(sized(most, most).is_ok());
    for (vertices, widest) in [(most + 1, 6), (6, most + 1)] {
        let error: ExtractError = sized(vertices, widest).unwrap_err();
        let counted = format!("{vertices} vertices and {} triangles", 2 * vertices);
        assert!(matches!(error, ExtractError::TooLarge { .. }));
        assert!(error.to_string().contains(&counted), "{error}");
    }
}
