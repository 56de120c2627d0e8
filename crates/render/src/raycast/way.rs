//! The ways of rays through a volume.

use super::{Cast, MOST_STEPS, Medium, seen::Seen};
use crate::{Camera, Projection, Ray, Size, trilinear::cut};
use isokit_geom::{HalfSpace, vector::Vector};
use isokit_lanes::{LINES, Sight, Sighted};
use isokit_volume::Sample;

/// The way of a ray through a volume, in steps, of which the first and the last may be no whole ones.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Way {
    /// Where the first whole step begins, and how far one leads, in index space.
    pub(super) start: [f64; 3],
    pub(super) step: [f64; 3],
    /// How many steps a cell is long along x, y, z: without end, upwards, where it does not move.
    pub(super) pace: [f64; 3],
    /// How many steps it is long before the first whole one, and from there on.
    pub(super) before: f64,
    pub(super) steps: f64,
    /// From which on and up to which of its whole steps something may be seen.
    pub(super) seen: [f64; 2],
    /// Where it leads in the world: of length 1.
    pub(super) towards: Vector,
}

/// Where a ray goes through a picture.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pixel {
    pub(super) number: usize,
    /// In pixels from the upper left corner.
    pub(super) place: [f64; 2],
    /// With so much of a step the way begins.
    pub(super) begin: f64,
}

/// The ways of the rays of a picture's pixels.
#[derive(Clone, Debug)]
pub(super) struct Ways<'a> {
    /// How the camera looks at the volume's cells; axes also as they are in the world.
    sight: Sight,
    /// Where rays begin in the middle of the picture, in the world.
    from: Vector,
    clips: &'a [HalfSpace],
    /// The length of a step, and how many are 1 long.
    step: f64,
    per_unit: f64,
    /// Where in the picture something may be seen, if that is known.
    seen: Option<Seen>,
    /// Pixels.
    size: [f64; 2],
    /// Half a pixel, where the axes are 1 long.
    pitch: f64,
}

impl<'a> Ways<'a> {
    /// None where rays have no way: through a volume that has no cells.
    pub(super) fn new<T: Sample>(
        medium: &Medium<'a, T>,
        (camera, size): (&Camera, Size),
        (step, seen): (f64, Option<Seen>),
    ) -> Option<Self> {
        let (dims, affine) = (medium.view.dims(), medium.view.frame().index_to_world);
        let size = [size.width, size.height].map(|n| f64::from(n.get()));
        let sight = Sight {
            from: affine.inverse_point(camera.from()),
            axes: camera.axes().map(|axis| affine.inverse_vector(axis)),
            units: camera.axes(),
            is_perspective: matches!(camera.projection(), Projection::Perspective { .. }),
            last: dims.map(|n| n as f64 - 1.0),
        };
        dims.iter().all(|&n| n > 1).then(|| Self {
            sight,
            from: camera.from(),
            clips: medium.clips,
            step,
            per_unit: step.recip(),
            seen,
            size,
            pitch: camera.half_height(1.0) / size[1],
        })
    }

