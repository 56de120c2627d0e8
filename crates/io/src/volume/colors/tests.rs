//! Colours in files, written and read, and what is none.

use crate::{
    ColorFile, VolumeOptions, open_colors, open_volume, prepare_colors, prepare_volume,
    volume_files, write_colors,
};
use isokit_geom::{Affine, Frame, Space, Unit};
use isokit_job::{Job, Limits};
use isokit_volume::{AnyVolume, Channels, ColorVolume, Grid, Volume};
use std::{fs, path::Path};

fn grid() -> Grid {
    let columns = [[0.8, 0.1, 0.0], [-0.1, 0.9, 0.2], [0.1, 0.0, 1.1]];
    let index_to_world = Affine::new(columns, [-8.0, 9.5, 0.25]).unwrap();
    Grid::new([2, 3, 4], Frame { index_to_world, unit: Unit::Micrometre, space: Space::Lps })
        .unwrap()
}

fn colors(channels: Channels) -> ColorVolume {
    let bytes = (0..24 * channels.count()).map(|n| (7 * n) as u8).collect();
    ColorVolume::new(grid(), channels, bytes).unwrap()
}

fn open(path: &Path) -> Option<ColorFile> {
    open_colors(path, &Job::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn refusal(path: &Path) -> String {
    open_volume(path, &VolumeOptions::default(), &Job::default()).unwrap_err().to_string()
}

#[test]
fn colours_come_back_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.nrrd", "b.NHDR"] {
        for channels in [Channels::Rgb, Channels::Rgba] {
            let (path, colors) = (folder.path().join(name), colors(channels));
            write_colors(&path, &colors, &Job::default()).unwrap();
            let file = open(&path).unwrap();
            assert_eq!((file.channels(), *file.grid(), file.notes().len()), (channels, grid(), 0));
            assert_eq!(file.collect(&Job::default()).unwrap(), colors);
            let refusal = refusal(&path);
            assert!(refusal.contains("they are colours, not values"), "{refusal}");
        }
    }
    for name in ["a.nii", "a.nii.gz", "a.npy", "a.raw", "a.mha", "a", ".nrrd"] {
        let path = folder.path().join(name);
        let error = write_colors(&path, &colors(Channels::Rgb), &Job::default()).unwrap_err();
        assert!(error.to_string().ends_with("colours are written as .nrrd or .nhdr"), "{error}");
        assert!(!path.exists(), "{name}");
    }
}

#[test]
fn what_is_prepared_has_no_name_yet() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a.nhdr", "b.nhdr"].map(|name| folder.path().join(name));
    let volume = AnyVolume::from(Volume::new(grid(), vec![0_i16; 24]).unwrap());
    let job = Job::default();
    let prepare = || {
        let colors = prepare_colors(&a, &colors(Channels::Rgb), &job).unwrap();
        (colors, prepare_volume(&b, &volume, &job).unwrap())
    };
    let files: Vec<_> = [&a, &b].iter().flat_map(|path| volume_files(path)).collect();
    drop(prepare());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    let (colors, volume) = prepare();
    assert!(files.iter().all(|path| !path.exists()));
    colors.finish().unwrap();
    volume.finish().unwrap();
    assert!(files.iter().all(|path| path.exists()));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), files.len());
}

/// A file with this header and enough bytes.
#[track_caller]
fn check(name: &str, header: &str, expected: Option<(Channels, &str)>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let bytes: Vec<u8> = (0..96).collect();
    fs::write(&path, [header.as_bytes(), &bytes].concat()).unwrap();
    let Some((channels, says)) = expected else {
        assert!(open(&path).is_none(), "{header}");
        return;
    };
    let file = open(&path).unwrap();
    assert_eq!((file.channels(), file.grid().dims()), (channels, [2, 3, 4]), "{header}");
    let found = file.collect(&Job::default()).unwrap();
    assert_eq!(found.samples(), &bytes[..24 * channels.count()]);
    let refusal = refusal(&path);
    assert!(refusal.contains(says), "{header}: {refusal}");
}

/// What is said to who wants values of what can only be colours, and of what may be vectors too.
const COLORS: &str = "they are colours, not values";
const VECTORS: &str = "--quantity says what is read of vectors";

