//! Which isovalues stand out.

use isokit::{spectrum::Suggestion, volume::Histogram};
use serde::Serialize;
use std::collections::BTreeMap;

/// What `suggest --json` prints.
#[derive(Debug, Serialize)]
pub(crate) struct SuggestReport {
    pub(crate) schema: &'static str,
    pub(crate) path: String,
    /// Best first.
    pub(crate) suggestions: Vec<SuggestedIso>,
    /// Of the finite values; null if there are none.
    pub(crate) range: Option<[f64; 2]>,
    /// Of the finite values, in bins of a histogram.
    pub(crate) mean: Option<f64>,
    pub(crate) deviation: Option<f64>,
    /// By which value so many percent of the samples are reached.
    pub(crate) percentiles: BTreeMap<u8, f64>,
}

/// An isovalue that is worth a look.
#[derive(Debug, Serialize)]
pub(crate) struct SuggestedIso {
    pub(crate) iso: f64,
    pub(crate) score: f64,
    /// That of the first reason.
    pub(crate) method: &'static str,
    /// All of them, in words.
    pub(crate) reason: String,
}

/// Of the samples.
pub(crate) const PERCENTS: [u8; 7] = [1, 5, 25, 50, 75, 95, 99];

impl SuggestReport {
    pub(crate) fn of(
        path: String,
        histogram: Option<&Histogram>,
        suggestions: &[Suggestion],
    ) -> Self {
        let [mean, deviation] = match histogram.map(Histogram::mean_and_deviation) {
            Some(both) => both.map(Some),
            None => [None; 2],
        };
        let at = |histogram: &Histogram| {
            PERCENTS.map(|percent| (percent, histogram.quantile(f64::from(percent) / 100.0)))
        };
        Self {
            schema: "isokit.suggest/1",
            path,
            suggestions: suggestions.iter().map(SuggestedIso::of).collect(),
            range: histogram.map(|histogram| histogram.range),
            mean,
            deviation,
            percentiles: histogram.map(at).into_iter().flatten().collect(),
        }
    }
}

impl SuggestedIso {
    fn of(suggestion: &Suggestion) -> Self {
        let reasons: Vec<String> = suggestion.reasons.iter().map(ToString::to_string).collect();
        Self {
            iso: suggestion.iso,
            score: suggestion.score,
            method: suggestion.reasons.first().map_or("", |reason| reason.method()),
            reason: reasons.join("; "),
        }
    }
}
