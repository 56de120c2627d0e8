//! Parts of files of all kinds, and what of them is never looked at.

use crate::{VolumeOptions, open_volume};
use flate2::{Compression, write::GzEncoder};
use isokit_job::{Job, Limits};
use isokit_volume::{AnyVolume, Quantity, for_any};
use std::{fs, io::Write, ops::Range, path::Path};
use tempfile::TempDir;

const DIMS: [usize; 3] = [5, 4, 6];

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packed = GzEncoder::new(vec![], Compression::fast());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

/// Samples that are all different: no two bytes of one are alike.
fn samples() -> Vec<u8> {
    (0..DIMS.iter().product::<usize>() as u16).flat_map(|n| (n * 257 + 1).to_be_bytes()).collect()
}

fn nrrd(fields: &str) -> String {
    format!("NRRD0004\ntype: ushort\ndimension: 3\nsizes: 5 4 6\n{fields}\n")
}

/// The same samples in files of all kinds, with their names.
fn files(folder: &Path) -> Vec<&'static str> {
    let (all, write) =
        (samples(), |name: &str, bytes: &[u8]| fs::write(folder.join(name), bytes).unwrap());
    let attached = |fields: &str, bytes: &[u8]| [nrrd(fields).as_bytes(), b"\n", bytes].concat();
    write("raw.nrrd", &attached("endian: big\nencoding: raw", &all));
    write("gzip.nrrd", &attached("endian: big\nencoding: gzip", &gzip(&all)));
    write("around.nrrd.gz", &gzip(&attached("endian: big\nencoding: raw", &all)));
    let words: Vec<String> =
        all.chunks(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]]).to_string()).collect();
    write("text.nrrd", &attached("encoding: text", words.join(" ").as_bytes()));
    // Two slices in each of three files, and three in two after some bytes.
    for (name, count) in [("pair", 3), ("half", 2)] {
        let bytes = all.len() / count;
        for n in 0..count {
            write(&format!("{name}{n}.raw"), &all[n * bytes..(n + 1) * bytes]);
        }
        let data = format!("data file: {name}%d.raw 0 {} 1 3", count - 1);
        let fields = format!("endian: big\nencoding: raw\n{data}");
        write(&format!("{name}.nhdr"), nrrd(&fields).as_bytes());
    }
    for (name, order) in [("c.npy", "False"), ("fortran.npy", "True")] {
        let text = format!("{{'descr': '>u2', 'fortran_order': {order}, 'shape': (6, 4, 5), }}");
        let length = (text.len() as u16).to_le_bytes();
        let head = [b"\x93NUMPY\x01\0".as_slice(), &length, text.as_bytes()].concat();
        write(name, &[head, all.clone()].concat());
    }
    let names = ["raw.nrrd", "gzip.nrrd", "around.nrrd.gz", "text.nrrd", "pair.nhdr", "half.nhdr"];
    names.into_iter().chain(["c.npy", "fortran.npy"]).collect()
}

fn value(volume: &AnyVolume, ijk: [usize; 3]) -> f64 {
    for_any!(volume, volume => volume.view().value(ijk))
}

/// Compares a part with that of the whole, and what is not wanted with 0.
#[track_caller]
fn check(path: &Path, options: &VolumeOptions, part: [Range<u64>; 3], wanted: [Range<u64>; 3]) {
    let job = Job::default();
    let file = open_volume(path, options, &job).unwrap();
    let whole = file.clone().collect(&job).unwrap();
    let has_all = !file.has_slices();
    let found = file.collect_part(part.clone(), wanted.clone(), &job).unwrap();
    let name = path.display();
    assert_eq!(found.grid().dims(), part.each_ref().map(|range| range.end - range.start));
    assert_eq!(found.scaling(), whole.scaling());
    let start = part.each_ref().map(|range| range.start as usize);
    assert_eq!(found.grid().frame, whole.grid().frame.starting_at(start).unwrap());
    for k in part[2].clone() {
        for (j, i) in part[1].clone().flat_map(|j| part[0].clone().map(move |i| (j, i))) {
            let ijk = [i, j, k];
            let is_wanted = has_all || (0..3).all(|k| wanted[k].contains(&ijk[k]));
            let expected = if is_wanted { value(&whole, ijk.map(|i| i as usize)) } else { 0.0 };
            let within = std::array::from_fn(|k| ijk[k] as usize - start[k]);
            assert_eq!(value(&found, within), expected, "{name}: {ijk:?} of {part:?}, {wanted:?}");
        }
    }
}

