//! Points of tiles, and triangles that are not looked at against all of them.

use super::{NONE, Seen, Smoothing, TILE, Tile, cover, key, triangle_of};
use crate::{
    Camera, Projection, Size,
    raster::{Drawn, Paint, Painted, bins::Bins, screen::Viewport},
};
use isokit_geom::{HalfSpace, vector::Vector};
use isokit_job::Job;
use isokit_mesh::{Positions, TriMesh};
use std::num::NonZeroU32;

fn seen(x: i32, y: i32) -> Seen {
    Seen { place: [x, y], depth: 1.0 }
}

/// How often each point of the first tile is in one of the triangles.
fn hits(triangles: &[[Seen; 3]], smoothing: Smoothing) -> Vec<u32> {
    let points = smoothing.points();
    let mut hits = vec![0; TILE[0] * TILE[1] * points.len()];
    for &corners in triangles {
        cover(&points, [0, 0], corners, |point, _| hits[point] += 1);
    }
    hits
}

#[test]
fn triangles_around_a_vertex_share_no_point_and_leave_none_out() {
    let rim = [(0, 0), (4096, 0), (8192, 0), (8192, 4096), (5000, 4096), (0, 4096), (0, 128)];
    // The middle itself is a point, and points are on edges from it.
    for middle in [(4096 + 128, 2048 + 128), (32, 96), (1999, 1), (128, 128)] {
        let fan = (0..rim.len()).map(|n| {
            let [a, b] = [rim[n], rim[(n + 1) % rim.len()]].map(|(x, y)| seen(x, y));
            let [a, b] = if n % 2 == 0 { [a, b] } else { [b, a] };
            [a, b, seen(middle.0, middle.1)]
        });
        let fan: Vec<_> = fan.collect();
        for smoothing in [Smoothing::None, Smoothing::Four, Smoothing::Sixteen] {
            assert!(hits(&fan, smoothing).into_iter().all(|n| n == 1), "{middle:?}");
        }
    }
}

#[test]
fn no_two_points_of_a_pixel_are_in_a_row_or_column() {
    for (smoothing, count) in [(Smoothing::None, 1), (Smoothing::Four, 4), (Smoothing::Sixteen, 16)]
    {
        let points = smoothing.points();
        assert_eq!(points.len(), count);
        for axis in [0, 1] {
            let mut ends: Vec<_> = points.iter().map(|point| point[axis]).collect();
            ends.sort_unstable();
            let expected: Vec<_> =
                (0..count as i32).map(|n| (2 * n + 1) * 128 / count as i32).collect();
            assert_eq!(ends, expected);
        }
    }
}

#[test]
fn keys_are_in_the_order_of_depth_and_then_of_triangles() {
    let depths = [f32::MIN, -2.0, -1e-30, -0.0, 0.0, 1e-40, 3.0, f32::MAX, f32::INFINITY];
    let keys = depths.map(|depth| key(depth, 7));
    assert!(keys.is_sorted());
    assert!(key(3.0, 7) < key(3.0, 8) && key(3.0, u32::MAX) < key(3.0_f32.next_up(), 0));
    assert_eq!(triangle_of(keys[3]), 7);
}

#[test]
fn depth_changes_linearly_from_corner_to_corner() {
    let corners = [(0, 0, 1.0), (8192, 0, 3.0), (0, 4096, 2.0)];
    let corners = corners.map(|(x, y, depth)| Seen { place: [x, y], depth });
    let mut count = 0;
    cover(&Smoothing::None.points(), [0, 0], corners, |point, depth| {
        let [x, y] = [point % TILE[0], point / TILE[0]].map(|n| n as f32 + 0.5);
        let expected = 1.0 + 2.0 * x / 32.0 + y / 16.0;
        assert!((depth - expected).abs() < 1e-5, "{depth} for {expected}");
        count += 1;
    });
    assert_eq!(count, TILE[0] * TILE[1] / 2);
}

/// Numbers from 0 to 1, from a generator with a fixed beginning.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }

    /// A place in a box around the middle, of which ever so many share a coordinate; so some are at one depth.
    fn place(&mut self, coarse: f64) -> Vector {
        [0; 3].map(|_| ((self.next() * 3.0 - 1.5) * coarse).round() / coarse)
    }

    /// Triangles, large and small, some of them slivers, some across the view at one depth.
    fn mesh(&mut self, count: u32) -> TriMesh {
        let mut places = vec![];
        for n in 0..count {
            let coarse = if n % 2 == 0 { 4.0 } else { 64.0 };
            let mut corners = [0; 3].map(|_| self.place(coarse));
            match n % 5 {
                0 => (0..3).for_each(|k| corners[k] = corners[k].map(|c| 4.0 * c)),
                1 => corners[2] = std::array::from_fn(|k| corners[1][k] + 0.003 * self.next()),
                2 => corners = corners.map(|[x, _, z]| [2.0 * x, (4.0 * self.0 as f64).sin(), z]),
                3 => corners = corners.map(|[x, _, z]| [6.0 * x, 0.25, 6.0 * z]),
                _ => {}
            }
            places.extend(corners);
        }
        let triangles = (0..count).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
        TriMesh { positions: Positions::F64(places), triangles, ..TriMesh::default() }
    }
}

