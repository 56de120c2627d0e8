//! The report: the keys that scripts rely on, and what stands there.

use crate::kit::Folder;
use isokit::geom::Space;
use isokit_cli::Exit;
use serde_json::{Value, json};

fn report(options: &str) -> (Folder, Value) {
    let folder = Folder::with_ball();
    folder.done(&format!("extract ball.nii --iso 50:ball -o a.glb --report r.json {options}"));
    let report = folder.json("r.json");
    (folder, report)
}

#[track_caller]
fn assert_keys(object: &Value, keys: &[&str]) {
    for key in keys {
        assert!(object.get(key).is_some(), "no {key} in {object}");
    }
}

#[test]
fn every_key_that_was_promised_is_there() {
    let (_, report) = report("--threads 2");
    assert_eq!(report["schema"], "isokit.extract/1");
    let keys = ["input", "surfaces", "skipped", "timings_s", "threads", "simd", "peak_rss_bytes"];
    assert_keys(&report, &keys);
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(report["threads"], 2);
    let keys = ["path", "format", "dims", "dtype", "spacing", "index_to_world", "unit", "space"];
    assert_keys(&report["input"], &keys);
    let keys = ["name", "iso", "vertices", "triangles", "components", "euler", "boundary_edges"];
    assert_keys(&report["surfaces"][0], &keys);
    let keys = ["nonmanifold_edges", "degenerate_triangles", "area", "volume", "bounds"];
    assert_keys(&report["surfaces"][0], &keys);
    assert_keys(&report["surfaces"][0], &["singular_cells"]);
    assert_keys(&report["skipped"], &["bricks", "bricks_skipped", "samples_read"]);
    assert_keys(&report["timings_s"], &["read", "index", "extract", "mend", "write", "total"]);
}

#[test]
fn cells_in_which_the_field_touches_itself_are_counted() {
    let folder = Folder::new();
    // The saddle of one face is 0, and both cells of the face have it.
    folder.volume("saddle.nii", Space::Ras, |ijk| match ijk {
        [5, 5, 5] | [6, 6, 5] => 1.0,
        [6, 5, 5] | [5, 6, 5] => -1.0,
        _ => -9.0,
    });
    for (topology, cells) in [("trilinear", 2), ("table", 0)] {
        let line = "extract saddle.nii --iso 0 -o a.ply --report r.json -v";
        let ran = folder.done(&format!("{line} --topology {topology}"));
        assert_eq!(folder.json("r.json")["surfaces"][0]["singular_cells"], cells, "{topology}");
        let says = "a saddle is exactly on the isovalue in 2 cells";
        assert_eq!(ran.err.contains(says), cells > 0, "{}", ran.err);
    }
}

#[test]
fn the_input_is_described_as_it_is() {
    let (_, report) = report("");
    let input = &report["input"];
    assert_eq!(input["format"], "nifti");
    assert_eq!(input["dims"], json!([16, 14, 12]));
    assert_eq!(input["dtype"], "f32");
    assert_eq!(input["spacing"], json!([1.0, 2.0, 1.5]));
    let rows = json!([
        [1.0, 0.0, 0.0, 10.0],
        [0.0, 2.0, 0.0, 20.0],
        [0.0, 0.0, 1.5, 30.0],
        [0.0, 0.0, 0.0, 1.0]
    ]);
    assert_eq!(input["index_to_world"], rows);
    assert_eq!((&input["unit"], &input["space"]), (&json!("mm"), &json!("RAS")));
    assert_eq!(input["nan"], 0);
    assert!(input["range"][0].as_f64().unwrap() < 0.0);
    assert_eq!(report["skipped"]["samples_read"], 16 * 14 * 12);
    assert_eq!(input.get("roi"), None);
}

#[test]
fn the_surface_is_described_as_the_file_holds_it() {
    let (folder, report) = report("");
    let surface = &report["surfaces"][0];
    let counts = folder.mesh("a.glb").surfaces[0].mesh.counts();
    assert_eq!((&surface["name"], &surface["iso"]), (&json!("ball"), &json!(50.0)));
    assert_eq!(surface["vertices"], counts.vertices);
    assert_eq!(surface["triangles"], counts.triangles);
    assert_eq!((&surface["components"], &surface["euler"]), (&json!(1), &json!(2)));
    assert_eq!(surface["boundary_edges"], 0);
    let check = folder.run("check a.glb --json").json();
    assert_eq!((&check["schema"], &check["ok"]), (&json!("isokit.check/1"), &json!(true)));
    for key in ["vertices", "triangles", "components", "euler", "boundary_edges"] {
        assert_eq!(check[key], surface[key], "{key}");
    }
}

#[test]
fn a_part_is_told_as_one() {
    let (_, report) = report("--roi 2:14,:,3:");
    assert_eq!(report["input"]["roi"], json!([[2, 14], [0, 14], [3, 12]]));
    assert_eq!(report["input"]["dims"], json!([16, 14, 12]));
}

#[test]
fn repeats_are_reported_with_their_median() {
    for option in ["--repeat 3", "--repeat-warm 3"] {
        let (_, report) = report(option);
        let all: Vec<f64> =
            serde_json::from_value(report["timings_s"]["extract_all"].clone()).unwrap();
        assert_eq!(all.len(), 3, "{option}");
        let mut sorted = all;
        sorted.sort_by(f64::total_cmp);
        let extract = report["timings_s"]["extract"].as_f64().unwrap();
        assert!((extract / sorted[1] - 1.0).abs() < 1e-9, "{option}");
    }
    assert_eq!(report("").1["timings_s"].get("extract_all"), None);
}

#[test]
fn a_report_may_go_to_stdout() {
    let folder = Folder::with_ball();
    let ran = folder.done("extract ball.nii --iso 1000 -o a.glb --report -");
    assert_eq!(ran.json()["surfaces"][0]["triangles"], 0);
    assert_eq!(ran.json()["surfaces"][0]["bounds"], Value::Null);
    let ran = folder.run("extract ball.nii --iso 50 -o - --report -");
    assert_eq!(ran.exit, Exit::Usage);
}
