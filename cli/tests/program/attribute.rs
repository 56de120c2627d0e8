//! `extract --attribute`, `--colormap` and `--texture`: what vertices carry, in every format.

use crate::kit::{Folder, SPACING};
use isokit::{geom::Space, mesh::Surface};
use isokit_cli::Exit;

/// With `ball.nii` and, at other samples of the same box, what is x.
fn folder() -> Folder {
    let folder = Folder::with_ball();
    folder.volume("x.nii", Space::Ras, |[i, ..]| 10.0 + i as f32);
    folder.done("resample x.nii --spacing 0.7 --kernel linear -o even.nrrd");
    folder
}

fn surface(folder: &Folder, name: &str) -> Surface {
    folder.mesh(name).surfaces.into_iter().next().unwrap()
}

/// x of each vertex and its value.
fn pairs(surface: &Surface) -> Vec<(f64, f64)> {
    let values = surface.mesh.attributes.values.as_ref().unwrap();
    let values = values.iter().map(|&value| f64::from(value));
    surface.mesh.positions.iter().map(|[x, ..]| x).zip(values).collect()
}

#[test]
fn values_are_those_of_the_place_in_any_space_and_format() {
    let folder = folder();
    for (name, words, sign) in [
        ("a.ply", "", 1.0),
        ("b.ply", "--space lps --refine 1 --balance", -1.0),
        ("c.glb", "--space ras", 1.0),
        ("d.ply", "--clip 0,0,1,38", 1.0),
    ] {
        folder.done(&format!("extract ball.nii --iso 50 --attribute even.nrrd {words} -o {name}"));
        let surface = surface(&folder, name);
        assert!(surface.mesh.attributes.colors.is_none());
        for (x, value) in pairs(&surface) {
            assert!((sign * x - value).abs() < 1e-3, "{name}: {x} {value}");
        }
    }
    folder.done("extract ball.nii --iso 50 --space index --attribute even.nrrd -o e.ply");
    for (i, value) in pairs(&surface(&folder, "e.ply")) {
        assert!((10.0 + SPACING[0] * i - value).abs() < 1e-3);
    }
}

#[test]
fn colours_go_from_the_least_value_of_all_surfaces_to_the_greatest_and_are_kept() {
    let folder = folder();
    let words = "--iso 50:#ff000080 --iso 20 --attribute x.nii --colormap gray";
    folder.done(&format!("extract ball.nii {words} -o a.glb --report r.json"));
    let report = &folder.json("r.json")["vertex_colors"];
    let (found, ends) = (&report["attribute"]["range"], &report["colormap"]["range"]);
    assert_eq!((found, report["colormap"]["name"].as_str()), (ends, Some("gray")));
    let [low, high] = [0, 1].map(|k| ends[k].as_f64().unwrap());
    folder.done("convert a.glb -o b.obj");
    let before = folder.mesh("a.glb").surfaces;
    for surface in &before {
        let alpha = if surface.name == "iso_50" { 0x80 } else { 0xff };
        let colors = surface.mesh.attributes.colors.as_ref().unwrap();
        for ((_, value), color) in pairs(surface).into_iter().zip(colors) {
            let [r, g, b, a] = color.0;
            let expected = ((value - low) / (high - low) * 255.0).round();
            assert!((f64::from(r) - expected).abs() <= 1.0 && r == g && g == b && a == alpha);
        }
    }
    // OBJ keeps colours, and says that it does not keep values.
    for (before, after) in before.iter().zip(folder.mesh("b.obj").surfaces) {
        let attributes = after.mesh.attributes;
        assert!(attributes.values.is_none());
        let pairs = attributes.colors.unwrap().into_iter();
        let colors = before.mesh.attributes.colors.as_ref().unwrap();
        assert!(pairs.zip(colors).all(|(found, color)| found.0[..3] == color.0[..3]));
    }
    let ran = folder.done("convert a.glb -o c.obj");
    assert!(ran.err.contains("OBJ holds no values of vertices"), "{}", ran.err);
}

#[test]
fn a_vertex_outside_has_no_value_and_the_colour_of_its_surface() {
    let folder = folder();
    // Half of the box.
    folder.volume_spaced("half.nii", [0.5, 2.0, 1.5], Space::Ras, |[i, ..]| i as f32);
    let words =
        "--iso 50:#123456 --attribute half.nii --attribute-kernel nearest --colormap magma:0:15";
    let ran = folder.done(&format!("extract ball.nii {words} -o a.ply"));
    assert!(ran.err.contains("are outside of it"), "{}", ran.err);
    let surface = surface(&folder, "a.ply");
    let colors = surface.mesh.attributes.colors.as_ref().unwrap();
    for ((x, value), color) in pairs(&surface).into_iter().zip(colors) {
        assert_eq!(value.is_nan(), x > 17.75, "{x}");
        assert_eq!(value.is_nan(), color.to_string() == "#123456");
        assert!(value.is_nan() || value == (2.0 * (x - 10.0) + 0.5).floor());
    }
    // glTF has no word for that.
    let ran = folder.done("convert a.ply -o b.glb");
    assert!(ran.err.contains("have no value, for which glTF has no word"), "{}", ran.err);
}

#[test]
fn a_pattern_colours_without_another_volume() {
    let folder = folder();
    folder.done("extract ball.nii --iso 50:#ffffff --texture checker:1 -o a.ply");
    let colors = surface(&folder, "a.ply").mesh.attributes.colors.unwrap();
    let mut found: Vec<String> = colors.iter().map(|color| color.to_string()).collect();
    found.sort();
    found.dedup();
    assert_eq!(found, ["#898989", "#ffffff"]);
}

#[test]
fn what_does_not_fit_is_refused_before_anything_is_read() {
    let folder = Folder::new();
    for (words, says) in [
        ("--attribute b.nii -o a.stl", "STL holds neither values nor colours"),
        ("--attribute b.nii --max-memory 1GiB -o a.ply", "need the whole mesh in memory"),
        ("--texture wood --max-memory 1GiB -o a.ply", "need the whole mesh in memory"),
        ("--attribute b.nii -o b.nii", "expected a name that ends in"),
        ("--colormap magma -o a.ply", "--attribute"),
        ("--attribute b.nii --colormap jet -o a.ply", "expected one of viridis"),
        ("--attribute b.nii --dump-scene s.toml -o a.ply", "no colours of vertices"),
        ("--quantity speed --max-memory 1GiB -o a.ply", "--quantity needs all vectors"),
        ("--quantity speed --index -o a.ply", "--index"),
        ("--quantity curl -o a.ply", "expected x, y, z, speed"),
    ] {
        let ran = folder.run(&format!("extract none.nii --iso 1 {words}"));
        assert!(ran.exit == Exit::Usage && ran.err.contains(says), "{words}: {}", ran.err);
    }
    assert!(folder.names().is_empty());
}
