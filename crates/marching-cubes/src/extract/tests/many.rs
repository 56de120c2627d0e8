//! Several isovalues at once against each alone.

use super::{all_options, chance};
use crate::{
    ExtractError, ExtractOptions, Nan, Topology, count, count_many, extract, extract_many,
};
use isokit_geom::Frame;
use isokit_job::Job;
use isokit_mesh::TriMesh;
use isokit_volume::{Grid, Sample, Scaling, Volume};
use proptest::prelude::*;

#[track_caller]
fn check<T: Sample>(volume: &Volume<T>, isos: &[f64], options: &ExtractOptions) {
    for topology in [Topology::Table, Topology::Trilinear] {
        check_one(volume, isos, &options.clone().with_topology(topology));
    }
}

#[track_caller]
fn check_one<T: Sample>(volume: &Volume<T>, isos: &[f64], options: &ExtractOptions) {
    let (view, job) = (volume.view(), Job::default());
    let mut meshes = vec![TriMesh::with_normals(); isos.len()];
    let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
    let all = extract_many(&view, isos, options, &mut sinks, &job).unwrap();
    drop(sinks);
    let counts = count_many(&view, isos, options, &job).unwrap();
    for (n, &iso) in isos.iter().enumerate() {
        assert_eq!(meshes[n], extract(&view, iso, options, &job).unwrap(), "{iso} of {isos:?}");
        assert_eq!(all[n].counts, meshes[n].counts());
        assert_eq!(counts[n], meshes[n].counts(), "{iso} of {isos:?}");
        assert_eq!(counts[n], count(&view, iso, options, &job).unwrap());
    }
}

#[test]
fn each_surface_is_the_one_that_its_value_alone_gives() {
    for (seed, nx) in (0..).zip([1, 5, 62, 63, 64, 65, 130]) {
        for options in all_options() {
            let bytes = chance([nx, 4, 3], seed, |r| (r % 9) as u8);
            check(&bytes, &[4.0, 3.5, 4.0, -1.0, 0.0, 8.0, 8.5, 1e9], &options);
            let turned = bytes.with_scaling(Scaling::new(-0.5, 2.0).unwrap());
            check(&turned, &[0.0, 2.0, 2.5, -7.0], &options);
            let holes = |r: u64| if r.is_multiple_of(5) { f32::NAN } else { (r % 7) as f32 };
            check(&chance([nx, 4, 3], seed, holes), &[3.0, 6.0, 0.0, -1.0], &options);
        }
    }
}

#[test]
fn slices_of_several_pieces_are_counted_as_they_are_extracted() {
    let isos = [4.0, 3.5, 6.0, 0.0];
    for options in all_options() {
        check(&chance([128, 70, 3], 3, |r| (r % 9) as u8), &isos, &options);
    }
    let grid = Grid::new([128, 70, 2], Frame::default()).unwrap();
    let mut samples: Vec<_> = (0..grid.count()).map(|n| (n % 9) as f32).collect();
    *samples.last_mut().unwrap() = f32::NAN;
    let volume = Volume::new(grid, samples).unwrap();
    let options = ExtractOptions::DEFAULT.with_topology(Topology::Table).with_nan(Nan::Error);
    let counts = count_many(&volume.view(), &isos, &options, &Job::default());
    assert_eq!(counts, Err(ExtractError::Nan { count: 1, first: [127, 69, 1] }));
}

#[test]
fn no_value_gives_no_surface() {
    check(&chance([5, 4, 3], 1, |r| r as i16), &[], &ExtractOptions::DEFAULT);
}

#[test]
fn one_value_that_is_no_number_or_one_nan_fails_all() {
    let volume = chance([5, 4, 3], 1, |r| if r.is_multiple_of(20) { f64::NAN } else { r as f64 });
    let of = |isos: &[f64], nan| {
        count_many(&volume.view(), isos, &ExtractOptions::DEFAULT.with_nan(nan), &Job::default())
    };
    let infinite = of(&[1.0, f64::INFINITY], Nan::Outside);
    assert_eq!(infinite, Err(ExtractError::Iso(f64::INFINITY)));
    assert!(matches!(of(&[1.0, 2.0], Nan::Error), Err(ExtractError::Nan { .. })));
}

proptest! {
    #[test]
    fn chance_gives_each_value_its_own_surface(
        dims in (1..70_u64, 1..5_u64, 1..5_u64),
        isos in prop::collection::vec(-4.0..4.0_f64, 1..6),
        seed: u64,
    ) {
        let volume = chance([dims.0, dims.1, dims.2], seed, |r| (r % 7) as i8 - 3);
        let ties: Vec<f64> = isos.iter().map(|iso| iso.round()).collect();
        check(&volume, &isos, &ExtractOptions::DEFAULT);
        check(&volume, &ties, &ExtractOptions::DEFAULT);
    }
}
