//! What shapes are: distances, sets, and what is done with them.

mod files;

use super::{Array, Combination, Model, Shape, Solid};
use crate::chance::{points, primitives, trees};
use isokit_geom::vector::{length, sub};
use proptest::prelude::*;
use std::collections::BTreeMap;

fn solid(shape: &Shape) -> Solid {
    Model::from(shape.clone()).build().expect("a shape")
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (1.0 + a.abs().max(b.abs())) || a == b
}

/// Goes along the slope to the surface, by steps as long as the value says. Where values are distances one step does.
fn nearest(solid: &Solid, from: [f64; 3]) -> Option<[f64; 3]> {
    let mut at = from;
    for _ in 0..3 {
        let jet = solid.tape().jet(at);
        let steep = length(jet.gradient);
        if jet.value.abs() < 1e-9 {
            return Some(at);
        }
        if (steep - 1.0).abs() > 1e-6 {
            return None;
        }
        at = [0, 1, 2].map(|k| at[k] - jet.value * jet.gradient[k]);
    }
    None
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_primitive_says_how_far_its_surface_is((shape, is_exact) in primitives(), all in points(30)) {
        let solid = solid(&shape);
        // Nowhere steeper than 1: so no surface is nearer than the value says.
        for pair in all.windows(2) {
            let apart = length(sub(pair[0], pair[1]));
            let rise = (solid.value(pair[0]) - solid.value(pair[1])).abs();
            assert!(rise <= apart * (1.0 + 1e-9) + 1e-9, "{rise} within {apart}: {shape:?}");
        }
        if !is_exact {
            return Ok(());
        }
        // And there is a point of the surface as far away as it says.
        let mut found = 0;
        for &point in &all {
            // In the middle of things there is no one way out.
            if let Some(end) = nearest(&solid, point.map(|c| c + 0.000_1)) {
                let apart = length(sub(end, point.map(|c| c + 0.000_1)));
                let value = solid.value(point.map(|c| c + 0.000_1)).abs();
                assert!((apart - value).abs() < 1e-6, "{apart}, {value} at {point:?}: {shape:?}");
                found += 1;
            }
        }
        assert!(found * 2 > all.len(), "{found} of {}: {shape:?}", all.len());
    }

    #[test]
    fn sets_obey_de_morgan(a in trees(false), b in trees(false), all in points(20), blend in 0.0..2.0_f64) {
        let solids = [&a, &b].map(solid);
        for blend in [0.0, blend] {
            let of = |how| solid(&a.clone().combined(how, b.clone(), blend));
            let [union, intersection, difference] =
                [Combination::Union, Combination::Intersection, Combination::Difference].map(of);
            for &point in &all {
                let [a, b] = solids.each_ref().map(|solid| solid.value(point));
                let bulge = if blend > 0.0 { (blend - (a - b).abs()).max(0.0).powi(2) / (4.0 * blend) } else { 0.0 };
                let found = union.value(point);
                assert!(near(found, a.max(b) + bulge), "{found}, {a}, {b}, {blend}");
                // Beyond the width of the blend it is the sharp one, to the bit.
                assert!((a - b).abs() < blend || found == a.max(b));
                // What is not in both is not in one or not in the other.
                let found = intersection.value(point);
                assert!(near(found, a.min(b) - bulge), "{found}, {a}, {b}, {blend}");
                // A difference is the intersection with what is not in the other.
                let gap = if blend > 0.0 { (blend - (a + b).abs()).max(0.0).powi(2) / (4.0 * blend) } else { 0.0 };
                let found = difference.value(point);
                assert!(near(found, a.min(-b) - gap), "{found}, {a}, {b}, {blend}");
            }
        }
    }

    #[test]
    fn a_shape_with_itself_is_itself(shape in trees(false), all in points(10)) {
        let one = solid(&shape);
        for how in [Combination::Union, Combination::Intersection] {
            let both = solid(&shape.clone().combined(how, shape.clone(), 0.0));
            assert_eq!(both.steps(), one.steps());
            all.iter().for_each(|&p| assert_eq!(both.value(p).to_bits(), one.value(p).to_bits()));
        }
    }

    #[test]
    fn what_is_moved_turned_mirrored_or_scaled_has_the_old_values_elsewhere(
        shape in trees(false), all in points(10), by in [-3.0..3.0_f64, -3.0..3.0, -3.0..3.0],
        degrees in -400.0..400.0_f64, factor in 0.2..3.0_f64,
    ) {
        let old = solid(&shape);
        let moved = solid(&shape.clone().moved(by));
        let scaled = solid(&shape.clone().scaled(factor));
        let mirrored = solid(&Shape::Mirrored { of: shape.clone().into(), normal: [1.0, 0.0, 0.0] });
        let (s, c) = degrees.to_radians().sin_cos();
        let turned = [0, 1, 2].map(|axis| {
            let mut all = [0.0; 3];
            all[axis] = degrees;
            solid(&shape.clone().rotated(all))
        });
        for p in all {
            let value = old.value(p);
            assert!(near(moved.value([0, 1, 2].map(|k| p[k] + by[k])), value));
            assert!(near(scaled.value(p.map(|c| c * factor)), value * factor));
            assert!(near(mirrored.value([-p[0], p[1], p[2]]), value));
            for (axis, turned) in turned.iter().enumerate() {
                let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut image = p;
                (image[i], image[j]) = (c * p[i] - s * p[j], s * p[i] + c * p[j]);
                assert!(near(turned.value(image), value), "{axis}: {shape:?}");
            }
        }
    }

    #[test]
    fn an_array_is_the_union_of_its_copies(shape in trees(false), all in points(10), step in [-2.0..2.0_f64, 0.5..3.0, -1.0..1.0]) {
        let grid = solid(&shape.clone().repeated(Array::Grid { count: [2, 1, 3], step, center: false }));
        let line = solid(&shape.clone().repeated(Array::Linear { count: 3, step, center: true }));
        let ring = solid(&shape.clone().repeated(Array::Polar { count: 4, axis: 2, turn: 90.0 }));
        let old = solid(&shape);
        let greatest = |all: Vec<[f64; 3]>| all.into_iter().map(|p| old.value(p)).fold(f64::MIN, f64::max);
        for p in all {
            let back = |n: [f64; 3]| [0, 1, 2].map(|k| p[k] - n[k] * step[k]);
            let copies = (0..6).map(|n| back([f64::from(n % 2), 0.0, f64::from(n / 2)])).collect();
            assert!(near(grid.value(p), greatest(copies)));
            assert!(near(line.value(p), greatest([-1.0, 0.0, 1.0].map(|n| back([n; 3])).to_vec())));
            let [x, y, z] = p;
            let turns = [[x, y, z], [y, -x, z], [-x, -y, z], [-y, x, z]];
            assert!(near(ring.value(p), greatest(turns.to_vec())));
        }
    }

    #[test]
    fn offsets_and_shells_are_what_they_say(shape in trees(false), all in points(10), by in -1.0..1.0_f64, wall in 0.1..1.0_f64) {
        let old = solid(&shape);
        let offset = solid(&Shape::Offset { of: shape.clone().into(), by });
        let shell = solid(&Shape::Shell { of: shape.into(), thickness: wall });
        for p in all {
            let value = old.value(p);
            assert_eq!(offset.value(p), value + by);
            assert_eq!(shell.value(p), value.min(wall - value));
        }
    }

    #[test]
    fn nothing_of_a_shape_is_outside_of_its_box(shape in trees(false), all in points(60)) {
        let solid = solid(&shape);
        let extent = super::extent::Extents::new(&Default::default()).of(&shape, 0.0).unwrap();
        for p in all {
            let is_within = (0..3).all(|k| extent.min[k] - 1e-9 <= p[k] && p[k] <= extent.max[k] + 1e-9);
            assert!(is_within || solid.value(p) < 1e-9, "{p:?} is not in {extent:?}: {shape:?}");
        }
    }
}