    /// The ways of the rays through pixels, each with the pixel's number. None of those that are beside what is kept of
    /// the volume.
    pub(super) fn of<I: Iterator<Item = Pixel>>(&self, pixels: I) -> Sights<'_, I> {
        let (batch, sighted) = (Default::default(), Sighted::default());
        Sights { ways: self, pixels, batch, sighted, next: 0, count: 0 }
    }

    /// How far to the right and up of the middle of the picture a place is, where the axes are 1 long.
    #[inline(always)]
    fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [2.0 * x - self.size[0], self.size[1] - 2.0 * y].map(|halves| halves * self.pitch)
    }

    /// The way of a ray that was sighted as one of several. None if nothing may be seen along it; then its steps are
    /// counted.
    #[inline(always)]
    fn way(&self, n: usize, pixel: &Pixel, sighted: &Sighted, done: &mut Cast) -> Option<Way> {
        let of = |all: &[[f64; LINES]; 3]| -> Vector { [all[0][n], all[1][n], all[2][n]] };
        let towards = of(&sighted.towards);
        let [near, far] = self.kept([sighted.near[n], sighted.far[n]], pixel, towards)?;
        let steps = (far - near) * self.per_unit;
        // Not where a camera so far away that numbers end has made one that is no number, or no end.
        if !(steps > 0.0 && steps <= 2.0 * MOST_STEPS) {
            return None;
        }
        let before = pixel.begin.min(steps);
        let at = near + before * self.step;
        let mut seen = [0.0, f64::INFINITY];
        if let Some(tiles) = &self.seen {
            let Some(distances) = tiles.at(pixel.place) else {
                let whole = (steps - before) as u64;
                let parts =
                    [before, steps - before - whole as f64].map(|part| u64::from(part > 0.0));
                done.steps_leapt += whole + parts[0] + parts[1];
                return None;
            };
            // Whole ones: what is below 0 becomes 0.
            let [from, to] = distances.map(|distance| ((distance - at) * self.per_unit) as u64);
            seen = [from as f64, to as f64 + 1.0];
        }
        let (mut start, direction) = (of(&sighted.origins), of(&sighted.directions));
        for k in 0..3 {
            start[k] += at * direction[k];
        }
        Some(Way {
            start,
            step: direction.map(|c| c * self.step),
            pace: of(&sighted.paces).map(|c| c * self.per_unit),
            before,
            steps: steps - before,
            seen,
            towards,
        })
    }

    /// What planes keep of a way from one distance to another.
    #[inline(always)]
    fn kept(&self, ends: [f64; 2], pixel: &Pixel, towards: Vector) -> Option<[f64; 2]> {
        if self.clips.is_empty() {
            return Some(ends);
        }
        let mut origin = self.from;
        if !self.sight.is_perspective {
            let [right, up] = self.point(pixel.place);
            for (k, c) in origin.iter_mut().enumerate() {
                *c += right * self.sight.units[0][k] + up * self.sight.units[1][k];
            }
        }
        cut(ends, &Ray { origin, direction: towards }, self.clips)
    }
}

/// See [`Ways::of`].
pub(super) struct Sights<'w, I> {
    ways: &'w Ways<'w>,
    pixels: I,
    batch: [Pixel; LINES],
    sighted: Sighted,
    /// Of so many the next one.
    count: usize,
    next: usize,
}

impl<I: Iterator<Item = Pixel>> Sights<'_, I> {
    /// The next way along which something may be seen, and the number of its pixel. Steps of others are counted.
    #[inline(always)]
    pub(super) fn next(&mut self, done: &mut Cast) -> Option<(usize, Way)> {
        while self.next < self.count || self.look() {
            let (n, pixel) = (self.next, &self.batch[self.next]);
            self.next += 1;
            if let Some(way) = self.ways.way(n, pixel, &self.sighted, done) {
                return Some((pixel.number, way));
            }
        }
        None
    }

    /// Looks along the next rays. Whether there are some.
    fn look(&mut self) -> bool {
        (self.next, self.count) = (0, 0);
        let mut points = [[0.0; LINES]; 2];
        for (n, pixel) in self.pixels.by_ref().take(LINES).enumerate() {
            let [right, up] = self.ways.point(pixel.place);
            (points[0][n], points[1][n]) = (right, up);
            (self.batch[n], self.count) = (pixel, n + 1);
        }
        if self.count > 0 {
            self.ways.sight.lines(points.each_ref(), &mut self.sighted);
        }
        self.count > 0
    }
}

impl Way {
    /// The place after so many steps.
    #[inline(always)]
    pub(super) fn at(&self, steps: f64) -> [f64; 3] {
        std::array::from_fn(|k| self.start[k] + steps * self.step[k])
    }
}

#[cfg(test)]
mod tests;
