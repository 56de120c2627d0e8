//! Surfaces of slices of which bricks are known: the same, and from fewer samples.

use super::{bits, frame, greatest_slice, options, samples};
use crate::{
    Boundary, Budget, ExtractOptions, Gradient, Nan, Placement, Skipped, Slabs, Topology,
    extract_into, extract_slabs,
};
use isokit_geom::Frame;
use isokit_job::{Job, Stopped};
use isokit_mesh::TriMesh;
use isokit_volume::{Bricks, Grid, Sample, Scaling, SlabSource, View, Volume};
use proptest::prelude::*;
use std::ops::Range;

/// Slices that give the rows that they are asked for, and in place of all others anything.
struct Known<'a, T> {
    view: View<'a, T>,
    grid: Grid,
    bricks: Bricks<T>,
    next: usize,
    given: u64,
}

impl<T: Sample> SlabSource<T> for Known<'_, T> {
    type Error = Stopped;

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn scaling(&self) -> Scaling {
        self.view.scaling()
    }

    fn bricks(&self) -> Option<&Bricks<T>> {
        Some(&self.bricks)
    }

    fn fill(&mut self, slices: &mut [T]) -> Result<(), Stopped> {
        let [nx, ny, _] = self.view.dims();
        slices.chunks_exact_mut(nx * ny).try_for_each(|slice| self.fill_rows(slice, 0..ny))
    }

    fn fill_rows(&mut self, slice: &mut [T], rows: Range<usize>) -> Result<(), Stopped> {
        let nx = self.view.dims()[0];
        slice.fill(T::at_rank(self.next as u64 * 31 % T::LAST_RANK));
        for j in rows {
            let row = self.view.row(j, self.next);
            slice[nx * j..nx * (j + 1)].copy_from_slice(row.gather(&mut vec![]));
            self.given += nx as u64;
        }
        self.next += 1;
        Ok(())
    }
}

/// What was skipped, of a part of a volume of whose bricks all are known.
#[track_caller]
fn check<T: Sample>(
    volume: &Volume<T>,
    part: [Range<usize>; 3],
    isos: &[f64],
    options: &ExtractOptions,
) -> Skipped {
    let job = Job::default();
    let bricks = Bricks::of(&volume.view(), &job).unwrap().part(&part).unwrap();
    let view = volume.view().part(part).unwrap();
    let whole = |&iso: &f64| {
        let mut mesh = TriMesh::with_normals();
        extract_into(&view, iso, options, &mut mesh.refill(), &job).unwrap();
        mesh
    };
    let expected: Vec<TriMesh> = isos.iter().map(whole).collect();
    let (least, slices) = (options.placement.least_window(), view.dims()[2]);
    let mut skipped = None;
    for window in [least, least + 1, least + 7, slices.max(least)] {
        let piece_bytes = 3 * greatest_slice(&view.grid(), options.topology);
        let slabs = Slabs { isos, options, budget: Budget { window, piece_bytes } };
        let mut meshes = vec![TriMesh::with_normals(); isos.len()];
        let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
        let (grid, bricks) = (view.grid(), bricks.clone());
        let mut source = Known { view, grid, bricks, next: 0, given: 0 };
        let found = extract_slabs(&mut source, &slabs, &mut sinks, &job).unwrap();
        drop(sinks);
        for (mesh, expected) in meshes.iter().zip(&expected) {
            assert!(bits(mesh) == bits(expected), "window {window}, {options:?}");
        }
        let own = found[0].skipped;
        assert_eq!(own.samples_read, source.given);
        assert_eq!(*skipped.get_or_insert(own), own, "window {window}");
    }
    skipped.unwrap()
}

/// Depth in two balls, in steps, so that whole bricks have one value and ties are many.
fn balls<T: Sample>(dims: [u64; 3], make: impl Fn(f64) -> T) -> Volume<T> {
    let grid = Grid::new(dims, Frame::default()).unwrap();
    let [nx, ny, _] = dims;
    let depth = |n: u64| {
        let place = [n % nx, n / nx % ny, n / nx / ny];
        let of_ball = |at: [f64; 3], radius: f64| {
            let square: f64 =
                (0..3).map(|k| (place[k] as f64 - at[k] * dims[k] as f64).powi(2)).sum();
            radius - square.sqrt()
        };
        make(of_ball([0.3, 0.4, 0.25], 6.0).max(of_ball([0.8, 0.7, 0.7], 5.0)).clamp(-2.0, 3.0))
    };
    Volume::new(grid, (0..grid.count()).map(depth).collect()).unwrap()
}

