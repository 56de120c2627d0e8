//! `extract`: what comes out, where and as what.

use crate::kit::{CENTRE, Folder, SPACING, assert_near, ball, middle};
use isokit::{
    geom::{Space, Unit},
    mesh::Topology,
};
use isokit_cli::Exit;
use std::fs;

/// Of a surface: closed, and everything else that `check` asks for.
#[track_caller]
fn assert_sound(topology: &Topology) {
    assert_eq!(topology.shortfalls(), [""; 0]);
    assert!(topology.triangles > 0);
}

#[test]
fn a_ball_is_where_it_was_and_as_large() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 50 -o ball.ply");
    let ball = folder.topology("ball.ply");
    assert_sound(&ball);
    assert_near(middle(&ball), CENTRE, 1e-4);
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 4_f64.powi(3);
    assert!((ball.measure.volume / volume - 1.0).abs() < 0.1, "{}", ball.measure.volume);
    let input = folder.mesh("ball.ply");
    assert_eq!((input.unit, input.space), (Unit::Millimetre, Space::Ras));
}

#[test]
fn every_format_holds_the_same_ball() {
    let folder = Folder::with_ball();
    let counts = ["ball.glb", "ball.gltf", "ball.obj", "ball.ply"].map(|name| {
        folder.done(&format!("extract ball.nii --iso 50 -o {name}"));
        folder.mesh(name).surfaces[0].mesh.counts()
    });
    assert!(counts.iter().all(|count| *count == counts[0]), "{counts:?}");
    folder.done("extract ball.nii --iso 50 -o ball.stl");
    assert_eq!(folder.mesh("ball.stl").surfaces[0].mesh.counts().triangles, counts[0].triangles);
}

#[test]
fn two_files_of_an_output_are_both_told() {
    let folder = Folder::with_ball();
    let ran = folder.done("extract ball.nii --iso 50 -o ball.gltf");
    assert!(ran.err.contains("ball.bin\n") && ran.err.contains("ball.gltf\n"), "{}", ran.err);
    assert_eq!(folder.names(), ["ball.bin", "ball.gltf", "ball.nii"]);
}

#[test]
fn several_isovalues_become_several_surfaces_with_names_and_colours() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 20:skin:#d8a58080 --iso 50 --iso -1e1:#010203 -o a.glb");
    let surfaces = folder.mesh("a.glb").surfaces;
    let names: Vec<&str> = surfaces.iter().map(|surface| surface.name.as_str()).collect();
    assert_eq!(names, ["skin", "iso_50", "iso_-10"]);
    let colors: Vec<String> =
        surfaces.iter().map(|surface| surface.color.unwrap().to_string()).collect();
    assert_eq!((&*colors[0], &*colors[2]), ("#d8a58080", "#010203"));
    assert!(colors[1].len() == 7 && colors[1] != colors[2], "{colors:?}");
}

#[test]
fn formats_of_one_surface_become_several_files() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 20:skin --iso 50 -o a.ply");
    assert_eq!(folder.names(), ["a_iso_50.ply", "a_skin.ply", "ball.nii"]);
}

#[test]
fn a_chosen_isovalue_is_told() {
    let folder = Folder::with_ball();
    let ran = folder.done("extract ball.nii --iso 50% -o a.ply");
    let told = ran.err.lines().find_map(|line| line.strip_prefix("note: --iso 50% is ")).unwrap();
    let iso: f64 = told.strip_suffix(" here").unwrap().parse().unwrap();
    assert!(ran.err.contains(&format!("iso_{iso}: ")), "{}", ran.err);
    let ran = folder.done("extract ball.nii --iso auto -o a.ply");
    assert!(ran.err.contains("note: --iso auto is "), "{}", ran.err);
}

#[test]
fn an_isovalue_beyond_the_range_gives_a_valid_file_and_a_warning() {
    let folder = Folder::with_ball();
    for name in ["a.glb", "a.gltf", "a.obj", "a.ply", "a.stl"] {
        let ran = folder.done(&format!("extract ball.nii --iso 1000 -o {name}"));
        let warning = "warning: isovalue 1000 is above every sample, they range from -";
        assert!(ran.err.contains(warning), "{}", ran.err);
        let surfaces = folder.mesh(name).surfaces;
        assert!(surfaces.iter().all(|surface| surface.mesh.triangles.is_empty()), "{name}");
        folder.done(&format!("check {name}"));
    }
}

