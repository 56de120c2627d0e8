//! What is between samples, where that is cubic.

use super::march::{March, Places};
use isokit_field::ScalarField;
use isokit_geom::vector::Vector;
use isokit_lanes::{Between, Facing, Found, Table};
use isokit_volume::Sample;

impl<T: Sample> March<'_, T> {
    /// The value at a place in index space; NaN if there is none.
    pub(super) fn value(&self, place: [f64; 3]) -> f64 {
        let cubic = self.cubic.map(|field| field.value(place));
        cubic.filter(|value| value.is_finite()).unwrap_or_else(|| self.field.at_index(place))
    }

    /// The gradient in the world at a place in index space.
    pub(super) fn gradient(&self, place: [f64; 3]) -> Vector {
        let cubic = self.cubic.map(|field| field.slope(place).gradient);
        match cubic.filter(|gradient| gradient.iter().all(|part| part.is_finite())) {
            Some(gradient) => self.field.in_world(gradient),
            None => self.field.gradient(place),
        }
    }

    /// What is between samples, after so many steps, on each line whose bit in `wanted` is set.
    #[inline(always)]
    pub(super) fn look(
        &self,
        (between, table): (&Between<'_, T>, &Table<'_>),
        (ways, places): Places<'_>,
        wanted: u16,
        facing: Option<&Facing>,
        found: &mut Found,
    ) {
        if self.cubic.is_none() {
            return between.look(places, wanted, table, facing, found);
        }
        let mut left = between.look_cubic(places, wanted, table, facing, found);
        while left != 0 {
            let n = left.trailing_zeros() as usize;
            left &= left - 1;
            let value = self.value(ways[n].at(places.1[n])) as f32;
            found.put(n, value, table, facing.is_some());
        }
    }
}
