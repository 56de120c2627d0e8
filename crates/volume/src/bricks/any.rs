//! Bricks of samples whose type is known only at run time.

use super::{BrickGrid, Bricks};
use crate::Sample;
use std::{any::Any, sync::Arc};

/// [`Bricks`] of any of the eight types.
#[derive(Clone, Debug)]
pub struct AnyBricks {
    grid: BrickGrid,
    bricks: Arc<dyn Any + Send + Sync>,
}

impl<T: Sample> From<Bricks<T>> for AnyBricks {
    fn from(bricks: Bricks<T>) -> Self {
        Self { grid: *bricks.grid(), bricks: Arc::new(bricks) }
    }
}

impl AnyBricks {
    /// The bricks, if their samples are of type `T`.
    pub fn of<T: Sample>(&self) -> Option<&Bricks<T>> {
        self.bricks.downcast_ref()
    }

    /// Where they are.
    pub fn grid(&self) -> &BrickGrid {
        &self.grid
    }
}
