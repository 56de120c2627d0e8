//! How an isovalue is chosen.

use std::{fmt, str::FromStr};

/// An isovalue, or how to find one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IsoChoice {
    /// This value; finite.
    Value(f64),
    /// The value that splits the samples into two classes of the least spread (Otsu 1979).
    Auto,
    /// So many hundredths of the way from the least finite value to the greatest.
    Percent(f64),
}

/// Not an isovalue.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a number, a percentage such as 50%, or auto, found {0:?}")]
pub struct ParseIsoError(String);

impl FromStr for IsoChoice {
    type Err = ParseIsoError;

    fn from_str(text: &str) -> Result<Self, ParseIsoError> {
        let number = |text: &str| text.parse().ok().filter(|number: &f64| number.is_finite());
        let found = match text.strip_suffix('%') {
            _ if text == "auto" => Some(Self::Auto),
            Some(percent) => number(percent).map(Self::Percent),
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
        for text in ["", "bone", "nan", "inf", "1e999", "%", "3,5", "-o"] {
            let error = text.parse::<IsoChoice>().unwrap_err().to_string();
            let expected = "expected a number, a percentage such as 50%, or auto, found";
            assert_eq!(error, format!("{expected} {text:?}"));
        }
    }
}
