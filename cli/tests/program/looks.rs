//! `render`: what values and surfaces look like, and what else of them is written.

use crate::{
    kit::Folder,
    render::{middle, pixels},
};
use isokit_cli::Exit;
use std::{fs, io::Cursor};

#[test]
fn values_are_seen_by_slopes_as_materials_and_by_splats() {
    let folder = Folder::with_ball();
    let volume = "[volume]\npath = \"ball.nii\"\n[output]\nsize = [65, 65]\n";
    let points = "[[40, \"#ff000000\"], [60, \"#ff0000ff\"]]";
    for (name, says) in [
        ("gradient", format!("[transfer]\npoints = {points}\ngradient = true\n")),
        ("slope", format!("[transfer]\npoints = {points}\ngradient = 2.5\n")),
        (
            "rows",
            format!(
                "[transfer]\nrows = [{{ gradient = 0, points = [[0, \"#00000000\"]] }}, \
                 {{ gradient = 1, points = {points} }}]\n"
            ),
        ),
        (
            "mixture",
            "[light]\nshading = \"mixture\"\nsurface = 0.9\n[[material]]\nvalues = [-9, 40]\n\
             color = \"#00000000\"\n[[material]]\nvalues = [60, 100]\ncolor = \"#ff000010\"\n"
                .to_owned(),
        ),
    ] {
        fs::write(folder.path("s.toml"), format!("{volume}{says}")).unwrap();
        for mode in ["raycast", "splat"] {
            let ran = folder.done(&format!("render s.toml --mode {mode} -o a.png"));
            assert_eq!(ran.err.contains("gradient is"), name == "gradient", "{}", ran.err);
            let [r, g, ..] = middle(&folder, "a.png")[..] else { panic!("three parts") };
            assert!(r > g + 60, "{name}, {mode}: {r}, {g}");
        }
    }
    let cloud = "[light]\nshading = \"none\"\nfrom = [0, 1, 1]\nscatter = 1.0\nahead = 0.3\n";
    let fine = "[sampling]\nkernel = \"catmull-rom\"\njitter = true\nerror = 0.01\n";
    fs::write(folder.path("s.toml"), format!("{volume}{cloud}{fine}")).unwrap();
    folder.done("render s.toml -o a.png --report r.json");
    assert!(folder.json("r.json")["skipped"]["pixels_refined"].as_u64().unwrap() > 1000);
    folder.done("render ball.nii --mode splat --size 33x33 -o b.png --report r.json");
    let report = folder.json("r.json");
    assert!(report["mode"] == "splat" && report["skipped"]["splats"].as_u64().unwrap() > 1000);
}

#[test]
fn surfaces_are_cut_from_textures_and_stand_in_light_and_shadow() {
    let folder = Folder::with_ball();
    let scene = "[volume]\npath = \"ball.nii\"\n[[surface]]\niso = 50\ncolor = \"#ffffff\"\n";
    let texture = "texture = { pattern = \"checker\", size = 7, colors = [\"#ff0000\"] }\n";
    let light = "[light]\nspecular = 0.0\nfrom = [1, 1, 1]\nshadows = true\nocclusion = 0.5\n";
    fs::write(folder.path("a.toml"), format!("{scene}{texture}[light]\nshading = \"none\"\n"))
        .unwrap();
    fs::write(folder.path("b.toml"), format!("{scene}{light}")).unwrap();
    for mode in ["surfaces", "iso-raycast"] {
        folder.done(&format!("render a.toml --mode {mode} --size 65x65 --smoothing 1 -o a.png"));
        let (_, all) = pixels(&folder, "a.png");
        let count = |color: [u8; 3]| all.iter().filter(|pixel| ***pixel == color).count();
        assert!(count([255, 0, 0]) > 40, "{mode}: {}", count([255, 0, 0]));
        folder.done(&format!(
            "render b.toml --mode {mode} --size 65x65 --background #000000 -o b.png"
        ));
        let (width, all) = pixels(&folder, "b.png");
        // Light comes from the front, which is y, from above, and from the right, which is x: left in the picture.
        let [bright, dark] = [28, 37].map(|c| all[c * width + c][0]);
        assert!(bright > dark + 15, "{mode}: {bright}, {dark}");
    }
}

