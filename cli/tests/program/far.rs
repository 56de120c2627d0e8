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
