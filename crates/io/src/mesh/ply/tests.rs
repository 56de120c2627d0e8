//! What PLY files say, right and wrong.

use crate::{
    Format,
    mesh::kit::{context, fault, read_back, surface, written},
};
use isokit_geom::Space;
use isokit_mesh::{Positions, Rgba};

/// A triangle in text, with some lines of the header and all of the body replaced.
fn triangle(header: &str, body: &str) -> String {
    format!("ply\nformat ascii 1.0\n{header}\nend_header\n{body}")
}

const VERTICES: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z";
const FACES: &str = "element face 1\nproperty list uchar int vertex_index";

#[track_caller]
fn check_fault(file: &str, expected: &str) {
    assert_eq!(fault(Format::Ply, file), format!("test: PLY, {expected}"));
}

#[test]
fn the_header_is_what_others_understand() {
    let (bytes, _) = written(Format::Ply, &[surface(3)], &context());
    let header = String::from_utf8_lossy(&bytes);
    let (header, _) = header.split_once("end_header\n").unwrap();
    assert_eq!(
        header,
        "ply\nformat binary_little_endian 1.0\ncomment isokit 0.1.0\ncomment SPACE=RAS\n\
         comment UNIT=mm\ncomment COMMAND=isokit extract head.nii -o head.glb\n\
         comment NAME=skin\ncomment ISO=-300.5\ncomment COLOR=#d8a58080\nelement vertex 9\n\
         property float x\nproperty float y\nproperty float z\nproperty float nx\n\
         property float ny\nproperty float nz\nelement face 18\n\
         property list uchar int vertex_indices\n"
    );
}

#[test]
fn polygons_become_fans_and_strangers_are_passed_over() {
    let header = "obj_info hello\nelement camera 2\nproperty float view\nproperty list uchar int tags\n\
                  element vertex 5\nproperty uchar red\nproperty double z\nproperty double y\n\
                  property double x\nproperty list uchar float more\n\
                  element face 2\nproperty uchar flags\nproperty list uchar uint vertex_indices\n\
                  element edge 1\nproperty int a";
    let body = "1 2 7 8\n2 0\n9 0 0 0 1 5\n9 0 0 1 0\n9 0 1 1 0\n9 0 1 0 0\n9 0.1 nan 7e300 0\n\
                1 4 0 1 2 3\n1 3 4 0 1\n0\n";
    let input = read_back(Format::Ply, triangle(header, body));
    let mesh = &input.surfaces[0].mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [4, 0, 1]]);
    let Positions::F64(positions) = &mesh.positions else { panic!("{:?}", mesh.positions) };
    assert_eq!(positions[2], [1.0, 1.0, 0.0]);
    assert!(positions[4][0] == 7e300 && positions[4][1].is_nan() && positions[4][2] == 0.1);
    assert_eq!(input.surfaces[0].name, "test", "the file's");
    assert_eq!(input.notes, ["the file does not name its unit"]);
}

#[test]
fn numbers_of_colours_that_are_beyond_are_said_once() {
    let colors = ["red", "green", "blue"].map(|name| format!("\nproperty float {name}")).concat();
    let read = |rest: &str| {
        let body = format!("0 0 0 0 0.5 1\n1 0 0 {rest}\n0 1 0 {rest}\n3 0 1 2\n");
        read_back(Format::Ply, triangle(&format!("{VERTICES}{colors}\n{FACES}"), &body))
    };
    let found = read("-3 nan 255");
    let expected = [[0, 128, 255, 255], [0, 0, 255, 255], [0, 0, 255, 255]].map(Rgba);
    assert_eq!(found.surfaces[0].mesh.attributes.colors, Some(expected.to_vec()));
    let says = "2 vertices have colours with numbers that are not from 0 to 1; cut to that";
    assert_eq!(found.notes[0], says);
    assert_eq!(read("0 0 1.0000002").notes.len(), 1, "the unit alone");
}

