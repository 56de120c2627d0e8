//! The shapes of `fixtures/shapes`: each becomes a closed mesh, and looks as it was looked at.
//!
//! `UPDATE=1 cargo test -p isokit-tests --test pictures` makes the pictures again.

use super::assert_alike;
use isokit::{io::read_mesh, job::Job, mesh::topology};
use isokit_cli::{Exit, run};
use isokit_tests::workspace;
use std::{env, fs, path::Path};

/// Name, distance of samples, and colour.
const SHAPES: [(&str, &str, &str); 5] = [
    ("bracket", "0.5", "#9aa4b0"),
    ("gear", "0.4", "#c9a227"),
    ("gyroid", "0.4", "#7fb3d5"),
    ("creature", "0.05", "#d98880"),
    ("barth", "0.4", "#7dba84"),
];

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
    let [volume, mesh, made] = ["a.nrrd", "a.ply", "a.png"].map(|file| folder.join(file));
    for (shape, spacing, color) in SHAPES {
        let (toml, kept) = (root.join(format!("{shape}.toml")), root.join(format!("{shape}.png")));
        done(&["sample", name(&toml), "--spacing", spacing, "-o", name(&volume)]);
        done(&["extract", name(&volume), "--iso", "0", "-o", name(&mesh)]);
        let job = Job::default();
        let surface = read_mesh(&mesh, &job).unwrap().surfaces.remove(0);
        let found = topology(&surface.mesh, &job).unwrap();
        assert!(found.shortfalls().is_empty() && found.triangles > 10_000, "{shape}: {found:?}");
        let picture = if env::var_os("UPDATE").is_some() { &kept } else { &made };
        let iso = format!("0:{color}");
        let looks = ["--size", "256x256", "--view", "anterior", "--orbit", "35"];
        let words = ["render", name(&volume), "--iso", &iso, "-o", name(picture)];
        done(&[&words[..], &looks[..]].concat());
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
