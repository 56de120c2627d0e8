//! What bricks tell against the samples themselves.

use super::Choice;
use crate::{Boundary, planes::Lattice};
use isokit_job::Job;
use isokit_volume::{Bricks, Grid, Scaling, View, Volume};
use proptest::prelude::*;
use std::ops::Range;

const ISO: f64 = 0.5;

/// All 0, and 1 in a box.
fn volume(dims: [usize; 3], inside: &[Range<usize>; 3]) -> Volume<u8> {
    let [nx, ny, _] = dims;
    let grid = Grid::new(dims.map(|n| n as u64), Default::default()).unwrap();
    let is_inside = |n: usize| {
        let place = [n % nx, n / nx % ny, n / nx / ny];
        (0..3).all(|axis| inside[axis].contains(&place[axis]))
    };
    let samples = (0..dims.iter().product()).map(|n| u8::from(is_inside(n)));
    Volume::new(grid, samples.collect()).unwrap()
}

/// Whether slice `k` differs from the one below, or a sample in it from a neighbour; behind guards, whether one is inside
/// at the border.
fn is_crossed(view: &View<'_, u8>, k: usize, boundary: Boundary) -> bool {
    let [nx, ny, nz] = view.dims();
    let at = |i: usize, j: usize, k: usize| view.stored([i, j, k]);
    let is_at_border =
        |i, j| [i == 0, i + 1 == nx, j == 0, j + 1 == ny, k == 0, k + 1 == nz].contains(&true);
    (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))).any(|(i, j)| {
        let own = at(i, j, k);
        let differs = (i > 0 && at(i - 1, j, k) != own)
            || (j > 0 && at(i, j - 1, k) != own)
            || (k > 0 && at(i, j, k - 1) != own);
        differs || boundary == Boundary::Closed && own == 1 && is_at_border(i, j)
    })
}

/// How many slices on their own, and how many slabs of four, are not needed.
fn check(view: &View<'_, u8>, bricks: &Bricks<u8>, boundary: Boundary) -> [usize; 2] {
    let [nx, ny, nz] = view.dims();
    let lattice = Lattice::new(view.dims(), boundary);
    let choice = Choice::new(bricks, &[Scaling::IDENTITY.threshold(ISO)], lattice);
    let rows = (0..ny * nz).flat_map(|n| choice.compared.of_row(n % ny, n / ny));
    let read: usize = rows.map(|words| nx.min(64 * words.end) - 64 * words.start).sum();
    assert_eq!(choice.skipped.samples_read, read as u64);
    [1, 4].map(|height| {
        let slabs = (0..nz).step_by(height).map(|k| k..nz.min(k + height));
        let left_out = slabs.filter(|slab| !choice.needs(slab));
        let mut count = 0;
        for slab in left_out {
            assert!(!slab.clone().any(|k| is_crossed(view, k, boundary)), "{slab:?}");
            count += slab.len();
        }
        count
    })
}

#[test]
fn slabs_far_from_the_surface_are_not_needed_and_their_number_is_known() {
    let inside = [3..60, 4..15, 24..57];
    let volume = volume([63, 20, 100], &inside);
    let bricks = Bricks::of(&volume.view(), &Job::default()).unwrap();
    // The box is in bricks that begin with slices 16 to 63; edges to slice 64 may be cut.
    for boundary in [Boundary::Open, Boundary::Closed] {
        assert_eq!(check(&volume.view(), &bricks, boundary), [100 - 49, 100 - 52]);
    }
}

proptest! {
    #[test]
    fn what_is_not_needed_holds_no_surface_and_what_is_read_is_counted(
        dims in [1..140_usize, 1..30_usize, 1..60_usize],
        at in [0..130_usize, 0..30_usize, 0..60_usize],
        sizes in [1..140_usize, 1..30_usize, 1..60_usize],
        cut in [0..70_usize, 0..12_usize, 0..12_usize],
    ) {
        let inside = [0, 1, 2].map(|axis| at[axis]..at[axis] + sizes[axis]);
        let volume = volume(dims, &inside);
        let whole = Bricks::of(&volume.view(), &Job::default()).unwrap();
        let part = [0, 1, 2].map(|axis| cut[axis].min(dims[axis] - 1)..dims[axis]);
        let (view, bricks) = (volume.view().part(part.clone()).unwrap(), whole.part(&part).unwrap());
        for boundary in [Boundary::Open, Boundary::Closed] {
            check(&volume.view(), &whole, boundary);
            check(&view, &bricks, boundary);
        }
    }
}
