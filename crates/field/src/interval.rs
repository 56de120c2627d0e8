//! Ranges of numbers, as bounds of what a function does in a box.

/// All numbers from `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The least of them.
    pub low: f64,
    /// The greatest of them.
    pub high: f64,
}

impl Interval {
    /// All numbers, the infinite ones too.
    pub const EVERYTHING: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// Whether a number is one of them. NaN is not.
    pub fn contains(&self, x: f64) -> bool {
        self.low <= x && x <= self.high
    }
}
