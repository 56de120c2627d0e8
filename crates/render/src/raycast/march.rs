//! One ray, step by step.

use super::{Cast, MOST_STEPS, RaycastOptions, leap::Clear};
use crate::{Gathered, Light, Ray, transfer::Lookup};
use isokit_geom::Affine;
use isokit_volume::{Sample, Scaling, View};

/// All that rays have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct March<'a, T> {
    view: &'a View<'a, T>,
    lookup: &'a Lookup<'a>,
    clear: Option<&'a Clear>,
    affine: Affine,
    /// What takes a gradient in index space to the world, as columns.
    covectors: [[f64; 3]; 3],
    /// The length of a step in world units.
    step: f64,
    light: Option<Light>,
    opaque: f32,
    scale: Scale,
}

/// What a stored sample means, in f32.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    slope: f32,
    intercept: f32,
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
        (lookup, clear): (&'a Lookup<'a>, Option<&'a Clear>),
        step: f64,
        options: &RaycastOptions,
    ) -> Self {
        let affine = view.frame().index_to_world;
        Self {
            view,
            lookup,
            clear,
            affine,
            covectors: affine.covector_columns(),
            step,
            light: options.light,
            opaque: options.opaque,
            scale: Scale::of(view.scaling()),
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
            // What is NaN hides nothing.
            let seen = match (value.is_nan(), (n as f64) < whole) {
                (true, _) => [0.0; 4],
                (_, true) => self.lookup.at(value),
                (_, false) => self.lookup.over(value.into(), way.steps - whole),
            };
            if seen[3] > 0.0 {
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

    /// Where a ray goes through the box from the first sample to the last. A volume of one sample along an axis has no
    /// inside.
    fn way(&self, ray: &Ray) -> Option<Way> {
        if self.view.dims().contains(&1) {
            return None;
        }
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
        // Not where a camera so far away that numbers end has made one that is no number, or no end.
        (steps > 0.0 && steps <= 2.0 * MOST_STEPS).then(|| Way {
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
            part[k] = ((place[k] - low as f64) as f32).clamp(0.0, 1.0);
            low
        });
        (cell, part)
    }

    /// The value in a cell.
    #[inline(always)]
    fn value(&self, cell: [usize; 3], [x, y, z]: [f32; 3]) -> f32 {
        let corners = self.view.cell(cell).map(|sample| sample.to_f64() as f32);
        let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
        let edge = |k: usize| mix(corners[k], corners[k + 1], x);
        let stored = mix(mix(edge(0), edge(2), y), mix(edge(4), edge(6), y), z);
        self.scale.value(stored)
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
    /// along each axis, which is what interpolating the central differences at samples gives; at the border and
    /// beside what has no value, by that of one side.
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
            let rise = |(below, low): (f64, f64), (above, high): (f64, f64)| {
                Some((above - below) / (high - low)).filter(|rise| rise.is_finite())
            };
            let (before, after) = (at(-1.0), at(1.0));
            let one_sided = || rise(before, at(0.0)).or_else(|| rise(at(0.0), after));
            rise(before, after).or_else(one_sided).unwrap_or(0.0)
        });
        let columns = &self.covectors;
        std::array::from_fn(|k| {
            columns[0][k] * part[0] + columns[1][k] * part[1] + columns[2][k] * part[2]
        })
    }
}

impl Scale {
    pub(super) fn of(scaling: Scaling) -> Self {
        Self { slope: scaling.slope() as f32, intercept: scaling.intercept() as f32 }
    }

    /// The value of a stored sample. Rounding keeps order: it never falls where samples rise, or never rises.
    #[inline(always)]
    pub(super) fn value(self, stored: f32) -> f32 {
        stored * self.slope + self.intercept
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
