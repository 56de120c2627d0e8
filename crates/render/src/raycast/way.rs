//! The ways of rays through a volume.

use super::{MOST_STEPS, Medium};
use crate::{Camera, Projection, Ray, Size, trilinear::cut};
use isokit_geom::{HalfSpace, vector::Vector};
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
    /// Where it leads in the world: of length 1.
    pub(super) towards: Vector,
}

/// The ways of the rays of a picture's pixels.
#[derive(Clone, Debug)]
pub(super) struct Ways<'a> {
    /// The last sample along x, y, z.
    last: [f64; 3],
    clips: &'a [HalfSpace],
    /// The length of a step.
    step: f64,
    /// Pixels.
    size: [f64; 2],
    /// Half a pixel, where the axes are 1 long.
    pitch: f64,
    is_perspective: bool,
    /// Where rays begin in the middle of the picture, and to the right, up and ahead, in the world and in index space.
    world: (Vector, [Vector; 3]),
    index: (Vector, [Vector; 3]),
}

impl<'a> Ways<'a> {
    /// None where rays have no way: through a volume that has no cells.
    pub(super) fn new<T: Sample>(
        medium: &Medium<'a, T>,
        (camera, size): (&Camera, Size),
        step: f64,
    ) -> Option<Self> {
        let (dims, affine) = (medium.view.dims(), medium.view.frame().index_to_world);
        let size = [size.width, size.height].map(|n| f64::from(n.get()));
        let index = camera.axes().map(|axis| affine.inverse_vector(axis));
        dims.iter().all(|&n| n > 1).then(|| Self {
            last: dims.map(|n| n as f64 - 1.0),
            clips: medium.clips,
            step,
            size,
            pitch: camera.half_height(1.0) / size[1],
            is_perspective: matches!(camera.projection(), Projection::Perspective { .. }),
            world: (camera.from(), camera.axes()),
            index: (affine.inverse_point(camera.from()), index),
        })
    }

    /// The way of the ray through a place of the picture, in pixels from its upper left corner, that begins with a part
    /// of a step. None beside what is kept of the volume.
    #[inline(always)]
    pub(super) fn through(&self, [x, y]: [f64; 2], begin: f64) -> Option<Way> {
        let [right, up] =
            [2.0 * x - self.size[0], self.size[1] - 2.0 * y].map(|halves| halves * self.pitch);
        let aside = |[to_right, to_up, _]: &[Vector; 3]| -> Vector {
            std::array::from_fn(|k| right * to_right[k] + up * to_up[k])
        };
        let ((from, world), (first, index)) = (&self.world, &self.index);
        let (mut ray, mut origin, mut direction);
        if self.is_perspective {
            let shorter = (1.0 + right * right + up * up).sqrt().recip();
            let ahead = |axes: &[Vector; 3]| -> Vector {
                let aside = aside(axes);
                std::array::from_fn(|k| (axes[2][k] + aside[k]) * shorter)
            };
            ray = Ray { origin: *from, direction: ahead(world) };
            (origin, direction) = (*first, ahead(index));
        } else {
            ray = Ray { origin: aside(world), direction: world[2] };
            (origin, direction) = (aside(index), index[2]);
            for k in 0..3 {
                ray.origin[k] += from[k];
                origin[k] += first[k];
            }
        }
        let (mut near, mut far) = (0.0_f64, f64::INFINITY);
        let mut cells = [f64::INFINITY; 3];
        for k in 0..3 {
            if direction[k] == 0.0 {
                // Beside the box, or in it all along.
                if !(0.0..=self.last[k]).contains(&origin[k]) {
                    return None;
                }
                continue;
            }
            cells[k] = direction[k].recip();
            let ends = [0.0, self.last[k]].map(|end| (end - origin[k]) * cells[k]);
            near = near.max(ends[0].min(ends[1]));
            far = far.min(ends[0].max(ends[1]));
        }
        let [near, far] = cut([near, far], &ray, self.clips)?;
        let steps = (far - near) / self.step;
        // Not where a camera so far away that numbers end has made one that is no number, or no end.
        if !(steps > 0.0 && steps <= 2.0 * MOST_STEPS) {
            return None;
        }
        let before = begin.min(steps);
        let at = near + before * self.step;
        for k in 0..3 {
            origin[k] += at * direction[k];
            direction[k] *= self.step;
            cells[k] /= self.step;
        }
        Some(Way {
            start: origin,
            step: direction,
            pace: cells,
            before,
            steps: steps - before,
            towards: ray.direction,
        })
    }
}

impl Way {
    /// The place after so many steps.
    #[inline(always)]
    pub(super) fn at(&self, steps: f64) -> [f64; 3] {
        std::array::from_fn(|k| self.start[k] + steps * self.step[k])
    }
}