#[test]
fn an_isovalue_below_the_range_gives_the_box_or_nothing() {
    let folder = Folder::with_ball();
    let ran = folder.done("extract ball.nii --iso -1000 -o box.ply");
    assert!(ran.err.contains("is not above the least sample, they range from -"), "{}", ran.err);
    assert!(ran.err.contains("the surface is the box of the volume"), "{}", ran.err);
    let of_box = folder.topology("box.ply");
    assert_sound(&of_box);
    assert_near(middle(&of_box), CENTRE, 1e-4);
    let ran = folder.done("extract ball.nii --iso -1000 --boundary open -o none.ply");
    assert!(ran.err.contains("the surface is empty"), "{}", ran.err);
    assert!(folder.mesh("none.ply").surfaces[0].mesh.triangles.is_empty());
}

#[test]
fn a_part_in_samples_or_in_the_world_leaves_the_rest_out() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 50 --roi :8,:,: -o samples.ply");
    folder.done("extract ball.nii --iso 50 --roi-mm :17,:,: -o world.ply");
    let [samples, world] = ["samples.ply", "world.ply"].map(|name| folder.topology(name));
    assert_sound(&samples);
    assert_eq!(samples, world);
    let bounds = samples.measure.bounds.unwrap();
    let end = 10.0 + 7.0 * SPACING[0];
    assert!(bounds.max[0] >= end && bounds.max[0] < end + 0.1 * SPACING[0], "{bounds:?}");
}

#[test]
fn the_world_may_be_turned_or_left() {
    let folder = Folder::with_ball();
    let centre = |space: &str| {
        folder.done(&format!("extract ball.nii --iso 50 --space {space} -o a.ply"));
        assert_sound(&folder.topology("a.ply"));
        (middle(&folder.topology("a.ply")), folder.mesh("a.ply").space)
    };
    let [x, y, z] = CENTRE;
    let turned = centre("lps");
    assert_near(turned.0, [-x, -y, z], 1e-4);
    assert_eq!(turned.1, Space::Lps);
    assert_eq!(centre("ras").1, Space::Ras);
    let index = centre("index");
    assert_near(index.0, [7.5, 6.5, 5.5], 1e-4);
    assert_eq!((index.1, folder.mesh("a.ply").unit), (Space::Unknown, Unit::Unknown));
}

#[test]
fn an_unknown_space_cannot_be_turned() {
    let folder = Folder::new();
    folder.volume("ball.npy", Space::Unknown, ball);
    let ran = folder.run("extract ball.npy --iso 50 --space ras -o a.ply");
    assert_eq!(ran.exit, Exit::Failed);
    assert!(ran.err.contains("cannot be turned to RAS"), "{}", ran.err);
    assert!(ran.err.contains("the caller's fault: leave --space out"), "{}", ran.err);
    assert_eq!(folder.names(), ["ball.npy"]);
}

#[test]
fn samples_without_a_header_are_read_as_described() {
    let folder = Folder::with_ball();
    folder.volume("ball.raw", Space::Unknown, ball);
    let bytes = fs::read(folder.path("ball.raw")).unwrap();
    let turned: Vec<u8> = bytes.chunks(4).flat_map(|sample| sample.iter().rev()).copied().collect();
    fs::write(folder.path("big.bin"), [&[7; 100], &turned[..]].concat()).unwrap();
    let place = "--spacing 1,2,1.5 --origin 10,20,30 --iso 50";
    folder.done(&format!("extract ball.raw --dims 16,14,12 --dtype f32 {place} -o a.ply"));
    folder.done(&format!(
        "extract big.bin --dims 16,14,12 --dtype f32be --skip 100 {place} -o b.ply"
    ));
    folder.done("extract ball.nii --iso 50 -o c.ply");
    let [a, b, c] = ["a.ply", "b.ply", "c.ply"].map(|name| folder.topology(name));
    assert_eq!(a, c);
    assert_eq!(b, c);
}

#[test]
fn normals_are_written_as_asked() {
    let folder = Folder::with_ball();
    for placement in ["linear", "cubic", "quintic"] {
        let meshes = ["gradient", "matching", "area", "none"].map(|kind| {
            let options = format!("--placement {placement} --normals {kind}");
            folder.done(&format!("extract ball.nii --iso 50 {options} -o a.ply"));
            folder.mesh("a.ply").surfaces[0].mesh.clone()
        });
        assert!(meshes.iter().all(|mesh| mesh.positions == meshes[0].positions), "{placement}");
        let [gradient, matching, area, none] = meshes.map(|mesh| mesh.normals);
        assert!(gradient.is_some() && area.is_some() && none.is_none());
        assert!(gradient != area && matching != area, "{placement}");
        assert_eq!(gradient == matching, placement == "linear", "{placement}");
    }
}