#[test]
fn surfaces_have_depths_and_normals() {
    let folder = Folder::with_ball();
    let ran =
        folder.done("render ball.nii --iso 50 --size 33x33 -o a.png --depth d.png --normals n.png");
    assert!(ran.err.contains("depths are from "), "{}", ran.err);
    let parts = |name: &str| {
        let mut reader = png::Decoder::new(Cursor::new(fs::read(folder.path(name)).unwrap()));
        reader.set_transformations(png::Transformations::IDENTITY);
        let mut reader = reader.read_info().unwrap();
        let mut all = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut all).unwrap();
        let parts = all.chunks(2).map(|two| u16::from_be_bytes([two[0], two[1]]));
        parts
            .collect::<Vec<_>>()
            .chunks(info.color_type.samples())
            .map(<[u16]>::to_vec)
            .collect::<Vec<_>>()
    };
    let (depths, normals) = (parts("d.png"), parts("n.png"));
    let middle = 16 * 33 + 16;
    assert!(depths[middle][0] < 2000 && depths[middle][1] == u16::MAX && depths[0] == [0, 0]);
    assert!(normals[middle][2] > 64_000 && normals[0] == [0; 4]);
    folder.done("render ball.nii --iso 50 --mode iso-raycast --size 33x33 -o a.png --depth d.npy");
    let ran = folder.done("info d.npy --json");
    assert!(ran.text().contains("33"), "{}", ran.text());
}

#[test]
fn a_sheet_shows_each_isovalue_alone_and_a_plot_what_values_look_like() {
    let folder = Folder::with_ball();
    folder.done(
        "render ball.nii --iso 30:#ff0000 --iso 50:core:#0000ff --size 130x65 --sheet -o a.png",
    );
    let (width, all) = pixels(&folder, "a.png");
    let at = |x: usize| all[30 * width + x].clone();
    assert!(width == 130 && at(32)[0] > at(32)[2] + 80 && at(97)[2] > at(97)[0] + 80);
    for (line, count) in [("--preset auto --plot p.png", 3), ("--iso 50 --plot p.png -o b.png", 4)]
    {
        folder.done(&format!("render ball.nii {line}"));
        let (width, all) = pixels(&folder, "p.png");
        assert_eq!(width, 960);
        let dark = all.iter().filter(|pixel| pixel[0] < 0x40).count();
        assert!(dark > 2000 && folder.names().len() == count, "{dark}, {:?}", folder.names());
    }
}

#[test]
fn what_else_is_wanted_is_made_without_a_picture_too() {
    let folder = Folder::with_ball();
    let line = "render ball.nii --iso 50 --size 33x33 --depth d.npy --normals n.png";
    folder.done(&format!("{line} --plot p.png --report r.json"));
    assert_eq!(folder.names(), ["ball.nii", "d.npy", "n.png", "p.png", "r.json"]);
    let report = folder.json("r.json");
    assert_eq!(report["outputs"].as_array().unwrap().len(), 3);
    assert!(report["surfaces"][0]["triangles"].as_u64().unwrap() > 100);
    let ran = folder.done(&format!("{line} --plot p.png --plan"));
    for says in ["depths of surfaces, to ", "normals of surfaces, to ", "look like, to "] {
        assert!(ran.text().contains(says), "{says}: {}", ran.text());
    }
    let ran = folder.done("render ball.nii --mode splat --plan");
    assert!(!ran.text().contains("skipped"), "{}", ran.text());
    for (line, says) in [
        ("--depth d.foo -o a.png", "--depth: expected a name"),
        ("--plot p.png --sheet", "name it with -o"),
        ("--plot p.png --frames 4", "name it with -o"),
    ] {
        let ran = folder.run(&format!("render ball.nii --iso 50 {line}"));
        assert!(ran.exit == Exit::Usage && ran.err.contains(says), "{line}: {}", ran.err);
    }
}

