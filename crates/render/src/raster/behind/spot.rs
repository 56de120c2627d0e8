//! Where in a picture something can be that is not drawn.

use crate::raster::{
    screen::{PARTS, Viewport},
    tile::{TILE, Tile, key},
};
use isokit_geom::vector::Vector;

/// Places of a picture, in parts of a pixel, and what is there nowhere nearer than.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// From where to where it reaches, in the picture.
    ends: [[i64; 2]; 2],
    /// The depth that none of it is nearer than.
    depth: f32,
    /// Of what is flat.
    facet: Option<Facet>,
}

/// A triangle whose corners are in the picture elsewhere by less than `off`, and there no nearer than they are.
#[derive(Clone, Copy, Debug)]
struct Facet {
    /// Seen so that its inside is on the positive side of its edges.
    corners: [[f64; 2]; 3],
    off: f64,
    /// The depth of its first corner, and how it changes from left to right and from top to bottom.
    plane: [f64; 3],
}

/// The area of a triangle that is seen from its edge, as a share of the square of a side.
const SLIVER: f64 = 1e-3;

impl Spot {
    /// Of what lies in the box of eight corners, or between them. `None` if that is not wholly before the camera.
    pub(super) fn around(corners: [Vector; 8], view: &Viewport<'_>) -> Option<Self> {
        let mut seen = [([0.0; 2], 0.0); 8];
        for (seen, corner) in seen.iter_mut().zip(corners) {
            *seen = place(view.view(corner), view)?;
        }
        // One part for what is rounded to it, and the last digit of what is computed twice.
        Some(Self::of(&seen, 1.0, view))
    }

    /// Of a triangle whose corners are elsewhere in the world by less than `off`.
    pub(super) fn of_triangle(corners: [Vector; 3], off: f64, view: &Viewport<'_>) -> Option<Self> {
        let mut seen = [([0.0; 2], 0.0); 3];
        let mut moved: f64 = 0.0;
        for (seen, corner) in seen.iter_mut().zip(corners) {
            let [right, up, ahead] = view.view(corner);
            // As near as it may be.
            let ahead = ahead - off;
            *seen = place([right, up, ahead], view)?;
            seen.1 = f64::from((seen.1 as f32).next_down());
            moved = moved.max(view.parts_of_one(ahead));
        }
        // Rounded to the nearest part; moved aside, and in a perspective aside for being moved ahead.
        let off = 0.75 + 8.0 * moved * off * (1.0 + view.slope());
        let spot = Self::of(&seen, off, view);
        Some(Self { facet: Some(Facet::new(seen, off)), ..spot })
    }

    fn of(seen: &[([f64; 2], f64)], off: f64, view: &Viewport<'_>) -> Self {
        let size = [view.size.width, view.size.height].map(|n| i64::from(n.get()));
        let ends = std::array::from_fn(|axis| {
            let along = seen.iter().map(|(place, _)| place[axis]);
            let least = along.clone().fold(f64::INFINITY, f64::min) - off;
            let most = along.fold(f64::NEG_INFINITY, f64::max) + off;
            let last = size[axis] * i64::from(PARTS) - 1;
            [(least.floor() as i64).max(0), (most.ceil() as i64).min(last)]
        });
        let depth = seen.iter().map(|(_, depth)| *depth).fold(f64::INFINITY, f64::min);
        Self { ends, depth: (depth as f32).next_down(), facet: None }
    }

    /// The tiles of a picture that it touches, of which so many are side by side.
    pub(super) fn tiles(&self, columns: usize) -> impl Iterator<Item = usize> + use<> {
        let [across, down] = self.ends.map(|[least, most]| {
            let tile = |end: i64, side: usize| end.max(0) as usize / PARTS as usize / side;
            (least <= most).then_some(move |side| tile(least, side)..tile(most, side) + 1)
        });
        let [across, down] = [(across, TILE[0]), (down, TILE[1])]
            .map(|(range, side)| range.map_or(0..0, |range| range(side)));
        down.flat_map(move |row| across.clone().map(move |column| row * columns + column))
    }

