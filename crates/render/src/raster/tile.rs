//! Which triangles are seen at the points of a tile.
//!
//! A point is in a triangle if it is on the inner side of all three edges, which whole numbers decide; on an edge it
//! is in one of the two triangles that the edge is common to, by the edge's direction (Pineda 1988, "A parallel
//! algorithm for polygon rasterization").
//!
//! Opaque surfaces come first, in their order. A triangle whose corners all lie behind the farthest of what is opaque at
//! the points of the tile is seen at none of them, and not looked at (Greene, Kass & Miller 1993, "Hierarchical Z-buffer
//! visibility").

use super::{
    Drawn, Smoothing,
    bins::{Bins, Entry},
    screen::{PARTS, Seen},
};

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
        let in_picture = bins.pixels(tile);
        nearest.fill(NONE);
        found.clear();
        let (mut is_opaque, mut wall) = ([false; 2], Wall::default());
        for Entry { surface, triangle, corners } in bins.entries(tile) {
            is_opaque[usize::from(bins.hides(surface))] = true;
            if !bins.hides(surface) {
                continue;
            }
            if wall.is_old(surface, nearest.len()) {
                wall.farthest = farthest(nearest, in_picture, points.len());
            }
            if wall.hides(triangle, corners) {
                drawn.triangles_hidden += 1;
                continue;
            }
            cover(points, corner, corners, |point, depth| {
                let key = key(depth, triangle);
                nearest[point] = nearest[point].min(key);
            });
        }
        if is_opaque[0] {
            if is_opaque[1] {
                wall.farthest = farthest(nearest, in_picture, points.len());
            }
            for Entry { triangle, corners, .. } in bins.translucent(tile) {
                if wall.hides(triangle, corners) {
                    drawn.triangles_hidden += 1;
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

/// What is opaque in a tile, as far as it was drawn.
#[derive(Debug)]
struct Wall {
    /// The farthest key of a point of the picture when that was last looked for.
    farthest: u64,
    /// The surface that is being drawn.
    surface: Option<usize>,
    /// Triangles of it that came since.
    came: usize,
}

impl Default for Wall {
    fn default() -> Self {
        Self { farthest: NONE, surface: None, came: 0 }
    }
}

impl Wall {
    /// Whether to look again before a triangle of a surface is drawn: another one is whole, or so many of this one
    /// came that to look at all points takes little longer.
    fn is_old(&mut self, surface: usize, points: usize) -> bool {
        let is_other = self.surface.is_some_and(|before| before != surface);
        self.surface = Some(surface);
        let is_old = is_other || self.came == points;
        self.came = if is_old { 1 } else { self.came + 1 };
        is_old
    }

    /// Whether a triangle lies behind it wherever it lies: no point of a triangle is nearer than all corners.
    fn hides(&self, triangle: u32, corners: [Seen; 3]) -> bool {
        corners.iter().all(|corner| key(corner.depth, triangle) >= self.farthest)
    }
}

/// The farthest of the keys of points in the picture: so many columns and rows of pixels.
fn farthest(nearest: &[u64], [columns, rows]: [usize; 2], points: usize) -> u64 {
    let mut farthest = 0;
    for row in nearest.chunks_exact(TILE[0] * points).take(rows) {
        farthest = row[..columns * points].iter().fold(farthest, |most, &key| most.max(key));
        if farthest == NONE {
            break;
        }
    }
    farthest
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
mod tests;
