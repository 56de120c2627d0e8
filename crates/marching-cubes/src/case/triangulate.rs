//! The best way to fill a loop.
//!
//! A loop of three to seven edges has at most 42 triangulations, so all are tried. One that draws a
//! diagonal inside a face of the cell will not do: the cell behind that face may draw the same, and four
//! triangles would share it. Of the *face-safe* rest the one with the greatest least angle wins, measured
//! with each vertex at the middle of its edge; where several share it, the one with the least edges.
//!
//! Angles are compared exactly. The least angle of a triangle is at most 60°, so its cosine is positive
//! and the squared cosine, a ratio of small integers, orders such angles backwards.

use super::polygons::{least_first, triangulations};
use isokit_geom::cube::Edge;
use std::cmp::Ordering;

/// Three edges of a cell, counter-clockwise seen from outside.
pub(crate) type Triangle = [Edge; 3];

/// The face-safe triangulation of `ring` with the greatest least angle, ties to the least edges: each
/// triangle begins with its least edge, and they are in ascending order.
pub(crate) fn best(ring: &[Edge]) -> Vec<Triangle> {
    let candidates = face_safe(ring).into_iter().map(|triangles| {
        let mut triangles: Vec<_> = triangles.into_iter().map(least_first).collect();
        triangles.sort_unstable();
        let sharpest = triangles.iter().map(|&t| Sharpness::of(t)).max();
        (sharpest, triangles)
    });
    let (_, triangles) = candidates.min().expect("every loop has a face-safe triangulation");
    triangles
}

/// The triangulations of `ring` without a diagonal that joins two edges of one face.
pub(crate) fn face_safe(ring: &[Edge]) -> Vec<Vec<Triangle>> {
    let follows = |p, q| (0..ring.len()).any(|i| ring[i] == p && ring[(i + 1) % ring.len()] == q);
    let is_clear = |[p, q]: [Edge; 2]| follows(p, q) || p.common_face(q).is_none();
    let mut found = triangulations(ring);
    found.retain(|triangles| triangles.iter().flat_map(|&t| sides(t)).all(is_clear));
    found
}

/// The directed sides of a triangle.
pub(crate) fn sides([a, b, c]: Triangle) -> [[Edge; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// The middle of an edge, in half cell sizes so that it is whole.
pub(crate) fn middle(edge: Edge) -> [i32; 3] {
    let [a, b] = edge.ends().map(|k| k.offset());
    std::array::from_fn(|axis| (a[axis] + b[axis]) as i32)
}

/// The squared cosine of a triangle's least angle, as a ratio: the greater, the sharper.
#[derive(Clone, Copy, Debug)]
struct Sharpness {
    over: i32,
    under: i32,
}

impl Sharpness {
    fn of(triangle: Triangle) -> Self {
        let [p, q, r] = triangle.map(middle);
        let angles = [[p, q, r], [q, r, p], [r, p, q]].map(|[at, to, and]| {
            let [u, v]: [[i32; 3]; 2] =
                [to, and].map(|end| std::array::from_fn(|axis| end[axis] - at[axis]));
            let dot = |a: [i32; 3], b: [i32; 3]| -> i32 { (0..3).map(|i| a[i] * b[i]).sum() };
            // An obtuse angle counts as a right one: neither is ever the least.
            Self { over: dot(u, v).max(0).pow(2), under: dot(u, u) * dot(v, v) }
        });
        angles.into_iter().max().expect("three angles")
    }
}

impl Ord for Sharpness {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.over * other.under).cmp(&(other.over * self.under))
    }
}

impl PartialOrd for Sharpness {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Sharpness {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Sharpness {}
