//! The values of a cubic cell along a ray.

use super::root::root;

/// A polynomial of degree 9 on the way through a cell, from 0 to 1, as numbers of which it is the sum by Bernstein's
/// polynomials. It is nowhere beyond all of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nonic([f64; 10]);

/// How often each of Bernstein's polynomials of degree 3, and of 9, counts.
const OF_CUBICS: [f64; 4] = [1.0, 3.0, 3.0, 1.0];
const OF_NONICS: [f64; 10] = [1.0, 9.0, 36.0, 84.0, 126.0, 126.0, 84.0, 36.0, 9.0, 1.0];

/// Shorter parts of the way are not cut in two.
const SHORT: f64 = 1e-12;

impl Nonic {
    /// The function in a cell of such control points along the way between two places in it.
    pub(super) fn between(points: &[[[f64; 4]; 4]; 4], from: [f64; 3], to: [f64; 3]) -> Self {
        let [x, y, z] = [0, 1, 2].map(|k| basis(from[k], to[k]));
        let mut whole = [0.0; 10];
        for (slice, along_z) in points.iter().zip(&z) {
            let mut plane = [0.0; 7];
            for (row, along_y) in slice.iter().zip(&y) {
                let mut line = [0.0; 4];
                for (point, along_x) in row.iter().zip(&x) {
                    for (line, part) in line.iter_mut().zip(along_x) {
                        *line += point * part;
                    }
                }
                add_product(&mut plane, &line, along_y);
            }
            add_product(&mut whole, &plane, along_z);
        }
        Self(std::array::from_fn(|n| whole[n] / OF_NONICS[n]))
    }

    /// Names each place where the way goes in or out of what is `iso` or more, in order. It begins as `is_inside`
    /// says, whatever the polynomial has there; how it ends comes back.
    ///
    /// A part of the way whose numbers change sides once has one crossing, as Descartes' rule has it (Lane & Riesenfeld
    /// 1981, "Bounds on a polynomial"); any other is cut in two.
    pub(super) fn crossings(&self, iso: f64, is_inside: bool, mut meet: impl FnMut(f64)) -> bool {
        crossings(self.0.map(|point| point - iso), [0.0, 1.0], is_inside, &mut meet)
    }
}

/// Bernstein's four polynomials of degree 3 between two places, by those of the way from 0 to 1, each as often as it
/// counts.
fn basis(from: f64, to: f64) -> [[f64; 4]; 4] {
    let mut basis = [[0.0; 4]; 4];
    for (m, times) in OF_CUBICS.into_iter().enumerate() {
        // Symmetric in three places: so many of them are the end (Ramshaw 1989, "Blossoms are polar forms").
        let mut own = [1.0, 0.0, 0.0, 0.0];
        for n in 0..3 {
            let t = if n < m { to } else { from };
            own = std::array::from_fn(|k| {
                own[k] * (1.0 - t) + if k > 0 { own[k - 1] * t } else { 0.0 }
            });
        }
        for (basis, own) in basis.iter_mut().zip(own) {
            basis[m] = times * own;
        }
    }
    basis
}

/// Adds the product of two polynomials.
fn add_product(sum: &mut [f64], a: &[f64], b: &[f64]) {
    for (n, a) in a.iter().enumerate() {
        for (sum, b) in sum[n..].iter_mut().zip(b) {
            *sum += a * b;
        }
    }
}

/// Names the crossings of a part of the way, where the polynomial is to be compared with 0.
fn crossings(
    points: [f64; 10],
    [from, to]: [f64; 2],
    is_inside: bool,
    meet: &mut impl FnMut(f64),
) -> bool {
    let changes = points.windows(2).filter(|pair| (pair[0] >= 0.0) != (pair[1] >= 0.0)).count();
    if changes > 1 && to - from > SHORT {
        let (left, right) = halves(points);
        let middle = 0.5 * (from + to);
        let is_inside = crossings(left, [from, middle], is_inside, meet);
        return crossings(right, [middle, to], is_inside, meet);
    }
    let is_inside_there = points[9] >= 0.0;
    if is_inside_there != is_inside {
        let share =
            if changes == 1 { root(|t| at(&points, t), [0.0, 1.0], is_inside_there) } else { 0.0 };
        meet(from + share * (to - from));
    }
    is_inside_there
}

