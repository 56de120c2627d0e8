//! Which triangles are seen at the points of a tile.
//!
//! A point is in a triangle if it is on the inner side of all three edges, which whole numbers decide; on an edge it
//! is in one of the two triangles that the edge is common to, by the edge's direction (Pineda 1988, "A parallel
//! algorithm for polygon rasterization").

use super::{Drawn, Smoothing, bins::Bins, screen::PARTS, screen::Seen};

/// Pixels of a tile, from left to right and from top to bottom: few enough that its points stay in the first caches.
pub(super) const TILE: [usize; 2] = [32, 16];

/// What stands for no triangle: farther away than any.
pub(super) const NONE: u64 = u64::MAX;

/// The points of a tile, and what is seen there. A key tells the nearer of two triangles; in its lower half it has
/// the triangle's number.
#[derive(Debug)]
pub(super) struct Tile {
    /// Where in a pixel the points are, in parts of one.
    points: Vec<[i32; 2]>,
    /// Of the nearest opaque triangle at each point. The points of a pixel are side by side.
    nearest: Vec<u64>,
    /// Of the translucent triangles before it: points with keys, as they come.
    found: Vec<(u32, u64)>,
    /// The same by points.
    before: Vec<u64>,
    /// Where those of a point begin, and after the last one how many there are.
    starts: Vec<u32>,
}

/// The key of a triangle at a depth.
#[inline(always)]
pub(super) fn key(depth: f32, triangle: u32) -> u64 {
    // Bits of numbers are in the numbers' order, but for the sign.
    let bits = depth.to_bits();
    let ordered = if bits >> 31 == 0 { bits | 1 << 31 } else { !bits };
    u64::from(ordered) << 32 | u64::from(triangle)
}

/// The triangle of a key.
#[inline(always)]
pub(super) fn triangle_of(key: u64) -> u32 {
    key as u32
}

impl Smoothing {
    /// Where in a pixel the points are, in parts of one: a lattice that is square but for rounding, turned so that
    /// each has a row and a column of its own.
    fn points(self) -> Vec<[i32; 2]> {
        let (count, turn) = match self {
            Self::None => (1, 1),
            Self::Four => (4, 2),
            Self::Sixteen => (16, 4),
        };
        let point = |n| [n, turn * n % (count + 1)].map(|n| (2 * n - 1) * PARTS / (2 * count));
        (1..=count).map(point).collect()
    }
}

impl Smoothing {
    /// Where in a pixel the points are, in pixels.
    pub(crate) fn places(self) -> Vec<[f64; 2]> {
        let place = |point: [i32; 2]| point.map(|part| f64::from(part) / f64::from(PARTS));
        self.points().into_iter().map(place).collect()
    }
}

impl Tile {
    pub(super) fn new(smoothing: Smoothing) -> Self {
        let points = smoothing.points();
        let count = TILE[0] * TILE[1] * points.len();
        let (nearest, starts) = (vec![NONE; count], vec![0; count + 1]);
        Self { points, nearest, found: vec![], before: vec![], starts }
    }

    /// Where in a pixel the points are, in parts of one.
    pub(super) fn points(&self) -> &[[i32; 2]] {
        &self.points
    }

    /// Finds out what is seen in a tile.
    pub(super) fn draw(&mut self, tile: [usize; 2], bins: &Bins<'_>, drawn: &mut Drawn) {
        let Self { points, nearest, found, .. } = self;
        let corner = [0, 1].map(|axis| (tile[axis] * TILE[axis]) as i64 * i64::from(PARTS));
        nearest.fill(NONE);
        found.clear();
        let mut are_all_opaque = true;
        for (triangle, corners) in bins.entries(tile) {
            if bins.is_opaque(triangle) {
                cover(points, corner, corners, |point, depth| {
                    let key = key(depth, triangle);
                    nearest[point] = nearest[point].min(key);
                });
            } else {
                are_all_opaque = false;
            }
        }
        if !are_all_opaque {
            for (triangle, corners) in bins.entries(tile) {
                if bins.is_opaque(triangle) {
                    continue;
                }
                cover(points, corner, corners, |point, depth| {
                    let key = key(depth, triangle);
                    match key < nearest[point] {
                        true => found.push((point as u32, key)),
                        false => drawn.hidden += 1,
                    }
                });
            }
        }
        self.sort();
    }

    /// Of a point: the keys of the translucent triangles, in order, and then that of the opaque one.
    #[inline]
    pub(super) fn at(&self, point: usize) -> (&[u64], u64) {
        let range = self.starts[point] as usize..self.starts[point + 1] as usize;
        (&self.before[range], self.nearest[point])
    }

