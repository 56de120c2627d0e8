//! Meshes that become distances.

use crate::{Failure, timed};
use isokit::{
    geom::{Affine, Frame},
    io::read_mesh,
    job::Job,
    mesh::{TriMesh, weld_exact},
    solid::{MeshSolid, SolidOptions, VoxelOptions, voxelize},
    volume::{AnyVolume, Grid},
};
use serde::Deserialize;
use std::path::Path;

/// Where samples are, and how far distances are told.
#[derive(Debug, Deserialize)]
pub(super) struct Around {
    dims: [u64; 3],
    spacing: f64,
    origin: [f64; 3],
    band: Option<f64>,
}

/// The first surface of a file, its vertices in the same place made one.
pub(super) fn read(path: &Path) -> Result<TriMesh, Failure> {
    let job = Job::default();
    let read = read_mesh(path, &job)?;
    let first = read.surfaces.first().ok_or("there is no surface")?;
    Ok(weld_exact(&first.mesh, &job)?.mesh)
}

/// Seconds from a mesh in memory on, and the distances.
pub(super) fn distances(
    mesh: &TriMesh,
    around: &Around,
    job: &Job,
) -> Result<(f64, AnyVolume), Failure> {
    let index_to_world = Affine::axis_aligned([around.spacing; 3], around.origin)?;
    let grid = Grid::new(around.dims, Frame { index_to_world, ..Frame::default() })?;
    let mut options = VoxelOptions::default();
    options.band = around.band;
    let work = || -> Result<AnyVolume, Failure> {
        let solid = MeshSolid::new(mesh, SolidOptions::default(), job)?;
        Ok(voxelize(&solid, grid, &options, job)?)
    };
    let (seconds, made) = timed(work);
    Ok((seconds, made?))
}
