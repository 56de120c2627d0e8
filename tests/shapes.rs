//! The shapes of `fixtures/shapes`: each becomes a closed mesh, and looks as it was looked at.
//!
//! `UPDATE=1 cargo test -p isokit-tests --test pictures` makes the pictures again.

use super::assert_alike;
use isokit::{io::read_mesh, job::Job, mesh::topology};
use isokit_cli::{Exit, run};
use isokit_tests::workspace;
use std::{env, fs, path::Path};

/// Name, distance of samples, colour, and where one stands.
const SHAPES: [(&str, &str, &str, [i32; 3]); 5] = [
    ("bracket", "0.5", "#9aa4b0", [92, -100, 88]),
    ("gear", "0.4", "#c9a227", [30, -80, 100]),
    ("gyroid", "0.4", "#7fb3d5", [-50, -125, 62]),
    ("creature", "0.05", "#d98880", [14, -12, 5]),
    ("barth", "0.4", "#7dba84", [30, -80, 50]),
];

fn scene(color: &str, from: [i32; 3]) -> String {
    format!(
        r##"
        volume.path = "a.nrrd"
        surface = [{{ iso = 0, color = "{color}" }}]
        camera = {{ from = {from:?}, fov = 26 }}
        light.specular = 0.3
        output = {{ size = [256, 256], background = "#ffffff" }}
        "##
    )
}

#[track_caller]
fn done(words: &[&str]) {
    let (mut out, mut err) = (vec![], vec![]);
    let exit = run(["isokit"].iter().chain(words), &mut out, &mut err);
    assert_eq!(exit, Exit::Done, "{words:?}: {}", String::from_utf8_lossy(&err));
}

fn name(path: &Path) -> &str {
    path.to_str().expect("a name in letters")
}

#[test]
fn every_shape_becomes_a_closed_mesh_and_looks_as_it_was_looked_at() {
    let root = workspace::root().join("fixtures/shapes");
    let folder = env::temp_dir().join(format!("isokit-shapes-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let names = ["a.nrrd", "a.ply", "a.toml", "a.png"];
    let [volume, mesh, looks, made] = names.map(|file| folder.join(file));
    for (shape, spacing, color, from) in SHAPES {
        let (toml, kept) = (root.join(format!("{shape}.toml")), root.join(format!("{shape}.png")));
        done(&["sample", name(&toml), "--spacing", spacing, "-o", name(&volume)]);
        done(&["extract", name(&volume), "--iso", "0", "-o", name(&mesh)]);
        let job = Job::default();
        let surface = read_mesh(&mesh, &job).unwrap().surfaces.remove(0);
        let found = topology(&surface.mesh, &job).unwrap();
        assert!(found.shortfalls().is_empty() && found.triangles > 10_000, "{shape}: {found:?}");
        let picture = if env::var_os("UPDATE").is_some() { &kept } else { &made };
        fs::write(&looks, scene(color, from)).unwrap();
        done(&["render", name(&looks), "-o", name(picture)]);
        assert_alike(shape, picture, &kept);
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn every_shape_is_looked_at() {
    for entry in fs::read_dir(workspace::root().join("fixtures/shapes")).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap();
        assert!(SHAPES.iter().any(|(name, ..)| *name == stem), "{}", path.display());
    }
}
