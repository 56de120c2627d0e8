//! What is between samples, at sixteen places at a time: values, looked up in a table, and how gradients face.
//!
//! A value is that of trilinear interpolation: along x, then y, then z. A gradient is made of central differences
//! at samples, interpolated alike. Samples are rounded to f32, and all that follows is f32.
//!
//! There is one text for all levels, and no fused multiply-add, so the bits are the same. Where a cell is at the
//! border, or samples are so many that their numbers need more than 31 bits, places are looked at one by one.

mod cubic;
mod found;

use crate::{
    Lane, Level, Samples,
    wide::{BATCH, Exact, Float, Mask, Task, Wide},
};
pub(crate) use cubic::Look as CubicLook;
pub use found::{BENT, Facing, Found, SEEN, Table};

/// Straight lines that are followed at a time.
pub const LINES: usize = BATCH;

/// Straight lines in index space: of each where it begins, and how far one step leads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Lines {
    /// Along x, y, z.
    pub start: [[f64; LINES]; 3],
    /// Along x, y, z.
    pub step: [[f64; LINES]; 3],
}

/// What is between the samples of a lattice that has two along each axis, or more.
#[derive(Clone, Copy, Debug)]
pub struct Between<'a, T> {
    samples: Samples<'a, T>,
}

impl<'a, T: Lane> Between<'a, T> {
    /// Between those samples. `None` where there is only one along an axis.
    pub fn new(samples: Samples<'a, T>) -> Option<Self> {
        let has_cells = samples.dims().iter().all(|&n| n > 1);
        has_cells.then_some(Self { samples })
    }

    /// What is found after so many steps on each line whose bit in `wanted` is set; of the others anything, but that
    /// nothing of them is seen. Cosines are found where the table shows something, if it is said what is faced.
    ///
    /// A place beyond the lattice is taken for the nearest in it; one that is NaN for any.
    ///
    /// # Panics
    ///
    /// If the table has no part, or 2²⁴ or more.
    #[inline]
    pub fn look(
        &self,
        (lines, steps): (&Lines, &[f64; LINES]),
        wanted: u16,
        table: &Table<'_>,
        facing: Option<&Facing>,
        found: &mut Found,
    ) {
        self.look_at(Level::current(), (lines, steps), wanted, table, facing, found);
    }

    fn look_at(
        &self,
        level: Level,
        (lines, steps): (&Lines, &[f64; LINES]),
        wanted: u16,
        table: &Table<'_>,
        facing: Option<&Facing>,
        found: &mut Found,
    ) {
        table.check();
        T::look(level, Look { between: *self, lines, steps, wanted, table, facing, found });
    }

    /// The cells of places, and how far in it each place is, from 0 to 1.
    #[inline(always)]
    fn cells<W: Wide>(&self, wide: W, lines: &Lines, steps: &[f64; LINES]) -> Cells<W> {
        let (zero, steps) = (wide.f64(0.0), wide.load_f64(steps));
        let mut cells = Cells { low: [wide.u32(0); 3], part: [wide.f32(0.0); 3] };
        for k in 0..3 {
            let last = f64::from(self.samples.dims()[k] - 1);
            let place = wide.load_f64(&lines.start[k]) + steps * wide.load_f64(&lines.step[k]);
            let place = place.max(zero).min(wide.f64(last));
            cells.low[k] = wide.truncate(place.min(wide.f64(last - 1.0)));
            cells.part[k] = wide.f64_to_f32(place - wide.i32_to_f64(cells.low[k]));
        }
        cells
    }

    /// The bits of cells that have so many cells before and after them along x, y, z, if numbers of samples fit.
    #[inline(always)]
    fn inner<W: Wide>(&self, wide: W, cells: &Cells<W>, margins: [u32; 3]) -> u16 {
        let dims = self.samples.dims();
        if !self.samples.is_near(i64::from(dims[2])) {
            return 0;
        }
        let mut are_inner = wide.mask(u16::MAX);
        for ((low, n), margin) in cells.low.into_iter().zip(dims).zip(margins) {
            // Cells before the first inner one wrap, and are beyond all of them.
            let inner = wide.u32(n.saturating_sub(1 + 2 * margin));
            are_inner = are_inner & wide.less(low + wide.u32(margin.wrapping_neg()), inner);
        }
        are_inner.bits()
    }

