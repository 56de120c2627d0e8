//! The targets of `tests/fuzz` on bytes by chance and on files with wrong bytes; `scripts/fuzz` looks longer.
//!
//! `VOLUMES=1000000 cargo test --release -p isokit-tests --test fuzz` extracts from so many volumes.

use isokit::{
    for_any,
    geom::Frame,
    io::{MeshContext, write_colors, write_mesh, write_volume},
    job::Job,
    marching_cubes::{ExtractOptions, extract},
    mesh::Surface,
    refine::{RefineOptions, Subdivision},
    volume::{Channels, ColorVolume, Grid, Volume},
};
use isokit_tests::{
    chance::{Chance, many},
    fuzz::{self, mesh_file, promises, volume_file},
    hard,
};
use proptest::{prelude::*, test_runner::FileFailurePersistence};
use std::{
    fs,
    path::{Path, PathBuf},
    sync::atomic::{AtomicUsize, Ordering},
};

fn ball() -> Volume<i16> {
    let grid = Grid::new([5, 4, 3], Frame::default()).unwrap();
    let square = |n: u64, middle: f64| (n as f64 - middle) * (n as f64 - middle);
    let value = |n: u64| square(n % 5, 2.0) + square(n / 5 % 4, 1.5) + square(n / 20, 1.0);
    Volume::new(grid, (0..60).map(|n| (300.0 - 100.0 * value(n)) as i16).collect()).unwrap()
}

