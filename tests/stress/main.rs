//! Volumes on which extractors break: ties, extremes, gaps, odd sizes, odd lattices, saddles on the isovalue.
//!
//! Each goes through [`check`], which knows nothing of what the surface should be: it must come out as the
//! reference says, and in every mode closed, two-manifold, oriented, every vertex in its cell and used, every
//! number finite, no triangle flat unless asked for, the inside of all cells what the surface encloses, and the same
//! bytes whoever makes it; its 48 turned and mirrored copies must have the same surface. A machine's vector instructions
//! are compared by `scripts/stress`, which runs the same list through the program.

mod cells;
mod places;
mod saddles;
mod shapes;
mod values;

use cells::{assert_in_cells, is_inside};
use isokit::{
    job::{Job, Threads},
    marching_cubes::{
        Boundary, Budget, Degenerate, Diagonals, ExtractOptions, Placement, Slabs, Source,
        Topology, extract, extract_many, extract_slabs,
    },
    mesh::TriMesh,
    volume::{Bricks, Sample, Slices, View, Volume},
};
use isokit_tests::{
    check::Census, fields::Field, modes::modes, oracle::assert_as_defined, reference::Surface,
    symmetry::assert_symmetric_in_turn, volumes::made,
};
use std::{array::from_fn, num::NonZeroUsize, sync::OnceLock};

/// All options under which the surface must be as the table defines it.
fn options() -> Vec<ExtractOptions> {
    let mut all = vec![];
    for boundary in [Boundary::Closed, Boundary::Open] {
        for degenerate in [Degenerate::Never, Degenerate::Exact] {
            let options = ExtractOptions::DEFAULT.with_topology(Topology::Table);
            let options = options.with_placement(Placement::Linear);
            all.push(options.with_boundary(boundary).with_degenerate(degenerate));
        }
    }
    all
}

/// Asserts all that must hold. Gives the closed surface.
#[track_caller]
fn check<T: Sample>(volume: &Volume<T>, iso: f64) -> Surface {
    check_view(&volume.view(), iso)
}

#[track_caller]
fn check_view<T: Sample>(view: &View<'_, T>, iso: f64) -> Surface {
    for options in modes() {
        let mesh = extract(view, iso, &options, &Job::default()).unwrap();
        let census = Census::of(&mesh);
        assert_eq!(census.faults(), 0, "{options:?}: {census:?}");
        if options.boundary == Boundary::Closed {
            assert_eq!(census.boundary_sides, 0, "{options:?}: {census:?}");
            assert_encloses(&mesh, census.volume);
        }
        assert_beside_crossed(&mesh, view, iso);
        assert_in_cells(view, iso, &options);
        assert_same_bytes(&mesh, view, iso, &options);
        let exact = options.clone().with_degenerate(Degenerate::Exact);
        let exact = extract(view, iso, &exact, &Job::default()).unwrap();
        assert_eq!(Census::of(&exact).faults_of_topology(), 0, "{options:?}");
        assert!(exact.triangles == mesh.triangles, "others if exact, {options:?}");
        let linear = options.clone().with_placement(Placement::Linear);
        let linear = extract(view, iso, &linear, &Job::default()).unwrap();
        assert!(linear.triangles == mesh.triangles, "others than linear, {options:?}");
        let fitted = options.clone().with_diagonals(Diagonals::Fitted);
        let fitted = extract(view, iso, &fitted, &Job::default()).unwrap();
        let found = Census::of(&fitted);
        assert_eq!((found.faults(), found.euler), (0, census.euler), "{options:?}: {found:?}");
        assert!(fitted.positions == mesh.positions, "other vertices if fitted, {options:?}");
    }
    let stored = |ijk: [u64; 3]| view.stored(ijk.map(|i| i as usize));
    assert_symmetric_in_turn(&made(view.dims().map(|n| n as u64), stored), iso);
    let surfaces = options().into_iter().map(|options| {
        let (_, surface) = assert_as_defined(view, iso, &options);
        assert!(options.boundary == Boundary::Open || surface.boundary_sides == 0);
        surface
    });
    surfaces.collect::<Vec<_>>()[0]
}

