//! Planes against what they stand for, bit by bit.

use super::{Counted, Lattice, Planes};
use crate::{Boundary, ExtractError, Nan, Source};
use isokit_job::Job;
use isokit_lanes::{RowCounts, count_rows};
use isokit_volume::{Grid, Volume};
use std::convert::Infallible;

fn planes(
    dims: [u64; 3],
    sample: impl Fn(usize) -> f32,
    (boundary, nan): (Boundary, Nan),
) -> Result<Planes, ExtractError<Infallible>> {
    let grid = Grid::new(dims, Default::default()).unwrap();
    let samples = (0..grid.count() as usize).map(sample).collect();
    let volume = Volume::new(grid, samples).unwrap();
    let lattice = Lattice::new(volume.view().dims(), boundary);
    let source = Source::from(&volume.view());
    let (mut all, _) = Planes::classify(&source, lattice, &[0.0], nan, &Job::default())?;
    Ok(all.remove(0))
}

fn bit(row: &[u64], i: usize) -> bool {
    row[i / 64] >> (i % 64) & 1 == 1
}

#[test]
fn a_guard_surrounds_the_samples_of_a_closed_volume() {
    for nx in [1, 2, 61, 62, 63, 64, 65, 126, 127, 128] {
        let all = planes([nx as u64, 3, 2], |_| 1.0, (Boundary::Closed, Nan::Outside)).unwrap();
        assert_eq!(all.lattice.points, [nx + 2, 5, 4]);
        for (y, z) in (0..5).flat_map(|y| (0..4).map(move |z| (y, z))) {
            let inner = (1..4).contains(&y) && (1..3).contains(&z);
            for i in 0..all.lattice.words * 64 {
                let expected = inner && (1..=nx).contains(&i);
                assert_eq!(bit(all.inside.row(y, z), i), expected, "{nx}: {i}, {y}, {z}");
            }
        }
    }
}

#[test]
fn an_open_volume_is_its_samples() {
    let odd = |i: usize| if i % 2 == 1 { 1.0 } else { -1.0 };
    let all = planes([65, 2, 2], odd, (Boundary::Open, Nan::Outside)).unwrap();
    assert_eq!(all.inside.row(0, 0), [0xAAAA_AAAA_AAAA_AAAA, 0]);
    assert_eq!(all.inside.row(1, 0), [0x5555_5555_5555_5555, 1]);
    assert_eq!((all.lattice.cells(0), all.lattice.cells(1)), (u64::MAX, 0));
}

#[test]
fn rows_of_whole_words_are_their_samples_as_other_rows_are() {
    let ring = |i: usize| ((i * 7919 % 1009) as f32).sin();
    for dims in [[64, 3, 2], [128, 70, 3], [64, 1, 1]] {
        let all = planes(dims, ring, (Boundary::Open, Nan::Error)).unwrap();
        let [nx, ny, nz] = dims.map(|n| n as usize);
        for n in 0..nx * ny * nz {
            let row = all.inside.row(n / nx % ny, n / nx / ny);
            assert_eq!(bit(row, n % nx), ring(n) >= 0.0, "{dims:?}, sample {n}");
        }
        let holes = |i: usize| if i + 40 >= nx * ny * nz { f32::NAN } else { ring(i) };
        let error = planes(dims, holes, (Boundary::Open, Nan::Error)).unwrap_err();
        assert_eq!(error, ExtractError::Nan { count: 40, first: [nx - 40, ny - 1, nz - 1] });
        let masked = planes(dims, holes, (Boundary::Open, Nan::Mask)).unwrap();
        let missing = masked.missing.unwrap();
        let last = missing.row(ny - 1, nz - 1);
        assert!(bit(last, nx - 40) && !bit(last, nx - 41));
    }
}

#[test]
fn nan_is_counted_or_marked_as_the_policy_says() {
    let holes = |i: usize| if i == 5 || i == 70 { f32::NAN } else { 1.0 };
    let error = planes([66, 2, 1], holes, (Boundary::Open, Nan::Error)).unwrap_err();
    assert_eq!(error, ExtractError::Nan { count: 2, first: [5, 0, 0] });
    let masked = planes([66, 2, 1], holes, (Boundary::Closed, Nan::Mask)).unwrap();
    let missing = masked.missing.unwrap();
    assert!(bit(missing.row(1, 1), 6) && bit(missing.row(2, 1), 5));
    assert_eq!(missing.row(2, 1)[1], 0);
    let outside = planes([66, 2, 1], holes, (Boundary::Open, Nan::Outside)).unwrap();
    assert!(outside.missing.is_none() && !bit(outside.inside.row(0, 0), 5));
}

#[test]
fn what_is_counted_on_the_way_is_what_the_planes_count() {
    let ring = |i: usize| ((i * 7919 % 1009) as f32).sin();
    for dims in [[5, 4, 80], [64, 3, 70], [130, 20, 40], [300, 90, 9], [2, 2, 2]] {
        for boundary in [Boundary::Open, Boundary::Closed] {
            let all = planes(dims, ring, (boundary, Nan::Outside)).unwrap();
            let Counted { rows, done } = all.counted.as_ref().expect("one value, without bricks");
            let [_, ny, nz] = all.lattice.points;
            assert_eq!((rows.len(), done.len()), (ny * nz, nz));
            for (z, rows) in rows.chunks_exact(ny).enumerate() {
                let mut expected = vec![RowCounts::default(); ny];
                if done[z] {
                    count_rows(&all.inside.slices(z), 0..ny, &mut expected);
                }
                assert_eq!(rows, expected, "{dims:?}, slice {z}");
            }
            assert!(nz < 40 || done.iter().filter(|&&done| done).count() * 2 > nz, "{done:?}");
        }
    }
}

#[test]
fn holes_undo_what_was_counted_on_the_way() {
    let holes = |i: usize| if i == 5 { f32::NAN } else { (i % 3) as f32 - 1.0 };
    let masked = planes([66, 20, 40], holes, (Boundary::Closed, Nan::Mask)).unwrap();
    assert!(masked.missing.is_some() && masked.counted.is_none());
}
