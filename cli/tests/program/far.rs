//! A lattice so far from the origin that f32 has steps of several samples: files hold f64, or say what they
//! cannot hold.

use crate::kit::{Folder, Ran};
use isokit::{
    geom::{Affine, Frame, Space, Unit},
    io::write_volume,
    job::Job,
    mesh::Positions,
    volume::{Grid, Volume},
};

const FAR: f64 = 6.4e6;
const SPACING: f64 = 0.1;
const N: usize = 17;

/// With the same ball at the origin, `near.nrrd`, and far away, `far.nrrd`.
fn folder() -> Folder {
    let folder = Folder::new();
    for (name, origin) in [("near.nrrd", 0.0), ("far.nrrd", FAR)] {
        let index_to_world = Affine::axis_aligned([SPACING; 3], [origin; 3]).unwrap();
        let frame = Frame { index_to_world, unit: Unit::Metre, space: Space::Ras };
        let grid = Grid::new([N as u64; 3], frame).unwrap();
        let middle = (N - 1) as f32 / 2.0;
        let from_middle = |n: usize| [n % N, n / N % N, n / N / N].map(|i| i as f32 - middle);
        let ball = |n: usize| 6.3 - from_middle(n).iter().map(|c| c * c).sum::<f32>().sqrt();
        let volume = Volume::new(grid, (0..N * N * N).map(ball).collect()).unwrap();
        write_volume(&folder.path(name), &volume.into(), &Job::default()).unwrap();
    }
    folder
}

fn extract(folder: &Folder, volume: &str, mesh: &str, more: &str) -> Ran {
    let line = format!("extract {volume} --iso 0 -o {mesh} --report {mesh}.json {more}");
    folder.done(line.trim())
}

/// The vertices of the one surface in a file.
fn vertices(folder: &Folder, mesh: &str) -> Vec<[f64; 3]> {
    folder.mesh(mesh).surfaces[0].mesh.positions.iter().collect()
}

#[test]
fn formats_that_hold_f64_are_exact_and_say_nothing() {
    let folder = folder();
    for ending in ["ply", "obj"] {
        let (near, far) = (format!("near.{ending}"), format!("far.{ending}"));
        extract(&folder, "near.nrrd", &near, "--space ras");
        let ran = extract(&folder, "far.nrrd", &far, "--space ras");
        let report = folder.json(&format!("{far}.json"));
        assert_eq!(report["merged_vertices"], 0, "{ending}");
        assert!(!ran.err.contains("warning"), "{ending}: {}", ran.err);
        assert!(matches!(folder.mesh(&far).surfaces[0].mesh.positions, Positions::F64(_)));
        let (near, far) = (vertices(&folder, &near), vertices(&folder, &far));
        assert!(near.len() == far.len() && near.len() > 500);
        for (near, far) in near.iter().zip(&far) {
            // OBJ holds y up; both axes are as far away, and one has the other sign.
            let home = |c: f64| if c < -FAR / 2.0 { c + FAR } else { c - FAR };
            let off = (0..3).map(|k| (home(far[k]) - near[k]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-6, "{ending}: {far:?} for {near:?}");
        }
        let sound = folder.topology(&format!("far.{ending}"));
        assert!(sound.shortfalls().is_empty(), "{ending}");
    }
}

#[test]
fn formats_that_hold_f32_warn_and_count_what_falls_together() {
    let folder = folder();
    for ending in ["stl", "glb", "gltf"] {
        let mesh = format!("far.{ending}");
        let ran = extract(&folder, "far.nrrd", &mesh, "");
        let report = folder.json(&format!("{mesh}.json"));
        let merged = report["merged_vertices"].as_u64().unwrap();
        assert!(merged > 0 && ran.err.contains("warning"), "{ending}: {merged}, {}", ran.err);
        let warning = report["warnings"][0].as_str().unwrap();
        assert!(warning.contains(".ply and .obj keep every digit"), "{warning}");
        let ran = extract(&folder, "far.nrrd", &mesh, "--space index");
        let report = folder.json(&format!("{mesh}.json"));
        assert_eq!(report["merged_vertices"], 0, "{ending}: the remedy");
        assert!(!ran.err.contains("warning"), "{ending}: {}", ran.err);
    }
}

#[test]
fn slices_of_a_volume_far_away_are_as_exact() {
    let folder = folder();
    extract(&folder, "far.nrrd", "whole.ply", "");
    extract(&folder, "far.nrrd", "slabs.ply", "--max-memory 64MiB");
    assert!(vertices(&folder, "whole.ply") == vertices(&folder, "slabs.ply"));
}

/// Millimetres as far away as f32 goes: a step is a 64th of the distance of samples, and a step of a glTF's metres another.
#[test]
fn what_is_divided_and_balanced_falls_together_in_no_file() {
    let folder = Folder::new();
    let index_to_world = Affine::axis_aligned([1.0; 3], [255_500.0, -130_000.0, 200_000.0]);
    let unit = Unit::Millimetre;
    let frame = Frame { index_to_world: index_to_world.unwrap(), unit, space: Space::Ras };
    let grid = Grid::new([9; 3], frame).unwrap();
    // Whole numbers from −3 to 3 without an order.
    let ties = |n: u32| (n.wrapping_mul(2_654_435_761) >> 7).wrapping_mul(40_503) >> 9;
    let ties = (0..729).map(|n| (ties(n) % 7) as i8 - 3).collect();
    write_volume(
        &folder.path("far.nrrd"),
        &Volume::new(grid, ties).unwrap().into(),
        &Job::default(),
    )
    .unwrap();
    let (mut together, ways) =
        (0, ["--refine 2", "--balance", "--refine 1 --balance", "--max-error 0.02"]);
    for options in ways {
        for (ending, unit) in [("glb", ""), ("gltf", "--gltf-unit cm"), ("stl", ""), ("ply", "")] {
            let mesh = format!("far.{ending}");
            let ran = extract(&folder, "far.nrrd", &mesh, &format!("--space ras {options} {unit}"));
            let report = folder.json(&format!("{mesh}.json"));
            assert_eq!(report["merged_vertices"], 0, "{options}, {ending}");
            assert!(!ran.err.contains("hold"), "{options}, {ending}: {}", ran.err);
        }
        // What was made for millimetres may fall together in metres.
        let ran = folder.done("convert far.ply -o far.glb");
        together += usize::from(ran.err.contains("on the place of another one"));
    }
    assert!(together > 1, "{together}");
}

#[test]
fn creases_fall_together_in_no_file() {
    let folder = Folder::new();
    let mut converted = 0;
    for turn in [20, 35, 70] {
        let shape = format!(
            "unit = \"mm\"\n[shape]\nbox = {{ size = [14, 12, 1.4] }}\nrotate = {{ x = {turn}, z = 35 }}\n\
             move = [255500.3, -130000.2, 200000.1]\n"
        );
        std::fs::write(folder.path("part.toml"), shape).unwrap();
        for (mesh, more) in [("far.glb", ""), ("far.gltf", "--gltf-unit cm"), ("far.ply", "")] {
            let creases = "--spacing 1 --creases 30 --refine 1";
            folder.done(&format!("extract part.toml {creases} {more} --report r.json -o {mesh}"));
            assert_eq!(folder.json("r.json")["merged_vertices"], 0, "{mesh}, {turn}");
        }
        let ran = folder.done("convert far.ply -o far.glb");
        converted += usize::from(ran.err.contains("on the place of another one"));
    }
    assert!(converted > 0, "metres that nobody thought of show nothing");
}
