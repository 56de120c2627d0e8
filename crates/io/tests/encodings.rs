//! One array in every format, encoding, byte order and way of splitting files reads as that array.

mod kit;

use isokit_io::{Endian, VolumeFile, VolumeOptions, open_volume, read_volume};
use isokit_job::Job;
use isokit_volume::{AnyVolume, Dtype, Sample, SlabSource, for_any, for_dtype};
use kit::{Array, cases};
use proptest::prelude::*;

fn bytes_of(volume: &AnyVolume) -> Vec<u8> {
    for_any!(volume, volume => bytemuck::cast_slice(volume.samples()).to_vec())
}

/// Some slices at a time, as a reader with little memory would ask for them.
fn in_slabs<T: Sample>(file: VolumeFile, at_a_time: u64) -> Vec<u8> {
    let grid = *file.grid();
    let mut source = file.into_source::<T>().unwrap();
    let mut slices = vec![T::default(); grid.count() as usize];
    for slab in slices.chunks_mut((grid.slice_count() * at_a_time) as usize) {
        source.fill(slab).unwrap();
    }
    bytemuck::cast_slice(&slices).to_vec()
}

fn check(array: &Array, endian: Endian, at_a_time: u64) {
    for case in cases(array, endian) {
        let folder = tempfile::tempdir().unwrap();
        let path = case.lay_out(folder.path());
        let what = case.what;
        let read = read_volume(&path, &case.options, &Job::default());
        let volume = read.unwrap_or_else(|error| panic!("{what}: {error}")).volume;
        assert_eq!(volume.grid().dims(), array.dims, "{what}");
        assert_eq!(volume.dtype(), array.dtype, "{what}");
        assert!(bytes_of(&volume) == array.bytes, "{what}");
        let file = open_volume(&path, &case.options, &Job::default()).unwrap();
        let slabs = for_dtype!(array.dtype, T => in_slabs::<T>(file, at_a_time));
        assert!(slabs == array.bytes, "{what}, in slabs");
    }
}

fn any_array() -> impl Strategy<Value = Array> {
    let dims = [1..6_u64, 1..6_u64, 1..6_u64];
    (dims, proptest::sample::select(&Dtype::ALL)).prop_flat_map(|(dims, dtype)| {
        let count = dims.iter().product::<u64>() as usize * dtype.bytes();
        let bytes = proptest::collection::vec(any::<u8>(), count);
        bytes.prop_map(move |bytes| Array { dims, dtype, bytes })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn every_encoding_of_an_array_reads_as_the_array(
        array in any_array(),
        big in any::<bool>(),
        at_a_time in 1..3_u64,
    ) {
        check(&array, if big { Endian::Big } else { Endian::Little }, at_a_time);
    }
}

#[test]
fn a_ramp_larger_than_a_buffer_reads_in_every_encoding() {
    let (dims, dtype) = ([70, 41, 37], Dtype::U16);
    let ramp = (0..70 * 41 * 37).flat_map(|n: u32| (n as u16).to_ne_bytes());
    let array = Array { dims, dtype, bytes: ramp.collect() };
    check(&array, Endian::Little, 5);
    check(&array, Endian::Big, 37);
}

#[test]
fn samples_as_text_are_read_as_their_type() {
    let headers = [
        ("a.nrrd", "NRRD0004\ntype: TYPE\ndimension: 2\nsizes: 3 2\nencoding: ascii\n\n"),
        (
            "a.mha",
            "NDims = 2\nDimSize = 3 2\nElementType = TYPE\nBinaryData = False\n\
             ElementDataFile = LOCAL\n",
        ),
    ];
    let types = [("short", "MET_SHORT"), ("float", "MET_FLOAT")];
    for (name, header) in headers {
        for (nrrd, meta) in types {
            let kind = if name == "a.nrrd" { nrrd } else { meta };
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join(name);
            let read = |samples: &str| {
                std::fs::write(&path, header.replace("TYPE", kind) + samples).unwrap();
                read_volume(&path, &VolumeOptions::default(), &Job::default())
            };
            let volume = read("1, -2 3\n\n4\t5 32767").unwrap().volume;
            let values = for_any!(&volume, volume => {
                volume.samples().iter().map(|sample| sample.to_f64()).collect::<Vec<_>>()
            });
            assert_eq!(values, [1.0, -2.0, 3.0, 4.0, 5.0, 32767.0]);
            let error = read("1 2 3 4 5").unwrap_err().to_string();
            assert!(error.contains("file holds 9"), "{error}");
            let error = read("1 2 3 4    5").unwrap_err().to_string();
            assert!(error.contains("expected a sample of type"), "{error}");
            assert!(error.ends_with("found the end"), "{error}");
            let error = read("1 2 3 4 five 6").unwrap_err().to_string();
            assert!(error.ends_with(r#"found "five""#), "{error}");
        }
    }
}
