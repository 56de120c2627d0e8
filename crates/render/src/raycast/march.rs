//! Rays side by side, step by step.
//!
//! What a ray gathers does not depend on those beside it: each has its own steps, and when one ends, the next takes its
//! place.

use super::{
    Cast, Cloud, Medium, RaycastOptions,
    ends::Ends,
    way::{Pixel, Sights, Way},
};
use crate::{
    Gathered, Interpolant, Light,
    clear::Clear,
    transfer::{Lookup, Place, Scale},
};
use isokit_geom::vector::length;
use isokit_lanes::{Between, Blocks, Facing, Found, LINES, Layers, Lines, Next, OnTheWay};
use isokit_volume::Sample;

/// All that rays have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct March<'a, T> {
    pub(super) field: Interpolant<'a, T>,
    /// None where no ray has a way through: there are no cells.
    between: Option<Between<'a, T>>,
    /// What takes a gradient in index space to the direction that it has in the world.
    covectors: [[f32; 3]; 3],
    /// How long a gradient of length 1 is that is found so.
    rise: f64,
    pub(super) lookup: &'a Lookup<'a>,
    /// Where nothing can be seen: as it is, and for leaps.
    clear: Option<(&'a Clear, Blocks<'a>)>,
    pub(super) light: Option<Light>,
    cloud: Option<&'a Cloud>,
    pub(super) opaque: f32,
}

/// Rays' ways, and places on them as lines and how many steps lead along each.
pub(super) type Places<'a> = (&'a [Way; LINES], (&'a Lines, &'a [f64; LINES]));

/// Rays side by side. In memory as they stand here, so that what registers are filled from does not lie across cache
/// lines.
#[derive(Default)]
#[repr(C)]
pub(super) struct Front {
    pub(super) lines: Lines,
    /// Each to the middle of its next step, of its whole ones.
    pub(super) on: OnTheWay,
    pub(super) facing: Facing,
    layers: Layers,
    /// What is known of the beginnings of those steps.
    pub(super) ends: Ends,
    pub(super) ways: [Way; LINES],
    /// The number of its pixel.
    pixels: [usize; LINES],
    /// The bits of those that are on their way.
    live: u16,
}

impl<'a, T: Sample> March<'a, T> {
    pub(super) fn new(
        medium: &Medium<'a, T>,
        (lookup, clear, cloud): (&'a Lookup<'a>, Option<&'a Clear>, Option<&'a Cloud>),
        options: &RaycastOptions,
    ) -> Self {
        let RaycastOptions { light, opaque, kernel, .. } = *options;
        let field = Interpolant::new(*medium.view, kernel);
        let clear = clear.and_then(|clear| Some((clear, clear.blocks()?)));
        let between = medium.view.samples().and_then(Between::new);
        let columns = [0, 1, 2].map(|axis| field.linear.across(axis));
        let greatest = columns.as_flattened().iter().fold(0.0, |most: f64, c| most.max(c.abs()));
        let covectors = columns.map(|column| column.map(|c| (c / greatest) as f32));
        // Differences are over two samples.
        let rise = 0.5 * greatest * medium.view.scaling().slope().abs();
        Self { field, between, covectors, rise, lookup, clear, light, cloud, opaque }
    }

    /// What rays gather on their ways, each with the number of its pixel.
    pub(super) fn along(
        &self,
        mut ways: Sights<'_, impl Iterator<Item = Pixel>>,
        pixels: &mut [Gathered],
        done: &mut Cast,
    ) {
        let Some(between) = &self.between else { return };
        let mut front = Front::default();
        front.facing.covectors = self.covectors;
        let (table, mut found) =
            (self.lookup.table(Scale::of(self.field.linear.view().scaling())), Found::default());
        let (mut due, mut advanced, mut looked) = (u16::MAX, 0.0, 0);
        loop {
            while due != 0 {
                let n = due.trailing_zeros() as usize;
                due &= due - 1;
                if front.live >> n & 1 == 1 {
                    let (gathered, at) = self.end(&front, n, done);
                    advanced += at;
                    pixels[front.pixels[n]] = gathered;
                }
                front.next(n, ways.next(done));
                if front.live >> n & 1 == 1 && front.ways[n].before > 0.0 {
                    let way = front.ways[n];
                    front.set(n, self.partial(&way, [-way.before, 0.0], done));
                }
            }
            if front.live == 0 {
                break;
            }
            let ready = self.lead(&mut front);
            let mut are_opaque = 0;
            looked += u64::from(ready.count_ones());
            let asked = (between, &table);
            if ready != 0 && self.lookup.has_integrals() {
                are_opaque = self.gather_between(asked, ready, &mut front, &mut found);
            } else if ready != 0 {
                let facing = self.has_gradients().then_some(&front.facing);
                self.look(asked, front.after(&front.on.steps), ready, facing, &mut found);
                if found.seen != 0 {
                    are_opaque = self.gather(&mut found, &mut front);
                }
            }
            due = (are_opaque | front.on.advance(ready)) & front.live;
        }
        done.steps += looked;
        done.steps_leapt += advanced as u64 - looked;
    }

    /// Leads rays to steps of which something may be seen; the bits of those that are there.
    #[inline(always)]
    fn lead(&self, front: &mut Front) -> u16 {
        let Front { lines, live, on, .. } = front;
        if let Some((_, blocks)) = &self.clear {
            return blocks.lead(lines, *live, on);
        }
        let is_going = |n: usize| u16::from(on.steps[n] < on.until[n]) << n;
        *live & (0..LINES).fold(0, |bits, n| bits | is_going(n))
    }

