//! One ray, step by step.

use super::{Cast, MOST_STEPS, Medium, RaycastOptions, leap::Clear};
use crate::{Gathered, Light, Ray, Trilinear, transfer::Lookup, trilinear::LANES};
use isokit_geom::{HalfSpace, vector::dot};
use isokit_volume::Sample;

/// All that rays have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct March<'a, T> {
    field: Trilinear<'a, T>,
    clips: &'a [HalfSpace],
    lookup: &'a Lookup<'a>,
    clear: Option<&'a Clear>,
    /// The length of a step in world units.
    step: f64,
    light: Option<Light>,
    opaque: f32,
}

/// The way of a ray through a volume: from the first number of steps to the last, where the last may be no whole
/// one.
struct Way {
    /// Where it begins, and how far one step leads, in index space.
    start: [f64; 3],
    step: [f64; 3],
    /// How many steps a sample's distance is, along each axis.
    pace: [f64; 3],
    /// How many steps it is long.
    steps: f64,
}

impl<'a, T: Sample> March<'a, T> {
    pub(super) fn new(
        medium: &Medium<'a, T>,
        (lookup, clear): (&'a Lookup<'a>, Option<&'a Clear>),
        step: f64,
        options: &RaycastOptions,
    ) -> Self {
        let (field, clips) = (Trilinear::new(*medium.view), medium.clips);
        let RaycastOptions { light, opaque, .. } = *options;
        Self { field, clips, lookup, clear, step, light, opaque }
    }

    /// What a ray gathers.
    pub(super) fn along(&self, ray: &Ray, done: &mut Cast) -> Gathered {
        let mut gathered = Gathered::NOTHING;
        let Some(way) = self.way(ray) else { return gathered };
        let (whole, count) = (way.steps.floor() as u64, way.steps.ceil() as u64);
        let mut values = [0.0; LANES];
        let mut n = 0;
        while n < count {
            let until = match self.clear {
                None => count,
                Some(clear) => {
                    let (around, is_clear) = clear.around(self.field.cell(way.middle(n)).0);
                    let next = way.leaving(around).clamp((n + 1) as f64, count as f64) as u64;
                    if is_clear {
                        done.steps_leapt += next - n;
                        n = next;
                        continue;
                    }
                    next
                }
            };
            // Whole steps, several at a time.
            while n < until.min(whole) {
                self.field.values(way.start, way.step, n as f64 + 0.5, &mut values);
                let most = (until.min(whole) - n).min(LANES as u64) as usize;
                for &value in &values[..most] {
                    done.steps += 1;
                    // What is NaN hides nothing.
                    let seen = if value.is_nan() { [0.0; 4] } else { self.lookup.at(value) };
                    if seen[3] > 0.0 {
                        gathered = gathered.over(self.lit(seen, way.middle(n), ray));
                        if gathered.opacity >= self.opaque {
                            done.steps_hidden += count - n - 1;
                            return gathered;
                        }
                    }
                    n += 1;
                }
            }
            // The last step may be a part of one.
            if n == whole && n < until {
                done.steps += 1;
                let place = way.middle(n);
                let (cell, part) = self.field.cell(place);
                let value = self.field.value(cell, part);
                let seen = match value.is_nan() {
                    true => [0.0; 4],
                    false => self.lookup.over(value.into(), way.steps - whole as f64),
                };
                if seen[3] > 0.0 {
                    gathered = gathered.over(self.lit(seen, place, ray));
                }
                n += 1;
            }
        }
        gathered
    }

    /// Where a ray goes through what is kept of the box from the first sample to the last.
    fn way(&self, ray: &Ray) -> Option<Way> {
        let [mut near, mut far] = self.field.interval(ray)?;
        for clip in self.clips {
            let (beyond, along) = (clip.beyond(ray.origin), dot(clip.normal(), ray.direction));
            let end = -beyond / along;
            match (along > 0.0, along < 0.0) {
                (true, _) => far = far.min(end),
                (_, true) => near = near.max(end),
                // Along the plane, on one side of it.
                _ if beyond > 0.0 => return None,
                _ => {}
            }
        }
        let steps = (far - near) / self.step;
        let affine = self.field.affine();
        let (origin, direction) =
            (affine.inverse_point(ray.origin), affine.inverse_vector(ray.direction));
        let step = direction.map(|c| c * self.step);
        (steps > 0.0 && steps <= 2.0 * MOST_STEPS).then(|| Way {
            start: std::array::from_fn(|k| origin[k] + near * direction[k]),
            step,
            pace: step.map(f64::recip),
            steps,
        })
    }

    /// What is seen at a place, under the light.
    #[inline(always)]
    fn lit(&self, [r, g, b, opacity]: [f32; 4], place: [f64; 3], ray: &Ray) -> Gathered {
        let Some(light) = &self.light else { return Gathered { color: [r, g, b], opacity } };
        let straight = [r, g, b].map(|part| part / opacity);
        let shaded = light.shade(straight, self.field.gradient(place), ray.direction);
        Gathered::new(shaded, opacity)
    }
}

impl Way {
    /// The middle of a step; that of the last, which may be a part of one, is nearer.
    #[inline(always)]
    fn middle(&self, n: u64) -> [f64; 3] {
        let (n, whole) = (n as f64, self.steps.floor());
        let middle = if n < whole { n + 0.5 } else { 0.5 * (whole + self.steps) };
        std::array::from_fn(|k| self.start[k] + middle * self.step[k])
    }

    /// The first step whose middle may be beyond a box that the way is in.
    #[inline(always)]
    fn leaving(&self, around: [[f64; 2]; 3]) -> f64 {
        let mut far = self.steps;
        for (k, ends) in around.into_iter().enumerate() {
            // Along an axis on which it does not move it does not leave.
            let leaves = match self.step[k] {
                0.0 => f64::INFINITY,
                step => (ends[usize::from(step > 0.0)] - self.start[k]) * self.pace[k],
            };
            far = if leaves < far { leaves } else { far };
        }
        // Rounded down: the middle of that step may still be in the box, and no other is passed over.
        (far - 0.5).floor()
    }
}