fn all(dims: [u64; 3]) -> [Range<usize>; 3] {
    dims.map(|n| 0..n as usize)
}

#[test]
fn rows_that_hold_no_surface_are_not_asked_for() {
    let dims = [70, 60, 90];
    let volume = balls(dims, |depth| depth as f32);
    for placement in [Placement::Linear, Placement::Quintic] {
        let options = ExtractOptions::DEFAULT.with_placement(placement);
        let found = check(&volume, all(dims), &[0.5], &options);
        assert!(found.samples_read < 70 * 60 * 90 / 2, "{found:?}");
        assert_eq!(found.bricks, 2 * 8 * 12);
        assert!(found.bricks_skipped > 150, "{found:?}");
        let none = check(&volume, all(dims), &[1e3, f64::MAX], &options);
        assert_eq!((none.samples_read, none.bricks_skipped), (0, none.bricks));
        // All is inside: beside every border there is a cap, or nothing.
        let capped = check(&volume, all(dims), &[-9.0], &options);
        assert_eq!((capped.samples_read, capped.bricks_skipped), (70 * 60 * 90, capped.bricks));
        let open = options.with_boundary(Boundary::Open);
        assert_eq!(check(&volume, all(dims), &[-9.0], &open).samples_read, 0);
    }
}

#[test]
fn every_choice_gives_the_same_surface_of_the_whole_and_of_parts() {
    let dims = [131, 44, 61];
    let volume = balls(dims, |depth| (depth * 4.0).round() as i16);
    for part in [all(dims), [3..131, 5..43, 9..61], [64..129, 0..40, 7..58]] {
        for boundary in [Boundary::Open, Boundary::Closed] {
            for gradient in [Gradient::Central, Gradient::Matching] {
                for topology in [Topology::Table, Topology::Trilinear] {
                    let options = ExtractOptions::DEFAULT
                        .with_boundary(boundary)
                        .with_gradient(gradient)
                        .with_topology(topology);
                    let skipped = check(&volume, part.clone(), &[0.0, 2.5, -8.0], &options);
                    assert!(skipped.bricks_skipped > 0);
                }
            }
        }
    }
}

#[test]
fn where_nan_matters_all_samples_are_asked_for() {
    let dims = [66, 30, 40];
    let holes = |depth: f64| if (0.9..1.1).contains(&depth) { f64::NAN } else { depth };
    let volume = balls(dims, holes);
    let read = |nan: Nan| check(&volume, all(dims), &[0.5], &ExtractOptions::DEFAULT.with_nan(nan));
    assert_eq!(read(Nan::Mask).samples_read, 66 * 30 * 40);
    assert!(read(Nan::Outside).samples_read < 66 * 30 * 40);
    let without = balls(dims, |depth| depth);
    for nan in [Nan::Mask, Nan::Error] {
        let options = ExtractOptions::DEFAULT.with_nan(nan);
        let skipped = check(&without, all(dims), &[0.5], &options);
        assert!(skipped.samples_read < 66 * 30 * 40, "{nan:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn chance_that_is_mostly_of_one_value_gives_the_same_surface(
        dims in [1_u64..140, 1_u64..30, 1_u64..50], seed: u64, options in options(), frame in frame(),
        matching: bool, most in 0..3_u64, rare in 1..3000_u64, starts in [0..5_usize, 0..9_usize, 0..9_usize],
    ) {
        let gradient = if matching { Gradient::Matching } else { Gradient::Central };
        let options = options.with_gradient(gradient);
        let grid = Grid::new(dims, frame).unwrap();
        let part = [0, 1, 2].map(|axis| {
            let n = dims[axis] as usize;
            starts[axis].min(n - 1)..n
        });
        let sample = |r: u64| if (r >> 8) % 4096 < rare { r % 7 } else { 4 * most };
        let isos = [2.0, 4.0, 6.5];
        match seed % 3 {
            0 => check(&samples(grid, seed, |r| sample(r) as u8), part, &isos, &options),
            1 => check(&samples(grid, seed, |r| sample(r) as f32), part, &isos, &options),
            _ => check(&samples(grid, seed, |r| sample(r) as i16), part, &isos, &options),
        };
    }
}
