//! Lines of numbers, sixteen abreast: what is done along each of them is done to all at once.
//!
//! There is one text for all levels, and no fused multiply-add, so the bits are the same. What it is worth is measured by
//! `scripts/bench_fields`.

use crate::{
    Level,
    wide::{BATCH, Exact, Task, Wide, run_at},
};

/// One number of each of sixteen lines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Abreast<F>(pub [F; BATCH]);

/// f32 or f64.
pub trait Real: Exact + Send + Sync {
    /// The number nearest to a value.
    fn nearest(value: f64) -> Self;
}

impl Real for f32 {
    #[inline(always)]
    fn nearest(value: f64) -> Self {
        value as Self
    }
}

impl Real for f64 {
    #[inline(always)]
    fn nearest(value: f64) -> Self {
        value
    }
}

/// Which numbers of a line make each of others, and how much each of them counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Taps<F> {
    /// The first that counts, for each number that is made.
    pub firsts: Vec<u32>,
    /// Where in `weights` its own end; they begin where those of the one before end.
    pub ends: Vec<u32>,
    /// How much each counts from the first on.
    pub weights: Vec<F>,
}

/// A line through which symmetric pieces go, as wide as two steps and the half of one: what the pieces must weigh so that
/// they add up to given numbers. Unser, Aldroubi & Eden 1993, "B-spline signal processing: part II", for pieces that are
/// B-splines of degree 2 or 3.
#[derive(Clone, Debug, PartialEq)]
pub struct Recursion<F> {
    /// How much of a weight is that of the number before: between −1 and 0.
    pub pole: F,
    /// How much of the sum of both ways is one weight: `−pole / (1 − pole²)`.
    pub share: F,
    /// How many times as high a piece is at its middle as one step beside it.
    pub middle: F,
    /// How much of the first numbers, and from the other side of the last, the sum of all that lie before them is, with
    /// them: of the line as it goes on.
    pub ends: Vec<F>,
}

/// Sums of the numbers of each line. Each begins with the first that counts.
///
/// # Panics
///
/// If there are not as many taps as numbers to make, or if they lead out of the line.
pub fn weigh<F: Real>(line: &[Abreast<F>], taps: &Taps<F>, made: &mut [Abreast<F>]) {
    weigh_at(Level::current(), line, taps, made);
}

fn weigh_at<F: Real>(level: Level, line: &[Abreast<F>], taps: &Taps<F>, made: &mut [Abreast<F>]) {
    assert!(taps.firsts.len() == made.len() && taps.ends.len() == made.len(), "taps for each");
    run_at(level, Weigh { line, taps, made });
}

struct Weigh<'b, F> {
    line: &'b [Abreast<F>],
    taps: &'b Taps<F>,
    made: &'b mut [Abreast<F>],
}

impl<F: Real> Task for Weigh<'_, F> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Taps { firsts, ends, weights } = self.taps;
        let mut start = 0;
        for n in 0..self.made.len() {
            let end = ends[n] as usize;
            let weights = &weights[start..end];
            let line = &self.line[firsts[n] as usize..][..weights.len()];
            start = end;
            let Some((&weight, rest)) = weights.split_first() else {
                self.made[n] = Abreast::default();
                continue;
            };
            let mut sum = F::load(wide, &[weight; BATCH]) * F::load(wide, &line[0].0);
            for k in 0..rest.len() {
                sum = sum + F::load(wide, &[rest[k]; BATCH]) * F::load(wide, &line[k + 1].0);
            }
            F::store(wide, sum, &mut self.made[n].0);
        }
    }
}

/// Turns the numbers of each line, but for the first and the last, into weights of pieces that add up to them; the first
/// and the last become the weights of those beside the line. What was in them does not count.
///
/// # Panics
///
/// If a line has fewer numbers than the recursion has ends.
pub fn find_weights<F: Real>(line: &mut [Abreast<F>], recursion: &Recursion<F>) {
    find_weights_at(Level::current(), line, recursion);
}

fn find_weights_at<F: Real>(level: Level, line: &mut [Abreast<F>], recursion: &Recursion<F>) {
    let ends = recursion.ends.len();
    assert!(ends > 0 && line.len() >= ends + 2, "{} numbers for {ends} ends", line.len());
    run_at(level, FindWeights { line, recursion });
}

struct FindWeights<'b, F> {
    line: &'b mut [Abreast<F>],
    recursion: &'b Recursion<F>,
}

