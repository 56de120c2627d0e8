//! The values that part the samples into classes.

use isokit_volume::Histogram;

/// Classes of samples, each between two values.
#[derive(Clone, Debug, PartialEq)]
pub struct Classes {
    /// Between neighbouring classes, rising; each midway between two bins that have samples.
    pub thresholds: Vec<f64>,
    /// Which share of the samples each class has, from the lowest on.
    pub shares: Vec<f64>,
    /// Which share of the variance is between the classes, from 0 to 1: what is left is within them.
    pub separability: f64,
}

/// Bins that are told apart.
const BINS: usize = 1024;

/// So many classes of which the variance within is least (Otsu 1979, "A threshold selection method from gray-level
/// histograms"; of more than two, Liao, Chen & Chung 2001, "A fast algorithm for multilevel thresholding"). `None` if
/// fewer bins than that have samples, or for fewer than two classes.
///
/// Of more than 1024 bins with samples neighbours are taken together.
pub fn classes(histogram: &Histogram, count: usize) -> Option<Classes> {
    let bins = occupied(histogram);
    if count < 2 || bins.len() < count {
        return None;
    }
    let sums = Sums::of(&bins);
    let all = sums.between(0..bins.len());
    // What the best `n` classes of the first bins have, and where the last of them begins.
    let mut best: Vec<f64> = (0..=bins.len()).map(|end| sums.between(0..end)).collect();
    let mut begins = vec![];
    for n in 1..count {
        let mut next = vec![f64::NEG_INFINITY; bins.len() + 1];
        let mut begin = vec![0; bins.len() + 1];
        for end in n + 1..=bins.len() {
            for (first, before) in best.iter().enumerate().take(end).skip(n) {
                let sum = before + sums.between(first..end);
                if sum > next[end] {
                    (next[end], begin[end]) = (sum, first);
                }
            }
        }
        best = next;
        begins.push(begin);
    }
    let mut ends = vec![bins.len()];
    for begin in begins.iter().rev() {
        ends.push(begin[ends[ends.len() - 1]]);
    }
    ends.push(0);
    ends.reverse();
    let middle = |end: usize| {
        let [below, above] = [bins[end - 1].last, bins[end].first];
        histogram.first + (below as f64).midpoint(above as f64) * histogram.width
    };
    let share = |pair: &[usize]| sums.weight(pair[0]..pair[1]) / sums.weight(0..bins.len());
    let within_all = sums.squares - all;
    Some(Classes {
        thresholds: ends[1..count].iter().map(|&end| middle(end)).collect(),
        shares: ends.windows(2).map(share).collect(),
        separability: ((best[bins.len()] - all) / within_all).clamp(0.0, 1.0),
    })
}

/// Neighbouring bins with samples.
struct Bin {
    first: usize,
    last: usize,
    weight: f64,
    moment: f64,
    square: f64,
}

fn occupied(histogram: &Histogram) -> Vec<Bin> {
    let all: Vec<usize> =
        (0..histogram.counts.len()).filter(|&n| histogram.counts[n] > 0).collect();
    let together = all.len().div_ceil(BINS).max(1);
    let bin = |bins: &[usize]| {
        let (mut weight, mut moment, mut square) = (0.0, 0.0, 0.0);
        for &n in bins {
            let (count, place) = (histogram.counts[n] as f64, n as f64);
            weight += count;
            moment += count * place;
            square += count * place * place;
        }
        Bin { first: bins[0], last: bins[bins.len() - 1], weight, moment, square }
    };
    all.chunks(together).map(bin).collect()
}

/// Sums over the first so many bins.
struct Sums {
    weights: Vec<f64>,
    moments: Vec<f64>,
    squares: f64,
}

impl Sums {
    fn of(bins: &[Bin]) -> Self {
        let (mut weights, mut moments) = (vec![0.0], vec![0.0]);
        for (n, bin) in bins.iter().enumerate() {
            weights.push(weights[n] + bin.weight);
            moments.push(moments[n] + bin.moment);
        }
        Self { weights, moments, squares: bins.iter().map(|bin| bin.square).sum() }
    }

