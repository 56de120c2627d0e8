//! `extract` of shapes: the surface of the volume that `sample` makes, without the volume.

use crate::kit::Folder;
use isokit_cli::Exit;
use std::{f64::consts::PI, fs};

const PART: &str = "
unit = \"mm\"
[shape]
difference = [\"body\", \"hole\"]
[part.body]
union = [{ box = { size = [40, 30, 10], round = 1 } }, { torus = { radius = 16, tube = 4 } }]
blend = 1
[part.hole]
cylinder = { radius = 4, height = 30 }
";

#[test]
fn the_surface_of_a_shape_is_that_of_its_volume() {
    let folder = Folder::new();
    fs::write(folder.path("part.toml"), PART).unwrap();
    folder.done("sample part.toml --spacing 0.5 -o part.nrrd");
    for words in ["", "--placement linear", "--boundary open --normals matching --topology table"] {
        folder.done(&format!("extract part.nrrd --iso 0:part {words} -o volume.stl"));
        for threads in [1, 2, 7] {
            folder.done(&format!(
                "extract part.toml --spacing 0.5 --iso 0:part {words} --threads {threads} -o shape.stl"
            ));
            let [shape, volume] =
                ["shape.stl", "volume.stl"].map(|name| fs::read(folder.path(name)).unwrap());
            // Behind the header, which says the command.
            assert!(shape[80..] == volume[80..], "{words}, {threads} threads");
        }
    }
    let found = folder.topology("shape.stl");
    assert_eq!(found.genus(), Some(1), "{found:?}");
}

#[test]
fn creases_keep_edges_sharp() {
    let folder = Folder::new();
    let shape = "[shape]\ndifference = [{ box = { size = [40, 30, 12] } }, { cylinder = { radius = 8, height = 30 } }]\nrotate = { x = 20, z = 35 }\n";
    fs::write(folder.path("part.toml"), shape).unwrap();
    let volume = 12.0 * (40.0 * 30.0 - PI * 64.0);
    let area = 2.0 * (40.0 * 30.0 - PI * 64.0) + 12.0 * (140.0 + 2.0 * PI * 8.0);
    let errors = ["", "--creases 30", "--creases 30 --refine 1"].map(|words| {
        let line = format!("extract part.toml --spacing 0.5 {words} --report r.json -o a.ply");
        folder.done(&line);
        let found = folder.topology("a.ply");
        assert!(found.shortfalls().is_empty() && found.genus() == Some(1), "{words}: {found:?}");
        let creased = &folder.json("r.json")["surfaces"][0]["refined"]["creased_vertices"];
        assert_eq!(creased.as_u64().is_some_and(|n| n > 300), !words.is_empty(), "{creased}");
        let measure = found.measure;
        [(measure.volume / volume - 1.0).abs(), (measure.area / area - 1.0).abs()]
    });
    let [plain, creased, divided] = errors;
    // What is left of the volume are the chords of the hole, and a division leaves a quarter of those.
    for n in [0, 1] {
        assert!(creased[n] < 0.1 * plain[n] && creased[n] < 2e-4, "{errors:?}");
    }
    assert!(divided[0] < 0.3 * creased[0], "{errors:?}");
}

#[test]
fn shapes_are_refined_on_their_own_field() {
    let folder = Folder::new();
    fs::write(folder.path("ball.toml"), "[shape]\nsphere = { radius = 10 }\n").unwrap();
    let errors = ["", "--refine 1", "--max-error 0.005", "--balance"].map(|words| {
        folder.done(&format!("extract ball.toml --spacing 1 {words} -o a.ply"));
        let found = folder.topology("a.ply");
        assert!(found.shortfalls().is_empty(), "{words}: {found:?}");
        (found.measure.volume / (4.0 / 3.0 * PI * 1000.0) - 1.0).abs()
    });
    assert!(errors[1..].iter().all(|error| *error < 0.3 * errors[0]), "{errors:?}");
}

#[test]
fn only_shapes_have_creases() {
    let folder = Folder::with_ball();
    fs::write(folder.path("ball.toml"), "[shape]\nsphere = { radius = 10 }\n").unwrap();
    for (words, says) in [
        ("ball.nii --iso 20 --creases 30", "only a shape says where its faces meet"),
        ("ball.toml --spacing 1 --creases 0", "expected degrees above 0 and below 180"),
        ("ball.toml --spacing 1 --creases -5", "expected degrees above 0 and below 180"),
        ("ball.toml --spacing 1 --creases 30 --degenerate exact", "leave out either it or"),
    ] {
        let ran = folder.run(&format!("extract {words} -o a.ply"));
        assert!(ran.exit == Exit::Usage && ran.err.contains(says), "{words}: {}", ran.err);
    }
}

#[test]
fn a_report_says_how_much_was_skipped() {
    let folder = Folder::new();
    fs::write(folder.path("part.toml"), PART).unwrap();
    folder.done("extract part.toml --spacing 0.1 -o a.ply --report r.json");
    let report = folder.json("r.json");
    let number = |key: &str| report["skipped"][key].as_u64().unwrap();
    assert!(number("bricks_skipped") * 2 > number("bricks"));
    assert!(number("samples_read") <= 512 * (number("bricks") - number("bricks_skipped")));
    let surface = &report["surfaces"][0];
    assert_eq!((&surface["name"], &surface["iso"]), (&"shape".into(), &0.0.into()));
    assert_eq!(
        (&report["input"]["format"], &report["input"]["unit"]),
        (&"shape".into(), &"mm".into())
    );
    assert!(folder.done("check a.ply").exit == Exit::Done);
}

#[test]
fn a_shape_has_a_pattern_as_a_volume_has() {
    let folder = Folder::new();
    fs::write(folder.path("part.toml"), PART).unwrap();
    folder.done("sample part.toml --spacing 1 -o part.nrrd");
    folder.done("extract part.nrrd --iso 0 --texture wood:4 -o volume.ply");
    folder.done("extract part.toml --spacing 1 --texture wood:4 -o shape.ply");
    let [shape, volume] = ["shape.ply", "volume.ply"].map(|name| {
        let bytes = fs::read(folder.path(name)).unwrap();
        let end = b"end_header\n";
        let start = bytes.windows(end.len()).position(|at| at == end).unwrap();
        assert!(bytes[..start].windows(3).any(|at| at == b"red"));
        bytes[start..].to_vec()
    });
    assert!(shape == volume);
}

#[test]
fn what_needs_a_volume_is_refused() {
    let folder = Folder::new();
    for (words, says) in [
        ("none.nii -o a.ply", "--iso is missing"),
        ("none.toml -o a.ply", "a shape needs --spacing"),
        ("none.toml -o a.ply --spacing 1 --origin 1,2,3", "a shape needs --spacing"),
        ("none.toml -o a.ply --spacing 1 --iso auto", "expected a number"),
        ("none.toml -o a.ply --spacing 1 --roi 0:9,0:9,0:9", "--roi"),
        ("none.toml -o a.ply --spacing 1 --attribute a.nii", "--attribute"),
        ("none.toml -o a.ply --spacing 1 --max-memory 1GiB", "--max-memory"),
    ] {
        let ran = folder.run(&format!("extract {words}"));
        assert!(ran.exit == Exit::Usage && ran.err.contains(says), "{words}: {}", ran.err);
    }
    assert!(folder.names().is_empty());
}
