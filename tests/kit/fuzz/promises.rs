//! What must hold of the surface of any volume in any mode: checks that panic.

use crate::{check::Census, oracle::assert_as_defined};
use isokit::{
    job::{Job, Threads},
    marching_cubes::{
        Boundary, Budget, Degenerate, ExtractError, ExtractOptions, Nan, Placement, Slabs, Source,
        Topology, count, extract, extract_many, extract_slabs,
    },
    mesh::TriMesh,
    pipeline::{Scan, SurfaceOptions},
    refine::RefineOptions,
    volume::{AnyVolume, Bricks, Sample, Slices, View},
};
use std::{num::NonZeroUsize, sync::OnceLock};

/// The surface, unless the isovalue or NaN are refused as they should be.
fn whole<T: Sample>(view: &View<'_, T>, iso: f64, options: &ExtractOptions) -> Option<TriMesh> {
    match extract(view, iso, options, &Job::default()) {
        Ok(mesh) => Some(mesh),
        Err(ExtractError::Iso(said)) => {
            assert!(!said.is_finite(), "{said} is finite");
            None
        }
        Err(ExtractError::Nan { .. }) => {
            assert_eq!(options.nan, Nan::Error);
            None
        }
        Err(error) => panic!("{error}, {options:?}"),
    }
}

/// # Panics
///
/// If the surface of a closed boundary is not closed, if any is not two-manifold and oriented, if a triangle
/// has no area where that is promised, if a number is not finite, if a count is not that of the mesh, or if
/// the surface is not the one that the reference describes.
pub fn surface<T: Sample>(view: &View<'_, T>, iso: f64, options: &ExtractOptions) {
    let Some(mesh) = whole(view, iso, options) else { return };
    let census = Census::of(&mesh);
    // A border around cells that are left out may touch itself in a vertex.
    let lawful = if options.nan == Nan::Mask { census.pinched_vertices } else { 0 };
    let faults = match options.degenerate {
        Degenerate::Never => census.faults(),
        Degenerate::Exact => census.faults_of_topology(),
    };
    assert_eq!(faults, lawful, "{census:?}, {options:?}");
    if options.boundary == Boundary::Closed && options.nan != Nan::Mask {
        assert_eq!(census.boundary_sides, 0, "{census:?}, {options:?}");
    }
    let counts = count(view, iso, options, &Job::default()).expect("it was extracted");
    assert_eq!(counts, mesh.counts(), "{options:?}");
    if options.topology == Topology::Table && options.placement == Placement::Linear {
        assert_as_defined(view, iso, options);
    }
}

/// # Panics
///
/// If dividing or balancing changes what is connected, or makes a fault that was not there: two vertices in one place and
/// triangles without area among them.
pub fn refined(volume: &AnyVolume, iso: f64, options: &ExtractOptions, refine: &RefineOptions) {
    let (scan, job) = (Scan::new(volume.clone()), Job::default());
    let extract = options.clone().with_degenerate(Degenerate::Never);
    let surface = SurfaceOptions::default().with_extract(extract);
    // What is refused is looked at in `surface`.
    let Ok(mut mesh) = scan.mesh(iso, &surface.before(refine), &job) else { return };
    let before = Census::of(&mesh);
    let (vertices, says) = (mesh.positions.len() as u64, format!("{refine:?}, {options:?}"));
    let found = scan.refine(iso, &mut mesh, (refine, &surface), &job).expect("a sound mesh");
    let after = Census::of(&mesh);
    assert_eq!(after.faults(), before.pinched_vertices, "{after:?}, {says}");
    let shape = |c: &Census| (c.components, c.euler, c.boundary_sides == 0, c.pinched_vertices);
    assert_eq!(shape(&after), shape(&before), "{says}");
    assert_eq!(found.new_vertices, mesh.positions.len() as u64 - vertices, "{says}");
}

/// # Panics
///
/// If the surface is not the same, byte for byte, on two threads and in small tasks, from `more` slices beyond the fewest at
/// a time, with bricks, and beside another isovalue.
pub fn pieces<T: Sample>(view: &View<'_, T>, iso: f64, options: &ExtractOptions, more: usize) {
    let Some(whole) = whole(view, iso, options) else { return };
    let (expected, job) = (bits(&whole), Job::default());
    let small = options.clone().with_layers_per_task(NonZeroUsize::MIN);
    let threads = extract(view, iso, &small, two_threads()).expect("as with others");
    assert!(bits(&threads) == expected, "two threads, {options:?}");

    let window = options.placement.least_window() + more % 3;
    let budget = Budget { window, piece_bytes: u64::MAX };
    let slabs = Slabs { isos: &[iso], options, budget };
    let mut mesh = TriMesh::with_normals();
    extract_slabs(&mut Slices::new(*view), &slabs, &mut vec![mesh.refill()], &job)
        .expect("as from the whole");
    assert!(bits(&mesh) == expected, "{budget:?}, {options:?}");

    let bricks = Bricks::of(view, &job).expect("small");
    let with_bricks = Source::with_bricks(view, &bricks).expect("its own");
    for (says, source) in [("bricks", with_bricks), ("two isovalues", view.into())] {
        let mut meshes = [TriMesh::with_normals(), TriMesh::with_normals()];
        let mut sinks: Vec<_> = meshes.iter_mut().map(TriMesh::refill).collect();
        extract_many(source, &[0.25, iso], options, &mut sinks, &job).expect("as alone");
        drop(sinks);
        assert!(bits(&meshes[1]) == expected, "{says}, {options:?}");
    }
}

fn two_threads() -> &'static Job {
    static JOB: OnceLock<Job> = OnceLock::new();
    JOB.get_or_init(|| {
        let threads = Threads::new(NonZeroUsize::MIN.saturating_add(1)).expect("two");
        Job { threads, ..Job::default() }
    })
}

/// All bits of a mesh. (Two meshes are equal where 0 and −0 differ; their files are not.)
fn bits(mesh: &TriMesh) -> (Vec<u64>, Vec<u32>, &[[u32; 3]]) {
    let positions = mesh.positions.iter().flatten().map(f64::to_bits);
    let normals = mesh.normals.iter().flatten().flatten().map(|c| c.to_bits());
    (positions.collect(), normals.collect(), &mesh.triangles)
}
