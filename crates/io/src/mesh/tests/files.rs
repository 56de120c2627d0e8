//! Files on a disk: names, pairs, several surfaces.

use super::assert_near;
use crate::{
    Format, WriteFault,
    mesh::{
        MeshContext, Written,
        kit::{context, surface, torus},
        read_mesh, write_mesh, write_mesh_to,
    },
};
use isokit_geom::{Space, Unit};
use isokit_job::Job;
use isokit_mesh::{Positions, Rgba, Surface, TriMesh};
use std::{
    fs,
    path::{Path, PathBuf},
};

fn write(path: &Path, surfaces: &[Surface], context: &MeshContext) -> Written {
    write_mesh(path, surfaces, context, &Job::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn three() -> [Surface; 3] {
    let bone = Surface { name: "bone/left".into(), mesh: torus(4), ..Surface::default() };
    let none = Surface { name: "none".into(), ..Surface::default() };
    [surface(6), bone, none]
}

fn names(files: &[PathBuf]) -> Vec<String> {
    files.iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect()
}

#[test]
fn several_surfaces_stand_in_one_file_where_the_format_can() {
    let folder = tempfile::tempdir().unwrap();
    for (name, files) in [
        ("a b.glb", vec!["a b.glb"]),
        ("a b.gltf", vec!["a b.bin", "a b.gltf"]),
        ("a b.obj", vec!["a b.mtl", "a b.obj"]),
    ] {
        let path = folder.path().join(name);
        let written = write(&path, &three(), &context());
        assert_eq!(names(&written.files), files);
        let input = read_mesh(&path, &Job::default()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(input.notes, [""; 0], "{name}");
        assert_eq!(input.surfaces.len(), 3, "{name}");
        for (found, surface) in input.surfaces.iter().zip(three()) {
            assert_eq!((&found.name, found.color), (&surface.name, surface.color), "{name}");
            assert_near(&found.mesh, &surface.mesh, 1e-5);
        }
    }
}

#[test]
fn several_surfaces_stand_beside_each_other_where_it_cannot() {
    let folder = tempfile::tempdir().unwrap();
    for ending in ["ply", "stl"] {
        let written = write(&folder.path().join(format!("head.{ending}")), &three(), &context());
        let expected = ["skin", "bone_left", "none"].map(|name| format!("head_{name}.{ending}"));
        assert_eq!(names(&written.files), expected);
        for (path, surface) in written.files.iter().zip(three()) {
            let input = read_mesh(path, &Job::default()).unwrap();
            assert_near(&input.surfaces[0].mesh, &surface.mesh, 0.0);
        }
    }
    let count = fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(count, 6, "and nothing else");
}

#[test]
fn a_cancelled_job_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let job = Job::default();
    job.cancel.cancel();
    for ending in ["glb", "gltf", "obj", "ply", "stl"] {
        let path = folder.path().join(format!("head.{ending}"));
        let error = write_mesh(&path, &three()[..1], &context(), &job).unwrap_err();
        assert!(matches!(error.fault, WriteFault::Cancelled(_)), "{error}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn one_stream_holds_what_it_can() {
    let to = |format, surfaces: &[Surface]| {
        write_mesh_to(&mut vec![], format, surfaces, &context(), &Job::default())
    };
    let error = to(Format::Ply, &three()).unwrap_err().to_string();
    assert_eq!(error, "PLY holds one surface, not 3; .glb and .obj hold several");
    let error = to(Format::Gltf, &three()).unwrap_err().to_string();
    assert!(error.starts_with("glTF cannot be written as one stream"), "{error}");
    assert!(to(Format::Obj, &three()).is_ok());
}

#[test]
fn an_unknown_ending_is_refused() {
    let error = write_mesh(Path::new("a.off"), &[], &context(), &Job::default()).unwrap_err();
    assert_eq!(error.to_string(), "a.off: a mesh is written as .glb, .gltf, .obj, .ply or .stl");
}

#[test]
fn colours_of_materials_are_read_where_we_did_not_write_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(folder.path().join("m.mtl"), "newmtl red\nKd 1 0 0\nd 0.5\n").unwrap();
    fs::write(
        &path,
        "mtllib m.mtl\nmtllib ../m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3",
    )
    .unwrap();
    let input = read_mesh(&path, &Job::default()).unwrap();
    assert_eq!(input.surfaces[0].color, Some(Rgba([255, 0, 0, 128])));
    assert_eq!(input.surfaces[0].name, "a");
    assert_eq!(input.notes[0], r#"materials "../m.mtl" are not there; read without colours"#);
}

#[test]
fn a_texture_of_a_material_is_not_read_and_a_note_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(folder.path().join("m.mtl"), "newmtl brick\nKd 1 0 0\nmap_Kd brick.png\n").unwrap();
    let notes = |color: &str| {
        let vertices = format!("v 0 0 0{color}\nv 1 0 0{color}\nv 0 1 0{color}\n");
        fs::write(&path, format!("mtllib m.mtl\n{vertices}usemtl brick\nf 1 2 3")).unwrap();
        read_mesh(&path, &Job::default()).unwrap().notes
    };
    let says = r#"the texture of surface "a" is not read, only the colours beside it"#;
    assert_eq!(notes("")[0], says);
    assert!(notes(" 0 1 0").iter().all(|note| note != says), "vertices have colours of their own");
}

#[test]
fn a_packed_file_is_unpacked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ply.gz");
    let plain = folder.path().join("a.ply");
    write(&plain, &[surface(9)], &context());
    let mut encoder = flate2::write::GzEncoder::new(vec![], flate2::Compression::fast());
    std::io::Write::write_all(&mut encoder, &fs::read(&plain).unwrap()).unwrap();
    fs::write(&path, encoder.finish().unwrap()).unwrap();
    let [packed, plain] = [path, plain].map(|path| read_mesh(&path, &Job::default()).unwrap());
    assert_eq!(packed.surfaces, plain.surfaces);
}

#[test]
fn what_f32_merges_is_said_with_a_remedy() {
    let far = 2e6;
    let positions = [[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, 5.0, 0.0]];
    let positions = positions.map(|xyz| xyz.map(|c: f64| c + far)).to_vec();
    let mesh = TriMesh {
        positions: Positions::F64(positions),
        triangles: vec![[0, 1, 2]],
        ..TriMesh::default()
    };
    let surface = Surface { name: "far".into(), mesh, ..Surface::default() };
    let folder = tempfile::tempdir().unwrap();
    for (ending, merged) in [("glb", 1), ("stl", 1), ("ply", 0), ("obj", 0)] {
        let path = folder.path().join(format!("far.{ending}"));
        let context = MeshContext { unit: Unit::Unknown, space: Space::Unknown, ..context() };
        let written = write(&path, std::slice::from_ref(&surface), &context);
        assert_eq!(written.merged_vertices, merged, "{ending}");
        assert_eq!(written.warnings.len(), usize::from(merged > 0), "{ending}");
        if let [warning] = &written.warnings[..] {
            assert!(warning.contains("1 vertex falls on the place of another"), "{warning}");
            assert!(warning.contains(".ply and .obj keep every digit"), "{warning}");
        } else {
            let input = read_mesh(&path, &Job::default()).unwrap();
            assert_eq!(input.surfaces[0].mesh, surface.mesh, "{ending}");
        }
    }
}
