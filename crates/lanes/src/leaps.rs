//! Leaps over blocks of a lattice in which there is nothing to be found, on sixteen lines at a time.
//!
//! There is one text for all levels, so that the steps are the same. What it is worth is measured by
//! `scripts/bench_render`.

use crate::{
    Level, Lines,
    wide::{BATCH, Float, Mask, Task, Wide, run_at},
};

/// Of each block of a lattice how far around it there is nothing.
#[derive(Clone, Copy, Debug)]
pub struct Blocks<'a> {
    counts: [u32; 3],
    cells: f64,
    reach: &'a [u8],
}

/// How far lines have come.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct OnTheWay {
    /// Where each is: so many steps and a half, to the middle of the next step.
    pub steps: [f64; BATCH],
    /// How many steps each has: it is led past them by no more than a half.
    pub until: [f64; BATCH],
    /// How many steps a cell is long on each, along x, y, z; without end, upwards, where it does not move.
    pub pace: [[f64; BATCH]; 3],
    /// Up to here something may be found on each, as is known: 0 where a line begins.
    pub seen: [f64; BATCH],
}

/// Added to a number and subtracted, leaves the nearest whole one.
const WHOLE: f64 = 1.5 * (1_u64 << 52) as f64;

/// More than rounding does to a number of steps, of up to some millions.
const UNSURE: f64 = 1e-6;

impl<'a> Blocks<'a> {
    /// Blocks of so many cells along each axis, and the reach of each, x fastest: 0 if there may be something in it,
    /// 1 if there is nothing in it, 2 if there is nothing in those that touch it either, and so on. `None` if there are
    /// not so many, or 2³¹ or more.
    pub fn new(counts: [usize; 3], cells: u16, reach: &'a [u8]) -> Option<Self> {
        let all = counts.iter().try_fold(1_usize, |all, &n| all.checked_mul(n))?;
        let is_right = all == reach.len() && (1..1 << 31).contains(&all) && cells > 0;
        let counts = counts.map(|n| n as u32);
        is_right.then_some(Self { counts, cells: cells.into(), reach })
    }

    /// Leads the lines whose bits in `live` are set over blocks in which there is nothing, to a step of which something
    /// may be found. The bits of those that are at such a step, before the last one.
    ///
    /// With twelve of them there the others wait, somewhere on their way over nothing.
    #[inline]
    pub fn lead(&self, lines: &Lines, live: u16, on: &mut OnTheWay) -> u16 {
        self.lead_at(Level::current(), lines, live, on)
    }

    fn lead_at(&self, level: Level, lines: &Lines, live: u16, on: &mut OnTheWay) -> u16 {
        let mut ready = 0;
        run_at(level, Lead { blocks: *self, lines, live, on, ready: &mut ready });
        ready
    }

    /// How far around each block there is nothing.
    #[inline(always)]
    fn reaches(&self, numbers: [u32; BATCH]) -> [u32; BATCH] {
        let mut reaches = [0; BATCH];
        for n in 0..BATCH {
            reaches[n] = self.reach[(numbers[n] as usize).min(self.reach.len() - 1)].into();
        }
        reaches
    }
}

/// With so many lines that have arrived a round of samples is worth more than to lead the last ones.
pub const ENOUGH: u32 = 12;

impl OnTheWay {
    /// One step further on the lines whose bits in `wanted` are set; the bits of those lines, of all, that have no whole
    /// step left then.
    #[inline]
    pub fn advance(&mut self, wanted: u16) -> u16 {
        self.advance_at(Level::current(), wanted)
    }

    fn advance_at(&mut self, level: Level, wanted: u16) -> u16 {
        let mut past = 0;
        run_at(level, Advance { wanted, on: self, past: &mut past });
        past
    }
}

struct Advance<'a> {
    wanted: u16,
    on: &'a mut OnTheWay,
    past: &'a mut u16,
}

impl Task for Advance<'_> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let own = wide.load_f64(&self.on.steps);
        let next = wide.select_f64(wide.mask(self.wanted), own + wide.f64(1.0), own);
        wide.store_f64(next, &mut self.on.steps);
        *self.past = wide.load_f64(&self.on.until).less(next).bits();
    }
}

