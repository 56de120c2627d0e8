//! One cell: its values, and what they decide.

use super::{
    decide::{Interior, Saddle, around},
    number::{Unit, ask},
    table::{AMBIGUOUS, Resolved, resolved},
};
use isokit_geom::cube::{Corner, Face};
use isokit_lanes::{Samples, Word};
use isokit_volume::{Sample, View};
use std::cmp::Ordering;

/// The values of samples less the isovalue.
///
/// Each is rounded once, so that all cells around a sample see the same number, whose sign is right. An
/// isovalue so great that a difference could overflow has all differences quartered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Values<'a, T> {
    view: View<'a, T>,
    iso: f64,
    scale: f64,
    guard: usize,
    unit: Unit,
    /// What is asked for before it is read, where no cache may hold it.
    expected: Option<Samples<'a, T>>,
}

impl<'a, T: Sample> Values<'a, T> {
    /// `guard` is the lattice index of the first sample.
    pub(crate) fn new(view: View<'a, T>, iso: f64, guard: usize) -> Self {
        // Half a step of the greatest f64: less than that makes no difference overflow.
        let greatest = 970.0_f64.exp2();
        let scale = if iso.abs() < greatest { 1.0 } else { 0.25 };
        let unit = Unit::of(&view, iso);
        Self { view, iso, scale, guard, unit, expected: view.samples() }
    }

    /// The same, of samples that are in the cache.
    pub(crate) fn at_hand(self) -> Self {
        Self { expected: None, ..self }
    }

    /// Says that the cells in some words of slice `z` will soon be asked for.
    pub(super) fn expect(&self, z: usize, words: &[Word]) {
        if let Some(samples) = &self.expected {
            for (y, z) in [(0, z), (1, z), (0, z + 1), (1, z + 1)] {
                samples.prefetch([0, y, z].map(|n| self.sample(n)), words, |word| word.active);
            }
        }
    }

    /// The number of the sample at a lattice index. A guard before the first has −1, which wraps.
    pub(super) fn sample(&self, point: usize) -> u32 {
        point.wrapping_sub(self.guard) as u32
    }

    /// The cell whose lowest corner is a point of the lattice.
    #[inline]
    pub(crate) fn cell(&self, code: u8, low: [usize; 3]) -> Cell {
        let dims = self.view.dims();
        let low = low.map(|i| i.wrapping_sub(self.guard));
        let scaling = self.view.scaling();
        let value = |stored: T| scaling.value(stored.to_f64()) * self.scale - self.iso * self.scale;
        if (0..3).all(|axis| low[axis].wrapping_add(1) < dims[axis] && low[axis] < dims[axis]) {
            let values = self.view.cell(low).map(value);
            let known = match self.unit.is_known() {
                true => u8::MAX,
                false => values.iter().rev().fold(0, |all, v| all << 1 | u8::from(v.is_finite())),
            };
            return Cell { code, known, values, unit: self.unit };
        }
        let mut cell = Cell { code, known: 0, values: [0.0; 8], unit: self.unit };
        for (k, corner) in cell.values.iter_mut().enumerate() {
            let ijk: [usize; 3] = std::array::from_fn(|axis| low[axis].wrapping_add(k >> axis & 1));
            if (0..3).all(|axis| ijk[axis] < dims[axis]) {
                *corner = value(self.view.stored(ijk));
                cell.known |= u8::from(corner.is_finite()) << k;
            }
        }
        cell
    }
}

/// The corners of a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Which are inside.
    pub(super) code: u8,
    /// Which have a finite value.
    pub(super) known: u8,
    /// Less the isovalue.
    pub(super) values: [f64; 8],
    /// Of which all values may be whole multiples.
    pub(super) unit: Unit,
}

/// What the values of a cell whose code is not simple decide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Verdict {
    /// The ambiguous faces that join their inside.
    pub(super) joined: u8,
    /// Two corners, of regions that the surface of the cell keeps apart, which its interior joins.
    pub(super) tunnel: Option<[u8; 2]>,
    /// Whether a saddle that decides is exactly on the isovalue.
    pub(super) is_singular: bool,
}

