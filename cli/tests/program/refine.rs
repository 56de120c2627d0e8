//! `extract --refine`, `--max-error` and `--balance`: nearer to the field, and what cannot be had so.

use crate::kit::{Folder, ball};
use isokit::geom::Space;
use isokit_cli::Exit;
use serde_json::{Value, json};
use std::fs;

/// What the report says of the one surface, and whether `check` finds nothing.
#[track_caller]
fn report(folder: &Folder, options: &str) -> Value {
    folder.done(&format!("extract ball.nii --iso 50 -o a.ply --report r.json {options}"));
    folder.done("check a.ply");
    folder.json("r.json")["surfaces"][0].clone()
}

/// How wrong the volume of the ball is, relative.
fn error(surface: &Value) -> f64 {
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 4_f64.powi(3);
    (surface["volume"].as_f64().unwrap() / volume - 1.0).abs()
}

#[test]
fn each_triangle_becomes_four_as_often_as_asked() {
    let folder = Folder::with_ball();
    let plain = report(&folder, "--placement cubic");
    assert_eq!(plain.get("refined"), None);
    let mut before = plain;
    for n in 1..=2 {
        let after = report(&folder, &format!("--refine {n}"));
        let triangles = before["triangles"].as_u64().unwrap();
        assert_eq!(after["triangles"], 4 * triangles);
        assert_eq!(after["refined"]["rounds"], n);
        assert_eq!(after["refined"]["unprojected_vertices"], 0);
        assert!(error(&after) < 0.5 * error(&before), "{after}");
        before = after;
    }
}

#[test]
fn a_balanced_ball_has_as_many_triangles_and_nearly_its_volume() {
    let folder = Folder::with_ball();
    let plain = report(&folder, "--placement cubic");
    let balanced = report(&folder, "--balance");
    assert_eq!(balanced["triangles"], plain["triangles"]);
    assert_eq!(balanced["refined"]["balanced_vertices"], plain["vertices"]);
    assert_eq!(balanced["refined"]["unbalanced_vertices"], 0);
    assert!(error(&balanced) < 0.2 * error(&plain), "{balanced} of {plain}");
}

#[test]
fn an_error_in_millimetres_is_reached_and_told() {
    let folder = Folder::with_ball();
    let coarse = report(&folder, "--max-error 0.2");
    let fine = report(&folder, "--max-error 0.05");
    for (surface, error) in [(&coarse, 0.2), (&fine, 0.05)] {
        let refined = &surface["refined"];
        assert_eq!(refined["max_error"], error);
        assert!(refined["bound"].as_f64().unwrap() <= error, "{refined}");
        assert_eq!(refined["unbounded_triangles"], 0, "{refined}");
    }
    assert!(fine["triangles"].as_u64().unwrap() > coarse["triangles"].as_u64().unwrap());
    assert!(error(&fine) < error(&coarse));
}

/// A folder with a volume of noise.
fn with_noise() -> Folder {
    let folder = Folder::new();
    let noise = |[x, y, z]: [usize; 3]| ((x * 7919 + y * 104_729 + z * 1_299_709) % 251) as f32;
    folder.volume("noise.nii", Space::Ras, noise);
    folder
}

#[test]
fn of_noise_it_is_told_which_vertices_could_not_be_balanced() {
    let folder = with_noise();
    let ran = folder.done("extract noise.nii --iso 125 --balance -v -o a.ply --report r.json");
    let surface = folder.json("r.json")["surfaces"][0].clone();
    let counted = |what: &str| surface["refined"][what].as_u64().unwrap();
    let [moved, kept] = ["balanced_vertices", "unbalanced_vertices"].map(counted);
    assert!(kept > 0, "{surface}");
    assert!(moved + kept <= surface["vertices"].as_u64().unwrap(), "{surface}");
    let said = ran.err.lines().find(|line| line.contains("could not be")).unwrap_or_default();
    let digits = |text: &str| text.chars().filter(char::is_ascii_digit).collect::<String>();
    assert!(digits(said).ends_with(&format!("{moved}{kept}")), "{said}");
    folder.done("check a.ply");
}

#[test]
fn of_noise_it_is_told_how_much_has_no_bound() {
    let folder = with_noise();
    let line = "extract noise.nii --iso 125 --max-error 0.5 -o a.ply --report r.json";
    let ran = folder.done(line);
    let unbounded = folder.json("r.json")["surfaces"][0]["refined"]["unbounded_triangles"].clone();
    assert!(unbounded.as_u64().unwrap() > 0);
    assert!(ran.err.contains("warning: iso_125: of "), "{}", ran.err);
    assert!(ran.err.contains("leave the surface by 0.5 at most"), "{}", ran.err);
    folder.done("check a.ply");
}

