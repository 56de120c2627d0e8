//! Samples that are NaN: how many, and the first.

/// What was met in some samples.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Found {
    pub(crate) count: u64,
    pub(crate) first: Option<[usize; 3]>,
}

impl Found {
    /// What the bits of row (j, k) tell.
    pub(crate) fn in_row(bits: &[u64], [j, k]: [usize; 2]) -> Self {
        let count = bits.iter().map(|word| u64::from(word.count_ones())).sum();
        let word = bits.iter().position(|&word| word != 0);
        let first = word.map(|w| [64 * w + bits[w].trailing_zeros() as usize, j, k]);
        Self { count, first }
    }

    /// The same where what was taken for a row are samples of rows of `nx` from this one on, as if all were one.
    pub(crate) fn placed_from(self, start: usize, nx: usize) -> Self {
        let place = |[i, j, k]: [usize; 3]| [(start + i) % nx, j + (start + i) / nx, k];
        let first = self.first.map(place);
        Self { first, ..self }
    }

    /// Goes on with what comes after.
    pub(crate) fn add(&mut self, more: Self) {
        self.count += more.count;
        self.first = self.first.or(more.first);
    }
}
