//! Headers of this format, and what they mean.

use crate::{ReadError, VolumeFile, VolumeOptions, open_volume};
use isokit_geom::Frame;
use isokit_job::Job;
use isokit_volume::{AnyVolume, Dtype};
use std::fs;

fn file_of(dictionary: &str) -> Vec<u8> {
    let length = (dictionary.len() as u16).to_le_bytes();
    let start = [b"\x93NUMPY\x01\0".as_slice(), &length, dictionary.as_bytes()].concat();
    [start, (0..240).collect()].concat()
}

fn try_open(dictionary: &str, options: &VolumeOptions) -> Result<VolumeFile, ReadError> {
    Ok(try_read(dictionary, options)?.0)
}

/// The file as it was opened, and what was in it.
fn try_read(
    dictionary: &str,
    options: &VolumeOptions,
) -> Result<(VolumeFile, AnyVolume), ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    fs::write(&path, file_of(dictionary)).unwrap();
    let file = open_volume(&path, options, &Job::default())?;
    let volume = file.clone().collect(&Job::default())?;
    assert_eq!(volume.grid(), file.grid());
    Ok((file, volume))
}

fn open(descr: &str, order: &str, shape: &str) -> VolumeFile {
    let text = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}");
    try_open(&text, &VolumeOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn is_refused(dictionary: &str, expected: &str) {
    let error = try_open(dictionary, &VolumeOptions::default()).unwrap_err().to_string();
    assert!(error.contains(expected), "{error}");
}

#[test]
fn an_array_is_indexed_z_y_x() {
    assert_eq!(open("|u1", "False", "(4, 3, 2)").grid().dims(), [2, 3, 4]);
    assert_eq!(open("|u1", "True", "(4, 3, 2)").grid().dims(), [2, 3, 4]);
    assert_eq!(open("|u1", "False", "(4, 3)").grid().dims(), [3, 4, 1]);
    assert_eq!(open("|u1", "True", "(4,)").grid().dims(), [4, 1, 1]);
    assert_eq!(open("|u1", "False", "(4L, 3L, 2L)").grid().frame, Frame::default());
}

#[test]
fn more_axes_count_volumes() {
    let file = open("|u1", "False", "(2, 5, 4, 3, 2)");
    assert_eq!(file.grid().dims(), [2, 3, 4]);
    assert!(file.notes()[0].contains("10 volumes"));
    let text = "{'descr': '|u1', 'fortran_order': False, 'shape': (10, 4, 3, 2)}";
    let last = VolumeOptions { volume_index: Some(9), ..Default::default() };
    match try_read(text, &last).unwrap().1 {
        AnyVolume::U8(volume) => assert_eq!(volume.samples()[0], 9 * 24),
        other => panic!("{}", other.dtype()),
    }
    is_refused(
        "{'descr': '|u1', 'fortran_order': True, 'shape': (2, 4, 3, 2)}",
        "Fortran order with more than three axes is not supported",
    );
}

#[test]
fn types_and_byte_orders_are_told_apart() {
    let dtype = |descr: &str| open(descr, "False", "(3,)").dtype();
    assert_eq!(dtype("|b1"), Dtype::U8);
    assert_eq!(dtype("|i1"), Dtype::I8);
    assert_eq!(dtype("=u2"), Dtype::U16);
    assert_eq!(dtype("f8"), Dtype::F64);
    let first = |descr: &str| {
        let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (3,)}}");
        match try_read(&text, &VolumeOptions::default()).unwrap().1 {
            AnyVolume::U16(volume) => volume.samples()[0],
            other => panic!("{}", other.dtype()),
        }
    };
    assert_eq!((first("<u2"), first(">u2")), (0x0100, 0x0001));
}

#[test]
fn types_that_cannot_be_read_are_named() {
    for (descr, named) in [
        ("'<i8'", "sample type int64 (64-bit integers; convert to i32 or f64) is not supported"),
        ("'>u8'", "sample type uint64 (64-bit integers"),
        ("'<f2'", "sample type float16 is not supported"),
        ("'<c16'", "sample type complex128"),
        ("'<U5'", "sample type \"U5\""),
        ("[('x', '<f4'), ('y', '<f4')]", "an array of records is not supported"),
    ] {
        let text = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (3,)}}");
        is_refused(&text, named);
        is_refused(&text, "NPY, byte 20: ");
    }
}

#[test]
fn a_dictionary_that_says_too_little_is_refused() {
    is_refused("{'shape': (3,)}", "byte 10: expected 'descr' with a sample type");
    is_refused("{'descr': '|u1'}", "expected 'shape' with one size or more");
    is_refused("{'descr': '|u1', 'shape': ()}", "expected 'shape' with one size or more");
    is_refused("{'descr': '|u1', 'shape': (3, 0)}", "expected 'shape' with one size or more");
    is_refused("{'descr': '|u1', 'shape': (3, -1)}", "found \"(3, -1)}\"");
    is_refused("{'descr': '|u1', 'shape': (3,)}", "expected 'fortran_order' with True or False");
    is_refused("{'descr': u1, 'shape': (3,)}", "'descr' with a sample type like '<i2'");
    let much = "{'descr': '|u1', 'fortran_order': False, 'shape': (99, 99)}";
    is_refused(much, "9801 bytes of samples, file holds 240");
}

#[test]
fn a_spacing_from_the_caller_needs_no_note() {
    let (spacing, origin) = (Some([1.0, 2.0, 3.0]), Some([4.0, 5.0, 6.0]));
    let options = VolumeOptions { spacing, origin, ..Default::default() };
    let text = "{'descr': '|u1', 'fortran_order': False, 'shape': (10, 4, 6)}";
    let file = try_open(text, &options).unwrap();
    assert_eq!(file.grid().frame.index_to_world.point([1.0; 3]), [5.0, 7.0, 9.0]);
    assert!(file.notes().is_empty(), "{:?}", file.notes());
}
