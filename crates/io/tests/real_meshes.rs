//! Meshes that other people's programs wrote, read as an independent reader found them.
//!
//! The files are not part of the project. Where their folder is absent, every test passes and says so.

use isokit_io::{MeshContext, MeshInput, ReadError, read_mesh, write_mesh};
use isokit_job::Job;
use std::path::{Path, PathBuf};

/// The folder, or `None` with one line that says so.
#[expect(clippy::print_stdout, reason = "whoever watches should see that nothing was tested")]
fn data() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: {} is absent", folder.display());
    None
}

fn read(path: &Path) -> Result<MeshInput, ReadError> {
    read_mesh(path, &Job::default())
}

/// Vertices and triangles of all surfaces together.
fn counts(input: &MeshInput) -> [u64; 2] {
    let counts = input.surfaces.iter().map(|surface| surface.mesh.counts());
    counts.fold([0, 0], |[v, t], counts| [v + counts.vertices, t + counts.triangles])
}

/// Vertices and triangles: of PLY and OBJ those of the file, of STL one vertex for each place.
const MESHES: [(&str, [u64; 2]); 22] = [
    ("bunny.ply", [35947, 69451]),
    // The manifest's 3287 vertices are split where texture coordinates differ; the file has these.
    ("cow.obj", [2903, 5804]),
    ("trimesh/20mm-xyz-cube.stl", [132, 260]),
    ("trimesh/7_8ths_cube.stl", [14, 24]),
    ("trimesh/angle_block.STL", [398, 704]),
    ("trimesh/box.STL", [4455, 8954]),
    ("trimesh/busted.STL", [1941, 3878]),
    ("trimesh/fandisk.obj", [2877, 5750]),
    ("trimesh/featuretype.STL", [2010, 3476]),
    ("trimesh/joined_tetrahedra.obj", [9, 8]),
    ("trimesh/multibody.stl", [20, 32]),
    ("trimesh/not_convex.obj", [288, 96]),
    ("trimesh/octagonal_pocket.ply", [1658, 3262]),
    ("trimesh/plate_holes.STL", [618, 1252]),
    ("trimesh/quadknot.obj", [1440, 2880]),
    ("trimesh/rabbit.obj", [644, 1252]),
    ("trimesh/soup.stl", [300, 100]),
    ("trimesh/suzanne.ply", [1966, 968]),
    ("trimesh/teapot.stl", [480, 894]),
    ("trimesh/torus.STL", [4350, 8700]),
    ("trimesh/unit_cube.STL", [8, 12]),
    ("trimesh/unit_sphere.STL", [642, 1280]),
];

#[test]
fn every_mesh_has_the_vertices_and_triangles_that_others_find() {
    let Some(data) = data() else { return };
    for (name, expected) in MESHES {
        let input = read(&data.join("meshes").join(name)).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(counts(&input), expected, "{name}");
    }
}

#[test]
fn what_is_written_is_read_back() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().unwrap();
    for (name, expected) in MESHES {
        let input = read(&data.join("meshes").join(name)).unwrap();
        let context = MeshContext::default();
        for ending in ["glb", "gltf", "obj", "ply", "stl"] {
            let path = folder.path().join(format!("out.{ending}"));
            let written = write_mesh(&path, &input.surfaces, &context, &Job::default());
            let written = written.unwrap_or_else(|error| panic!("{name}: {error}"));
            let found = match ending {
                "ply" | "stl" => {
                    written.files.iter().map(|path| counts(&read(path).unwrap())).collect()
                }
                _ => vec![counts(&read(&path).unwrap())],
            };
            let triangles: u64 = found.iter().map(|[_, triangles]| triangles).sum();
            assert_eq!(triangles, expected[1], "{name} as {ending}");
            if ending != "stl" {
                let vertices: u64 = found.iter().map(|[vertices, _]| vertices).sum();
                assert_eq!(vertices, expected[0], "{name} as {ending}");
            }
        }
    }
}

#[test]
fn a_malformed_mesh_is_an_error_with_its_place_or_lawful_after_all() {
    let Some(data) = data() else { return };
    let malformed = |name: &str| read(&data.join("malformed/mesh").join(name));
    for (name, expected) in [
        ("empty.obj", "OBJ, byte 36: expected a vertex, a face or an object, found none"),
        ("invalid_index.obj", "OBJ, line 12: expected vertices 1 to 6, found 7"),
        (
            "notenoughindices.obj",
            "OBJ, line 9: expected a face of at least 3 corners, found \"1// 2//\"",
        ),
        ("comments.off", "neither content nor name tells the format"),
    ] {
        let error = malformed(name).unwrap_err().to_string();
        assert!(error.contains(&format!("{name}: {expected}")), "{error}");
    }
    for (name, expected) in [
        ("empty.ply", [0, 0]),
        ("empty.stl", [0, 0]),
        ("points_emptyface.ply", [1024, 0]),
        ("negative_indices.obj", [8, 12]),
        ("nancolor.obj", [8, 12]),
    ] {
        assert_eq!(
            counts(&malformed(name).unwrap_or_else(|error| panic!("{error}"))),
            expected,
            "{name}"
        );
    }
}
