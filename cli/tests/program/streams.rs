//! What goes to stdout and what to stderr.

use crate::kit::Folder;
use isokit::lanes::Level;
use isokit_cli::{Exit, run};
use std::{
    fs,
    io::{self, Write},
};

#[test]
fn a_mesh_on_stdout_is_the_mesh_of_the_file() {
    let folder = Folder::with_ball();
    for format in ["ply", "glb", "stl"] {
        let name = format!("a.{format}");
        folder.done(&format!("extract ball.nii --iso 50 -o {name}"));
        let ran = folder.done(&format!("extract ball.nii --iso 50 -o - --format {format}"));
        assert!(ran.out == fs::read(folder.path(&name)).unwrap(), "{format}");
    }
    let ran = folder.done("extract ball.nii --iso 50 -o -");
    assert!(ran.out.starts_with(b"ply\n"));
}

#[test]
fn quiet_is_quiet_and_verbose_tells_more() {
    let folder = Folder::with_ball();
    assert_eq!(folder.done("extract ball.nii --iso 1000 -o a.ply -q").err, "");
    let usual = folder.done("extract ball.nii --iso 50 -o a.ply").err;
    assert!(usual.starts_with("iso_50: ") && usual.contains("\nwrote "), "{usual}");
    let verbose = folder.done("extract ball.nii --iso 50 -o a.ply -v").err;
    assert!(verbose.contains(" s, total ") && verbose.contains("Euler"), "{verbose}");
}

#[test]
fn the_log_may_be_json_a_line_each() {
    let folder = Folder::with_ball();
    let ran = folder.done("extract ball.nii --iso 1000 -o a.ply --log-json --progress always");
    for line in ran.err.lines() {
        let object: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!(object["level"].is_string(), "{line}");
    }
    assert!(ran.err.contains(r#"{"level":"warning","message":"isovalue 1000 is above"#));
    let ran = folder.run("info lost.nii --log-json");
    let error: serde_json::Value = serde_json::from_str(&ran.err).unwrap();
    assert_eq!(error["fault"], "the caller's fault");
}

#[test]
fn progress_is_shown_where_it_was_asked_for() {
    let folder = Folder::with_ball();
    let shown = folder.done("extract ball.nii --iso 50 -o a.ply --progress always").err;
    assert!(shown.lines().any(|line| line.ends_with(" %")), "{shown}");
    let never = folder.done("extract ball.nii --iso 50 -o a.ply").err;
    assert!(!never.contains('%'), "{never}");
    for mode in ["surfaces", "iso-raycast", "raycast", "splat"] {
        let line = format!("render ball.nii --iso 50 --mode {mode} --size 33x33 -o a.png");
        let shown = folder.done(&format!("{line} --progress always")).err;
        let last = shown.lines().rfind(|line| line.ends_with(" %"));
        assert_eq!(last, Some("render: 100 %"), "{mode}: {shown}");
        assert!(!folder.done(&line).err.contains('%'), "{mode}");
    }
}

/// A pipe whose reader has gone.
struct Gone;

impl Write for Gone {
    fn write(&mut self, _: &[u8]) -> io::Result<usize> {
        Err(io::ErrorKind::BrokenPipe.into())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_reader_that_has_gone_is_no_error() {
    let folder = Folder::with_ball();
    let ball = folder.path("ball.nii").into_os_string().into_string().unwrap();
    for line in ["info BALL", "extract BALL --iso 50 -o - -q", "--help", "completions bash"] {
        let line = line.replace("BALL", &ball);
        let words = format!("isokit {line}");
        let mut err = vec![];
        let exit = run(words.split(' '), &mut Gone, &mut err);
        assert_eq!((exit, String::from_utf8(err).unwrap()), (Exit::Done, String::new()), "{line}");
    }
}

#[test]
fn every_command_helps_on_stdout() {
    let folder = Folder::new();
    assert!(folder.done("--help").text().contains("Commands:"));
    assert!(folder.done("--version").text().starts_with("isokit "));
    for command in ["info", "extract", "check", "convert", "completions", "man"] {
        let ran = folder.done(&format!("{command} --help"));
        assert!(ran.text().contains("Example"), "{command}");
        assert_eq!(ran.err, "");
    }
    let ran = folder.run("frobnicate");
    assert_eq!((ran.exit, ran.out.len()), (Exit::Usage, 0));
}

#[test]
fn completions_and_manual_pages_come_from_the_same_definition() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let ran = folder.done(&format!("completions {shell}"));
        assert!(ran.text().contains("boundary"), "{shell}");
    }
    assert!(folder.done("man").text().contains(".TH isokit"));
    let (mut out, mut err) = (vec![], vec![]);
    let dir = folder.path("");
    let exit = run(["isokit".into(), "man".into(), dir.into_os_string()], &mut out, &mut err);
    assert_eq!(exit, Exit::Done);
    assert!(folder.names().contains(&"isokit-extract.1".to_owned()), "{:?}", folder.names());
    let page = fs::read_to_string(folder.path("isokit-extract.1")).unwrap();
    assert!(page.contains("degenerate"), "{page}");
}

/// What the program says on stderr, and its status, with `ISOKIT_SIMD` in its environment.
fn with_level(folder: &Folder, level: &str) -> (Option<i32>, String) {
    let mut process = std::process::Command::new(env!("CARGO_BIN_EXE_isokit"));
    process.args(["extract", "ball.nii", "--iso", "50", "-o", "a.ply"]);
    let done = process.current_dir(folder.path("")).env("ISOKIT_SIMD", level).output().unwrap();
    (done.status.code(), String::from_utf8(done.stderr).unwrap())
}

#[test]
fn instructions_that_there_are_not_are_refused_or_warned_of() {
    let folder = Folder::with_ball();
    let (status, told) = with_level(&folder, "avx-512");
    assert_eq!(status, Some(2), "{told}");
    let refusal = "error: ISOKIT_SIMD: expected one of portable avx2 avx512, found \"avx-512\"";
    assert!(told.starts_with(refusal), "{told}");
    assert_eq!(folder.names(), ["ball.nii"]);
    for level in Level::ALL {
        let (status, told) = with_level(&folder, level.name());
        assert_eq!(status, Some(0), "{told}");
        let has_it = Level::available().contains(&level);
        let warning = format!("warning: ISOKIT_SIMD: this machine has no {level}; ");
        assert_eq!(told.contains(&warning), !has_it, "{told}");
    }
    assert_eq!(with_level(&folder, "").0, Some(0), "empty is as good as unset");
}
