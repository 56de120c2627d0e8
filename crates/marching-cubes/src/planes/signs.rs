//! From a slice of samples to bits, for those who go through a volume slice by slice.

use super::{Lattice, PIECE_WORDS, behind_guard};
use isokit_lanes::{Thresholds, has_nan, signs_of_many, words};
use isokit_volume::{Sample, View};

/// What slices are classified by.
pub(crate) struct Signs<'a, T> {
    pub(crate) view: View<'a, T>,
    pub(crate) lattice: Lattice,
    pub(crate) thresholds: Thresholds<T>,
    pub(crate) stops_at_nan: bool,
}

impl<T: Sample> Signs<'_, T> {
    /// The bits of slice `k` of the samples for each threshold, one slice of bits every `stride` words, over zeros
    /// or the bits of another slice of samples. False, and not all of them, if a sample is NaN and that matters.
    pub(crate) fn classify(
        &self,
        k: usize,
        (bits, stride): (&mut [u64], usize),
        scratch: &mut Vec<T>,
    ) -> bool {
        let Self { view, lattice, thresholds, .. } = self;
        let matters = |row: &[T]| self.stops_at_nan && has_nan(row);
        if let Some(pieces) = lattice.as_one_row(view, k) {
            for (n, piece) in pieces.enumerate() {
                signs_of_many(piece, thresholds, &mut bits[n * PIECE_WORDS..], stride);
                if matters(piece) {
                    return false;
                }
            }
            return true;
        }
        let [nx, ny, _] = view.dims();
        for j in 0..ny {
            let row = view.row(j, k).gather(scratch);
            let own = lattice.row_of_samples(j);
            let (per_row, bits) = (own.len(), &mut bits[own.start..]);
            signs_of_many(row, thresholds, bits, stride);
            if matters(row) {
                return false;
            }
            if lattice.guard > 0 {
                for plane in bits.chunks_mut(stride) {
                    plane[words(nx)..per_row].fill(0);
                    behind_guard(&mut plane[..per_row]);
                }
            }
        }
        true
    }
}
