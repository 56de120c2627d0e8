//! Vectors in files of every format that holds them.

use crate::{VolumeOptions, read_volume};
use isokit_job::Job;
use isokit_volume::{AnyVolume, Quantity};
use std::{fs, path::Path};

/// A lattice of 2 × 3 × 4 vectors, a different one at each sample.
const COUNT: usize = 24;

fn vector(n: usize) -> [f32; 3] {
    [n as f32, 100.0 - n as f32, 0.5 * n as f32]
}

/// The numbers of all samples, those of a sample together or apart.
fn numbers(together: bool) -> Vec<u8> {
    let all = |n: usize| match together {
        true => vector(n / 3)[n % 3],
        false => vector(n % COUNT)[n / COUNT],
    };
    (0..3 * COUNT).flat_map(|n| all(n).to_le_bytes()).collect()
}

fn read(path: &Path, quantity: Option<Quantity>) -> Result<Vec<f32>, String> {
    let options = VolumeOptions { quantity, ..VolumeOptions::default() };
    let input = read_volume(path, &options, &Job::default()).map_err(|error| error.to_string())?;
    assert_eq!(input.volume.grid().dims(), [2, 3, 4]);
    match input.volume {
        AnyVolume::F32(volume) => Ok(volume.samples().to_vec()),
        _ => Err("expected f32".into()),
    }
}

/// A file's components and speed are those of its vectors, seen along `signs`; as a volume it is refused.
#[track_caller]
fn check(name: &str, header: &[u8], together: bool, signs: [f32; 3]) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, [header, &numbers(together)].concat()).unwrap();
    for (axis, sign) in signs.into_iter().enumerate() {
        let found = read(&path, Some(Quantity::Component(axis))).unwrap();
        let expected = (0..COUNT).map(|n| sign * vector(n)[axis]);
        assert!(found.iter().copied().eq(expected), "{found:?}");
    }
    let speed = read(&path, Some(Quantity::Speed)).unwrap();
    for (n, speed) in speed.into_iter().enumerate() {
        let square: f32 = vector(n).iter().map(|c| c * c).sum();
        assert!((speed - square.sqrt()).abs() < 1e-4);
    }
    let refusal = read(&path, None).unwrap_err();
    assert!(
        refusal.contains("--quantity says what is read of vectors: x, y, z, speed"),
        "{refusal}"
    );
}

fn nrrd(lines: &str) -> Vec<u8> {
    format!("NRRD0004\ntype: float\nendian: little\nencoding: raw\ndimension: 4\n{lines}\n\n")
        .into()
}

#[test]
fn nrrd_has_its_axis_of_vectors_first_or_last() {
    let first = "sizes: 3 2 3 4\nkinds: vector domain domain domain";
    check("a.nrrd", &nrrd(first), true, [1.0; 3]);
    let first = "sizes: 3 2 3 4\nspace directions: none (1,0,0) (0,1,0) (0,0,1)";
    check("a.nrrd", &nrrd(first), true, [1.0; 3]);
    let last = "sizes: 2 3 4 3\nkinds: domain domain domain 3-vector";
    check("a.nrrd", &nrrd(last), false, [1.0; 3]);
}

#[test]
fn vectors_of_a_nrrd_are_turned_with_its_world() {
    let las = "sizes: 3 2 3 4\nspace: left-anterior-superior\nkinds: vector space space space\n\
               space directions: none (1,0,0) (0,1,0) (0,0,1)";
    check("a.nrrd", &nrrd(las), true, [-1.0, 1.0, 1.0]);
    let frame = format!("{las}\nmeasurement frame: (-1,0,0) (0,-1,0) (0,0,1)");
    check("a.nrrd", &nrrd(&frame), true, [1.0, -1.0, 1.0]);
}

#[test]
fn meta_image_has_channels() {
    let header = "NDims = 3\nDimSize = 2 3 4\nElementType = MET_FLOAT\nElementNumberOfChannels = 3\n\
                  ElementDataFile = LOCAL\n";
    check("a.mha", header.as_bytes(), true, [1.0; 3]);
}

#[test]
fn npy_has_a_fourth_axis() {
    let text = "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 3, 2, 3)}";
    let text = format!("{text:117}\n");
    let header = [b"\x93NUMPY\x01\x00", &(text.len() as u16).to_le_bytes()[..], text.as_bytes()];
    check("a.npy", &header.concat(), true, [1.0; 3]);
}

#[test]
fn nifti_has_three_volumes_and_says_what_they_are() {
    let mut header = vec![0; 352];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348_i32.to_le_bytes());
    for (n, size) in [5_i16, 2, 3, 4, 1, 3].into_iter().enumerate() {
        put(40 + 2 * n, &size.to_le_bytes());
    }
    put(68, &1007_i16.to_le_bytes());
    put(70, &16_i16.to_le_bytes());
    for n in 0..4 {
        put(76 + 4 * n, &1_f32.to_le_bytes());
    }
    put(108, &352_f32.to_le_bytes());
    put(344, b"n+1\0");
    check("a.nii", &header, false, [1.0; 3]);
    // Without the intent they are volumes, and components if that is asked for.
    header[68..70].fill(0);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nii");
    fs::write(&path, [&header[..], &numbers(false)].concat()).unwrap();
    let y = read(&path, Some(Quantity::Component(1))).unwrap();
    assert!(y.into_iter().eq((0..COUNT).map(|n| vector(n)[1])));
    assert_eq!(read(&path, None).unwrap()[5], vector(5)[0]);
}

#[test]
fn what_are_no_vectors_has_no_quantity() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |lines: &str, expected: &str| {
        let path = folder.path().join("a.nrrd");
        fs::write(&path, [nrrd(lines), vec![0; 4096]].concat()).unwrap();
        let refusal = read(&path, Some(Quantity::Speed)).unwrap_err();
        assert!(refusal.contains(expected), "{refusal}");
    };
    let many = "sizes: 2 3 4 2\nkinds: domain domain domain list";
    refused(many, "three numbers per sample, found 2 volumes of one");
    refused(
        "sizes: 2 3 4 1\nkinds: domain domain domain list",
        "three numbers per sample, found one",
    );
    let frame =
        "sizes: 3 2 3 4\nkinds: vector domain domain domain\nmeasurement frame: (1,0) none (0,1)";
    refused(frame, "expected three vectors like (1,0,0)");
    let lists = "sizes: 3 3 4 2\nkinds: vector domain domain list";
    refused(lists, "several volumes of vectors");
    refused(
        "sizes: 3 2 3 4\nkinds: RGB-color domain domain domain",
        "line 2: colours are three or four unsigned bytes, found float, which is not supported",
    );
    let overflow = "sizes: 3 9223372036854775807 1 1\nkinds: vector domain domain domain";
    refused(overflow, "samples are more than 64 bits can count");
    let short = "sizes: 3 99 99 99\nkinds: vector domain domain domain";
    refused(short, "samples");
}
