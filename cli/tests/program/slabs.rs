//! `extract --max-memory`: the same files in little memory, and what cannot be had so.

use crate::kit::{Folder, ball};
use isokit::geom::Space;
use isokit_cli::Exit;
use serde_json::json;
use std::fs;

/// Room for the program, for the pieces of so many surfaces, and for 4 to 6, 7, 10 and all slices of the
/// volumes here; with longer stencils for those of the least window, a few slices more, and all.
fn limits(words: &str) -> Vec<String> {
    let room = 40 * 1024 + 3 * 1024 * words.matches("--iso ").count();
    // Where all cells may be special, a slice takes four times as much.
    let times = if words.contains("--topology table") { 1 } else { 4 };
    let slices = match words.contains("--placement linear") {
        true => [7, 9, 13, 1 << 20],
        false => [21, 23, 26, 1 << 20],
    };
    slices.iter().map(|slices| format!("{}KiB", room + times * slices)).collect()
}

/// Compares all files that a command makes with those it makes at every limit.
#[track_caller]
fn same(folder: &Folder, words: &str) {
    same_as_placed(folder, words);
    if !words.contains("--placement") {
        same_as_placed(folder, &format!("{words} --placement linear")); // with a window of fewer slices
    }
}

#[track_caller]
fn same_as_placed(folder: &Folder, words: &str) {
    let before = folder.names();
    let made = || {
        let names = folder.names().into_iter().filter(|name| !before.contains(name));
        let read = |name: String| {
            let content = fs::read(folder.path(&name)).unwrap();
            fs::remove_file(folder.path(&name)).unwrap();
            (name, content)
        };
        names.map(read).collect::<Vec<_>>()
    };
    let told = folder.done(&format!("extract {words}")).err;
    let expected = made();
    assert!(!expected.is_empty(), "{words}");
    for limit in limits(words) {
        let ran = folder.done(&format!("extract {words} --max-memory {limit}"));
        assert_eq!(ran.err, told, "{words}, {limit}");
        let names = |files: &[(String, Vec<u8>)]| {
            files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>()
        };
        let found = made();
        assert_eq!(names(&found), names(&expected));
        assert!(found == expected, "{words}, {limit}");
    }
}

#[test]
fn every_format_gets_the_same_bytes() {
    let folder = Folder::with_ball();
    for name in ["a.ply", "a.stl", "a.obj", "a.glb", "a.gltf"] {
        same(&folder, &format!("ball.nii --iso 50 -o {name}"));
    }
}

#[test]
fn packed_volumes_and_series_of_slices_get_the_same_bytes() {
    let folder = Folder::new();
    folder.volume("ball.nii.gz", Space::Ras, ball);
    same(&folder, "ball.nii.gz --iso 50 -o a.ply");
    let slice = |k: usize| {
        let samples = (0..14).flat_map(|j| (0..16).map(move |i| ball([i, j, k])));
        samples.flat_map(f32::to_be_bytes).collect::<Vec<u8>>()
    };
    for k in 0..12 {
        fs::write(folder.path(&format!("s{k}.raw")), slice(k)).unwrap();
    }
    let header = "NRRD0004\ntype: float\ndimension: 3\nsizes: 16 14 12\nendian: big\n\
                  encoding: raw\ndata file: s%d.raw 0 11 1 2\n";
    fs::write(folder.path("series.nhdr"), header).unwrap();
    same(&folder, "series.nhdr --iso 50 -o a.ply");
    same(&folder, "series.nhdr --iso 50 --roi 2:,3:9,4:11 -o a.glb");
}

#[test]
fn every_choice_of_surface_part_and_place_gets_the_same_bytes() {
    let folder = Folder::with_ball();
    for options in [
        "--iso 20:skin:#d8a58080 --iso 50 --iso -1e1:#010203",
        "--iso auto",
        "--iso 40%",
        "--iso 1000",
        "--iso -1000",
        "--iso -1000 --boundary open",
        "--iso 50 --normals none --degenerate exact",
        "--iso -20 --boundary open --roi 1:9,2:14,3:10",
        "--iso 50 --roi :,:,5:8",
        "--iso 50 --roi-mm -18:-12,:,33:41 --space lps",
        "--iso 50 --space index --gltf-unit mm",
        "--iso 50 --placement cubic",
        "--iso 20 --placement quintic --boundary open",
        "--iso 50 --normals matching",
        "--iso 50 --origin 5e6,6e6,7e6 --spacing 0.1,0.1,0.1",
    ] {
        same(&folder, &format!("ball.nii {options} -o a.glb"));
    }
    same(&folder, "ball.nii --iso 20 --iso 50 -o a.ply");
    folder.volume("noise.nii", Space::Ras, |[i, j, k]| {
        ((7 * i + 11 * j * j + 13 * k * i) % 9) as f32
    });
    same(&folder, "noise.nii --iso 4 --topology table -o a.ply");
    // So high that the window of every placement moves.
    let tower = |[i, j, k]: [usize; 3]| ((5 * i + 3 * j * j + 7 * k * i + k) % 9) as u8;
    let places = (0..8 * 7 * 30).map(|n| [n % 8, n / 8 % 7, n / 56]);
    fs::write(folder.path("tower.raw"), places.map(tower).collect::<Vec<u8>>()).unwrap();
    same(&folder, "tower.raw --dims 8,7,30 --dtype u8 --iso 4 -o a.ply");
}