/// What is seen at the points of a tile, by looking at all triangles.
fn plainly(tile: [usize; 2], bins: &Bins<'_>, smoothing: Smoothing) -> Vec<(Vec<u64>, u64)> {
    let points = smoothing.points();
    let corner = [0, 1].map(|axis| (tile[axis] * TILE[axis] * 256) as i64);
    let mut seen = vec![(vec![], NONE); TILE[0] * TILE[1] * points.len()];
    for entry in bins.entries(tile) {
        cover(&points, corner, entry.corners, |point, depth| {
            let (key, (before, nearest)) = (key(depth, entry.triangle), &mut seen[point]);
            match bins.hides(entry.surface) {
                true => *nearest = key.min(*nearest),
                false => before.push(key),
            }
        });
    }
    for (before, nearest) in &mut seen {
        before.retain(|key| key < nearest);
        before.sort_unstable();
    }
    seen
}

/// Compares each tile of a picture with what all triangles make of it; how many were not looked at comes back.
fn check(surfaces: &[Painted<'_>], camera: &Camera, smoothing: Smoothing) -> u64 {
    let [width, height] = [75, 41].map(|n| NonZeroU32::new(n).unwrap());
    let view = Viewport::new(camera, Size { width, height });
    let (bins, _) = Bins::of(surfaces, &view, None, &Job::default()).unwrap();
    let (mut drawn, mut tile, count) =
        (Drawn::default(), Tile::new(smoothing), smoothing.points().len());
    let [columns, rows] = bins.tiles();
    for place in (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row])) {
        tile.draw(place, &bins, &mut drawn);
        let expected = plainly(place, &bins, smoothing);
        let [columns, rows] = bins.pixels(place);
        for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
            let first = (y * TILE[0] + x) * count;
            let of_pixel = expected.iter().enumerate().skip(first).take(count);
            for (point, (before, nearest)) in of_pixel {
                assert_eq!(tile.at(point), (&before[..], *nearest), "{place:?}, {x}, {y}");
            }
        }
    }
    drawn.triangles_hidden
}

#[test]
fn triangles_that_are_not_looked_at_are_seen_nowhere() {
    let (mut hidden, plain) = (0, Paint::Plain([1.0; 3]));
    for seed in 0..12 {
        let mut chance = Chance(seed);
        let meshes = [3, 40, 60, 2500, 50].map(|count| chance.mesh(count));
        let half = HalfSpace::new([0.3, 1.0, -0.2], 0.4).unwrap();
        let surfaces = meshes.iter().enumerate().map(|(n, mesh)| {
            let opacity = if (n + seed as usize).is_multiple_of(3) { 0.5 } else { 1.0 };
            let clips = if n % 2 == 1 { std::slice::from_ref(&half) } else { &[] };
            Painted { mesh, paint: plain, opacity, clips }
        });
        let surfaces: Vec<_> = surfaces.collect();
        let projection = match seed % 2 {
            0 => Projection::Parallel { height: 2.0 },
            _ => Projection::Perspective { fov: 40.0 },
        };
        // From before, from the side, and from among them.
        let from = [[0.0, -3.0, 0.0], [2.0, 3.0, 1.0], [0.2, 0.4, 0.1]][seed as usize % 3];
        let camera = Camera::new(from, [0.0; 3], [0.0, 0.0, 1.0], projection).unwrap();
        let smoothing = [Smoothing::None, Smoothing::Four, Smoothing::Sixteen][seed as usize / 4];
        hidden += check(&surfaces, &camera, smoothing);
    }
    assert!(hidden > 5000, "{hidden}");
}

#[test]
fn of_triangles_at_one_depth_the_first_is_seen_and_the_others_are_not_looked_at() {
    let corners = vec![[-9.0, 0.0, -9.0], [9.0, 0.0, -9.0], [0.0, 0.0, 20.0]];
    let positions = Positions::F64(corners);
    let wall = TriMesh { positions, triangles: vec![[0, 1, 2]], ..TriMesh::default() };
    let of = |opacity| Painted { mesh: &wall, paint: Paint::Plain([1.0; 3]), opacity, clips: &[] };
    let projection = Projection::Parallel { height: 2.0 };
    let camera = Camera::new([0.0, -3.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0], projection).unwrap();
    // 3 × 3 tiles. What comes first is nearer; the second of what is opaque, and what is translucent after the first, is not.
    for (opacities, hidden) in
        [([1.0, 1.0, 0.5], 18), ([0.5, 1.0, 0.5], 9), ([0.5, 0.5, 1.0], 0), ([0.5, 0.5, 0.5], 0)]
    {
        assert_eq!(check(&opacities.map(of), &camera, Smoothing::Four), hidden, "{opacities:?}");
    }
}