#[test]
fn a_part_has_the_samples_of_the_whole_whatever_the_file() {
    let folder = TempDir::new().unwrap();
    let all = DIMS.map(|n| 0..n as u64);
    let parts = [
        all.clone(),
        [0..5, 0..4, 2..5],
        [0..5, 1..3, 0..6],
        [2..4, 0..4, 1..2],
        [1..5, 3..4, 5..6],
        [0..1, 0..1, 0..1],
    ];
    for name in files(folder.path()) {
        let path = folder.path().join(name);
        for part in &parts {
            let options = VolumeOptions::default();
            check(&path, &options, part.clone(), part.clone());
            check(&path, &options, all.clone(), part.clone());
        }
        check(&path, &VolumeOptions::default(), [1..5, 0..4, 1..6], [2..4, 1..3, 1..4]);
    }
}

#[test]
fn of_vectors_all_is_read_and_the_part_is_that_of_the_whole() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("flow.nrrd");
    let head = "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 5 4 2\nencoding: raw\nkinds: vector domain domain domain\n\n";
    fs::write(&path, [head.as_bytes(), &samples()[..120]].concat()).unwrap();
    let options = VolumeOptions { quantity: Some(Quantity::Speed), ..Default::default() };
    check(&path, &options, [1..4, 0..4, 1..2], [1..4, 0..4, 1..2]);
    check(&path, &options, [1..4, 0..4, 0..2], [2..4, 0..1, 1..2]);
}

#[test]
fn what_is_not_wanted_is_not_looked_at() {
    let folder = TempDir::new().unwrap();
    let (job, wanted) = (Job::default(), [0..5, 0..4, 0..2]);
    files(folder.path());
    let is_read_in_part = |name: &str, wanted: [Range<u64>; 3]| {
        let file = open_volume(&folder.path().join(name), &VolumeOptions::default(), &job);
        let file = file.unwrap();
        assert!(file.clone().collect(&job).is_err(), "{name}");
        assert!(file.collect_part(wanted.clone(), wanted, &job).is_ok(), "{name}");
    };
    let cut_off = |name: &str| {
        let path = folder.path().join(name);
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    };
    cut_off("text.nrrd");
    is_read_in_part("text.nrrd", wanted.clone());
    // Noise, which takes its own length.
    let mut state = 1_u32;
    let noise: Vec<u8> = (0..64 * 64 * 64)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
        .collect();
    let head = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 64 64 64\nencoding: gzip\n\n";
    fs::write(folder.path().join("noise.nrrd"), [head.as_bytes(), &gzip(&noise)].concat()).unwrap();
    cut_off("noise.nrrd");
    is_read_in_part("noise.nrrd", [0..64, 0..64, 0..2]);
    let file = open_volume(&folder.path().join("pair.nhdr"), &VolumeOptions::default(), &job);
    fs::remove_file(folder.path().join("pair2.raw")).unwrap();
    assert!(file.as_ref().unwrap().clone().collect(&job).is_err());
    assert!(file.unwrap().collect_part(wanted.clone(), wanted, &job).is_ok());
}

#[test]
fn a_limit_is_of_the_part() {
    let folder = TempDir::new().unwrap();
    files(folder.path());
    let limited = Job { limits: Limits { bytes: 79 }, ..Job::default() };
    let path = folder.path().join("raw.nrrd");
    let file = open_volume(&path, &VolumeOptions::default(), &limited).unwrap();
    let part = |z: Range<u64>| [0..5, 0..4, z];
    let fits =
        |part: [Range<u64>; 3], wanted| file.clone().collect_part(part, wanted, &limited).is_ok();
    assert!(fits(part(3..4), part(3..4)));
    assert!(!fits(part(3..5), part(3..4)) && !fits(part(3..5), part(3..5)));
}
