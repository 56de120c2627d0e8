//! What is written is read back: samples, sizes, place, unit, space and meaning, as far as each format
//! has words for them.

use isokit_geom::{Affine, Frame, Space, Unit};
use isokit_io::{RawLayout, VolumeInput, VolumeOptions, WriteFault, read_volume, write_volume};
use isokit_job::Job;
use isokit_volume::{AnyVolume, Dtype, Grid, Sample, Scaling, Volume, for_any, for_dtype};
use proptest::prelude::*;
use std::fs;

const ENDINGS: [&str; 6] = ["nii", "nii.gz", "nrrd", "nhdr", "npy", "raw"];

fn write_and_read(volume: &AnyVolume, ending: &str) -> VolumeInput {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("volume.{ending}"));
    write_volume(&path, volume, &Job::default()).unwrap();
    let mut options = VolumeOptions::default();
    if ending == "raw" {
        let dtype = if volume.scaling().is_identity() { volume.dtype() } else { Dtype::F64 };
        let (dims, endian) = (volume.grid().dims(), isokit_io::Endian::Little);
        options.raw = Some(RawLayout { dims, dtype, endian, skip: 0 });
    }
    read_volume(&path, &options, &Job::default()).unwrap()
}

fn bytes_of(volume: &AnyVolume) -> Vec<u8> {
    for_any!(volume, volume => bytemuck::cast_slice(volume.samples()).to_vec())
}

fn values_of(volume: &AnyVolume) -> Vec<u64> {
    for_any!(volume, volume => {
        let value = |sample: &_| volume.scaling().value(Sample::to_f64(*sample)).to_bits();
        volume.samples().iter().map(value).collect()
    })
}

/// Largest difference of two maps, against the size of their numbers.
fn apart(a: &Affine, b: &Affine) -> f64 {
    let (a, b) = (a.rows(), b.rows());
    let largest = a.iter().flatten().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs() / largest).fold(0.0, f64::max)
}

/// NIfTI keeps the world RAS, and lengths in a unit it knows.
fn as_nifti_says(frame: Frame) -> Frame {
    let (unit, factor) = match frame.unit {
        Unit::Unknown => (Unit::Millimetre, 1.0),
        Unit::Centimetre => (Unit::Millimetre, 10.0),
        Unit::Nanometre => (Unit::Micrometre, 1e-3),
        Unit::Angstrom => (Unit::Micrometre, 1e-4),
        unit => (unit, 1.0),
    };
    let ras = frame.in_space(Space::Ras).unwrap_or(Frame { space: Space::Ras, ..frame });
    let index_to_world = ras.index_to_world.scaled_world([factor; 3]).unwrap();
    Frame { index_to_world, unit, ..ras }
}

fn check(volume: &AnyVolume) {
    for ending in ENDINGS {
        let read = write_and_read(volume, ending).volume;
        let (frame, found) = (volume.grid().frame, read.grid().frame);
        assert_eq!(read.grid().dims(), volume.grid().dims(), "{ending}");
        match ending {
            "nii" | "nii.gz" => {
                assert!(bytes_of(&read) == bytes_of(volume), "{ending}");
                assert_eq!(read.scaling(), volume.scaling(), "{ending}");
                let expected = as_nifti_says(frame);
                assert_eq!((found.unit, found.space), (expected.unit, expected.space));
                let apart = apart(&found.index_to_world, &expected.index_to_world);
                assert!(apart < 1e-6, "{ending}: {apart}, {found:?}, {expected:?}");
            }
            _ => {
                assert!(read.scaling().is_identity(), "{ending}");
                let has_place = matches!(ending, "nrrd" | "nhdr");
                assert_eq!(found, if has_place { frame } else { Frame::default() }, "{ending}");
                match volume.scaling().is_identity() {
                    true => assert!(bytes_of(&read) == bytes_of(volume), "{ending}"),
                    false => assert_eq!(values_of(&read), values_of(volume), "{ending}"),
                }
            }
        }
    }
}

fn any_frame() -> impl Strategy<Value = Frame> {
    let unit = proptest::sample::select(&Unit::ALL).prop_map(|(unit, _)| unit);
    let space = proptest::sample::select(&[Space::Unknown, Space::Ras, Space::Lps]);
    let columns = proptest::array::uniform3(proptest::array::uniform3(-3.0..3.0_f64));
    let origin = proptest::array::uniform3(-500.0..500.0_f64);
    (unit, space, columns, origin).prop_filter_map("flat", |(unit, space, columns, origin)| {
        let index_to_world = Affine::new(columns, origin).ok()?;
        Some(Frame { index_to_world, unit, space })
    })
}

