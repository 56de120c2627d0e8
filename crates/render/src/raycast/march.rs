//! One ray, step by step.

use super::{Cast, RaycastOptions, leap::Clear};
use crate::{Gathered, Light, Ray, TransferFunction, gather::opacity_over, transfer::Lookup};
use isokit_geom::Affine;
use isokit_volume::{Sample, View};

/// All that rays have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct March<'a, T> {
    view: &'a View<'a, T>,
    transfer: &'a TransferFunction,
    lookup: &'a Lookup,
    clear: Option<&'a Clear>,
    affine: Affine,
    /// What takes a gradient in index space to the world, as columns.
    covectors: [[f64; 3]; 3],
    /// The length of a step, and the length over which opacities are gathered, in world units.
    step: f64,
    unit: f64,
    light: Option<Light>,
    opaque: f32,
    scaling: [f32; 2],
}

/// The way of a ray through a volume: from the first number of steps to the last, where the last may be no whole
/// one.
struct Way {
    /// Where it begins, and how far one step leads, in index space.
    start: [f64; 3],
    step: [f64; 3],
    /// How many steps it is long.
    steps: f64,
}

impl<'a, T: Sample> March<'a, T> {
    pub(super) fn new(
        view: &'a View<'a, T>,
        transfer: &'a TransferFunction,
        (lookup, clear): (&'a Lookup, Option<&'a Clear>),
        (step, unit): (f64, f64),
        options: &RaycastOptions,
    ) -> Self {
        let affine = view.frame().index_to_world;
        Self {
            view,
            transfer,
            lookup,
            clear,
            affine,
            covectors: affine.covector_columns(),
            step,
            unit,
            light: options.light,
            opaque: options.opaque,
            scaling: [view.scaling().slope() as f32, view.scaling().intercept() as f32],
        }
    }

    /// What a ray gathers.
    pub(super) fn along(&self, ray: &Ray, done: &mut Cast) -> Gathered {
        let mut gathered = Gathered::NOTHING;
        let Some(way) = self.way(ray) else { return gathered };
        let whole = way.steps.floor();
        let count = way.steps.ceil() as u64;
        let mut n = 0;
        while n < count {
            // The last step may be a part of one: its middle is nearer.
            let middle =
                if (n as f64) < whole { n as f64 + 0.5 } else { 0.5 * (whole + way.steps) };
            let place: [f64; 3] = std::array::from_fn(|k| way.start[k] + middle * way.step[k]);
            let (cell, part) = self.cell(place);
            if let Some(around) = self.clear.and_then(|clear| clear.around(cell)) {
                let next = way.leaving(around).clamp((n + 1) as f64, count as f64) as u64;
                done.steps_leapt += next - n;
                n = next;
                continue;
            }
            done.steps += 1;
            let value = self.value(cell, part);
            let mut seen = self.lookup.at(value);
            if (n as f64) >= whole {
                seen = self.of_part(value, way.steps - whole);
            }
            // What is NaN hides nothing.
            if seen[3] > 0.0 && !value.is_nan() {
                gathered = gathered.over(self.lit(seen, place, ray));
                if gathered.opacity >= self.opaque {
                    done.steps_hidden += count - n - 1;
                    break;
                }
            }
            n += 1;
        }
        gathered
    }

    /// Where a ray goes through the box from the first sample to the last.
    fn way(&self, ray: &Ray) -> Option<Way> {
        let origin = self.affine.inverse_point(ray.origin);
        let direction = self.affine.inverse_vector(ray.direction);
        let (mut near, mut far) = (0.0_f64, f64::INFINITY);
        for k in 0..3 {
            let last = self.view.dims()[k] as f64 - 1.0;
            let ends = [0.0, last].map(|end| (end - origin[k]) / direction[k]);
            if direction[k] == 0.0 {
                // Beside the box, or in it all along.
                if !(0.0..=last).contains(&origin[k]) {
                    return None;
                }
                continue;
            }
            near = near.max(ends[0].min(ends[1]));
            far = far.min(ends[0].max(ends[1]));
        }
        let steps = (far - near) / self.step;
        (steps > 0.0).then(|| Way {
            start: std::array::from_fn(|k| origin[k] + near * direction[k]),
            step: direction.map(|c| c * self.step),
            steps,
        })
    }

