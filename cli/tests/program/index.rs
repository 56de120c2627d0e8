//! `extract --index`: the same mesh, sooner.

use crate::kit::{DIMS, Folder, ball};
use isokit::geom::Space;
use isokit_cli::Exit;
use serde_json::Value;
use std::fs;

/// Extracts with an index: the mesh, what was skipped, and what was said.
#[track_caller]
fn indexed(folder: &Folder, iso: &str) -> (Vec<u8>, Value, String) {
    let line = format!("extract ball.nii --iso {iso} -o mesh.ply --index --report report.json");
    let ran = folder.run(&line);
    assert_eq!(ran.exit, Exit::Done, "{}", ran.err);
    let report = fs::read(folder.path("report.json")).unwrap();
    let report: Value = serde_json::from_slice(&report).unwrap();
    let mesh = fs::read(folder.path("mesh.ply")).unwrap();
    (mesh, report["skipped"].clone(), ran.err)
}

#[track_caller]
fn plain(folder: &Folder, iso: &str) -> Vec<u8> {
    folder.run(&format!("extract ball.nii --iso {iso} -o plain.ply"));
    fs::read(folder.path("plain.ply")).unwrap()
}

#[test]
fn an_index_is_made_once_and_changes_nothing() {
    let folder = Folder::with_ball();
    for (n, iso) in ["0.5", "0.5", "-2", "3"].iter().enumerate() {
        let (mesh, skipped, said) = indexed(&folder, iso);
        assert_eq!(mesh, plain(&folder, iso), "{iso}");
        assert_eq!(skipped["bricks"], 4);
        assert_eq!(said.contains("index kept in"), n == 0, "{said}");
    }
    assert!(folder.names().contains(&"ball.nii.bricks".to_owned()));
    let (_, skipped, _) = indexed(&folder, "1e6");
    assert_eq!((&skipped["bricks_skipped"], &skipped["samples_read"]), (&4.into(), &0.into()));
}

#[test]
fn several_values_share_an_index() {
    let folder = Folder::with_ball();
    let run = |more: &str| {
        let out = format!("extract ball.nii --iso 0.5 --iso 2 --iso -1 -o mesh.glb {more}");
        assert_eq!(folder.run(&out).exit, Exit::Done);
        fs::read(folder.path("mesh.glb")).unwrap()
    };
    assert_eq!(run("--index"), run(""));
}

#[test]
fn an_index_of_what_the_volume_was_before_is_made_again() {
    let folder = Folder::with_ball();
    indexed(&folder, "0.5");
    folder.volume("ball.nii", Space::Ras, |ijk| ball(ijk) + 2.0);
    let later = std::time::SystemTime::now() + std::time::Duration::from_secs(5);
    let file = fs::File::options().write(true).open(folder.path("ball.nii")).unwrap();
    file.set_modified(later).unwrap();
    let (mesh, _, said) = indexed(&folder, "0.5");
    assert!(said.contains("made again") && said.contains("has changed since"), "{said}");
    assert_eq!(mesh, plain(&folder, "0.5"));
}

#[test]
fn a_damaged_index_is_made_again() {
    let folder = Folder::with_ball();
    indexed(&folder, "0.5");
    let whole = fs::read(folder.path("ball.nii.bricks")).unwrap();
    let mut flipped = whole.clone();
    flipped[60] ^= 0x40;
    for broken in [&[][..], &whole[..20], &whole[..whole.len() - 1], &flipped, &[7; 5000]] {
        fs::write(folder.path("ball.nii.bricks"), broken).unwrap();
        let (mesh, _, said) = indexed(&folder, "0.5");
        assert!(said.contains("damaged"), "{said}");
        assert_eq!(mesh, plain(&folder, "0.5"));
        assert_eq!(fs::read(folder.path("ball.nii.bricks")).unwrap(), whole);
    }
}

#[test]
fn an_index_that_cannot_be_kept_is_a_warning() {
    let folder = Folder::with_ball();
    fs::create_dir(folder.path("ball.nii.bricks")).unwrap();
    let (mesh, skipped, said) = indexed(&folder, "0.5");
    assert!(said.contains("index not kept"), "{said}");
    assert_eq!(skipped["bricks"], 4);
    assert_eq!(mesh, plain(&folder, "0.5"));
}

#[test]
fn a_part_has_no_index() {
    let folder = Folder::with_ball();
    let ran = folder.run("extract ball.nii --iso 0.5 -o mesh.ply --index --roi :,:,:4");
    assert_eq!(ran.exit, Exit::Usage, "{}", ran.err);
}

#[test]
fn without_an_index_all_samples_are_read() {
    let folder = Folder::with_ball();
    folder.run("extract ball.nii --iso 0.5 -o mesh.ply --report report.json");
    let report: Value =
        serde_json::from_slice(&fs::read(folder.path("report.json")).unwrap()).unwrap();
    assert_eq!(report["skipped"]["samples_read"], DIMS.iter().product::<usize>());
    assert_eq!(report["skipped"]["bricks"], 0);
    assert!(!folder.names().iter().any(|name| name.ends_with(".bricks")));
}
