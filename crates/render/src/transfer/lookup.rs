//! An optical model made ready for many values and one length of step.

use super::{
    Mixture, OpticalModel, SlopeFunction, TransferFunction,
    integral::Integrals,
    slopes::{between, extinction},
};
use crate::{Gathered, gather::opacity_over};
use isokit_lanes::{BENT, SEEN, Table};
use isokit_volume::Scaling;

/// What values look like over a step, in parts between whose ends it changes linearly. Where a function has a step, or a
/// peak too narrow for that, it is asked itself.
#[derive(Clone, Debug)]
pub(crate) struct Lookup<'a> {
    model: &'a OpticalModel,
    /// How many reference lengths a step has.
    step: f64,
    /// How long it is in the world.
    length: f64,
    /// The value of the first entry.
    base: f32,
    /// Entries per value.
    scale: f32,
    looks: Looks<'a>,
    /// What is seen between two values, if that is wanted.
    integrals: Option<Integrals>,
    /// Of each part whether something is seen in it, and whether it is not as good as linear.
    marks: Box<[u8; PARTS]>,
    /// The first part from each on in which something is seen, or else how many there are.
    next_seen: Box<[u16; PARTS]>,
}

/// At the ends of parts: one more than there are parts.
type Entries = Box<[[f32; 4]; PARTS + 1]>;

/// What is known at the ends of parts.
#[derive(Clone, Debug)]
enum Looks<'a> {
    /// Colours, multiplied by the opacities of a step.
    Values(Entries),
    /// Of each slope colours multiplied by what hides light in a step, and that.
    Slopes(&'a SlopeFunction, Vec<Entries>),
    /// What there is in half a step, and the colours of surfaces; of each part how much the density changes in it.
    Mixture { mixture: &'a Mixture, halves: Entries, surfaces: Entries, changes: Box<[f32; PARTS]> },
}

/// A place that is looked up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// The part that its value is in, and how far in it.
    pub(crate) part: usize,
    pub(crate) share: f32,
    /// Its value: a number.
    pub(crate) value: f32,
    /// How long the gradient is there in the world; of use if the model [has slopes](OpticalModel::has_slopes).
    pub(crate) slope: f64,
}

/// What a stored sample means, in f32.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    slope: f32,
    intercept: f32,
}

impl Scale {
    pub(crate) fn of(scaling: Scaling) -> Self {
        Self { slope: scaling.slope() as f32, intercept: scaling.intercept() as f32 }
    }

    /// The value of a stored sample. Rounding keeps order: it never falls where samples rise, or never rises.
    #[inline(always)]
    pub(crate) fn value(self, stored: f32) -> f32 {
        stored * self.slope + self.intercept
    }
}

/// Parts of a lookup: few enough for the second cache.
const PARTS: usize = 1 << 12;

/// By how much a colour or an opacity may be off between two entries: a quarter of what 10 bits tell apart.
const UNSEEN: f32 = 1.0 / 4096.0;

