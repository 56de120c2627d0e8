//! What fails, with which status and which words, and leaves nothing behind.

use crate::kit::{Folder, ball};
use isokit::{geom::Space, job::CancelToken};
use isokit_cli::{Exit, run_cancellable};
use std::fs;

#[track_caller]
fn fails(folder: &Folder, line: &str, exit: Exit, says: &[&str]) {
    let before = folder.names();
    let ran = folder.run(line);
    assert_eq!(ran.exit, exit, "{line}: {}", ran.err);
    for words in says {
        assert!(ran.err.contains(words), "{line}: {}", ran.err);
    }
    assert!(ran.err.starts_with("error: "), "{}", ran.err);
    assert_eq!(ran.out, b"", "data goes to stdout, nothing else");
    assert_eq!(folder.names(), before, "nothing is left behind");
}

#[test]
fn wrong_usage_is_status_2() {
    let folder = Folder::with_ball();
    fails(&folder, "extract ball.nii --iso 50 -o a.xyz", Exit::Usage, &["found .xyz"]);
    fails(&folder, "extract ball.nii -o a.ply", Exit::Usage, &["--iso"]);
    let refusal = "expected a number, a percentage from 0% to 100%, or auto, found \"skin\"";
    fails(&folder, "extract ball.nii --iso skin:3 -o a.ply", Exit::Usage, &[refusal]);
    fails(&folder, "extract ball.nii --iso 50 -o a.ply --smooth 3", Exit::Usage, &["--smooth"]);
}

#[test]
fn a_failure_is_status_1_and_says_whose_fault_it_is() {
    let folder = Folder::with_ball();
    let lost = ["lost.nii: cannot read", "the caller's fault: look at the path"];
    fails(&folder, "extract lost.nii --iso 50 -o a.ply", Exit::Failed, &lost);
    fails(&folder, "info lost.nii", Exit::Failed, &lost);
    let bytes = fs::read(folder.path("ball.nii")).unwrap();
    fs::write(folder.path("cut.nii"), &bytes[..1000]).unwrap();
    let cut = ["cut.nii: NIfTI: ", "the file's fault: "];
    fails(&folder, "extract cut.nii --iso 50 -o a.ply", Exit::Failed, &cut);
    let part = ["samples 3:99 of the x axis, which has 16", "the caller's fault: choose a part"];
    fails(&folder, "extract ball.nii --iso 50 --roi 3:99,:,: -o a.ply", Exit::Failed, &part);
    let folders = ["there is no folder", "the caller's fault: make the folder"];
    fails(&folder, "extract ball.nii --iso 50 -o no/a.ply", Exit::Failed, &folders);
}

#[test]
fn the_folder_of_the_output_is_looked_for_before_the_input() {
    let folder = Folder::new();
    let says = ["there is no folder"];
    fails(&folder, "extract lost.nii --iso 50 -o no/a.ply", Exit::Failed, &says);
}

#[test]
fn nan_is_an_error_until_someone_says_what_it_means() {
    let folder = Folder::new();
    let hole = |ijk| if ijk == [8, 7, 6] || ijk == [9, 7, 6] { f32::NAN } else { ball(ijk) };
    folder.volume("hole.nii", Space::Ras, hole);
    let says =
        ["samples that are NaN: 2, the first at [8, 7, 6]", "the file's fault", "--nan mask"];
    fails(&folder, "extract hole.nii --iso 50 -o a.ply", Exit::Failed, &says);
    let part = "extract hole.nii --iso 50 --roi 4:,3:,2: -o a.ply";
    fails(&folder, part, Exit::Failed, &["the first at [8, 7, 6]"]);

    folder.done("extract hole.nii --iso 20 --nan outside -o closed.ply");
    let closed = folder.topology("closed.ply");
    assert_eq!((closed.shortfalls(), closed.components.len()), (vec![], 2));
    folder.done("extract hole.nii --iso 20 --nan mask -o open.ply");
    assert!(folder.topology("open.ply").components.len() == 1);
}

#[test]
fn an_old_output_stands_until_the_new_one_is_whole() {
    let folder = Folder::with_ball();
    fs::write(folder.path("a.ply"), "old").unwrap();
    folder.run("extract ball.nii --iso 50 --roi 3:99,:,: -o a.ply");
    assert_eq!(fs::read(folder.path("a.ply")).unwrap(), b"old");
    folder.done("extract ball.nii --iso 50 -o a.ply");
    assert!(fs::read(folder.path("a.ply")).unwrap().starts_with(b"ply\n"));
    assert_eq!(folder.names(), ["a.ply", "ball.nii"]);
}

#[test]
fn an_interrupt_is_status_130_and_leaves_nothing() {
    let folder = Folder::with_ball();
    let (ball, mesh) = (folder.path("ball.nii"), folder.path("a.ply"));
    let cancel = CancelToken::default();
    cancel.cancel();
    let words = ["isokit", "extract", ball.to_str().unwrap(), "--iso", "50", "-o"];
    let words = words.into_iter().chain([mesh.to_str().unwrap()]);
    let (mut out, mut err) = (vec![], vec![]);
    let exit = run_cancellable(words, &mut out, &mut err, &cancel);
    assert_eq!((exit, exit.code()), (Exit::Interrupted, 130));
    assert!(err.starts_with(b"error: interrupted"));
    assert_eq!(folder.names(), ["ball.nii"]);
}

#[test]
fn sizes_that_were_typed_are_the_callers() {
    let folder = Folder::new();
    fs::write(folder.path("a.raw"), [7; 27]).unwrap();
    let caller = "the caller's fault: ";
    for (options, says) in [
        ("3,3,4", "sizes and sample type describe 36 bytes, the file has 27\n"),
        ("3,3,3 --skip 1", "describe 27 bytes, the file has 26 after 1 that are skipped"),
        ("3,3,3 --skip 99", "describe 27 bytes, the file has 0 after 99 that are skipped"),
        ("3,3,2", "describe 18 bytes, the file has 27"),
        ("4294967296,4294967296,4", "more samples than 64 bits can count"),
    ] {
        let line = format!("info a.raw --dtype u8 --json --dims {options}");
        fails(&folder, &line, Exit::Failed, &[says, caller]);
    }
    let zero = "expected sizes of 1 or more, found \"3,3,0\"";
    fails(&folder, "info a.raw --dtype u8 --dims 3,3,0", Exit::Usage, &[zero]);
}

#[test]
fn samples_of_one_value_have_no_automatic_isovalue() {
    let folder = Folder::new();
    folder.volume("flat.nii", Space::Ras, |_| 7.0);
    let says = ["auto gives no isovalue: all samples have one value", "give --iso a number"];
    fails(&folder, "extract flat.nii --iso auto -o a.ply", Exit::Failed, &says);
}
