//! `render`: what becomes of scenes, volumes and meshes.

use crate::kit::Folder;
use isokit_cli::Exit;
use std::{fs, io::Cursor};

/// Pixels of a picture of 8 bits: width, and the parts of each.
pub(crate) fn pixels(folder: &Folder, name: &str) -> (usize, Vec<Vec<u8>>) {
    decoded(fs::read(folder.path(name)).unwrap())
}

fn decoded(bytes: Vec<u8>) -> (usize, Vec<Vec<u8>>) {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut all = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut all).unwrap();
    let parts = info.color_type.samples();
    (info.width as usize, all.chunks(parts).map(<[u8]>::to_vec).collect())
}

/// The pixel in the middle of a square picture.
pub(crate) fn middle(folder: &Folder, name: &str) -> Vec<u8> {
    let (width, pixels) = pixels(folder, name);
    pixels[width / 2 * width + width / 2].clone()
}

const SCENE: &str = r##"
[volume]
path = "ball.nii"
[[surface]]
name = "wall"
iso = 50
color = "#ff0000"
[[surface]]
name = "core"
iso = 70
color = "#0000ff"
[[clip]]
plane = [0, 1, 0, 33]
surfaces = ["wall"]
[light]
shading = "none"
[output]
size = [65, 65]
"##;

#[test]
fn a_volume_becomes_a_picture_of_a_surface_or_of_its_values() {
    let folder = Folder::with_ball();
    let ran = folder.done("render ball.nii --iso 50:ball:#00ff00 --size 65x65 -o a.png");
    assert!(ran.err.contains("a.png\n"), "{}", ran.err);
    let [r, g, b] = middle(&folder, "a.png")[..] else { panic!("three parts") };
    assert!(g > 200 && r < 120 && b < 120, "{r}, {g}, {b}");
    let (_, all) = pixels(&folder, "a.png");
    assert_eq!(all[0], [255; 3]);
    folder.done("render ball.nii --size 65x65 --background #000000 -o b.png");
    let (_, all) = pixels(&folder, "b.png");
    assert_eq!(all[0], [0; 3]);
    assert!(middle(&folder, "b.png")[0] > 20);
}

#[test]
fn a_scene_says_what_is_seen_and_options_come_before_it() {
    let folder = Folder::with_ball();
    fs::write(folder.path("s.toml"), SCENE).unwrap();
    // The front of the wall is cut away: the camera looks along -y.
    folder.done("render s.toml -o a.png");
    assert_eq!(middle(&folder, "a.png"), [0, 0, 255]);
    folder.done("render s.toml --view posterior -o b.png");
    assert_eq!(middle(&folder, "b.png"), [255, 0, 0]);
    folder.done("render s.toml --size 33x33 --background transparent -o c.png");
    let (width, all) = pixels(&folder, "c.png");
    assert_eq!(
        (width, all[0].clone(), all[16 * 33 + 16].clone()),
        (33, vec![0; 4], vec![0, 0, 255, 255])
    );
}

#[test]
fn rays_find_the_surfaces_that_a_mesh_has() {
    let folder = Folder::with_ball();
    // From a side rays frame the volume, and meshes themselves.
    let camera = "[camera]\nfrom = [40, 80, 60]\nfov = 25\n";
    fs::write(folder.path("s.toml"), format!("{SCENE}{camera}")).unwrap();
    folder.done("render s.toml -o a.png");
    folder.done("render s.toml --mode iso-raycast -o b.png --report r.json");
    let [(_, mesh), (_, rays)] = ["a.png", "b.png"].map(|name| pixels(&folder, name));
    let differ = mesh.iter().zip(&rays).filter(|(a, b)| a != b).count();
    assert!(differ < mesh.len() / 20, "{differ} of {}", mesh.len());
    assert!(folder.json("r.json")["skipped"]["cells"].as_u64().unwrap() > 1000);
}

#[test]
fn a_mesh_is_seen_in_its_own_colours() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 50:ball:#00ff0080 -o a.glb");
    folder.done("render a.glb --size 65x65 --background transparent -o a.png");
    let [r, g, b, opacity] = middle(&folder, "a.png")[..] else { panic!("four parts") };
    assert!(g > 150 && r < 140 && b < 140, "{r}, {g}, {b}");
    // Through two walls: 1 - (1 - 128/255)^2.
    assert_eq!(opacity, 192);
}