    /// The numbers, from the first sample, of the lowest corners of cells. Where a bit is not set, that of another
    /// whose bit is.
    #[inline(always)]
    fn numbers<W: Wide>(&self, wide: W, cells: &Cells<W>, bits: u16) -> W::U32 {
        let strides = self.samples.strides();
        let [x, y, z] = cells.low;
        let x_y = x * wide.u32(strides[0] as u32) + y * wide.u32(strides[1] as u32);
        let own = x_y + z * wide.u32(strides[2] as u32);
        if bits == u16::MAX {
            return own;
        }
        let kept = wide.u32(wide.store(own)[bits.trailing_zeros() as usize & (BATCH - 1)]);
        wide.select(wide.mask(bits), own, kept)
    }

    /// The value in a cell, of any.
    fn value(&self, low: [u32; 3], [x, y, z]: [f32; 3]) -> f32 {
        let strides = self.samples.strides();
        let along = |k: usize, n: u32| i64::from(low[k] + n) * strides[k];
        let corner = |i: u32, j: u32, k: u32| -> f32 {
            let number = self.samples.first() + along(0, i) + along(1, j) + along(2, k);
            let exact: f64 = self.samples.all()[number as usize].exact().into();
            exact as f32
        };
        let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
        let edge = |j: u32, k: u32| mix(corner(0, j, k), corner(1, j, k), x);
        mix(mix(edge(0, 0), edge(1, 0), y), mix(edge(0, 1), edge(1, 1), y), z)
    }
}

/// The cells of places.
#[derive(Clone, Copy)]
struct Cells<W: Wide> {
    low: [W::U32; 3],
    part: [W::F32; 3],
}

/// Part of the way from one number to another.
#[inline(always)]
fn mix<F: Float>(a: F, b: F, share: F) -> F {
    a + (b - a) * share
}

/// The rows of samples through the four edges of cells along x: those before the cell, at its corners, and after it.
type Rows<W> = [[<W as Wide>::F32; 4]; 4];

pub struct Look<'b, 'a, T> {
    between: Between<'a, T>,
    lines: &'b Lines,
    steps: &'b [f64; LINES],
    wanted: u16,
    table: &'b Table<'b>,
    facing: Option<&'b Facing>,
    found: &'b mut Found,
}

impl<T: Lane> Task for Look<'_, '_, T> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Self { between, lines, steps, wanted, table, facing, found } = self;
        let cells = between.cells(wide, lines, steps);
        let inner = between.inner(wide, &cells, [1; 3]);
        let is_any_inner = inner & wanted != 0;
        let numbers = between.numbers(wide, &cells, inner);
        let mut rows = [[wide.f32(0.0); 4]; 4];
        if is_any_inner {
            // SAFETY: the cells of these numbers are inner ones, and samples are near, asked there.
            rows = unsafe { between.rows(wide, numbers, facing.is_some()) };
        }
        let [x, y, z] = cells.part;
        // No closures, which are not always inlined into the function that a level's instructions are enabled for.
        let mut edges = [x; 4];
        for (edge, row) in edges.iter_mut().zip(&rows) {
            *edge = mix(row[1], row[2], x);
        }
        let mut stored = mix(mix(edges[0], edges[1], y), mix(edges[2], edges[3], y), z);
        let others = wanted & !inner;
        if others != 0 {
            stored = between.put_in(wide, &cells, others, stored);
        }
        found.look_up(wide, table, stored, wanted);
        let Some(facing) = facing else { return };
        found.odd = found.seen;
        if is_any_inner && found.seen & inner != 0 {
            // SAFETY: as above.
            let gradient = unsafe { between.gradient(wide, numbers, &rows, edges, cells.part) };
            let is_tame = found.face(wide, facing, gradient);
            found.odd = found.seen & !(inner & is_tame);
        }
    }
}

