//! Shapes, boxes and points by chance, for tests.

use crate::{Array, Combination, Formula, PeriodicSurface, Shape};
use isokit_geom::Aabb;
use proptest::prelude::*;

/// Lengths, halves and wholes often among them, so that faces meet.
fn length() -> impl Strategy<Value = f64> {
    prop_oneof![(1_u32..8).prop_map(|n| f64::from(n) * 0.5), 0.2..4.0_f64]
}

fn place() -> impl Strategy<Value = [f64; 3]> {
    let coordinate = || prop_oneof![(-6_i32..=6).prop_map(|n| f64::from(n) * 0.5), -4.0..4.0_f64];
    [coordinate(), coordinate(), coordinate()]
}

pub(crate) const FORMULAS: [&str; 11] = [
    "4 - x^2 - 2*y^2 - z^2",
    "sin(x) * cos(y) + z / 3",
    "min(x, y, 2 - z) - exp(-abs(x))",
    "1 - abs(mod(x, 2) - 1) - y^3 / 10",
    "atan2(y, x + 5) - tan(z / 8)",
    "ln(4 + x) - sqrt(9 - y) + z^0.5",
    "pow(2, x) - length(x, y, z) + asin(z / 4) - acos(y / 9)",
    "ln(x) + y",
    "pow(2, 900 * x) - pow(3, -y)",
    "x^300 - z",
    "floor(x) + clamp(y, -1, 1) * atan(z) - 0.2 * z^-2",
];

/// A shape that is not made of others. Whether its value is a signed distance is told beside it.
pub(crate) fn primitives() -> impl Strategy<Value = (Shape, bool)> {
    let share = 0.0..=1.0_f64;
    let exact = prop_oneof![
        length().prop_map(|radius| Shape::Sphere { radius }),
        ([length(), length(), length()], share.clone()).prop_map(|(size, share)| {
            let round = 0.5 * share * size[0].min(size[1]).min(size[2]);
            Shape::Box { size, round }
        }),
        (length(), length(), share.clone()).prop_map(|(radius, height, share)| {
            Shape::Cylinder { radius, height, round: share * radius.min(0.5 * height) }
        }),
        (length(), prop_oneof![Just(0.0), length()], length())
            .prop_map(|(radius, top, height)| Shape::Cone { radius, top, height }),
        (length(), share).prop_map(|(radius, share)| {
            Shape::Torus { radius, tube: radius * (0.1 + 0.9 * share) }
        }),
        (place(), place(), length()).prop_map(|(from, to, radius)| Shape::Capsule {
            from,
            to,
            radius
        }),
        (place(), -2.0..2.0_f64).prop_map(|(n, at)| {
            Shape::Plane { normal: if n == [0.0; 3] { [1.0, 2.0, 3.0] } else { n }, at }
        }),
    ];
    let surfaces = prop::sample::select(vec![
        PeriodicSurface::Gyroid,
        PeriodicSurface::SchwarzP,
        PeriodicSurface::SchwarzD,
        PeriodicSurface::Neovius,
        PeriodicSurface::Iwp,
    ]);
    let periodic =
        (surfaces, length(), prop::option::of(length())).prop_map(|(surface, cell, thickness)| {
            Shape::Periodic { surface, cell: 2.0 * cell, thickness }
        });
    prop_oneof![7 => exact.prop_map(|shape| (shape, true)), 2 => periodic.prop_map(|s| (s, false))]
}

fn formulas() -> impl Strategy<Value = Shape> {
    let parsed = |text: &str| Shape::Formula(text.parse::<Formula>().expect("a formula"));
    prop::sample::select(FORMULAS.to_vec()).prop_map(parsed)
}

fn arrays() -> impl Strategy<Value = Array> {
    prop_oneof![
        ([1_u32..3, 1_u32..3, 1_u32..3], place(), any::<bool>())
            .prop_map(|(count, step, center)| Array::Grid { count, step, center }),
        (1_u32..4, place(), any::<bool>()).prop_map(|(count, step, center)| Array::Linear {
            count,
            step,
            center
        }),
        (1_u32..6, 0_u8..3, -90.0..90.0_f64).prop_map(|(count, axis, turn)| Array::Polar {
            count,
            axis,
            turn
        }),
    ]
}

/// A tree of shapes, formulas among them if that is wanted.
pub(crate) fn trees(with_formulas: bool) -> BoxedStrategy<Shape> {
    let leaves = if with_formulas {
        prop_oneof![5 => primitives().prop_map(|(shape, _)| shape), 1 => formulas()].boxed()
    } else {
        primitives().prop_map(|(shape, _)| shape).boxed()
    };
    leaves
        .prop_recursive(4, 24, 3, |inner| {
            let how = prop::sample::select(vec![
                Combination::Union,
                Combination::Intersection,
                Combination::Difference,
            ]);
            let blend = prop_oneof![Just(0.0), length()];
            let turns = [-180.0..180.0_f64, -180.0..180.0, -180.0..180.0];
            prop_oneof![
                4 => (how, prop::collection::vec(inner.clone(), 1..4), blend)
                    .prop_map(|(how, of, blend)| Shape::Combined { how, of, blend }),
                1 => (inner.clone(), -1.0..1.0_f64)
                    .prop_map(|(of, by)| Shape::Offset { of: of.into(), by }),
                1 => (inner.clone(), length())
                    .prop_map(|(of, thickness)| Shape::Shell { of: of.into(), thickness }),
                1 => (inner.clone(), [0.3..2.0_f64, 0.3..2.0, 0.3..2.0])
                    .prop_map(|(of, by)| Shape::Scaled { of: of.into(), by }),
                1 => (inner.clone(), [0.1..1.0_f64, -1.0..1.0, -1.0..1.0])
                    .prop_map(|(of, normal)| Shape::Mirrored { of: of.into(), normal }),
                1 => (inner.clone(), turns).prop_map(|(of, degrees)| of.rotated(degrees)),
                1 => (inner.clone(), place()).prop_map(|(of, by)| of.moved(by)),
                1 => (inner, arrays()).prop_map(|(of, array)| of.repeated(array)),
            ]
        })
        .boxed()
}

/// A box with points in it, its corners among them.
pub(crate) fn boxes() -> impl Strategy<Value = (Aabb, Vec<[f64; 3]>)> {
    let size = prop_oneof![Just(0.0), 0.0..0.5_f64, 0.0..4.0_f64];
    let shares = prop::collection::vec([0.0..=1.0_f64, 0.0..=1.0, 0.0..=1.0], 40);
    (place(), [size.clone(), size.clone(), size], shares).prop_map(|(min, size, shares)| {
        let own = Aabb { min, max: [0, 1, 2].map(|k| min[k] + size[k]) };
        let within = |share: [f64; 3]| {
            [0, 1, 2].map(|k| (min[k] + share[k] * size[k]).clamp(own.min[k], own.max[k]))
        };
        (own, own.corners().into_iter().chain(shares.into_iter().map(within)).collect())
    })
}

/// Points near to the origin.
pub(crate) fn points(count: usize) -> impl Strategy<Value = Vec<[f64; 3]>> {
    prop::collection::vec(place(), count)
}