#[test]
fn a_scene_describes_a_volume_as_the_command_line_does() {
    let folder = Folder::with_ball();
    folder.done("convert ball.nii -o ball.raw");
    let report = folder.done("info ball.nii --json");
    let report: serde_json::Value = serde_json::from_str(report.text()).unwrap();
    let dims = report["dims"].to_string();
    let scene = |says: &str| {
        let volume = format!("[volume]\npath = \"ball.raw\"\n{says}\n");
        fs::write(folder.path("s.toml"), format!("{volume}[[surface]]\niso = 50\n")).unwrap();
    };
    let dtype = report["dtype"].as_str().unwrap();
    scene(&format!("dims = {dims}\ndtype = \"{dtype}\"\nspacing = [1, 1, 3]"));
    folder.done("render s.toml --size 33x33 -o a.png --report r.json");
    assert_eq!(folder.json("r.json")["input"]["spacing"], serde_json::json!([1.0, 1.0, 3.0]));
    folder.done("render s.toml --spacing 1,1,2 --size 33x33 -o a.png --report r.json");
    assert_eq!(folder.json("r.json")["input"]["spacing"], serde_json::json!([1.0, 1.0, 2.0]));
    scene(&format!("dims = {dims}"));
    let ran = folder.run("render s.toml -o a.png");
    assert!(ran.exit == Exit::Usage && ran.err.contains("dims and dtype"), "{}", ran.err);
}

#[test]
fn what_would_have_no_effect_is_refused() {
    let folder = Folder::with_ball();
    for (says, refusal) in [
        ("[light]\nshading = \"none\"\ndiffuse = 0.5\n", "shading = \"none\""),
        ("[sampling]\nstep = 0.25\n", "step"),
        ("[transfer]\nunit = 2\n", "unit"),
        ("texture = { pattern = \"wood\", size = 7, colors = [\"#ff000080\"] }\n", "#rrggbb"),
        (
            "texture = { pattern = \"wood\", size = 7, colors = [\"#ff0000\", \"#00ff00\"] }\n",
            "one color",
        ),
        (
            "[light]\nfrom = [1, 0, 0]\nscatter = 1\nahead = 1\n[output]\nmode = \"raycast\"\n",
            "0.99",
        ),
        (
            "[transfer]\ngradient = true\n[sampling]\nintegrated = true\n[output]\nmode = \"raycast\"\n",
            "values alone",
        ),
        ("[sampling]\nintegrated = true\n[output]\nmode = \"splat\"\n", "integrated"),
        ("[sampling]\nkernel = \"catmull-rom\"\n[output]\nmode = \"splat\"\n", "kernel"),
    ] {
        let scene = "[volume]\npath = \"ball.nii\"\n[[surface]]\niso = 50\ncolor = \"#ffffff\"\n";
        fs::write(folder.path("s.toml"), format!("{scene}{says}")).unwrap();
        let ran = folder.run("render s.toml -o a.png");
        assert!(ran.exit == Exit::Usage && ran.err.contains(refusal), "{says}: {}", ran.err);
    }
}

#[test]
fn a_preset_that_was_typed_may_be_integrated_whatever_the_file_looked_like() {
    let folder = Folder::with_ball();
    let scene = "[volume]\npath = \"ball.nii\"\n[transfer]\nrows = [{ gradient = 0, points = [[0, \"#ffffff\"]] }]\n\
                 [sampling]\nintegrated = true\n[output]\nmode = \"raycast\"\n";
    fs::write(folder.path("s.toml"), scene).unwrap();
    let ran = folder.run("render s.toml --size 20x20 -o a.png");
    assert!(ran.exit == Exit::Usage && ran.err.contains("values alone"), "{}", ran.err);
    let ran = folder.run("render s.toml --preset auto --size 20x20 -o a.png");
    assert!(ran.exit == Exit::Done, "{}", ran.err);
}
