//! Pictures of scans of which no more is read than they depend on.

use super::{behind, look, scene, size};
use crate::{
    pipeline::{Region, RegionError, Scan, ScanFile, TargetSpace},
    scene::{CapStyle, Clip, Scene, Viewpoint},
};
use isokit_geom::HalfSpace;
use isokit_io::{Endian, RawLayout, VolumeOptions};
use isokit_job::Job;
use isokit_render::{ControlPoint, Image, Kernel, Projection, Scatter, Side, TransferFunction};
use isokit_volume::Dtype;
use std::{fs, ops::Range};
use tempfile::TempDir;

const DIMS: [usize; 3] = [36, 34, 40];

/// A file of bytes that change a little from sample to sample, and by chance, around [-18, 17]³.
struct File {
    folder: TempDir,
    options: VolumeOptions,
}

impl File {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        let mut state = 1_u32;
        let sample = |n: usize| {
            let ijk = [n % DIMS[0], n / DIMS[0] % DIMS[1], n / DIMS[0] / DIMS[1]];
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let radius = ijk.iter().map(|&i| (i as f64 - 18.0).powi(2)).sum::<f64>().sqrt();
            (250.0 - 12.0 * radius + f64::from(state >> 26)).clamp(1.0, 255.0) as u8
        };
        let samples: Vec<u8> = (0..DIMS.iter().product()).map(sample).collect();
        fs::write(folder.path().join("a.raw"), samples).unwrap();
        let mut options = VolumeOptions::default();
        let (dims, dtype) = (DIMS.map(|n| n as u64), Dtype::U8);
        options.raw = Some(RawLayout { dims, dtype, endian: Endian::Little, skip: 0 });
        // No sum of these is rounded to what it would be in another order.
        options.origin = Some([-18.3, -17.7, -18.1]);
        options.spacing = Some([1.0, 1.03, 0.97]);
        Self { folder, options }
    }

    fn open(&self, region: &str) -> ScanFile {
        let region = Region::parse_samples(region).unwrap();
        let path = self.folder.path().join("a.raw");
        let space = TargetSpace::Source;
        ScanFile::open(&path, &self.options, space, &region, &Job::default()).unwrap()
    }
}

/// Bytes through a function that shows those above 40, and also 0: what was not read would be seen.
fn colored() -> Scene {
    let point = |value: f64, rgba: &str| ControlPoint::new(value, rgba.parse().unwrap());
    let points = vec![
        point(0.0, "#00ff0080"),
        point(1.0, "#00ff0000"),
        point(40.0, "#80402000"),
        point(250.0, "#ffe0c060"),
    ];
    let model = Some(TransferFunction::new(points).unwrap().into());
    let surfaces =
        vec![look("skin", 60.0, [1.0, 0.2, 0.1], 0.5), look("bone", 170.0, [0.3, 0.4, 1.0], 1.0)];
    let raster = isokit_render::RasterOptions::DEFAULT;
    Scene { surfaces, model, raster, ..scene() }
}

/// Keeps z ≤ `offset`, of all surfaces, or of one.
fn below(offset: f64, surfaces: Option<&str>) -> Clip {
    let half = HalfSpace::new([0.02, 0.0, 1.0], offset).unwrap();
    Clip { half, surfaces: surfaces.map(|name| vec![name.into()]), cap: CapStyle::Slice }
}

fn from(at: [f64; 3], height: f64) -> Viewpoint {
    let projection = Projection::Parallel { height };
    Viewpoint::At {
        from: [3.0, 60.0, 5.0],
        at: Some(at),
        up: [0.0, 0.0, 1.0],
        orbit: 0.0,
        projection,
    }
}

/// Scenes that do not show all of the scan.
fn scenes() -> Vec<Scene> {
    let framed = Viewpoint::Framed { side: Side::Left, orbit: 20.0, fov: Some(30.0), turns: false };
    let cut = |viewpoint, clips| Scene { viewpoint, clips, ..colored() };
    vec![
        cut(framed, vec![below(-2.3, None)]),
        cut(framed, vec![below(0.0, None), behind(3.1, None, CapStyle::Solid)]),
        cut(from([0.0; 3], 70.0), vec![below(-7.0, Some("skin")), below(2.0, Some("bone"))]),
        cut(from([4.0, 0.0, 6.0], 9.0), vec![]),
        cut(from([4.0, 0.0, 6.0], 9.0), vec![behind(1.0, None, CapStyle::Slice)]),
    ]
}

#[track_caller]
fn assert_fewer(wanted: &[Range<usize>; 3], what: &str) {
    let read: usize = wanted.iter().map(|range| range.len()).product();
    assert!(10 * read < 9 * DIMS.iter().product::<usize>(), "{what}: {wanted:?}");
}

