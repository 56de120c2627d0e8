//! No file of a command takes the place of another: which are the same is found before any is opened.

use crate::kit::{Folder, ball};
use isokit::geom::Space;
use isokit_cli::Exit;
use std::{collections::BTreeMap, fs};

/// What is in all files.
fn contents(folder: &Folder) -> BTreeMap<String, Vec<u8>> {
    let names = folder.names().into_iter();
    names.map(|name| (name.clone(), fs::read(folder.path(&name)).unwrap())).collect()
}

/// A command that is refused for two names of one file, and leaves all files as they were.
#[track_caller]
fn refused(folder: &Folder, line: &str, options: [&str; 2]) {
    let before = contents(folder);
    let ran = folder.run(line);
    assert_eq!(ran.exit, Exit::Usage, "{line}: {}", ran.err);
    assert!(ran.err.contains("are the same file"), "{line}: {}", ran.err);
    for option in options {
        assert!(ran.err.contains(option), "{line}: {}", ran.err);
    }
    assert!(contents(folder) == before, "{line}: a file has changed");
}

/// A folder with a volume and a mesh in formats of one file and of two.
fn folder() -> Folder {
    let folder = Folder::with_ball();
    for name in ["v.npy", "v.raw", "w.nhdr"] {
        folder.done(&format!("convert ball.nii -o {name}"));
    }
    for name in ["m.ply", "m.gltf", "m.obj"] {
        folder.done(&format!("extract ball.nii --iso 50 -o {name}"));
    }
    folder
}

#[test]
fn two_names_of_one_file_are_refused() {
    let folder = folder();
    let (input, output, report) = ("the input", "--output", "--report");
    for (line, options) in [
        ("extract v.npy --iso 5 -o r.ply --report r.ply", [output, report]),
        ("extract v.npy --iso 5 -o new.ply --report v.npy", [input, report]),
        ("extract v.npy --iso 5 -o r.obj --report r.mtl", [output, report]),
        ("extract v.npy --iso 5 -o r.gltf --report r.bin", [output, report]),
        ("extract v.npy --iso 5 -o r.gltf --report r.gltf", [output, report]),
        ("extract v.npy --iso 5 --iso 6 -o r.ply --report r_iso_6.ply", [output, report]),
        ("extract v.npy --iso 5:a --iso 6:a -o r.stl --report r_a_2.stl", [output, report]),
        ("extract v.npy --iso 5 -o r.ply --index --report v.npy.bricks", ["--index", report]),
        ("extract w.nhdr --iso 5 -o r.ply --report w.raw", [input, report]),
        ("extract w.nhdr --iso 5 -o r.ply --report w.raw --max-memory 1GiB", [input, report]),
        ("extract m.ply --dims 1,1,1 --dtype u8 --iso 5 -o m.ply", [input, output]),
        ("extract m.mtl --dims 1,1,1 --dtype u8 --iso 5 -o m.obj", [input, output]),
        ("extract m.bin --dims 1,1,1 --dtype u8 --iso 5 -o m.gltf", [input, output]),
        ("convert v.npy -o v.npy", [input, output]),
        ("convert w.nhdr -o w.raw", [input, output]),
        ("convert v.raw --dims 16,14,12 --dtype f32 -o v.nhdr", [input, output]),
        ("convert m.ply -o m.ply --space lps", [input, output]),
        ("convert m.gltf -o m.gltf", [input, output]),
    ] {
        refused(&folder, line, options);
    }
}

#[test]
fn what_is_named_after_a_chosen_isovalue_is_no_other_file() {
    let folder = folder();
    let line = "extract ball.nii --iso 50% --iso 20 -o r.ply";
    let told = folder.done(line).err;
    let chosen = told.lines().find_map(|line| line.strip_prefix("note: --iso 50% is ")).unwrap();
    let chosen = chosen.strip_suffix(" here").unwrap();
    for limit in ["", " --max-memory 1GiB"] {
        let line = format!("{line} --report r_iso_{chosen}.ply{limit}");
        refused(&folder, &line, ["--output", "--report"]);
    }
}

#[test]
fn surfaces_of_a_mesh_that_become_files_spare_the_input() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 50:a --iso 20:b -o m.glb");
    fs::rename(folder.path("m.glb"), folder.path("m_a.ply")).unwrap();
    refused(&folder, "convert m_a.ply -o m.ply", ["the input", "--output"]);
}

#[cfg(unix)]
#[test]
fn links_are_followed_to_what_they_name() {
    let folder = folder();
    std::os::unix::fs::symlink("v.npy", folder.path("link.json")).unwrap();
    std::os::unix::fs::symlink("r.ply", folder.path("new.json")).unwrap();
    std::os::unix::fs::symlink(folder.path("."), folder.path("here")).unwrap();
    let line = "extract v.npy --iso 5 -o r.ply --report";
    for (report, other) in [
        ("link.json", "the input"),
        ("here/v.npy", "the input"),
        ("new.json", "--output"),
        ("here/r.ply", "--output"),
    ] {
        let ran = folder.run(&format!("{line} {report}"));
        assert_eq!(ran.exit, Exit::Usage, "{report}: {}", ran.err);
        assert!(ran.err.contains(other) && ran.err.contains("--report"), "{}", ran.err);
    }
    assert!(!folder.names().contains(&"r.ply".to_owned()));
}

#[test]
fn different_files_are_not_taken_for_one() {
    let folder = Folder::new();
    folder.volume("r.nii", Space::Ras, ball);
    folder.done("extract r.nii --iso 5 -o r.obj --index --report r.json");
    folder.done("extract r.nii --iso 5 --iso 6 -o r.ply --report r_iso_7.ply");
    folder.done("convert r.obj -o r.gltf");
    folder.done("convert r.gltf -o r.glb");
    folder.done("convert r.nii -o r.nhdr");
    folder.done("convert r.nhdr -o r.nrrd");
}
