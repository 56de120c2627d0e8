//! Sheets in the space of samples.

use super::footprint::RADIUS;
use crate::{Camera, Projection, Size, Trilinear};
use isokit_geom::{
    Affine,
    vector::{Vector, cross, dot, length},
};
use isokit_volume::Sample;

/// Sheets through a volume, parallel to the picture and equally thick, front to back.
///
/// The kernel's space is that of the samples, divided by how much the kernel is widened: so that where a pixel is larger
/// than a sample no sample falls between pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheets {
    camera: Camera,
    size: Size,
    affine: Affine,
    /// How far ahead of the camera the first begins.
    begin: f64,
    step: f64,
    count: usize,
    widening: f64,
    /// The most samples from a pixel to the next, or from a sheet to the next.
    pitch: f64,
    /// How thick a sheet is in the kernel's space.
    thickness: f64,
}

/// One of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheet {
    /// How far ahead of the camera its front is.
    pub(super) front: f64,
    /// From the place of a sample to the nearest place on the middle of the sheet, in pixels from that in the upper left
    /// corner, and how far away it is in the kernel's space: factors of i, j, k, and a sum.
    column: [f64; 4],
    row: [f64; 4],
    away: [f64; 4],
    /// See [`shear`](Self::shear).
    along: f64,
    shear: f64,
    across: f64,
    /// How far one goes in pixels at most, to the right and down, on a distance of 1.
    reach: [f64; 2],
}

/// Where a sample is, seen from a sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub(super) column: f64,
    pub(super) row: f64,
    pub(super) away: f64,
}

/// Samples that are near each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Block {
    /// Along x, y, z the first, and one after the last.
    pub(super) samples: [[usize; 2]; 3],
    /// The first sheet and the last to which they give something.
    pub(super) sheets: [usize; 2],
    /// To the right and down, the first pixel and the last.
    pub(super) pixels: [[usize; 2]; 2],
}

/// Pixels around what is looked at that count for gradients.
pub(super) const APRON: usize = 1;

