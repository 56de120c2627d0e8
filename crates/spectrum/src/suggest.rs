//! Isovalues that are worth a look, and why.

use crate::{
    ContourSpectrum, classes,
    peaks::{Peak, peaks, smooth},
};
use isokit_volume::Histogram;
use std::fmt;

/// An isovalue that is worth a look.
#[derive(Clone, Debug, PartialEq)]
pub struct Suggestion {
    /// The value.
    pub iso: f64,
    /// How much it stands out by its first reason, from 0 to 1.
    pub score: f64,
    /// Why, the best first; never none.
    pub reasons: Vec<Reason>,
}

/// Why an isovalue is worth a look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// It parts the samples into classes ([`classes`]).
    Classes {
        /// How many there are.
        count: usize,
        /// Which share of all samples is above it.
        above: f64,
        /// Which share of the variance that one class fewer leaves within classes is between these: the score.
        gain: f64,
    },
    /// The total gradient has a maximum: much of a boundary runs there (Pekar, Wiemker & Hempel 2001, section 3). The
    /// score is how far it stands out, as a share of the greatest.
    TotalGradient {
        /// The surface's area, in units of the world squared.
        area: f64,
        /// Its mean gradient: values per unit of the world.
        mean_gradient: f64,
    },
    /// The mean gradient has a maximum: the boundary that runs there is sharp. The score is how far it stands out, as a
    /// share of the greatest.
    MeanGradient {
        /// The surface's area, in units of the world squared.
        area: f64,
        /// Its mean gradient: values per unit of the world.
        mean_gradient: f64,
    },
}

/// Peaks that stand out less are taken for chance.
const LEAST: f64 = 0.03;

/// The mean gradient of a surface with a smaller share of the greatest area counts as much less as that is smaller.
const SMALL: f64 = 0.1;

/// By how much curves are smoothed, and how near to each other values are taken for the same: shares of all levels.
const SMOOTH: f64 = 0.008;
const NEAR: f64 = 0.025;

/// The isovalues that stand out, best first: those that part the samples into two classes or three, and those at which
/// the total gradient or the mean gradient has a maximum.
pub fn suggest(histogram: &Histogram, spectrum: &ContourSpectrum) -> Vec<Suggestion> {
    let mut found = of_classes(histogram);
    let levels = spectrum.levels();
    let (contours, deviation) = (spectrum.contours(), SMOOTH * levels.isos().len() as f64);
    let deviation = deviation.max(1.0);
    let smoothed = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
        smooth(&(0..contours.len()).map(of).collect::<Vec<_>>(), deviation)
    };
    let area = smoothed(&|n| contours[n].area);
    let total = smoothed(&|n| contours[n].total_gradient);
    let widest = greatest(&area);
    let steep = |n: usize| if area[n] > 0.0 { total[n] / area[n] } else { 0.0 };
    let mean: Vec<f64> = (0..contours.len()).map(steep).collect();
    let weight = |n: usize| (area[n] / (SMALL * widest)).min(1.0);
    let of_peaks =
        |curve: &[f64], weight: &dyn Fn(usize) -> f64, reason: &dyn Fn(usize) -> Reason| {
            let most = (0..curve.len()).map(|n| curve[n] * weight(n)).fold(0.0, f64::max);
            let suggestion = |peak: Peak| Suggestion {
                iso: rounded(levels.isos()[peak.at], levels.width()),
                score: (peak.prominence * weight(peak.at) / most).min(1.0),
                reasons: vec![reason(peak.at)],
            };
            let all = peaks(curve).into_iter().map(suggestion);
            all.filter(|one| one.score > LEAST).collect::<Vec<_>>()
        };
    found.extend(of_peaks(&total, &|_| 1.0, &|n| Reason::TotalGradient {
        area: area[n],
        mean_gradient: steep(n),
    }));
    found.extend(of_peaks(&mean, &weight, &|n| Reason::MeanGradient {
        area: area[n],
        mean_gradient: steep(n),
    }));
    together(found, NEAR * levels.width() * levels.isos().len() as f64)
}

fn of_classes(histogram: &Histogram) -> Vec<Suggestion> {
    let (mut found, mut before) = (vec![], 0.0);
    for count in [2, 3] {
        let Some(all) = classes(histogram, count) else { break };
        let gain = (all.separability - before) / (1.0 - before);
        before = all.separability;
        for (n, &iso) in all.thresholds.iter().enumerate() {
            let above = all.shares[n + 1..].iter().sum();
            let reasons = vec![Reason::Classes { count, above, gain }];
            found.push(Suggestion { iso, score: gain, reasons });
        }
        if before >= 1.0 {
            break;
        }
    }
    found
}

/// Best first; of those that are near to each other the best, with the reasons of all.
fn together(mut found: Vec<Suggestion>, near: f64) -> Vec<Suggestion> {
    found.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut kept: Vec<Suggestion> = vec![];
    for next in found {
        match kept.iter_mut().find(|better| (better.iso - next.iso).abs() <= near) {
            Some(better) => better.reasons.extend(next.reasons),
            None => kept.push(next),
        }
    }
    kept
}

