//! A volume of any type, any samples, an isovalue and options, all made of bytes.

use super::bytes::Bytes;
use crate::hard;
use isokit::{
    for_dtype,
    geom::{Affine, Frame},
    marching_cubes::{
        Boundary, Degenerate, Diagonals, ExtractOptions, Gradient, Nan, Placement, Topology,
    },
    volume::{AnyVolume, Dtype, Grid, Sample},
};

/// What the bytes say.
pub(super) struct Made {
    pub(super) volume: AnyVolume,
    pub(super) iso: f64,
    pub(super) options: ExtractOptions,
    /// For what else is to be chosen.
    pub(super) choice: u8,
}

impl Made {
    /// With at most so many samples along each axis.
    pub(super) fn of(bytes: &[u8], longest: [u64; 3]) -> Self {
        let mut bytes = Bytes(bytes);
        let dims = longest.map(|longest| 1 + u64::from(bytes.byte()) % longest);
        let frame = Frame { index_to_world: affine(&mut bytes), ..Frame::default() };
        let grid = Grid::new(dims, frame).expect("small");
        let options = options(&mut bytes);
        let (choice, dtype) = (bytes.byte(), bytes.pick(&Dtype::ALL));
        let diagonals = [Diagonals::Table, Diagonals::Fitted][usize::from(choice >> 7)];
        let options = options.with_diagonals(diagonals);
        let (values, iso) = samples(dtype, grid.count(), bytes);
        Self { volume: hard::volume(dtype, grid, &values), iso, options, choice }
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

/// The samples: a few values, which tie, or all that the bytes give, or such as are hard; the isovalue one of them, or
/// between two, or a hard one, or any number.
fn samples(dtype: Dtype, count: u64, mut bytes: Bytes<'_>) -> (Vec<f64>, f64) {
    let any = |bytes: &mut Bytes<'_>| {
        let word = bytes.word();
        match dtype {
            Dtype::F32 => f64::from(f32::from_bits(word as u32)),
            Dtype::F64 => f64::from_bits(word),
            _ => for_dtype!(dtype, T => Sample::to_f64(word as T)),
        }
    };
    let (kind, iso) = (bytes.byte(), bytes.word());
    let few: [f64; 4] = std::array::from_fn(|_| any(&mut bytes));
    let iso = match kind / 3 % 4 {
        0 => few[0],
        1 => f64::midpoint(few[0], few[1]),
        2 => hard::ISOS[(iso % hard::ISOS.len() as u64) as usize],
        _ => f64::from_bits(iso),
    };
    let hard = hard::values(dtype, iso);
    let mut value = |_| match kind % 3 {
        0 => bytes.pick(&few),
        1 => any(&mut bytes),
        _ => bytes.pick(&hard),
    };
    ((0..count).map(&mut value).collect(), iso)
}
