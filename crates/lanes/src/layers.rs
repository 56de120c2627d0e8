//! Colours that lines gather, front to back, on sixteen lines at a time.
//!
//! What comes next is seen through what was gathered: with colours that are multiplied by their opacity,
//! C′ ← C′ + (1 − α) C′ᵢ and α ← α + (1 − α) αᵢ (Porter & Duff 1984, "Compositing digital images").
//! There is one text for all levels, and no fused multiply-add, so the bits are the same. What it is worth is measured by
//! `scripts/bench_render`.

use crate::{
    LINES, Level,
    wide::{Float, Mask, Task, Wide, run_at},
};

/// What lines have gathered: red, green and blue, each multiplied by the opacity, and the opacity.
pub type Layers = [[f32; LINES]; 4];

/// What comes next on lines.
#[derive(Clone, Copy, Debug)]
pub struct Next<'a> {
    /// Colours multiplied by their opacity, and opacities, at the ends of parts.
    pub entries: &'a [[f32; 4]],
    /// The part of each line.
    pub parts: &'a [u32; LINES],
    /// How far in it, from 0 to 1.
    pub shares: &'a [f32; LINES],
    /// What share of its colour each has under a light, and how much white in addition; a colour is never above its
    /// opacity then. `None` leaves colours as they are.
    pub shades: Option<&'a [[f32; LINES]; 2]>,
}

impl Next<'_> {
    /// Lays it behind what the lines whose bits are set have gathered; the bits of those that have an opacity of
    /// `opaque` or more then.
    ///
    /// # Panics
    ///
    /// If a line, whether its bit is set or not, is in a part whose end is no entry.
    #[inline]
    pub fn lay(&self, lines: u16, layers: &mut Layers, opaque: f32) -> u16 {
        self.lay_at(Level::current(), lines, layers, opaque)
    }

    fn lay_at(&self, level: Level, lines: u16, layers: &mut Layers, opaque: f32) -> u16 {
        let mut are_opaque = 0;
        run_at(level, Lay { next: *self, lines, layers, opaque, are_opaque: &mut are_opaque });
        are_opaque
    }
}

struct Lay<'a> {
    next: Next<'a>,
    lines: u16,
    layers: &'a mut Layers,
    opaque: f32,
    are_opaque: &'a mut u16,
}

impl Task for Lay<'_> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Self { next: Next { entries, parts, shares, shades }, lines, layers, .. } = self;
        let (low, high) = (wide.rows(entries, parts), wide.rows(&entries[1..], parts));
        let share = wide.load_f32(shares);
        let mut next = low;
        for k in 0..4 {
            next[k] = low[k] + (high[k] - low[k]) * share;
        }
        if let Some([matt, gloss]) = shades {
            let (matt, white) = (wide.load_f32(matt), next[3] * wide.load_f32(gloss));
            for k in 0..3 {
                next[k] = (next[k] * matt + white).min(next[3]);
            }
        }
        let (are_lines, open) = (wide.mask(lines), wide.f32(1.0) - wide.load_f32(&layers[3]));
        let mut opacity = open;
        for k in 0..4 {
            let before = wide.load_f32(&layers[k]);
            opacity = wide.select_f32(are_lines, before + open * next[k], before);
            wide.store_f32(opacity, &mut layers[k]);
        }
        // Never, if it is NaN.
        let opaque = if self.opaque.is_nan() { f32::INFINITY } else { self.opaque };
        *self.are_opaque = lines & !opacity.less(wide.f32(opaque)).bits();
    }
}

#[cfg(test)]
mod tests {
    use super::{Layers, Next};
    use crate::{LINES, Level, vertices::tests::Chance};

    fn numbers(chance: &mut Chance) -> [f32; LINES] {
        [(); LINES].map(|()| chance.below(1001) as f32 / 1000.0)
    }

    #[test]
    fn every_level_lays_what_is_worked_out_line_by_line() {
        let mut chance = Chance(11);
        let entries: Vec<[f32; 4]> = (0..20)
            .map(|_| {
                let [r, g, b, a, ..] = numbers(&mut chance);
                [r * a, g * a, b * a, a]
            })
            .collect();
        for round in 0..200 {
            let parts = [(); LINES].map(|()| chance.below(19));
            let shares = numbers(&mut chance);
            let shades = [numbers(&mut chance), numbers(&mut chance)];
            let shades = (round % 2 == 0).then_some(&shades);
            let before: Layers = [(); 4].map(|()| numbers(&mut chance));
            let (next, lines) = (
                Next { entries: &entries, parts: &parts, shares: &shares, shades },
                chance.next() as u16,
            );
            let opaque = if round % 7 == 0 { f32::NAN } else { 0.75 };
            let mut expected = (before, 0);
            for n in (0..LINES).filter(|n| lines >> n & 1 == 1) {
                let part = parts[n] as usize;
                let [low, high] = [entries[part], entries[part + 1]];
                let mut own = [0, 1, 2, 3].map(|k| low[k] + (high[k] - low[k]) * shares[n]);
                if let Some([matt, gloss]) = shades {
                    for k in 0..3 {
                        own[k] = (own[k] * matt[n] + own[3] * gloss[n]).min(own[3]);
                    }
                }
                let open = 1.0 - before[3][n];
                for k in 0..4 {
                    expected.0[k][n] = before[k][n] + open * own[k];
                }
                expected.1 |= u16::from(expected.0[3][n] >= opaque) << n;
            }
            for &level in Level::available() {
                let mut layers = before;
                let are_opaque = next.lay_at(level, lines, &mut layers, opaque);
                assert_eq!((layers, are_opaque), expected, "{level}");
            }
        }
    }

    #[test]
    #[should_panic(expected = "out of range")]
    fn a_part_without_an_end_is_refused() {
        let parts = [1; LINES];
        let next =
            Next { entries: &[[0.0; 4]; 2], parts: &parts, shares: &[0.0; LINES], shades: None };
        next.lay(u16::MAX, &mut Layers::default(), 1.0);
    }
}
