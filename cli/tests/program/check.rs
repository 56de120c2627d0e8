//! `check`: sound or not, and why not.

use crate::kit::Folder;
use isokit_cli::Exit;

#[test]
fn a_closed_surface_is_sound_in_every_format() {
    let folder = Folder::with_ball();
    for name in ["a.glb", "a.gltf", "a.obj", "a.ply", "a.stl"] {
        folder.done(&format!("extract ball.nii --iso 50 -o {name}"));
        let ran = folder.done(&format!("check {name}"));
        assert!(ran.text().contains(&format!("{name}: sound\n")), "{}", ran.text());
        assert!(ran.text().contains("1 piece, Euler characteristic 2 (genus 0)"), "{}", ran.text());
    }
}

#[test]
fn an_open_surface_falls_short_with_status_3() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 50 --roi :8,:,: --boundary open -o a.ply");
    let ran = folder.run("check a.ply");
    assert_eq!((ran.exit, ran.exit.code()), (Exit::FallsShort, 3));
    assert!(ran.text().contains("a.ply: falls short\n"), "{}", ran.text());
    assert!(ran.text().contains("not closed"), "{}", ran.text());
    let ran = folder.run("check a.ply --json");
    assert_eq!(ran.exit, Exit::FallsShort);
    assert_eq!(ran.json()["ok"], false);
    assert!(ran.json()["boundary_edges"].as_u64().unwrap() > 0);
}

#[test]
fn surfaces_of_a_file_are_checked_apart_and_added_up() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 50:one --iso 20:two -o a.glb");
    let report = folder.done("check a.glb --json").json();
    let surfaces = report["surfaces"].as_array().unwrap();
    assert_eq!(surfaces.len(), 2);
    let triangles: u64 = surfaces.iter().map(|s| s["triangles"].as_u64().unwrap()).sum();
    assert_eq!(report["triangles"], triangles);
    assert_eq!(report["components"], 2);
}

#[test]
fn vertices_stored_apart_are_welded_on_request_and_hinted_at() {
    let folder = Folder::new();
    // A tetrahedron, each corner stored three times.
    let corners = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
    let sides = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let vertices: String =
        sides.as_flattened().iter().map(|&v| format!("v {}\n", corners[v])).collect();
    let faces = "f 1 2 3\nf 4 5 6\nf 7 8 9\nf 10 11 12\n";
    std::fs::write(folder.path("split.obj"), vertices + faces).unwrap();
    let ran = folder.run("check split.obj");
    assert_eq!(ran.exit, Exit::FallsShort);
    assert!(ran.text().contains("--weld 0 makes them one"), "{}", ran.text());
    let ran = folder.done("check split.obj --weld 0");
    assert!(ran.text().contains("4 vertices, 4 triangles, 1 piece"), "{}", ran.text());
}

#[test]
fn a_volume_is_no_mesh() {
    let folder = Folder::with_ball();
    folder.done("convert ball.nii -o ball.npy");
    folder.done("convert ball.nii -o ball.raw");
    for name in ["ball.nii", "ball.npy", "ball.raw"] {
        let ran = folder.run(&format!("check {name}"));
        assert_eq!(ran.exit, Exit::Failed);
        let says = ["this is a volume, and `check` is for meshes", "`isokit info` says what"];
        for words in says {
            assert!(ran.err.contains(words), "{}", ran.err);
        }
    }
}