impl<'a> Lookup<'a> {
    /// For steps of so many reference lengths, and so long in the world.
    pub(crate) fn new(model: &'a OpticalModel, step: f64, length: f64) -> Self {
        let ends = functions(model).map(|function| {
            let points = function.points();
            [points[0].value, points[points.len() - 1].value]
        });
        let [least, greatest] =
            ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [c, d]| [a.min(c), b.max(d)]);
        // A little beyond both ends, where a step may be: what is farther out is as there.
        let reach = least.abs().max(greatest.abs());
        let beyond = ((greatest - least) / 1024.0).max(reach * 1e-6).max(1e-30);
        let base = (least - beyond) as f32;
        let width = greatest + beyond - f64::from(base);
        let scale = (PARTS as f64 / width) as f32;
        let value = |n: usize| f64::from(base) + width * (n as f64 / PARTS as f64);
        let entries = |entry: &dyn Fn(f64) -> [f32; 4]| -> Entries {
            Box::new(std::array::from_fn(|n| entry(value(n))))
        };
        let looks = match model {
            OpticalModel::Values(function) => {
                Looks::Values(entries(&|value| multiplied(function, value, step)))
            }
            OpticalModel::Slopes(slopes) => {
                let row = |function| entries(&|value| extinctions(function, value, step));
                Looks::Slopes(slopes, slopes.rows().map(|(_, function)| row(function)).collect())
            }
            OpticalModel::Mixture(mixture) => Looks::Mixture {
                mixture,
                halves: entries(&|value| multiplied(mixture.substance(), value, 0.5 * step)),
                surfaces: entries(&|value| {
                    let [r, g, b] = mixture.surface_color(value);
                    [r, g, b, 0.0]
                }),
                changes: Box::new(std::array::from_fn(|n| {
                    mixture.change(value(n).midpoint(value(n + 1))) as f32
                })),
            },
        };
        let mut lookup = Self {
            model,
            step,
            length,
            base,
            scale,
            looks,
            integrals: None,
            marks: Box::new([0; PARTS]),
            next_seen: Box::new([PARTS as u16; PARTS]),
        };
        lookup.mark(value);
        lookup
    }

    /// The same, made ready for steps [between](Self::between) two values, if nothing but values counts.
    #[must_use]
    pub(crate) fn with_integrals(self) -> Self {
        let OpticalModel::Values(function) = self.model else { return self };
        let values = (f64::from(self.base), PARTS as f64 / f64::from(self.scale));
        Self { integrals: Some(Integrals::new(function, values, PARTS)), ..self }
    }

    /// Whether steps are looked up by the values at both ends.
    pub(crate) fn has_integrals(&self) -> bool {
        self.integrals.is_some()
    }

    /// What a part of a step looks like whose values change evenly between two numbers, under a light if there is one.
    /// None if that is not made ready.
    pub(crate) fn between(
        &self,
        ends: [f64; 2],
        part: f64,
        shade: Option<[f32; 2]>,
    ) -> Option<Gathered> {
        Some(lit(self.integrals.as_ref()?.between(ends, part * self.step), shade))
    }

    /// Finds out in which parts something is seen, and which are bent.
    fn mark(&mut self, value: impl Fn(usize) -> f64) {
        for part in 0..PARTS {
            // However little of it, next to a part too: rounding may lead there.
            let ends = [value(part.saturating_sub(1)), value((part + 2).min(PARTS))];
            self.marks[part] = if self.model.shows_any(ends) { SEEN } else { 0 };
        }
        for (n, function) in functions(self.model).enumerate() {
            for point in function.points() {
                let value = point.value as f32;
                // Of a step this side and the other.
                let is_off = [value, value.next_down()].into_iter().any(|value| {
                    let (part, share) = self.part(value);
                    let (found, exact) = match &self.looks {
                        Looks::Values(entries) => {
                            (entries, multiplied(function, value.into(), self.step))
                        }
                        Looks::Slopes(_, rows) => {
                            (&rows[n], extinctions(function, value.into(), self.step))
                        }
                        Looks::Mixture { halves, .. } => {
                            (halves, multiplied(function, value.into(), 0.5 * self.step))
                        }
                    };
                    let found = within(found, part, share);
                    found.into_iter().zip(exact).any(|(a, b)| (a - b).abs() > UNSEEN)
                });
                // Densities change as they do up to the end of a zone.
                if is_off || matches!(self.looks, Looks::Mixture { .. }) {
                    let (part, _) = self.part(value);
                    let near = part.saturating_sub(1)..(part + 2).min(PARTS);
                    self.marks[near].iter_mut().for_each(|mark| *mark |= BENT);
                }
            }
        }
        let mut next = PARTS as u16;
        for part in (0..PARTS).rev() {
            next = if self.is(part, SEEN) { part as u16 } else { next };
            self.next_seen[part] = next;
        }
    }

    /// Whether slopes change what is seen.
    pub(crate) fn has_slopes(&self) -> bool {
        self.model.has_slopes()
    }

    /// The place of a value, if something may be seen of it.
    #[inline]
    pub(crate) fn place(&self, value: f32) -> Option<Place> {
        if value.is_nan() {
            return None;
        }
        let (part, share) = self.part(value);
        self.is(part, SEEN).then_some(Place { part, share, value, slope: 0.0 })
    }

    /// Colour times opacity, and opacity, at the ends of parts, if nothing but values counts.
    #[inline(always)]
    pub(crate) fn values(&self) -> Option<&[[f32; 4]]> {
        match &self.looks {
            Looks::Values(entries) => Some(&entries[..]),
            _ => None,
        }
    }

    /// Whether a part has a mark.
    #[inline(always)]
    fn is(&self, part: usize, mark: u8) -> bool {
        self.marks[part] & mark != 0
    }

    /// What a whole step of a place looks like, under a light if there is one.
    #[inline(always)]
    pub(crate) fn gathered(&self, place: Place, shade: Option<[f32; 2]>) -> Gathered {
        match &self.looks {
            Looks::Values(entries) if !self.is(place.part, BENT) => {
                let [r, g, b, opacity] = within(entries, place.part, place.share);
                lit(Gathered { color: [r, g, b], opacity }, shade)
            }
            _ => self.layered(place, shade),
        }
    }

    #[inline(never)]
    fn layered(&self, place: Place, shade: Option<[f32; 2]>) -> Gathered {
        let Place { part, share, value, slope } = place;
        match &self.looks {
            Looks::Slopes(slopes, rows) if !self.is(part, BENT) => {
                let (row, of_next) = between(slopes.rows().map(|row| row.0), slope);
                let of_next = of_next as f32;
                let low = within(&rows[row], part, share);
                let high = within(&rows[(row + 1).min(rows.len() - 1)], part, share);
                let [r, g, b, all]: [f32; 4] =
                    std::array::from_fn(|n| low[n] + (high[n] - low[n]) * of_next);
                if all <= 0.0 {
                    return Gathered::NOTHING;
                }
                let opacity = -(-f64::from(all)).exp_m1() as f32;
                lit(Gathered { color: [r, g, b].map(|c| c / all * opacity), opacity }, shade)
            }
            Looks::Mixture { mixture, halves, surfaces, changes } if !self.is(part, BENT) => {
                let [r, g, b, opacity] = within(halves, part, share);
                let half = Gathered { color: [r, g, b], opacity };
                let change = f64::from(changes[part]);
                let of_surface = mixture.surface_opacity(change, slope, self.length);
                let [r, g, b, _] = within(surfaces, part, share);
                half.over(lit(Gathered::new([r, g, b], of_surface), shade)).over(half)
            }
            _ => self.exact([value.into(), slope], 1.0, shade),
        }
    }

    /// What a part of a step looks like at a value, a number, and a slope, as exact as the model is.
    #[inline(never)]
    pub(crate) fn exact(
        &self,
        [value, slope]: [f64; 2],
        part: f64,
        shade: Option<[f32; 2]>,
    ) -> Gathered {
        let of = |[r, g, b, opacity]: [f32; 4]| Gathered { color: [r, g, b], opacity };
        match self.model {
            OpticalModel::Values(function) => {
                lit(of(multiplied(function, value, part * self.step)), shade)
            }
            OpticalModel::Slopes(slopes) => {
                let point = slopes.at(value, slope);
                let opacity = opacity_over(point.opacity.into(), part * self.step) as f32;
                lit(Gathered::new(point.color, opacity), shade)
            }
            OpticalModel::Mixture(mixture) => {
                let half = of(multiplied(mixture.substance(), value, 0.5 * part * self.step));
                let length = part * self.length;
                let opacity = mixture.surface_opacity(mixture.change(value), slope, length);
                let surface = lit(Gathered::new(mixture.surface_color(value), opacity), shade);
                half.over(surface).over(half)
            }
        }
    }

    /// The parts, for samples that mean what `scale` says.
    pub(crate) fn table(&self, scale: Scale) -> Table<'_> {
        let Scale { slope, intercept } = scale;
        Table { slope, intercept, base: self.base, scale: self.scale, marks: &self.marks[..] }
    }

    /// Whether no value from one to another can be seen.
    pub(crate) fn is_clear(&self, ends: [f32; 2]) -> bool {
        let [first, last] = ends.map(|end| self.part(end).0);
        usize::from(self.next_seen[first]) > last
    }

    /// The part that a value is in, and how far in it.
    #[inline(always)]
    fn part(&self, value: f32) -> (usize, f32) {
        let place = ((value - self.base) * self.scale).clamp(0.0, PARTS as f32);
        let part = (place as usize).min(PARTS - 1);
        (part, place - part as f32)
    }
}

