//! Isovalues at equal distances.

/// Isovalues at equal distances, of which each is compared with samples as any isovalue is: inside is `value >= iso`.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    isos: Vec<f64>,
    first: f64,
    per_level: f64,
}

/// As many as can be told apart in a picture, and no more than a pass has memory for.
const MOST: usize = 1 << 16;

impl Levels {
    /// So many isovalues, each in the middle of one of so many equal parts of a range. `None` if the range is empty or
    /// not finite, or has not so many different numbers, or if there are none, or more than 65 536.
    pub fn between([least, greatest]: [f64; 2], count: usize) -> Option<Self> {
        let width = greatest / count as f64 - least / count as f64;
        if !((1..=MOST).contains(&count) && width > 0.0 && width.is_finite()) {
            return None;
        }
        let at = |share: f64| least * (1.0 - share) + greatest * share;
        let isos: Vec<f64> = (0..count).map(|n| at((n as f64 + 0.5) / count as f64)).collect();
        let is_rising = isos.windows(2).all(|pair| pair[0] < pair[1]);
        is_rising.then(|| Self { first: isos[0], isos, per_level: width.recip() })
    }

    /// The isovalues, rising; never none.
    pub fn isos(&self) -> &[f64] {
        &self.isos
    }

    /// How far they are from each other.
    pub fn width(&self) -> f64 {
        self.per_level.recip()
    }

    /// At how many of them a value is inside. That of NaN is 0.
    #[inline]
    pub(crate) fn rank(&self, value: f64) -> usize {
        let guess = ((value - self.first) * self.per_level + 1.0).max(0.0); // NaN becomes 0
        let mut rank = (guess as usize).min(self.isos.len());
        // Rounding may lead to the one beside it.
        while rank > 0 && value < self.isos[rank - 1] {
            rank -= 1;
        }
        while rank < self.isos.len() && value >= self.isos[rank] {
            rank += 1;
        }
        rank
    }
}

#[cfg(test)]
mod tests {
    use super::Levels;

    #[test]
    fn isovalues_are_in_the_middle_of_equal_parts() {
        let levels = Levels::between([-1.0, 3.0], 4).unwrap();
        assert_eq!(levels.isos(), [-0.5, 0.5, 1.5, 2.5]);
        assert_eq!(levels.width(), 1.0);
    }

    #[test]
    fn a_value_is_inside_of_the_levels_that_it_is_not_below() {
        for (range, count) in [([-1.0, 3.0], 7), ([1e6, 1e6 + 0.25], 1000), ([-1e300, 1e300], 3)] {
            let levels = Levels::between(range, count).unwrap();
            let plainly = |value: f64| levels.isos().iter().filter(|&&iso| value >= iso).count();
            let near = levels.isos().iter().flat_map(|iso| [iso.next_down(), *iso, iso.next_up()]);
            let others =
                [f64::NEG_INFINITY, range[0], 0.0, -0.0, range[1], f64::INFINITY, f64::MAX];
            for value in near.chain(others) {
                assert_eq!(levels.rank(value), plainly(value), "{value}");
            }
            assert_eq!(levels.rank(f64::NAN), 0);
        }
    }

    #[test]
    fn a_range_without_room_has_no_levels() {
        assert_eq!(Levels::between([1.0, 1.0], 4), None);
        assert_eq!(Levels::between([2.0, 1.0], 4), None);
        assert_eq!(Levels::between([1.0, 1.0 + 4.0 * f64::EPSILON], 100), None);
        assert_eq!(Levels::between([0.0, 1.0], 0), None);
        assert_eq!(Levels::between([0.0, f64::INFINITY], 4), None);
        assert_eq!(Levels::between([f64::NAN, 1.0], 4), None);
        assert!(Levels::between([-f64::MAX, f64::MAX], 4).is_some());
    }
}