#[test]
fn a_plan_is_told_and_nothing_is_written() {
    let folder = Folder::with_ball();
    fs::write(folder.path("s.toml"), SCENE.replace("\"#0000ff\"", "\"#0000ff00\"")).unwrap();
    let ran = folder.done("render s.toml --plan");
    for says in [
        "1 picture of 65 x 65, surfaces",
        "reads 2 304 of 2 688 samples, 0:16,0:12,0:12: planes cut the others away",
        "wall: extracted at 50, without normals",
        "core: not made: its opacity is 0",
    ] {
        assert!(ran.text().contains(says), "{says}: {}", ran.text());
    }
    let ran = folder.done("render s.toml --normals n.png --plan");
    assert!(ran.text().contains("wall: extracted at 50, with normals"), "{}", ran.text());
    let ran = folder.done("render s.toml --mode raycast --plan");
    assert!(ran.text().contains("bricks hold nothing that can be seen"), "{}", ran.text());
    let ran = folder.done("render ball.nii --iso 50:a --iso 70:a:#ff000000 --plan");
    assert_eq!(ran.text().matches("not made").count(), 1, "{}", ran.text());
    assert_eq!(folder.names(), ["ball.nii", "s.toml"]);
}

#[test]
fn the_report_says_what_was_not_computed() {
    let folder = Folder::with_ball();
    fs::write(folder.path("s.toml"), SCENE).unwrap();
    folder.done("render s.toml -o a.png --report r.json");
    let report = folder.json("r.json");
    assert_eq!(report["schema"], "isokit.render/1");
    assert_eq!(report["surfaces"][0]["name"], "wall");
    assert!(report["surfaces"][1]["triangles"].as_u64().unwrap() > 20);
    assert!(report["skipped"]["triangles_skipped"].as_u64().unwrap() > 50, "{report}");
    assert!(report["timings_s"]["render"].as_f64().unwrap() > 0.0);
    folder.done("render ball.nii --size 65x65 -o b.png --report r.json");
    let report = folder.json("r.json");
    assert_eq!(report["mode"], "raycast");
    assert!(report["skipped"]["steps"].as_u64().unwrap() > 1000, "{report}");
}

#[test]
fn a_small_picture_needs_fewer_samples() {
    let folder = Folder::with_ball();
    for (what, skipped) in
        [("--iso 20", "bricks_lost"), ("--iso 20 --mode iso-raycast", "cells"), ("", "steps")]
    {
        let line = format!("render ball.nii {what} --size 5x5 --report r.json -o");
        folder.done(&format!("{line} full.png"));
        let full = folder.json("r.json");
        assert_eq!(full["skipped"]["halvings"], serde_json::json!([0, 0, 0]));
        folder.done(&format!("{line} screen.png --lod screen"));
        let screen = folder.json("r.json");
        assert!(screen["skipped"]["halvings"][0].as_u64().unwrap() > 0, "{screen}");
        let of = |report: &serde_json::Value| report["skipped"][skipped].as_u64().unwrap();
        assert!(of(&screen) < of(&full) || skipped == "bricks_lost", "{screen}");
        let (full, screen) = (pixels(&folder, "full.png").1, pixels(&folder, "screen.png").1);
        let parts = full.iter().flatten().zip(screen.iter().flatten());
        let differ: u32 = parts.map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        assert!(differ < 16 * 3 * 25, "{what}: {differ}");
    }
    let ran = folder.done("render ball.nii --size 5x5 --lod screen --plan");
    assert!(ran.text().contains("looked at one sample of "), "{}", ran.text());
}

#[test]
fn a_way_around_is_a_picture_for_each_step_all_of_one_scale() {
    for what in ["--iso 50", "--preset auto", "--preset auto --mode splat"] {
        let folder = Folder::with_ball();
        let turn = |frames: &str| {
            folder.done(&format!("render ball.nii {what} --size 20x20 --frames {frames}"));
        };
        turn("3 -o turn.png");
        let names = ["ball.nii", "turn_001.png", "turn_002.png", "turn_003.png"];
        assert_eq!(folder.names(), names);
        // Steps of half the length come by the same places.
        turn("6 -o way.png");
        let read = |name| fs::read(folder.path(name)).unwrap();
        for (turn, way) in [("turn_001.png", "way_001.png"), ("turn_002.png", "way_003.png")] {
            assert_eq!(read(turn), read(way), "{what}");
        }
    }
}

#[test]
fn any_number_of_threads_writes_the_same_bytes() {
    let folder = Folder::with_ball();
    for scene in ["--iso 50:#ff000080 --iso 70", "--preset auto"] {
        let bytes = ["1", "2", "7"].map(|threads| {
            folder.done(&format!(
                "render ball.nii {scene} --size 70x50 --threads {threads} -o a.png"
            ));
            fs::read(folder.path("a.png")).unwrap()
        });
        assert!(bytes.iter().all(|other| *other == bytes[0]));
    }
}