impl<F: Real> Task for FindWeights<'_, F> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Self { line, recursion: Recursion { pole, share, middle, ends } } = self;
        let last = line.len() - 2;
        let pole = F::load(wide, &[*pole; BATCH]);
        let share = F::load(wide, &[*share; BATCH]);
        let middle = F::load(wide, &[*middle; BATCH]);
        let (low, high) = (F::load(wide, &line[1].0), F::load(wide, &line[last].0));
        // All numbers before the first, and after the last, each step by the pole.
        let mut before = F::load(wide, &[ends[0]; BATCH]) * low;
        let mut after = F::load(wide, &[ends[0]; BATCH]) * high;
        for k in 1..ends.len() {
            let end = F::load(wide, &[ends[k]; BATCH]);
            before = before + end * F::load(wide, &line[1 + k].0);
            after = after + end * F::load(wide, &line[last - k].0);
        }
        F::store(wide, before, &mut line[1].0);
        for numbers in &mut line[2..=last] {
            before = F::load(wide, &numbers.0) + pole * before;
            F::store(wide, before, &mut numbers.0);
        }
        let mut weight = share * ((before + after) - high);
        F::store(wide, weight, &mut line[last].0);
        let mut above = weight;
        for numbers in line[1..last].iter_mut().rev() {
            above = weight;
            weight = pole * (weight - F::load(wide, &numbers.0));
            F::store(wide, weight, &mut numbers.0);
        }
        // The pieces add up to the first number and to the last.
        let (first, second) = (weight, if last > 1 { above } else { weight });
        F::store(wide, (low - middle * first) - second, &mut line[0].0);
        let inner = F::load(wide, &line[if last > 1 { last - 1 } else { last }].0);
        let end = F::load(wide, &line[last].0);
        F::store(wide, (high - middle * end) - inner, &mut line[last + 1].0);
    }
}

#[cfg(test)]
mod tests {
    use super::{Abreast, Recursion, Taps, find_weights_at, weigh_at};
    use crate::{Level, vertices::tests::Chance, wide::BATCH};

    fn line<F>(count: usize, chance: &mut Chance, number: fn(f64) -> F) -> Vec<Abreast<F>> {
        let mut number = || number(f64::from(chance.below(2001)) / 8.0 - 125.0);
        (0..count).map(|_| Abreast(std::array::from_fn(|_| number()))).collect()
    }

    /// Some numbers of a line, for each of a few.
    fn taps<F>(count: usize, chance: &mut Chance, number: fn(f64) -> F) -> Taps<F> {
        let mut taps = Taps { firsts: vec![], ends: vec![], weights: vec![] };
        for _ in 0..chance.below(9) {
            let first = chance.below(count as u32 + 1);
            for _ in 0..chance.below(count as u32 - first + 1) {
                taps.weights.push(number(f64::from(chance.below(41)) / 16.0 - 1.25));
            }
            taps.firsts.push(first);
            taps.ends.push(taps.weights.len() as u32);
        }
        taps
    }

    #[test]
    fn sums_are_those_of_each_line_alone_at_every_level() {
        let mut chance = Chance(7);
        for count in (1..40).chain([100]) {
            let line = line(count, &mut chance, |number| number as f32);
            let taps = taps(count, &mut chance, |number| number as f32);
            for &level in Level::available() {
                let mut made = vec![Abreast([-1.0; BATCH]); taps.firsts.len()];
                weigh_at(level, &line, &taps, &mut made);
                let mut start = 0;
                for (n, made) in made.iter().enumerate() {
                    let weights = &taps.weights[start..taps.ends[n] as usize];
                    start = taps.ends[n] as usize;
                    for (lane, found) in made.0.into_iter().enumerate() {
                        let product =
                            |k: usize| weights[k] * line[taps.firsts[n] as usize + k].0[lane];
                        let sum = (0..weights.len()).map(product).reduce(|sum, next| sum + next);
                        assert_eq!(found.to_bits(), sum.unwrap_or(0.0).to_bits(), "{level:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn pieces_of_the_weights_that_are_found_add_up_to_the_numbers_at_every_level() {
        let mut chance = Chance(8);
        // Of pieces of degree 2 and 3.
        for (pole, middle) in [(8.0_f64.sqrt() - 3.0, 6.0), (3.0_f64.sqrt() - 2.0, 4.0)] {
            for count in 1..30 {
                // One number goes on as it is, others anyhow.
                let ends: Vec<f64> = match count {
                    1 => vec![1.0 / (1.0 - pole)],
                    _ => (0..count.min(4)).map(|k| 0.9 / (1 + 3 * k) as f64).collect(),
                };
                let recursion =
                    Recursion { pole, share: -pole / (1.0 - pole * pole), middle, ends };
                let given = line(count + 2, &mut chance, |number| number);
                let mut of_levels = vec![];
                for &level in Level::available() {
                    let mut weights = given.clone();
                    find_weights_at(level, &mut weights, &recursion);
                    for (n, given) in given.iter().enumerate().take(count + 1).skip(1) {
                        for lane in 0..BATCH {
                            let weight = |n: usize| weights[n].0[lane];
                            let sum = weight(n - 1) + middle * weight(n) + weight(n + 1);
                            assert!((sum - given.0[lane]).abs() < 1e-11, "{level:?}, {count}, {n}");
                        }
                    }
                    of_levels.push(weights);
                }
                assert!(of_levels.iter().all(|weights| *weights == of_levels[0]), "{count}");
            }
        }
    }
}
