//! How long steps took, by the clock on the wall.

use serde::Serialize;
use std::time::Instant;

/// Seconds per step.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Timings {
    /// From the file to samples in memory.
    pub(crate) read: f64,
    /// Reading the index of the volume, or making and keeping it.
    pub(crate) index: f64,
    /// From the volume in memory to indexed meshes with normals in memory, allocation included; of
    /// several runs the median. Where only rows near the surfaces are read, and slice by slice, that is in it.
    pub(crate) extract: f64,
    /// Changing meshes after they were made: dividing, balancing and colouring them.
    pub(crate) mend: f64,
    /// From meshes in memory to files.
    pub(crate) write: f64,
    /// All of it, of several runs the last, with what the steps leave out.
    pub(crate) total: f64,
    /// Each run, where several were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) extract_all: Option<Vec<f64>>,
}

/// Does the work and adds its seconds.
pub(crate) fn timed<R>(seconds: &mut f64, work: impl FnOnce() -> R) -> R {
    let start = Instant::now();
    let result = work();
    *seconds += start.elapsed().as_secs_f64();
    result
}

/// The middle of some numbers, or halfway between the two in the middle; 0 of none.
pub(crate) fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |n: usize| sorted.get(n).copied().unwrap_or(0.0);
    at(sorted.len().saturating_sub(1) / 2).midpoint(at(sorted.len() / 2))
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median(&[7.0]), 7.0);
    }
}