#[test]
fn a_picture_goes_to_stdout_with_as_many_bits_as_asked_for() {
    let folder = Folder::with_ball();
    let ran = folder.done("render ball.nii --iso 50 --size 20x20 --bits 16 -o -");
    let reader = png::Decoder::new(Cursor::new(ran.out)).read_info().unwrap();
    assert_eq!(reader.info().bit_depth, png::BitDepth::Sixteen);
}

#[test]
fn words_that_do_not_fit_together_are_refused() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 50 -o a.stl");
    for (line, says) in [
        ("render ball.nii --iso 50 -o a.jpg", "a.jpg: expected a name that ends in .png"),
        ("render a.stl --iso 50 -o a.png", "a mesh has no values: leave out --iso"),
        ("render a.stl --mode raycast -o a.png", "a mesh has no values for rays"),
        ("render ball.nii --mode surfaces -o a.png", "no surface is named"),
        ("render ball.nii --frames 2 -o -", "several pictures do not fit into stdout"),
        ("render ball.nii -o - --report -", "picture and report cannot both go to stdout"),
        ("render ball.nii --size 0x3 -o a.png", "expected WIDTHxHEIGHT"),
        ("render ball.nii --frames 100001 -o a.png", "from 1 to 100000"),
        ("render ball.nii --frames 18446744073709551615 --plan", "from 1 to 100000"),
        ("render ball.nii --smoothing 4 -o a.png", "--smoothing is for surfaces"),
        ("render ball.nii --iso 50 --preset auto -o a.png", "--preset is for values"),
        ("render a.stl --spacing 2,2,2 -o a.png", "a mesh has no samples"),
        ("render a.stl --lod screen -o a.png", "--lod is for the samples of a volume"),
        ("render ball.nii --iso 50 --color #3060c0 -o a.png", "--color is of a mesh"),
        ("render a.stl --color green -o a.png", "expected #rrggbb or #rrggbbaa"),
        ("render ball.nii --sheet -o a.png", "--sheet is of isovalues"),
        ("render ball.nii --depth d.npy -o a.png", "--depth and --normals are of surfaces"),
        ("render ball.nii --iso 50 --normals n.npy -o a.png", "--normals: expected a name"),
        ("render a.stl --plot p.png", "a mesh has no values: leave out --plot"),
        ("render ball.nii --plot ball.nii", "--plot: expected a name"),
        ("render ball.nii --iso 50 --depth a.png -o a.png", "a.png"),
        ("render a.stl --preset auto -o a.png", "--preset is for values"),
    ] {
        let ran = folder.run(line);
        assert_eq!(ran.exit, Exit::Usage, "{line}");
        assert!(ran.err.contains(says), "{line}: {}", ran.err);
    }
    assert_eq!(folder.names(), ["a.stl", "ball.nii"]);
}

