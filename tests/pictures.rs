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
    render::{Gathered, Image, Projection, RasterOptions, RaycastOptions, Size, Smoothing},
    scene::{Scene, SurfaceLook, Viewpoint},
    volume::{Grid, Volume},
};
use isokit_cli::{Exit, run};
use isokit_tests::{volumes, workspace};
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

/// Makes the picture of a scene, and whatever else options ask for; `@` in them is where the picture goes.
#[track_caller]
fn render(name: &str, to: &Path, options: &str) {
    let scene = workspace::root().join(format!("fixtures/scenes/{name}.toml"));
    let to = to.to_str().unwrap();
    let words = ["isokit", "render", scene.to_str().unwrap(), "-o", to].map(str::to_owned);
    let options = options.split_whitespace().map(|word| word.replace('@', to));
    let (mut out, mut err) = (vec![], vec![]);
    let exit = run(words.into_iter().chain(options), &mut out, &mut err);
    assert_eq!(exit, Exit::Done, "{name}: {}", String::from_utf8_lossy(&err));
}

#[test]
fn every_scene_looks_as_it_was_looked_at() {
    let (root, made) = (workspace::root().join("fixtures"), env::temp_dir());
    assert!(scenes().len() >= 8);
    for name in scenes() {
        let kept = root.join(format!("images/{name}.png"));
        let found = match env::var_os("UPDATE") {
            Some(_) => kept.clone(),
            None => made.join(format!("isokit-{}-{name}.png", std::process::id())),
        };
        render(&name, &found, "");
        assert_alike(&name, &found, &kept);
        if found != kept {
            fs::remove_file(found).unwrap();
        }
    }
}

#[test]
fn every_scene_of_the_guide_is_one() {
    let guide = workspace::root().join("crates/isokit/src/guide/pictures.md");
    let text = fs::read_to_string(guide).unwrap();
    let scenes = text.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap());
    let volume = workspace::root().join("fixtures/volumes/head.nii.gz");
    let name = format!("isokit-{}-guide.toml", std::process::id());
    let (path, mut whole) = (env::temp_dir().join(name), String::new());
    for (n, scene) in scenes.enumerate() {
        // The first is whole; the others are what its surfaces are seen with.
        if n == 0 {
            whole = scene.replace("head.nii.gz", volume.to_str().unwrap());
            fs::write(&path, &whole).unwrap();
            whole.truncate(whole.find("[output]").unwrap());
        } else {
            fs::write(&path, format!("{whole}{scene}")).unwrap();
        }
        let (mut out, mut err) = (vec![], vec![]);
        let words = ["isokit", "render", path.to_str().unwrap(), "--plan"];
        let exit = run(words, &mut out, &mut err);
        assert_eq!(exit, Exit::Done, "{scene}: {}", String::from_utf8_lossy(&err));
    }
    assert!(text.matches("```toml").count() >= 6);
    fs::remove_file(path).unwrap();
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