impl Sheets {
    /// Through all of a volume that is before the camera; none if nothing is.
    pub(super) fn new<T: Sample>(
        field: &Trilinear<'_, T>,
        (camera, size): (&Camera, Size),
        step: f64,
    ) -> Option<Self> {
        let (affine, dims) = (*field.affine(), field.view().dims());
        if dims.contains(&1) {
            return None;
        }
        let corners = (0..8).map(|n| -> Vector {
            let corner =
                std::array::from_fn(|k| if n >> k & 1 == 1 { dims[k] as f64 - 1.0 } else { 0.0 });
            camera.view(affine.point(corner))
        });
        let [least, most] = corners
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [.., ahead]| {
                [a.min(ahead), b.max(ahead)]
            });
        let begin = least.max(0.0);
        let count = ((most - begin) / step).ceil();
        if !(count > 0.0 && count <= crate::raycast::MOST_STEPS) {
            return None;
        }
        let [right, up, forward] = camera.axes();
        // The most that a pixel is wide, in samples.
        let pixel = 2.0 * camera.half_height(most) / f64::from(size.height.get());
        let samples = |direction: Vector, far: f64| length(affine.inverse_vector(direction)) * far;
        let wide = samples(right, pixel).max(samples(up, pixel));
        let widening = wide.max(1.0);
        // To the next sheet one goes along the ray, which leads aside too.
        let [aside, above] = match camera.projection() {
            Projection::Parallel { .. } => [0.0; 2],
            Projection::Perspective { .. } => {
                let tall = camera.half_height(1.0);
                let [width, height] = [size.width, size.height].map(|n| f64::from(n.get()));
                [tall * width / height, tall]
            }
        };
        let through =
            samples(forward, step) + samples(right, step * aside) + samples(up, step * above);
        let pitch = wide.max(through);
        let mut sheets = Self {
            camera: *camera,
            size,
            affine,
            begin,
            step,
            count: count as usize,
            widening,
            pitch,
            thickness: 0.0,
        };
        let (_, along) = sheets.frame(begin + step);
        let normal = cross(along[0], along[1]);
        let through = affine.inverse_vector(forward).map(|c| c * step / widening);
        sheets.thickness = (dot(through, normal) / length(normal)).abs();
        sheets.thickness.is_normal().then_some(sheets)
    }

    pub(super) fn step(&self) -> f64 {
        self.step
    }

    pub(super) fn widening(&self) -> f64 {
        self.widening
    }

    /// How far from a sample, in samples, it gives something.
    pub(super) fn reach(&self) -> f64 {
        (RADIUS + 0.5 * self.thickness) * self.widening
    }

    pub(super) fn pitch(&self) -> f64 {
        self.pitch
    }

    pub(super) fn thickness(&self) -> f64 {
        self.thickness
    }

    /// In the kernel's space: the place of the middle of the first pixel at a depth, and how far a pixel to the right and
    /// one down lead.
    fn frame(&self, ahead: f64) -> (Vector, [Vector; 2]) {
        let [right, up, forward] = self.camera.axes();
        let [width, height] = [self.size.width, self.size.height].map(|n| f64::from(n.get()));
        let half = self.camera.half_height(ahead);
        let (x, y) = ((1.0 - width) / height * half, (height - 1.0) / height * half);
        let from = self.camera.from();
        let place: Vector =
            std::array::from_fn(|k| from[k] + ahead * forward[k] + x * right[k] + y * up[k]);
        let pixel = 2.0 * half / height;
        let vector = |v: Vector| self.affine.inverse_vector(v).map(|c| c * pixel / self.widening);
        let place = self.affine.inverse_point(place).map(|c| c / self.widening);
        (place, [vector(right), vector(up).map(|c| -c)])
    }

    pub(super) fn sheet(&self, number: usize) -> Sheet {
        let front = self.begin + number as f64 * self.step;
        let (place, [x, y]) = self.frame(front + 0.5 * self.step);
        let [a, b, c] = [dot(x, x), dot(x, y), dot(y, y)];
        let normal = cross(x, y);
        let long = length(normal);
        let square = long * long;
        // Of w, from `place` to the sample: where x and y lead as near to it as they can.
        let row = |v: Vector| -> [f64; 4] {
            let [i, j, k] = v.map(|c| c / self.widening);
            [i, j, k, -dot(v, place)]
        };
        let mix =
            |p: f64, q: f64| -> Vector { std::array::from_fn(|k| (p * x[k] + q * y[k]) / square) };
        Sheet {
            front,
            column: row(mix(c, -b)),
            row: row(mix(-b, a)),
            away: row(normal.map(|c| c / long)),
            along: a,
            shear: b / a,
            across: square / a,
            reach: [c, a].map(|c| c.sqrt() / long),
        }
    }

    /// What samples give something to; none if they give nothing to the picture.
    pub(super) fn block(&self, samples: [[usize; 2]; 3]) -> Option<Block> {
        let corners = (0..8).map(|n| -> Vector {
            std::array::from_fn(|k| {
                let [first, end] = samples[k];
                if n >> k & 1 == 1 { end as f64 - 1.0 } else { first as f64 }
            })
        });
        let corners: [Vector; 8] = {
            let mut all = [[0.0; 3]; 8];
            all.iter_mut().zip(corners).for_each(|(to, corner)| *to = corner);
            all
        };
        let reach = RADIUS + 0.5 * self.thickness;
        let first = self.sheet(0);
        // Sheets follow each other at the same distances: which one would go through a sample.
        let sign = (self.sheet(1).away[3] - first.away[3]).signum();
        let through = corners.map(|corner| -sign * first.spot(corner).away / self.thickness);
        let least = through.iter().fold(f64::INFINITY, |a, b| a.min(*b));
        let most = through.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
        let last = self.count as f64 - 1.0;
        let ends = [
            (least - reach / self.thickness).ceil().max(0.0),
            (most + reach / self.thickness).floor().min(last),
        ];
        if ends[0].is_nan() || ends[1].is_nan() || ends[0] > ends[1] {
            return None;
        }
        let sheets = ends.map(|end| end as usize);
        // Between these two, places on sheets move steadily.
        let mut pixels = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for sheet in sheets.map(|number| self.sheet(number)) {
            for spot in corners.map(|corner| sheet.spot(corner)) {
                for (axis, middle) in [spot.column, spot.row].into_iter().enumerate() {
                    let wide = RADIUS * sheet.reach[axis];
                    let [low, high] = &mut pixels[axis];
                    (*low, *high) = (low.min(middle - wide), high.max(middle + wide));
                }
            }
        }
        let most = [self.size.width, self.size.height].map(|n| f64::from(n.get()) - 1.0);
        let mut found = [[0; 2]; 2];
        for axis in 0..2 {
            let [low, high] = pixels[axis];
            let apron = APRON as f64;
            let (low, high) =
                ((low - apron).ceil().max(0.0), (high + apron).floor().min(most[axis]));
            if low.is_nan() || high.is_nan() || low > high {
                return None;
            }
            found[axis] = [low as usize, high as usize];
        }
        Some(Block { samples, sheets, pixels: found })
    }

    /// How a pixel's ray leads: to the right and up for each length ahead.
    pub(super) fn slopes(&self, [column, row]: [usize; 2]) -> [f64; 2] {
        let [width, height] = [self.size.width, self.size.height].map(|n| f64::from(n.get()));
        match self.camera.projection() {
            Projection::Parallel { .. } => [0.0; 2],
            Projection::Perspective { .. } => {
                let half = self.camera.half_height(1.0);
                let [x, y] = [column as f64 + 0.5, row as f64 + 0.5];
                [(2.0 * x - width) / height * half, (height - 2.0 * y) / height * half]
            }
        }
    }

    /// How wide a pixel is in the world, so far ahead.
    pub(super) fn pixel(&self, ahead: f64) -> f64 {
        2.0 * self.camera.half_height(ahead) / f64::from(self.size.height.get())
    }
}

impl Sheet {
    #[inline(always)]
    pub(super) fn spot(&self, [i, j, k]: Vector) -> Spot {
        let at = |[x, y, z, sum]: [f64; 4]| x * i + y * j + z * k + sum;
        Spot { column: at(self.column), row: at(self.row), away: at(self.away) }
    }

    /// How far one goes in pixels at most, to the right and down, on such a distance.
    #[inline(always)]
    pub(super) fn reach(&self, radius: f64) -> [f64; 2] {
        self.reach.map(|reach| radius * reach)
    }

    /// See [`shear`](Self::shear).
    #[inline(always)]
    pub(super) fn squares(&self) -> [f64; 2] {
        [self.along, self.across]
    }

    /// The square of the distance of a pixel that is x to the right and y below is
    /// `squares()[0] · (x + shear() · y)² + squares()[1] · y²`.
    #[inline(always)]
    pub(super) fn shear(&self) -> f64 {
        self.shear
    }
}

impl Block {
    pub(super) fn samples(&self) -> u64 {
        self.samples.iter().map(|[first, end]| (end - first) as u64).product()
    }
}
