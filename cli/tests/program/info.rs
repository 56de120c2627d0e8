//! `info`: what a file holds.

use crate::kit::{Folder, ball};
use isokit::geom::Space;
use serde_json::{Value, json};

#[test]
fn a_volume_is_described_for_people() {
    let ran = Folder::with_ball().done("info ball.nii");
    let text = ran.text();
    for words in [
        "ball.nii: NIfTI volume\n",
        "16 x 14 x 12 of f32, 2 688 in all\n",
        "spacing   1 2 1.5\n",
        "unit      mm\n",
        "axes      RAS\n",
        "range     -",
        "NaN       0\n",
        "a first isovalue to try (Otsu's): ",
        "isokit extract ball.nii --iso ",
    ] {
        assert!(text.contains(words), "no {words:?} in {text}");
    }
    assert!(text.contains('█'), "a histogram: {text}");
}

#[test]
fn a_volume_is_described_for_scripts() {
    let folder = Folder::new();
    let hole = |ijk| if ijk == [0, 0, 0] { f32::NAN } else { ball(ijk) };
    folder.volume("hole.nrrd", Space::Lps, hole);
    let report = folder.done("info hole.nrrd --json").json();
    assert_eq!(report["schema"], "isokit.info/1");
    assert_eq!(report["kind"], "volume");
    assert_eq!(report["dims"], json!([16, 14, 12]));
    assert_eq!(report["space"], "LPS");
    assert_eq!(report["nan"], 1);
    assert!(report["suggested_iso"].is_f64());
}

#[test]
fn what_was_assumed_is_said() {
    let folder = Folder::new();
    folder.volume("ball.npy", Space::Unknown, ball);
    let text = folder.done("info ball.npy").text().to_owned();
    assert!(text.contains("unit      unknown\n"), "{text}");
    let text = folder.done("info ball.npy --spacing 2,2,2").text().to_owned();
    assert!(text.contains("spacing   2 2 2\n"), "{text}");
}

#[test]
fn samples_of_one_value_or_none_are_described_too() {
    let folder = Folder::new();
    folder.volume("flat.nrrd", Space::Ras, |_| 7.0);
    let text = folder.done("info flat.nrrd").text().to_owned();
    assert!(text.contains("range     7 to 7\n") && text.contains("no isovalue"), "{text}");
    folder.volume("nan.nrrd", Space::Ras, |_| f32::NAN);
    let text = folder.done("info nan.nrrd").text().to_owned();
    assert!(text.contains("range     none\n") && text.contains("NaN       2 688"), "{text}");
    assert_eq!(folder.done("info nan.nrrd --json").json()["range"], Value::Null);
}

#[test]
fn a_mesh_is_described_by_its_surfaces() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 50:core --iso 20:skin:#d8a58080 -o a.glb");
    let text = folder.done("info a.glb").text().to_owned();
    assert!(text.contains("a.glb: GLB mesh\n"), "{text}");
    assert!(text.contains("  core: ") && text.contains("with normals, #d8a58080"), "{text}");
    let report = folder.done("info a.glb --json").json();
    assert_eq!((&report["schema"], &report["kind"]), (&json!("isokit.info/1"), &json!("mesh")));
    assert_eq!(report["surfaces"].as_array().unwrap().len(), 2);
    assert!(report["bounds"].is_array());
}
