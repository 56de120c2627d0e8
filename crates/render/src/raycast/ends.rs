//! Steps by the values at both of their ends.

use super::march::{Front, March};
use crate::Gathered;
use isokit_lanes::{Between, Found, LINES, SEEN, Table};
use isokit_volume::Sample;

/// The values at which rays have come to the ends of their steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    /// After how many steps, and the value there.
    at: [f64; LINES],
    values: [f32; LINES],
}

impl Default for Ends {
    fn default() -> Self {
        Self { at: [f64::NAN; LINES], values: [f32::NAN; LINES] }
    }
}

impl Ends {
    /// The ray begins.
    pub(super) fn begin(&mut self, n: usize) {
        self.at[n] = f64::NAN;
    }
}

impl<T: Sample> March<'_, T> {
    /// Adds what is seen in the next steps of rays; the bits of those that are as good as opaque then.
    pub(super) fn gather_between(
        &self,
        (between, table): (&Between<'_, T>, &Table<'_>),
        ready: u16,
        front: &mut Front,
        found: &mut Found,
    ) -> u16 {
        // A step may show something whatever its ends show.
        let asked = (between, &Table { marks: &[SEEN], ..*table });
        let begins = front.on.steps.map(|middle| middle - 0.5);
        let ends = front.on.steps.map(|middle| middle + 0.5);
        let is_new = |n: usize| u16::from(front.ends.at[n] != begins[n]) << n;
        let new = ready & (0..LINES).fold(0, |bits, n| bits | is_new(n));
        let mut first = front.ends.values;
        if new != 0 {
            self.look(asked, front.after(&begins), new, None, found);
            for n in (0..LINES).filter(|n| new >> n & 1 == 1) {
                first[n] = found.values[n];
            }
        }
        self.look(asked, front.after(&ends), ready, None, found);
        let last = found.values;
        let mut room = Default::default();
        let shades = self.light.and_then(|_| {
            self.look(asked, front.after(&front.on.steps), ready, Some(&front.facing), found);
            self.shades(found, front, &mut room)
        });
        let mut are_opaque = 0;
        for n in (0..LINES).filter(|n| ready >> n & 1 == 1) {
            (front.ends.at[n], front.ends.values[n]) = (ends[n], last[n]);
            let shade = shades.map(|[matt, gloss]| [matt[n], gloss[n]]);
            let values = [first[n], last[n]].map(f64::from);
            let next = self.between(values, 1.0, shade).dimmed(self.share(front, n));
            let gathered = front.gathered(n).over(next);
            front.set(n, gathered);
            are_opaque |= u16::from(gathered.opacity >= self.opaque) << n;
        }
        are_opaque
    }

    /// What a part of a step looks like whose ends have such values; if one has none, nothing.
    pub(super) fn between(&self, ends: [f64; 2], part: f64, shade: Option<[f32; 2]>) -> Gathered {
        let are_numbers = !ends[0].is_nan() && !ends[1].is_nan();
        let found = are_numbers.then(|| self.lookup.between(ends, part, shade));
        found.flatten().unwrap_or(Gathered::NOTHING)
    }
}
