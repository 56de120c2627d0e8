//! Lines that lead over the border, and are continued there.
//!
//! The missing samples are those of the polynomial through the nearest ones, as many as the stencil has: one after
//! another, each by those behind it, as `line.rs` of `volume` does it for one line, with the same bits. So all samples
//! of such a line are loaded from farther in, and values change their places.

use super::MOST;
use crate::wide::{BATCH, Mask, Wide};

/// The most values that one is continued from: `volume` has stencils of so many, here six are the most.
const MOST_HELD: usize = 7;

/// For each number of values the factors of all of them in the value before the first: the difference of as high
/// an order as there are values is 0.
pub const ONE_BEFORE: [[f64; MOST_HELD]; MOST_HELD + 1] = {
    let mut factors = [[0.0; MOST_HELD]; MOST_HELD + 1];
    let mut held = 1;
    while held <= MOST_HELD {
        let (mut n, mut factor) = (0, -1.0);
        while n < held {
            factor = -factor * (held - n) as f64 / (n + 1) as f64;
            factors[held][n] = factor;
            n += 1;
        }
        held += 1;
    }
    factors
};

/// What the lines of a batch lack: a sample before the first that the lattice has, or behind the last, and then one
/// more.
pub(super) struct Lacking<W: Wide> {
    before: [W::Mask; 2],
    behind: [W::Mask; 2],
    /// Which lack any.
    pub(super) any: u16,
}

impl<W: Wide> Lacking<W> {
    /// For stencils of so many pairs, of the `usable` lines, which have as many samples or more. Given are the places
    /// of the lower ends on their lines, and how many samples there are.
    #[inline(always)]
    pub(super) fn new(wide: W, pairs: u32, usable: W::Mask, along: W::U32, size: W::U32) -> Self {
        let none = wide.mask(0);
        let (mut before, mut behind, mut any) = ([none; 2], [none; 2], none);
        for n in 0..pairs - 1 {
            let is_before = usable & wide.less(along, wide.u32(pairs - 1 - n));
            let last = size + wide.u32(n.wrapping_sub(1));
            let is_behind = usable & wide.less(last, along + wide.u32(pairs));
            (before[n as usize], behind[n as usize]) = (is_before, is_behind);
            any = any | is_before | is_behind;
        }
        Self { before, behind, any: any.bits() }
    }

    /// Numbers moved by so much for every sample that is lacking, into the lattice.
    #[inline(always)]
    pub(super) fn moved(&self, wide: W, mut numbers: W::U32, step: W::U32) -> W::U32 {
        let (none, back) = (wide.u32(0), step * wide.u32(u32::MAX));
        for n in 0..2 {
            numbers = numbers + wide.select(self.before[n], step, none);
            numbers = numbers + wide.select(self.behind[n], back, none);
        }
        numbers
    }

    /// Moves values to their places, and puts in what is lacking.
    #[inline(always)]
    pub(super) fn put_in<const HELD: usize>(&self, wide: W, values: &mut [[f64; BATCH]; MOST]) {
        for n in 0..HELD / 2 - 1 {
            if self.before[n].bits() != 0 {
                continued::<W, HELD>(wide, self.before[n], values);
            }
            if self.behind[n].bits() != 0 {
                values[..HELD].reverse();
                continued::<W, HELD>(wide, self.behind[n], values);
                values[..HELD].reverse();
            }
        }
    }
}

/// Where chosen, puts a value before the others, of which the last is dropped.
#[inline(always)]
fn continued<W: Wide, const HELD: usize>(
    wide: W,
    chosen: W::Mask,
    values: &mut [[f64; BATCH]; MOST],
) {
    let mut before = wide.f64(0.0);
    for n in 0..HELD {
        before = before + wide.f64(ONE_BEFORE[HELD][n]) * wide.load_f64(&values[n]);
    }
    for value in &mut values[..HELD] {
        let own = wide.load_f64(value);
        wide.store_f64(wide.select_f64(chosen, before, own), value);
        before = own;
    }
}
