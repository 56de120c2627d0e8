//! Where a curve has maxima, and how far each stands out.

/// A maximum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Peak {
    /// Its place; the middle one of several that are equal.
    pub(crate) at: usize,
    /// How far one has to go down from it, on the easier side, to come to one that is higher; or to the end.
    pub(crate) prominence: f64,
}

/// The maxima within a curve of finite numbers, in order. Its ends are none.
pub(crate) fn peaks(curve: &[f64]) -> Vec<Peak> {
    let mut found = vec![];
    let mut n = 1;
    while n + 1 < curve.len() {
        let end = n + curve[n..].iter().take_while(|&&value| value == curve[n]).count();
        if curve[n - 1] < curve[n] && end < curve.len() && curve[end] < curve[n] {
            let height = curve[n];
            let lowest = |way: &mut dyn Iterator<Item = &f64>| {
                way.take_while(|&&value| value <= height)
                    .fold(height, |least, value| least.min(*value))
            };
            let before = lowest(&mut curve[..n].iter().rev());
            let after = lowest(&mut curve[end..].iter());
            found.push(Peak { at: (n + end - 1) / 2, prominence: height - before.max(after) });
        }
        n = end;
    }
    found
}

/// The means of numbers around each, by a bell of that standard deviation; at the ends of those that are there.
pub(crate) fn smooth(curve: &[f64], deviation: f64) -> Vec<f64> {
    let reach = (3.0 * deviation).ceil() as usize;
    let bell: Vec<f64> =
        (0..=reach).map(|n| (-0.5 * (n as f64 / deviation).powi(2)).exp()).collect();
    let mean = |n: usize| {
        let around = n.saturating_sub(reach)..curve.len().min(n + reach + 1);
        let (sum, weights) = around.fold((0.0, 0.0), |(sum, weights), m| {
            let weight = bell[n.abs_diff(m)];
            (sum + weight * curve[m], weights + weight)
        });
        sum / weights
    };
    (0..curve.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::{Peak, peaks, smooth};

    #[test]
    fn a_maximum_stands_out_from_the_higher_one_of_its_valleys() {
        let found = peaks(&[0.0, 5.0, 3.0, 4.0, 1.0, 9.0, 9.0, 9.0, 2.0]);
        let peak = |at, prominence| Peak { at, prominence };
        assert_eq!(found, [peak(1, 4.0), peak(3, 1.0), peak(6, 7.0)]);
    }

    #[test]
    fn ends_are_no_maxima() {
        assert_eq!(peaks(&[3.0, 2.0, 1.0]), []);
        assert_eq!(peaks(&[1.0, 2.0, 2.0]), []);
        assert_eq!(peaks(&[2.0, 2.0]), []);
        assert_eq!(peaks(&[]), []);
    }

    #[test]
    fn what_is_even_stays_and_what_is_not_becomes_lower() {
        assert!(smooth(&[2.0; 9], 1.5).iter().all(|value| (value - 2.0).abs() < 1e-15));
        let bump = smooth(&[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0], 1.0);
        assert!((bump[4] - 0.399).abs() < 1e-2 && (bump[3] - 0.242).abs() < 1e-2, "{bump:?}");
        assert!((bump.iter().sum::<f64>() - 1.0).abs() < 0.02);
    }
}
