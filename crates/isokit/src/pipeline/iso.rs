//! How an isovalue is chosen.

use crate::pipeline::PipelineError;
use isokit_job::Job;
use isokit_volume::{Histogram, Statistics};
use std::{fmt, str::FromStr};

/// An isovalue, or how to find one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IsoChoice {
    /// This value; finite.
    Value(f64),
    /// The value that splits the samples into two classes of the least spread (Otsu 1979).
    Auto,
    /// So many hundredths of the way from the least finite value to the greatest; 0 to 100.
    Percent(f64),
}

/// What samples tell of themselves.
pub(super) trait Facts {
    /// Range and NaN.
    fn statistics(&self, job: &Job) -> Result<Statistics, PipelineError>;

    /// How often each value occurs; `None` if none is finite.
    fn histogram(&self, job: &Job) -> Result<Option<&Histogram>, PipelineError>;
}

impl IsoChoice {
    /// The isovalue that was meant.
    pub(super) fn find(self, facts: &impl Facts, job: &Job) -> Result<f64, PipelineError> {
        let none = |reason| PipelineError::Iso { choice: self, reason };
        match self {
            Self::Value(iso) => Ok(iso),
            Self::Auto => {
                let histogram = facts.histogram(job)?.ok_or(none("no sample is finite"))?;
                histogram.otsu().ok_or(none("all samples have one value"))
            }
            Self::Percent(percent) => {
                let range = finite_range(facts, job)?.ok_or(none("no sample is finite"))?;
                let part = percent / 100.0;
                // The difference of two finite values may not be finite.
                Ok(range[0] * (1.0 - part) + range[1] * part)
            }
        }
    }
}

fn finite_range(facts: &impl Facts, job: &Job) -> Result<Option<[f64; 2]>, PipelineError> {
    let statistics = facts.statistics(job)?;
    if statistics.infinite == 0 {
        return Ok(statistics.range);
    }
    // Infinite samples are in no bin.
    Ok(facts.histogram(job)?.map(|histogram| histogram.range))
}

/// Not an isovalue.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a number, a percentage from 0% to 100%, or auto, found {0:?}")]
pub struct ParseIsoError(String);

impl FromStr for IsoChoice {
    type Err = ParseIsoError;

    fn from_str(text: &str) -> Result<Self, ParseIsoError> {
        let number = |text: &str| text.parse().ok().filter(|number: &f64| number.is_finite());
        let found = match text.strip_suffix('%') {
            _ if text == "auto" => Some(Self::Auto),
            Some(percent) => {
                number(percent).filter(|part| (0.0..=100.0).contains(part)).map(Self::Percent)
            }
            None => number(text).map(Self::Value),
        };
        found.ok_or_else(|| ParseIsoError(text.to_owned()))
    }
}

impl fmt::Display for IsoChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value(iso) => write!(f, "{iso}"),
            Self::Auto => f.write_str("auto"),
            Self::Percent(percent) => write!(f, "{percent}%"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::IsoChoice;

    #[test]
    fn numbers_percentages_and_auto_are_read() {
        for (text, expected) in [
            ("300", IsoChoice::Value(300.0)),
            ("-300", IsoChoice::Value(-300.0)),
            ("1e-3", IsoChoice::Value(1e-3)),
            ("50%", IsoChoice::Percent(50.0)),
            ("auto", IsoChoice::Auto),
        ] {
            assert_eq!(text.parse(), Ok(expected));
        }
    }

    #[test]
    fn a_refusal_names_what_was_expected_and_found() {
        for text in ["", "bone", "nan", "inf", "1e999", "%", "3,5", "-o", "150%", "-5%", "1e308%"] {
            let error = text.parse::<IsoChoice>().unwrap_err().to_string();
            let expected = "expected a number, a percentage from 0% to 100%, or auto, found";
            assert_eq!(error, format!("{expected} {text:?}"));
        }
    }
}
