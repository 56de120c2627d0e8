//! Rays side by side, step by step.
//!
//! What a ray gathers does not depend on those beside it: each has its own steps, and when one ends, the next takes its
//! place.

use super::{Cast, Cloud, MOST_STEPS, Medium, RaycastOptions};
use crate::{
    Gathered, Light, Ray, Trilinear,
    clear::Clear,
    transfer::{Lookup, Place, Scale, Values},
};
use isokit_geom::{
    HalfSpace,
    vector::{Vector, length},
};
use isokit_lanes::{Between, Blocks, Facing, Found, LINES, Lines};
use isokit_volume::Sample;

/// All that rays have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct March<'a, T> {
    field: Trilinear<'a, T>,
    /// None where no ray has a way through: there are no cells.
    between: Option<Between<'a, T>>,
    /// What takes a gradient in index space to the direction that it has in the world.
    covectors: [[f32; 3]; 3],
    /// How long a gradient of length 1 is that is found so.
    rise: f64,
    clips: &'a [HalfSpace],
    lookup: &'a Lookup<'a>,
    /// Where nothing can be seen: as it is, and for leaps.
    clear: Option<(&'a Clear, Blocks<'a>)>,
    /// The length of a step in world units.
    step: f64,
    light: Option<Light>,
    cloud: Option<&'a Cloud>,
    opaque: f32,
}

/// The way of a ray through a volume: from the first number of steps to the last, where the last may be no whole
/// one.
#[derive(Clone, Copy, Debug, Default)]
struct Way {
    /// Where it begins, and how far one step leads, in index space.
    start: [f64; 3],
    step: [f64; 3],
    /// How many steps it is long.
    steps: f64,
    /// How many of them its first, if that is no whole one.
    begin: f64,
    /// Where it leads in the world.
    towards: Vector,
}

/// Rays side by side.
#[derive(Default)]
struct Front {
    lines: Lines,
    /// How many steps it is to the middle of the next step of each.
    steps: [f64; LINES],
    /// How many whole steps each has.
    whole: [f64; LINES],
    /// How many steps a cell is long on each, along x, y, z: without end where it does not move.
    pace: [[f64; LINES]; 3],
    facing: Facing,
    gathered: [Gathered; LINES],
    ways: [Way; LINES],
    /// The number of its pixel.
    pixels: [usize; LINES],
    /// The bits of those that are on their way.
    live: u16,
}

impl<'a, T: Sample> March<'a, T> {
    pub(super) fn new(
        medium: &Medium<'a, T>,
        (lookup, clear, cloud): (&'a Lookup<'a>, Option<&'a Clear>, Option<&'a Cloud>),
        step: f64,
        options: &RaycastOptions,
    ) -> Self {
        let (field, clips) = (Trilinear::new(*medium.view), medium.clips);
        let RaycastOptions { light, opaque, .. } = *options;
        let clear = clear.and_then(|clear| Some((clear, clear.blocks()?)));
        let between = medium.view.samples().and_then(Between::new);
        let columns = [0, 1, 2].map(|axis| field.across(axis));
        let greatest = columns.as_flattened().iter().fold(0.0, |most: f64, c| most.max(c.abs()));
        let covectors = columns.map(|column| column.map(|c| (c / greatest) as f32));
        // Differences are over two samples.
        let rise = 0.5 * greatest * medium.view.scaling().slope().abs();
        Self { field, between, covectors, rise, clips, lookup, clear, step, light, cloud, opaque }
    }

    /// What rays gather, each with the number of its pixel and the part of a step that it begins with.
    pub(super) fn along(
        &self,
        mut rays: impl Iterator<Item = (usize, Ray, f64)>,
        pixels: &mut [Gathered],
        done: &mut Cast,
    ) {
        let Some(between) = &self.between else { return };
        let mut front = Front::default();
        front.facing.covectors = self.covectors;
        let (table, mut found) =
            (self.lookup.table(Scale::of(self.field.view().scaling())), Found::default());
        let mut due = u16::MAX;
        loop {
            while due != 0 {
                let n = due.trailing_zeros() as usize;
                due &= due - 1;
                if front.live >> n & 1 == 1 {
                    self.end(&mut front, n, done);
                    pixels[front.pixels[n]] = front.gathered[n];
                }
                let mut ways = rays
                    .by_ref()
                    .filter_map(|(pixel, ray, begin)| Some((pixel, self.way(&ray, begin)?)));
                front.next(n, ways.next());
                if front.live >> n & 1 == 1 && front.ways[n].begin > 0.0 {
                    let way = &front.ways[n];
                    let first = self.partial(way, [0.0, way.begin.min(way.steps)], done);
                    front.gathered[n] = first;
                }
            }
            if front.live == 0 {
                return;
            }
            let ready = self.leap(&mut front, done);
            due = 0;
            if ready != 0 {
                let places = (&front.lines, &front.steps);
                let facing = self.has_gradients().then_some(&front.facing);
                between.look(places, ready, &table, facing, &mut found);
                done.steps += u64::from(ready.count_ones());
                due = if found.seen == 0 { 0 } else { self.gather(&mut found, &mut front) };
            }
            for n in 0..LINES {
                front.steps[n] += f64::from(ready >> n & 1);
                due |= u16::from(front.steps[n] > front.whole[n]) << n;
            }
            due &= front.live;
        }
    }