struct Lead<'b> {
    blocks: Blocks<'b>,
    lines: &'b Lines,
    live: u16,
    on: &'b mut OnTheWay,
    ready: &'b mut u16,
}

impl Task for Lead<'_> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Self { blocks, lines, live, on, ready } = self;
        let until = wide.load_f64(&on.until);
        let (mut own, mut seen) = (wide.load_f64(&on.steps), wide.load_f64(&on.seen));
        loop {
            let going = live & own.less(until).bits();
            *ready = going & own.less(seen).bits();
            let others = going & !*ready;
            if others == 0 || ready.count_ones() >= ENOUGH {
                break;
            }
            let (next, is_clear) = blocks.next(wide, (lines, &on.pace), until, own);
            let are_others = wide.mask(others);
            own = wide.select_f64(is_clear & are_others, next, own);
            seen = wide.select_f64(!is_clear & are_others, next, seen);
        }
        wide.store_f64(own, &mut on.steps);
        wide.store_f64(seen, &mut on.seen);
    }
}

impl Blocks<'_> {
    /// The first step of each line beyond its block, or if there is nothing to be found in that, beyond those around it
    /// in which there is nothing either; and whether there is nothing in its own.
    #[inline(always)]
    fn next<W: Wide>(
        &self,
        wide: W,
        (lines, pace): (&Lines, &[[f64; BATCH]; 3]),
        until: W::F64,
        own: W::F64,
    ) -> (W::F64, W::Mask) {
        let (zero, half, one) = (wide.f64(0.0), wide.f64(0.5), wide.f64(1.0));
        let mut number = wide.u32(0);
        let mut block = [zero; 3];
        for axis in [2, 1, 0] {
            let place = wide.load_f64(&lines.start[axis]) + own * wide.load_f64(&lines.step[axis]);
            let place = (place * wide.f64(1.0 / self.cells)).max(zero);
            let along = wide.truncate(place.min(wide.f64(f64::from(self.counts[axis] - 1))));
            block[axis] = wide.i32_to_f64(along);
            number = number * wide.u32(self.counts[axis]) + along;
        }
        let reach = wide.load(&self.reaches(wide.store(number)));
        let more = (wide.i32_to_f64(reach) - one).max(zero);
        let is_clear = wide.less(wide.u32(0), reach);
        let mut far = until;
        for axis in 0..3 {
            let pace = wide.load_f64(&pace[axis]);
            let side = wide.select_f64(zero.less(pace), one + more, zero - more);
            let end = (block[axis] + side) * wide.f64(self.cells);
            // One that is NaN is no end: the line lies in a face of the blocks.
            far = ((end - wide.load_f64(&lines.start[axis])) * pace).min(far);
        }
        // The first step whose middle is beyond: the nearest whole number. Where rounding could change it, the one before.
        let whole = wide.f64(WHOLE);
        let next = (far - wide.f64(UNSURE)) + whole - whole + half;
        (next.max(own + one), is_clear)
    }
}

#[cfg(test)]
mod tests {
    use super::{BATCH, Blocks, ENOUGH, OnTheWay};
    use crate::{Level, Lines, vertices::tests::Chance};