    /// The cell of a place, and how far in it the place is along each axis, from 0 to 1. Rounding may lead out of the
    /// volume; the nearest cell goes on there.
    #[inline(always)]
    fn cell(&self, place: [f64; 3]) -> ([usize; 3], [f32; 3]) {
        let mut part = [0.0; 3];
        let cell = std::array::from_fn(|k| {
            // What is below 0 becomes 0.
            let low = (place[k] as usize).min(self.view.dims()[k].saturating_sub(2));
            part[k] = (place[k] - low as f64) as f32;
            low
        });
        (cell, part)
    }

    /// The value in a cell.
    #[inline(always)]
    fn value(&self, cell: [usize; 3], [x, y, z]: [f32; 3]) -> f32 {
        let corners = self.corners(cell);
        let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
        let edge = |k: usize| mix(corners[k], corners[k + 1], x);
        let stored = mix(mix(edge(0), edge(2), y), mix(edge(4), edge(6), y), z);
        stored * self.scaling[0] + self.scaling[1]
    }

    /// The samples at the corners of a cell. Along an axis of one sample both ends are that one.
    #[inline(always)]
    fn corners(&self, cell: [usize; 3]) -> [f32; 8] {
        if self.view.dims().iter().all(|&n| n > 1) {
            return self.view.cell(cell).map(|sample| sample.to_f64() as f32);
        }
        std::array::from_fn(|corner| {
            let at = |k: usize| (cell[k] + (corner >> k & 1)).min(self.view.dims()[k] - 1);
            self.view.stored([at(0), at(1), at(2)]).to_f64() as f32
        })
    }

    /// Colour times opacity, and opacity, of a value over a part of a step.
    #[cold]
    fn of_part(&self, value: f32, part: f64) -> [f32; 4] {
        let point = self.transfer.at(value.into());
        let opacity = opacity_over(point.opacity.into(), part * self.step / self.unit) as f32;
        let [r, g, b] = point.color.map(|part| part * opacity);
        [r, g, b, opacity]
    }

    /// What is seen at a place, under the light.
    #[inline(always)]
    fn lit(&self, [r, g, b, opacity]: [f32; 4], place: [f64; 3], ray: &Ray) -> Gathered {
        let Some(light) = &self.light else { return Gathered { color: [r, g, b], opacity } };
        let straight = [r, g, b].map(|part| part / opacity);
        let shaded = light.shade(straight, self.gradient(place), ray.direction);
        Gathered::new(shaded, opacity)
    }

    /// The gradient in the world, but for its length: by central differences of values a sample before and after
    /// along each axis, which is what interpolating the central differences at samples gives.
    #[inline(always)]
    fn gradient(&self, place: [f64; 3]) -> [f64; 3] {
        let dims = self.view.dims();
        let part: [f64; 3] = std::array::from_fn(|k| {
            let at = |offset: f64| {
                let mut there = place;
                there[k] = (place[k] + offset).clamp(0.0, dims[k] as f64 - 1.0);
                let (cell, part) = self.cell(there);
                (f64::from(self.value(cell, part)), there[k])
            };
            let ((below, low), (above, high)) = (at(-1.0), at(1.0));
            if high > low { (above - below) / (high - low) } else { 0.0 }
        });
        let columns = &self.covectors;
        std::array::from_fn(|k| {
            columns[0][k] * part[0] + columns[1][k] * part[1] + columns[2][k] * part[2]
        })
    }
}

impl Way {
    /// The first step whose middle may be beyond a box that the way is in.
    #[inline(always)]
    fn leaving(&self, around: [[f64; 2]; 3]) -> f64 {
        let mut far = self.steps;
        for k in 0..3 {
            let end = around[k][usize::from(self.step[k] > 0.0)];
            let leaves = (end - self.start[k]) / self.step[k];
            // Along an axis on which it does not move it does not leave: infinite, or NaN.
            far = if leaves < far { leaves } else { far };
        }
        // Rounded down: the middle of that step may still be in the box, and no other is passed over.
        (far - 0.5).floor()
    }
}