impl<T: Lane> Between<'_, T> {
    /// The samples around cells, along x; without those before and after them, unless they are wanted.
    ///
    /// # Safety
    ///
    /// All cells must have cells on all sides, and [`Samples::is_near`] must hold for all slices.
    #[inline(always)]
    unsafe fn rows<W: Wide>(&self, wide: W, numbers: W::U32, with_outer: bool) -> Rows<W> {
        let (samples, first) = (&self.samples, self.samples.first());
        let [to_x, to_y, to_z] = samples.strides();
        let mut rows = [[wide.f32(0.0); 4]; 4];
        // SAFETY: all corners, and the samples before and after them in a row, are samples with both neighbours along
        // two axes or more.
        unsafe {
            if with_outer {
                let first = first - to_x;
                let from = [first, first + to_y, first + to_z, first + to_y + to_z];
                let found = wide.four_along_x(samples, from, numbers);
                for (row, four) in rows.iter_mut().zip(found) {
                    for (to, samples) in row.iter_mut().zip(four) {
                        *to = T::Exact::to_f32(wide, samples);
                    }
                }
            } else {
                let from = [first, first + to_y, first + to_z, first + to_y + to_z];
                let found = wide.two_along_x(samples, from, numbers);
                for (row, [low, high]) in rows.iter_mut().zip(found) {
                    row[1] = T::Exact::to_f32(wide, low);
                    row[2] = T::Exact::to_f32(wide, high);
                }
            }
        }
        rows
    }

    /// The gradients in cells.
    ///
    /// # Safety
    ///
    /// As of [`rows`](Self::rows).
    #[inline(always)]
    unsafe fn gradient<W: Wide>(
        &self,
        wide: W,
        numbers: W::U32,
        rows: &Rows<W>,
        [a, b, c, d]: [W::F32; 4],
        [x, y, z]: [W::F32; 3],
    ) -> [W::F32; 3] {
        let (samples, first) = (&self.samples, self.samples.first());
        let [_, to_y, to_z] = samples.strides();
        // Rows beside the cell, each before and after it: two along y, two along z.
        let from = [
            first - to_y,
            first + 2 * to_y,
            first + to_z - to_y,
            first + to_z + 2 * to_y,
            first - to_z,
            first + 2 * to_z,
            first + to_y - to_z,
            first + to_y + 2 * to_z,
        ];
        // SAFETY: they are neighbours of corners, and have both neighbours along the two axes on which they are not
        // beside the cell.
        let found = unsafe { wide.two_along_x(samples, from, numbers) };
        let mut outer = [x; 8];
        for (outer, [low, high]) in outer.iter_mut().zip(found) {
            *outer = mix(T::Exact::to_f32(wide, low), T::Exact::to_f32(wide, high), x);
        }
        let mut along = [a; 4];
        for (along, [before, low, high, after]) in along.iter_mut().zip(rows) {
            *along = mix(*high - *before, *after - *low, x);
        }
        let along_x = mix(mix(along[0], along[1], y), mix(along[2], along[3], y), z);
        let low = mix(b - outer[0], outer[1] - a, y);
        let high = mix(d - outer[2], outer[3] - c, y);
        let along_y = mix(low, high, z);
        let low = mix(c - outer[4], outer[5] - a, z);
        let high = mix(d - outer[6], outer[7] - b, z);
        [along_x, along_y, mix(low, high, y)]
    }

    /// Puts in what is stored in some cells, one by one.
    #[inline(always)]
    fn put_in<W: Wide>(&self, wide: W, cells: &Cells<W>, bits: u16, stored: W::F32) -> W::F32 {
        let [x, y, z] = cells.low;
        let low = [wide.store(x), wide.store(y), wide.store(z)];
        let (mut part, mut all) = ([[0.0; BATCH]; 3], [0.0; BATCH]);
        for (to, numbers) in part.iter_mut().zip(cells.part) {
            wide.store_f32(numbers, to);
        }
        wide.store_f32(stored, &mut all);
        let mut left = bits;
        while left != 0 {
            let n = left.trailing_zeros() as usize;
            left &= left - 1;
            let cell = [low[0][n], low[1][n], low[2][n]];
            all[n] = self.value(cell, [part[0][n], part[1][n], part[2][n]]);
        }
        wide.load_f32(&all)
    }
}

#[cfg(test)]
mod tests;
