//! Headers of this format, and what they mean.

use crate::{ReadError, VolumeFile, VolumeOptions, open_volume};
use isokit_geom::{Space, Unit};
use isokit_job::Job;
use isokit_volume::Dtype;
use std::fs;

fn try_open(header: &str) -> Result<VolumeFile, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mha");
    let header = format!("{header}\nElementDataFile = LOCAL\n");
    fs::write(&path, [header.as_bytes(), &[0; 24]].concat()).unwrap();
    open_volume(&path, &VolumeOptions::default(), &Job::default())
}

const CUBE: &str = "NDims = 3\nDimSize = 2 3 4\nElementType = MET_UCHAR\n";

#[track_caller]
fn cube(lines: &str) -> VolumeFile {
    try_open(&format!("{CUBE}{lines}")).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn is_refused(header: &str, expected: &str) {
    let error = try_open(header).unwrap_err().to_string();
    assert!(error.contains(expected), "{error}");
}

#[test]
fn each_three_numbers_of_the_matrix_are_the_direction_of_an_axis() {
    let file = cube(
        "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 10 20 30\nElementSpacing = 1 2 3\n\
         AnatomicalOrientation = RAI\nCenterOfRotation = 5 5 5",
    );
    let frame = file.grid().frame;
    assert_eq!(
        frame.index_to_world.columns(),
        [[0.0, 1.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 0.0, 3.0]]
    );
    assert_eq!(frame.index_to_world.origin(), [10.0, 20.0, 30.0]);
    assert_eq!((frame.space, frame.unit), (Space::Lps, Unit::Millimetre));
    assert!(file.notes().is_empty(), "{:?}", file.notes());
}

#[test]
fn keys_have_more_than_one_name() {
    let file = cube("elementsize = 4 4 5\nPosition = 1 2 3\nRotation = 1 0 0 0 1 0 0 0 1");
    let affine = file.grid().frame.index_to_world;
    assert_eq!(affine.point([1.0; 3]), [5.0, 6.0, 8.0]);
    let both = cube("ElementSize = 4 4 5\nElementSpacing = 1 1 2").grid().frame.index_to_world;
    assert_eq!(both.spacing(), [1.0, 1.0, 2.0]);
}

#[test]
fn one_to_four_axes_are_read() {
    let header = |axes: u32, sizes: &str| {
        format!("NDims = {axes}\nDimSize = {sizes}\nElementType = MET_CHAR")
    };
    let open = |axes, sizes| try_open(&header(axes, sizes)).unwrap();
    assert_eq!(open(1, "7").grid().dims(), [7, 1, 1]);
    assert_eq!(open(2, "4 5").grid().dims(), [4, 5, 1]);
    let four = open(4, "2 2 2 3");
    assert_eq!(four.grid().dims(), [2, 2, 2]);
    assert!(four.notes()[0].contains("3 volumes"));
    is_refused(&header(5, "1 1 1 1 1"), "line 1: expected 1 to 4 axes, found \"5\"");
}

#[test]
fn four_axes_have_a_matrix_of_four() {
    let matrix = "TransformMatrix = 1 0 0 0 0 0 1 0 0 1 0 0 0 0 0 1\nOffset = 1 2 3 4";
    let lines = format!("NDims = 4\nDimSize = 1 2 3 4\nElementType = MET_CHAR\n{matrix}");
    let affine = try_open(&lines).unwrap().grid().frame.index_to_world;
    assert_eq!(affine.columns(), [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]);
    assert_eq!(affine.origin(), [1.0, 2.0, 3.0]);
}

#[test]
fn what_cannot_be_read_is_named() {
    let with = |kind: &str| format!("NDims = 3\nDimSize = 1 1 1\nElementType = {kind}");
    is_refused(&with("MET_LONG_LONG"), "line 3: sample type int64 (64-bit integers");
    is_refused(&with("MET_ULONG_LONG"), "line 3: sample type uint64 (64-bit integers");
    is_refused(&with("MET_FLOAT_ARRAY"), "line 3: sample type MET_FLOAT_ARRAY is not supported");
    is_refused(&with("short"), "line 3: expected a type like MET_SHORT");
    let channels = format!("{CUBE}ElementNumberOfChannels = 3");
    is_refused(&channels, "3 numbers per sample: --quantity says what is read of vectors: x, y, z");
    let channels = format!("{CUBE}ElementNumberOfChannels = 4");
    is_refused(&channels, "4 numbers per sample: they are colours, not values");
    let channels = format!("{CUBE}ElementNumberOfChannels = 5");
    is_refused(&channels, "line 4: 5 numbers per sample is not supported");
    is_refused(&format!("ObjectType = Mesh\n{CUBE}"), "line 1: object type \"Mesh\"");
}

#[test]
fn types_are_as_wide_as_metaio_has_them() {
    let of = |kind: &str| {
        try_open(&format!("NDims = 1\nDimSize = 3\nElementType = {kind}")).unwrap().dtype()
    };
    assert_eq!(of("MET_LONG"), Dtype::I32);
    assert_eq!(of("MET_ULONG"), Dtype::U32);
    assert_eq!(of("met_float"), Dtype::F32);
}

#[test]
fn an_unusable_map_names_its_line_and_what_overrides_it() {
    is_refused(&format!("{CUBE}ElementSpacing = 1 0 1"), "line 4: expected a usable map");
    is_refused(&format!("{CUBE}ElementSpacing = 1 0 1"), "(--spacing overrides it)");
    is_refused(&format!("{CUBE}ElementSpacing = 1 nan 1"), "line 4: expected a finite number");
    is_refused(&format!("{CUBE}TransformMatrix = 1 0 0 0 1"), "line 4: expected 3 x 3 numbers");
}

#[test]
fn a_header_without_an_end_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mha");
    fs::write(&path, CUBE).unwrap();
    let error = open_volume(&path, &VolumeOptions::default(), &Job::default()).unwrap_err();
    let expected = "expected ElementDataFile = …, found the end of the file";
    assert!(error.to_string().ends_with(expected), "{error}");
}
