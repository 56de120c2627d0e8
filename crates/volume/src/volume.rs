//! Samples that own their memory.

use crate::{Grid, Sample, Scaling, View};

/// A lattice of samples, x fastest, without gaps.
///
/// # Guarantees
///
/// There is exactly one sample per lattice point.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume<T> {
    grid: Grid,
    scaling: Scaling,
    samples: Vec<T>,
}

/// Samples and lattice do not fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{held} samples for a lattice of {needed}")]
pub struct VolumeError {
    /// How many samples there are.
    pub held: usize,
    /// How many the lattice has.
    pub needed: u64,
}

impl<T: Sample> Volume<T> {
    /// `samples` on `grid`, each meaning itself.
    ///
    /// # Errors
    ///
    /// If the number of samples is not the lattice's.
    pub fn new(grid: Grid, samples: Vec<T>) -> Result<Self, VolumeError> {
        if samples.len() as u64 == grid.count() {
            Ok(Self { grid, scaling: Scaling::IDENTITY, samples })
        } else {
            Err(VolumeError { held: samples.len(), needed: grid.count() })
        }
    }

    /// The same samples with another meaning.
    pub fn with_scaling(self, scaling: Scaling) -> Self {
        Self { scaling, ..self }
    }

    /// The lattice.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// What a stored sample means.
    pub fn scaling(&self) -> Scaling {
        self.scaling
    }

    /// The stored samples, x fastest.
    pub fn samples(&self) -> &[T] {
        &self.samples
    }

    /// The stored samples alone.
    pub fn into_samples(self) -> Vec<T> {
        self.samples
    }

    /// All of it, borrowed.
    pub fn view(&self) -> View<'_, T> {
        let view = View::new(&self.samples, &self.grid).expect("one sample per lattice point");
        view.with_scaling(self.scaling)
    }

    /// Moves the lattice in the world; the samples stay.
    pub fn set_frame(&mut self, frame: isokit_geom::Frame) {
        self.grid.frame = frame;
    }
}
