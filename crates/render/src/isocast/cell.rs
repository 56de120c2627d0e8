//! The values of a cell along a ray.

use super::root::root;

/// A cubic on the way through a cell, from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cubic([f64; 4]);

impl Cubic {
    /// The trilinear function of eight corners along the way between two places in the cell.
    pub(super) fn between(corners: [f64; 8], from: [f64; 3], to: [f64; 3]) -> Self {
        let [f000, f100, f010, f110, f001, f101, f011, f111] = corners;
        let (x, y, z) = (f100 - f000, f010 - f000, f001 - f000);
        let (xy, xz, yz) = (f110 - f100 - y, f101 - f100 - z, f011 - f010 - z);
        let xyz = (f111 - f011) - (f101 - f001) - xy;
        let [u, v, w] = from;
        let [a, b, c] = [0, 1, 2].map(|k| to[k] - from[k]);
        Self([
            f000 + u * x + v * y + w * z + u * v * xy + u * w * xz + v * w * yz + u * v * w * xyz,
            a * x
                + b * y
                + c * z
                + (a * v + b * u) * xy
                + (a * w + c * u) * xz
                + (b * w + c * v) * yz
                + (a * v * w + b * u * w + c * u * v) * xyz,
            a * b * xy + a * c * xz + b * c * yz + (a * b * w + a * c * v + b * c * u) * xyz,
            a * b * c * xyz,
        ])
    }

    fn at(&self, t: f64) -> f64 {
        let [a, b, c, d] = self.0;
        a + t * (b + t * (c + t * d))
    }

    fn rise(&self, t: f64) -> f64 {
        let [_, b, c, d] = self.0;
        b + t * (2.0 * c + t * 3.0 * d)
    }

    /// Names each place where the way goes in or out of what is `iso` or more, in order. It begins as `is_inside`
    /// says, whatever the cubic has there; how it ends comes back.
    pub(super) fn crossings(
        &self,
        iso: f64,
        mut is_inside: bool,
        mut meet: impl FnMut(f64),
    ) -> bool {
        let mut from = 0.0;
        for to in self.turns().into_iter().chain([1.0]) {
            let is_inside_there = self.at(to) >= iso;
            if is_inside_there != is_inside {
                meet(root(|t| [self.at(t) - iso, self.rise(t)], [from, to], is_inside_there));
                is_inside = is_inside_there;
            }
            from = to;
        }
        is_inside
    }

    /// Where between 0 and 1 it turns from rising to falling or back, in order; 1 where it does not.
    fn turns(&self) -> [f64; 2] {
        // In units of the greatest, so that no square overflows or vanishes.
        let [_, b, c, d] = self.0;
        let greatest = b.abs().max(c.abs()).max(d.abs());
        let [b, c, d] = [b, c, d].map(|part| part / greatest);
        // b + 2 c t + 3 d t² = 0, by the formula that does not cancel.
        let root = (c * c - 3.0 * b * d).sqrt();
        let sum = -(c + root.copysign(c));
        let turns = [sum / (3.0 * d), b / sum].map(|t| if t > 0.0 && t < 1.0 { t } else { 1.0 });
        [turns[0].min(turns[1]), turns[0].max(turns[1])]
    }
}

#[cfg(test)]
mod tests {
    use super::Cubic;

    /// Numbers from −1 to 1 from a generator with a fixed beginning.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 7_u64;
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / f64::from(1 << 23) - 1.0
        }
    }

    fn trilinear(corners: [f64; 8], [x, y, z]: [f64; 3]) -> f64 {
        let weight = |k: usize| {
            let along = |bit: usize, at: f64| if k >> bit & 1 == 1 { at } else { 1.0 - at };
            along(0, x) * along(1, y) * along(2, z)
        };
        (0..8).map(|k| weight(k) * corners[k]).sum()
    }

    #[test]
    fn along_a_way_the_cubic_is_the_trilinear_function() {
        let mut next = numbers();
        for _ in 0..200 {
            let corners: [f64; 8] = std::array::from_fn(|_| next());
            let [from, to]: [[f64; 3]; 2] =
                std::array::from_fn(|_| std::array::from_fn(|_| next().abs()));
            let cubic = Cubic::between(corners, from, to);
            for t in [0.0, 0.3, 0.5, 1.0] {
                let place = std::array::from_fn(|k| from[k] + t * (to[k] - from[k]));
                assert!((cubic.at(t) - trilinear(corners, place)).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn every_crossing_is_found_in_order_and_no_other() {
        let (mut next, mut most) = (numbers(), 0);
        for _ in 0..3000 {
            let cubic = Cubic(std::array::from_fn(|k| next() * [0.3, 3.0, 8.0, 6.0][k]));
            let mut met = vec![];
            let is_inside = cubic.at(0.0) >= 0.0;
            let ends = cubic.crossings(0.0, is_inside, |t| met.push(t));
            assert_eq!(ends, cubic.at(1.0) >= 0.0);
            assert!(met.is_sorted() && met.iter().all(|t| (0.0..=1.0).contains(t)));
            assert!(met.iter().all(|&t| cubic.at(t).abs() < 1e-13), "{cubic:?}: {met:?}");
            let signs = (0..=2000).map(|n| cubic.at(f64::from(n) / 2000.0) >= 0.0);
            let signs: Vec<bool> = signs.collect();
            let changes = signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
            // A dense walk may step over a pair.
            assert!(met.len() >= changes && (met.len() - changes) % 2 == 0, "{cubic:?}: {met:?}");
            most = most.max(met.len());
        }
        assert_eq!(most, 3);
    }

    #[test]
    fn pairs_of_crossings_are_found_however_large_numbers_are() {
        for size in [1e-200, 1.0, 1e200] {
            // Up and down again: 4 t (1 − t).
            let hill = Cubic([0.0, 4.0 * size, -4.0 * size, 0.0]);
            let mut met = vec![];
            assert!(!hill.crossings(0.75 * size, false, |t| met.push(t)));
            assert_eq!(met, [0.25, 0.75]);
        }
    }

    #[test]
    fn a_way_that_begins_otherwise_than_rounding_says_is_put_right_once() {
        let flat = Cubic([1.0, 0.0, 0.0, 0.0]);
        let mut met = vec![];
        assert!(flat.crossings(1.0, false, |t| met.push(t)));
        assert_eq!(met.len(), 1);
        let ramp = Cubic([-1.0, 2.0, 0.0, 0.0]);
        let mut met = vec![];
        assert!(ramp.crossings(0.0, false, |t| met.push(t)));
        assert_eq!(met, [0.5]);
    }
}
