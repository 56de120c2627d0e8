//! What OBJ files say, right and wrong.

use crate::{
    Format,
    mesh::{
        axes::y_up,
        kit::{context, fault, read_back, surface, torus, written},
    },
    read_mesh,
};
use isokit_job::Job;
use isokit_mesh::{Positions, Rgba, Surface};
use std::fs;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[track_caller]
fn check_fault(file: &str, expected: &str) {
    assert_eq!(fault(Format::Obj, file), format!("test: OBJ, {expected}"));
}

#[test]
fn the_file_is_y_up_and_says_so() {
    let mut surface = surface(3);
    surface.mesh.positions = Positions::F32(vec![[0.1, 2.0, -3e-7]; 9]);
    let text = String::from_utf8(written(Format::Obj, &[surface], &context()).0).unwrap();
    let lines: Vec<_> = text.lines().take(10).collect();
    assert_eq!(lines[1..3], ["# SPACE=RAS", "# UNIT=mm"]);
    assert_eq!(lines[4], "# AXES=y up: (x, z, -y) of the source, whose z is up");
    assert_eq!(
        lines[5..10],
        ["# NAME=skin", "# ISO=-300.5", "# COLOR=#d8a58080", "o skin", "v 0.1 -0.0000003 -2"]
    );
    assert_eq!(text.lines().last(), Some("f 9//9 1//1 7//7"));
}

#[test]
fn the_crate_tobj_reads_what_we_write() {
    let second = Surface { name: "a second".into(), mesh: torus(5), ..Surface::default() };
    let surfaces = [surface(6), second];
    let bytes = written(Format::Obj, &surfaces, &context()).0;
    let options = tobj::LoadOptions { single_index: true, ..Default::default() };
    let nothing = |_: &std::path::Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut bytes.as_slice(), &options, nothing).unwrap();
    let names: Vec<_> = models.iter().map(|model| model.name.as_str()).collect();
    assert_eq!(names, ["skin", "a_second"]);
    for (model, surface) in models.iter().zip(&surfaces) {
        let (mesh, Positions::F32(positions)) = (&model.mesh, &surface.mesh.positions) else {
            panic!("f32 was written");
        };
        let normals = surface.mesh.normals.as_ref().unwrap();
        assert_eq!(mesh.positions.len(), 3 * positions.len());
        for (&found, &corner) in mesh.indices.iter().zip(surface.mesh.triangles.iter().flatten()) {
            let [at, corner] = [3 * found as usize, corner as usize];
            assert_eq!(mesh.positions[at..at + 3], y_up(positions[corner]));
            assert_eq!(mesh.normals[at..at + 3], y_up(normals[corner]));
        }
    }
}

#[test]
fn polygons_relative_indices_and_long_lines_are_understood() {
    let text =
        format!("{SQUARE}vt 0 0\nvn 0 0 1\nf -4/1/1 2/-1/-1 \\\n  3/1/1 4/1/1\nl 1 2\nf 1 2 3");
    let input = read_back(Format::Obj, text);
    let mesh = &input.surfaces[0].mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    assert_eq!(mesh.positions.get(2), [1.0, 0.0, 1.0], "y up in the file, z up in memory");
    assert_eq!(mesh.normals, None, "some corners have none");
    assert_eq!(input.surfaces.len(), 1);
    assert_eq!(
        input.notes,
        ["OBJ does not say which axis is up; y is taken to be", "the file does not name its unit"]
    );
}

