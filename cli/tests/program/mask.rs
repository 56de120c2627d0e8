//! `extract --mask`: what another volume keeps.

use crate::kit::{CENTRE, Folder, ball};
use isokit::geom::Space;
use isokit_cli::Exit;
use std::fs;

/// With `ball.nii` and, on the same lattice, `labels.nii`: 4 in the lower half along x, 7 in the upper one.
fn folder() -> Folder {
    let folder = Folder::with_ball();
    folder.volume("labels.nii", Space::Ras, |[i, ..]| if i < 8 { 4.0 } else { 7.0 });
    folder
}

/// The volume that the first surface encloses.
#[track_caller]
fn volume(folder: &Folder, line: &str) -> f64 {
    folder.done(&format!("extract ball.nii --iso 50 -o a.ply --report a.json {line}"));
    folder.done("check a.ply");
    folder.json("a.json")["surfaces"][0]["volume"].as_f64().unwrap()
}

#[test]
fn a_label_keeps_its_part_and_closes_it() {
    let folder = folder();
    let whole = volume(&folder, "--placement linear");
    for (values, expected) in [("4", 0.5), ("7,9", 0.5), ("4,7", 1.0)] {
        let share = volume(&folder, &format!("--mask labels.nii --mask-values {values}")) / whole;
        assert!((0.9..1.01).contains(&(share / expected)), "{values}: {share}");
    }
    assert_eq!(
        volume(&folder, "--mask labels.nii --mask-values 4,7"),
        volume(&folder, "--mask labels.nii")
    );
    // With a plane, a quarter; in any space, and with an index.
    let [_, y, _] = CENTRE;
    let plane = format!("--mask labels.nii --mask-values 7 --clip 0,1,0,{y}");
    let quarter = volume(&folder, &plane);
    assert!((0.8..1.0).contains(&(quarter / whole / 0.25)), "{quarter}");
    assert_eq!(volume(&folder, &format!("{plane} --index")), quarter);
    let turned = volume(&folder, "--mask labels.nii --mask-values 7 --space lps");
    let same = volume(&folder, "--mask labels.nii --mask-values 7");
    assert!((turned / same - 1.0).abs() < 1e-5, "{turned} {same}");
    let mesh = folder.topology("a.ply");
    assert!((mesh.measure.bounds.unwrap().min[0] - 17.5).abs() < 1e-5, "halfway between samples");
}

#[test]
fn a_mask_that_keeps_nothing_is_the_callers_mistake_and_one_elsewhere_leaves_nothing() {
    let folder = folder();
    let ran = folder.run("extract ball.nii --iso 50 --mask labels.nii --mask-values 5 -o a.stl");
    assert_eq!(ran.exit, Exit::Failed);
    for says in ["no sample has one of --mask-values: the samples range from 4 to 7", "name values"]
    {
        assert!(ran.err.contains(says), "{}", ran.err);
    }
    folder.volume("none.nii", Space::Ras, |_| 0.0);
    let ran = folder.run("extract ball.nii --iso 50 --mask none.nii -o a.stl");
    assert!(ran.exit == Exit::Failed && ran.err.contains("a value other than 0"), "{}", ran.err);
    // The ball lies where the mask has another label.
    folder.volume("corner.nii", Space::Ras, |ijk| f32::from(u8::from(ijk == [0; 3])));
    for cut in ["--mask corner.nii", "--clip 1,0,0,-99"] {
        let ran = folder.done(&format!("extract ball.nii --iso 50:core {cut} -o a.stl"));
        let says = "core: what is kept of the volume holds nothing of it";
        assert!(ran.err.contains(says), "{cut}: {}", ran.err);
    }
}

#[test]
fn a_mask_without_a_known_space_is_taken_to_lie_in_the_same_one() {
    let folder = folder();
    folder.volume("loose.npy", Space::Unknown, |ijk| f32::from(u8::from(ball(ijk) > 0.0)));
    let ran = folder.done("extract ball.nii --iso 50 --mask loose.npy -o a.stl");
    assert!(
        ran.err.contains("loose.npy: axes are RAS and unknown; they are taken to be the same"),
        "{}",
        ran.err
    );
}

#[test]
fn of_a_volume_that_is_all_inside_a_mask_tells_what_is_left() {
    let folder = folder();
    folder.volume("elsewhere.npy", Space::Unknown, |_| 1.0);
    let ran =
        folder.done("extract ball.nii --iso -9999 --mask labels.nii --mask-values 4 -o a.stl");
    assert!(!ran.err.contains("warning"), "no box of the volume: {}", ran.err);
    folder.done("check a.stl");
    for (line, says) in [
        ("--iso -9999 --boundary open --mask elsewhere.npy", "kept of the volume holds nothing"),
        ("--iso -9999 --mask elsewhere.npy", "kept of the volume holds nothing"),
        ("--iso 9999 --mask labels.nii", "above every sample"),
    ] {
        let ran = folder.done(&format!("extract ball.nii {line} -o a.stl"));
        assert!(ran.err.contains(says), "{line}: {}", ran.err);
    }
}

#[test]
fn of_surfaces_that_no_plane_names_the_remarks_stay() {
    let folder = folder();
    let line = "--iso 50:core --iso -9999:all --clip 1,0,0,20:core";
    let ran = folder.done(&format!("extract ball.nii {line} -o a.stl"));
    assert!(ran.err.contains("the surface is the box of the volume"), "{}", ran.err);
    let ran = folder.done(&format!("extract ball.nii {line} --boundary open -o a.stl"));
    assert!(ran.err.contains("warning") && !ran.err.contains("what is kept"), "{}", ran.err);
}

#[test]
fn a_mask_that_is_not_there_is_told_before_the_volume_is_read() {
    let folder = folder();
    let ran = folder.run("extract ball.nii --iso 50 --index --mask none.nii -o a.stl");
    assert!(ran.exit == Exit::Failed && ran.err.contains("none.nii"), "{}", ran.err);
    assert!(!folder.names().contains(&"ball.nii.bricks".to_owned()));
}

#[test]
fn what_does_not_go_with_a_mask_is_said() {
    let folder = folder();
    fs::write(folder.path("detached.nhdr"), "").unwrap();
    fs::write(folder.path("detached.raw"), "").unwrap();
    for (line, says) in [
        ("--mask labels.nii --refine 1", "cannot be used with"),
        ("--mask labels.nii --max-memory 1GiB", "cannot be used with"),
        ("--mask labels.nii --placement cubic", "cannot be used with"),
        ("--mask labels.nii --dump-scene s.toml", "a scene has no mask"),
        ("--mask-values 4", "--mask <VOLUME>"),
        ("--mask labels.nii --mask-values 4,skin", "expected a number, found \"skin\""),
        ("--mask labels.nii --report labels.nii", "are the same file"),
        ("--mask detached.nhdr --report detached.raw", "are the same file"),
        ("--mask labels.nii --diagonals fitted", "leave out either it or --clip and --mask"),
        ("--clip 1,0,0,5 --diagonals fitted", "leave out either it or --clip and --mask"),
        ("--clip 1,0,0,5:iso_50 --diagonals fitted", "leave out either it or --clip and --mask"),
        ("--mask labels.nii --degenerate exact", "--degenerate exact: triangles of surfaces that"),
        ("--clip 1,0,0,5 --degenerate exact", "leave out either it or --clip and --mask"),
    ] {
        let ran = folder.run(&format!("extract ball.nii --iso 50 {line} -o a.stl"));
        assert!(ran.exit == Exit::Usage && ran.err.contains(says), "{line}: {}", ran.err);
    }
}
