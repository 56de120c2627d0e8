//! Chance that is the same everywhere and every time.

use std::{env, num::NonZeroUsize, thread};

/// SplitMix64 (Steele, Lea & Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014).
#[derive(Clone, Debug)]
pub struct Chance(u64);

impl Chance {
    /// The sequence that belongs to `seed`.
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    pub const fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    /// A whole number from 0 to below `end`, which is small.
    pub const fn below(&mut self, end: u64) -> u64 {
        ((self.bits() >> 32) * end) >> 32
    }

    /// A number from 0 to below 1, a multiple of 2⁻⁵³.
    pub const fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// How many are tried: what this variable of the environment says, else so many.
///
/// # Panics
///
/// If what it says is not a number.
pub fn many(variable: &str, default: usize) -> usize {
    let parsed = |text: String| text.parse().unwrap_or_else(|_| panic!("{variable} is a number"));
    env::var(variable).map_or(default, parsed)
}

/// Does something for each number below `count`, on as many threads as the machine has.
pub fn for_each_below(count: usize, each: impl Fn(usize) + Sync) {
    let threads = thread::available_parallelism().map_or(1, NonZeroUsize::get);
    thread::scope(|scope| {
        for first in 0..threads {
            let each = &each;
            scope.spawn(move || (first..count).step_by(threads).for_each(each));
        }
    });
}

/// Says that so many were looked at and all were right; `scripts/sweep` prints these lines.
#[expect(clippy::print_stdout, reason = "whoever looks at so many wants to see how many")]
pub fn looked_at(count: usize, what: &str) {
    println!("looked at: {count} {what}");
}

#[cfg(test)]
mod tests {
    use super::{Chance, for_each_below};
    use std::sync::Mutex;

    #[test]
    fn the_sequence_is_the_published_one() {
        let mut chance = Chance::new(1_234_567);
        let expected = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973];
        assert_eq!([chance.bits(), chance.bits()], expected);
    }

    #[test]
    fn each_number_below_has_its_turn_once() {
        for count in [0, 1, 7, 100] {
            let had = Mutex::new(vec![0; count]);
            for_each_below(count, |n| had.lock().unwrap()[n] += 1);
            assert_eq!(had.into_inner().unwrap(), vec![1; count]);
        }
    }

    #[test]
    fn numbers_stay_below_their_end_and_reach_all_below_it() {
        let mut chance = Chance::new(7);
        let mut seen = [0; 7];
        (0..7000).for_each(|_| seen[chance.below(7) as usize] += 1);
        assert!(seen.iter().all(|&n| n > 800), "{seen:?}");
        assert!((0..1000).all(|_| (0.0..1.0).contains(&chance.unit())));
    }
}
