//! Pictures of the scenes in `fixtures/scenes`, and rays against meshes.
//!
//! A scene there and a picture of the same name in `fixtures/images` are a test: put a new scene there, run
//! `UPDATE=1 cargo test -p isokit-tests --test pictures`, look at the picture that this writes, and keep both. Pictures
//! may differ by a tenth of a part of 255 on the mean, and by more than a twentieth of what a colour can be in one part of
//! a thousand: as much as mathematical functions of other systems may bring, and less than one sees.

mod shapes;

use isokit::{
    job::Job,
    pipeline::Scan,
    render::{Image, Projection, RasterOptions, RaycastOptions, Size, Smoothing},
    scene::{Scene, SurfaceLook, Viewpoint},
    volume::{Grid, Volume},
};
use isokit_cli::{Exit, run};
use isokit_tests::workspace;
use std::{
    env,
    fs::{self, File},
    io::BufReader,
    num::NonZeroU32,
    path::{Path, PathBuf},
};

/// Width and height, and the parts of all colours.
fn parts(path: &Path) -> ([u32; 2], Vec<u8>) {
    let file = BufReader::new(File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut all = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut all).unwrap();
    ([info.width, info.height], all)
}

#[track_caller]
fn assert_alike(name: &str, found: &Path, kept: &Path) {
    let ((size, pixels), (expected, known)) = (parts(found), parts(kept));
    assert_eq!(size, expected, "{name}");
    let off = pixels.iter().zip(&known).map(|(a, b)| a.abs_diff(*b));
    let sum: u64 = off.clone().map(u64::from).sum();
    let far = off.filter(|off| *off > 255 / 20).count();
    let mean = sum as f64 / pixels.len() as f64;
    assert!(mean <= 0.1 && far * 1000 <= pixels.len(), "{name}: {mean} on the mean, {far} far");
}

/// The scenes' names.
fn scenes() -> Vec<String> {
    let folder = workspace::root().join("fixtures/scenes");
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let name = |path: PathBuf| path.file_stem().unwrap().to_str().unwrap().to_owned();
    paths.map(name).collect()
}

#[test]
fn every_scene_looks_as_it_was_looked_at() {
    let (root, made) = (workspace::root().join("fixtures"), env::temp_dir());
    assert!(scenes().len() >= 5);
    for name in scenes() {
        let scene = root.join(format!("scenes/{name}.toml"));
        let kept = root.join(format!("images/{name}.png"));
        let found = match env::var_os("UPDATE") {
            Some(_) => kept.clone(),
            None => made.join(format!("isokit-{}-{name}.png", std::process::id())),
        };
        let words = ["isokit".as_ref(), "render".as_ref(), scene.as_os_str(), "-o".as_ref()];
        let (mut out, mut err) = (vec![], vec![]);
        let exit = run(words.into_iter().chain([found.as_os_str()]), &mut out, &mut err);
        assert_eq!(exit, Exit::Done, "{name}: {}", String::from_utf8_lossy(&err));
        assert_alike(&name, &found, &kept);
        if found != kept {
            fs::remove_file(found).unwrap();
        }
    }
}

#[test]
fn every_picture_has_a_scene() {
    let scenes = scenes();
    for entry in fs::read_dir(workspace::root().join("fixtures/images")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        assert!(scenes.iter().any(|scene| scene == name), "{}: nothing shows it", path.display());
    }
}

const SIDE: u32 = 121;

/// How many walls each pixel shows, of a surface of half an opacity.
fn walls(image: &Image) -> Vec<u32> {
    let walls = |opacity: f32| -(1.0 - opacity).log2();
    image.pixels().iter().map(|pixel| walls(pixel.opacity).round() as u32).collect()
}

/// The pixels of which rays and triangles tell different numbers of walls; and those whose neighbours have other
/// numbers than they, which are edges.
fn differing(scan: &Scan, iso: f64) -> (Vec<usize>, Vec<bool>) {
    let (color, name) = ([1.0; 3], "one".to_owned());
    let scene = Scene {
        surfaces: vec![SurfaceLook { name, iso: Some(iso), color, opacity: 0.5, texture: None }],
        clips: vec![],
        model: None,
        viewpoint: Viewpoint::At {
            from: [70.0, -90.0, 60.0],
            at: None,
            up: [0.0, 0.0, 1.0],
            projection: Projection::Perspective { fov: 25.0 },
        },
        raster: RasterOptions::DEFAULT.with_light(None).with_smoothing(Smoothing::None),
        raycast: RaycastOptions::DEFAULT,
    };
    let (job, side) = (Job::default(), NonZeroU32::new(SIDE).unwrap());
    let size = Size { width: side, height: side };
    let meshes = scene.meshes(scan, (&[scene.viewpoint], size), &job).unwrap();
    let drawn = scene.draw(&meshes, (Some(scan), scan.around()), size, &job).unwrap().0;
    let traced = scene.trace(scan, size, &job).unwrap().0;
    let [drawn, traced] = [drawn, traced].map(|image| walls(&image));
    assert!(drawn.iter().filter(|&&walls| walls > 0).count() > 2000, "hardly anything is seen");
    let side = SIDE as usize;
    let is_edge = |n: usize| {
        let (x, y) = (n % side, n / side);
        let around = |c: usize| c.saturating_sub(1)..(c + 2).min(side);
        let mut near = around(y).flat_map(|y| around(x).map(move |x| y * side + x));
        near.any(|m| drawn[m] != drawn[n] || traced[m] != traced[n])
    };
    let differ = (0..drawn.len()).filter(|&n| drawn[n] != traced[n]).collect();
    (differ, (0..drawn.len()).map(is_edge).collect())
}

fn scan(value: impl Fn([f64; 3]) -> f32) -> Scan {
    let grid = Grid::new([32; 3], Default::default()).unwrap();
    let at = |n: u64| [n % 32, n / 32 % 32, n / 1024].map(|i| i as f64);
    Scan::new(Volume::new(grid, (0..grid.count()).map(|n| value(at(n))).collect()).unwrap())
}

#[test]
fn rays_and_triangles_tell_the_same_walls_but_for_edges() {
    let gyroid = |[x, y, z]: [f64; 3]| {
        let [x, y, z] = [x, y, z].map(|c| c * 0.35);
        (x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()) as f32
    };
    let ball = |place: [f64; 3]| {
        13.0 - place.iter().map(|c| (c - 15.6).powi(2)).sum::<f64>().sqrt() as f32
    };
    for (scan, iso, most) in [(scan(ball), 0.0, 150), (scan(gyroid), 0.2, 700)] {
        let (differ, is_edge) = differing(&scan, iso);
        assert!(differ.len() < most, "{} pixels of {most} differ", differ.len());
        assert!(differ.iter().all(|&n| is_edge[n]), "one of them is within a surface");
    }
}
