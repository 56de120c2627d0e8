//! What is between samples, where that is cubic.

use super::march::{March, Places};
use isokit_lanes::{Between, Facing, Found, Table};
use isokit_volume::Sample;

impl<T: Sample> March<'_, T> {
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
        if !self.field.is_cubic() {
            return between.look(places, wanted, table, facing, found);
        }
        let mut left = between.look_cubic(places, wanted, table, facing, found);
        while left != 0 {
            let n = left.trailing_zeros() as usize;
            left &= left - 1;
            let value = self.field.at_index(ways[n].at(places.1[n])) as f32;
            found.put(n, value, table, facing.is_some());
        }
    }
}
