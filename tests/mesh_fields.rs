//! Meshes as fields: what is made of fields is made of them too.

use isokit::{
    field::{FieldSamples, ScalarField},
    geom::{Space, Unit},
    job::Job,
    mesh::{Positions, TriMesh, topology},
    pipeline::{Scan, SurfaceOptions, refine_on, sparse_meshes_into},
    refine::{Isosurface, RefineOptions},
    solid::{MeshSolid, SolidOptions, VoxelOptions, grid_around, voxelize},
    volume::Grid,
};
use isokit_tests::{fields, volumes};

/// A cube of side 2, turned so that no face lies along the axes.
fn cube() -> TriMesh {
    let rows = [[2.0, -1.0, 2.0], [2.0, 2.0, -1.0], [-1.0, 2.0, 2.0]];
    let corner = |k: u32| {
        let p = [0, 1, 2].map(|axis| f64::from(2 * (k >> axis & 1)) - 1.0);
        rows.map(|row: [f64; 3]| (row[0] * p[0] + row[1] * p[1] + row[2] * p[2]) / 3.0)
    };
    let sides =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    TriMesh {
        positions: Positions::F64((0..8).map(corner).collect()),
        triangles: sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..TriMesh::default()
    }
}

/// A ring with a piece missing.
fn open() -> TriMesh {
    let scan = Scan::new(volumes::cube(&fields::torus(0.6, 0.25), 21));
    let mut mesh = scan.mesh(0.0, &SurfaceOptions::default(), &Job::default()).unwrap();
    mesh.triangles.drain(..mesh.triangles.len() / 9);
    mesh
}

fn solid(mesh: &TriMesh) -> MeshSolid {
    MeshSolid::new(mesh, SolidOptions::default(), &Job::default()).unwrap()
}

fn around(solid: &MeshSolid, spacing: f64) -> Grid {
    grid_around(solid.bounds(), [spacing; 3], 2, Unit::Unknown, Space::Unknown).unwrap()
}

#[test]
fn the_surface_of_a_mesh_s_field_is_that_of_its_voxels_byte_for_byte() {
    let (job, options) = (Job::default(), SurfaceOptions::default());
    for mesh in [cube(), open()] {
        let solid = solid(&mesh);
        let grid = around(&solid, 0.03);
        let voxels = voxelize(&solid, grid, &VoxelOptions::default(), &job).unwrap();
        for iso in [0.0, 0.1, -0.05] {
            let whole = Scan::new(voxels.clone()).mesh(iso, &options, &job).unwrap();
            let field = solid.placed(&grid);
            let samples = FieldSamples::<f32>::new(&field, grid.frame).unwrap();
            let mut sparse = [TriMesh::default()];
            sparse_meshes_into(&samples, &[iso], &options, &mut sparse, &job).unwrap();
            assert!(whole.triangles.len() > 1000);
            assert!(sparse[0] == whole, "{iso}: {} triangles", whole.triangles.len());
        }
    }
}

#[test]
fn a_mesh_that_is_made_again_has_its_creases() {
    let (job, surface) = (Job::default(), SurfaceOptions::default());
    let solid = solid(&cube());
    let grid = around(&solid, 0.11);
    let field = solid.placed(&grid);
    let voxels = voxelize(&solid, grid, &VoxelOptions::default(), &job).unwrap();
    let options = RefineOptions::DEFAULT.with_creases(30.0);
    let mut made = Scan::new(voxels).mesh(0.0, &surface.before(&options), &job).unwrap();
    let off = |mesh: &TriMesh| (topology(mesh, &job).unwrap().measure.volume / 8.0 - 1.0).abs();
    let before = off(&made);
    let isosurface = Isosurface { field: &field, iso: 0.0 };
    let refined = refine_on(&isosurface, &mut made, (&options, &surface), &job).unwrap();
    assert!(refined.creased > 100, "{refined:?}");
    assert!(topology(&made, &job).unwrap().shortfalls().is_empty());
    assert!(off(&made) < 0.02 * before, "{:e} of {before:e}", off(&made));
    for place in made.positions.iter() {
        let value = field.value(grid.frame.index_to_world.inverse_point(place));
        assert!(value.abs() < 1e-5, "{place:?}: {value}");
    }
}