#[test]
fn a_lattice_holds_the_shape_and_two_samples_around_it() {
    for (size, spacing) in [(10.0, 0.5), (10.0, 0.1), (3.3, 0.7)] {
        let shape = Shape::Box { size: [size; 3], round: 0.0 }.moved([1.0, 2.0, 3.0]);
        let grid = solid(&shape).grid([spacing; 3]).unwrap();
        let bounds = grid.bounds();
        for axis in 0..3 {
            let middle = 0.5 * (bounds.min[axis] + bounds.max[axis]);
            assert!((middle - [1.0, 2.0, 3.0][axis]).abs() < 1e-9);
            let around = 0.5 * (bounds.max[axis] - bounds.min[axis] - size) / spacing;
            assert!((1.5 - 1e-9..2.0).contains(&around), "{around}");
        }
    }
}

#[test]
fn what_is_empty_adds_nothing_to_a_box() {
    let ball = Shape::Sphere { radius: 1.0 };
    let gone = Shape::Offset { of: ball.clone().into(), by: -2.0 };
    for union in [ball.clone().union(gone.clone()), gone.clone().union(ball.clone())] {
        assert_eq!(solid(&union).bounds(), solid(&ball).bounds());
    }
    let copies = Array::Linear { count: 3, step: [5.0, 0.0, 0.0], center: false };
    for nothing in [gone.clone().union(gone.clone()), gone.repeated(copies)] {
        let says = solid(&nothing).grid([1.0; 3]).unwrap_err().to_string();
        assert!(says.contains("nothing is left"), "{says}");
    }
}

