//! Two-dimensional transfer functions: what a place looks like by its value and by how steep values are there
//! (Levoy 1988, "Display of surfaces from volume data"; Kindlmann & Durkin 1998, "Semi-automatic generation of
//! transfer functions for direct volume rendering").
//!
//! A row for each of some slopes is a function of values. Between two rows what hides light, the extinction
//! −ln (1 − opacity), changes linearly; so a place half as steep as a row, above one that shows nothing, hides per length
//! half as much.

use super::{ControlPoint, TransferFunction};

/// What places look like by value and slope: the length of the gradient, in values per world unit.
///
/// # Guarantees
///
/// There is a row or more, and slopes are finite and rise from row to row, from 0 or more.
#[derive(Clone, Debug, PartialEq)]
pub struct SlopeFunction {
    rows: Vec<(f64, TransferFunction)>,
}

/// Why rows are no such function.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SlopeError {
    /// There is none.
    #[error("a transfer function by slopes has a row at least")]
    Empty,
    /// A slope is out of its range, or not above that of the row before.
    #[error(
        "row {number} of the transfer function has slope {slope}: slopes are finite and rise from row to row, from 0 on"
    )]
    Slope {
        /// Counted from 1.
        number: usize,
        /// Its slope.
        slope: f64,
    },
}

/// Opacities are taken for no more: what is opaque hides but 2⁻²⁴ of what is behind it in a reference length.
const MOST: f64 = 1.0 - 1.0 / (1 << 24) as f64;

impl SlopeFunction {
    /// The function of those rows: of each its slope, and what values look like there. Less steep than the first is as
    /// the first, and steeper than the last as the last.
    ///
    /// # Errors
    ///
    /// If there is no row, or slopes do not rise.
    pub fn new(rows: Vec<(f64, TransferFunction)>) -> Result<Self, SlopeError> {
        if rows.is_empty() {
            return Err(SlopeError::Empty);
        }
        let mut before = -1.0;
        for (number, &(slope, _)) in (1..).zip(&rows) {
            if !(slope > before && slope >= 0.0 && slope.is_finite()) {
                return Err(SlopeError::Slope { number, slope });
            }
            before = slope;
        }
        Ok(Self { rows })
    }

    /// What is even is not seen, and what is as steep as `full` or more as `function` says.
    ///
    /// # Errors
    ///
    /// If `full` is not above 0, or infinite.
    pub fn fading(function: TransferFunction, full: f64) -> Result<Self, SlopeError> {
        Self::new(vec![(0.0, function.hidden()), (full, function)])
    }

    /// The rows.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = (f64, &TransferFunction)> {
        self.rows.iter().map(|(slope, function)| (*slope, function))
    }

    /// The row of the greatest slope.
    pub fn steepest(&self) -> &TransferFunction {
        &self.rows[self.rows.len() - 1].1
    }

    /// What a value looks like where values are so steep.
    pub fn at(&self, value: f64, slope: f64) -> ControlPoint {
        let (row, share) = between(self.rows.iter().map(|row| row.0), slope);
        let ends = [row, (row + 1).min(self.rows.len() - 1)];
        let ends = ends.map(|row| self.rows[row].1.at(value));
        let weights = [1.0 - share, share];
        let all: [f64; 2] = std::array::from_fn(|n| weights[n] * extinction(ends[n].opacity));
        let sum = all[0] + all[1];
        let color = std::array::from_fn(|part| {
            let of = |n: usize| all[n] * f64::from(ends[n].color[part]);
            if sum > 0.0 { ((of(0) + of(1)) / sum) as f32 } else { ends[1].color[part] }
        });
        ControlPoint { value, color, opacity: -(-sum).exp_m1() as f32 }
    }
}

/// What hides light: it adds up along a ray.
pub(super) fn extinction(opacity: f32) -> f64 {
    -(-f64::from(opacity).min(MOST)).ln_1p()
}

/// The row of rising slopes before a slope, and how far it is to the next: before the first as there.
pub(super) fn between(slopes: impl Iterator<Item = f64>, slope: f64) -> (usize, f64) {
    let (mut row, mut low) = (0, f64::NAN);
    for (n, next) in slopes.enumerate() {
        if n > 0 && slope < next {
            return (row, ((slope - low) / (next - low)).max(0.0));
        }
        (row, low) = (n, next);
    }
    (row, 0.0)
}

#[cfg(test)]
mod tests {
    use super::{SlopeError, SlopeFunction};
    use crate::{ControlPoint, TransferFunction};

    fn flat(shade: f32, opacity: f32) -> TransferFunction {
        let points = vec![ControlPoint { value: 0.0, color: [shade; 3], opacity }];
        TransferFunction::new(points).unwrap()
    }

    #[test]
    fn between_rows_what_hides_light_changes_linearly() {
        let rows = vec![(0.0, flat(0.0, 0.0)), (4.0, flat(1.0, 0.75)), (6.0, flat(0.5, 0.75))];
        let function = SlopeFunction::new(rows).unwrap();
        for (slope, shade, opacity) in [
            (0.0, 0.0, 0.0),
            (2.0, 1.0, 0.5), // two of them hide what one of 0.75 does
            (4.0, 1.0, 0.75),
            (5.0, 0.75, 0.75),
            (60.0, 0.5, 0.75),
        ] {
            let found = function.at(7.0, slope);
            assert!((found.opacity - opacity).abs() < 1e-6, "{slope}: {found:?}");
            assert!(opacity == 0.0 || (found.color[0] - shade).abs() < 1e-6, "{slope}: {found:?}");
        }
        assert_eq!(SlopeFunction::fading(flat(1.0, 0.75), 4.0).unwrap().at(0.0, 2.0).opacity, 0.5);
    }

    #[test]
    fn rows_that_do_not_rise_are_refused_by_number() {
        let row = |slope| (slope, flat(1.0, 0.5));
        assert_eq!(SlopeFunction::new(vec![]).unwrap_err(), SlopeError::Empty);
        for slopes in [[1.0, 1.0], [1.0, 0.5], [0.0, f64::NAN], [0.0, f64::INFINITY]] {
            let found = SlopeFunction::new(slopes.map(row).into()).unwrap_err();
            assert!(matches!(found, SlopeError::Slope { number: 2, .. }), "{found:?}");
        }
        let below = SlopeFunction::new(vec![row(-0.5)]);
        assert!(matches!(below.unwrap_err(), SlopeError::Slope { number: 1, .. }));
    }
}
