//! Triangles cut by planes, in space (Sutherland & Hodgman 1974, "Reentrant polygon clipping").
//!
//! Where a side is cut depends on its two ends alone, in the order from what is kept to what is not: so two triangles
//! that share the side share the cut.

use isokit_geom::{Aabb, HalfSpace, vector::Vector};
use isokit_mesh::TriMesh;

/// The box around what planes keep of a mesh's triangles; where there are no planes, around its vertices. What is not
/// finite is passed over, and what names a vertex that is not there.
pub fn kept_bounds(mesh: &TriMesh, clips: &[HalfSpace]) -> Option<Aabb> {
    if clips.is_empty() {
        let is_finite = |place: &Vector| place.iter().all(|c| c.is_finite());
        return Aabb::around(mesh.positions.iter().filter(is_finite));
    }
    let (mut bounds, mut polygon) = (None::<Aabb>, vec![]);
    let is_whole =
        |triangle: &&[u32; 3]| triangle.iter().all(|&v| (v as usize) < mesh.positions.len());
    for triangle in mesh.triangles.iter().filter(is_whole) {
        cut(triangle.map(|vertex| mesh.positions.get(vertex as usize)), clips, &mut polygon);
        for &place in &polygon {
            let point = Aabb { min: place, max: place };
            bounds = Some(bounds.unwrap_or(point).with(place));
        }
    }
    bounds
}

/// What is left of a triangle: a convex polygon, in the triangle's order. Nothing is left of one that is not finite.
pub(super) fn cut(corners: [Vector; 3], halves: &[HalfSpace], polygon: &mut Vec<Vector>) {
    polygon.clear();
    if !corners.as_flattened().iter().all(|number| number.is_finite()) {
        return;
    }
    polygon.extend(corners);
    let mut rest = Vec::with_capacity(polygon.len() + 1);
    for half in halves {
        rest.clear();
        for (n, &from) in polygon.iter().enumerate() {
            let to = polygon[(n + 1) % polygon.len()];
            let [before, after] = [from, to].map(|place| half.beyond(place));
            if before <= 0.0 {
                rest.push(from);
            }
            match (before <= 0.0, after <= 0.0) {
                (true, false) => rest.push(between([from, to], [before, after])),
                (false, true) => rest.push(between([to, from], [after, before])),
                _ => {}
            }
        }
        std::mem::swap(polygon, &mut rest);
        if polygon.is_empty() {
            return;
        }
    }
}

/// The place on the plane between one that is kept and one that is not.
fn between([kept, gone]: [Vector; 2], [before, after]: [f64; 2]) -> Vector {
    let share = before / (before - after);
    std::array::from_fn(|k| kept[k] + share * (gone[k] - kept[k]))
}

#[cfg(test)]
mod tests {
    use super::{cut, kept_bounds};
    use isokit_geom::{
        Aabb, HalfSpace,
        vector::{Vector, length, normal},
    };
    use isokit_mesh::{Positions, TriMesh};

    const TRIANGLE: [Vector; 3] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    fn left_of(corners: [Vector; 3], halves: &[(Vector, f64)]) -> Vec<Vector> {
        let halves: Vec<_> = halves.iter().map(|&(n, d)| HalfSpace::new(n, d).unwrap()).collect();
        let mut polygon = vec![];
        cut(corners, &halves, &mut polygon);
        polygon
    }

    /// The area of a polygon.
    fn area(polygon: &[Vector]) -> f64 {
        let triangles = polygon.windows(2).skip(1);
        triangles.map(|pair| length(normal([polygon[0], pair[0], pair[1]])) / 2.0).sum()
    }

    #[test]
    fn what_is_cut_off_and_what_is_left_make_the_whole() {
        for (direction, offset) in
            [([1.0, 0.0, 0.0], 1.0), ([1.0, 2.0, 0.5], 3.0), ([-1.0, 1.0, 0.0], 0.0)]
        {
            let back = (direction.map(|c: f64| -c), -offset);
            let parts = [(direction, offset), back].map(|half| area(&left_of(TRIANGLE, &[half])));
            assert!((parts[0] + parts[1] - 8.0).abs() < 1e-12 && parts[0] * parts[1] > 0.0);
        }
        let twice = [([1.0, 0.0, 0.0], 1.0), ([0.0, 1.0, 0.0], 1.0)];
        assert_eq!(area(&left_of(TRIANGLE, &twice)), 1.0);
    }

    #[test]
    fn a_side_is_cut_at_the_same_place_from_either_of_its_triangles() {
        let [a, b] = [[0.1, 0.7, 0.3], [5.3, 0.2, -0.9]];
        let half = ([1.0, 0.1, 0.0], 2.0);
        let one = left_of([a, b, [1.0, 3.0, 2.0]], &[half]);
        let other = left_of([b, a, [0.0, -3.0, 1.0]], &[half]);
        let common = one.iter().filter(|place| other.contains(place)).count();
        assert_eq!(common, 2, "{one:?}, {other:?}");
    }

    #[test]
    fn nothing_is_left_of_what_is_beyond_or_not_finite() {
        assert!(left_of(TRIANGLE, &[([0.0, 0.0, 1.0], -1.0)]).is_empty());
        assert!(left_of([[f64::NAN; 3], TRIANGLE[1], TRIANGLE[2]], &[]).is_empty());
        assert_eq!(left_of(TRIANGLE, &[([0.0, 0.0, 1.0], 0.0)]), TRIANGLE);
    }

    #[test]
    fn the_box_of_what_is_left_has_the_cut_in_it_and_not_what_is_cut_off() {
        // Of a large triangle, of which no vertex is left, one that is not finite, and one that is not there.
        let corners = [TRIANGLE[0], TRIANGLE[1], TRIANGLE[2], [f64::NAN, 9.0, 9.0]];
        let mesh = TriMesh {
            positions: Positions::F64(corners.to_vec()),
            triangles: vec![[0, 1, 2], [0, 1, 3], [0, 1, 9]],
            ..TriMesh::default()
        };
        let half = |normal: Vector, offset: f64| HalfSpace::new(normal, offset).unwrap();
        let strip = [
            half([-1.0, 0.0, 0.0], -1.0),
            half([1.0, 0.0, 0.0], 2.0),
            half([0.0, -1.0, 0.0], -0.5),
        ];
        let left = Aabb { min: [1.0, 0.5, 0.0], max: [2.0, 3.0, 0.0] };
        assert_eq!(kept_bounds(&mesh, &strip), Some(left));
        assert_eq!(kept_bounds(&mesh, &[half([0.0, 0.0, 1.0], -1.0)]), None);
        let whole = Aabb { min: [0.0; 3], max: [4.0, 4.0, 0.0] };
        assert_eq!(kept_bounds(&mesh, &[]), Some(whole));
        assert_eq!(kept_bounds(&mesh, &[half([1.0, 0.0, 0.0], 4.0)]), Some(whole));
    }
}
