//! From a slice of samples to bits, for those who go through a volume slice by slice.

use super::{Lattice, PIECE_WORDS, behind_guard, behind_guards};
use isokit_lanes::{Thresholds, has_nan, signs_of_many, signs_side_by_side, words};
use isokit_volume::{Sample, View};
use std::ops::Range;

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
        self.each_row(k, scratch, |row, own, is_guarded| {
            let bits = &mut bits[own.start..];
            signs_of_many(row, &self.thresholds, bits, stride);
            if is_guarded {
                for plane in bits.chunks_mut(stride) {
                    plane[words(row.len())..own.len()].fill(0);
                    behind_guard(&mut plane[..own.len()]);
                }
            }
        })
    }

    /// The same for eight of the thresholds or fewer, whose planes lie side by side.
    pub(crate) fn classify_abreast(
        &self,
        k: usize,
        thresholds: &Thresholds<T>,
        bits: &mut [[u64; 8]],
        scratch: &mut Vec<T>,
    ) -> bool {
        self.each_row(k, scratch, |row, own, is_guarded| {
            let bits = &mut bits[own];
            signs_side_by_side(row, thresholds, bits);
            if is_guarded {
                bits[words(row.len())..].fill([0; 8]);
                behind_guards(bits);
            }
        })
    }

    /// Hands the rows of a slice over, or pieces of it as if they were rows, with the words that their bits go to, and
    /// whether that is behind a guard. False, and not all of them, if a sample is NaN and that matters.
    fn each_row(
        &self,
        k: usize,
        scratch: &mut Vec<T>,
        mut take: impl FnMut(&[T], Range<usize>, bool),
    ) -> bool {
        let Self { view, lattice, .. } = self;
        let matters = |row: &[T]| self.stops_at_nan && has_nan(row);
        if let Some(pieces) = lattice.as_one_row(view, k) {
            for (n, piece) in pieces.enumerate() {
                let first = n * PIECE_WORDS;
                take(piece, first..first + words(piece.len()), false);
                if matters(piece) {
                    return false;
                }
            }
            return true;
        }
        for j in 0..view.dims()[1] {
            let row = view.row(j, k).gather(scratch);
            take(row, lattice.row_of_samples(j), lattice.guard > 0);
            if matters(row) {
                return false;
            }
        }
        true
    }
}