#[test]
fn what_is_refined_is_placed_on_cubics_unless_something_else_is_asked_for() {
    let folder = Folder::with_ball();
    let bytes = |options: &str| {
        folder.done(&format!("extract ball.nii --iso 50 -o a.stl {options}"));
        let bytes = fs::read(folder.path("a.stl")).unwrap();
        bytes[80..].to_vec() // the beginning names the command
    };
    for way in ["--refine 1", "--balance", "--max-error 0.1"] {
        let chosen = bytes(way);
        assert!(chosen == bytes(&format!("{way} --placement cubic")), "{way}");
        assert!(chosen != bytes(&format!("{way} --placement linear")), "{way}");
    }
}

#[test]
fn several_surfaces_are_refined_each_by_its_own_value_and_threads_change_nothing() {
    let folder = Folder::with_ball();
    let line = "extract ball.nii --iso 20 --iso 60 --refine 1 --balance";
    folder.done(&format!("{line} -o one.glb --report r.json --threads 1"));
    folder.done(&format!("{line} -o two.glb --threads 3"));
    assert!(fs::read(folder.path("one.glb")).unwrap() == fs::read(folder.path("two.glb")).unwrap());
    let report = folder.json("r.json");
    for (surface, iso) in report["surfaces"].as_array().unwrap().iter().zip([20.0, 60.0]) {
        let radius: f64 = (100.0 - iso) / 12.5;
        let volume = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        assert!((surface["volume"].as_f64().unwrap() / volume - 1.0).abs() < 0.02, "{surface}");
    }
    assert!(report["timings_s"]["mend"].as_f64().unwrap() > 0.0);
}

#[test]
fn fitted_diagonals_join_the_same_vertices_otherwise_whatever_normals_are_kept() {
    let folder = Folder::with_ball();
    let counts = |surface: &Value| [surface["vertices"].clone(), surface["triangles"].clone()];
    let plain = report(&folder, "");
    let fitted = report(&folder, "--diagonals fitted");
    assert_eq!(counts(&fitted), counts(&plain));
    let bytes = |options: &str| {
        folder.done(&format!("extract ball.nii --iso 50 -o a.stl {options}"));
        fs::read(folder.path("a.stl")).unwrap()[80..].to_vec()
    };
    let chosen = bytes("--diagonals fitted");
    assert!(chosen != bytes(""));
    for same in ["--threads 1", "--normals none", "--normals area", "--index"] {
        assert!(chosen == bytes(&format!("--diagonals fitted {same}")), "{same}");
    }
    let balanced = report(&folder, "--diagonals fitted --balance");
    assert_eq!(counts(&balanced), counts(&plain));
}

#[test]
fn an_empty_surface_stays_empty() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 1000 --refine 2 --balance -o a.ply --report r.json");
    assert_eq!(folder.json("r.json")["surfaces"][0]["triangles"], json!(0));
}

#[test]
fn what_does_not_fit_together_is_refused_before_anything_is_read() {
    let folder = Folder::new();
    folder.volume("ball.nii", Space::Ras, ball);
    for (options, says) in [
        ("--refine 0", "expected 1 to 6, found \"0\""),
        ("--refine 7", "expected 1 to 6, found \"7\""),
        ("--max-error 0", "expected a distance above 0, found \"0\""),
        ("--max-error=-1", "expected a distance above 0, found \"-1\""),
        ("--max-error nan", "expected a distance above 0, found \"nan\""),
        ("--max-error 1 --refine 1", "cannot be used with"),
        ("--diagonals fitted --max-memory 1GiB", "--diagonals fitted needs the whole mesh"),
        ("--diagonals straight", "invalid value 'straight'"),
        ("--balance --max-memory 1GiB", "need the whole mesh and the whole volume in memory"),
        ("--refine 1 --max-memory 1GiB", "leave out either them or --max-memory"),
        ("--max-error 1 --max-memory 1GiB", "leave out either them or --max-memory"),
        ("--balance --degenerate exact", "--degenerate exact makes triangles without area"),
    ] {
        let ran = folder.run(&format!("extract ball.nii --iso 50 -o a.ply {options}"));
        assert_eq!(ran.exit, Exit::Usage, "{options}: {}", ran.err);
        assert!(ran.err.contains(says), "{options}: {}", ran.err);
        assert_eq!(folder.names(), ["ball.nii"], "{options}");
    }
}
