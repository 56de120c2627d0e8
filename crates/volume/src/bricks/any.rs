//! Bricks of samples whose type is known only at run time.

use super::Bricks;
use crate::Sample;
use std::{any::Any, sync::Arc};

/// [`Bricks`] of any of the eight types.
#[derive(Clone, Debug)]
pub struct AnyBricks {
    count: u64,
    bricks: Arc<dyn Any + Send + Sync>,
}

impl<T: Sample> From<Bricks<T>> for AnyBricks {
    fn from(bricks: Bricks<T>) -> Self {
        Self { count: bricks.extents().len() as u64, bricks: Arc::new(bricks) }
    }
}

impl AnyBricks {
    /// The bricks, if their samples are of type `T`.
    pub fn of<T: Sample>(&self) -> Option<&Bricks<T>> {
        self.bricks.downcast_ref()
    }

    /// How many bricks there are.
    pub fn count(&self) -> u64 {
        self.count
    }
}