#[test]
fn every_encoding_gives_the_same_mesh() {
    let ascii = triangle(
        &format!("comment 3D Slicer output. SPACE=LPS\n{VERTICES}\n{FACES}"),
        "0 0 0\n1 0 0\n0 1.5 -2\n3 0 1 2\n",
    );
    let expected = read_back(Format::Ply, &ascii);
    assert_eq!(expected.space, Space::Lps);
    let numbers = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.5, -2.0_f32];
    for endian in ["little", "big"] {
        let format = format!("format binary_{endian}_endian 1.0");
        let header = ascii.replace("format ascii 1.0", &format).replace('\n', "\r\n");
        let mut bytes = header.as_bytes()[..header.find("end_header").unwrap()].to_vec();
        bytes.extend(b"end_header\r\n");
        let is_big = endian == "big";
        bytes.extend(
            numbers.iter().flat_map(|n| if is_big { n.to_be_bytes() } else { n.to_le_bytes() }),
        );
        bytes.push(3);
        bytes.extend(
            [0, 1, 2_u32]
                .iter()
                .flat_map(|n| if is_big { n.to_be_bytes() } else { n.to_le_bytes() }),
        );
        assert_eq!(read_back(Format::Ply, bytes).surfaces, expected.surfaces, "{endian}");
    }
}

#[test]
fn a_fault_is_named_with_its_place() {
    let all = format!("{VERTICES}\n{FACES}");
    let body = "0 0 0\n1 0 0\n0 1 0\n";
    check_fault("PLY\n", r#"line 1: expected ply, found "PLY""#);
    check_fault(
        "ply\nformat ascii 2.0\n",
        "line 2: expected format, comment, element, property or end_header, found \"format ascii 2.0\"",
    );
    check_fault(
        &triangle("element vertex -1", ""),
        "line 3: expected a number of elements, found \"element vertex -1\"",
    );
    check_fault(
        &triangle("property int x", ""),
        "line 3: expected an element first, found \"property int x\"",
    );
    check_fault(
        &triangle(FACES, "3 0 1 2\n"),
        "line 5: expected an element named vertex, found none",
    );
    check_fault(
        &triangle(&VERTICES.replace(" y", " v"), body),
        "line 3: expected vertices with x, y and z, found no y",
    );
    check_fault(
        &triangle(&all.replace("_index", "_color"), &format!("{body}3 0 1 2")),
        "line 7: expected a list named vertex_indices, found none",
    );
    check_fault(
        &triangle(&all, "0 0 0\n1 zero 0\n0 1 0\n3 0 1 2"),
        r#"line 11: expected a number, found "zero""#,
    );
    check_fault(
        &triangle(&all, &format!("{body}2 0 1")),
        "line 13: expected a face of at least 3 corners, found 2",
    );
    check_fault(
        &triangle(&all, &format!("{body}3 0 -1 2")),
        "line 13: expected a whole number not below 0, found -1",
    );
    check_fault(
        &triangle(&all, &format!("{body}3 0 3 2")),
        "face 0: expected vertices below 3, found 3",
    );
    check_fault(
        &triangle(&all, &format!("{body}3 0 1")),
        "line 13: expected a number, found the end of the file",
    );
}

#[test]
fn a_count_that_the_file_cannot_hold_takes_no_memory() {
    for count in ["4", "4000000000", "18446744073709551615"] {
        let file = triangle(&VERTICES.replace('3', count), "0 0 0\n1 0 0\n0 1 0\n");
        let found = fault(Format::Ply, file);
        assert!(found.contains("header announces") && found.contains("file holds 18"), "{found}");
    }
}

#[test]
fn strips_are_not_taken_for_no_faces() {
    let header = format!("{VERTICES}\nelement tristrips 1\nproperty list int int vertex_indices");
    check_fault(
        &triangle(&header, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2"),
        "line 7: triangle strips is not supported",
    );
}
