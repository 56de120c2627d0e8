//! Files cut short and files with wrong bytes: an error or a volume, never a panic, and never more
//! memory than allowed.

mod kit;

use isokit_io::{Endian, ReadFault, VolumeOptions, read_volume};
use isokit_job::{Job, Limits};
use isokit_volume::Dtype;
use kit::{Array, Case, bzip2, cases, gzip};
use proptest::prelude::*;
use std::{fs, path::Path};

fn array() -> Array {
    let bytes = (1..=24).flat_map(|n: i16| (n * 1000).to_ne_bytes()).collect();
    Array { dims: [4, 3, 2], dtype: Dtype::I16, bytes }
}

fn limited() -> Job {
    Job { limits: Limits { bytes: 1 << 16 }, ..Job::default() }
}

fn all_cases() -> impl Iterator<Item = Case> {
    [Endian::Little, Endian::Big].into_iter().flat_map(|endian| cases(&array(), endian))
}

/// Reads it, and looks only at what must hold of any outcome.
fn survives(path: &Path, case: &Case, changed: &Path) -> bool {
    match read_volume(path, &case.options, &limited()) {
        Ok(input) => {
            let grid = input.volume.grid();
            assert!(grid.count() <= 1 << 16, "{}: {:?}", case.what, grid.dims());
            true
        }
        Err(error) => {
            let text = error.to_string();
            // In the folder, unless a broken name begins with a slash.
            assert!(error.path.is_absolute(), "{}: {text}", case.what);
            assert!(text.len() < 600, "{}, {}: {text}", case.what, changed.display());
            false
        }
    }
}

#[test]
fn a_file_cut_short_anywhere_is_an_error_or_a_volume() {
    for case in all_cases() {
        let folder = tempfile::tempdir().unwrap();
        let path = case.lay_out(folder.path());
        for (name, bytes) in &case.files {
            let changed = folder.path().join(name);
            let mut opened = 0;
            for length in 0..bytes.len() {
                fs::write(&changed, &bytes[..length]).unwrap();
                opened += usize::from(survives(&path, &case, &changed));
            }
            // Trailers of packed streams, ends of headers, and lists are not samples.
            assert!(opened <= 24, "{}: {name} opened {opened} times", case.what);
            fs::write(&changed, bytes).unwrap();
        }
        assert!(survives(&path, &case, &path), "{}", case.what);
    }
}

