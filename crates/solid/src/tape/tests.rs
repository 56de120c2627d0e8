//! All ways to a value lead to the same one.

use super::{Range, Tape};
use crate::{
    Model, Shape,
    chance::{FORMULAS, boxes, points, trees},
};
use isokit_field::ScalarField;
use isokit_geom::{Aabb, Frame};
use isokit_volume::Grid;
use proptest::prelude::*;

fn tape(shape: &Shape) -> Tape {
    Model::from(shape.clone()).build().expect("a shape").tape().clone()
}

fn ranges(own: Aabb) -> [Range; 3] {
    [0, 1, 2].map(|axis| Range::new(own.min[axis], own.max[axis]))
}

#[track_caller]
fn assert_within(tape: &Tape, own: Aabb, points: &[[f64; 3]]) {
    let range = tape.range(ranges(own));
    let shorter = tape.shortened(ranges(own));
    for &point in points {
        let value = tape.value(point);
        let fits =
            if value.is_nan() { range.none } else { range.low <= value && value <= range.high };
        assert!(fits, "{value} at {point:?} in {own:?} is not in {range:?} of {tape:?}");
        if let Some(shorter) = &shorter {
            assert!(shorter.len() < tape.len());
            let found = shorter.value(point);
            assert_eq!(found.to_bits(), value.to_bits(), "{found}, {value} at {point:?}: {tape:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_value_in_a_box_is_out_of_range_and_fewer_steps_make_the_same_bits(
        shape in trees(true), (own, points) in boxes()
    ) {
        assert_within(&tape(&shape), own, &points);
    }

    #[test]
    fn formulas_keep_to_their_ranges(n in 0..FORMULAS.len(), (own, points) in boxes()) {
        assert_within(&tape(&Shape::Formula(FORMULAS[n].parse().unwrap())), own, &points);
    }

    #[test]
    fn rows_are_the_values_of_each_point_to_the_bit(
        shape in trees(true), width in 1_usize..70, from in 0_usize..9, deep in 1_usize..4,
    ) {
        let points = [from..from + width, 3..3 + deep, from..from + 2];
        let shape = shape.moved([5.0, 2.0, 4.0]);
        let grid = Grid::new([100, 100, 100], Frame::default()).unwrap();
        let placed = Model::from(shape).build().unwrap().placed(&grid);
        let mut values = vec![f64::NAN; width * deep * 2];
        placed.fill(points.clone(), &mut values);
        let [x, y, z] = points;
        let all = z.flat_map(|k| y.clone().flat_map({
            let x = x.clone();
            move |j| x.clone().map(move |i| [i, j, k])
        }));
        for (point, found) in all.zip(values) {
            let value = placed.value(point.map(|c| c as f64));
            assert_eq!(found.to_bits(), value.to_bits(), "{found}, {value} at {point:?}");
        }
    }

    #[test]
    fn derivatives_are_limits_of_differences(shape in trees(true), points in points(12)) {
        let tape = tape(&shape);
        for point in points.into_iter().map(|p| p.map(|c| c + 0.012_345)) {
            let jet = tape.jet(point);
            assert_eq!(jet.value.to_bits(), tape.value(point).to_bits());
            let [x, y, z] = jet.gradient;
            assert_eq!(tape.slope(point).0.map(f64::to_bits), [x, y, z, jet.value].map(f64::to_bits));
            let at = |axis: usize, step: f64| {
                let mut moved = point;
                moved[axis] += step;
                tape.jet(moved)
            };
            for axis in 0..3 {
                let h = 1e-5;
                let near: Vec<_> = [-2.0, -1.0, 1.0, 2.0].map(|n| at(axis, n * h)).into();
                // Only where it is smooth all around: one-sided slopes agree, and curvature is moderate.
                let bent = near.iter().flat_map(|jet| jet.hessian.into_iter().flatten());
                let is_smooth = bent.chain(jet.hessian.into_iter().flatten()).all(|c| c.abs() < 1e2)
                    && near.iter().all(|other| {
                        let apart = (0..3).map(|k| (other.gradient[k] - jet.gradient[k]).abs());
                        apart.fold(0.0, f64::max) < 4e-3
                    });
                if !is_smooth || !jet.value.is_finite() {
                    continue;
                }
                let rise = (near[2].value - near[1].value) / (2.0 * h);
                assert!((rise - jet.gradient[axis]).abs() < 1e-2, "{rise}, {jet:?} at {point:?}");
                for k in 0..3 {
                    let rise = (near[2].gradient[k] - near[1].gradient[k]) / (2.0 * h);
                    let jumps = (near[3].gradient[k] - near[2].gradient[k]) / h - rise;
                    assert!(
                        jumps.abs() > 1.0 || (rise - jet.hessian[axis][k]).abs()
                                < 1e-2 * (1.0 + jet.hessian[axis][k].abs()),
                        "{rise}, {jet:?} at {point:?}"
                    );
                }
            }
        }
    }
}

proptest! {
    #[test]
    fn a_solid_on_a_lattice_is_bounded_and_the_same_within_a_box(
        shape in trees(true), (own, points) in boxes()
    ) {
        let grid = Grid::new([100, 100, 100], Frame::default()).unwrap();
        let placed = Model::from(shape).build().unwrap().placed(&grid);
        let (bounds, within) = (placed.bounds(own), placed.within(own));
        for point in points {
            let value = placed.value(point);
            assert!(value.is_nan() || bounds.contains(value), "{value} is not in {bounds:?}");
            if let Some(within) = &within {
                assert_eq!(within.value(point).to_bits(), value.to_bits());
            }
        }
    }
}

#[test]
fn nothing_is_made_twice() {
    let tape = tape(&Shape::Formula("sin(x*y) + sin(y*x) - (x*y)".parse().unwrap()));
    // x, y, their product, its sine, the sum and the difference; and that what is no number is outside.
    assert_eq!(tape.len(), 8);
}

#[test]
fn far_from_all_others_one_shape_is_left() {
    let ball = Shape::Sphere { radius: 1.0 };
    let balls = (0..50).map(|n| ball.clone().moved([10.0 * f64::from(n), 0.0, 0.0]));
    let union = balls.reduce(Shape::union).unwrap();
    let (tape, one) = (tape(&union), tape(&ball.moved([10.0, 0.0, 0.0])));
    let near = Aabb { min: [9.0, -1.0, -1.0], max: [11.0, 1.0, 1.0] };
    let shorter = tape.shortened(ranges(near)).unwrap();
    assert!(shorter.len() == one.len() && tape.len() > 20 * one.len(), "{shorter:?}");
}

#[test]
fn where_a_formula_has_no_number_is_outside() {
    let tape = tape(&Shape::Formula("max(ln(x), -100) + max(-100, ln(x))".parse().unwrap()));
    let own = Aabb { min: [-2.0, 0.0, 0.0], max: [-1.0, 1.0, 1.0] };
    assert_eq!(tape.value([-1.5, 0.5, 0.5]), f64::NEG_INFINITY);
    assert_within(&tape, own, &[[-1.5, 0.5, 0.5]]);
    let half = Aabb { min: [-2.0, 0.0, 0.0], max: [2.0, 1.0, 1.0] };
    assert_within(&tape, half, &[[-1.5, 0.5, 0.5], [1.5, 0.5, 0.5], [0.0; 3]]);
}