#[test]
fn one_thread_and_seven_make_the_bytes_that_two_make() {
    // Besides the scenes as they are: caps, shadows and occlusion by rays, what else surfaces have, and a sheet.
    let more = [
        ("clip", "--mode iso-raycast"),
        ("part", "--mode iso-raycast --depth @.npy"),
        ("shadows", "--mode iso-raycast"),
        ("rays", "--depth @.npy --normals @.normals.png"),
        ("surfaces", "--depth @.npy --normals @.normals.png"),
        ("surfaces", "--sheet"),
    ];
    let plain = scenes();
    let all = plain.iter().map(|name| (&**name, "")).chain(more);
    let folder = env::temp_dir().join(format!("isokit-{}-threads", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    for (name, options) in all {
        let made = |threads: usize| {
            let options = format!("{options} --bits 16 --size 64x48 --threads {threads}");
            render(name, &folder.join("a.png"), &options);
            let paths = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
            let mut paths: Vec<PathBuf> = paths.collect();
            paths.sort();
            assert_eq!(paths.len(), 1 + options.matches('@').count(), "{name} {options}");
            let taken = |path: PathBuf| (fs::read(&path).unwrap(), fs::remove_file(path).unwrap());
            paths.into_iter().map(|path| taken(path).0).collect::<Vec<_>>()
        };
        let expected = made(2);
        for threads in [1, 7] {
            assert!(made(threads) == expected, "{name} {options}: {threads} threads");
        }
    }
    fs::remove_dir_all(folder).unwrap();
}

const SIDE: usize = 121;

/// What a wall hides: so little that many of them can be told apart.
const OPACITY: f32 = 0.1;

/// How many walls each pixel shows.
fn walls(image: &Image) -> Vec<u32> {
    let walls = |pixel: &Gathered| {
        let walls = (1.0 - pixel.opacity).ln() / (1.0 - OPACITY).ln();
        assert!((walls - walls.round()).abs() < 0.02, "{walls} walls");
        walls.round() as u32
    };
    image.pixels().iter().map(walls).collect()
}

/// How many walls triangles show and how many rays do, in a perspective and in a parallel projection.
fn pictures(scan: &Scan, iso: f64) -> [[Vec<u32>; 2]; 2] {
    let widest = scan.part().iter().map(|range| range.len()).max().unwrap() as f64;
    let parallel = Projection::Parallel { height: 1.7 * widest };
    [Projection::Perspective { fov: 25.0 }, parallel].map(|projection| {
        let from = [2.2, -2.8, 1.9].map(|c| c * widest);
        let viewpoint =
            Viewpoint::At { from, at: None, up: [0.0, 0.0, 1.0], orbit: 0.0, projection };
        let (color, name) = ([1.0; 3], "one".to_owned());
        let look = SurfaceLook { name, iso: Some(iso), color, opacity: OPACITY, texture: None };
        let scene = Scene {
            surfaces: vec![look],
            clips: vec![],
            model: None,
            viewpoint,
            raster: RasterOptions::DEFAULT.with_light(None).with_smoothing(Smoothing::None),
            raycast: RaycastOptions::DEFAULT,
        };
        let (job, side) = (Job::default(), NonZeroU32::new(SIDE as u32).unwrap());
        let size = Size { width: side, height: side };
        let meshes = scene.meshes(scan, (&[viewpoint], size), &job).unwrap();
        let drawn = scene.draw(&meshes, (Some(scan), scan.around()), size, &job).unwrap().0;
        let traced = scene.trace(scan, size, &job).unwrap().0;
        let pictures = [drawn, traced].map(|image| walls(&image));
        for picture in &pictures {
            let seen = picture.iter().filter(|&&walls| walls > 0).count();
            assert!(seen > 2000, "hardly anything is seen: {seen}");
        }
        pictures
    })
}

/// The pixels in which two pictures differ: those where both have an edge, and those where one of them has none. An edge
/// lies between two pixels: one that differs from all around it makes none in the other picture. `moved` are pictures of
/// nearly the same: a fold thinner than a pixel may have its edge there alone.
fn differing(pictures: &[Vec<u32>; 2], moved: &[[Vec<u32>; 2]]) -> [Vec<usize>; 2] {
    let varies = |n: usize, picture: &[u32]| {
        let around = |c: usize| c.saturating_sub(1)..(c + 2).min(SIDE);
        let mut near = around(n / SIDE).flat_map(|y| around(n % SIDE).map(move |x| y * SIDE + x));
        near.any(|m| picture[m] != picture[n])
    };
    let has_edge = |n: usize, who: usize| {
        varies(n, &pictures[who]) || moved.iter().any(|moved| varies(n, &moved[who]))
    };
    let [one, other] = pictures;
    let differ = (0..one.len()).filter(|&n| one[n] != other[n]);
    let (edges, holes) = differ.partition(|&n| (0..2).all(|who| has_edge(n, who)));
    [edges, holes]
}

fn scan(value: impl Fn([f64; 3]) -> f64) -> Scan {
    let grid = Grid::new([32; 3], Default::default()).unwrap();
    let at = |n: u64| [n % 32, n / 32 % 32, n / 1024].map(|i| i as f64);
    let samples = (0..grid.count()).map(|n| value(at(n)) as f32).collect();
    Scan::new(Volume::new(grid, samples).unwrap())
}

#[test]
fn rays_and_triangles_tell_the_same_walls_but_for_edges() {
    let gyroid = |[x, y, z]: [f64; 3]| {
        let [x, y, z] = [x, y, z].map(|c| c * 0.35);
        x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
    };
    let ball =
        |place: [f64; 3]| 13.0 - place.iter().map(|c| (c - 15.6).powi(2)).sum::<f64>().sqrt();
    // Chance at every sixth sample or so, and in between what a cell has in between.
    let coarse = volumes::noise([6; 3], 1);
    let noise = |place: [f64; 3]| {
        let ijk = place.map(|c| c * 5.0 / 31.0);
        let low = ijk.map(|c| (c as usize).min(4));
        let corner = |k: usize| {
            let bit = |axis: usize| k >> axis & 1;
            let weight = |axis: usize| match (bit(axis), ijk[axis] - low[axis] as f64) {
                (0, along) => 1.0 - along,
                (_, along) => along,
            };
            let [x, y, z] = [0, 1, 2].map(|axis| low[axis] + bit(axis));
            weight(0) * weight(1) * weight(2) * f64::from(coarse.samples()[x + 6 * (y + 6 * z)])
        };
        (0..8).map(corner).sum()
    };
    for (scan, iso, most) in
        [(scan(ball), 0.0, 10), (scan(gyroid), 0.2, 100), (scan(noise), 0.1, 100)]
    {
        let views = pictures(&scan, iso);
        // Flat triangles are off the surface that rays meet about as much as these are.
        let moved = [-0.04, -0.02, -0.01, 0.01, 0.02, 0.04].map(|by| pictures(&scan, iso + by));
        for (view, pictures) in views.iter().enumerate() {
            let [edges, holes] = differing(pictures, &moved.each_ref().map(|m| m[view].clone()));
            assert!(edges.len() < most, "{} pixels of {most} differ at edges", edges.len());
            let holes: Vec<_> = holes.iter().map(|n| [n % SIDE, n / SIDE]).collect();
            assert!(holes.is_empty(), "not at an edge of both: {holes:?}");
        }
    }
}

#[test]
fn a_pinhole_in_one_picture_is_no_edge_and_an_edge_a_pixel_farther_is_one() {
    // Two walls on the left, none on the right.
    let edge_at = |column: usize| {
        let walls = |n: usize| if n % SIDE < column { 2 } else { 0 };
        (0..SIDE * SIDE).map(walls).collect::<Vec<u32>>()
    };
    let plain = edge_at(60);
    assert_eq!(differing(&[plain.clone(), plain.clone()], &[]), [vec![0; 0], vec![]]);
    let [edges, holes] = differing(&[plain.clone(), edge_at(61)], &[]);
    assert_eq!((edges.len(), holes.len()), (SIDE, 0));
    let moved = [59, 62].map(|column| [edge_at(column), edge_at(column)]);
    for (pixel, walls) in [(20 * SIDE + 30, 0), (20 * SIDE + 30, 1), (0, 4), (SIDE * 80 - 1, 2)] {
        let mut doctored = plain.clone();
        doctored[pixel] = walls;
        let expected = [vec![], vec![pixel]];
        assert_eq!(
            differing(&[doctored.clone(), plain.clone()], &moved),
            expected,
            "{walls} walls"
        );
        assert_eq!(differing(&[plain.clone(), doctored], &moved), expected, "{walls} walls");
    }
}

#[test]
fn through_noise_and_ties_one_looks_through_an_even_number_of_walls() {
    for seed in 0..3 {
        let noise = Scan::new(volumes::noise([9, 8, 10], seed));
        let ties = Scan::new(volumes::ties([9, 8, 10], 1, seed));
        for pictures in [pictures(&noise, 0.1), pictures(&ties, 0.0)].into_iter().flatten() {
            for (picture, who) in pictures.iter().zip(["triangles", "rays"]) {
                let odd = (0..SIDE * SIDE).filter(|&n| picture[n] % 2 == 1).count();
                assert_eq!(odd, 0, "{who}, seed {seed}: no closed surface shows that");
                assert!(picture.iter().any(|&walls| walls > 8), "{who}, seed {seed}");
            }
        }
    }
}