#[test]
fn a_sample_on_the_isovalue_gives_bad_triangles_only_where_exactness_was_asked_for() {
    let folder = Folder::new();
    folder.volume("dot.nii", Space::Ras, |ijk| if ijk == [5, 5, 5] { 1.0 } else { 0.0 });
    folder.done("extract dot.nii --iso 1 -o never.ply");
    assert_sound(&folder.topology("never.ply"));
    folder.done("extract dot.nii --iso 1 --degenerate exact -o exact.ply");
    assert_eq!(folder.topology("exact.ply").degenerate_triangles, 8);
}

/// Two far corners of a cell are joined by its middle, so says the trilinear field, and the table not.
#[test]
fn what_the_field_joins_is_joined_where_that_was_asked_for() {
    let folder = Folder::new();
    let far = |ijk: [usize; 3]| match ijk {
        [5, 5, 5] | [6, 6, 6] => 4.0,
        _ if ijk.iter().all(|c| (5..7).contains(c)) => -1.0,
        _ => -9.0,
    };
    folder.volume("far.nii", Space::Ras, far);
    for (topology, components) in [("table", 2), ("trilinear", 1)] {
        folder.done(&format!("extract far.nii --iso 0 --topology {topology} -o a.ply"));
        assert_sound(&folder.topology("a.ply"));
        assert_eq!(folder.topology("a.ply").components.len(), components, "{topology}");
    }
}

#[test]
fn a_reflecting_frame_keeps_the_outside_outside() {
    let folder = Folder::new();
    folder.volume_spaced("ball.nii", [-1.0, 2.0, 1.5], Space::Ras, ball);
    folder.done("extract ball.nii --iso 50 -o a.ply");
    let topology = folder.topology("a.ply");
    assert_sound(&topology);
    assert!(topology.measure.volume > 0.0);
}

#[test]
fn far_from_the_origin_formats_that_can_hold_every_digit_and_others_warn() {
    let folder = Folder::with_ball();
    let far = "--origin 6.4e6,6.4e6,6.4e6 --spacing 0.1,0.1,0.1 --iso 50 --report r.json";
    for name in ["a.ply", "a.obj"] {
        assert!(!folder.done(&format!("extract ball.nii {far} -o {name}")).err.contains("warning"));
        assert_sound(&folder.topology(name));
    }
    for name in ["a.glb", "a.stl"] {
        let ran = folder.done(&format!("extract ball.nii {far} -o {name}"));
        assert!(ran.err.contains("warning: ") && ran.err.contains("holds f32"), "{}", ran.err);
        assert!(folder.json("r.json")["merged_vertices"].as_u64().unwrap() > 0);
    }
}

#[test]
fn the_bytes_depend_neither_on_threads_nor_on_names() {
    let folder = Folder::with_ball();
    for ending in ["glb", "obj", "ply", "stl"] {
        let line = "extract ball.nii --iso 50";
        folder.done(&format!("{line} -o one.{ending} --threads 1"));
        folder.done(&format!("{line} -o two.{ending} --threads 3 --report r.json --repeat 2 -v"));
        let [one, two] = ["one", "two"].map(|name| folder.path(&format!("{name}.{ending}")));
        let [one, two] = [one, two].map(|path| fs::read(path).unwrap());
        // An OBJ names the file of its materials.
        assert!(one == two || ending == "obj" && one.len() == two.len(), "{ending}");
    }
}