#[test]
fn scenes_that_make_no_sense_are_refused_with_their_place() {
    let folder = Folder::with_ball();
    let volume = "[volume]\npath = \"ball.nii\"\n";
    for (scene, exit, says) in [
        ("[volume\n", Exit::Failed, "line 1"),
        ("[volume]\npath = \"ball.nii\"\ncolour = 1\n", Exit::Failed, "unknown field `colour`"),
        ("[output]\nsize = [3, 3]\n", Exit::Usage, "the scene names no volume"),
        ("[volume]\npath = \"none.nii\"\n", Exit::Failed, "none.nii"),
        (
            &format!("{volume}[[clip]]\nplane = [0, 0, 0, 1]\n"),
            Exit::Usage,
            "a plane has a direction",
        ),
        (
            &format!("{volume}[output]\nsize = [0, 3]\n"),
            Exit::Usage,
            "expected two numbers above 0",
        ),
        (
            &format!("{volume}[camera]\nfrom = [1, 1, 1]\nview = \"left\"\n"),
            Exit::Usage,
            "found both",
        ),
        (&format!("{volume}[camera]\nup = [1, 1, 1]\n"), Exit::Usage, "add from"),
        (
            &format!("{volume}[camera]\nfrom = [9, 9, 9]\nprojection = \"parallel\"\n"),
            Exit::Usage,
            "needs a height",
        ),
        (
            &format!("{volume}[camera]\nprojection = \"parallel\"\nfov = 5.0\n"),
            Exit::Usage,
            "fov is for a perspective",
        ),
        (
            &format!(
                "{volume}[camera]\nfrom = [9, 9, 9]\nprojection = \"perspective\"\nheight = 5.0\n"
            ),
            Exit::Usage,
            "height is for a parallel projection",
        ),
        (
            &format!("{volume}[camera]\nfrom = [9, 9, 9]\nfov = 5.0\nheight = 5.0\n"),
            Exit::Usage,
            "leave out one",
        ),
        (&format!("{volume}[camera]\norbit = nan\n"), Exit::Usage, "a finite number"),
        (
            &format!("{volume}[transfer]\npreset = \"auto\"\npoints = [[1, \"#ffffff\"]]\n"),
            Exit::Usage,
            "found several",
        ),
        (&format!("{volume}[[surface]]\niso = 50\nopacity = 1.5\n"), Exit::Usage, "from 0 to 1"),
        (&format!("{volume}[light]\nambient = 2.0\n"), Exit::Usage, "from 0 to 1"),
        (
            &format!("{volume}[transfer]\npoints = [[1, \"#ffffff\"], [0, \"#ffffff\"]]\n"),
            Exit::Usage,
            "after 1",
        ),
        (&format!("{volume}[sampling]\nstep = 0.0\n"), Exit::Failed, "the step is 0"),
        (
            &format!("{volume}[light]\nshading = \"mixture\"\n"),
            Exit::Usage,
            "a mixture is of one material at least",
        ),
        (&format!("{volume}[light]\nsurface = 0.5\n"), Exit::Usage, "shading = \"mixture\""),
        (
            &format!("{volume}[[material]]\nvalues = [1, 2]\ncolor = \"#ffffff\"\n"),
            Exit::Usage,
            "materials are seen with",
        ),
        (
            &format!("{volume}[light]\nshading = \"mixture\"\n[transfer]\ngradient = true\n"),
            Exit::Usage,
            "looks like its materials",
        ),
        (&format!("{volume}[transfer]\ngradient = -1.0\n"), Exit::Usage, "a slope above 0"),
        (&format!("{volume}[transfer]\nrows = []\n"), Exit::Usage, "a row at least"),
        (
            &format!(
                "{volume}[transfer]\npeaks = [{{ value = 40, width = 30, color = \"#ffffff80\" }}, \
                 {{ value = 50, width = 5, color = \"#ffffff80\" }}]\n"
            ),
            Exit::Usage,
            "peak 2",
        ),
        (&format!("{volume}[transfer]\npeaks = []\npoints = []\n"), Exit::Usage, "found several"),
        (&format!("{volume}[light]\nshadows = true\n"), Exit::Usage, "expected surfaces"),
        (&format!("{volume}[light]\nfrom = [1, 0, 0]\n"), Exit::Usage, "add scatter"),
        (&format!("{volume}[light]\nscatter = 1.0\n"), Exit::Usage, "add from"),
        (
            &format!("{volume}[light]\nscatter = 1.0\nfrom = [0, 0, 0]\n"),
            Exit::Usage,
            "a direction",
        ),
        (&format!("{volume}[sampling]\nerror = 2.0\n"), Exit::Usage, "from 0.0001 to 1"),
        (
            &format!("{volume}[sampling]\njitter = true\n[output]\nmode = \"splat\"\n"),
            Exit::Usage,
            "expected mode = \"raycast\"",
        ),
        (
            &format!("{volume}[[surface]]\niso = 50\n[light]\nshadows = true\n"),
            Exit::Usage,
            "add from",
        ),
        (
            &format!("{volume}[[surface]]\niso = 50\n[light]\nocclusion = 2.0\n"),
            Exit::Usage,
            "from 0 to 1",
        ),
        (
            &format!(
                "{volume}[[surface]]\niso = 50\ntexture = {{ pattern = \"wood\", size = 0, colors = [\"#000000\"] }}\n"
            ),
            Exit::Usage,
            "a texture has a size above 0",
        ),
        (
            &format!(
                "{volume}[[surface]]\niso = 50\n[[clip]]\nplane = [1, 0, 0, 1]\nsurfaces = [\"skin\"]\n"
            ),
            Exit::Failed,
            "no surface has that name",
        ),
        (
            &format!("{volume}[camera]\nfrom = [1, 1, 1]\nat = [1, 1, 1]\n"),
            Exit::Failed,
            "at the place that it looks at",
        ),
    ] {
        fs::write(folder.path("s.toml"), scene).unwrap();
        let ran = folder.run("render s.toml -o a.png");
        assert_eq!(ran.exit, exit, "{scene}: {}", ran.err);
        assert!(ran.err.contains(says), "{scene}: {}", ran.err);
        assert!(!folder.names().contains(&"a.png".to_owned()));
    }
    fs::write(folder.path("s.toml"), SCENE).unwrap();
    for (report, by) in [("ball.nii", "the input"), ("s.toml", "the scene")] {
        let ran = folder.run(&format!("render s.toml -o a.png --report {report}"));
        assert_eq!(ran.exit, Exit::Usage, "{}", ran.err);
        assert!(ran.err.contains(by), "{}", ran.err);
    }
    let ran = folder.run("render gone.toml -o a.png");
    assert!(ran.err.contains("gone.toml: cannot read the scene"), "{}", ran.err);
}
