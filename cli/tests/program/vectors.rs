//! `--quantity`: what is read of files of vectors.

use crate::kit::Folder;
use isokit_cli::Exit;
use std::fs;

/// A vortex around z, of 9 × 9 × 5 vectors: it turns by 0.5 per unit of time inside of a radius of 3.
fn folder() -> Folder {
    let folder = Folder::new();
    let mut bytes = b"NRRD0004\ntype: float\nendian: little\nencoding: raw\ndimension: 4\n\
        sizes: 3 9 9 5\nkinds: vector domain domain domain\nsample units: mm/s\n\
        space: left-posterior-superior\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n\n"
        .to_vec();
    for n in 0..9 * 9 * 5 {
        let [x, y] = [n % 9, n / 9 % 9].map(|i| i as f32 - 4.0);
        let turn = if x * x + y * y < 9.0 { 0.5 } else { 0.0 };
        [-turn * y, turn * x, 0.0].iter().for_each(|c| bytes.extend(c.to_le_bytes()));
    }
    fs::write(folder.path("flow.nrrd"), bytes).unwrap();
    folder
}

#[test]
fn a_quantity_is_a_volume_for_every_command() {
    let folder = folder();
    folder.done("convert flow.nrrd --quantity q-criterion -o q.nrrd");
    let info = folder.done("info q.nrrd --json").json();
    assert_eq!((&info["dims"], &info["dtype"]), (&serde_json::json!([9, 9, 5]), &"f32".into()));
    assert_eq!((info["space"].as_str(), info["range"][1].as_f64()), (Some("LPS"), Some(0.25)));
    let info = folder.done("info flow.nrrd --quantity vorticity --json").json();
    assert!(info["range"][1].as_f64().unwrap() >= 1.0 && info["sample_unit"].is_null());
    let said = folder.done("info flow.nrrd --quantity speed");
    assert!(said.text().contains("values in mm/s, as the file says"), "{}", said.text());
    folder.done("extract flow.nrrd --quantity q-criterion --iso 0.2 -o vortex.ply");
    assert!(folder.topology("vortex.ply").shortfalls().is_empty());
}

#[test]
fn without_it_vectors_are_refused_with_its_name() {
    let folder = folder();
    for line in
        ["info flow.nrrd", "convert flow.nrrd -o a.nii", "extract flow.nrrd --iso 1 -o a.ply"]
    {
        let ran = folder.run(line);
        assert_eq!(ran.exit, Exit::Failed);
        let says = "3 numbers per sample (axis 0, vector): --quantity says what is read of vectors";
        assert!(ran.err.contains(says), "{}", ran.err);
    }
    folder.done("convert flow.nrrd --quantity y -o y.nrrd");
    let ran = folder.run("info y.nrrd --quantity speed");
    assert!(ran.err.contains("three numbers per sample, found one"), "{}", ran.err);
}

#[test]
fn a_scene_names_a_quantity_and_an_extraction_of_one_says_it() {
    let folder = folder();
    folder.done("extract flow.nrrd --quantity speed --iso 0.5 -o a.ply --dump-scene s.toml");
    let scene = fs::read_to_string(folder.path("s.toml")).unwrap();
    assert!(scene.contains("quantity = \"speed\""), "{scene}");
    let range = |line: &str| {
        folder.done(&format!("render {line} --size 33x33 -o a.png --report r.json"));
        let range = folder.json("r.json")["input"]["range"].clone();
        (range, fs::read(folder.path("a.png")).unwrap())
    };
    let (speeds, picture) = range("s.toml");
    assert_eq!(speeds, range("flow.nrrd --quantity speed --iso 0.5").0);
    // What was typed comes before what the file says.
    let (turns, other) = range("s.toml --quantity vorticity");
    assert!(turns != speeds && other != picture, "{turns}");
    let without = scene.replace("quantity = \"speed\"\n", "");
    fs::write(folder.path("s.toml"), without).unwrap();
    let ran = folder.run("render s.toml -o a.png");
    assert!(ran.exit == Exit::Failed && ran.err.contains("--quantity says"), "{}", ran.err);
}

#[test]
fn a_mesh_has_no_quantity() {
    let folder = folder();
    folder.done("extract flow.nrrd --quantity speed --iso 0.5 -o a.stl");
    for (line, says) in [
        ("render a.stl --quantity speed -o a.png", "a mesh has no samples: leave out --quantity"),
        ("render a.stl --spacing 1,1,1 -o a.png", "a mesh has no samples"),
        ("convert a.stl --quantity speed -o b.ply", "--quantity are for volumes"),
    ] {
        let ran = folder.run(line);
        assert!(ran.exit == Exit::Usage && ran.err.contains(says), "{line}: {}", ran.err);
    }
    assert!(folder.run("info a.stl --quantity speed").err.contains("this is a mesh"));
    assert_eq!(folder.names(), ["a.stl", "flow.nrrd"]);
}
