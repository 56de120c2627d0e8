//! Volumes that other people's programs wrote, read as an independent reader found them.
//!
//! The files are not part of the project. Where their folder is absent, every test passes and says so.

use isokit_geom::{Space, Unit};
use isokit_io::{Endian, Format, RawLayout, VolumeInput, VolumeOptions, open_volume, read_volume};
use isokit_job::{Job, Limits};
use isokit_volume::{AnyVolume, Dtype, Sample, Statistics, Volume, for_any};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// The folder, or `None` with one line that says so.
#[expect(clippy::print_stdout, reason = "whoever watches should see that nothing was tested")]
fn data() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: {} is absent", folder.display());
    None
}

fn read(path: &Path, options: &VolumeOptions) -> VolumeInput {
    read_volume(path, options, &Job::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn range(volume: &AnyVolume) -> [f64; 2] {
    let statistics = for_any!(volume, volume => Statistics::of(&volume.view(), &Job::default()));
    statistics.unwrap().range.unwrap()
}

struct Line {
    file: &'static str,
    dims: [u64; 3],
    dtype: Dtype,
    spacing: [f64; 3],
    range: [f64; 2],
    volumes: u64,
    space: Space,
}

const fn line(
    file: &'static str,
    dims: [u64; 3],
    dtype: Dtype,
    spacing: [f64; 3],
    range: [f64; 2],
) -> Line {
    Line { file, dims, dtype, spacing, range, volumes: 1, space: Space::Unknown }
}

const RAS: Space = Space::Ras;
const LPS: Space = Space::Lps;
const ONE: [f64; 3] = [1.0; 3];

/// What the manifest says; where it rounds a spacing, its digits.
#[rustfmt::skip]
const LINES: [Line; 45] = [
    Line { space: RAS, ..line("volvis/engine.nii.gz", [256, 256, 128], Dtype::U8, ONE, [0.0, 255.0]) },
    Line { space: RAS, ..line("volvis/bonsai.nii.gz", [256, 256, 256], Dtype::U8, ONE, [0.0, 255.0]) },
    Line { space: RAS, ..line("volvis/fuel.nii.gz", [64, 33, 32], Dtype::U8, ONE, [0.0, 255.0]) },
    line("volvis/tooth/tooth.nhdr", [103, 94, 161], Dtype::U16, ONE, [0.0, 1300.0]),
    Line { space: RAS, ..line("nifti/mni152_t1_1mm.nii.gz", [197, 233, 189], Dtype::U8, ONE, [0.0, 255.0]) },
    Line { space: RAS, ..line("nifti/mni152_gm_prob_1mm.nii.gz", [197, 233, 189], Dtype::U8, ONE, [0.0, 255.0]) },
    Line { space: RAS, ..line("nifti/CT_pitch.nii.gz", [175, 248, 58], Dtype::U8, [0.8125, 0.8125, 2.397], [0.0, 255.0]) },
    Line { space: RAS, ..line("nifti/shear_gantry_tilt.nii.gz", [306, 422, 54], Dtype::U8, [0.48242, 0.48242, 2.3708], [-1024.0, 789.0]) },
    Line { space: RAS, ..line("nifti/ts_example_ct.nii.gz", [122, 101, 112], Dtype::I32, [3.0; 3], [-1207.0, 3382.0]) },
    Line { space: RAS, ..line("nifti/ts_example_ct_sm.nii.gz", [122, 101, 30], Dtype::I16, [3.0; 3], [-1100.0, 1207.0]) },
    Line { space: RAS, volumes: 2, ..line("nifti/example4d.nii.gz", [128, 96, 24], Dtype::I16, [2.0, 2.0, 2.2], [0.0, 1162.0]) },
    Line { space: RAS, volumes: 2, ..line("nifti/example_nifti2.nii.gz", [32, 20, 12], Dtype::I16, [2.0, 2.0, 2.2], [46.0, 757.0]) },
    Line { space: RAS, ..line("nifti/anatomical.nii", [33, 41, 25], Dtype::I16, [2.0; 3], [-610.0, 30393.0]) },
    Line { space: RAS, ..line("nifti/dtypes/uint8.nii", [3; 3], Dtype::U8, ONE, [0.0, 26.0]) },
    Line { space: RAS, ..line("nifti/dtypes/int8.nii", [3; 3], Dtype::I8, ONE, [0.0, 26.0]) },
    Line { space: RAS, ..line("nifti/dtypes/uint16.nii", [3; 3], Dtype::U16, ONE, [0.0, 26.0]) },
    Line { space: RAS, ..line("nifti/dtypes/int16.nii", [3; 3], Dtype::I16, ONE, [0.0, 26.0]) },
    Line { space: RAS, ..line("nifti/dtypes/uint32.nii", [3; 3], Dtype::U32, ONE, [0.0, 26.0]) },
    Line { space: RAS, ..line("nifti/dtypes/int32.nii", [3; 3], Dtype::I32, ONE, [0.0, 26.0]) },
    Line { space: RAS, ..line("nifti/dtypes/float32.nii", [3; 3], Dtype::F32, ONE, [0.0, 26.0]) },
    Line { space: RAS, ..line("nifti/dtypes/float64.nii", [3; 3], Dtype::F64, ONE, [0.0, 26.0]) },
    line("nifti/pair/minimal.hdr", [64, 64, 10], Dtype::U8, [3.0; 3], [0.0, 63.0]),
    line("nifti/pair/minimal.img", [64, 64, 10], Dtype::U8, [3.0; 3], [0.0, 63.0]),
    line("nifti/pair/minimal.hdr.gz", [64, 64, 10], Dtype::U8, [3.0; 3], [0.0, 63.0]),
    line("nifti/pair/minimal.img.gz", [64, 64, 10], Dtype::U8, [3.0; 3], [0.0, 63.0]),
    line("nifti/pair/minimal.nii", [64, 64, 10], Dtype::U8, [3.0; 3], [0.0, 63.0]),
    line("nifti/pair/minimal.nii.gz", [64, 64, 10], Dtype::U8, [3.0; 3], [0.0, 63.0]),
    line("nifti/pair/minimal2.hdr", [64, 64, 10], Dtype::U8, [3.0; 3], [0.0, 63.0]),
    Line { space: RAS, ..line("nifti/pair/minimal_extended_hdr.nii", [8, 8, 1], Dtype::F64, ONE, [0.0, 0.0]) },
    Line { space: RAS, ..line("labels/ts_example_seg.nii.gz", [122, 101, 30], Dtype::U8, [3.0; 3], [0.0, 117.0]) },
    Line { space: RAS, ..line("labels/aal.nii.gz", [181, 217, 181], Dtype::U8, ONE, [0.0, 116.0]) },
    Line { space: RAS, ..line("labels/torsoLabel.nii.gz", [384, 320, 89], Dtype::U8, [0.782, 0.782, 5.0], [0.0, 11.0]) },
    Line { space: LPS, ..line("labels/Segmentation.seg.nrrd", [128, 128, 34], Dtype::U8, [3.0469, 3.0469, 10.0], [0.0, 7.0]) },
    line("nrrd/headsq/quarter.nhdr", [64, 64, 93], Dtype::I16, [3.2, 3.2, 1.5], [0.0, 3926.0]),
    Line { space: LPS, ..line("nrrd/FLAIR_oblique.nrrd", [124, 160, 140], Dtype::U8, ONE, [0.0, 255.0]) },
    Line { space: LPS, ..line("nrrd/CTChest4.nrrd", [128, 128, 34], Dtype::I32, [3.0469, 3.0469, 10.0], [-3024.0, 3070.0]) },
    line("nrrd/stent.nrrd", [128, 128, 256], Dtype::F32, ONE, [0.0, 1.0]),
    line("nrrd/pynrrd/test1d_ascii.nrrd", [27, 1, 1], Dtype::U8, [1.0458, 1.0, 1.0], [1.0, 27.0]),
    line("nrrd/pynrrd/test2d_ascii.nrrd", [3, 9, 1], Dtype::U16, [1.0458, 2.0, 1.0], [1.0, 27.0]),
    line("nrrd/pynrrd/test_customFields.nrrd", [27, 1, 1], Dtype::U8, [1.0458, 1.0, 1.0], [1.0, 27.0]),
    Line { space: RAS, ..line("nrrd/pynrrd/test_simple4d_raw.nrrd", [1, 1, 1], Dtype::F64, [1.5, 1.5, 1.0], [0.76903426, 0.76903426]) },
    // The manifest says 0..253, but zlib alone unpacks it to 0..29, as its copy in VTI has it.
    Line { space: LPS, ..line("metaimage/frogtissue.mhd", [500, 470, 136], Dtype::U8, [1.0, 1.0, 1.5], [0.0, 29.0]) },
    Line { space: LPS, ..line("metaimage/HeadMRVolume.mhd", [48, 62, 42], Dtype::U8, [4.0; 3], [0.0, 255.0]) },
    Line { space: LPS, ..line("metaimage/3DCT_lung.mha", [115, 157, 129], Dtype::I16, [1.366, 1.366, 2.5], [-1255.0, 1474.0]) },
    line("npy/hdz2000.npy.bz2", [128, 128, 128], Dtype::U8, ONE, [0.0, 255.0]),
];

#[test]
fn every_volume_of_the_manifest_opens_as_its_line_says() {
    let Some(data) = data() else { return };
    let mut wrong = vec![];
    for line in &LINES {
        let path = data.join(line.file);
        let volumes = (0..line.volumes).map(|index| {
            let mut options = VolumeOptions::default();
            options.volume_index = Some(index);
            read(&path, &options).volume
        });
        let volumes: Vec<_> = volumes.collect();
        let (grid, dtype) = (*volumes[0].grid(), volumes[0].dtype());
        let ends = volumes.iter().map(range);
        let ends = ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap();
        let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 6e-5);
        let spacing = grid.frame.index_to_world.spacing();
        let same_range = ends.iter().zip(line.range).all(|(a, b)| (a - b).abs() < 2e-3);
        if (grid.dims(), dtype, grid.frame.space) != (line.dims, line.dtype, line.space)
            || !near(spacing, line.spacing)
            || !same_range
        {
            let space = grid.frame.space;
            let found = (grid.dims(), dtype, spacing, ends, space);
            wrong.push(format!("{}: {found:?}", line.file));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn headerless_volumes_open_as_they_are_described() {
    let Some(data) = data() else { return };
    let files = [
        ("volvis/vismale_head_128x256x256_u8.raw.bz2", [128, 256, 256], [1.0, 254.0]),
        ("volvis/Bucky_32x32x32_u8.raw", [32, 32, 32], [0.0, 255.0]),
    ];
    for (file, dims, ends) in files {
        let mut options = VolumeOptions::default();
        let (dtype, endian) = (Dtype::U8, Endian::Little);
        options.raw = Some(RawLayout { dims, dtype, endian, skip: 0 });
        options.spacing = Some([1.57774, 0.995861, 1.00797]);
        let input = read(&data.join(file), &options);
        let grid = input.volume.grid();
        assert_eq!((grid.dims(), range(&input.volume)), (dims, ends), "{file}");
        assert_eq!(grid.frame.index_to_world.spacing(), [1.57774, 0.995861, 1.00797]);
        assert_eq!((grid.frame.unit, input.format), (Unit::Unknown, Format::Raw));
        assert_eq!(input.notes, [""; 0], "{file}");
    }
}

#[test]
fn nine_encodings_hold_one_array() {
    let Some(data) = data() else { return };
    let names = [
        ".nhdr",
        ".nrrd",
        "_gz.nrrd",
        "_bz2.nrrd",
        "_gz_lineskip.nrrd",
        "_gz_byteskip_minus_one.nrrd",
        "_byteskip_minus_one.nhdr",
        "_byteskip_minus_one_nifti.nhdr",
    ];
    let read = |name: &str| {
        let path = data.join(format!("nrrd/pynrrd/BallBinary30x30x30{name}"));
        match read(&path, &VolumeOptions::default()).volume {
            AnyVolume::I16(volume) => volume.samples().to_vec(),
            other => panic!("{}", other.dtype()),
        }
    };
    let first = read(names[0]);
    assert_eq!(first.iter().map(|&sample| i64::from(sample)).sum::<i64>(), 3_682_296);
    for name in [&names[1..], &[".nii.gz"]].concat() {
        assert!(read(name) == first, "{name}");
    }
    // Here nobody skips the header inside: it is taken for samples, as teem and ITK do.
    assert!(read("_nifti.nhdr") != first);
    let path = data.join("nrrd/pynrrd/BallBinary30x30x30_byteskip_minus_five.nhdr");
    let error = read_volume(&path, &VolumeOptions::default(), &Job::default()).unwrap_err();
    assert!(error.to_string().contains("line 8: expected a number of bytes, or -1"), "{error}");
}

#[test]
fn integers_of_64_bits_are_refused_by_name() {
    let Some(data) = data() else { return };
    for name in ["int64", "uint64"] {
        let path = data.join(format!("nifti/dtypes/{name}.nii"));
        let error = open_volume(&path, &VolumeOptions::default(), &Job::default()).unwrap_err();
        let expected = format!("NIfTI, byte 70: sample type {name} (64-bit integers");
        assert!(error.to_string().contains(&expected), "{error}");
    }
}

#[test]
fn a_header_without_its_image_names_the_image() {
    let Some(data) = data() else { return };
    let files = [
        ("nifti/analyze.hdr", "analyze.img: cannot read", "(it holds the samples of analyze.hdr)"),
        ("malformed/mhd_missing_data/frog.mhd", "frog.zraw: cannot read", "of frog.mhd)"),
    ];
    for (file, missing, why) in files {
        let options = VolumeOptions::default();
        let error = open_volume(&data.join(file), &options, &Job::default()).unwrap_err();
        let text = error.to_string();
        assert!(text.contains(missing) && text.contains(why), "{text}");
    }
}

/// Samples and matrix after axes were swapped and turned so that they run along those of the world.
fn canonical<T: Sample>(volume: &Volume<T>) -> ([usize; 3], Vec<T>, [[f64; 4]; 4]) {
    let affine = volume.grid().frame.index_to_world;
    let columns = affine.columns();
    let axis_of = |world: usize| {
        let along = |axis: usize| columns[axis][world].abs();
        (0..3).max_by(|&a, &b| along(a).total_cmp(&along(b))).unwrap()
    };
    let axes: [usize; 3] = std::array::from_fn(axis_of);
    let dims = volume.view().dims();
    let new_dims = axes.map(|axis| dims[axis]);
    let turned: [bool; 3] = std::array::from_fn(|world| columns[axes[world]][world] < 0.0);
    let old = |new: [usize; 3]| {
        let mut ijk = [0; 3];
        for world in 0..3 {
            let n = new[world];
            ijk[axes[world]] = if turned[world] { new_dims[world] - 1 - n } else { n };
        }
        ijk
    };
    let view = volume.view();
    let mut samples = vec![];
    for k in 0..new_dims[2] {
        for j in 0..new_dims[1] {
            samples.extend((0..new_dims[0]).map(|i| view.stored(old([i, j, k]))));
        }
    }
    let origin = affine.point(old([0; 3]).map(|i| i as f64));
    let mut rows = [[0.0; 4]; 4];
    for world in 0..3 {
        let sign = if turned[world] { -1.0 } else { 1.0 };
        for row in 0..3 {
            rows[row][world] = columns[axes[world]][row] * sign;
        }
        rows[world][3] = origin[world];
    }
    (new_dims, samples, rows)
}

#[test]
fn storage_orders_are_one_volume_in_the_world() {
    let Some(data) = data() else { return };
    let mut first = None;
    let mut files: Vec<_> = fs::read_dir(data.join("nifti/orient")).unwrap().collect();
    files.sort_by_key(|file| file.as_ref().unwrap().path());
    assert_eq!(files.len(), 24);
    for file in files {
        let path = file.unwrap().path();
        let volume = read(&path, &VolumeOptions::default()).volume;
        let found = for_any!(&volume, volume => {
            let (dims, samples, rows) = canonical(volume);
            (dims, samples.into_iter().map(Sample::to_f64).collect::<Vec<_>>(), rows)
        });
        let first = first.get_or_insert_with(|| found.clone());
        assert!(found.0 == first.0 && found.1 == first.1, "{}", path.display());
        let differ = found.2.iter().flatten().zip(first.2.iter().flatten());
        let greatest = differ.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(greatest < 1e-4, "{}: {greatest}", path.display());
    }
}

#[test]
fn malformed_files_end_in_an_error_that_names_them() {
    let Some(data) = data() else { return };
    let mut folders = vec![data.join("malformed")];
    let job = Job { limits: Limits { bytes: 1 << 28 }, ..Job::default() };
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            match read_volume(&path, &VolumeOptions::default(), &job) {
                Ok(_) => panic!("{name} opened"),
                Err(error) if name == "frog.mhd" => {
                    assert_eq!(error.path.extension().unwrap(), "zraw")
                }
                Err(error) => assert_eq!(error.path, path),
            }
        }
    }
}