fn greatest(curve: &[f64]) -> f64 {
    curve.iter().fold(0.0, |most, value| value.max(most))
}

/// With as many digits as tell levels apart.
fn rounded(iso: f64, width: f64) -> f64 {
    let digits = -width.log10().floor();
    let unit = 10.0_f64.powi(digits.clamp(-300.0, 300.0) as i32);
    let round = (iso * unit).round() / unit;
    if round.is_finite() { round } else { iso }
}

impl Reason {
    /// The method's name.
    pub fn method(&self) -> &'static str {
        match self {
            Self::Classes { .. } => "otsu",
            Self::TotalGradient { .. } => "laplacian",
            Self::MeanGradient { .. } => "contour",
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Classes { count, above, .. } => {
                let classes = if count == 2 { "two classes" } else { "three classes" };
                let percent = Figures(100.0 * above);
                write!(f, "parts the samples into {classes}; {percent} % are above")
            }
            Self::TotalGradient { area, mean_gradient } => {
                let (area, mean) = (Figures(area), Figures(mean_gradient));
                write!(f, "much boundary: an area of {area}, {mean} per unit steep")
            }
            Self::MeanGradient { area, mean_gradient } => {
                let (area, mean) = (Figures(area), Figures(mean_gradient));
                write!(f, "a sharp boundary: {mean} per unit steep, an area of {area}")
            }
        }
    }
}

/// A number with three figures.
struct Figures(f64);

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let long = self.0.abs().log10().floor();
        match long {
            _ if !long.is_finite() => write!(f, "{}", self.0),
            _ if !(-4.0..15.0).contains(&long) => write!(f, "{:.2e}", self.0),
            _ if long >= 2.0 => {
                let unit = 10.0_f64.powi(long as i32 - 2);
                write!(f, "{}", (self.0 / unit).round() * unit)
            }
            _ => write!(f, "{:.*}", (2.0 - long) as usize, self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Figures, Reason, suggest};
    use crate::{ContourSpectrum, Levels};
    use isokit_geom::Frame;
    use isokit_job::Job;
    use isokit_volume::{Grid, Histogram, Statistics, Volume};

    /// Balls in balls: shells of some values, with slopes between them.
    fn suggested(value: impl Fn(f64) -> f32) -> Vec<super::Suggestion> {
        let job = Job::default();
        let grid = Grid::new([64; 3], Frame::default()).unwrap();
        let at = |n: usize| {
            let place = [n % 64, n / 64 % 64, n / 4096].map(|i| i as f64 - 31.4);
            value(place.iter().map(|c| c * c).sum::<f64>().sqrt())
        };
        let volume = Volume::new(grid, (0..64 * 64 * 64).map(at).collect()).unwrap();
        let statistics = Statistics::of(&volume.view(), &job).unwrap();
        let histogram = Histogram::of(&volume.view(), &statistics, &job).unwrap().unwrap();
        let levels = Levels::between(histogram.range, 256).unwrap();
        let spectrum = ContourSpectrum::of(&volume.view(), levels, &job).unwrap();
        suggest(&histogram, &spectrum)
    }

    fn step(radius: f64, at: f64) -> f64 {
        0.5 + 0.5 * ((at - radius) / 1.2).tanh()
    }

    #[test]
    fn boundaries_between_three_materials_are_found() {
        let found = suggested(|r| (40.0 * step(r, 26.0) + 160.0 * step(r, 14.0)) as f32);
        for boundary in [20.0, 120.0] {
            let near = found.iter().find(|one| (one.iso - boundary).abs() < 8.0);
            let reasons = &near.unwrap_or_else(|| panic!("{boundary} in {found:?}")).reasons;
            let is_steep = |reason: &Reason| !matches!(reason, Reason::Classes { .. });
            assert!(reasons.iter().any(is_steep), "{boundary}: {reasons:?}");
        }
        assert!(found.is_sorted_by(|a, b| a.score >= b.score));
        assert!(found.iter().all(|one| (0.0..=1.0).contains(&one.score)));
        let apart = |a: f64, b: f64| a == b || (a - b).abs() > 4.9;
        assert!(found.iter().all(|a| found.iter().all(|b| apart(a.iso, b.iso))), "{found:?}");
    }

    #[test]
    fn two_values_are_parted_between_them() {
        let found = suggested(|r| if r < 20.0 { 100.0 } else { 0.0 });
        assert_eq!(found[0].score, 1.0);
        assert!((1.0..99.0).contains(&found[0].iso), "{found:?}");
    }

    #[test]
    fn reasons_are_words_with_three_figures() {
        let all = [0.0, 0.01234, 1.0, 12.345, 123.4, 98765.0, 1.5e20, 1e-9];
        let words = all.map(|number| Figures(number).to_string());
        assert_eq!(words, ["0", "0.0123", "1.00", "12.3", "123", "98800", "1.50e20", "1.00e-9"]);
        let reason = Reason::Classes { count: 2, above: 0.125, gain: 0.8 };
        assert_eq!(reason.to_string(), "parts the samples into two classes; 12.5 % are above");
        assert_eq!(reason.method(), "otsu");
    }
}