#[test]
fn where_a_formula_has_no_number_sets_are_what_they_are_in_any_order() {
    let ball = Shape::Sphere { radius: 1.0 };
    let half = Shape::Formula("sqrt(x) - 0.2".parse().unwrap());
    let (without, with) = ([-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]);
    for (a, b) in [(&ball, &half), (&half, &ball)] {
        let both = solid(&a.clone().intersection(b.clone()));
        assert!(both.value(without) < 0.0 && both.value(with) > 0.0);
        let any = solid(&a.clone().combined(Combination::Union, b.clone(), 0.1));
        assert!(any.value(without) == 0.5 && any.value([-2.0, 0.0, 0.0]) < 0.0);
    }
    let rest = solid(&ball.difference(half));
    assert!(rest.value(without) == 0.5 && rest.value(with) < 0.0);
}

#[test]
fn the_corner_of_an_offset_intersection_is_in_its_box() {
    let cut = Shape::Plane { normal: [1.0, 0.0, 0.0], at: 0.0 };
    let ball = Shape::Sphere { radius: 1.0 }.intersection(cut);
    let offset = Shape::Offset { of: ball.into(), by: 0.5 };
    let bounds = solid(&offset).bounds().unwrap();
    assert_eq!((bounds.min, bounds.max), ([-1.5; 3], [0.5, 1.5, 1.5]));
}

/// What a listing makes of a point.
fn read(listing: &str, point: [f64; 3]) -> f64 {
    let (mut numbers, mut last) = (BTreeMap::new(), f64::NAN);
    for line in listing.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let of = |k: usize| -> f64 { numbers[words[k]] };
        last = match words[1] {
            "const" => words[2].parse().unwrap(),
            "var-x" => point[0],
            "var-y" => point[1],
            "var-z" => point[2],
            "neg" => -of(2),
            "abs" => of(2).abs(),
            "sqrt" => of(2).sqrt(),
            "square" => of(2) * of(2),
            "floor" => of(2).floor(),
            "sin" => libm::sin(of(2)),
            "cos" => libm::cos(of(2)),
            "tan" => libm::tan(of(2)),
            "asin" => libm::asin(of(2)),
            "acos" => libm::acos(of(2)),
            "atan" => libm::atan(of(2)),
            "exp" => libm::exp(of(2)),
            "ln" => libm::log(of(2)),
            "atan2" => libm::atan2(of(2), of(3)),
            "add" => of(2) + of(3),
            "sub" => of(2) - of(3),
            "mul" => of(2) * of(3),
            "div" => of(2) / of(3),
            "min" => {
                if of(2) < of(3) {
                    of(2)
                } else {
                    of(3)
                }
            }
            "max" => {
                if of(2) > of(3) {
                    of(2)
                } else {
                    of(3)
                }
            }
            "compare" => f64::from(of(2) > of(3)) - f64::from(of(2) < of(3)),
            "or" => {
                if of(2) == 0.0 {
                    of(3)
                } else {
                    of(2)
                }
            }
            word => panic!("{word}: {listing}"),
        };
        assert!(numbers.insert(words[0], last).is_none(), "{line}: {listing}");
    }
    last
}

#[test]
fn a_listing_has_no_powers_but_squares() {
    let listing = |text: &str| solid(&Shape::Formula(text.parse().unwrap())).listing();
    assert!(listing("x^y").is_none() && listing("x^2").is_some());
}

proptest! {
    #[test]
    fn a_listing_makes_the_same_values(shape in trees(true), points in points(10)) {
        let solid = solid(&shape);
        if let Some(listing) = solid.listing() {
            for point in points {
                let (value, found) = (solid.value(point), read(&listing, point));
                assert!(value == found || value.is_nan() && found.is_nan(), "{value}, {found}: {listing}");
            }
        }
    }
}
