//! A small volume of any type, any samples and any options: the surface must be what is promised.

use super::bytes::Bytes;
use crate::{check::Census, oracle::assert_as_defined};
use isokit::{
    geom::{Affine, Frame},
    job::Job,
    marching_cubes::{
        Boundary, Degenerate, ExtractError, ExtractOptions, Gradient, Nan, Placement, Topology,
        count, extract as surface,
    },
    volume::{Dtype, Grid, Sample, View, Volume},
};

/// Samples along an axis are at most so many.
const LONGEST: u64 = 9;

/// Makes a volume, an isovalue and options of the bytes, extracts, and looks at the mesh.
///
/// # Panics
///
/// If the surface of a closed boundary is not closed, if any is not two-manifold and oriented, if a triangle
/// has no area where that is promised, if a number is not finite, if a count is not that of the mesh, or if
/// the surface is not the one that the reference describes.
pub fn extract(bytes: &[u8]) {
    let mut bytes = Bytes(bytes);
    let dims = [(); 3].map(|()| 1 + u64::from(bytes.byte()) % LONGEST);
    let frame = Frame { index_to_world: affine(&mut bytes), ..Frame::default() };
    let grid = Grid::new(dims, frame).expect("small");
    let options = options(&mut bytes);
    match bytes.pick(&Dtype::ALL) {
        Dtype::U8 => any_iso(grid, &options, bytes, |word| word as u8),
        Dtype::I8 => any_iso(grid, &options, bytes, |word| word as i8),
        Dtype::U16 => any_iso(grid, &options, bytes, |word| word as u16),
        Dtype::I16 => any_iso(grid, &options, bytes, |word| word as i16),
        Dtype::U32 => any_iso(grid, &options, bytes, |word| word as u32),
        Dtype::I32 => any_iso(grid, &options, bytes, |word| word as i32),
        Dtype::F32 => any_iso(grid, &options, bytes, |word| f32::from_bits(word as u32)),
        Dtype::F64 => any_iso(grid, &options, bytes, f64::from_bits),
    }
}

fn options(bytes: &mut Bytes<'_>) -> ExtractOptions {
    ExtractOptions::DEFAULT
        .with_boundary(bytes.pick(&[Boundary::Closed, Boundary::Open]))
        .with_topology(bytes.pick(&[Topology::Table, Topology::Trilinear]))
        .with_placement(bytes.pick(&[Placement::Linear, Placement::Cubic, Placement::Quintic]))
        .with_gradient(bytes.pick(&[Gradient::Central, Gradient::Matching]))
        .with_degenerate(bytes.pick(&[Degenerate::Never, Degenerate::Exact]))
        .with_nan(bytes.pick(&[Nan::Outside, Nan::Mask, Nan::Error]))
}

/// One of a few lattices: plain, mirrored and stretched, oblique, far away.
fn affine(bytes: &mut Bytes<'_>) -> Affine {
    let made = match bytes.byte() % 4 {
        0 => Affine::axis_aligned([1.0; 3], [0.0; 3]),
        1 => Affine::axis_aligned([-1.0, 1e-3, 50.0], [5.0, -7.0, 0.0]),
        2 => Affine::new([[1.0, 0.5, 0.0], [-0.3, 1.0, 0.2], [0.0, 0.1, 2.0]], [10.0; 3]),
        _ => Affine::axis_aligned([0.1; 3], [6.4e6; 3]),
    };
    made.expect("regular")
}

/// The samples: a few values, which tie, or all that the bytes give; the isovalue one of them or a number.
fn any_iso<T: Sample>(
    grid: Grid,
    options: &ExtractOptions,
    mut bytes: Bytes<'_>,
    sample: impl Fn(u64) -> T,
) {
    let (kind, iso) = (bytes.byte(), bytes.word());
    let count = grid.count() as usize;
    let few: [T; 4] = std::array::from_fn(|_| sample(bytes.word()));
    let samples: Vec<T> = match kind % 2 {
        0 => (0..count).map(|_| bytes.pick(&few)).collect(),
        _ => (0..count).map(|_| sample(bytes.word())).collect(),
    };
    let iso = match kind / 2 % 3 {
        0 => few[0].to_f64(),
        1 => f64::midpoint(few[0].to_f64(), few[1].to_f64()),
        _ => f64::from_bits(iso),
    };
    let volume = Volume::new(grid, samples).expect("as many as the lattice has");
    check(&volume.view(), iso, options);
}

fn check<T: Sample>(view: &View<'_, T>, iso: f64, options: &ExtractOptions) {
    let job = Job::default();
    let mesh = match surface(view, iso, options, &job) {
        Ok(mesh) => mesh,
        Err(ExtractError::Iso(said)) => return assert!(!said.is_finite(), "{said} is finite"),
        Err(ExtractError::Nan { .. }) => return assert_eq!(options.nan, Nan::Error),
        Err(error) => panic!("{error}, {options:?}"),
    };
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
    let counts = count(view, iso, options, &job).expect("what was extracted can be counted");
    assert_eq!(counts, mesh.counts(), "{options:?}");
    if options.topology == Topology::Table && options.placement == Placement::Linear {
        assert_as_defined(view, iso, options);
    }
}
