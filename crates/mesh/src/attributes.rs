//! What vertices carry besides place and normal.

use crate::Rgba;

/// A number and a colour for each vertex, or neither.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attributes {
    /// A number per vertex, such as the value of another volume there; NaN where there is none.
    pub values: Option<Vec<f32>>,
    /// A colour per vertex. It stands in place of the colour of the surface.
    pub colors: Option<Vec<Rgba>>,
}

impl Attributes {
    /// Whether there are none of either kind.
    pub fn is_empty(&self) -> bool {
        self.values.is_none() && self.colors.is_none()
    }

    /// Those of some vertices, by number.
    ///
    /// # Panics
    ///
    /// If there is no such vertex.
    pub fn pick(&self, vertices: &[u32]) -> Self {
        Self { values: picked(&self.values, vertices), colors: picked(&self.colors, vertices) }
    }
}

fn picked<T: Copy>(all: &Option<Vec<T>>, vertices: &[u32]) -> Option<Vec<T>> {
    all.as_ref().map(|all| vertices.iter().map(|&vertex| all[vertex as usize]).collect())
}
