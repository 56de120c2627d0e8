//! Meshes to write, and files to read that never were on a disk.

use super::{
    MeshContext, MeshInput, Written,
    input::{MeshFile, understand},
    write_mesh_to,
};
use crate::{Format, ReadError};
use isokit_geom::{Space, Unit};
use isokit_job::Job;
use isokit_mesh::{Positions, Rgba, Surface, TriMesh};
use std::path::Path;

/// The formats that one stream can hold.
pub(super) const STREAMS: [Format; 4] = [Format::Glb, Format::Obj, Format::Ply, Format::Stl];

/// A context of which nothing is a default.
pub(super) fn context() -> MeshContext {
    let command = "isokit extract head.nii -o head.glb".to_owned();
    MeshContext { unit: Unit::Millimetre, space: Space::Ras, command, gltf_unit: None }
}

/// A torus of `n` × `n` vertices with its normals, away from the origin.
pub(super) fn torus(n: u32) -> TriMesh {
    let turn = |i: u32| f64::from(i) / f64::from(n) * std::f64::consts::TAU;
    let places = (0..n).flat_map(|i| (0..n).map(move |j| (turn(i), turn(j))));
    let normals = places.map(|(u, v)| [v.cos() * u.cos(), v.cos() * u.sin(), v.sin()]);
    let normals: Vec<_> = normals.collect();
    let positions = normals.iter().zip((0..n).flat_map(|i| (0..n).map(move |_| turn(i))));
    let positions = positions.map(|(normal, u)| {
        let middle = [50.0 * u.cos(), 50.0 * u.sin(), 0.0];
        std::array::from_fn(|k| ([10.0, 20.0, 30.0][k] + middle[k] + 20.0 * normal[k]) as f32)
    });
    let positions = Positions::F32(positions.collect());
    let number = |i: u32, j: u32| (i % n) * n + j % n;
    let triangles = (0..n).flat_map(|i| {
        (0..n).flat_map(move |j| {
            let [a, b] = [number(i, j), number(i + 1, j)];
            let [c, d] = [number(i + 1, j + 1), number(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
    });
    let triangles = triangles.collect();
    let normals = Some(normals.into_iter().map(|normal| normal.map(|c| c as f32)).collect());
    TriMesh { positions, normals, triangles, ..TriMesh::default() }
}

/// The torus as a translucent surface.
pub(super) fn surface(n: u32) -> Surface {
    let (color, iso) = (Some(Rgba([216, 165, 128, 128])), Some(-300.5));
    Surface { name: "skin".to_owned(), color, iso, mesh: torus(n) }
}

/// A stream of surfaces.
pub(super) fn written(
    format: Format,
    surfaces: &[Surface],
    context: &MeshContext,
) -> (Vec<u8>, Written) {
    let mut bytes = vec![];
    let written = write_mesh_to(&mut bytes, format, surfaces, context, &Job::default());
    (bytes, written.unwrap_or_else(|error| panic!("{format}: {error}")))
}

/// Reads bytes as a file named `test`.
pub(super) fn read(format: Format, bytes: impl AsRef<[u8]>) -> Result<MeshInput, ReadError> {
    let (path, bytes, job) = (Path::new("test"), bytes.as_ref(), Job::default());
    understand(MeshFile { path, format, bytes, job: &job })
}

/// Reads bytes that are in order.
#[track_caller]
pub(super) fn read_back(format: Format, bytes: impl AsRef<[u8]>) -> MeshInput {
    read(format, bytes).unwrap_or_else(|error| panic!("{error}"))
}

/// What reading says of bytes that are not.
#[track_caller]
pub(super) fn fault(format: Format, bytes: impl AsRef<[u8]>) -> String {
    match read(format, bytes) {
        Ok(input) => panic!("read as {input:?}"),
        Err(error) => error.to_string(),
    }
}