    #[test]
    fn nothing_is_leapt_over_and_every_level_leaps_alike() {
        let (mut chance, counts, cells) = (Chance(5), [9_usize, 7, 6], 4_usize);
        let count = counts.iter().product::<usize>();
        for share in [1, 30, 100] {
            let seen: Vec<bool> = (0..count).map(|_| chance.below(100) < share).collect();
            let at = |block: [usize; 3]| block[0] + counts[0] * (block[1] + counts[1] * block[2]);
            let place = |n: usize| [n % 9, n / 9 % 7, n / 63];
            let away = |a: [usize; 3], b: [usize; 3]| (0..3).map(|k| a[k].abs_diff(b[k])).max();
            let reach = |n: usize| {
                let others = (0..count).filter(|&m| seen[m]);
                others.filter_map(|m| away(place(n), place(m))).min().unwrap_or(255) as u8
            };
            let reach: Vec<u8> = (0..count).map(reach).collect();
            let blocks = Blocks::new(counts, cells as u16, &reach).unwrap();
            for _ in 0..50 {
                let mut lines = Lines::default();
                let mut pace = [[0.0; BATCH]; 3];
                for (k, n) in (0..3).flat_map(|k| (0..BATCH).map(move |n| (k, n))) {
                    let last = (counts[k] * cells) as u32;
                    lines.start[k][n] = f64::from(chance.below(4 * last + 1)) / 4.0;
                    lines.step[k][n] = f64::from(chance.below(9)) / 8.0 - 0.5;
                    let step = lines.step[k][n];
                    pace[k][n] = if step == 0.0 { f64::INFINITY } else { 1.0 / step };
                }
                let until = [(); BATCH].map(|()| f64::from(chance.below(40)));
                let begin = [(); BATCH].map(|()| f64::from(chance.below(20)) + 0.5);
                let live = chance.next() as u16;
                let on = OnTheWay { steps: begin, until, pace, seen: [0.0; BATCH] };
                let lead = |level| {
                    let mut on = on;
                    (blocks.lead_at(level, &lines, live, &mut on), on)
                };
                let (ready, led) = lead(Level::Portable);
                for &level in Level::available() {
                    assert_eq!(lead(level), (ready, led), "{level}");
                }
                for n in 0..BATCH {
                    if live >> n & 1 == 0 || begin[n] >= until[n] {
                        assert_eq!((ready >> n & 1, led.steps[n]), (0, begin[n]));
                        continue;
                    }
                    let exact = |k: usize, steps: f64| lines.start[k][n] + steps * lines.step[k][n];
                    let block = |steps: f64| {
                        [0, 1, 2]
                            .map(|k| ((exact(k, steps).max(0.0) / 4.0) as usize).min(counts[k] - 1))
                    };
                    // On a face it is in a block beside it, too.
                    let is_on_face = |steps: f64| (0..3).any(|k| exact(k, steps) % 4.0 == 0.0);
                    let steps = led.steps[n];
                    if ready >> n & 1 == 1 {
                        assert!(seen[at(block(steps))] && steps < until[n]);
                        assert!(led.seen[n] > steps);
                        // Up to the end of its block; rounding may take one step more.
                        let mut later = steps;
                        while later + 1.0 < led.seen[n] {
                            assert!(is_on_face(later) || block(later) == block(steps), "{later}");
                            later += 1.0;
                        }
                    } else {
                        assert!(steps >= until[n] || ready.count_ones() >= ENOUGH);
                    }
                    assert!(steps >= begin[n] && steps <= until[n] + 0.5 && steps.fract() == 0.5);
                    let mut between = begin[n];
                    while between < steps {
                        assert!(is_on_face(between) || !seen[at(block(between))], "{between}");
                        between += 1.0;
                    }
                }
            }
        }
    }

    #[test]
    fn lines_advance_by_a_step_at_every_level() {
        let mut chance = Chance(9);
        for _ in 0..50 {
            let steps = [(); BATCH].map(|()| f64::from(chance.below(8)) + 0.5);
            let until = [(); BATCH].map(|()| f64::from(chance.below(8)));
            let wanted = chance.next() as u16;
            for &level in Level::available() {
                let mut on = OnTheWay { steps, until, ..OnTheWay::default() };
                let past = on.advance_at(level, wanted);
                for n in 0..BATCH {
                    assert_eq!(on.steps[n], steps[n] + f64::from(wanted >> n & 1), "{level}");
                    assert_eq!(past >> n & 1 == 1, on.steps[n] > until[n], "{level}");
                }
            }
        }
    }

    #[test]
    fn blocks_are_as_many_as_their_reaches() {
        assert!(Blocks::new([2, 2, 2], 4, &[0; 8]).is_some());
        for (counts, cells, count) in [([2, 2, 2], 4, 7), ([0, 2, 2], 4, 0), ([1, 1, 1], 0, 1)] {
            assert!(Blocks::new(counts, cells, &vec![0; count]).is_none());
        }
    }
}