    /// Leads rays to steps of which something may be seen; the bits of those that are there.
    #[inline(always)]
    fn leap(&self, front: &mut Front, done: &mut Cast) -> u16 {
        /// With so many there the others wait for nobody: they go on while those are looked at.
        const ENOUGH: u32 = 12;
        let on_their_way = |front: &Front| {
            let mut bits = 0;
            for n in 0..LINES {
                bits |= u16::from(front.steps[n] < front.whole[n]) << n;
            }
            bits & front.live
        };
        let mut going = on_their_way(front);
        let Some((_, blocks)) = &self.clear else { return going };
        let (before, mut ready) = (front.steps, 0_u16);
        while going != 0 && ready.count_ones() < ENOUGH {
            let Front { lines, pace, whole, steps, .. } = &mut *front;
            ready |= blocks.leap(lines, pace, whole, going, steps);
            going = on_their_way(front) & !ready;
        }
        let leapt = |n: usize| front.steps[n] - before[n];
        done.steps_leapt += (0..LINES).map(leapt).sum::<f64>() as u64;
        ready
    }

    /// Adds the last step of a ray, if it is a part of one and not hidden.
    fn end(&self, front: &mut Front, n: usize, done: &mut Cast) {
        let (way, at) = (&front.ways[n], front.steps[n] - 0.5);
        let left = way.steps - at;
        if front.gathered[n].opacity >= self.opaque {
            done.steps_hidden += left.ceil() as u64;
        } else if left > 0.0 {
            let last = self.partial(way, [at, way.steps], done);
            front.gathered[n] = front.gathered[n].over(last);
        }
    }

    /// What is seen in a part of a step, if something may be.
    #[inline(never)]
    fn partial(&self, way: &Way, [from, to]: [f64; 2], done: &mut Cast) -> Gathered {
        let place = way.at(0.5 * (from + to));
        if self.clear.is_some_and(|(clear, _)| clear.is_clear(place)) {
            done.steps_leapt += 1;
            return Gathered::NOTHING;
        }
        done.steps += 1;
        let value = self.field.at_index(place);
        if value.is_nan() {
            return Gathered::NOTHING;
        }
        let share = self.cloud.map_or(1.0, |cloud| cloud.light(place));
        self.exact(way, place, value, to - from).dimmed(share)
    }

    fn exact(&self, way: &Way, place: [f64; 3], value: f64, part: f64) -> Gathered {
        if !self.has_gradients() {
            return self.lookup.exact([value, 0.0], part, None);
        }
        let gradient = self.field.gradient(place);
        let shade = self.light.map(|light| light.answer(gradient, way.towards));
        self.lookup.exact([value, length(gradient)], part, shade)
    }

    /// Whether anybody asks for gradients.
    fn has_gradients(&self) -> bool {
        self.light.is_some() || self.lookup.has_slopes()
    }

    /// Adds what is seen in the next step of each ray; the bits of those that are as good as opaque then.
    #[inline(always)]
    fn gather(&self, found: &mut Found, front: &mut Front) -> u16 {
        let shades = self.shades(found, front);
        if let (Some(values), None) = (self.lookup.values(), self.cloud) {
            return self.gather_values(&values, found, shades.as_ref(), front);
        }
        let (mut left, mut opaque) = (found.seen, 0);
        while left != 0 {
            let n = left.trailing_zeros() as usize;
            left &= left - 1;
            let place = Place {
                part: found.parts[n] as usize,
                share: found.shares[n],
                value: found.values[n],
                slope: f64::from(found.slopes[n]) * self.rise,
            };
            let shade = shades.as_ref().map(|[matt, gloss]| [matt[n], gloss[n]]);
            let mut next = self.lookup.gathered(place, shade);
            if let Some(cloud) = self.cloud {
                next = next.dimmed(cloud.light(front.ways[n].at(front.steps[n])));
            }
            let gathered = front.gathered[n].over(next);
            front.gathered[n] = gathered;
            opaque |= u16::from(gathered.opacity >= self.opaque) << n;
        }
        opaque
    }

