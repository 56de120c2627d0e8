//! Headers of this format, and what they mean.

use crate::{ReadError, VolumeFile, VolumeOptions, open_volume};
use isokit_geom::{Space, Unit};
use isokit_job::Job;
use isokit_volume::Dtype;
use std::fs;

/// A header with these lines above `encoding: raw`, and enough samples for 240 bytes.
fn try_open(lines: &str) -> Result<VolumeFile, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    let header = format!("NRRD0004\n{lines}\nencoding: raw\n\n");
    fs::write(&path, [header.as_bytes(), &[0; 240]].concat()).unwrap();
    open_volume(&path, &VolumeOptions::default(), &Job::default())
}

#[track_caller]
fn open(lines: &str) -> VolumeFile {
    try_open(lines).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn is_refused(lines: &str, expected: &str) {
    let error = try_open(lines).unwrap_err().to_string();
    assert!(error.contains(expected), "{error}");
}

const CUBE: &str = "type: uchar\ndimension: 3\nsizes: 2 3 4\n";

fn cube(lines: &str) -> VolumeFile {
    open(&format!("{CUBE}{lines}"))
}

#[test]
fn directions_are_columns_and_none_of_them_need_be_along_an_axis() {
    let file = cube(
        "space: left-posterior-superior\nspace directions: (0, 2,0) (-1,0,0.5) (0,0,3)\n\
         space origin: (1,2 , 3)\nspace units: \"um\" \"um\" \"um\"",
    );
    let frame = file.grid().frame;
    assert_eq!(
        frame.index_to_world.columns(),
        [[0.0, 2.0, 0.0], [-1.0, 0.0, 0.5], [0.0, 0.0, 3.0]]
    );
    assert_eq!(frame.index_to_world.origin(), [1.0, 2.0, 3.0]);
    assert_eq!((frame.space, frame.unit), (Space::Lps, Unit::Micrometre));
    assert!(file.notes().iter().all(|note| note.contains("216 bytes after")), "{:?}", file.notes());
}

#[test]
fn every_space_becomes_a_right_handed_world() {
    let corner = |space: &str| {
        let lines = format!("space: {space}\nspace directions: (1,0,0) (0,1,0) (0,0,1)");
        let frame = cube(&lines).grid().frame;
        (frame.space, frame.index_to_world.point([1.0; 3]))
    };
    assert_eq!(corner("right-anterior-superior"), (Space::Ras, [1.0; 3]));
    assert_eq!(corner("RAS"), (Space::Ras, [1.0; 3]));
    assert_eq!(corner("LPS"), (Space::Lps, [1.0; 3]));
    assert_eq!(corner("left-anterior-superior"), (Space::Ras, [-1.0, 1.0, 1.0]));
    assert_eq!(corner("scanner-xyz"), (Space::Unknown, [1.0; 3]));
    assert_eq!(corner("3D-right-handed"), (Space::Unknown, [1.0; 3]));
    assert_eq!(corner("3D-left-handed"), (Space::Unknown, [1.0, 1.0, -1.0]));
    is_refused(&format!("{CUBE}space: outer"), "line 5: expected a space like");
}

#[test]
fn a_reflection_is_noted() {
    let notes = cube("space: 3D-left-handed\nspacings: 1 2 3").notes().join("; ");
    assert!(notes.contains("the space is left-handed; z is reflected"), "{notes}");
}

#[test]
fn directions_need_no_space_and_spacings_may_be_unknown() {
    let file = cube("space directions: (2,0,0) (0,2,0) (0,0,2)");
    assert_eq!(file.grid().frame.index_to_world.spacing(), [2.0; 3]);
    assert_eq!(file.grid().frame.space, Space::Unknown);
    let file = cube("spacings: 2 nan NaN");
    assert_eq!(file.grid().frame.index_to_world.spacing(), [2.0, 1.0, 1.0]);
}

#[test]
fn units_are_assumed_where_nobody_gives_them() {
    let unit = |lines: &str| {
        let file = cube(lines);
        let assumed = file.notes().iter().any(|note| note.contains("assumed"));
        (file.grid().frame.unit, assumed)
    };
    assert_eq!(unit("spacings: 1 1 1"), (Unit::Millimetre, true));
    assert_eq!(unit("space units: \"\" \"\" \"\""), (Unit::Millimetre, true));
    assert_eq!(unit("space units: \"mm\" \"mm\" \"mm\""), (Unit::Millimetre, false));
    assert_eq!(unit("units: \"nm\" \"nm\" \"nm\""), (Unit::Nanometre, false));
    assert_eq!(unit("space units: \"unknown\" \"unknown\" \"unknown\""), (Unit::Unknown, false));
    assert_eq!(unit("space units: \"mm\" \"mm\" \"m\""), (Unit::Unknown, false));
    is_refused(&format!("{CUBE}space units: mm"), "line 5: expected words in quotes");
}

#[test]
fn values_are_in_what_the_file_says_and_in_nothing_else() {
    let unit = |lines: &str| cube(lines).sample_unit().map(str::to_owned);
    assert_eq!(unit("sample units: HU"), Some("HU".into()));
    assert_eq!(unit("sample units: \"degrees Celsius\""), Some("degrees Celsius".into()));
    assert_eq!([unit("sample units: ???"), unit("spacings: 1 1 1")], [None, None]);
    let flow = "type: uchar\ndimension: 4\nsizes: 3 2 3 4\nkinds: vector domain domain domain\n\
                sample units: m/s";
    is_refused(flow, "--quantity says what is read of vectors");
}

#[test]
fn a_list_of_volumes_comes_last_and_never_first() {
    let lines = "type: uchar\ndimension: 4\nsizes: 2 3 4 5\nkinds: domain domain domain list";
    let file = open(lines);
    assert_eq!(file.grid().dims(), [2, 3, 4]);
    assert!(file.notes().iter().any(|note| note.contains("5 volumes")));
    let flows =
        "type: uchar\ndimension: 5\nsizes: 2 3 4 3 5\nkinds: domain domain domain vector time";
    assert!(open(flows).notes().iter().any(|note| note.contains("15 volumes")));
    // Where vectors point is for who asks for vectors.
    let frame = lines.to_owned() + "\nmeasurement frame: none none none";
    assert_eq!(open(&frame).grid().dims(), [2, 3, 4]);
    is_refused(
        "type: uchar\ndimension: 4\nsizes: 3 2 3 4\nkinds: RGB-color domain domain domain",
        "3 numbers per sample (axis 0, rgb-color): they are colours, not values",
    );
    is_refused(
        "type: uchar\ndimension: 4\nsizes: 3 2 3 4\n\
         space directions: none (1,0,0) (0,1,0) (0,0,1)",
        "3 numbers per sample (axis 0, no kind)",
    );
    let single = "type: uchar\ndimension: 4\nsizes: 1 2 3 4\n\
                  space directions: none (1,0,0) (0,1,0) (0,0,1)";
    assert_eq!(open(single).grid().dims(), [2, 3, 4]);
}

#[test]
fn missing_axes_have_size_1() {
    let file = open("type: short\ndimension: 1\nsizes: 7\nspacings: 0.5\nendian: little");
    assert_eq!(file.grid().dims(), [7, 1, 1]);
    let lines = "type: uchar\ndimension: 2\nsizes: 5 6\nspace dimension: 2\n\
                 space directions: (0,2) (3,0)";
    let file = open(lines);
    assert_eq!(file.grid().dims(), [5, 6, 1]);
    let columns = file.grid().frame.index_to_world.columns();
    assert_eq!(columns, [[0.0, 2.0, 0.0], [3.0, 0.0, 0.0], [0.0, 0.0, -1.0]]);
}

#[test]
fn types_have_many_names_and_some_are_refused_by_name() {
    let dtype =
        |name: &str| open(&format!("type: {name}\ndimension: 1\nsizes: 3\nendian: little")).dtype();
    assert_eq!(dtype("signed  char"), Dtype::I8);
    assert_eq!(dtype("UCHAR"), Dtype::U8);
    assert_eq!(dtype("unsigned short int"), Dtype::U16);
    assert_eq!(dtype("int32_t"), Dtype::I32);
    assert_eq!(dtype("double"), Dtype::F64);
    let rest = "\ndimension: 1\nsizes: 3";
    is_refused(&format!("type: long long{rest}"), "line 2: sample type int64 (64-bit integers");
    is_refused(&format!("type: uint64_t{rest}"), "line 2: sample type uint64 (64-bit integers");
    is_refused(&format!("type: block{rest}"), "line 2: sample type block is not supported");
    is_refused(&format!("type: half{rest}"), "line 2: expected a type like short or float");
}

#[test]
fn a_missing_byte_order_is_assumed_where_it_matters() {
    let notes = |kind: &str| {
        let file = open(&format!("type: {kind}\ndimension: 1\nsizes: 3"));
        file.notes().iter().any(|note| note == "no endian given; little is assumed")
    };
    assert!(notes("short"));
    assert!(!notes("uchar"));
}

#[test]
fn comments_pairs_and_unknown_fields_say_nothing_of_samples() {
    let file =
        cube("# type: double\ntype:=double\nmeasurement frame: (1,0,0)\nfancy: 3\ncontent: a:=b");
    assert_eq!(file.dtype(), Dtype::U8);
    is_refused(&format!("{CUBE}type: short"), "line 5: expected each field once, found type again");
}

#[test]
fn unusable_maps_name_their_line() {
    let flat = "space directions: (1,0,0) (2,0,0) (0,0,1)";
    is_refused(&format!("{CUBE}{flat}"), "line 5: expected a usable map from samples");
    is_refused(&format!("{CUBE}spacings: 1 0 1"), "axis 1 has length 0");
    is_refused(&format!("{CUBE}spacings: 1 inf 1"), "line 5: expected a usable map");
    is_refused(&format!("{CUBE}space directions: (1,0,0) (0,1,0)"), "3 values, one per axis");
    is_refused(&format!("{CUBE}space directions: (1,0,x) none none"), "vectors like (1,0,0)");
}