fn any_volume() -> impl Strategy<Value = AnyVolume> {
    let scaling = prop_oneof![
        Just(Scaling::IDENTITY),
        (0.001..10.0_f32, -1000.0..1000.0_f32).prop_map(|(slope, inter)| Scaling::new(
            slope.into(),
            inter.into()
        )
        .unwrap()),
        (0.001..10.0_f64, -1000.0..1000.0_f64)
            .prop_map(|(slope, inter)| Scaling::new(-slope, inter).unwrap()),
    ];
    let dims = [1..7_u64, 1..7_u64, 1..7_u64];
    let dtype = proptest::sample::select(&Dtype::ALL);
    (dims, dtype, any_frame(), scaling).prop_flat_map(|(dims, dtype, frame, scaling)| {
        let count = dims.iter().product::<u64>() as usize * dtype.bytes();
        let bytes = proptest::collection::vec(any::<u8>(), count);
        bytes.prop_map(move |bytes| {
            let grid = Grid::new(dims, frame).unwrap();
            for_dtype!(dtype, T => {
                let mut samples = vec![T::default(); bytes.len() / size_of::<T>()];
                bytemuck::cast_slice_mut(&mut samples).copy_from_slice(&bytes);
                AnyVolume::from(Volume::new(grid, samples).unwrap().with_scaling(scaling))
            })
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn a_volume_comes_back(volume in any_volume()) {
        check(&volume);
    }
}

fn ramp(dims: [u64; 3], frame: Frame) -> AnyVolume {
    let samples = (0..dims.iter().product::<u64>()).map(|n| n as u16);
    Volume::new(Grid::new(dims, frame).unwrap(), samples.collect()).unwrap().into()
}

#[test]
fn a_smooth_volume_comes_back() {
    let index_to_world = Affine::axis_aligned([0.7, 0.7, 1.25], [-90.0, -126.0, 72.0]).unwrap();
    let frame = Frame { index_to_world, unit: Unit::Millimetre, space: Space::Lps };
    check(&ramp([40, 30, 20], frame));
}

#[test]
fn an_unknown_world_without_origin_stays_unknown_in_nifti() {
    let index_to_world = Affine::axis_aligned([0.5, 0.5, 2.0], [0.0; 3]).unwrap();
    let frame = Frame { index_to_world, unit: Unit::Micrometre, space: Space::Unknown };
    assert_eq!(write_and_read(&ramp([3, 4, 5], frame), "nii").volume.grid().frame, frame);
}

#[test]
fn a_size_beyond_nifti_1_is_written_as_nifti_2() {
    let volume = ramp([32_768, 1, 1], Frame::default());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.nii");
    write_volume(&path, &volume, &Job::default()).unwrap();
    assert_eq!(fs::read(&path).unwrap()[..8], *b"\x1c\x02\0\0n+2\0");
    assert_eq!(write_and_read(&volume, "nii").volume.grid().dims(), [32_768, 1, 1]);
}

#[test]
fn another_ending_is_refused_with_those_that_are_known() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["volume.mha", "volume", "nii", ".nii"] {
        let path = folder.path().join(name);
        let error = write_volume(&path, &ramp([2, 2, 2], Frame::default()), &Job::default());
        let error = error.unwrap_err().to_string();
        assert!(error.contains(".nrrd, .nhdr, .nii, .nii.gz, .npy or .raw"), "{error}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_cancelled_write_leaves_nothing() {
    let job = Job::default();
    job.cancel.cancel();
    for ending in ENDINGS {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(format!("volume.{ending}"));
        let error = write_volume(&path, &ramp([2, 2, 2], Frame::default()), &job).unwrap_err();
        assert!(matches!(error.fault, WriteFault::Cancelled(_)), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{ending}");
    }
}

#[test]
fn the_same_volume_is_the_same_bytes() {
    let volume = ramp([9, 8, 7], Frame::default());
    for ending in ENDINGS {
        let written = [0, 1].map(|_| {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join(format!("volume.{ending}"));
            write_volume(&path, &volume, &Job::default()).unwrap();
            fs::read(&path).unwrap()
        });
        assert!(written[0] == written[1], "{ending}");
    }
}