#[test]
fn an_nrrd_says_by_its_first_axis_what_it_counts() {
    let nrrd = |kind: &str, count: u32, dtype: &str| {
        format!(
            "NRRD0004\ntype: {dtype}\nencoding: raw\nendian: little\ndimension: 4\n\
             sizes: {count} 2 3 4\nkinds: {kind} space space space\nspace dimension: 3\n\
             space directions: none (1,0,0) (0,1,0) (0,0,1)\n\n"
        )
    };
    for kind in ["RGB-color", "3-color"] {
        check("a.nrrd", &nrrd(kind, 3, "uchar"), Some((Channels::Rgb, COLORS)));
    }
    for kind in ["vector", "3-vector", "list", "???"] {
        check("a.nrrd", &nrrd(kind, 3, "uchar"), Some((Channels::Rgb, VECTORS)));
    }
    for kind in ["RGBA-color", "4-color", "vector", "4-vector", "list", "none"] {
        check("a.nrrd", &nrrd(kind, 4, "uint8"), Some((Channels::Rgba, COLORS)));
    }
    check("a.nrrd", &nrrd("vector", 3, "signed char"), None);
    check("a.nrrd", &nrrd("3-gradient", 3, "uchar"), None);
    // Nothing else may be beside the numbers of a colour.
    let more = "NRRD0004\ntype: uchar\nencoding: raw\ndimension: 5\n";
    let between = "sizes: 3 2 2 2 2\nkinds: RGB-color list space space space";
    let after = "sizes: 3 2 2 2 2\nkinds: RGB-color space space space list";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    let vectors = after.replace("RGB-color", "vector");
    let last = "sizes: 2 2 2 2 3\nkinds: space space space list RGB-color";
    for (lines, says) in [
        (between, "line 5: 2 numbers per sample (axis 1, list) is not supported"),
        (after, "line 5: several volumes of colours is not supported"),
        (&vectors, "line 5: several volumes of vectors or colours is not supported"),
        (
            last,
            "line 6: an axis of colours that is not the first (axis 4, rgb-color) is not supported",
        ),
    ] {
        fs::write(&path, [more, lines, "\n\n", &"0".repeat(99)].concat()).unwrap();
        let error = open_colors(&path, &Job::default()).unwrap_err().to_string();
        assert!(error.ends_with(says), "{lines}: {error}");
    }
    let unsigned = "line 2: colours are three or four unsigned bytes, found";
    for (kind, count, dtype, says) in [
        ("HSV-color", 3, "uchar", "line 6: 3 numbers per sample (axis 0, hsv-color)"),
        ("quaternion", 4, "uchar", "line 6: 4 numbers per sample (axis 0, quaternion)"),
        ("list", 5, "uchar", "line 6: 5 numbers per sample (axis 0, list)"),
        ("RGB-color", 3, "ushort", &format!("{unsigned} ushort, which")),
        ("RGBA-color", 4, "unsigned short", &format!("{unsigned} unsigned short, which")),
        ("3-color", 3, "float", &format!("{unsigned} float, which")),
        ("4-color", 4, "int8", &format!("{unsigned} int8, which")),
    ] {
        fs::write(&path, [nrrd(kind, count, dtype).as_bytes(), &[0; 500]].concat()).unwrap();
        let error = open_colors(&path, &Job::default()).unwrap_err().to_string();
        assert!(error.ends_with(&format!("{says} is not supported")), "{error}");
    }
}

#[test]
fn a_meta_image_says_by_its_channels() {
    let header = |count: u32, dtype: &str| {
        format!(
            "NDims = 3\nDimSize = 2 3 4\nElementType = {dtype}\nElementNumberOfChannels = {count}\n\
             ElementDataFile = LOCAL\n"
        )
    };
    check("a.mha", &header(3, "MET_UCHAR"), Some((Channels::Rgb, VECTORS)));
    check("a.mha", &header(4, "MET_UCHAR"), Some((Channels::Rgba, COLORS)));
    check("a.mha", &header(1, "MET_UCHAR"), None);
    check("a.mha", &header(3, "MET_CHAR"), None);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mha");
    for (count, dtype, what) in [
        (4, "MET_UCHAR", "colours"),
        (3, "MET_UCHAR", "vectors or colours"),
        (3, "MET_FLOAT", "vectors"),
    ] {
        let four = header(count, dtype)
            .replace("NDims = 3\nDimSize = 2 3 4", "NDims = 4\nDimSize = 2 3 4 2");
        fs::write(&path, four).unwrap();
        let error = open_colors(&path, &Job::default()).unwrap_err().to_string();
        assert!(
            error.ends_with(&format!("line 2: several volumes of {what} is not supported")),
            "{error}"
        );
    }
}

#[test]
fn what_is_too_large_or_too_short_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    write_colors(&path, &colors(Channels::Rgba), &Job::default()).unwrap();
    let job = Job { limits: Limits { bytes: 95 }, ..Job::default() };
    let error = open(&path).unwrap().collect(&job).unwrap_err().to_string();
    assert!(error.contains("needs 96 bytes, the limit is 95"), "{error}");
    let mut bytes = fs::read(&path).unwrap();
    bytes.pop();
    fs::write(&path, &bytes).unwrap();
    let error = open_colors(&path, &Job::default()).unwrap_err().to_string();
    assert!(error.contains("announces 96 bytes"), "{error}");
    let text = String::from_utf8_lossy(&bytes[..bytes.len() - 95]).into_owned();
    let many = text.replace("sizes: 4 2 3 4", "sizes: 4 9223372036854775807 3 4");
    fs::write(&path, many).unwrap();
    let error = open_colors(&path, &Job::default()).unwrap_err().to_string();
    assert!(error.contains("more than 64 bits can count"), "{error}");
}
