//! `render` of a part of a volume, and of what a scene needs of it.

use crate::{
    kit::{Folder, ball},
    render::pixels,
};
use isokit::geom::Space;
use isokit_cli::Exit;
use std::fs;

/// Half of a ball, from a place; nothing is chosen by samples.
const SCENE: &str = r##"
[volume]
path = "ball.nii"
[[surface]]
name = "wall"
iso = 50
color = "#ff0000"
[[clip]]
plane = [0, 0, 1, 36]
cap = "slice"
[transfer]
points = [[0, "#00000000"], [100, "#ffe0c0ff"]]
[camera]
from = [18, 80, 50]
[output]
size = [40, 40]
"##;

#[test]
fn a_part_is_looked_at_as_if_there_were_no_more() {
    let folder = Folder::with_ball();
    // What lies beyond is another thing, and of other values.
    let far = |ijk: [usize; 3]| if (3..7).contains(&ijk[2]) { ball(ijk) } else { 1e6 };
    folder.volume("far.nii", Space::Ras, far);
    let same = |what: &str| {
        for mode in ["--iso 50", "--iso 50 --mode iso-raycast", "", "--mode splat"] {
            for (volume, picture) in [("ball.nii", "a.png"), ("far.nii", "b.png")] {
                folder.done(&format!("render {volume} {mode} {what} --size 30x30 -o {picture}"));
            }
            let [a, b] = ["a.png", "b.png"].map(|name| fs::read(folder.path(name)).unwrap());
            assert!(a == b, "{mode} {what}");
        }
    };
    // Samples from 3 to 6 along z lie from 34.5 to 39 mm.
    same("--roi :,:,3:7");
    same("--roi-mm :,:,34.5:39");
    folder.done("render ball.nii --iso 50 --roi :,:,3:7 --size 30x30 -o roi.png");
    folder.done("render ball.nii --iso 50 --roi-mm :,:,34.5:39 --size 30x30 -o mm.png");
    folder.done("render ball.nii --iso 50 --size 30x30 -o all.png");
    let [roi, mm, all] =
        ["roi.png", "mm.png", "all.png"].map(|name| fs::read(folder.path(name)).unwrap());
    assert!(roi == mm && roi != all);
}

#[test]
fn a_scene_names_its_part_and_an_extraction_writes_it() {
    let folder = Folder::with_ball();
    let roi = |line: &str| SCENE.replace("[[surface]]", &format!("{line}\n[[surface]]"));
    fs::write(folder.path("roi.toml"), roi("roi = \"8:,:,:\"")).unwrap();
    fs::write(folder.path("all.toml"), SCENE).unwrap();
    folder.done("render roi.toml -o a.png");
    folder.done("render all.toml --roi 8:,:,: -o b.png");
    folder.done("render roi.toml --roi :,:,: -o whole.png");
    folder.done("render all.toml -o all.png");
    let read = |name: &str| fs::read(folder.path(name)).unwrap();
    assert!(read("a.png") == read("b.png") && read("whole.png") == read("all.png"));
    assert!(read("a.png") != read("all.png"));
    assert!(pixels(&folder, "a.png").1.iter().any(|pixel| *pixel != [255; 3]));
    folder.done("extract ball.nii --iso 50 --roi 1:9,:,3: -o a.stl --dump-scene d.toml");
    let text = fs::read_to_string(folder.path("d.toml")).unwrap();
    assert!(text.contains("roi = \"1:9,:,3:\""), "{text}");
    folder.done("extract ball.nii --iso 50 --roi-mm :,30:35.5,: -o a.stl --dump-scene d.toml");
    let text = fs::read_to_string(folder.path("d.toml")).unwrap();
    assert!(text.contains("roi_mm = \":,30.0:35.5,:\""), "{text}");
    folder.done("render d.toml --plan");
    fs::write(folder.path("both.toml"), roi("roi = \":,:,2:\"\nroi_mm = \":,:,2:\"")).unwrap();
    for (line, says) in [
        ("render both.toml --plan", "either roi or roi_mm"),
        ("render a.stl --roi :,:,: -o a.png", "--roi is of the samples of a volume"),
        ("render all.toml --roi :,:,12:13 --plan", "which has 12"),
    ] {
        let ran = folder.run(line);
        assert!(ran.exit != Exit::Done && ran.err.contains(says), "{line}: {}", ran.err);
    }
}

#[test]
fn only_samples_that_a_picture_depends_on_are_read() {
    let folder = Folder::new();
    // Beyond the plane there are no numbers, of which a report would tell.
    folder.volume("ball.nii", Space::Ras, |ijk| if ijk[2] > 9 { f32::NAN } else { ball(ijk) });
    fs::write(folder.path("s.toml"), SCENE).unwrap();
    for mode in ["surfaces", "iso-raycast", "raycast", "splat"] {
        folder.done(&format!("render s.toml --mode {mode} -o a.png --report r.json"));
        let report = folder.json("r.json");
        let samples = &report["samples"];
        // The plane is at sample 4, and around it are 4.
        assert_eq!(samples["ranges"][2], serde_json::json!([0, 9]), "{mode}: {samples}");
        assert_eq!((&samples["all"], &samples["read"]), (&2688.into(), &2016.into()));
        assert_eq!(report["input"]["nan"], 0);
        assert_eq!(report["input"]["read"][2], serde_json::json!([0, 9]));
        let all = folder.done(&format!("render s.toml --mode {mode} -o b.png --plot p.png -v"));
        assert!(all.err.contains("reads all 2 688 samples: the chart counts"), "{}", all.err);
        assert!(pixels(&folder, "a.png") == pixels(&folder, "b.png"), "{mode}");
    }
}

