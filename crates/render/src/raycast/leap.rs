//! Bricks of which nothing can be seen.

use crate::{transfer::Lookup, trilinear::Scale};
use isokit_lanes::Extent;
use isokit_volume::{BrickGrid, Bricks, Sample, Scaling};

/// For each brick how far around it nothing can be seen.
#[derive(Clone, Debug)]
pub(super) struct Clear {
    grid: BrickGrid,
    /// In bricks along each axis, and diagonally: 0 if something in the brick itself can be seen, 1 if nothing in it can,
    /// 2 if nothing in those that touch it can either, and so on. What is beyond the volume cannot be seen.
    reach: Vec<u8>,
}

impl Clear {
    /// A value between samples is between their least and greatest, but for the rounding of three
    /// interpolations, one after another; so a brick is clear if the lookup shows nothing from there to there.
    pub(super) fn new<T: Sample>(
        bricks: &Bricks<T>,
        scaling: Scaling,
        lookup: &Lookup<'_>,
    ) -> Self {
        let scale = Scale::of(scaling);
        let is_clear = |extent: &Extent<T>| {
            let Some(range) = extent.range() else { return true }; // all samples are NaN
            let [least, greatest] = range.map(|end| end.to_f64() as f32);
            let slack = 8.0 * f32::EPSILON * least.abs().max(greatest.abs());
            let [a, b] = [least - slack, greatest + slack].map(|stored| scale.value(stored));
            lookup.is_clear([a.min(b), a.max(b)])
        };
        let far = |extent: &Extent<T>| if is_clear(extent) { u8::MAX } else { 0 };
        let reach = bricks.extents().iter().map(far).collect();
        let mut clear = Self { grid: *bricks.grid(), reach };
        clear.spread();
        clear
    }

    /// The box, in index space, of bricks around a cell in which all is like in its own; and whether that means that
    /// nothing in it can be seen.
    #[inline(always)]
    pub(super) fn around(&self, cell: [usize; 3]) -> ([[f64; 2]; 3], bool) {
        let brick: [usize; 3] = std::array::from_fn(|axis| self.grid.brick_of(axis, cell[axis]));
        let reach = usize::from(self.reach[self.grid.number(brick)]);
        let ends = |axis: usize| {
            let cells = BrickGrid::CELLS[axis];
            let more = reach.saturating_sub(1);
            let low = brick[axis].saturating_sub(more) * cells;
            let high = ((brick[axis] + more + 1) * cells).min(self.grid.dims()[axis] - 1);
            [low as f64, high as f64]
        };
        ([ends(0), ends(1), ends(2)], reach > 0)
    }

    /// From bricks that can be seen to the others: a brick's reach is one more than the least around it (Rosenfeld &
    /// Pfaltz 1966, "Sequential operations in digital picture processing": once forward, once backward).
    fn spread(&mut self) {
        let [nx, ny, nz] = self.grid.counts();
        let all = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        let all: Vec<[usize; 3]> = all.collect();
        let before = |n: usize| [n % 3, n / 3 % 3, n / 9].map(|offset| offset as isize - 1);
        for is_back in [false, true] {
            let mut visit = |brick: [usize; 3]| {
                let around = (0..13).map(before).filter_map(|offset| {
                    let moved = |k: usize| {
                        let offset = if is_back { -offset[k] } else { offset[k] };
                        let there = brick[k].checked_add_signed(offset)?;
                        (there < [nx, ny, nz][k]).then_some(there)
                    };
                    Some(self.reach[self.grid.number([moved(0)?, moved(1)?, moved(2)?])])
                });
                let least = around.min().unwrap_or(u8::MAX).saturating_add(1);
                let number = self.grid.number(brick);
                self.reach[number] = self.reach[number].min(least);
            };
            match is_back {
                false => all.iter().copied().for_each(&mut visit),
                true => all.iter().rev().copied().for_each(&mut visit),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Clear;
    use isokit_volume::BrickGrid;

    #[test]
    fn the_reach_is_how_far_the_next_brick_is_that_can_be_seen() {
        let grid = BrickGrid::new([300, 70, 60]);
        let [nx, ny, nz] = grid.counts();
        let mut state = 1_u64;
        for share in [0, 1, 20] {
            let seen: Vec<bool> = (0..nx * ny * nz)
                .map(|_| {
                    state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
                    (state >> 40) % 300 < share
                })
                .collect();
            let reach = seen.iter().map(|&seen| if seen { 0 } else { u8::MAX }).collect();
            let mut clear = Clear { grid, reach };
            clear.spread();
            let place = |n: usize| [n % nx, n / nx % ny, n / nx / ny];
            for n in 0..seen.len() {
                let away = |m: usize| {
                    let (a, b) = (place(n), place(m));
                    (0..3).map(|k| a[k].abs_diff(b[k])).max().unwrap()
                };
                let nearest = (0..seen.len()).filter(|&m| seen[m]).map(away).min();
                let expected = nearest.map_or(u8::MAX, |away| away as u8);
                assert_eq!(clear.reach[n], expected, "{:?}", place(n));
            }
        }
    }
}