    /// Whether at all of its points in a tile, of which so many columns and rows are in the picture, something is nearer.
    pub(super) fn is_behind(&self, tile: &Tile, place: [usize; 2], pixels: [usize; 2]) -> bool {
        let (part, count) = (i64::from(PARTS), tile.points().len());
        tile.points().iter().enumerate().all(|(n, point)| {
            let first = [0, 1]
                .map(|axis| (place[axis] * TILE[axis]) as i64 * part + i64::from(point[axis]));
            let [columns, mut rows] = [0, 1].map(|axis| {
                let [least, most] = self.ends[axis].map(|end| end - first[axis]);
                let from = (least + part - 1).div_euclid(part).max(0);
                from..(most.div_euclid(part) + 1).min(pixels[axis] as i64)
            });
            rows.all(|row| {
                columns.clone().all(|column| {
                    let (_, nearest) =
                        tile.at((row as usize * TILE[0] + column as usize) * count + n);
                    let at = [first[0] + column * part, first[1] + row * part];
                    self.depth_at(at).is_none_or(|depth| nearest < key(depth, 0))
                })
            })
        })
    }

    /// What it is no nearer than at a point, if it is there.
    fn depth_at(&self, place: [i64; 2]) -> Option<f32> {
        let Some(facet) = &self.facet else { return Some(self.depth) };
        let depth = facet.depth_at(place.map(|c| c as f64))?;
        // No point is nearer than all corners. NaN is of a triangle that is seen from its edge.
        Some(((depth as f32).next_down()).max(self.depth))
    }
}

/// A place as the camera sees it: where in the picture, in parts of a pixel, and its depth.
fn place(seen: Vector, view: &Viewport<'_>) -> Option<([f64; 2], f64)> {
    let (place, depth) = view.pixels(seen);
    let is_finite = place.iter().all(|c| c.is_finite()) && depth.is_finite();
    (view.is_ahead(seen[2]) && is_finite).then(|| (place.map(|c| c * f64::from(PARTS)), depth))
}

impl Facet {
    fn new(seen: [([f64; 2], f64); 3], off: f64) -> Self {
        let side = |n: usize, axis: usize| seen[n].0[axis] - seen[0].0[axis];
        let area = side(1, 0) * side(2, 1) - side(1, 1) * side(2, 0);
        let [second, third] = [1, 2].map(|n| seen[n].1 - seen[0].1);
        let longest = [1, 2].map(|n| side(n, 0).hypot(side(n, 1))).into_iter().fold(0.0, f64::max);
        let square = longest * longest;
        // The slopes of a sliver are what rounding makes of them: of its plane nothing is known.
        let known = if area.abs() > SLIVER * square { area } else { f64::NAN };
        let along = (second * side(2, 1) - third * side(1, 1)) / known;
        let down = (third * side(1, 0) - second * side(2, 0)) / known;
        // More than rounding brings, here and where places are whole numbers.
        let rounding = second.abs().max(third.abs()) * (1e-9 + 1e-15 * square);
        let [a, b, c] = seen.map(|(place, _)| place);
        let corners = if area < 0.0 { [a, c, b] } else { [a, b, c] };
        Self { corners, off, plane: [seen[0].1 - rounding, along, down] }
    }

    /// The least depth that it can have at a point, if it can be there: that of a place of its plane that is nowhere farther
    /// from the point, along either axis, than its corners may be from where they are.
    fn depth_at(&self, [x, y]: [f64; 2]) -> Option<f64> {
        let [first, along, down] = self.plane;
        let is_in = |n: usize| {
            let [from, to] = [self.corners[n], self.corners[(n + 1) % 3]];
            let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
            dx * (y - from[1]) - dy * (x - from[0]) >= -(dx.abs() + dy.abs()) * self.off
        };
        let [left, top] = self.corners[0];
        let depth = first + along * (x - left) + down * (y - top);
        (0..3).all(is_in).then_some(depth - (along.abs() + down.abs()) * self.off)
    }
}