impl Verdict {
    /// Whether the cell has the triangles that its case has.
    pub(super) fn is_plain(self) -> bool {
        self.joined == 0 && self.tunnel.is_none()
    }
}

impl Cell {
    fn is_inside(&self, k: usize) -> bool {
        self.code >> k & 1 == 1
    }

    /// The row of the table for this cell with these faces joined.
    pub(super) fn resolved(&self, joined: u8) -> &'static Resolved {
        resolved(self.code, joined)
    }

    /// What the values decide.
    pub(super) fn verdict(&self) -> Verdict {
        self.verdict_along(2)
    }

    /// The same with slices across a given axis.
    pub(super) fn verdict_along(&self, axis: usize) -> Verdict {
        let short = self.unit.short(self.values);
        let mut verdict = Verdict { joined: 0, tunnel: None, is_singular: false };
        let faces = AMBIGUOUS[usize::from(self.code)];
        let mut rest = faces;
        while rest != 0 {
            let face = rest.trailing_zeros() as u8;
            rest &= rest - 1;
            let saddle = self.saddle(Face::new(face), short);
            verdict.joined |= u8::from(saddle != Ordering::Less) << face;
            verdict.is_singular |= saddle == Ordering::Equal;
        }
        // Two corners of a face, all others on the other side, are joined across it or not at all (`decide.rs`).
        let are_two_of_a_face = faces != 0 && matches!(self.code.count_ones(), 2 | 6);
        // Where some corner has no finite value nothing is joined in the interior.
        if !are_two_of_a_face && self.known == u8::MAX {
            let row = self.resolved(verdict.joined);
            if row.discs.len() > 1 {
                self.look_inside(axis, row, short, &mut verdict);
            }
        }
        verdict
    }

    /// How the value at the saddle of an ambiguous face compares with the isovalue.
    ///
    /// A corner that is outside without a finite value is infinitely low, and keeps the inside apart;
    /// where there is none, one inside that is infinite joins it.
    #[inline(always)]
    fn saddle(&self, face: Face, short: Option<[i64; 8]>) -> Ordering {
        let corners = face.corners().map(Corner::index);
        if self.known != u8::MAX {
            return self.saddle_of_some(corners);
        }
        let of_face = |short: [i64; 8]| corners.map(|k| short[k]);
        let saddle = ask(&Saddle, corners.map(|k| self.values[k]), short.map(of_face));
        // Seen from a corner that is outside, the two diagonals have changed places.
        if self.is_inside(corners[0]) { saddle } else { saddle.reverse() }
    }

    /// The same where not all corners of the cell have a finite value.
    #[cold]
    fn saddle_of_some(&self, mut corners: [usize; 4]) -> Ordering {
        if !self.is_inside(corners[0]) {
            corners.rotate_left(1);
        }
        let is_known = |k: usize| self.known >> k & 1 == 1;
        let [a, b, c, d] = corners;
        if !(is_known(b) && is_known(d)) {
            return Ordering::Less;
        }
        if !(is_known(a) && is_known(c)) {
            return Ordering::Greater;
        }
        ask(&Saddle, corners.map(|k| self.values[k]), None)
    }

    fn look_inside(
        &self,
        axis: usize,
        row: &Resolved,
        short: Option<[i64; 8]>,
        verdict: &mut Verdict,
    ) {
        let Some(body) = ask(&Interior { axis }, self.values, short) else { return };
        verdict.is_singular |= body.value == Ordering::Equal;
        let low = around(axis);
        let ends = [low[body.first], low[body.first + 2]].map(|k| {
            // One end of the edge, at least, is on the side that the edge is on at the maximum.
            if self.is_inside(k) == body.is_inside { k } else { k | 1 << axis }
        });
        let [a, c] = ends;
        if body.joins() && row.regions[a] != row.regions[c] {
            verdict.tunnel = Some(ends.map(|k| k as u8));
        }
    }
}

#[cfg(test)]
mod tests;
