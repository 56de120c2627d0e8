//! The same samples give the same bytes, whoever computes them, in whatever pieces, from whatever layout.

use isokit::{
    geom::{Affine, Frame},
    job::{Job, Threads},
    marching_cubes::{
        Boundary, Diagonals, ExtractOptions, Gradient, Nan, Placement, Topology, extract,
        extract_into,
    },
    mesh::TriMesh,
    volume::{Grid, Sample, View, Volume},
};
use isokit_tests::{chance::Chance, fields};
use std::num::NonZeroUsize;

/// Part gyroid, part chance, in an oblique frame, with a hole without values.
fn volume(dims: [u64; 3]) -> Volume<f32> {
    let columns = [[0.9, 0.1, 0.0], [-0.1, 0.8, 0.2], [0.3, 0.0, 1.3]];
    let index_to_world = Affine::new(columns, [10.0, -20.0, 30.0]).unwrap();
    let grid = Grid::new(dims, Frame { index_to_world, ..Frame::default() }).unwrap();
    let (gyroid, mut chance) = (fields::gyroid(3.0), Chance::new(5));
    let at = |n: u64| {
        let ijk = [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]];
        let smooth = gyroid(ijk.map(|i| i as f64 / 20.0 - 1.0));
        match ijk[0] {
            7 if ijk[1] == 9 => f32::NAN,
            0..40 => smooth as f32,
            _ => (smooth + chance.unit() * 2.0 - 1.0) as f32,
        }
    };
    Volume::new(grid, (0..grid.count()).map(at).collect()).unwrap()
}

fn options() -> [ExtractOptions; 9] {
    let default = || ExtractOptions::DEFAULT;
    let linear = || default().with_placement(Placement::Linear);
    [
        default(),
        default().with_boundary(Boundary::Open),
        default().with_nan(Nan::Mask),
        default().with_placement(Placement::Cubic).with_gradient(Gradient::Matching),
        default().with_gradient(Gradient::Matching).with_boundary(Boundary::Open),
        linear(),
        linear().with_topology(Topology::Table).with_nan(Nan::Mask),
        default().with_topology(Topology::Table).with_placement(Placement::Cubic),
        default().with_diagonals(Diagonals::Fitted).with_nan(Nan::Mask),
    ]
}

/// All bits of a mesh. (Two meshes are equal where 0 and −0 differ; their files are not.)
fn bits(mesh: &TriMesh) -> Vec<u64> {
    let positions = mesh.positions.iter().flatten().map(f64::to_bits);
    let normals = mesh.normals.iter().flatten().flatten().map(|c| u64::from(c.to_bits()));
    let triangles = mesh.triangles.iter().flatten().map(|&v| u64::from(v));
    positions.chain(normals).chain(triangles).collect()
}

fn of<T: Sample>(view: &View<'_, T>, options: &ExtractOptions, job: &Job) -> Vec<u64> {
    let mesh = extract(view, 0.1, options, job).unwrap();
    assert!(mesh.triangles.len() > 1000, "{} show nothing", mesh.triangles.len());
    bits(&mesh)
}

#[test]
fn any_number_of_threads_and_any_size_of_task_and_a_second_run() {
    let volume = volume([70, 31, 37]);
    for options in options() {
        let expected = of(&volume.view(), &options, &Job::default());
        assert!(expected == of(&volume.view(), &options, &Job::default()), "a second run");
        for threads in [1, 2, 3, 7] {
            let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
            let job = Job { threads, ..Job::default() };
            for layers in [1, 3, 16, 1000] {
                let options =
                    options.clone().with_layers_per_task(NonZeroUsize::new(layers).unwrap());
                let same = expected == of(&volume.view(), &options, &job);
                assert!(same, "{} threads, {layers} layers", job.threads.count());
            }
        }
    }
}

#[test]
fn memory_that_was_used_before() {
    let volume = volume([70, 31, 37]);
    let mut mesh = TriMesh::with_normals();
    for iso in [-0.5, 0.1, 5.0, 0.1] {
        for options in options() {
            let expected = extract(&volume.view(), iso, &options, &Job::default()).unwrap();
            let job = Job::default();
            extract_into(&volume.view(), iso, &options, &mut mesh.refill(), &job).unwrap();
            assert!(bits(&mesh) == bits(&expected), "iso {iso}, {options:?}");
        }
    }
}

#[test]
fn a_view_in_any_order_of_axes_is_as_good_as_a_copy() {
    let whole = volume([70, 31, 37]);
    let strides = [1, 70, 70 * 31_isize];
    let samples = whole.samples();
    for order in [[0, 1, 2], [1, 0, 2], [2, 1, 0], [1, 2, 0]] {
        for mirrored in [false, true] {
            let dims = order.map(|axis| whole.grid().dims()[axis]);
            let grid = Grid::new(dims, whole.grid().frame).unwrap();
            let sign = if mirrored { -1 } else { 1 };
            let first = if mirrored { samples.len() - 1 } else { 0 };
            let strides = order.map(|axis| sign * strides[axis]);
            let view = View::strided(samples, first, strides, &grid).unwrap();
            let copy = copied(&view);
            for options in options() {
                let same = of(&view, &options, &Job::default())
                    == of(&copy.view(), &options, &Job::default());
                assert!(same, "{order:?}, mirrored: {mirrored}");
            }
        }
    }
}

#[test]
fn a_part_of_a_view_is_as_good_as_a_copy() {
    let whole = volume([70, 31, 37]);
    let part = whole.view().part([3..69, 5..30, 2..20]).unwrap();
    let copy = copied(&part);
    for options in options() {
        let same =
            of(&part, &options, &Job::default()) == of(&copy.view(), &options, &Job::default());
        assert!(same);
    }
}

/// The same samples without gaps, read one by one.
fn copied(view: &View<'_, f32>) -> Volume<f32> {
    let [nx, ny, nz] = view.dims();
    let points = (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])));
    Volume::new(view.grid(), points.map(|ijk| view.stored(ijk)).collect()).unwrap()
}

#[test]
fn a_mirrored_volume_has_its_vertices_at_mirrored_places() {
    let plain = volume([40, 20, 20]);
    let [nx, ny, nz] = [40, 20, 20_isize];
    let grid = Grid::new([40, 20, 20], Frame::default()).unwrap();
    let there = View::new(plain.samples(), &grid).unwrap();
    let strides = [-1, nx, nx * ny];
    let back = View::strided(plain.samples(), nx as usize - 1, strides, &grid).unwrap();
    let places = |view: &View<'_, f32>, mirror: f64, placement| {
        let options = ExtractOptions::DEFAULT.with_boundary(Boundary::Open);
        let options = options.with_placement(placement);
        let mesh = extract(view, 0.1, &options, &Job::default()).unwrap();
        let at = |[x, y, z]: [f64; 3]| [(nx - 1) as f64 * mirror + x * (1.0 - 2.0 * mirror), y, z];
        let mut places: Vec<_> = mesh.positions.iter().map(at).collect();
        places.sort_by(|a, b| a.partial_cmp(b).unwrap());
        places
    };
    for placement in [Placement::Linear, Placement::Cubic, Placement::Quintic] {
        let (there, back) = (places(&there, 0.0, placement), places(&back, 1.0, placement));
        assert!(nz > 1 && there.len() == back.len() && there.len() > 1000);
        // The cut itself is the same; the place, a sum with the sample's number, may round differently.
        let off = there.iter().flatten().zip(back.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) <= 4.0e-6);
    }
}