/// The value at a place and how it rises there (de Casteljau's scheme; Farin 2002, section 4.2).
fn at(points: &[f64; 10], t: f64) -> [f64; 2] {
    let mut points = *points;
    for last in (1..9).rev() {
        for n in 0..=last {
            points[n] += (points[n + 1] - points[n]) * t;
        }
    }
    let rise = points[1] - points[0];
    [points[0] + rise * t, 9.0 * rise]
}

/// The same polynomial on the two halves of the way.
fn halves(mut points: [f64; 10]) -> ([f64; 10], [f64; 10]) {
    let mut left = points;
    for (n, left) in left.iter_mut().enumerate() {
        *left = points[0];
        for m in 0..9 - n {
            points[m] = 0.5 * (points[m] + points[m + 1]);
        }
    }
    (left, points)
}

#[cfg(test)]
mod tests {
    use super::{Nonic, at};

    /// Numbers from −1 to 1 from a generator with a fixed beginning.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 9_u64;
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / f64::from(1 << 23) - 1.0
        }
    }

    #[test]
    fn along_a_way_it_is_the_sum_by_bernsteins_polynomials_in_space() {
        let mut next = numbers();
        let weight = |n: usize, t: f64| {
            [1.0, 3.0, 3.0, 1.0][n] * t.powi(n as i32) * (1.0 - t).powi(3 - n as i32)
        };
        for _ in 0..100 {
            let points = [(); 4].map(|()| [(); 4].map(|()| [(); 4].map(|()| next())));
            let [from, to] = [(); 2].map(|()| [(); 3].map(|()| next().abs()));
            let nonic = Nonic::between(&points, from, to);
            for t in [0.0, 0.3, 0.5, 1.0] {
                let [x, y, z] = [0, 1, 2].map(|k| from[k] + t * (to[k] - from[k]));
                let all = (0..64).map(|n| [n % 4, n / 4 % 4, n / 16]);
                let parts = all
                    .map(|[i, j, k]| points[k][j][i] * weight(i, x) * weight(j, y) * weight(k, z));
                let expected: f64 = parts.sum();
                assert!((at(&nonic.0, t)[0] - expected).abs() < 1e-14, "{t}");
                let [low, high] = [t - 1e-5, t + 1e-5].map(|t| at(&nonic.0, t)[0]);
                assert!((at(&nonic.0, t)[1] - (high - low) / 2e-5).abs() < 1e-7, "{t}");
            }
        }
    }

    #[test]
    fn every_crossing_is_found_in_order_and_no_other() {
        let (mut next, mut most) = (numbers(), 0);
        for _ in 0..2000 {
            // Its numbers swing, or else it would hardly turn.
            let nonic =
                Nonic(std::array::from_fn(|n| next() * [0.1, 1.0, 9.0][n.min(9 - n).min(2)]));
            let mut met = vec![];
            let value = |t| at(&nonic.0, t)[0];
            let ends = nonic.crossings(0.0, value(0.0) >= 0.0, |t| met.push(t));
            assert_eq!(ends, value(1.0) >= 0.0);
            assert!(met.is_sorted() && met.iter().all(|t| (0.0..=1.0).contains(t)));
            assert!(met.iter().all(|&t| value(t).abs() < 1e-12), "{nonic:?}: {met:?}");
            let signs: Vec<bool> =
                (0..=2000).map(|n| value(f64::from(n) / 2000.0) >= 0.0).collect();
            let changes = signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
            // A dense walk may step over a pair.
            assert!(met.len() >= changes && (met.len() - changes) % 2 == 0, "{nonic:?}: {met:?}");
            most = most.max(met.len());
        }
        assert!(most >= 5, "{most}");
    }

    #[test]
    fn what_only_touches_the_value_ends_and_is_met_by_pairs() {
        // (2 t − 1)², once touching from above, once from below, once not at all.
        let points = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map(|n| {
            let n = f64::from(n);
            1.0 - 4.0 * n / 9.0 + 4.0 * n * (n - 1.0) / 72.0
        });
        for (sign, lift) in [(1.0, 0.0), (-1.0, 0.0), (1.0, 1e-9), (-1.0, -1e-9)] {
            let nonic = Nonic(points.map(|point| sign * point + lift));
            let mut met = vec![];
            assert_eq!(nonic.crossings(0.0, sign > 0.0, |t| met.push(t)), sign > 0.0);
            assert!(met.len() % 2 == 0 && met.iter().all(|t| (t - 0.5).abs() < 1e-6), "{met:?}");
        }
        let mut met = vec![];
        assert!(Nonic([0.0; 10]).crossings(0.0, false, |t| met.push(t)));
        assert_eq!(met, [0.0]);
    }
}
