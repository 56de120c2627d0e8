//! How far an extraction says that it is.

use crate::{
    Boundary, Budget, Diagonals, ExtractOptions, Slabs, extract, extract_many, extract_slabs,
};
use isokit_geom::Frame;
use isokit_job::Job;
use isokit_mesh::TriMesh;
use isokit_volume::{Grid, Slices, Volume};

/// Triangles for several tasks.
fn waves() -> Volume<f32> {
    let dims = [50, 40, 45];
    let grid = Grid::new(dims, Frame::default()).unwrap();
    let value = |n: u64| {
        let [x, y, z] = [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]];
        (0.6 * x as f32).sin() * (0.5 * y as f32).cos() + (0.5 * z as f32).sin()
    };
    Volume::new(grid, (0..grid.count()).map(value).collect()).unwrap()
}

#[track_caller]
fn assert_over(job: &Job, phase: &str, how: &str) {
    let now = job.progress.snapshot();
    assert_eq!((now.phase, now.done), (phase, now.total), "{how}");
}

#[track_caller]
fn check(isos: &[f64], options: &ExtractOptions) {
    let (volume, job) = (waves(), Job::default());
    // The first has memory that does not suffice: a sweep fills a part of it.
    let smaller = extract(&volume.view(), 1.4, options, &Job::default()).unwrap();
    assert!(!smaller.triangles.is_empty());
    let mut meshes = vec![TriMesh::with_normals(); isos.len()];
    meshes[0] = smaller;
    for memory in ["little", "used"] {
        let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
        extract_many(&volume.view(), isos, options, &mut sinks, &job).unwrap();
        assert_over(&job, "extract", &format!("{memory} memory, {isos:?}, {options:?}"));
    }
    let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
    let slabs = Slabs { isos, options, budget: Budget { window: 11, piece_bytes: u64::MAX } };
    extract_slabs(&mut Slices::new(volume.view()), &slabs, &mut sinks, &job).unwrap();
    assert_over(&job, "extract", &format!("slabs, {isos:?}, {options:?}"));
}

#[test]
fn progress_ends_where_it_was_said_to() {
    for boundary in [Boundary::Open, Boundary::Closed] {
        for diagonals in [Diagonals::Table, Diagonals::Fitted] {
            let options = ExtractOptions::DEFAULT.with_boundary(boundary).with_diagonals(diagonals);
            check(&[0.1], &options);
            check(&[0.1, -0.3], &options);
            check(&[9.0], &options); // nowhere
            check(&[0.1, 9.0], &options);
        }
    }
}
