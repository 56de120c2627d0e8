//! Lattices on which extractors break, by where they lie: items 13 and 14 of the list.

use crate::{check, mesh, sampled};
use isokit::{
    geom::{Affine, Frame},
    marching_cubes::ExtractOptions,
    mesh::Positions,
};
use isokit_tests::{check::assert_closed, fields};

#[test]
fn lattices_that_are_stretched_tiny_mirrored_or_turned() {
    let mut volume = sampled(&fields::torus(0.6, 0.25), 16);
    let square = 0.5_f64.sqrt();
    let frames = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1e6]],
        [[1e-12, 0.0, 0.0], [0.0, 1e-12, 0.0], [0.0, 0.0, 1e-12]],
        [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]],
        [[square, square, 0.0], [-square, square, 0.0], [0.0, 0.0, 1.0]],
        [[1.0, 0.0, 0.0], [0.9, 1.0, 0.0], [0.0, -3.0, 1.0]],
    ];
    for columns in frames {
        let index_to_world = Affine::new(columns, [0.0; 3]).unwrap();
        volume.set_frame(Frame { index_to_world, ..Frame::default() });
        assert_eq!(check(&volume, 0.0).euler, 0);
        let census = assert_closed(&mesh(&volume, 0.0, &ExtractOptions::DEFAULT));
        assert!(census.volume > 0.0, "outwards, {columns:?}");
    }
}

/// At 6.4e6 the steps of f32 are five samples wide.
#[test]
fn far_from_the_origin_vertices_are_f64_and_lie_as_they_do_near_it() {
    let mut volume = sampled(&fields::gyroid(1.5), 17);
    let far = 6.4e6;
    let mut at = |origin: f64| {
        let index_to_world = Affine::axis_aligned([0.1; 3], [origin; 3]).unwrap();
        volume.set_frame(Frame { index_to_world, ..Frame::default() });
        check(&volume, 0.1);
        mesh(&volume, 0.1, &ExtractOptions::DEFAULT)
    };
    let (near, away) = (at(0.0), at(far));
    assert!(matches!(near.positions, Positions::F32(_)));
    assert!(matches!(away.positions, Positions::F64(_)));
    assert_eq!(near.triangles, away.triangles);
    for (near, away) in near.positions.iter().zip(away.positions.iter()) {
        let off = (0..3).map(|k| (away[k] - far - near[k]).abs()).fold(0.0, f64::max);
        // Half a step of f32 at 1.6, one of f64 at 6.4e6, and what f32 leaves of the root on an edge.
        let least = 2_f64.powi(-24) + 2_f64.powi(-30) + 0.1 * 2_f64.powi(-18);
        assert!(off <= least, "{away:?} is {off:e} off");
    }
    assert_closed(&away);
}
