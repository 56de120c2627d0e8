//! Where in a picture something of a volume may be seen, and how far away.
//!
//! The blocks of which something may be seen are laid on the picture, in tiles of pixels: rays beside them all have nothing
//! to look for, and the others nothing before the nearest one and behind the farthest. All of it is rounded outwards, so
//! that no bit of the picture depends on it.

use crate::{
    Camera, Projection, Size,
    clear::{CELLS, Clear},
};
use isokit_geom::{
    Affine,
    vector::{Vector, length},
};
use isokit_job::{Job, Stopped};
use isokit_lanes::exactly;
use rayon::prelude::*;

/// Pixels of a tile along each side.
const TILE: f64 = 8.0;

/// How far away something may be seen in each tile of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Seen {
    /// Tiles along x and y.
    counts: [usize; 2],
    /// Distances along rays from where they begin: from the least to the greatest.
    tiles: Vec<[f64; 2]>,
}

/// Where nothing may be seen: no distance is so great and so small.
const NOTHING: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

impl Seen {
    /// `None` where a block may be beside the camera or behind it.
    ///
    /// # Errors
    ///
    /// If the job does not allow two numbers for each tile and thread.
    pub(super) fn new(
        (clear, affine): (&Clear, &Affine),
        (camera, size): (&Camera, Size),
        job: &Job,
    ) -> Result<Option<Self>, Stopped> {
        let tiles = |n: u32| (f64::from(n) / TILE).ceil() as usize;
        let counts = [size.width, size.height].map(|n| tiles(n.get()));
        let (count, threads) = (counts[0] * counts[1], job.threads.count());
        let most = (count as u64).checked_mul(2 * threads as u64);
        job.limits.probe("tiles of the picture", most, size_of::<[f64; 2]>())?;
        let onto = Onto::new((clear, affine), (camera, size));
        let nothing = || Some(Self { counts, tiles: vec![NOTHING; count] });
        let layers = clear.counts()[2];
        Ok(job.threads.run(|| {
            let layers = (0..layers).into_par_iter().with_min_len(layers.div_ceil(threads));
            let seen = layers.fold(nothing, |seen, z| {
                exactly(|| {
                    let mut seen = seen?;
                    for block in clear.seen(z) {
                        seen.add(onto.patch(block)?);
                    }
                    Some(seen)
                })
            });
            // The least and the greatest are the same in any order.
            seen.reduce(nothing, |one, other| Some(one?.with(&other?)))
        }))
    }

    /// From where to where something may be seen along the ray through a place of the picture, in pixels, if it may be.
    #[inline(always)]
    pub(super) fn at(&self, place: [f64; 2]) -> Option<[f64; 2]> {
        let [x, y] = place.map(|c| (c / TILE) as usize);
        let distances = self.tiles.get(x + self.counts[0] * y).copied();
        distances.filter(|[near, far]| near <= far)
    }

    fn add(&mut self, Patch { from, to, distances: [near, far] }: Patch) {
        // What is below 0 becomes 0.
        let tile = |at: f64| (at / TILE) as usize;
        let end = |k: usize| if to[k] < 0.0 { 0 } else { (tile(to[k]) + 1).min(self.counts[k]) };
        let [columns, rows] = [0, 1].map(|k| tile(from[k])..end(k));
        for row in rows.map(|y| y * self.counts[0]) {
            let start = (row + columns.start).min(row + columns.end);
            for tile in &mut self.tiles[start..row + columns.end] {
                *tile = [tile[0].min(near), tile[1].max(far)];
            }
        }
    }

    fn with(mut self, other: &Self) -> Self {
        for (own, tile) in self.tiles.iter_mut().zip(&other.tiles) {
            *own = [own[0].min(tile[0]), own[1].max(tile[1])];
        }
        self
    }
}

/// Where a block is in the picture: between two places, in pixels, and between two distances along rays.
struct Patch {
    from: [f64; 2],
    to: [f64; 2],
    distances: [f64; 2],
}

/// What takes blocks onto the picture.
struct Onto {
    /// The middle of the first block, and from one to the next along x, y, z: to the right, up and ahead of the camera.
    first: Vector,
    steps: [Vector; 3],
    /// How far a block reaches from its middle to the right, up and ahead, and to any side.
    reach: Vector,
    radius: f64,
    /// Pixels from the left and upper border to the middle.
    middle: [f64; 2],
    /// Pixels for what is 1 aside, in a perspective picture 1 ahead.
    scale: f64,
    is_perspective: bool,
}

/// More than rounding does to places, as a share of the greatest number among them.
const UNSURE: f64 = 1e-13;

impl Onto {
    fn new((clear, affine): (&Clear, &Affine), (camera, size): (&Camera, Size)) -> Self {
        let cells = CELLS as f64;
        let steps = [0, 1, 2].map(|axis| {
            let mut along = [0.0; 3];
            along[axis] = cells;
            camera.turned(affine.vector(along))
        });
        let last = clear.counts().map(|n| n as f64 * cells);
        let numbers = [camera.from(), affine.point([0.0; 3]), affine.vector(last)];
        let unsure = UNSURE * numbers.map(length).into_iter().sum::<f64>();
        let reach = [0, 1, 2].map(|k| unsure + steps.iter().map(|s| 0.5 * s[k].abs()).sum::<f64>());
        let size = [size.width, size.height].map(|n| f64::from(n.get()));
        Self {
            first: camera.view(affine.point([0.5 * cells; 3])),
            steps,
            reach,
            radius: length(reach),
            middle: size.map(|n| 0.5 * n),
            scale: 0.5 * size[1] / camera.half_height(1.0),
            is_perspective: matches!(camera.projection(), Projection::Perspective { .. }),
        }
    }

    /// `None` where it is not before the camera, or numbers end.
    fn patch(&self, block: [usize; 3]) -> Option<Patch> {
        let block = block.map(|n| n as f64);
        let [x, y, z]: Vector = std::array::from_fn(|k| {
            let along = |axis: usize| block[axis] * self.steps[axis][k];
            self.first[k] + along(0) + along(1) + along(2)
        });
        let [right, up, ahead] = self.reach;
        let (mut aside, mut beside, mut distance, mut radius) = ([x, -y], [right, up], z, ahead);
        if self.is_perspective {
            let nearest = z - ahead;
            if nearest <= 0.0 {
                return None;
            }
            aside = aside.map(|c| c / z);
            beside = [0, 1].map(|k| (beside[k] + aside[k].abs() * ahead) / nearest);
            (distance, radius) = (length([x, y, z]), self.radius);
        }
        let at = |k: usize| self.middle[k] + aside[k] * self.scale;
        // A ray is a pixel's, in its middle, which is far from the border of a tile.
        let from = [0, 1].map(|k| at(k) - beside[k] * self.scale);
        let to = [0, 1].map(|k| at(k) + beside[k] * self.scale);
        let distances = [distance - radius, distance + radius];
        let is_known = [from, to, distances].as_flattened().iter().all(|number| number.is_finite());
        is_known.then_some(Patch { from, to, distances })
    }
}

#[cfg(test)]
mod tests;