    /// The same where nothing but values counts: all four parts of a colour at once.
    #[inline(always)]
    fn gather_values(
        &self,
        values: &Values<'_>,
        found: &Found,
        shades: Option<&[[f32; LINES]; 2]>,
        front: &mut Front,
    ) -> u16 {
        let (mut left, mut opaque) = (found.seen, 0);
        while left != 0 {
            let n = left.trailing_zeros() as usize;
            left &= left - 1;
            let (part, share) = (found.parts[n] as usize, found.shares[n]);
            let mut next = values.within(part, share).unwrap_or_else(|| {
                four(self.lookup.exact([found.values[n].into(), 0.0], 1.0, None))
            });
            if let Some([matt, gloss]) = shades {
                // As `Gathered::lit`; the opacity stays as it is.
                let (shade, white) = ([matt[n], matt[n], matt[n], 1.0], next[3] * gloss[n]);
                let opacity = next[3];
                let add = [white, white, white, 0.0];
                for k in 0..4 {
                    next[k] = (next[k] * shade[k] + add[k]).min(opacity);
                }
            }
            let mut gathered = four(front.gathered[n]);
            let open = 1.0 - gathered[3];
            for k in 0..4 {
                gathered[k] += open * next[k];
            }
            let [r, g, b, opacity] = gathered;
            front.gathered[n] = Gathered { color: [r, g, b], opacity };
            opaque |= u16::from(opacity >= self.opaque) << n;
        }
        opaque
    }

    /// How gradients answer the light, matt and in gloss, if there is one. Of steps in which nothing is seen anything.
    /// Slopes that were not found are put in.
    #[inline(always)]
    fn shades(&self, found: &mut Found, front: &Front) -> Option<[[f32; LINES]; 2]> {
        let mut shades = self.light.map(|light| light.shares(found.cosines));
        let mut odd = found.odd;
        while odd != 0 {
            let n = odd.trailing_zeros() as usize;
            odd &= odd - 1;
            let way = &front.ways[n];
            let gradient = self.field.gradient(way.at(front.steps[n]));
            found.slopes[n] = (length(gradient) / self.rise) as f32;
            if let (Some(light), Some([matt, gloss])) = (&self.light, &mut shades) {
                [matt[n], gloss[n]] = light.answer(gradient, way.towards);
            }
        }
        shades
    }

    /// Where a ray goes through what is kept of the box from the first sample to the last.
    fn way(&self, ray: &Ray, begin: f64) -> Option<Way> {
        let [near, far] = self.field.interval_within(ray, self.clips)?;
        let steps = (far - near) / self.step;
        let affine = self.field.affine();
        let (origin, direction) =
            (affine.inverse_point(ray.origin), affine.inverse_vector(ray.direction));
        let step = direction.map(|c| c * self.step);
        (steps > 0.0 && steps <= 2.0 * MOST_STEPS).then(|| Way {
            start: std::array::from_fn(|k| origin[k] + near * direction[k]),
            step,
            steps,
            begin,
            towards: ray.direction,
        })
    }
}

impl Front {
    /// Puts the next ray at the beginning of its way, if there is one.
    fn next(&mut self, n: usize, next: Option<(usize, Way)>) {
        self.live &= !(1 << n);
        let Some((pixel, way)) = next else { return };
        self.live |= 1 << n;
        let long = length(way.towards);
        for k in 0..3 {
            self.lines.start[k][n] = way.start[k];
            self.lines.step[k][n] = way.step[k];
            // Upwards where it does not move: there it does not leave.
            let is_still = way.step[k] == 0.0;
            self.pace[k][n] = if is_still { f64::INFINITY } else { way.step[k].recip() };
            self.facing.towards[k][n] = (way.towards[k] / long) as f32;
        }
        let whole = (way.steps - way.begin).max(0.0).floor();
        (self.steps[n], self.whole[n]) = (way.begin + 0.5, way.begin + whole);
        (self.ways[n], self.pixels[n], self.gathered[n]) = (way, pixel, Gathered::NOTHING);
    }
}

/// Colour and opacity side by side.
#[inline(always)]
fn four(gathered: Gathered) -> [f32; 4] {
    let [r, g, b] = gathered.color;
    [r, g, b, gathered.opacity]
}

impl Way {
    /// The place after so many steps.
    #[inline(always)]
    fn at(&self, steps: f64) -> [f64; 3] {
        std::array::from_fn(|k| self.start[k] + steps * self.step[k])
    }
}
