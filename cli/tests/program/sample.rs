//! `sample`: shapes become volumes, and those become meshes.

use crate::kit::{Folder, assert_near, middle};
use isokit_cli::Exit;
use std::fs;

const RING: &str = "
unit = \"mm\"
[shape]
torus = { radius = 5, tube = 2 }
move = [1, 2, 3]
";

#[test]
fn a_shape_becomes_a_volume_whose_surface_is_that_of_the_shape() {
    let folder = Folder::new();
    fs::write(folder.path("ring.toml"), RING).unwrap();
    let json = r#"{"shape": {"torus": {"radius": 5, "tube": 2}, "move": [1, 2, 3]}, "unit": "mm"}"#;
    fs::write(folder.path("ring.json"), json).unwrap();
    for dtype in ["f32", "f64"] {
        let ran =
            folder.done(&format!("sample ring.toml --spacing 0.4 --dtype {dtype} -o ring.nrrd"));
        assert!(ran.err.contains(&format!("39 x 39 x 14 of {dtype}")), "{}", ran.err);
        folder.done("sample ring.json --spacing 0.4,0.4,0.4 --threads 3 -o same.nrrd");
        folder.done(&format!(
            "sample ring.json --spacing 0.4 --threads 1 --dtype {dtype} -o same.nrrd"
        ));
        let [a, b] = ["ring.nrrd", "same.nrrd"].map(|name| fs::read(folder.path(name)).unwrap());
        assert!(a == b, "TOML and JSON, and all numbers of threads, make the same bytes");
        let info = folder.done("info ring.nrrd --json").json();
        assert_eq!((&info["unit"], &info["dtype"]), (&"mm".into(), &dtype.into()));
        folder.done("extract ring.nrrd --iso 0 -o ring.ply");
        let found = folder.topology("ring.ply");
        assert!(found.shortfalls().is_empty() && found.genus() == Some(1), "{found:?}");
        assert_near(middle(&found), [1.0, 2.0, 3.0], 1e-3);
        let expected = 2.0 * std::f64::consts::PI.powi(2) * 5.0 * 4.0;
        assert!((found.measure.volume / expected - 1.0).abs() < 0.02, "{}", found.measure.volume);
    }
}

#[test]
fn words_that_do_not_fit_are_refused_before_anything_is_read() {
    let folder = Folder::new();
    for (words, says) in [
        ("none.toml --spacing 1 -o a.ply", "expected a name that ends in one of"),
        ("none.toml --spacing 0 -o a.nii", "expected one distance above 0"),
        ("none.toml --spacing 1 --dtype u8 -o a.nii", "[possible values: f32, f64]"),
        ("none.nii --spacing 1 -o a.nii", "a shape is a .toml or a .json"),
        ("none.toml -o a.nii", "--spacing <X[,Y,Z]>"),
    ] {
        let ran = folder.run(&format!("sample {words}"));
        assert!(ran.exit == Exit::Usage && ran.err.contains(says), "{words}: {}", ran.err);
    }
    assert!(folder.names().is_empty());
}

#[test]
fn what_is_no_shape_is_said_with_its_place() {
    let folder = Folder::new();
    for (text, says) in [
        ("[shape]\nspher = { radius = 1 }", "line 2"),
        (
            "[shape]\nsphere = { radius = -1 }",
            "shape.sphere.radius: expected a finite number above 0",
        ),
        ("[shape]\ngyroid = { cell = 1 }", "it has no end along x"),
        ("[shape]\nformula = \"x + q\"", "column 5"),
        ("[shape]\nsphere = { radius = 1e15 }", "spacing: expected at most"),
        ("[shape]\nsphere = { radius = 1e6 }", "volume needs"),
    ] {
        fs::write(folder.path("a.toml"), text).unwrap();
        let ran = folder.run("sample a.toml --spacing 1 -o a.nii");
        assert!(ran.exit == Exit::Failed && ran.err.contains(says), "{text}: {}", ran.err);
        assert_eq!(folder.names(), ["a.toml"]);
    }
    let ran = folder.run("sample b.toml --spacing 1 -o a.nii");
    assert!(ran.exit == Exit::Failed && ran.err.contains("cannot read the shape"), "{}", ran.err);
}
