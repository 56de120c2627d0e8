//! What an opaque surface hides, before it is made: whatever is in a box, the picture is the same without it.
//!
//! Two ways to know it. What a closed surface encloses lies behind it from everywhere else ([`hides_within`]); it needs no
//! picture, but only holds at some distance from the surface. And where boxes are, the surface is drawn as the picture
//! draws it, at the same points, and must be nearer than the whole box at each of them ([`are_behind`]).

use super::{
    Painted, RasterError, Smoothing,
    bins::{Bins, tiles_of},
    screen::{PARTS, Viewport},
    tile::{TILE, Tile, key},
};
use crate::{Camera, Size};
use isokit_geom::vector::Vector;
use isokit_job::{Job, Stopped};
use isokit_lanes::exactly;
use rayon::prelude::*;

/// By how much less than a gap places may be moved by rounding.
const FINE: f64 = 1.0 / 16.0;

/// Of more boxes in tiles nothing is known: to look at them takes longer than to draw what is in them.
const MOST: usize = 1 << 21;

/// Whether a closed opaque surface within a box hides all that it encloses, if that is nowhere nearer to it than `gap`, in
/// world units: at each point of a picture, whatever is rounded there. It does not where the camera, or what is too near to it
/// to be seen, is in the box, and in pictures so small that a gap is lost between their points.
pub fn hides_within(bounds: [Vector; 8], gap: f64, (camera, size): (&Camera, Size)) -> bool {
    let view = Viewport::new(camera, size);
    let ahead = bounds.map(|corner| view.view(corner)[2]);
    let near = ahead.into_iter().fold(f64::INFINITY, f64::min);
    let far = ahead.into_iter().fold(f64::NEG_INFINITY, f64::max);
    near > 0.0 && view.is_ahead(near) && view.rounding([near, far]) <= FINE * gap
}

/// Whether boxes lie wholly behind an opaque surface, at all points of a picture that they reach. Each is the eight corners
/// of something convex; one that is not wholly before the camera
/// is not, nor are more than it is worth to look at.
///
/// # Errors
///
/// As [`rasterize`](super::rasterize).
pub fn are_behind(
    surface: &Painted<'_>,
    boxes: impl Iterator<Item = [Vector; 8]>,
    (camera, size): (&Camera, Size),
    smoothing: Smoothing,
    job: &Job,
) -> Result<bool, RasterError> {
    let view = Viewport::new(camera, size);
    let [columns, rows] = tiles_of(&view);
    let (mut spots, mut wanted) = (vec![], vec![false; columns * rows]);
    for corners in boxes {
        let Some(spot) = Spot::of(corners, &view) else { return Ok(false) };
        for tile in spot.tiles(columns) {
            wanted[tile] = true;
            spots.push((tile, spot));
        }
        if spots.len() > MOST {
            return Ok(false);
        }
    }
    if spots.is_empty() {
        return Ok(true);
    }
    spots.sort_by_key(|&(tile, _)| tile);
    let surfaces = [surface.whole()];
    let (bins, _) = Bins::of(&surfaces, &view, Some(wanted), &job.unwatched())?;
    let by_tile: Vec<_> = spots.chunk_by(|a, b| a.0 == b.0).collect();
    // What is seen ends the search, as does whoever stops the job.
    let look = |tile: &mut Tile, spots: &&[(usize, Spot)]| {
        job.check().map_err(|cancelled| Some(cancelled.into()))?;
        let place = [spots[0].0 % columns, spots[0].0 / columns];
        exactly(|| {
            tile.draw(place, &bins, &mut Default::default());
            let is_behind =
                |(_, spot): &(usize, Spot)| spot.is_behind(tile, place, bins.pixels(place));
            if spots.iter().all(is_behind) { Ok(()) } else { Err(None) }
        })
    };
    let new = || Tile::new(smoothing);
    let found = job.threads.run(|| {
        let looked = by_tile.par_iter().map_init(new, look);
        looked.try_for_each(|found: Result<(), Option<Stopped>>| found)
    });
    match found {
        Ok(()) => Ok(true),
        Err(None) => Ok(false),
        Err(Some(stopped)) => Err(stopped.into()),
    }
}

/// Where in a picture a box can be: a rectangle of it, and nowhere nearer than a depth.
#[derive(Clone, Copy, Debug)]
struct Spot {
    /// From where to where it reaches, in parts of a pixel, in the picture.
    ends: [[i64; 2]; 2],
    depth: f32,
}

impl Spot {
    fn of(corners: [Vector; 8], view: &Viewport<'_>) -> Option<Self> {
        let (mut ends, mut depth) = ([[f64::INFINITY, f64::NEG_INFINITY]; 2], f64::INFINITY);
        for corner in corners.map(|corner| view.view(corner)) {
            let (place, corner_depth) = view.pixels(corner);
            let is_finite = place.iter().all(|c| c.is_finite()) && corner_depth.is_finite();
            if !(view.is_ahead(corner[2]) && is_finite) {
                return None;
            }
            depth = depth.min(corner_depth);
            for (ends, c) in ends.iter_mut().zip(place) {
                *ends = [ends[0].min(c), ends[1].max(c)];
            }
        }
        let size = [view.size.width, view.size.height].map(|n| i64::from(n.get()));
        let ends = std::array::from_fn(|axis| {
            let [least, most] = ends[axis].map(|c| c * f64::from(PARTS));
            // One part more on each side, for what is rounded to it.
            let last = size[axis] * i64::from(PARTS) - 1;
            [
                (least.floor() as i64).saturating_sub(1).max(0),
                (most.ceil() as i64).saturating_add(1).min(last),
            ]
        });
        // Of what is computed twice the last digit may differ.
        Some(Self { ends, depth: (depth as f32).next_down() })
    }

    /// The tiles of a picture that it touches, of which so many are side by side.
    fn tiles(&self, columns: usize) -> impl Iterator<Item = usize> + use<> {
        let [across, down] = [0, 1].map(|axis| {
            let [least, most] =
                self.ends[axis].map(|end| end.max(0) as usize / PARTS as usize / TILE[axis]);
            if self.ends[axis][0] > self.ends[axis][1] { 0..0 } else { least..most + 1 }
        });
        down.flat_map(move |row| across.clone().map(move |column| row * columns + column))
    }

    /// Whether at all of its points in a tile, of which so many columns and rows are in the picture, something is nearer.
    fn is_behind(&self, tile: &Tile, place: [usize; 2], pixels: [usize; 2]) -> bool {
        let (part, count) = (i64::from(PARTS), tile.points().len());
        tile.points().iter().enumerate().all(|(n, point)| {
            let [columns, rows] = [0, 1].map(|axis| {
                let first = (place[axis] * TILE[axis]) as i64 * part + i64::from(point[axis]);
                let [least, most] = self.ends[axis].map(|end| end - first);
                let from = (least + part - 1).div_euclid(part).max(0);
                from..(most.div_euclid(part) + 1).min(pixels[axis] as i64)
            });
            rows.into_iter().all(|row| {
                columns.clone().all(|column| {
                    let (_, nearest) =
                        tile.at((row as usize * TILE[0] + column as usize) * count + n);
                    nearest < key(self.depth, 0)
                })
            })
        })
    }
}

#[cfg(test)]
mod tests;