#[test]
fn a_wrong_byte_anywhere_is_an_error_or_a_volume() {
    for case in cases(&array(), Endian::Big) {
        let folder = tempfile::tempdir().unwrap();
        let path = case.lay_out(folder.path());
        for (name, bytes) in &case.files {
            let changed = folder.path().join(name);
            for place in 0..bytes.len().min(700) {
                let right = bytes[place];
                let wrong = [0, 0xff, b'9', b'\n', right ^ 1];
                for wrong in wrong.into_iter().filter(|&wrong| wrong != right) {
                    let mut bytes = bytes.clone();
                    bytes[place] = wrong;
                    fs::write(&changed, &bytes).unwrap();
                    survives(&path, &case, &changed);
                }
            }
            fs::write(&changed, bytes).unwrap();
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    #[test]
    fn bytes_written_over_doubled_and_taken_out_break_nothing(
        which in any::<prop::sample::Index>(),
        edits in proptest::collection::vec((0..3, any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let cases: Vec<_> = all_cases().collect();
        let mut case = which.get(&cases).clone();
        for (kind, place, byte) in edits {
            let bytes = &mut case.files[0].1;
            // Mostly in the header, where it matters.
            let place = place.index(bytes.len().min(400));
            match kind {
                0 => bytes[place] = byte,
                1 => bytes.insert(place, byte),
                _ => drop(bytes.remove(place)),
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let path = case.lay_out(folder.path());
        survives(&path, &case, &path);
    }
}

fn fault_of(name: &str, bytes: &[u8], job: &Job) -> ReadFault {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    read_volume(&path, &VolumeOptions::default(), job).unwrap_err().fault
}

fn huge_nrrd(encoding: &str, data: &[u8]) -> Vec<u8> {
    let header = format!(
        "NRRD0004\ntype: double\ndimension: 3\nsizes: 100000 100000 100000\n\
         endian: little\nencoding: {encoding}\n\n"
    );
    [header.as_bytes(), data].concat()
}

#[test]
fn a_header_that_promises_petabytes_is_held_against_the_file() {
    let promised = 8_000_000_000_000_000;
    let short = [0; 1000];
    for (encoding, data, holds) in [
        ("raw", short.to_vec(), 1000),
        ("gzip", gzip(&short), 1000),
        ("bzip2", bzip2(&short), 1000),
        ("ascii", b"1 2 3".to_vec(), 5),
    ] {
        match fault_of("a.nrrd", &huge_nrrd(encoding, &data), &Job::default()) {
            ReadFault::Truncated { announced, held, .. } => {
                let least = if encoding == "ascii" { 1_999_999_999_999_999 } else { promised };
                assert_eq!((announced, held), (least, holds), "{encoding}");
            }
            other => panic!("{encoding}: {other}"),
        }
    }
}

#[test]
fn more_memory_than_allowed_is_the_callers_choice() {
    let header = b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 100 100 10\nencoding: raw\n\n";
    let file = [&header[..], &[0; 100_000]].concat();
    let job = Job { limits: Limits { bytes: 99_999 }, ..Job::default() };
    match fault_of("a.nrrd", &file, &job) {
        ReadFault::OverLimit(over) => assert_eq!((over.needed, over.limit), (100_000, 99_999)),
        other => panic!("{other}"),
    }
}

#[test]
fn a_cancelled_job_reads_nothing() {
    let header = b"NRRD0004\ntype: uchar\ndimension: 1\nsizes: 2\nencoding: raw\n\nab";
    let job = Job::default();
    job.cancel.cancel();
    let fault = fault_of("a.nrrd", header, &job);
    assert!(matches!(fault, ReadFault::Cancelled(_)), "{fault}");
}

#[test]
fn packed_samples_with_a_wrong_sum_are_refused() {
    let header = b"NRRD0004\ntype: uchar\ndimension: 1\nsizes: 900\nencoding: gzip\n\n";
    let mut packed = gzip(&[7; 900]);
    let sum = packed.len() - 8;
    packed[sum] ^= 1;
    let fault = fault_of("a.nrrd", &[&header[..], &packed].concat(), &Job::default());
    assert!(fault.to_string().contains("expected sound compressed data"), "{fault}");
}

#[test]
fn a_series_of_a_billion_files_stops_at_the_first_that_is_missing() {
    let header = b"NRRD0004\ntype: uchar\ndimension: 2\nsizes: 1 1000000000\nencoding: raw\n\
                   data file: s%d.raw 1 1000000000 1\n";
    let fault = fault_of("a.nhdr", header, &Job::default());
    assert!(fault.to_string().contains("it holds the samples of a.nhdr"), "{fault}");
}

#[test]
fn headers_that_contradict_themselves_say_where() {
    let nrrd = |lines: &str| format!("NRRD0004\n{lines}\n\n").into_bytes();
    let meta = |lines: &str| format!("NDims = 3\n{lines}\nElementDataFile = LOCAL\n").into_bytes();
    let cases = [
        ("a.nrrd", nrrd("type: short"), r#"line 3: expected the field "dimension", found the end"#),
        ("a.nrrd", nrrd("dimension: 17"), "line 2: expected 1 to 16 axes, found \"17\""),
        ("a.nrrd", nrrd("dimension: 3\nsizes: 3 4"), "line 3: expected 3 values, one per axis"),
        ("a.nrrd", nrrd("dimension: 1\nsizes: 0"), "line 3: expected sizes above 0"),
        ("a.nrrd", nrrd("what is this"), "line 2: expected a field (name: value)"),
        ("a.mha", meta("DimSize = 3 4"), "line 2: expected 3 sizes above 0, found \"3 4\""),
        ("a.mha", meta("DimSize = 1 1 1"), "line 3: expected ElementType = … before it"),
        ("a.npy", b"\x93NUMPY\x09\0\0\0\0\0\0\0".to_vec(), "byte 6: expected version 1, 2 or 3"),
        ("a.nii", vec![1; 348], "byte 0: expected a header size of 348 or 540"),
        ("a.nii", vec![], "header announces 348 bytes of header, file holds 0"),
        ("a.raw", vec![0; 8], "a file without header: give its sizes and sample type"),
        ("a.stl", vec![0; 8], "this is a mesh (STL), not a volume"),
    ];
    for (name, bytes, expected) in cases {
        let fault = fault_of(name, &bytes, &Job::default()).to_string();
        assert!(fault.contains(expected), "{fault}, expected {expected}");
    }
}