#[test]
fn a_plan_needs_no_samples_where_the_header_says_enough() {
    let folder = Folder::with_ball();
    fs::write(folder.path("s.toml"), SCENE).unwrap();
    // The header and no sample, in a file of the size that it announces.
    let bytes = fs::read(folder.path("ball.nii")).unwrap();
    let mut hollow = bytes.clone();
    hollow[352..].fill(0xff);
    fs::write(folder.path("ball.nii"), hollow).unwrap();
    for mode in ["surfaces", "iso-raycast", "raycast", "splat"] {
        let ran = folder.done(&format!("render s.toml --mode {mode} --plan"));
        for says in [
            "reads 2 016 of 2 688 samples, 0:16,0:14,0:9: planes cut the others away",
            "which bricks hold something is not known before samples are read",
        ] {
            assert!(ran.text().contains(says), "{says}: {}", ran.text());
        }
        folder.done(&format!("render s.toml --mode {mode} --plan --report r.json"));
        assert_eq!(folder.json("r.json")["input"]["range"], serde_json::Value::Null);
    }
    // With an index it is.
    fs::write(folder.path("ball.nii"), bytes).unwrap();
    folder.done("extract ball.nii --iso 50 --index -o a.stl");
    let ran = folder.done("render s.toml --plan");
    assert!(ran.text().contains("of 4 bricks hold no surface that can be seen"), "{}", ran.text());
    // What is chosen by samples needs all of them.
    for (what, says) in [
        ("--iso auto", "reads all 2 688 samples: an isovalue is chosen"),
        ("--mode raycast --preset mr", "reads all 2 688 samples: what values look like is chosen"),
    ] {
        let ran = folder.done(&format!("render s.toml {what} --plan"));
        assert!(ran.text().contains(says), "{what}: {}", ran.text());
        assert!(ran.text().contains("bricks hold no"), "{}", ran.text());
    }
}

#[test]
fn a_way_around_from_a_place_begins_there_and_keeps_its_distance() {
    let folder = Folder::with_ball();
    let from = |place: &str| {
        SCENE.replace("[18, 80, 50]", place).replace("[0, 0, 1, 36]", "[0, 0, 1, 99]")
    };
    let scene = |name: &str, place: &str| fs::write(folder.path(name), from(place)).unwrap();
    // The middle is at (17.5, 33, 38.25).
    scene("a.toml", "[17.5, 83, 50]");
    scene("b.toml", "[-32.5, 33, 50]");
    folder.done("render a.toml --frames 4 -o turn.png");
    for (line, frame) in [("a.toml", 1), ("b.toml", 2), ("a.toml --orbit 180", 3)] {
        folder.done(&format!("render {line} -o one.png"));
        let [(_, one), (_, turn)] =
            ["one.png", &format!("turn_00{frame}.png")].map(|name| pixels(&folder, name));
        let differ = one.iter().zip(&turn).filter(|(a, b)| a != b).count();
        assert!(differ <= one.len() / 200, "{line}: {differ} pixels");
        assert!(one.iter().any(|pixel| pixel != &[255; 3]), "{line}");
    }
}

#[test]
fn planes_that_are_typed_cut_volumes_values_and_meshes() {
    let folder = Folder::with_ball();
    let camera = "--view left --size 40x40";
    folder.done("extract ball.nii --iso 50 -o a.stl");
    // Keeps what is below the middle, 38.25.
    for (input, plane) in [
        ("ball.nii --iso 50:#ff0000", "0,0,1,38.25"),
        ("ball.nii --preset auto", "0,0,1,38.25"),
        ("ball.nii --preset auto --mode splat", "0,0,1,38.25"),
    ] {
        folder.done(&format!("render {input} {camera} -o whole.png"));
        folder.done(&format!("render {input} {camera} --clip {plane} -o half.png"));
        let [whole, half] = ["whole.png", "half.png"]
            .map(|name| pixels(&folder, name).1.iter().filter(|pixel| **pixel != [255; 3]).count());
        assert!(half > 0 && half != whole, "{input}: {half} of {whole}");
    }
    fs::write(
        folder.path("s.toml"),
        SCENE.replace("[0, 0, 1, 36]", "[0, 0, 1, 38.25]").replace("\"slice\"", "\"solid\""),
    )
    .unwrap();
    let bare = SCENE.replace("[[clip]]\nplane = [0, 0, 1, 36]\ncap = \"slice\"\n", "");
    fs::write(folder.path("bare.toml"), bare).unwrap();
    folder.done("render s.toml -o a.png");
    folder.done("render bare.toml --clip 0,0,1,38.25 -o b.png");
    let read = |name: &str| fs::read(folder.path(name)).unwrap();
    assert!(read("a.png") == read("b.png"));
    // Of a mesh one looks inside, and it is framed by what is left of it.
    for (plane, name) in [("0,0,1,99", "whole"), ("0,0,1,38.25", "half"), ("0,0,1,0", "none")] {
        folder.done(&format!("render a.stl {camera} --clip {plane} -o {name}.png"));
    }
    folder.done(&format!("render a.stl {camera} -o plain.png"));
    let is_seen = |name: &str| pixels(&folder, name).1.iter().any(|pixel| *pixel != [255; 3]);
    assert!(read("whole.png") == read("plain.png") && read("half.png") != read("whole.png"));
    assert!(is_seen("half.png") && !is_seen("none.png"));
}