#[test]
fn an_extraction_says_what_it_made_as_a_scene() {
    let folder = Folder::with_ball();
    let line = "extract ball.nii --iso 50:wall:#ff000080 --iso 70% -o a.glb";
    folder.done(&format!("{line} --clip 0,1,0,33 --dump-scene s.toml"));
    let scene = fs::read_to_string(folder.path("s.toml")).unwrap();
    for says in
        ["ball.nii\"", "name = \"wall\"\niso = 50.0\ncolor = \"#ff000080\"", "iso = 2", "[[clip]]"]
    {
        assert!(scene.contains(says), "{says}: {scene}");
    }
    let ran = folder.done("render s.toml --plan");
    assert!(ran.text().contains("wall: extracted at 50"), "{}", ran.text());
    folder.done("render s.toml --size 33x33 -o a.png");
    let line = "extract ball.nii --iso 50 -o a.glb";
    folder.done(&format!("{line} --spacing 1,2,3 --max-memory 512MiB --dump-scene t.toml"));
    folder.done("render t.toml --size 33x33 -o a.png --report r.json");
    assert_eq!(folder.json("r.json")["input"]["spacing"], serde_json::json!([1.0, 2.0, 3.0]));
    for (line, says) in [
        ("--dump-scene a.glb", ".toml"),
        ("--dump-scene s.toml --roi-mm :,:,:9 --space index", "--space"),
        ("--dump-scene s.toml --clip 1,0,0,3 --space index", "--space"),
    ] {
        let ran = folder.run(&format!("extract ball.nii --iso 50 -o a.glb {line}"));
        assert!(ran.exit == Exit::Usage && ran.err.contains(says), "{line}: {}", ran.err);
    }
}

#[test]
fn a_plane_cuts_the_surfaces_that_it_names() {
    let folder = Folder::with_ball();
    let made = |more: &str| {
        let line = "extract ball.nii --iso 50:wall --iso 70%:core -o a.glb --report a.json";
        folder.done(&format!("{line} {more}"));
        let report = folder.json("a.json");
        ["wall", "core"].map(|name| {
            let all = report["surfaces"].as_array().unwrap();
            all.iter().find(|surface| surface["name"] == name).unwrap().clone()
        })
    };
    let ([wall, core], [x, y, z]) = (made(""), CENTRE);
    let [cut, uncut] = made(&format!("--clip 1,0,0,{x}:wall"));
    let share = cut["volume"].as_f64().unwrap() / wall["volume"].as_f64().unwrap();
    assert!((0.4..0.5).contains(&share), "{share}");
    assert_eq!(uncut, core, "as if there were no plane");
    let [first, both] = made(&format!("--clip 1,0,0,{x}:wall --clip 0,1,0,{y}:core:wall"));
    assert!(first["volume"].as_f64() < cut["volume"].as_f64(), "{first}");
    assert!(both["volume"].as_f64() < core["volume"].as_f64(), "{both}");
    // A scene has them too, and pictures of both are the same.
    made(&format!("--clip 0,0,1,{z}:core --dump-scene cut.toml"));
    made("--dump-scene whole.toml");
    folder.done("render cut.toml --size 33x33 -o cut.png");
    folder.done(&format!("render whole.toml --clip 0,0,1,{z}:core --size 33x33 -o typed.png"));
    let [cut, typed] = ["cut.png", "typed.png"].map(|name| fs::read(folder.path(name)).unwrap());
    assert!(cut == typed);
}

#[test]
fn planes_cut_a_surface_and_close_it() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 50 --placement linear -o whole.ply --report whole.json");
    let [x, y, z] = CENTRE;
    for (name, line) in [
        ("half", format!("--clip 0,1,0,{y}")),
        ("eighth", format!("--clip 1,0,0,{x} --clip 0,-1,0,-{y} --clip 0,0,3,{}", 3.0 * z)),
    ] {
        folder
            .done(&format!("extract ball.nii --iso 50 {line} -o {name}.stl --report {name}.json"));
        folder.done(&format!("check {name}.stl"));
        let volume = |name: &str| {
            folder.json(&format!("{name}.json"))["surfaces"][0]["volume"].as_f64().unwrap()
        };
        let share = volume(name) / volume("whole");
        // The ball is but six samples wide: what its rims lose within a cell counts.
        let (expected, lost) = if name == "half" { (0.5, 0.1) } else { (0.125, 0.35) };
        assert!((1.0 - lost..=1.0).contains(&(share / expected)), "{name}: {share}");
    }
    for (line, says) in [
        ("--clip 0,0,0,1", "a plane has a direction"),
        ("--clip 0,0,1,1:skin", "expected the name of a surface, iso_50, found \"skin\""),
        ("--clip 1,2,3", "expected four numbers"),
        ("--clip 1,0,0,5 --refine 1", "cannot be used with"),
        ("--clip 1,0,0,5 --placement cubic", "cannot be used with"),
    ] {
        let ran = folder.run(&format!("extract ball.nii --iso 50 {line} -o a.stl"));
        assert!(ran.exit == Exit::Usage && ran.err.contains(says), "{line}: {}", ran.err);
    }
}