/// The functions of values that are in a model.
fn functions(model: &OpticalModel) -> Box<dyn Iterator<Item = &TransferFunction> + '_> {
    match model {
        OpticalModel::Values(function) => Box::new([function].into_iter()),
        OpticalModel::Slopes(slopes) => Box::new(slopes.rows().map(|(_, function)| function)),
        OpticalModel::Mixture(mixture) => Box::new([mixture.substance()].into_iter()),
    }
}

/// Colour times opacity, and opacity, over so many reference lengths.
fn multiplied(function: &TransferFunction, value: f64, length: f64) -> [f32; 4] {
    let point = function.at(value);
    let opacity = opacity_over(point.opacity.into(), length) as f32;
    let [r, g, b] = point.color.map(|part| part * opacity);
    [r, g, b, opacity]
}

/// Colour times what hides light over so many reference lengths, and that.
fn extinctions(function: &TransferFunction, value: f64, length: f64) -> [f32; 4] {
    let point = function.at(value);
    let all = (extinction(point.opacity) * length) as f32;
    let [r, g, b] = point.color.map(|part| part * all);
    [r, g, b, all]
}

#[inline(always)]
fn within(entries: &[[f32; 4]; PARTS + 1], part: usize, share: f32) -> [f32; 4] {
    let [low, high] = [entries[part], entries[part + 1]];
    std::array::from_fn(|n| low[n] + (high[n] - low[n]) * share)
}

#[inline(always)]
fn lit(dark: Gathered, shade: Option<[f32; 2]>) -> Gathered {
    match shade {
        Some(shade) => dark.lit(shade),
        None => dark,
    }
}

#[cfg(test)]
mod tests;
