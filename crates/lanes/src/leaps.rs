//! Leaps over blocks of a lattice in which there is nothing to be found, on sixteen lines at a time.
//!
//! There is one text for all levels, so that the steps are the same.

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

    /// Leads the lines whose bits in `wanted` are set, which are so many steps and a half on their way, each over the
    /// blocks around it in which there is nothing, to a step and a half of which something may be found; past `until`
    /// steps by no more than that half. A line may be led in several leaps, of which this is one: the bits of those that
    /// have arrived where there may be something.
    ///
    /// `pace` is how many steps a cell is long on each line, along each axis; without end, upwards, where it does not
    /// move.
    #[inline]
    pub fn leap(
        &self,
        lines: &Lines,
        pace: &[[f64; BATCH]; 3],
        until: &[f64; BATCH],
        wanted: u16,
        steps: &mut [f64; BATCH],
    ) -> u16 {
        self.leap_at(Level::current(), lines, pace, until, wanted, steps)
    }

    fn leap_at(
        &self,
        level: Level,
        lines: &Lines,
        pace: &[[f64; BATCH]; 3],
        until: &[f64; BATCH],
        wanted: u16,
        steps: &mut [f64; BATCH],
    ) -> u16 {
        let mut arrived = 0;
        let blocks = *self;
        run_at(level, Leap { blocks, lines, pace, until, wanted, steps, arrived: &mut arrived });
        arrived
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

struct Leap<'b> {
    blocks: Blocks<'b>,
    lines: &'b Lines,
    pace: &'b [[f64; BATCH]; 3],
    until: &'b [f64; BATCH],
    wanted: u16,
    steps: &'b mut [f64; BATCH],
    arrived: &'b mut u16,
}

impl Task for Leap<'_> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Self { blocks, lines, pace, until, wanted, steps, arrived } = self;
        let (zero, half, one) = (wide.f64(0.0), wide.f64(0.5), wide.f64(1.0));
        let own = wide.load_f64(steps);
        let mut number = wide.u32(0);
        let mut block = [zero; 3];
        for axis in [2, 1, 0] {
            let place = wide.load_f64(&lines.start[axis]) + own * wide.load_f64(&lines.step[axis]);
            let place = (place * wide.f64(1.0 / blocks.cells)).max(zero);
            let along = wide.truncate(place.min(wide.f64(f64::from(blocks.counts[axis] - 1))));
            block[axis] = wide.u32_to_f64(along);
            number = number * wide.u32(blocks.counts[axis]) + along;
        }
        let reach = wide.load(&blocks.reaches(wide.store(number)));
        let more = wide.u32_to_f64(reach) - one;
        let is_clear = wide.less(wide.u32(0), reach);
        let mut far = wide.load_f64(until);
        for axis in 0..3 {
            let pace = wide.load_f64(&pace[axis]);
            let side = wide.select_f64(zero.less(pace), one + more, zero - more);
            let end = (block[axis] + side) * wide.f64(blocks.cells);
            // One that is NaN is no end: the line lies in a face of the blocks.
            far = ((end - wide.load_f64(&lines.start[axis])) * pace).min(far);
        }
        // The first step whose middle is beyond: the nearest whole number. Where rounding could change it, the one before.
        let whole = wide.f64(WHOLE);
        let next = (far - wide.f64(UNSURE)) + whole - whole + half;
        let is_wanted = wide.mask(wanted);
        let led = next.max(own + one);
        wide.store_f64(wide.select_f64(is_clear & is_wanted, led, own), steps);
        *arrived = wanted & !is_clear.bits();
    }
}

#[cfg(test)]
mod tests {
    use super::{BATCH, Blocks};
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
                let wanted = chance.next() as u16;
                let leap = |level| {
                    let mut steps = begin;
                    (blocks.leap_at(level, &lines, &pace, &until, wanted, &mut steps), steps)
                };
                let (arrived, steps) = leap(Level::Portable);
                for &level in Level::available() {
                    assert_eq!(leap(level), (arrived, steps), "{level}");
                }
                for n in 0..BATCH {
                    let block = |steps: f64| {
                        [0, 1, 2].map(|k| {
                            let place = lines.start[k][n] + steps * lines.step[k][n];
                            ((place.max(0.0) / 4.0) as usize).min(counts[k] - 1)
                        })
                    };
                    let is_clear = !seen[at(block(begin[n]))];
                    assert_eq!(arrived >> n & 1 == 1, wanted >> n & 1 == 1 && !is_clear);
                    if wanted >> n & 1 == 0 || !is_clear {
                        assert_eq!(steps[n], begin[n]);
                        continue;
                    }
                    assert!(steps[n] >= begin[n] + 1.0 && steps[n].fract() == 0.5);
                    assert!(steps[n] <= until[n].max(begin[n] + 1.0) + 0.5);
                    let mut between = begin[n] + 1.0;
                    while between < steps[n] {
                        // On a face it is in a block beside it, too.
                        let exact = |k: usize| lines.start[k][n] + between * lines.step[k][n];
                        let is_on_face = (0..3).any(|k| exact(k) % 4.0 == 0.0);
                        assert!(is_on_face || !seen[at(block(between))], "{between}");
                        between += 1.0;
                    }
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
