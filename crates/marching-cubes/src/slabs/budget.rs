//! How high the window is, for so much memory.

use crate::{Boundary, ExtractOptions, Nan, Topology, trilinear::SpecialCells};
use isokit_job::OverLimit;
use isokit_lanes::words;
use isokit_volume::{Dtype, Grid};

/// How much of a volume and of its surfaces is in memory at a time. Changes time and memory only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Slices, at least [`least_window`](crate::Placement::least_window) or as many as there are.
    pub window: usize,
    /// Bytes of the surface that a sink is asked for at a time. A slice that makes more is an error.
    pub piece_bytes: u64,
}

/// A window is not made higher for these bytes of samples and more: it gains nothing.
const ENOUGH: u64 = 64 << 20;

/// Nor for these slices and more, whose overlap with the next window is a few hundredths.
const ENOUGH_SLICES: u64 = 64;

/// The least that is reserved for a piece.
const LEAST_PIECE: u64 = 1 << 20;

impl Budget {
    /// A budget of so many bytes for all that [`extract_slabs`](crate::extract_slabs) and the sinks take
    /// together for so many surfaces, where each of their sinks takes `pieces` times the bytes of a piece.
    /// Half of it is for the window, or less where that is enough.
    ///
    /// # Errors
    ///
    /// If it does not suffice for the least window. What is needed then suffices.
    pub fn within(
        bytes: u64,
        (grid, dtype): (&Grid, Dtype),
        (surfaces, pieces): (u64, u64),
        options: &ExtractOptions,
    ) -> Result<Self, OverLimit> {
        let (surfaces, pieces) = (surfaces.max(1), surfaces.saturating_mul(pieces).max(1));
        let per_slice = bytes_per_slice(grid, dtype, surfaces, options);
        // A volume may have fewer.
        let fewest = grid.dims()[2].min(options.placement.least_window() as u64);
        let least = per_slice.map(|bytes| bytes.saturating_mul(fewest));
        let needed = least.and_then(|least| least.checked_add(pieces.saturating_mul(LEAST_PIECE)));
        let (Some(per_slice), Some(0..)) = (per_slice, needed.and_then(|n| bytes.checked_sub(n)))
        else {
            let needed = needed.unwrap_or(u64::MAX);
            return Err(OverLimit { what: "extraction slice by slice", needed, limit: bytes });
        };
        let most = (bytes / 2 / per_slice).max(fewest);
        let most = most.min((ENOUGH / per_slice).max(ENOUGH_SLICES));
        let window = most.min((bytes - pieces * LEAST_PIECE) / per_slice);
        let piece_bytes = (bytes - window * per_slice) / pieces;
        Ok(Self { window: window as usize, piece_bytes })
    }
}

/// What a slice of the window takes: its samples, and while surfaces are made a bit of each for every one of
/// them (and two more where cells next to NaN are left out), what its rows make, and, where values decide
/// what is connected, its cells, which may all be special.
fn bytes_per_slice(
    grid: &Grid,
    dtype: Dtype,
    surfaces: u64,
    options: &ExtractOptions,
) -> Option<u64> {
    let guards = if options.boundary == Boundary::Closed { 2 } else { 0 };
    let [nx, ny, _] = grid.dims();
    let samples = nx.checked_mul(ny)?.checked_mul(dtype.bytes() as u64)?;
    let may_miss = options.nan == Nan::Mask && !dtype.is_integer();
    let planes = surfaces.checked_add(if may_miss { 2 } else { 0 })?;
    let words = words(usize::try_from(nx.checked_add(guards)?).ok()?) as u64;
    let rows = ny.checked_add(guards)?;
    let special = match options.topology {
        Topology::Table => 0,
        Topology::Trilinear => nx.checked_add(guards)?.checked_mul(SpecialCells::BYTES as u64)?,
    };
    let row = words.checked_mul(8)?.checked_mul(planes)?.checked_add(16)?.checked_add(special)?;
    samples.checked_add(rows.checked_mul(row)?)
}

#[cfg(test)]
mod tests {
    use super::{Budget, bytes_per_slice};
    use crate::{ExtractOptions, Placement, Topology};
    use isokit_volume::{Dtype, Grid};

    #[test]
    fn what_a_refusal_says_is_needed_suffices_and_no_less() {
        for (dims, pieces, placement) in [
            ([1024, 1024, 2048], (1, 1), Placement::Linear),
            ([3, 5, 7], (2, 3), Placement::Cubic),
            ([1 << 20, 900, 9], (3, 1), Placement::Quintic),
            ([4096, 2048, 1], (1, 2), Placement::Linear),
        ] {
            let options = &ExtractOptions::DEFAULT.with_placement(placement);
            let grid = Grid::new(dims, Default::default()).unwrap();
            let within = |bytes| Budget::within(bytes, (&grid, Dtype::I16), pieces, options);
            let needed = within(0).unwrap_err().needed;
            let fewest = placement.least_window().min(dims[2] as usize);
            assert_eq!(within(needed).unwrap().window, fewest);
            assert_eq!(within(needed - 1).unwrap_err().needed, needed);
        }
    }

    #[test]
    fn window_and_pieces_stay_within_the_budget() {
        let grid = Grid::new([700, 500, 300], Default::default()).unwrap();
        for (topology, placement, least) in [
            (Topology::Table, Placement::Linear, 10),
            (Topology::Trilinear, Placement::Linear, 40),
            (Topology::Trilinear, Placement::Quintic, 110),
        ] {
            let options = ExtractOptions::DEFAULT.with_placement(placement);
            let options = &options.with_topology(topology);
            let per_slice = bytes_per_slice(&grid, Dtype::F32, 2, options).unwrap();
            for bytes in (least..1000).map(|n| n << 20) {
                let budget = Budget::within(bytes, (&grid, Dtype::F32), (2, 1), options).unwrap();
                let window = budget.window as u64 * per_slice;
                assert!(
                    budget.window >= options.placement.least_window()
                        && window + 2 * budget.piece_bytes <= bytes
                );
            }
        }
    }

    #[test]
    fn a_slice_whose_cells_may_all_be_special_takes_more() {
        let grid = Grid::new([62, 30, 9], Default::default()).unwrap();
        let of = |topology| {
            let options = ExtractOptions::DEFAULT.with_topology(topology);
            bytes_per_slice(&grid, Dtype::U8, 1, &options).unwrap()
        };
        assert_eq!(of(Topology::Trilinear) - of(Topology::Table), 64 * 32 * 12);
    }

    #[test]
    fn a_slice_that_no_memory_holds_is_refused() {
        let grid = Grid::new([1 << 40, 1 << 23, 1], Default::default()).unwrap();
        let found = Budget::within(1 << 40, (&grid, Dtype::F64), (1, 1), &ExtractOptions::DEFAULT);
        assert_eq!(found.unwrap_err().needed, u64::MAX);
    }
}
