//! `voxelize`: meshes become volumes, and those become the meshes again.

use crate::kit::{Folder, assert_near, middle};
use isokit::{
    io::{VolumeOptions, read_volume},
    job::Job,
    lanes::Level,
    volume::{AnyVolume, Grid},
};
use isokit_cli::Exit;
use std::{
    f64::consts::TAU,
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

type Mesh = (Vec<[f64; 3]>, Vec<[usize; 3]>);

/// Writes a mesh as PLY, in f64.
fn ply(folder: &Folder, name: &str, (places, triangles): &Mesh) {
    let mut text = "ply\nformat ascii 1.0\n".to_owned();
    writeln!(text, "element vertex {}", places.len()).unwrap();
    ["x", "y", "z"].iter().for_each(|axis| writeln!(text, "property double {axis}").unwrap());
    writeln!(text, "element face {}", triangles.len()).unwrap();
    text.push_str("property list uchar int vertex_indices\nend_header\n");
    places.iter().for_each(|[x, y, z]| writeln!(text, "{x} {y} {z}").unwrap());
    triangles.iter().for_each(|[a, b, c]| writeln!(text, "3 {a} {b} {c}").unwrap());
    fs::write(folder.path(name), text).unwrap();
}

/// A box with two triangles a side.
fn cuboid(half: [f64; 3]) -> Mesh {
    let corner = |k: usize| [0, 1, 2].map(|axis| half[axis] * ((k >> axis & 1) as f64 * 2.0 - 1.0));
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}

/// A grid of `n` by `m` places that is closed both ways; the place of each is of turns around the axis and the tube.
fn torus(radius: f64, tube: f64, [n, m]: [usize; 2]) -> Mesh {
    let place = |i: usize, j: usize| {
        let (a, b) = (i as f64 / n as f64 * TAU, j as f64 / m as f64 * TAU);
        let out = radius + tube * b.cos();
        [out * a.cos(), out * a.sin(), tube * b.sin()]
    };
    let places = (0..n * m).map(|at| place(at / m, at % m)).collect();
    let name = |i: usize, j: usize| i % n * m + j % m;
    let quad = |at: usize| {
        let (i, j) = (at / m, at % m);
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    (places, (0..n * m).flat_map(quad).collect())
}

/// Samples as f64, and where they are.
fn samples(folder: &Folder, name: &str) -> (Grid, Vec<f64>) {
    let read = read_volume(&folder.path(name), &VolumeOptions::default(), &Job::default()).unwrap();
    let samples = match &read.volume {
        AnyVolume::F32(volume) => volume.samples().iter().map(|&s| f64::from(s)).collect(),
        AnyVolume::U8(volume) => volume.samples().iter().map(|&s| f64::from(s)).collect(),
        other => panic!("{}", other.dtype()),
    };
    (*read.volume.grid(), samples)
}

fn points(grid: &Grid) -> impl Iterator<Item = [f64; 3]> {
    let ([nx, ny, nz], frame) = (grid.dims(), grid.frame.index_to_world);
    let at = move |n: u64| [n % nx, n / nx % ny, n / (nx * ny)];
    (0..nx * ny * nz).map(move |n| frame.point(at(n).map(|c| c as f64)))
}

/// How far the surface of a box is, positive inside.
fn to_cuboid(half: [f64; 3], p: [f64; 3]) -> f64 {
    let beside = [0, 1, 2].map(|k| p[k].abs() - half[k]);
    let out = beside.map(|c| c.max(0.0).powi(2)).iter().sum::<f64>().sqrt();
    -out - beside.into_iter().fold(f64::NEG_INFINITY, f64::max).min(0.0)
}

fn to_torus(radius: f64, tube: f64, [x, y, z]: [f64; 3]) -> f64 {
    tube - (x.hypot(y) - radius).hypot(z)
}

const HALF: [f64; 3] = [2.0, 1.5, 1.0];

#[test]
fn a_box_has_the_distances_of_a_box() {
    let folder = Folder::new();
    ply(&folder, "box.ply", &cuboid(HALF));
    let ran = folder.done("voxelize box.ply --spacing 0.3,0.25,0.2 -o far.nrrd");
    assert!(ran.err.contains("19 x 17 x 15 of f32"), "{}", ran.err);
    let (grid, found) = samples(&folder, "far.nrrd");
    assert_near(grid.frame.index_to_world.spacing(), [0.3, 0.25, 0.2], 1e-12);
    for (p, found) in points(&grid).zip(found) {
        let expected = to_cuboid(HALF, p);
        assert!((found - expected).abs() < 1e-6, "{p:?}: {found}, not {expected}");
    }
    folder.done("voxelize box.ply --spacing 0.3,0.25,0.2 --band 0.4 -o near.nrrd");
    for (p, found) in points(&grid).zip(samples(&folder, "near.nrrd").1) {
        assert!((found - to_cuboid(HALF, p).clamp(-0.4, 0.4)).abs() < 1e-6, "{p:?}: {found}");
    }
    folder.done("voxelize box.ply --spacing 0.3 --mode occupancy --margin 4 -o full.nii.gz");
    let (grid, found) = samples(&folder, "full.nii.gz");
    assert_eq!(grid.dims(), [23, 19, 16]);
    for (p, found) in points(&grid).zip(found) {
        let expected = to_cuboid(HALF, p);
        assert!(expected.abs() < 1e-6 || found == f64::from(u8::from(expected > 0.0)), "{p:?}");
    }
}

#[test]
fn a_mesh_comes_back_from_its_distances_ever_better() {
    let folder = Folder::new();
    ply(&folder, "ring.ply", &torus(1.0, 0.4, [256, 128]));
    let known = folder.topology("ring.ply");
    assert!(known.shortfalls().is_empty() && known.genus() == Some(1), "{known:?}");
    let spacings = [0.16, 0.08, 0.04];
    let errors = spacings.map(|h| {
        folder.done(&format!("voxelize ring.ply --spacing {h} -o ring.nrrd"));
        let (grid, found) = samples(&folder, "ring.nrrd");
        for (p, found) in points(&grid).zip(found) {
            let away = (found - to_torus(1.0, 0.4, p)).abs();
            assert!(away < 4e-4, "{p:?} is {away} farther than of a smooth ring");
        }
        folder.done("extract ring.nrrd --iso 0 -o back.ply");
        let back = folder.topology("back.ply");
        assert!(back.shortfalls().is_empty() && back.genus() == Some(1), "{back:?}");
        assert_near(middle(&back), [0.0; 3], h);
        let mesh = &folder.mesh("back.ply").surfaces[0].mesh;
        for p in mesh.positions.iter() {
            let away = to_torus(1.0, 0.4, p).abs();
            assert!(away < 0.5 * h, "{p:?} is {away} from where it was");
        }
        (back.measure.volume / known.measure.volume - 1.0).abs()
    });
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(order > 1.8, "volumes are wrong by {errors:?}: order {order}");
    }
    assert!(errors[2] < 0.005, "{errors:?}");
}

/// The ring without a patch, with some faces turned over and others twice there.
fn broken() -> Mesh {
    let (places, all) = torus(1.0, 0.4, [64, 32]);
    let mut triangles = vec![];
    for (n, [a, b, c]) in all.into_iter().enumerate() {
        // A strip along the tube is 64 triangles long.
        let is_hole = n < 3 * 64 && n % 64 < 6;
        match n % 7 {
            _ if is_hole => {}
            1 => triangles.push([a, c, b]),
            3 => triangles.extend([[a, b, c]; 2]),
            _ => triangles.push([a, b, c]),
        }
    }
    (places, triangles)
}

#[test]
fn a_broken_mesh_has_an_inside_and_is_told_of() {
    let folder = Folder::new();
    let mesh = broken();
    ply(&folder, "broken.ply", &mesh);
    let ran = folder.done("voxelize broken.ply --spacing 0.06 -o broken.nrrd");
    for says in ["counted once", "turned to be wound as their neighbours", "the surface ends"] {
        assert!(ran.err.contains(says), "{}", ran.err);
    }
    let (grid, found) = samples(&folder, "broken.nrrd");
    for (p, found) in points(&grid).zip(found) {
        // Near the hole, at the outer side, where x is most, the lid is between its edges.
        let is_at_hole = p[0] > 1.2 && p[1].abs() < 0.6;
        let expected = to_torus(1.0, 0.4, p);
        let is_near = expected.abs() < 0.01;
        assert!(is_at_hole || is_near || (found > 0.0) == (expected > 0.0), "{p:?}: {found}");
    }
    folder.done("extract broken.nrrd --iso 0 -o mended.ply");
    let mended = folder.topology("mended.ply");
    assert!(mended.shortfalls().is_empty() && mended.genus() == Some(1), "{mended:?}");
    let exact = 0.5 * TAU * TAU * 0.16;
    assert!((mended.measure.volume / exact - 1.0).abs() < 0.03, "{}", mended.measure.volume);
}

#[test]
fn vertices_of_no_triangle_count_for_nothing() {
    let folder = Folder::new();
    let mut mesh = cuboid(HALF);
    ply(&folder, "a.ply", &mesh);
    mesh.0.push([1e9, 0.0, 0.0]);
    ply(&folder, "b.ply", &mesh);
    for name in ["a", "b"] {
        folder.done(&format!("voxelize {name}.ply --spacing 0.5 -o {name}.nrrd"));
    }
    let [a, b] = ["a.nrrd", "b.nrrd"].map(|name| fs::read(folder.path(name)).unwrap());
    assert!(a == b);
}

#[test]
fn thin_walls_are_kept_on_request() {
    let folder = Folder::new();
    let (sin, cos) = 0.5_f64.sin_cos();
    // Oblique to the samples, so that hardly any is in it.
    let tilt = |[x, y, z]: [f64; 3]| {
        let [x, y] = [cos * x - sin * y, sin * x + cos * y];
        [x, cos * y - sin * z, sin * y + cos * z]
    };
    let (places, triangles) = cuboid([1.0, 1.0, 0.01]);
    ply(&folder, "plate.ply", &(places.into_iter().map(tilt).collect(), triangles));
    let inside = |words: &str| {
        folder.done(&format!("voxelize plate.ply --spacing 0.3 {words} -o a.nrrd"));
        samples(&folder, "a.nrrd").1.into_iter().filter(|&value| value > 0.0).count()
    };
    let few = inside("--mode occupancy");
    let kept = inside("--mode occupancy --conservative");
    assert!(few < 10 && kept > 45, "{few} and {kept}"); // 45 cells are as large as one side of it
    assert_eq!(inside("--conservative"), kept);
    folder.done("extract a.nrrd --iso 0 -o kept.ply");
    let found = folder.topology("kept.ply");
    assert!(found.shortfalls().is_empty() && found.components.len() == 1, "{found:?}");
    // Every point of the plate has its nearest sample inside.
    let (grid, distances) = samples(&folder, "a.nrrd");
    for n in 0..41 * 41 {
        let [u, v] = [n % 41, n / 41].map(|at| f64::from(at) / 20.0 - 1.0);
        let beside = |p: [f64; 3]| {
            let from = tilt([u, v, 0.0]);
            (0..3).all(|k| (p[k] - from[k]).abs() <= 0.15 + 1e-9)
        };
        let near = points(&grid).zip(&distances).find(|(p, _)| beside(*p));
        assert!(near.is_some_and(|(_, &distance)| distance >= 0.0), "{u}, {v}: {near:?}");
    }
}

/// The bytes that a process of its own writes.
fn written(folder: &Folder, level: Level, threads: &str) -> Vec<u8> {
    let mut process = std::process::Command::new(env!("CARGO_BIN_EXE_isokit"));
    process.args(["voxelize", "a.ply", "--spacing", "0.05", "-o", "a.nrrd", "--threads", threads]);
    let done = process.current_dir(folder.path("")).env("ISOKIT_SIMD", level.name()).output();
    let done = done.unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    fs::read(folder.path("a.nrrd")).unwrap()
}

#[test]
fn any_instructions_and_any_number_of_threads_write_the_same_bytes() {
    let folder = Folder::new();
    for mesh in [torus(1.0, 0.4, [40, 20]), broken()] {
        ply(&folder, "a.ply", &mesh);
        let plain = written(&folder, Level::Portable, "1");
        for &level in Level::available() {
            for threads in ["1", "2", "5"] {
                assert!(written(&folder, level, threads) == plain, "{level}, {threads} threads");
            }
        }
    }
}

#[test]
fn words_that_do_not_fit_are_refused_before_anything_is_read() {
    let folder = Folder::new();
    for (words, says) in [
        ("none.ply --spacing 1 -o a.ply", "expected a name that ends in one of"),
        ("none.ply --spacing 0 -o a.nii", "expected one distance above 0"),
        ("none.ply --spacing nan -o a.nii", "expected one distance above 0"),
        ("none.ply --spacing 1 --band 0 -o a.nii", "expected a distance above 0"),
        ("none.ply --spacing 1 --band -1 -o a.nii", "--band"),
        ("none.ply --spacing 1 --band 1 --mode occupancy -o a.nii", "leave it out"),
        ("none.ply --spacing 1 --margin -1 -o a.nii", "--margin"),
        ("none.ply -o a.nii", "--spacing <X[,Y,Z]>"),
    ] {
        let ran = folder.run(&format!("voxelize {words}"));
        assert!(ran.exit == Exit::Usage && ran.err.contains(says), "{words}: {}", ran.err);
    }
    assert!(folder.names().is_empty());
}

#[test]
fn what_cannot_be_is_said_with_its_place() {
    let folder = Folder::with_ball();
    ply(&folder, "box.ply", &cuboid(HALF));
    fs::write(folder.path("empty.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();
    let nan = f32::NAN.to_le_bytes();
    let mut stl = vec![0; 84];
    stl[80] = 1;
    stl.extend([0.0_f32; 9].iter().flat_map(|c| c.to_le_bytes()).chain(nan));
    stl.extend([0; 10]);
    fs::write(folder.path("nan.stl"), stl).unwrap();
    let names = folder.names();
    for (words, says) in [
        ("none.ply --spacing 1", "none.ply"),
        ("ball.nii --spacing 1", "this is a volume, and `voxelize` is for meshes"),
        ("empty.obj --spacing 1", "empty.obj"),
        ("nan.stl --spacing 1", "finite"),
        ("box.ply --spacing 1e-5", "the volume needs"),
        ("box.ply --spacing 1e-12", "are more than can be numbered"),
        ("box.ply --spacing 1e-300", "are more than can be numbered"),
        ("box.ply --spacing 1 --margin 4000000000", "are more than can be numbered"),
    ] {
        let ran = folder.run(&format!("voxelize {words} -o a.nii"));
        assert!(ran.exit == Exit::Failed && ran.err.contains(says), "{words}: {}", ran.err);
        assert!(ran.err.contains("error: "), "{}", ran.err);
        assert_eq!(folder.names(), names, "{words}");
    }
}

/// The folder of meshes by others, or `None` with one line that says so.
#[expect(clippy::print_stdout, reason = "whoever watches should see that nothing was tested")]
fn data() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/meshes");
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: {} is absent", folder.display());
    None
}

#[test]
fn meshes_by_others_become_closed_ones() {
    let Some(data) = data() else { return };
    let folder = Folder::new();
    // The bunny has five holes below; busted, featuretype and the soup have edges of one triangle or of many.
    for name in [
        "bunny.ply",
        "cow.obj",
        "trimesh/busted.STL",
        "trimesh/featuretype.STL",
        "trimesh/joined_tetrahedra.obj",
        "trimesh/multibody.stl",
        "trimesh/soup.stl",
        "trimesh/suzanne.ply",
        "trimesh/teapot.stl",
        "trimesh/unit_sphere.STL",
    ] {
        let bytes = fs::read(data.join(name)).unwrap();
        let own = Path::new(name).file_name().unwrap().to_string_lossy().to_lowercase();
        fs::write(folder.path(&own), bytes).unwrap();
        let mesh = folder.mesh(&own);
        let bounds = mesh.surfaces[0].mesh.bounds().unwrap();
        let longest =
            [0, 1, 2].map(|k| bounds.max[k] - bounds.min[k]).into_iter().fold(0.0, f64::max);
        let spacing = longest / 60.0;
        folder.done(&format!("voxelize {own} --spacing {spacing} -o a.nrrd"));
        let (_, found) = samples(&folder, "a.nrrd");
        assert!(found.iter().all(|d| d.is_finite()), "{name}");
        assert!(found.iter().any(|&d| d > 0.0), "{name}: nothing is inside");
        folder.done("extract a.nrrd --iso 0 -o a.ply");
        let back = folder.topology("a.ply");
        assert!(back.shortfalls().is_empty(), "{name}: {back:?}");
    }
}
