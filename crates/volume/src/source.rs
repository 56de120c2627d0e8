//! Samples that are made where they are asked for, in any order, and what is known of boxes of them beforehand.

use crate::{Grid, Sample, View};
use isokit_lanes::Extent;
use std::ops::Range;

/// A box of lattice points, along x, y, z.
pub type Points = [Range<usize>; 3];

/// Samples on a lattice that need not be in memory.
///
/// Whoever asks twice for a sample is told the same.
pub trait SampleSource<T: Sample>: Sync {
    /// The lattice.
    fn grid(&self) -> Grid;

    /// No sample in a box that is not empty is below the least of these or above the greatest, and none is NaN unless it is said
    /// here. Both ends may be farther off than need be. Default: nothing is known.
    fn extent(&self, _points: &Points) -> Option<Extent<T>> {
        None
    }

    /// The same samples for whoever asks within a box only, where that is cheaper to ask: all answers there are the same.
    /// Default: there are none that are cheaper.
    fn within(&self, _points: &Points) -> Option<Box<dyn SampleSource<T> + '_>> {
        None
    }

    /// Writes the samples of a box, x fastest.
    ///
    /// # Panics
    ///
    /// If there are more or fewer samples than points, or if one of these is not in the lattice.
    fn fill(&self, points: &Points, samples: &mut [T]);
}

/// Samples that are in memory, of which nothing else is known.
impl<T: Sample> SampleSource<T> for View<'_, T> {
    fn grid(&self) -> Grid {
        View::grid(self)
    }

    fn fill(&self, [x, y, z]: &Points, samples: &mut [T]) {
        assert_eq!(samples.len(), x.len() * y.len() * z.len(), "one for each point");
        let rows = z.clone().flat_map(|k| y.clone().map(move |j| (j, k)));
        for (row, (j, k)) in samples.chunks_exact_mut(x.len().max(1)).zip(rows) {
            row.copy_from_slice(self.row(j, k).part(x.clone()).gather(&mut vec![]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::SampleSource;
    use crate::{Grid, View};

    #[test]
    fn a_view_gives_the_samples_of_a_box_however_they_lie() {
        let samples: Vec<u8> = (0..24).collect();
        let grid = |dims| Grid::new(dims, Default::default()).unwrap();
        let plain = View::new(&samples, &grid([2, 3, 4])).unwrap();
        let turned = View::strided(&samples, 0, [6, 2, 1], &grid([4, 3, 2])).unwrap();
        let mut found = [0; 4];
        plain.fill(&[0..2, 1..2, 2..4], &mut found);
        assert_eq!(found, [14, 15, 20, 21]);
        turned.fill(&[2..4, 1..2, 0..2], &mut found);
        assert_eq!(found, [14, 20, 15, 21]);
        assert!(plain.extent(&[0..1, 0..1, 0..1]).is_none());
    }
}