    fn weight(&self, bins: std::ops::Range<usize>) -> f64 {
        self.weights[bins.end] - self.weights[bins.start]
    }

    /// What a class has: the square of its mean, as often as it has samples.
    fn between(&self, bins: std::ops::Range<usize>) -> f64 {
        let weight = self.weight(bins.clone());
        let moment = self.moments[bins.end] - self.moments[bins.start];
        if weight > 0.0 { moment * moment / weight } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::classes;
    use isokit_volume::Histogram;

    fn histogram(counts: Vec<u64>) -> Histogram {
        let range = [10.0, 10.0 + 2.0 * (counts.len() - 1) as f64];
        Histogram { range, first: 10.0, width: 2.0, counts }
    }

    #[test]
    fn heaps_are_parted_between_them() {
        let found = classes(&histogram(vec![6, 2, 0, 0, 5, 5, 0, 0, 0, 2]), 3).unwrap();
        assert_eq!(found.thresholds, [10.0 + 2.0 * 2.5, 10.0 + 2.0 * 7.0]);
        assert_eq!(found.shares, [0.4, 0.5, 0.1]);
        assert!(found.separability > 0.95);
        let apart = classes(&histogram(vec![3, 0, 0, 1]), 2).unwrap();
        assert_eq!((apart.separability, apart.thresholds), (1.0, vec![13.0]));
    }

    #[test]
    fn two_classes_are_otsus_and_any_number_is_the_best_of_all() {
        let mut state = 3_u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            state >> 33
        };
        for _ in 0..200 {
            let counts: Vec<u64> = (0..9).map(|_| (next() % 7).saturating_sub(2)).collect();
            let given = histogram(counts.clone());
            let occupied: Vec<usize> = (0..9).filter(|&n| counts[n] > 0).collect();
            let Some(found) = classes(&given, 3) else {
                assert!(occupied.len() < 3);
                continue;
            };
            let within = |from: f64, to: f64| {
                let own: Vec<usize> = occupied
                    .iter()
                    .copied()
                    .filter(|&n| (from..to).contains(&given.middle(n)))
                    .collect();
                let weight: f64 = own.iter().map(|&n| counts[n] as f64).sum();
                let mean = own.iter().map(|&n| counts[n] as f64 * n as f64).sum::<f64>() / weight;
                own.iter().map(|&n| counts[n] as f64 * (n as f64 - mean).powi(2)).sum::<f64>()
            };
            let spread = |low: f64, high: f64| {
                within(f64::NEG_INFINITY, low) + within(low, high) + within(high, f64::INFINITY)
            };
            let two = [classes(&given, 2).unwrap().thresholds[0], given.otsu().unwrap()];
            let [one, otsus] = two.map(|iso| spread(iso, f64::INFINITY));
            assert!((one - otsus).abs() < 1e-9, "{two:?}");
            let own = spread(found.thresholds[0], found.thresholds[1]);
            for (n, &low) in occupied.iter().enumerate().skip(1) {
                for &high in &occupied[n + 1..] {
                    assert!(own <= spread(given.middle(low), given.middle(high)) + 1e-9);
                }
            }
            let all = within(f64::NEG_INFINITY, f64::INFINITY);
            assert!((found.separability - (1.0 - own / all)).abs() < 1e-9);
        }
    }

    #[test]
    fn more_classes_than_bins_with_samples_there_are_not() {
        assert_eq!(classes(&histogram(vec![3, 0, 1]), 3), None);
        assert_eq!(classes(&histogram(vec![3]), 2), None);
        assert_eq!(classes(&histogram(vec![3, 1]), 1), None);
    }

    #[test]
    fn of_many_bins_neighbours_are_taken_together() {
        let counts: Vec<u64> = (0..65_536).map(|n| u64::from(n % 7 != 0)).collect();
        let found = classes(&histogram(counts), 2).unwrap();
        assert!((found.shares[0] - 0.5).abs() < 2e-3, "{found:?}");
    }
}