/// A folder of a test's own, for files that are read back once.
fn folder() -> PathBuf {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let name = format!("fuzz-{}-{number}", std::process::id());
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Small volume files of several formats, and one header that is all text.
fn volume_files() -> Vec<Vec<u8>> {
    let folder = folder();
    let write = |ending: &str| {
        let path = folder.join(format!("ball.{ending}"));
        write_volume(&path, &ball().into(), &Job::default()).unwrap();
        fs::read(path).unwrap()
    };
    let mut files: Vec<Vec<u8>> = ["nii", "nii.gz", "nrrd", "npy"].map(write).into();
    let meta = "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n\
                ElementSpacing = 1 2 3\nElementDataFile = LOCAL\n12345678";
    files.push(meta.into());
    let channels = meta.replace("ElementSpacing", "ElementNumberOfChannels = 4\nElementSpacing");
    files.push([channels.as_bytes(), &[7; 24]].concat());
    let colors = ColorVolume::new(*ball().grid(), Channels::Rgb, vec![9; 180]).unwrap();
    write_colors(&folder.join("ball.nrrd"), &colors, &Job::default()).unwrap();
    files.push(fs::read(folder.join("ball.nrrd")).unwrap());
    fs::remove_dir_all(folder).unwrap();
    files
}

/// Small mesh files of all formats.
fn mesh_files() -> Vec<Vec<u8>> {
    let folder = folder();
    let mesh = extract(&ball().view(), 0.0, &ExtractOptions::DEFAULT, &Job::default()).unwrap();
    let surface = Surface { name: "ball".into(), color: None, iso: Some(0.0), mesh };
    let write = |ending: &str| {
        let path = folder.join(format!("ball.{ending}"));
        let context = MeshContext::default();
        write_mesh(&path, std::slice::from_ref(&surface), &context, &Job::default()).unwrap();
        fs::read(path).unwrap()
    };
    let files = ["glb", "ply", "obj", "stl"].map(write).into();
    fs::remove_dir_all(folder).unwrap();
    files
}

/// Bytes written over, doubled or taken out.
fn edited(mut bytes: Vec<u8>, edits: &[(u8, prop::sample::Index, u8)]) -> Vec<u8> {
    for (kind, place, byte) in edits {
        // Mostly in the header, where it matters.
        let place = place.index(bytes.len().min(400));
        match kind % 3 {
            0 => bytes[place] = *byte,
            1 => bytes.insert(place, *byte),
            _ => drop(bytes.remove(place)),
        }
    }
    bytes
}

#[test]
fn volumes_and_options_by_chance() {
    let mut chance = Chance::new(1);
    for n in 0..many("VOLUMES", 3000) {
        let bytes: Vec<u8> = (0..n % 800).map(|_| chance.bits() as u8).collect();
        fuzz::extract(&bytes);
    }
}

#[test]
fn volumes_by_chance_divided_and_balanced() {
    let mut chance = Chance::new(2);
    for n in 0..many("VOLUMES", 3000) / 5 {
        let bytes: Vec<u8> = (0..n % 800).map(|_| chance.bits() as u8).collect();
        fuzz::refine(&bytes);
    }
}

#[test]
fn volumes_by_chance_piece_by_piece() {
    let mut chance = Chance::new(3);
    for n in 0..many("VOLUMES", 3000) / 5 {
        let bytes: Vec<u8> = (0..n % 1600).map(|_| chance.bits() as u8).collect();
        fuzz::pieces(&bytes);
    }
}

/// Each line is a target and bytes at which it once failed, shrunk, and behind them what was wrong.
#[test]
fn what_once_failed_does_not() {
    let kept = include_str!("fuzz/kept.txt").lines().filter(|line| !line.starts_with('#'));
    let kept: Vec<&str> = kept.collect();
    assert!(!kept.is_empty());
    for line in kept {
        let mut words = line.splitn(3, ' ');
        let mut word = || words.next().unwrap_or_else(|| panic!("three parts: {line}"));
        let (name, digits, says) = (word(), word(), word());
        let target = fuzz::target(name).unwrap_or_else(|| panic!("no target {name}"));
        let byte = |n: usize| u8::from_str_radix(&digits[n..n + 2], 16);
        let bytes: Result<Vec<u8>, _> = (0..digits.len()).step_by(2).map(byte).collect();
        assert!(says.len() > 10, "{line}");
        target(&bytes.unwrap_or_else(|error| panic!("{error}: {line}")));
    }
}

#[test]
fn sound_files_are_read() {
    volume_files().iter().for_each(|file| volume_file(file));
    mesh_files().iter().for_each(|file| mesh_file(file));
}

/// All that may be done to a surface.
fn ways() -> impl Strategy<Value = RefineOptions> {
    let subdivision = prop::sample::select(vec![
        Subdivision::None,
        Subdivision::Levels(1),
        Subdivision::Levels(2),
        Subdivision::MaxError(0.3),
        Subdivision::MaxError(0.03),
    ]);
    (subdivision, any::<bool>()).prop_map(|(subdivision, balance)| {
        RefineOptions::DEFAULT.with_subdivision(subdivision).with_balance(balance)
    })
}

/// What fails is shrunk, and its seed is kept here: it comes first from then on.
const KEPT: FileFailurePersistence =
    FileFailurePersistence::Direct("fuzz/proptest-regressions.txt");

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: Some(Box::new(KEPT)), ..ProptestConfig::default() })]

    #[test]
    fn volumes_and_options_that_shrink(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        fuzz::extract(&bytes);
    }

    #[test]
    fn near_ties_extremes_and_gaps_in_every_mode(
        (volume, iso) in hard::volumes(),
        options in hard::options(),
    ) {
        for_any!(&volume, volume => promises::surface(&volume.view(), iso, &options));
    }

    #[test]
    fn near_ties_extremes_and_gaps_piece_by_piece(
        (volume, iso) in hard::volumes(),
        options in hard::options(),
        more in 0..3_usize,
    ) {
        for_any!(&volume, volume => promises::pieces(&volume.view(), iso, &options, more));
    }

    #[test]
    fn near_ties_extremes_and_gaps_divided_and_balanced(
        (volume, iso) in hard::volumes(),
        options in hard::options(),
        way in ways(),
    ) {
        promises::refined(&volume, iso, &options, &way);
    }

    #[test]
    fn files_that_are_nothing(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        volume_file(&bytes);
        mesh_file(&bytes);
    }

    #[test]
    fn files_with_wrong_bytes(
        which in any::<prop::sample::Index>(),
        edits in proptest::collection::vec(
            (any::<u8>(), any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        volume_file(&edited(which.get(&volume_files()).clone(), &edits));
        mesh_file(&edited(which.get(&mesh_files()).clone(), &edits));
    }
}
