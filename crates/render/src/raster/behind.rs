//! What an opaque surface hides, before it is made: the picture is the same without it.
//!
//! What a closed surface encloses lies behind it from everywhere else ([`hides_within`]): to know that needs no picture, but
//! it only holds at some distance from the surface. Elsewhere the surface is drawn as the picture draws it, at the same
//! points, and must be nearer at each of them than what may be there: a whole box ([`boxes_in_sight`]), or a triangle that
//! is known but for its last digits ([`are_behind`]).

mod spot;

use super::{
    Painted, RasterError, Smoothing,
    bins::{Bins, tiles_of},
    screen::Viewport,
    tile::Tile,
};
use crate::{Camera, Size};
use isokit_geom::vector::Vector;
use isokit_job::{Job, Stopped};
use isokit_lanes::exactly;
use rayon::prelude::*;
use spot::Spot;
use std::sync::atomic::{AtomicUsize, Ordering};

/// By how much less than a gap places may be moved by rounding.
const FINE: f64 = 1.0 / 16.0;

/// With more of them, counted once for each tile, nothing is known: to look at them takes longer than to draw them.
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

/// Of so many boxes, those that do not lie wholly behind an opaque surface at all points of a picture that they reach.
/// `None` if there are more than `most`, if one is not wholly before the camera, or if it is not worth it to look at them. Each
/// is the eight corners of something convex.
///
/// # Errors
///
/// As [`rasterize`](super::rasterize).
pub fn boxes_in_sight(
    surface: &Painted<'_>,
    (boxes, count, most): (impl Fn(usize) -> [Vector; 8] + Sync, usize, usize),
    (camera, size): (&Camera, Size),
    smoothing: Smoothing,
    job: &Job,
) -> Result<Option<Vec<usize>>, RasterError> {
    let view = Viewport::new(camera, size);
    let around = |n| exactly(|| Spot::around(boxes(n), &view));
    let spots = || (0..count).into_par_iter().map(around).collect();
    let spots: Option<Vec<_>> = job.threads.run(spots);
    let Some(spots) = spots else { return Ok(None) };
    in_sight(surface, (&spots, most), &view, smoothing, job)
}

/// Whether triangles lie wholly behind an opaque surface at all points of a picture that they can be at, if their corners
/// are elsewhere by less than `off`. Not if it is not worth it to look at them.
///
/// # Errors
///
/// As [`rasterize`](super::rasterize).
pub fn are_behind(
    surface: &Painted<'_>,
    (triangles, off): (impl Iterator<Item = [Vector; 3]>, f64),
    (camera, size): (&Camera, Size),
    smoothing: Smoothing,
    job: &Job,
) -> Result<bool, RasterError> {
    let view = Viewport::new(camera, size);
    let spots = triangles.map(|corners| Spot::of_triangle(corners, off, &view));
    let Some(spots) = spots.collect::<Option<Vec<_>>>() else { return Ok(false) };
    Ok(in_sight(surface, (&spots, 0), &view, smoothing, job)?.is_some())
}

/// Spots that are not wholly behind a surface, if there are no more than `most`.
fn in_sight(
    surface: &Painted<'_>,
    (spots, most): (&[Spot], usize),
    view: &Viewport<'_>,
    smoothing: Smoothing,
    job: &Job,
) -> Result<Option<Vec<usize>>, RasterError> {
    let [columns, rows] = tiles_of(view);
    let (mut places, mut wanted) = (vec![], vec![false; columns * rows]);
    for (n, spot) in spots.iter().enumerate() {
        for tile in spot.tiles(columns) {
            wanted[tile] = true;
            places.push((tile, n));
        }
        if places.len() > MOST {
            return Ok(None);
        }
    }
    if places.is_empty() {
        return Ok(Some(vec![]));
    }
    job.threads.run(|| places.par_sort_unstable());
    let surfaces = [surface.whole()];
    let (bins, _) = Bins::of(&surfaces, view, Some(wanted), &job.unwatched())?;
    let by_tile: Vec<_> = places.chunk_by(|a, b| a.0 == b.0).collect();
    // One can be found in several tiles: no more than four of them count for too many.
    let (found, enough) = (AtomicUsize::new(0), most.saturating_mul(4));
    let look = |tile: &mut Tile, places: &&[(usize, usize)]| {
        job.check()?;
        if found.load(Ordering::Relaxed) > enough {
            return Ok(vec![]);
        }
        let place = [places[0].0 % columns, places[0].0 / columns];
        let seen: Vec<usize> = exactly(|| {
            tile.draw(place, &bins, &mut Default::default());
            let pixels = bins.pixels(place);
            let seen = places.iter().filter(|(_, n)| !spots[*n].is_behind(tile, place, pixels));
            seen.map(|&(_, n)| n).collect()
        });
        found.fetch_add(seen.len(), Ordering::Relaxed);
        Ok(seen)
    };
    let look_at = || by_tile.par_iter().map_init(|| Tile::new(smoothing), look).collect();
    let seen: Result<Vec<_>, Stopped> = job.threads.run(look_at);
    let mut seen = seen?.concat();
    if found.into_inner() > enough {
        return Ok(None);
    }
    seen.sort_unstable();
    seen.dedup();
    Ok((seen.len() <= most).then_some(seen))
}

#[cfg(test)]
mod tests;
