//! What STL files say, right and wrong.

use crate::{
    Format,
    mesh::kit::{context, fault, read_back, surface, written},
};
use isokit_mesh::{Surface, TriMesh};
use std::slice::from_ref;

const FACET: &str = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1e0 0\n \
                     endloop\nendfacet\n";

#[track_caller]
fn check_fault(file: &str, expected: &str) {
    assert_eq!(fault(Format::Stl, file), format!("test: STL, {expected}"));
}

#[test]
fn the_header_says_where_and_what_and_never_solid() {
    let (bytes, _) = written(Format::Stl, &[surface(3)], &context());
    let header = String::from_utf8_lossy(&bytes[..80]).into_owned();
    let expected =
        "isokit 0.1.0 SPACE=RAS UNIT=mm ISO=-300.5 NAME=skin COMMAND=isokit extract head.";
    assert_eq!(header, expected);
    assert_eq!(bytes.len(), 84 + 18 * 50);
    let solid = Surface { name: "solid".into(), ..Surface::default() };
    assert!(!written(Format::Stl, &[solid], &context()).0.starts_with(b"solid"));
}

#[test]
fn normals_are_those_of_the_triangles_and_point_outside() {
    let (bytes, _) = written(Format::Stl, &[surface(24)], &context());
    let torus = surface(24).mesh;
    for (facet, triangle) in bytes[84..].chunks_exact(50).zip(&torus.triangles) {
        let number = |k: usize| f32::from_le_bytes(facet[4 * k..4 * k + 4].try_into().unwrap());
        let normals = torus.normals.as_ref().unwrap();
        let smooth = normals[triangle[0] as usize];
        let dot: f32 = (0..3).map(|k| number(k) * smooth[k]).sum();
        assert!(dot > 0.9, "{dot}");
        assert_eq!(facet[48..], [0, 0]);
    }
}

#[test]
fn corners_at_one_place_become_one_vertex_and_that_is_said() {
    let surface = surface(8);
    let input = read_back(Format::Stl, written(Format::Stl, from_ref(&surface), &context()).0);
    assert_eq!(input.surfaces[0].mesh.counts(), surface.mesh.counts());
    assert_eq!(
        input.notes,
        ["STL repeats vertices: 320 corners at exactly the place of another one share its vertex"]
    );
}

#[test]
fn degenerate_triangles_are_kept_for_whoever_checks() {
    let positions = isokit_mesh::Positions::F32(vec![[0.0; 3], [1.0, 0.0, 0.0]]);
    let mesh = TriMesh { positions, triangles: vec![[0, 1, 1], [0, 0, 0]], ..TriMesh::default() };
    let surface = Surface { mesh: mesh.clone(), ..Surface::default() };
    let input = read_back(Format::Stl, written(Format::Stl, &[surface], &context()).0);
    assert_eq!(input.surfaces[0].mesh.triangles, mesh.triangles);
}

#[test]
fn text_holds_several_solids_in_any_case() {
    let text =
        format!("solid left part\n{FACET}endsolid\n\nSOLID\n{}ENDSOLID x\n", FACET.to_uppercase());
    let input = read_back(Format::Stl, text.replace('\n', "\r\n"));
    let names: Vec<_> = input.surfaces.iter().map(|surface| surface.name.as_str()).collect();
    assert_eq!(names, ["left part", "test"]);
    for surface in &input.surfaces {
        assert_eq!(surface.mesh.triangles, [[0, 1, 2]]);
    }
}

#[test]
fn a_binary_file_may_begin_with_solid() {
    let (mut bytes, _) = written(Format::Stl, &[surface(3)], &context());
    bytes[..5].copy_from_slice(b"solid");
    assert_eq!(read_back(Format::Stl, bytes).surfaces[0].mesh.counts().triangles, 18);
}

#[test]
fn bytes_behind_the_last_triangle_are_ignored() {
    let (mut bytes, _) = written(Format::Stl, &[surface(3)], &context());
    bytes.extend(b"trailer");
    assert_eq!(read_back(Format::Stl, bytes).surfaces[0].mesh.counts().triangles, 18);
}

#[test]
fn a_fault_is_named_with_its_place() {
    check_fault("", "byte 0: expected \"solid\" or a header of 84 bytes, found 0 bytes");
    check_fault(&format!("solid\n{FACET}"), "line 8: expected endsolid, found the end of the file");
    let wrong = format!("solid\n{FACET}endsolid").replace("vertex 1 0 0", "vertex 1 0");
    check_fault(&wrong, r#"line 5: expected vertex and three numbers, found "vertex 1 0""#);
    let wrong = format!("solid\n{FACET}endsolid").replace("  vertex 1 0 0\n", "");
    check_fault(
        &wrong,
        "line 6: expected solid, facet, outer loop, three vertices and their ends, found \"endloop\"",
    );
    let mut bytes = written(Format::Stl, &[surface(3)], &context()).0;
    bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let expected = "test: STL: header announces 214748364750 bytes of triangles, file holds 900";
    assert_eq!(fault(Format::Stl, bytes), expected);
}
