//! Angles without arctangents against those with.

use super::{Search, Turns, Windings, solid_angle};
use crate::{
    bvh::Bvh,
    kit::{Chance, ball, cube},
};
use isokit_geom::vector::length;
use std::f64::consts::PI;

#[test]
fn turns_are_sums_of_arguments() {
    let mut chance = Chance(31);
    for round in 0..2000 {
        let (mut turns, mut sum) = (Turns::default(), 0.0);
        for _ in 0..1 + round % 40 {
            // Some close to whole and half turns, and on them.
            let tie = f64::from(chance.below(9)) / 4.0 - 1.0;
            let near = [tie, tie + 1e-15 * chance.number(), chance.number()];
            let angle = PI * near[chance.below(3) as usize].clamp(-1.0, 1.0);
            let (im, re) = angle.sin_cos();
            let weight = f64::from(chance.below(2)) * 2.0 - 1.0;
            let size = chance.number().abs() + 0.01;
            turns.turn([re * size, im * size], weight);
            sum += im.atan2(re) * weight;
        }
        // Half a turn is as well one the other way.
        let turns = (turns.angle() - sum) / (2.0 * PI);
        assert!((turns - turns.round()).abs() < 1e-12, "{turns}");
    }
}

#[test]
fn turns_of_no_half_are_counted() {
    let mut chance = Chance(32);
    for _ in 0..2000 {
        let (mut turns, mut sum) = (Turns::default(), 0.0);
        for _ in 0..30 {
            let angle = 0.999_999 * PI * chance.number();
            turns.turn([angle.cos(), angle.sin()], 1.0);
            sum += angle;
        }
        assert!((turns.angle() - sum).abs() < 1e-12, "{} of {sum}", turns.angle());
    }
    let mut turns = Turns::default();
    (0..64).for_each(|_| turns.turn([1.0, 1.0], 1.0));
    assert!((turns.angle() - 16.0 * PI).abs() < 1e-12);
    (0..96).for_each(|_| turns.turn([1.0, 1.0], -1.0));
    assert!((turns.angle() + 8.0 * PI).abs() < 1e-12);
}

/// How far a point is from a segment.
fn to_segment([a, b]: [[f64; 3]; 2], p: [f64; 3]) -> f64 {
    let at = |t: f64| length([0, 1, 2].map(|k| a[k] + t * (b[k] - a[k]) - p[k]));
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for _ in 0..60 {
        let (x, y) = (low + (high - low) * 0.382, low + (high - low) * 0.618);
        if at(x) < at(y) { high = y } else { low = x }
    }
    at(0.5 * (low + high))
}

#[test]
fn a_search_ends_with_the_sum_of_arctangents() {
    let mut chance = Chance(33);
    let mut on_planes = 0;
    for round in 0..60 {
        let mesh = match round % 3 {
            0 => chance.soup(1 + round),
            1 => isokit_mesh::TriMesh::joined(&[cube(), ball(2 + round as u32 / 6)]).unwrap(),
            _ => cube(),
        };
        let corners: Vec<_> = mesh.triangles.iter().map(|&t| mesh.corners(t)).collect();
        let bvh = Bvh::new(&corners);
        let weights: Vec<f64> = corners.iter().map(|_| f64::from(chance.below(3)) - 1.0).collect();
        let windings = Windings::new(&bvh, weights.clone());
        for _ in 0..60 {
            // Anywhere; in planes of sides; on lines of edges, beyond them.
            let [a, b, c] = corners[chance.below(corners.len() as u32) as usize];
            let [s, t] = [0, 1].map(|_| f64::from(chance.below(17)) / 4.0 - 2.0);
            let beside = [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
            let beyond = [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]));
            let tie = chance.point().map(|c| (c * 6.0).round() / 3.0);
            let point =
                [beside, beyond, tie, chance.point().map(|c| 2.0 * c)][chance.below(4) as usize];
            let is_at_an_edge = corners.iter().any(|&[a, b, c]| {
                [[a, b], [b, c], [c, a]].into_iter().any(|edge| to_segment(edge, point) < 1e-3)
            });
            let angles = bvh.facets().iter().map(|facet| solid_angle(facet, point));
            let angles: Vec<f64> = angles.collect();
            // In a side, half of all directions are on either.
            let is_in_a_side = angles.iter().any(|angle| angle.abs() > 2.0 * PI - 1e-6);
            if is_at_an_edge || is_in_a_side {
                continue;
            }
            on_planes += usize::from(angles.contains(&0.0));
            let sum: f64 = angles.iter().zip(&weights).map(|(angle, weight)| angle * weight).sum();
            let (found, error) = Search::new(&windings, &bvh, point).open(0.0);
            let away = (found - sum / (4.0 * PI)).abs();
            assert!(away < 1e-11, "{point:?}: {found}, not {}", sum / (4.0 * PI));
            assert!(error < 1e-12, "{error}");
            assert!((windings.at(&bvh, point, 0.0).0 - found).abs() < 1e-11);
        }
    }
    assert!(on_planes > 100, "only {on_planes} points are in planes of sides");
}