#[test]
fn nan_is_treated_and_told_the_same() {
    let folder = Folder::new();
    let holes = |ijk: [usize; 3]| match (ijk[0] + 3 * ijk[1] + 5 * ijk[2]) % 17 {
        0 => f32::NAN,
        _ => ball(ijk),
    };
    folder.volume("a.nii", Space::Ras, holes);
    same(&folder, "a.nii --iso 20 --nan outside -o a.ply");
    same(&folder, "a.nii --iso 20 --nan mask -o a.ply");
    for options in ["", " --roi 3:9,2:,5:", " --placement linear"] {
        let words = format!("extract a.nii --iso 20 -o a.ply{options}");
        let expected = folder.run(&words);
        assert_eq!(expected.exit, Exit::Failed);
        for limit in limits(&words) {
            assert_eq!(folder.run(&format!("{words} --max-memory {limit}")).err, expected.err);
        }
        assert_eq!(folder.names(), ["a.nii"], "nothing is left");
    }
}

#[test]
fn the_report_tells_what_is_known_of_slices_that_passed_by() {
    let folder = Folder::with_ball();
    let words = "extract ball.nii --iso 50:ball --iso 20 --roi :,:,2:11 -o a.glb --report";
    folder.done(&format!("{words} whole.json"));
    folder.done(&format!("{words} slabs.json --max-memory 56MiB"));
    let (whole, slabs) = (folder.json("whole.json"), folder.json("slabs.json"));
    for key in ["schema", "command", "input", "outputs", "warnings", "threads", "version"] {
        assert_eq!(slabs[key], whole[key], "{key}");
    }
    for n in 0..2 {
        let (slabs, whole) = (&slabs["surfaces"][n], &whole["surfaces"][n]);
        for key in [
            "name",
            "iso",
            "color",
            "vertices",
            "triangles",
            "components",
            "euler",
            "bounds",
            "boundary_edges",
            "nonmanifold_edges",
            "inconsistent_edges",
            "degenerate_triangles",
        ] {
            assert_eq!(slabs[key], whole[key], "{key}");
        }
        for key in ["area", "volume"] {
            let [slabs, whole] = [slabs, whole].map(|surface| surface[key].as_f64().unwrap());
            assert!((slabs / whole - 1.0).abs() < 1e-12, "{key}: {slabs}, {whole}");
        }
    }
    assert_eq!(slabs["skipped"]["samples_read"], json!(16 * 14 * 9));
    assert!(slabs["timings_s"]["total"].as_f64().unwrap() > 0.0);
}

#[test]
fn what_cannot_be_had_is_refused_with_what_can() {
    let folder = Folder::with_ball();
    let noise: Vec<u8> =
        (0..300 * 300 * 6_u32).map(|n| (n.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    fs::write(folder.path("a.raw"), noise).unwrap();
    let dense =
        "a.raw --dims 300,300,6 --dtype u8 --iso 99.5 -o a.ply --topology table --max-memory 44MiB";
    fs::write(folder.path("f.npy"), fortran()).unwrap();
    for (words, exit, says) in [
        (
            "ball.nii --iso 5 -o a.ply --max-memory 9MiB",
            Exit::Failed,
            "slices at a time need 44MiB in all",
        ),
        (dense, Exit::Failed, "the surface of one slice needs"),
        ("ball.nii --iso 5 -o - --max-memory 1GiB", Exit::Usage, "name one with -o"),
        ("ball.nii --iso 5 -o a.ply --normals area --max-memory 1GiB", Exit::Usage, "whole mesh"),
        ("f.npy --iso 5 -o a.ply --max-memory 1GiB", Exit::Failed, "convert the file to .nrrd"),
        ("ball.nii --iso 5 -o a.ply --max-memory 512M", Exit::Usage, "512MiB may be meant"),
    ] {
        let ran = folder.run(&format!("extract {words}"));
        assert_eq!(ran.exit, exit, "{words}: {}", ran.err);
        assert!(ran.err.contains(says), "{words}: {}", ran.err);
    }
}

/// 2 × 2 × 2 samples as NumPy writes them with the slowest axis first.
fn fortran() -> Vec<u8> {
    let header = "{'descr': '|u1', 'fortran_order': True, 'shape': (2, 2, 2), }";
    let mut file = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    file.extend(format!("{header:<117}\n").bytes());
    file.extend([0, 9, 0, 9, 0, 9, 0, 9]);
    file
}