/// The volume within is above 0, and the flux of x, of y and of z out of the surface are each this volume.
#[track_caller]
fn assert_encloses(mesh: &TriMesh, volume: f64) {
    let Some(bounds) = mesh.bounds() else { return };
    let (mut flux, mut sizes) = ([0.0; 3], [0.0; 3]);
    for &triangle in &mesh.triangles {
        let [p, q, r] = mesh.corners(triangle).map(|c| from_fn(|k| c[k] - bounds.min[k]));
        let [u, v]: [[f64; 3]; 2] = [q, r].map(|c: [f64; 3]| from_fn(|k| c[k] - p[k]));
        for k in 0..3 {
            let [i, j] = [(k + 1) % 3, (k + 2) % 3];
            let part = (p[k] + q[k] + r[k]) * (u[i] * v[j] - u[j] * v[i]) / 6.0;
            flux[k] += part;
            sizes[k] += part.abs();
        }
    }
    assert!(volume > 0.0, "{volume}");
    for (flux, size) in flux.into_iter().zip(sizes) {
        assert!((flux - volume).abs() <= 1e-12 * size.max(volume), "{flux} is not {volume}");
    }
}

/// Each vertex, as it is stored, lies in the closed box of a cell with samples on both sides of the isovalue, but for what
/// f32 rounds where the frame is turned.
#[track_caller]
fn assert_beside_crossed<T: Sample>(mesh: &TriMesh, view: &View<'_, T>, iso: f64) {
    const MARGIN: f64 = 1e-5;
    let index_to_world = view.frame().index_to_world;
    for place in mesh.positions.iter() {
        let place = index_to_world.inverse_point(place);
        let is_crossed = (0..8).any(|side: i64| {
            let reach = |k: usize| if side >> k & 1 == 1 { MARGIN } else { -MARGIN };
            let cell: [i64; 3] = from_fn(|k| (place[k] + reach(k)).floor() as i64);
            let corner = |n: i64| is_inside(view, iso, from_fn(|k| cell[k] + (n >> k & 1)));
            (0..8).any(corner) && !(0..8).all(corner)
        });
        assert!(is_crossed, "{place:?} is in no cell that the surface crosses, iso {iso}");
    }
}

/// On any number of threads, in any size of task, slice by slice and with bricks.
#[track_caller]
fn assert_same_bytes<T: Sample>(
    expected: &TriMesh,
    view: &View<'_, T>,
    iso: f64,
    options: &ExtractOptions,
) {
    for job in jobs() {
        let one = options.clone().with_layers_per_task(NonZeroUsize::MIN);
        let same = bits(&extract(view, iso, &one, job).unwrap()) == bits(expected);
        assert!(same, "{} threads, {options:?}", job.threads.count());
    }
    let least = options.placement.least_window();
    for window in [least, least + 1] {
        let budget = Budget { window, piece_bytes: u64::MAX };
        let slabs = Slabs { isos: &[iso], options, budget };
        let mut mesh = TriMesh::with_normals();
        let source = &mut Slices::new(*view);
        extract_slabs(source, &slabs, &mut vec![mesh.refill()], &Job::default()).unwrap();
        assert!(bits(&mesh) == bits(expected), "a window of {window} slices, {options:?}");
    }
    let bricks = Bricks::of(view, &Job::default()).unwrap();
    let source = Source::with_bricks(view, &bricks).unwrap();
    let mut mesh = TriMesh::with_normals();
    extract_many(source, &[iso], options, &mut [mesh.refill()], &Job::default()).unwrap();
    assert!(bits(&mesh) == bits(expected), "with bricks, {options:?}");
}

/// All numbers of threads that are tried.
fn jobs() -> &'static [Job] {
    static JOBS: OnceLock<Vec<Job>> = OnceLock::new();
    let job = |count| {
        let threads = Threads::new(NonZeroUsize::new(count).unwrap()).unwrap();
        Job { threads, ..Job::default() }
    };
    JOBS.get_or_init(|| [1, 2, 3, 7, 16].map(job).into())
}

/// All bits of a mesh. (Two meshes are equal where 0 and −0 differ; their files are not.)
fn bits(mesh: &TriMesh) -> (Vec<u64>, Vec<u32>, &[[u32; 3]]) {
    let positions = mesh.positions.iter().flatten().map(f64::to_bits);
    let normals = mesh.normals.iter().flatten().flatten().map(|c| c.to_bits());
    (positions.collect(), normals.collect(), &mesh.triangles)
}

fn sampled(field: &Field, points: u64) -> Volume<f64> {
    made([points; 3], |ijk| field(ijk.map(|i| i as f64 * 2.0 / (points - 1) as f64 - 1.0)))
}

fn mesh<T: Sample>(volume: &Volume<T>, iso: f64, options: &ExtractOptions) -> TriMesh {
    extract(&volume.view(), iso, options, &Job::default()).unwrap()
}
