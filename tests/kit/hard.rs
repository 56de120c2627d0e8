//! Values on which decisions hang: the isovalue and its neighbours, zeros, the least and the greatest there are, and what
//! is no number.

use isokit::{
    for_dtype,
    geom::Frame,
    marching_cubes::{
        Boundary, Degenerate, Diagonals, ExtractOptions, Gradient, Nan, Placement, Topology,
    },
    volume::{AnyVolume, Dtype, Grid, Sample, Volume},
};
use proptest::{collection::vec, prelude::*, sample::select};

/// Samples that are hard beside an isovalue, the plain ones first. All are values of the type.
pub fn values(dtype: Dtype, iso: f64) -> Vec<f64> {
    let all = match dtype {
        Dtype::F32 => {
            let tie = iso as f32;
            let (up, down, tiny) = (tie.next_up(), tie.next_down(), f32::from_bits(1));
            let large = [1e38, -1e38, f32::MAX, f32::MIN, f32::INFINITY, f32::NEG_INFINITY];
            let small = [0.0, -0.0, tiny, -tiny, f32::MIN_POSITIVE, f32::MIN_POSITIVE.next_down()];
            let near = [tie, 1.0, -1.0, up, down, up.next_up(), down.next_down(), -tie];
            [&near[..], &small, &large, &[f32::NAN]].concat().into_iter().map(f64::from).collect()
        }
        Dtype::F64 => {
            let (up, down, tiny) = (iso.next_up(), iso.next_down(), f64::from_bits(1));
            let large = [1e300, -1e300, f64::MAX, f64::MIN, f64::INFINITY, f64::NEG_INFINITY];
            let small = [0.0, -0.0, tiny, -tiny, f64::MIN_POSITIVE, f64::MIN_POSITIVE.next_down()];
            let near = [iso, 1.0, -1.0, up, down, up.next_up(), down.next_down(), -iso];
            [&near[..], &small, &large, &[f64::NAN]].concat()
        }
        _ => {
            let ends = [f64::MIN, f64::MAX, -2_147_483_647.0, 4_294_967_294.0];
            let near = [iso, 1.0, -1.0, iso.floor() + 1.0, iso.ceil() - 1.0, 0.0, 127.0, 128.0];
            [&near[..], &ends].concat()
        }
    };
    for_dtype!(dtype, T => all.into_iter().map(|value| Sample::to_f64(value as T)).collect())
}

/// Isovalues that are hard, the plain ones first.
pub const ISOS: [f64; 14] = [
    0.0,
    -0.0,
    1.0,
    0.5,
    127.5,
    -3.0,
    5e-324,
    1e-310,
    1e-45,
    1e300,
    f64::MAX,
    f64::MIN,
    f32::MAX as f64,
    i32::MIN as f64,
];

/// A volume of a type, made of values of that type.
///
/// # Panics
///
/// If there are not as many as the lattice has.
pub fn volume(dtype: Dtype, grid: Grid, values: &[f64]) -> AnyVolume {
    for_dtype!(dtype, T => {
        let samples = values.iter().map(|&value| value as T).collect();
        Volume::<T>::new(grid, samples).expect("one for each place").into()
    })
}

/// Small volumes of all types with an isovalue: mostly ties and near-ties, or all that is hard, or anything.
pub fn volumes() -> impl Strategy<Value = (AnyVolume, f64)> {
    let iso = prop_oneof![4 => select(ISOS.to_vec()), 1 => -1e3..1e3_f64];
    let parts = ([1..7_u64, 1..7_u64, 1..7_u64], select(Dtype::ALL.to_vec()), iso);
    parts.prop_flat_map(|(dims, dtype, iso)| {
        let hard = values(dtype, iso);
        let near = hard[..7].to_vec();
        let value = prop_oneof![5 => select(near), 2 => select(hard), 1 => -2.0..2.0_f64];
        let count = dims.iter().product::<u64>() as usize;
        vec(value, count).prop_map(move |values| {
            let grid = Grid::new(dims, Frame::default()).expect("small");
            (volume(dtype, grid, &values), iso)
        })
    })
}

/// Every choice of how a surface is extracted.
pub fn options() -> impl Strategy<Value = ExtractOptions> {
    let surface = (
        select(vec![Topology::Table, Topology::Trilinear]),
        select(vec![Boundary::Closed, Boundary::Open]),
        select(vec![Nan::Outside, Nan::Mask, Nan::Error]),
    );
    let vertices = (
        select(vec![Placement::Linear, Placement::Cubic, Placement::Quintic]),
        select(vec![Gradient::Central, Gradient::Matching]),
        select(vec![Degenerate::Never, Degenerate::Exact]),
        select(vec![Diagonals::Table, Diagonals::Fitted]),
    );
    (surface, vertices).prop_map(
        |((topology, boundary, nan), (placement, gradient, degenerate, diagonals))| {
            let options = ExtractOptions::DEFAULT.with_topology(topology).with_boundary(boundary);
            let options = options.with_nan(nan).with_placement(placement).with_diagonals(diagonals);
            options.with_gradient(gradient).with_degenerate(degenerate)
        },
    )
}

#[cfg(test)]
mod tests {
    use super::{ISOS, values};
    use isokit::volume::Dtype;

    #[test]
    fn every_type_has_values_on_both_sides_of_what_is_within_it_and_ties() {
        for dtype in Dtype::ALL {
            let found = values(dtype, 1.0);
            let count = |holds: fn(&f64) -> bool| found.iter().filter(|v| holds(v)).count();
            assert!(count(|&v| v == 1.0) > 0 && count(|&v| v < 1.0) > 2, "{dtype:?}");
            assert!(count(|&v| v > 1.0) > 2, "{dtype:?}");
        }
        let floats = values(Dtype::F32, 1.0);
        assert!(floats.contains(&f64::from(1_f32.next_down())) && floats[20].is_nan());
        assert!(floats.contains(&f64::from(f32::from_bits(1))));
        assert!(values(Dtype::F64, 0.5).contains(&0.5_f64.next_up()));
        assert!(ISOS.iter().all(|iso| iso.is_finite()));
    }
}
