//! What fails, with which status and which words, and leaves nothing behind.

use crate::kit::{DIMS, Folder, ball};
use isokit::{geom::Space, job::CancelToken};
use isokit_cli::{Exit, run_cancellable};
use std::{
    fs,
    io::{self, Write},
};

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
    let mesh = folder.path("a.ply");
    fs::write(&mesh, "old").unwrap();
    let mut seen = vec![];
    let look = || seen.push((fs::read(&mesh).unwrap(), half_made(&folder)));
    let exit = when_extracted(&folder, &CancelToken::default(), look).0;
    assert_eq!(exit, Exit::Done);
    assert_eq!(seen, [(b"old".to_vec(), 1)], "beside the new one, which is not whole yet");
    assert!(fs::read(&mesh).unwrap().starts_with(b"ply\n"));
    assert_eq!(folder.names(), ["a.ply", "ball.nii"]);
}

#[test]
fn an_old_output_stands_when_the_last_slice_fails() {
    let folder = Folder::new();
    let last = |ijk: [usize; 3]| if ijk[2] == DIMS[2] - 1 { f32::NAN } else { ball(ijk) };
    folder.volume("last.nii", Space::Ras, last);
    fs::write(folder.path("a.ply"), "old").unwrap();
    let line = format!("extract last.nii --iso 50 -o a.ply{FEW_SLICES}");
    fails(&folder, &line, Exit::Failed, &["samples that are NaN: 224", "the file's fault"]);
    assert_eq!(fs::read(folder.path("a.ply")).unwrap(), b"old");
    folder.done(&format!("{line} --nan outside"));
    assert!(fs::read(folder.path("a.ply")).unwrap().starts_with(b"ply\n"));
}

#[test]
fn an_interrupt_is_status_130_and_leaves_nothing() {
    let folder = Folder::with_ball();
    let (cancel, mut begun) = (CancelToken::default(), 0);
    let interrupt = || {
        begun = half_made(&folder);
        cancel.cancel();
    };
    let (exit, err) = when_extracted(&folder, &cancel, interrupt);
    assert_eq!(begun, 1, "there is something to leave");
    assert_eq!((exit, exit.code()), (Exit::Interrupted, 130));
    assert!(err.contains("\nerror: interrupted"), "{err}");
    assert_eq!(folder.names(), ["ball.nii"]);
}

/// A few slices of the ball at a time: the first pieces of the mesh are on the disk before the last slice
/// is read.
const FEW_SLICES: &str = " --topology table --placement linear --max-memory 44039KiB";

/// Outputs that were begun and have no name yet.
fn half_made(folder: &Folder) -> usize {
    folder.names().iter().filter(|name| name.starts_with(".isokit-")).count()
}

/// Makes `a.ply` of the ball, and does something as soon as its size is told: all pieces are made then, and
/// the file is not.
fn when_extracted(
    folder: &Folder,
    cancel: &CancelToken,
    mut act: impl FnMut() + Send,
) -> (Exit, String) {
    let (ball, mesh) = (folder.path("ball.nii"), folder.path("a.ply"));
    let words = ["isokit", "extract", ball.to_str().unwrap(), "--iso", "50", "-o"];
    let words = words.into_iter().chain([mesh.to_str().unwrap()]);
    let words = words.chain(FEW_SLICES.split_whitespace());
    let mut err = Listener { heard: vec![], act: &mut act };
    let exit = run_cancellable(words, &mut vec![], &mut err, cancel);
    (exit, String::from_utf8(err.heard).unwrap())
}

/// Acts once, when a surface is told.
struct Listener<'a> {
    heard: Vec<u8>,
    act: &'a mut (dyn FnMut() + Send),
}

impl Write for Listener<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let is_told = |heard: &[u8]| heard.windows(9).any(|word| word == b" vertices");
        let was_told = is_told(&self.heard);
        self.heard.extend(bytes);
        if !was_told && is_told(&self.heard) {
            (self.act)();
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
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