    /// Brings what was found into the order of points, and of depth in each.
    fn sort(&mut self) {
        let Self { found, before, starts, .. } = self;
        starts.fill(0);
        if found.is_empty() {
            return;
        }
        found.iter().for_each(|&(point, _)| starts[point as usize + 1] += 1);
        let mut sum = 0;
        for start in &mut *starts {
            sum += *start;
            *start = sum;
        }
        before.clear();
        before.resize(found.len(), NONE);
        // From the last on, the end of each point's keys goes down to their beginning.
        for &(point, key) in found.iter().rev() {
            let end = &mut starts[point as usize + 1];
            *end -= 1;
            before[*end as usize] = key;
        }
        starts.rotate_left(1);
        let last = starts.len() - 1;
        starts[last] = found.len() as u32;
        for range in starts.windows(2).filter(|range| range[1] - range[0] > 1) {
            before[range[0] as usize..range[1] as usize].sort_unstable();
        }
    }
}

/// Names each point in a triangle, with its depth there. `corner` is the tile's, in parts of a pixel.
#[inline(always)]
fn cover(
    points: &[[i32; 2]],
    corner: [i64; 2],
    corners: [Seen; 3],
    mut hit: impl FnMut(usize, f32),
) {
    let place = |seen: Seen| [0, 1].map(|axis| i64::from(seen.place[axis]) - corner[axis]);
    let [a, mut b, mut c] = corners.map(place);
    let [near, mut second, mut third] = corners.map(|seen| f64::from(seen.depth));
    let mut area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if area < 0 {
        (b, c, second, third, area) = (c, b, third, second, -area);
    }
    let edges = [Edge::new(a, b), Edge::new(b, c), Edge::new(c, a)];
    let least = [0, 1].map(|axis| a[axis].min(b[axis]).min(c[axis]));
    let greatest = [0, 1].map(|axis| a[axis].max(b[axis]).max(c[axis]));
    let mut plane = None;
    let part = i64::from(PARTS);
    for (n, point) in points.iter().enumerate() {
        let point = point.map(i64::from);
        let range = |axis: usize| {
            let first = (least[axis] - point[axis] + part - 1).div_euclid(part).max(0);
            let last = (greatest[axis] - point[axis]).div_euclid(part);
            first..(last + 1).min(TILE[axis] as i64)
        };
        let columns = range(0);
        if columns.is_empty() {
            continue;
        }
        for row in range(1) {
            let y = row * part + point[1];
            for column in columns.clone() {
                let x = column * part + point[0];
                if !edges.iter().all(|edge| edge.has([x, y])) {
                    continue;
                }
                let [along, down] = *plane.get_or_insert_with(|| {
                    let (second, third) = (second - near, third - near);
                    let [bx, by, cx, cy] = [b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]];
                    let [bx, by, cx, cy] = [bx, by, cx, cy].map(|n| n as f64);
                    let area = area as f64;
                    [(second * cy - third * by) / area, (third * bx - second * cx) / area]
                });
                let depth = near + along * (x - a[0]) as f64 + down * (y - a[1]) as f64;
                // Of a sliver the slopes are steep: no point is nearer or farther than all corners.
                let ends = [near.min(second).min(third), near.max(second).max(third)];
                let depth = depth.max(ends[0]).min(ends[1]) as f32;
                hit((row as usize * TILE[0] + column as usize) * points.len() + n, depth);
            }
        }
    }
}

/// An edge of a triangle whose inside is on its positive side.
struct Edge {
    x: i64,
    y: i64,
    base: i64,
}

impl Edge {
    #[inline(always)]
    fn new(from: [i64; 2], to: [i64; 2]) -> Self {
        let [x, y] = [to[0] - from[0], to[1] - from[1]];
        // Of the two directions of an edge one has the points on it.
        let is_owner = y > 0 || (y == 0 && x < 0);
        let base = y * from[0] - x * from[1] - i64::from(!is_owner);
        Self { x, y, base }
    }

    #[inline(always)]
    fn has(&self, [x, y]: [i64; 2]) -> bool {
        self.x * y - self.y * x + self.base >= 0
    }
}

#[cfg(test)]
mod tests {
    use super::{Seen, Smoothing, TILE, cover, key, triangle_of};

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
        for (smoothing, count) in
            [(Smoothing::None, 1), (Smoothing::Four, 4), (Smoothing::Sixteen, 16)]
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
}
