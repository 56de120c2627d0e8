//! Eight planes at once, whose words lie side by side: word `w` of plane `k` is `[w][k]`.
//!
//! What a row has is kept for the next one, and with AVX-512 a register has the same word of all eight planes, so that none
//! of its lanes is idle, however short rows are. Eight isovalues take 2.2 to 2.4 times as long as one on one thread, and 1.6
//! to 1.8 times on two; planes one after another 2.8 and 2.1 times (row `many` of `scripts/bench`, EPYC, Zen 4, November
//! 2026; the machine was not idle, and was for the latter). At other levels planes are taken apart, which is slow: there callers keep them apart.

use super::{Layer, Rows};
use crate::Level;

/// Planes that lie side by side.
pub(super) const PLANES: usize = 8;

impl Rows<'_> {
    /// Whether several planes are sooner counted side by side on this machine than one after another.
    pub fn are_side_by_side() -> bool {
        #[cfg(target_arch = "x86_64")]
        return Level::current() == Level::Avx512;
        #[cfg(not(target_arch = "x86_64"))]
        return false;
    }

    /// What the lowest slices of eight planes add. There is no one word more.
    ///
    /// # Panics
    ///
    /// As [`lowest`](Self::lowest).
    pub fn lowest_of_eight(&self, slice: &[[u64; PLANES]]) -> [Layer; PLANES] {
        [0, 1, 2, 3, 4, 5, 6, 7].map(|k| self.lowest(&plane(slice, k)))
    }

    /// What slices of eight planes add that are above others, of which that is known. There is no one word more.
    ///
    /// # Panics
    ///
    /// As [`above`](Self::above).
    pub fn above_of_eight(
        &self,
        low: (&[[u64; PLANES]], &[Layer; PLANES]),
        slice: &[[u64; PLANES]],
    ) -> [Layer; PLANES] {
        self.above_of_eight_at(Level::current(), low, slice)
    }

    fn above_of_eight_at(
        &self,
        level: Level,
        (low, below): (&[[u64; PLANES]], &[Layer; PLANES]),
        slice: &[[u64; PLANES]],
    ) -> [Layer; PLANES] {
        #[cfg(target_arch = "x86_64")]
        if level == Level::Avx512 {
            level.assert_available();
            self.check_sizes([low.len() + 1, slice.len() + 1]);
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            let sums = unsafe { super::wide::in_layers(self, [low, slice]) };
            return std::array::from_fn(|k| Self::layer(below[k], sums[k]));
        }
        std::array::from_fn(|k| self.above_at(level, (&plane(low, k), below[k]), &plane(slice, k)))
    }
}

/// One plane of eight, and one word more.
fn plane(slice: &[[u64; PLANES]], k: usize) -> Vec<u64> {
    slice.iter().map(|words| words[k]).chain([0]).collect()
}

#[cfg(test)]
mod tests {
    use super::{PLANES, plane};
    use crate::{Layer, Level, Rows};

    #[test]
    fn planes_side_by_side_have_what_each_has_by_itself() {
        let mut state = 17_u64;
        let mut chance = || {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
            state ^ state >> 29
        };
        for points in (1..=70_usize).chain([127, 128, 129, 192, 256, 258, 321, 512]) {
            let words = points.div_ceil(64);
            for rows in [1, 2, 3, 8, 37] {
                let mut slice = || -> Vec<[u64; PLANES]> {
                    let mut words_of = |n: usize| {
                        // From noise to smooth, and to nothing but ones.
                        let word = |k: usize, noise: u64| match k {
                            0..3 => noise,
                            3 => noise | noise >> 7,
                            4 => u64::MAX << (noise % 64),
                            5 => u64::MAX,
                            _ => (n % 2) as u64 * u64::MAX,
                        };
                        let is_cut = n % words == words - 1 && !points.is_multiple_of(64);
                        let mask = if is_cut { (1 << (points % 64)) - 1 } else { u64::MAX };
                        std::array::from_fn(|k| word(k, chance()) & mask)
                    };
                    (0..words * rows).map(&mut words_of).collect()
                };
                let (low, high) = (slice(), slice());
                let last = |n: usize| n % words == words - 1;
                let cells = |n| if last(n) { (1 << ((points - 1) % 64)) - 1 } else { u64::MAX };
                let cells: Vec<u64> = (0..words * rows).map(cells).collect();
                let all = Rows { words, cells: &cells };
                let below = all.lowest_of_eight(&low);
                let expected: [Layer; PLANES] = std::array::from_fn(|k| {
                    assert_eq!(below[k], all.lowest(&plane(&low, k)));
                    all.above((&plane(&low, k), below[k]), &plane(&high, k))
                });
                for &level in Level::available() {
                    let found = all.above_of_eight_at(level, (&low, &below), &high);
                    assert_eq!(found, expected, "{level}, {points} points, {rows} rows");
                }
            }
        }
    }

    #[test]
    #[should_panic(expected = "one word more")]
    fn a_slice_that_is_too_short_is_refused() {
        let (cells, slice) = (vec![1; 8], vec![[0; PLANES]; 7]);
        let rows = Rows { words: 4, cells: &cells };
        rows.above_of_eight((&slice, &[Layer::default(); PLANES]), &slice);
    }
}
