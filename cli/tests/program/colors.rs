//! `voxelize --colors` and `extract --attribute`: colours go from a mesh into a volume and come back.

use crate::kit::Folder;
use isokit::{
    geom::{Space, Unit},
    io::{MeshContext, open_colors, write_mesh},
    job::Job,
    lanes::Level,
    mesh::{Attributes, Positions, Rgba, Surface, TriMesh},
    volume::{Channels, ColorVolume},
};
use isokit_cli::Exit;
use std::{f64::consts::PI, fs, process::Command};

/// A ball of radius 10 around a place: bands of triangles, without normals.
pub(crate) fn ball(centre: [f64; 3]) -> TriMesh {
    let (n, m) = (96, 48);
    let place = |at: u32| {
        let (i, j) = (at / (m + 1), at % (m + 1));
        let a = 2.0 * PI * f64::from(i) / f64::from(n);
        let b = PI * f64::from(j) / f64::from(m);
        let direction = [b.sin() * a.cos(), b.sin() * a.sin(), -b.cos()];
        [0, 1, 2].map(|k| (centre[k] + 10.0 * direction[k]) as f32)
    };
    let name = |i: u32, j: u32| i % n * (m + 1) + j;
    let quad = |at: u32| {
        let (i, j) = (at / m, at % m);
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let is_triangle = |&[a, b, c]: &[u32; 3]| {
        place(a) != place(b) && place(a) != place(c) && place(b) != place(c)
    };
    TriMesh {
        positions: Positions::F32((0..n * (m + 1)).map(place).collect()),
        triangles: (0..n * m).flat_map(quad).filter(is_triangle).collect(),
        ..TriMesh::default()
    }
}

/// A colour of the direction from the origin, before it is rounded; opacity is last.
fn of_direction(place: [f64; 3]) -> [f64; 4] {
    let length = place.iter().map(|c| c * c).sum::<f64>().sqrt();
    let [x, y, z] = place.map(|c| c / length);
    [130.0 + 100.0 * x, 120.0 - 90.0 * y, 128.0 + 60.0 * z, 180.0 + 70.0 * z]
}

pub(crate) fn painted(mut mesh: TriMesh, color: impl Fn([f64; 3]) -> [u8; 4]) -> TriMesh {
    let colors = mesh.positions.iter().map(|place| Rgba(color(place))).collect();
    mesh.attributes = Attributes { values: None, colors: Some(colors) };
    mesh
}

pub(crate) fn opaque(place: [f64; 3]) -> [u8; 4] {
    let [r, g, b, _] = of_direction(place).map(|code| code.round() as u8);
    [r, g, b, 255]
}

pub(crate) fn write(folder: &Folder, name: &str, surfaces: &[Surface]) {
    let command = "test".to_owned();
    let context =
        MeshContext { unit: Unit::Millimetre, space: Space::Ras, command, gltf_unit: None };
    write_mesh(&folder.path(name), surfaces, &context, &Job::default()).unwrap();
}

pub(crate) fn surface(name: &str, mesh: TriMesh) -> Surface {
    Surface { name: name.to_owned(), mesh, ..Surface::default() }
}

fn colors(folder: &Folder, name: &str) -> ColorVolume {
    let file = open_colors(&folder.path(name), &Job::default()).unwrap().unwrap();
    file.collect(&Job::default()).unwrap()
}

/// Vertices of a mesh file, and their colours.
fn vertices(folder: &Folder, name: &str) -> Vec<([f64; 3], [u8; 4])> {
    let surfaces = folder.mesh(name).surfaces;
    let mesh = &surfaces[0].mesh;
    let colors = mesh.attributes.colors.as_ref().unwrap();
    mesh.positions.iter().zip(colors.iter().map(|color| color.0)).collect()
}

#[test]
fn a_ball_coloured_by_direction_comes_back_in_its_colours() {
    let folder = Folder::new();
    for name in ["a.ply", "a.glb", "a.gltf", "a.obj"] {
        write(&folder, name, &[surface("ball", painted(ball([0.0; 3]), opaque))]);
        for band in ["", "--band 1"] {
            let ran = folder
                .done(&format!("voxelize {name} --spacing 0.5 {band} -o d.nrrd --colors c.nrrd"));
            assert!(ran.err.contains("45 x 45 x 45 of colours, 3 bytes each"), "{}", ran.err);
            folder.done("extract d.nrrd --iso 0 --attribute c.nrrd -o b.ply --report r.json");
            let found = vertices(&folder, "b.ply");
            assert!(found.len() > 5000);
            for (place, color) in found {
                for (k, expected) in of_direction(place).into_iter().take(3).enumerate() {
                    let away = (f64::from(color[k]) - expected).abs();
                    assert!(away < 2.5, "{name} {band} {place:?}: {color:?}, not {expected}");
                }
                assert_eq!(color[3], 255);
            }
            let attribute = &folder.json("r.json")["vertex_colors"]["attribute"];
            assert_eq!(attribute["channels"], 3);
            assert!(attribute["range"].is_null() && attribute["without_value"] == 0);
        }
    }
}

#[test]
fn every_format_that_holds_colours_takes_them_as_they_are() {
    let folder = Folder::new();
    write(&folder, "a.ply", &[surface("ball", painted(ball([0.0; 3]), |_| [7, 200, 31, 255]))]);
    folder.done("voxelize a.ply --spacing 1 --mode occupancy -o d.nii --colors c.nhdr");
    let all = colors(&folder, "c.nhdr");
    assert!(all.samples().as_chunks::<3>().0.iter().all(|color| *color == [7, 200, 31]));
    for name in ["b.ply", "b.glb", "b.obj"] {
        folder.done(&format!("extract d.nii --iso 0.5 --attribute c.nhdr -o {name}"));
        let found = vertices(&folder, name);
        assert!(found.iter().all(|(_, color)| *color == [7, 200, 31, 255]), "{name}");
    }
    // Of a surface that something shows through, opacity stays.
    folder.done("extract d.nii --iso 0.5:#00000080 --attribute c.nhdr -o b.ply");
    assert!(vertices(&folder, "b.ply").iter().all(|(_, color)| *color == [7, 200, 31, 128]));
}

#[test]
fn info_shows_a_volume_of_colours() {
    let folder = Folder::new();
    for (name, opacity, says) in [
        ("c.nrrd", 255, "11 x 11 x 11 of colours, 3 bytes each (red, green, blue), 1 331 in all\n"),
        ("c.nhdr", 9, "colours, 4 bytes each (red, green, blue, opacity), 1 331 in all\n"),
    ] {
        let mesh = painted(ball([3.0, 0.0, 0.0]), |_| [1, 2, 3, opacity]);
        write(&folder, "a.ply", &[surface("ball", mesh)]);
        folder.done(&format!("voxelize a.ply --spacing 2 --margin 0 -o d.nrrd --colors {name}"));
        let ran = folder.done(&format!("info {name}"));
        let lattice = colors(&folder, name).grid().bounds().min[0];
        let place = format!("  from      {lattice} ");
        for words in
            [&format!("{name}: NRRD volume of colours\n"), says, "  unit      mm\n", &place]
        {
            assert!(ran.text().contains(words), "no {words:?} in {}", ran.text());
        }
        let report = folder.done(&format!("info {name} --json")).json();
        let found = [&report["schema"], &report["kind"], &report["space"], &report["dtype"]];
        assert_eq!(found, ["isokit.info/1", "volume of colors", "RAS", "u8"]);
        assert_eq!(report["channels"], if opacity == 255 { 3 } else { 4 });
        assert_eq!((&report["dims"][2], &report["spacing"][1]), (&11.into(), &2.0.into()));
        assert_eq!(report["index_to_world"][0][3], lattice);
    }
    for words in ["info c.nrrd --origin 0,0,0", "convert c.nrrd -o e.nii", "suggest c.nrrd"] {
        let ran = folder.run(words);
        let says = "3 numbers per sample (axis 0, rgb-color): they are colours, not values";
        assert!(ran.exit == Exit::Failed && ran.err.contains(says), "{words}: {}", ran.err);
        assert!(ran.err.contains("`isokit extract --attribute` takes it"), "{words}: {}", ran.err);
    }
}

#[test]
fn opacity_is_kept_where_something_shows_through() {
    let folder = Folder::new();
    let mesh = painted(ball([0.0; 3]), |place| of_direction(place).map(|code| code.round() as u8));
    write(&folder, "a.glb", &[surface("ball", mesh)]);
    folder.done("voxelize a.glb --spacing 0.5 -o d.nrrd --colors c.nrrd");
    assert_eq!(colors(&folder, "c.nrrd").channels(), Channels::Rgba);
    folder.done("extract d.nrrd --iso 0 --attribute c.nrrd -o b.ply");
    for (place, color) in vertices(&folder, "b.ply") {
        for (found, expected) in color.into_iter().zip(of_direction(place)) {
            assert!((f64::from(found) - expected).abs() < 2.5, "{place:?}: {color:?}");
        }
    }
}

#[test]
fn surfaces_have_colours_as_a_whole_too() {
    let folder = Folder::new();
    let colored = |name: &str, x: f64, color: Option<&str>| Surface {
        color: color.map(|color| color.parse().unwrap()),
        ..surface(name, ball([x, 0.0, 0.0]))
    };
    let surfaces = [colored("one", -30.0, Some("#ff0000")), colored("two", 0.0, None)];
    let last = surface("three", painted(ball([30.0, 0.0, 0.0]), |_| [0, 0, 255, 255]));
    write(&folder, "a.glb", &[&surfaces[..], &[last]].concat());
    let ran = folder.done("voxelize a.glb --spacing 1.5 -o d.nrrd --colors c.nrrd");
    assert!(ran.err.contains("two has no colours: it is taken as #cccccc"), "{}", ran.err);
    folder.done("extract d.nrrd --iso 0 --attribute c.nrrd -o b.ply");
    for ([x, ..], color) in vertices(&folder, "b.ply") {
        let expected = match x {
            ..-15.0 => [255, 0, 0, 255],
            -15.0..15.0 => [204, 204, 204, 255],
            _ => [0, 0, 255, 255],
        };
        assert_eq!(color, expected, "{x}");
    }
}

#[test]
fn what_is_beyond_the_colours_keeps_the_colour_of_its_surface() {
    let folder = Folder::with_ball();
    write(&folder, "a.ply", &[surface("ball", painted(ball([10.0, 33.0, 38.0]), opaque))]);
    folder.done("voxelize a.ply --spacing 1 --margin 0 -o d.nrrd --colors c.nrrd");
    let words = "--iso 50:#112233 --attribute c.nrrd --attribute-kernel nearest";
    let ran = folder.done(&format!("extract ball.nii {words} -o b.ply --report r.json"));
    assert!(ran.err.contains("are outside of it, and have the colour of"), "{}", ran.err);
    let (mut beyond, mut within) = (0, 0);
    for ([x, ..], color) in vertices(&folder, "b.ply") {
        assert!(x <= 20.6 || color == [0x11, 0x22, 0x33, 255], "{x}: {color:?}");
        if x > 20.6 { beyond += 1 } else { within += 1 }
    }
    let attribute = &folder.json("r.json")["vertex_colors"]["attribute"];
    assert!(attribute["without_value"].as_u64() >= Some(beyond) && beyond > 0 && within > 0);
    assert_eq!(attribute["kernel"], "nearest");
}

#[test]
fn any_instructions_and_any_number_of_threads_write_the_same_colours() {
    let folder = Folder::new();
    let uneven = |[x, y, z]: [f64; 3]| [x * y, y + z, x * z, 9.0 * z].map(|c| c.to_bits() as u8);
    write(&folder, "a.ply", &[surface("ball", painted(ball([0.0; 3]), uneven))]);
    let written = |level: Level, threads: &str| {
        let words = "voxelize a.ply --spacing 0.7 -o d.nrrd --colors c.nrrd --threads";
        let mut process = Command::new(env!("CARGO_BIN_EXE_isokit"));
        process.args(words.split(' ')).arg(threads).current_dir(folder.path(""));
        let done = process.env("ISOKIT_SIMD", level.name()).output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        ["d.nrrd", "c.nrrd"].map(|name| fs::read(folder.path(name)).unwrap())
    };
    let plain = written(Level::Portable, "1");
    for &level in Level::available() {
        for threads in ["1", "2"] {
            assert!(written(level, threads) == plain, "{level}, {threads} threads");
        }
    }
}

#[test]
fn words_that_do_not_fit_are_refused_before_anything_is_read() {
    let folder = Folder::new();
    for (words, says) in [
        ("-o a.nrrd --colors a.nii", "expected a name that ends in one of .nrrd .nhdr, found .nii"),
        ("-o a.nrrd --colors a.nrrd", "are the same file: choose another name for --colors"),
        ("-o a.nhdr --colors none.ply", "expected a name that ends in one of .nrrd .nhdr"),
    ] {
        let ran = folder.run(&format!("voxelize none.ply --spacing 1 {words}"));
        assert!(ran.exit == Exit::Usage && ran.err.contains(says), "{words}: {}", ran.err);
    }
    let ran = folder.run("voxelize none.ply --spacing 1 -o a.nhdr --colors a.raw");
    assert!(ran.exit == Exit::Usage, "{}", ran.err);
    assert!(folder.names().is_empty());
}

#[test]
fn what_cannot_be_is_said_and_nothing_is_written() {
    let folder = Folder::with_ball();
    write(&folder, "plain.ply", &[surface("ball", ball([0.0; 3]))]);
    write(&folder, "a.ply", &[surface("ball", painted(ball([0.0; 3]), opaque))]);
    folder.done("voxelize a.ply --spacing 2 -o d.nrrd --colors c.nrrd");
    let names = folder.names();
    for (words, says) in [
        (
            "voxelize plain.ply --spacing 1 -o e.nrrd --colors f.nrrd",
            "plain.ply: neither vertices nor surfaces have colours",
        ),
        ("voxelize a.ply --spacing 1e-5 -o e.nrrd --colors f.nrrd", "the volume of colours needs"),
        (
            "extract d.nrrd --iso 0 --attribute c.nrrd --colormap gray -o b.ply",
            "c.nrrd: it holds colours already, no values for a --colormap",
        ),
        (
            "extract d.nrrd --iso 0 --attribute c.nrrd --texture wood -o b.ply",
            "c.nrrd: it holds colours, and --texture makes others",
        ),
        (
            "extract d.nrrd --iso 0 --attribute ball.nii -o b.obj",
            "ball.nii: OBJ holds colours of vertices, but no values",
        ),
        ("extract c.nrrd --iso 0 -o b.ply", "3 numbers per sample (axis 0, rgb-color)"),
        ("extract d.nrrd --iso 0 --attribute none.nrrd -o b.ply", "none.nrrd"),
    ] {
        let ran = folder.run(words);
        assert!(ran.exit == Exit::Failed && ran.err.contains(says), "{words}: {}", ran.err);
        assert_eq!(folder.names(), names, "{words}");
    }
}