fn pixels(image: Image) -> Vec<[u32; 4]> {
    let bits = |pixel: &isokit_render::Gathered| {
        let [r, g, b] = pixel.color.map(f32::to_bits);
        [r, g, b, pixel.opacity.to_bits()]
    };
    image.pixels().iter().map(bits).collect()
}

#[test]
fn surfaces_of_what_is_read_are_those_of_the_whole_to_the_bit() {
    let (file, job) = (File::new(), Job::default());
    let whole = file.open(":,:,:").read(&job).unwrap();
    for (n, mut scene) in scenes().into_iter().enumerate() {
        let camera = (&[scene.viewpoint][..], size());
        let opened = file.open(":,:,:");
        let wanted = scene.samples_of_surfaces(opened.lattice(), camera).unwrap().unwrap();
        assert_fewer(&wanted, &format!("scene {n}"));
        let part = opened.read_wanted(&wanted, &job).unwrap();
        assert!(part.is_read_in_part() && !whole.is_read_in_part());
        let drawn = |scan: &Scan| pixels(super::drawn(&scene, scan).unwrap());
        assert!(drawn(&part) == drawn(&whole), "scene {n}");
        for kernel in [Kernel::Linear, Kernel::CatmullRom] {
            scene.raycast = scene.raycast.with_kernel(kernel);
            let traced = |scan: &Scan| pixels(scene.trace(scan, size(), &job).unwrap().0);
            assert!(traced(&part) == traced(&whole), "scene {n}, {kernel:?}");
        }
    }
}

#[test]
fn rays_through_what_is_read_gather_what_they_gather_in_the_whole_to_the_bit() {
    let (file, job) = (File::new(), Job::default());
    let whole = file.open(":,:,:").read(&job).unwrap();
    let cloud = Scatter { from: [1.0, 2.0, 3.0], strength: 2.0, ambient: 0.3, ahead: 0.2 };
    for (n, mut scene) in scenes().into_iter().enumerate() {
        let plain = scene.raycast;
        for options in [
            plain,
            plain.with_kernel(Kernel::CatmullRom),
            plain.with_integrated(true).with_jitter(true),
            plain.with_error(Some(0.004)),
            plain.with_scatter(Some(cloud)),
        ] {
            scene.raycast = options;
            let camera = (&[scene.viewpoint][..], size());
            let opened = file.open(":,:,:");
            let wanted = scene.samples_of_rays(opened.lattice(), camera).unwrap().unwrap();
            // Light comes from beside the picture, and planes for some surfaces do not cut rays.
            if n != 2 && (n != 3 || options.scatter.is_none()) {
                assert_fewer(&wanted, &format!("scene {n}"));
            }
            let part = opened.read_wanted(&wanted, &job).unwrap();
            let cast = |scan: &Scan| pixels(scene.cast(scan, size(), &job).unwrap().0);
            assert!(cast(&part) == cast(&whole), "scene {n}, {options:?}");
            let splat = |scan: &Scan| pixels(scene.splat(scan, size(), &job).unwrap().0);
            assert!(splat(&part) == splat(&whole), "scene {n}, {options:?}");
        }
    }
}

#[test]
fn what_was_not_read_counts_for_nothing_and_is_not_cropped() {
    let (file, job) = (File::new(), Job::default());
    let wanted = [4..20, 0..34, 7..9];
    let part = file.open(":,:,:").read_wanted(&wanted, &job).unwrap();
    let cropped = file.open("4:20,:,7:9").read(&job).unwrap();
    assert_eq!(part.statistics(&job).unwrap().range, cropped.statistics(&job).unwrap().range);
    assert_eq!(part.samples_read(), wanted);
    let region = |text| Region::parse_samples(text).unwrap();
    assert!(part.clone().cropped(&region("5:8,:,7:8")).is_ok());
    let beyond = part.cropped(&region("5:8,:,6:8")).unwrap_err();
    assert!(matches!(beyond, RegionError::Unread { .. }), "{beyond}");
}

#[test]
fn a_part_that_was_read_alone_is_the_part_of_the_whole() {
    let (file, job, scene) = (File::new(), Job::default(), &scenes()[1]);
    for region in ["3:30,:,10:39", ":,5:,:", "0:20,1:30,2:33"] {
        let alone = file.open(region).read(&job).unwrap();
        let whole = file.open(":,:,:").read(&job).unwrap();
        let part = whole.cropped(&Region::parse_samples(region).unwrap()).unwrap();
        assert_eq!((alone.part(), alone.around()), (part.part(), part.around()));
        let drawn = |scan: &Scan| pixels(super::drawn(scene, scan).unwrap());
        assert!(drawn(&alone) == drawn(&part), "{region}");
        let cast = |scan: &Scan| pixels(scene.cast(scan, size(), &job).unwrap().0);
        assert!(cast(&alone) == cast(&part), "{region}");
    }
}