    /// What a ray has gathered in the end, with its last step, if it is a part of one and not hidden; and after how many
    /// whole steps that is.
    fn end(&self, front: &Front, n: usize, done: &mut Cast) -> (Gathered, f64) {
        let (way, at, gathered) = (&front.ways[n], front.on.steps[n] - 0.5, front.gathered(n));
        if gathered.opacity >= self.opaque {
            done.steps_hidden += (way.steps - at).ceil() as u64;
            return (gathered, at);
        }
        // In those between nothing is seen.
        let at = way.steps.floor();
        match way.steps > at {
            true => (gathered.over(self.partial(way, [at, way.steps], done)), at),
            false => (gathered, at),
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
        let gradient = || self.field.gradient(place);
        let shaded = |light: Light| light.answer(gradient(), way.towards);
        let share = self.cloud.map_or(1.0, |cloud| cloud.light(place));
        if self.lookup.has_integrals() {
            let ends = [from, to].map(|steps| self.field.at_index(way.at(steps)));
            return self.between(ends, to - from, self.light.map(shaded)).dimmed(share);
        }
        let value = self.field.at_index(place);
        if value.is_nan() {
            return Gathered::NOTHING;
        }
        let slope = if self.lookup.has_slopes() { length(gradient()) } else { 0.0 };
        self.lookup.exact([value, slope], to - from, self.light.map(shaded)).dimmed(share)
    }

    /// Whether anybody asks for gradients.
    pub(super) fn has_gradients(&self) -> bool {
        self.light.is_some() || self.lookup.has_slopes()
    }

    /// Adds what is seen in the next step of each ray; the bits of those that are as good as opaque then.
    #[inline(always)]
    fn gather(&self, found: &mut Found, front: &mut Front) -> u16 {
        let mut room = Default::default();
        let shades = self.shades(found, front, &mut room);
        let (mut left, mut are_opaque) = (found.seen, 0);
        if let (Some(entries), None) = (self.lookup.values(), self.cloud) {
            // What nothing but values and light counts for, and is linear.
            left = found.bent;
            let (parts, shares) = (&found.parts, &found.shares);
            let next = Next { entries, parts, shares, shades };
            are_opaque = next.lay(found.seen & !found.bent, &mut front.layers, self.opaque);
        }
        while left != 0 {
            let n = left.trailing_zeros() as usize;
            left &= left - 1;
            let place = Place {
                part: found.parts[n] as usize,
                share: found.shares[n],
                value: found.values[n],
                slope: f64::from(found.slopes[n]) * self.rise,
            };
            let shade = shades.map(|[matt, gloss]| [matt[n], gloss[n]]);
            let mut next = self.lookup.gathered(place, shade);
            next = next.dimmed(self.share(front, n));
            let gathered = front.gathered(n).over(next);
            front.set(n, gathered);
            are_opaque |= u16::from(gathered.opacity >= self.opaque) << n;
        }
        are_opaque
    }

    /// How much light a ray's next step has.
    #[inline(always)]
    pub(super) fn share(&self, front: &Front, n: usize) -> f32 {
        self.cloud.map_or(1.0, |cloud| cloud.light(front.ways[n].at(front.on.steps[n])))
    }

    /// How gradients answer the light, matt and in gloss, if there is one: kept in `room`. Of steps in which nothing is
    /// seen anything. Slopes that were not found are put in.
    #[inline(always)]
    pub(super) fn shades<'s>(
        &self,
        found: &mut Found,
        front: &Front,
        room: &'s mut [[f32; LINES]; 2],
    ) -> Option<&'s [[f32; LINES]; 2]> {
        if let Some(light) = &self.light {
            *room = light.shares(found.cosines);
        }
        let mut odd = found.odd;
        while odd != 0 {
            let n = odd.trailing_zeros() as usize;
            odd &= odd - 1;
            let way = &front.ways[n];
            let gradient = self.field.gradient(way.at(front.on.steps[n]));
            found.slopes[n] = (length(gradient) / self.rise) as f32;
            if let Some(light) = &self.light {
                [room[0][n], room[1][n]] = light.answer(gradient, way.towards);
            }
        }
        self.light.is_some().then_some(room)
    }
}

impl Front {
    /// Puts the next ray at the beginning of its way, if there is one.
    #[inline(always)]
    fn next(&mut self, n: usize, next: Option<(usize, Way)>) {
        self.live &= !(1 << n);
        let Some((pixel, way)) = next else { return };
        self.live |= 1 << n;
        for k in 0..3 {
            self.lines.start[k][n] = way.start[k];
            self.lines.step[k][n] = way.step[k];
            self.on.pace[k][n] = way.pace[k];
            self.facing.towards[k][n] = way.towards[k] as f32;
        }
        let OnTheWay { steps, until, seen, .. } = &mut self.on;
        let [from, to] = way.seen;
        (until[n], seen[n]) = (way.steps.floor().min(to), 0.0);
        steps[n] = from.min(until[n]) + 0.5;
        (self.ways[n], self.pixels[n]) = (way, pixel);
        self.set(n, Gathered::NOTHING);
        self.ends.begin(n);
    }

    /// The places of all rays after so many steps each.
    pub(super) fn after<'a>(&'a self, steps: &'a [f64; LINES]) -> Places<'a> {
        (&self.ways, (&self.lines, steps))
    }

    /// What a ray has gathered so far.
    pub(super) fn gathered(&self, n: usize) -> Gathered {
        let [r, g, b, opacity] = self.layers[n];
        Gathered { color: [r, g, b], opacity }
    }

    pub(super) fn set(&mut self, n: usize, Gathered { color: [r, g, b], opacity }: Gathered) {
        self.layers[n] = [r, g, b, opacity];
    }
}