#[test]
fn groups_and_materials_do_not_tear_a_surface() {
    let text = format!("{SQUARE}g a\nusemtl a\nf 1 2 3\ng b\nusemtl b\nf 1 3 4\n");
    let input = read_back(Format::Obj, text);
    assert_eq!(input.surfaces[0].mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(input.surfaces[0].mesh.positions.len(), 4);
}

#[test]
fn objects_may_share_vertices_with_others() {
    let text =
        format!("v 9 9 9\n{SQUARE}o a\nf 2 3 4\no b\nv 5 5 5\nf 2 4 6\nf 6 4 7\no c\nv 7 7 7\n");
    let input = read_back(Format::Obj, text);
    let [a, b, c] = &input.surfaces[..] else { panic!("{:?}", input.surfaces) };
    assert_eq!((a.mesh.positions.len(), &a.mesh.triangles), (3, &vec![[0, 1, 2]]));
    assert_eq!(b.mesh.triangles, [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(b.mesh.positions.get(3), [7.0, -7.0, 7.0], "a vertex from behind comes last");
    assert_eq!((c.name.as_str(), c.mesh.positions.len(), c.mesh.triangles.len()), ("c", 1, 0));
}

#[test]
fn normals_that_differ_within_a_vertex_are_left_out() {
    let text = format!("{SQUARE}vn 0 0 1\nvn 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\nf 1//3 3//3 4//1");
    let same = read_back(Format::Obj, &text);
    assert_eq!(
        same.surfaces[0].mesh.normals,
        Some(vec![[0.0, -1.0, 0.0]; 4]),
        "two numbers, one normal"
    );
    let split = read_back(Format::Obj, text.replace("1//3", "1//2"));
    assert_eq!(split.surfaces[0].mesh.normals, None);
    assert_eq!(split.notes[0], "test: normals differ within a vertex; left out");
}

#[test]
fn vertices_without_colours_have_that_of_their_surface() {
    let text = "v 0 0 0\nv 1 0 0 0 1 0\nv 1 1 0\nv 0 1 0\no a\nf 1 2 3\no b\nf 1 3 4\n";
    let [green, grey] = [[0, 255, 0, 255], [204, 204, 204, 255]].map(Rgba);
    let input = read_back(Format::Obj, text);
    let colors = |k: usize| input.surfaces[k].mesh.attributes.colors.clone();
    assert_eq!((colors(0), colors(1)), (Some(vec![grey, green, grey]), None));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(folder.path().join("a.mtl"), "newmtl red\nKd 1 0 0\n").unwrap();
    fs::write(&path, format!("mtllib a.mtl\n{}", text.replace("o a", "o a\nusemtl red"))).unwrap();
    let red = Rgba([255, 0, 0, 255]);
    let input = read_mesh(&path, &Job::default()).unwrap();
    assert_eq!(input.surfaces[0].mesh.attributes.colors, Some(vec![red, green, red]));
}

#[test]
fn colours_in_bytes_are_said_to_be_beyond() {
    let text = "v 0 0 0 0 0 0\nv 1 0 0 255 31 0\nv 1 1 0 0 1 0\nf 1 2 3\n";
    let says = "1 vertex has a colour with numbers that are not from 0 to 1; cut to that";
    assert_eq!(read_back(Format::Obj, text).notes[0], says);
    let notes = read_back(Format::Obj, text.replace("255 31", "1 0.5")).notes;
    assert_eq!(notes.len(), 2, "{notes:?}");
}

#[test]
fn a_surface_far_from_the_origin_is_read_in_f64() {
    let near = read_back(Format::Obj, format!("{SQUARE}f 1 2 3"));
    assert!(matches!(near.surfaces[0].mesh.positions, Positions::F32(_)));
    let far = read_back(Format::Obj, "v 500000.01 0 0\nv 500001 0 0\nv 500000 1 0\nf 1 2 3");
    assert_eq!(far.surfaces[0].mesh.positions.get(0)[0], 500000.01);
}

#[test]
fn a_fault_is_named_with_its_place() {
    check_fault("# nothing\n", "byte 10: expected a vertex, a face or an object, found none");
    check_fault("v 1 2\n", r#"line 1: expected three coordinates, found "v 1 2""#);
    check_fault("v 1 2 z\n", r#"line 1: expected three coordinates, found "v 1 2 z""#);
    check_fault(
        &format!("{SQUARE}f 1 2"),
        r#"line 5: expected a face of at least 3 corners, found "1 2""#,
    );
    check_fault(
        &format!("{SQUARE}f 1 2 0"),
        r#"line 5: expected corners as v, v/vt, v//vn or v/vt/vn, found "1 2 0""#,
    );
    check_fault(
        &format!("{SQUARE}f 1 2 -5"),
        r#"line 5: expected corners as v, v/vt, v//vn or v/vt/vn, found "1 2 -5""#,
    );
    check_fault(
        &format!("{SQUARE}f 1 2 3\nf 1 2 5\nf 1 2 3"),
        "line 6: expected vertices 1 to 4, found 5",
    );
    check_fault(
        &format!("{SQUARE}vn 0 0 1\nf 1//1 2//1 3//2"),
        "line 6: expected normals 1 to 1, found 2",
    );
}
