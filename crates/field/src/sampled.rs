//! A volume seen through cubics: smooth within each cell, and exact at the samples.
//!
//! Along each axis the function is the cubic through the four nearest samples, so in space it is the tensor
//! product of three such cubics, made of 64 samples. On an edge of the lattice it is the cubic of
//! `Placement::Cubic` in `marching-cubes`: vertices placed by that lie on its surface, to the last digits.
//! That is why it is this kernel and not Catmull & Rom's ([`Sampled::catmull_rom`]), which has a continuous gradient but
//! errors of O(h³) where these are O(h⁴). Across faces of cells the value is continuous and the gradient is not, by as
//! much as it is wrong. Of samples h apart of a smooth function the value is off by O(h⁴), the gradient by
//! O(h³), the Hessian by O(h²), in units of the world.
//!
//! A sample that is not finite leaves no value in the cells whose stencils it is in.

use crate::{
    Interval, Jet, ScalarField, Slope,
    kernel::{Cubic, Stencil, WIDTH, around_cell, samples, stretch},
};
use isokit_geom::{Aabb, Affine};
use isokit_volume::{Dtype, Sample, View};
use std::ops::Range;

/// Bounds of a box that more samples are in are not looked for.
const MOST: usize = 1 << 18;

/// The cubic function through the samples of a volume.
#[derive(Clone, Copy, Debug)]
pub struct Sampled<'a, T> {
    view: View<'a, T>,
    cubic: Cubic,
}

impl<'a, T: Sample> Sampled<'a, T> {
    /// The function through the samples of `view`.
    pub fn new(view: View<'a, T>) -> Self {
        Self { view, cubic: Cubic::Lagrange }
    }

    /// Another function through the samples of `view`, with a continuous gradient: in each cell along each axis the cubic
    /// that rises at a sample as from the one before to the one after (Catmull & Rom 1974, "A class of local interpolating
    /// splines"). Values are off by O(h³), gradients by O(h²).
    pub fn catmull_rom(view: View<'a, T>) -> Self {
        Self { view, cubic: Cubic::CatmullRom }
    }

    /// How far a value of a cell may be from the middle of the range of the samples that it is made of, the cell's corners
    /// and those around, where half of the range is 1; more if the cell is at the border of the volume.
    pub fn growth(is_border: bool) -> f64 {
        stretch(is_border).powi(3)
    }

    /// The samples that the function is made of in a cell, given by its lowest corner, along x, y, z.
    pub fn around(&self, cell: [usize; 3]) -> [Range<usize>; 3] {
        let dims = self.view.dims();
        std::array::from_fn(|axis| around_cell(cell[axis], dims[axis]))
    }

    /// The function in a cell, given by its lowest corner, as 4³ numbers of which it is the sum by Bernstein's
    /// polynomials of degree 3 along x (in the rows), y and z, which run from 0 to 1 in the cell. It has no value there
    /// that is beyond all of them. They are not finite where a sample is not that it is made of. Farin 2002, "Curves
    /// and surfaces for CAGD", chapters 5 and 15.
    ///
    /// # Panics
    ///
    /// If there is no such cell.
    pub fn control_points(&self, cell: [usize; 3]) -> [[[f64; 4]; 4]; 4] {
        let dims = self.view.dims();
        assert!(
            (0..3).all(|axis| cell[axis] + 1 < dims[axis]),
            "cell {cell:?} of {dims:?} samples"
        );
        let [x, y, z] = [0, 1, 2].map(|axis| Stencil::control(self.cubic, cell[axis], dims[axis]));
        let weighed = |[a, b, c, d]: [f64; 4], row: [f64; WIDTH]| {
            a * row[0] + b * row[1] + c * row[2] + d * row[3]
        };
        let mut along_x = [[[0.0; 4]; WIDTH]; WIDTH];
        for (slice, k) in along_x.iter_mut().zip(z.0) {
            for (points, j) in slice.iter_mut().zip(y.0.clone()) {
                let mut row = [0.0; WIDTH];
                for (stored, i) in row.iter_mut().zip(x.0.clone()) {
                    *stored = self.view.stored([i, j, k]).to_f64();
                }
                *points = x.1.map(|weights| weighed(weights, row));
            }
        }
        let along_y = along_x.map(|slice| {
            y.1.map(|weights| {
                [0, 1, 2, 3].map(|i| weighed(weights, [0, 1, 2, 3].map(|j| slice[j][i])))
            })
        });
        let scaling = self.view.scaling();
        z.1.map(|weights| {
            let point =
                |j: usize, i: usize| weighed(weights, [0, 1, 2, 3].map(|k| along_y[k][j][i]));
            [0, 1, 2, 3].map(|j| [0, 1, 2, 3].map(|i| scaling.value(point(j, i))))
        })
    }

    /// Bounds of the samples, as stored, that the function is made of in a box, and whether a cell of these is at the border.
    /// None if a sample is not finite, if the box leaves the lattice, or if there are too many to look at.
    fn stored_around(&self, ijk: Aabb) -> Option<([f64; 2], bool)> {
        let dims = self.view.dims();
        let mut is_border = false;
        let mut lines: [Range<usize>; 3] = Default::default();
        for axis in 0..3 {
            let (low, high, last) = (ijk.min[axis], ijk.max[axis], dims[axis] - 1);
            if !(low >= 0.0 && low <= high && high <= last as f64) {
                return None;
            }
            let [first, end] = [samples(low, dims[axis]), samples(high, dims[axis])];
            lines[axis] = first.start..end.end;
            // Those whose stencils are one-sided.
            is_border |= low < 1.0 || high >= last.saturating_sub(1) as f64;
        }
        let [x, y, z] = lines;
        if x.len().saturating_mul(y.len()).saturating_mul(z.len()) > MOST {
            return None;
        }
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        for (k, j) in z.flat_map(|k| y.clone().map(move |j| (k, j))) {
            for i in x.clone() {
                let stored = self.view.stored([i, j, k]).to_f64();
                if !stored.is_finite() {
                    return None;
                }
                ends = [ends[0].min(stored), ends[1].max(stored)];
            }
        }
        Some((ends, is_border))
    }

    fn stencils(&self, ijk: [f64; 3]) -> [Stencil; 3] {
        let dims = self.view.dims();
        std::array::from_fn(|axis| Stencil::at(self.cubic, ijk[axis], dims[axis]))
    }

    /// The stored samples of a stencil by their places along y, x and z; 0 where the volume has fewer.
    #[inline(always)]
    fn stored(&self, [x, y, z]: &[Stencil; 3]) -> [[[f64; WIDTH]; WIDTH]; WIDTH] {
        let mut stored = [[[0.0; WIDTH]; WIDTH]; WIDTH];
        let along_x = x.samples();
        for (c, k) in z.samples().enumerate() {
            for (stored, j) in stored.iter_mut().zip(y.samples()) {
                let four = (along_x.len() == WIDTH).then_some([along_x.start, j, k]);
                if let Some(four) = four.and_then(|place| self.view.four(place)) {
                    for (stored, sample) in stored.iter_mut().zip(four) {
                        stored[c] = sample.to_f64();
                    }
                    continue;
                }
                for (stored, i) in stored.iter_mut().zip(along_x.clone()) {
                    stored[c] = self.view.stored([i, j, k]).to_f64();
                }
            }
        }
        stored
    }

    /// Sums of stored samples over a stencil, along x, then y, then z: for each of the derivatives that are
    /// asked for, as orders along x, y, z, `ORDERS` less one in all at most. The four slices go side by side.
    #[inline(always)]
    fn sums<const ORDERS: usize, const N: usize>(
        &self,
        ijk: [f64; 3],
        asked: [[usize; 3]; N],
    ) -> [f64; N] {
        let stencils = self.stencils(ijk);
        let [x, y, z] = &stencils;
        let stored = self.stored(&stencils);
        let mut slices = [[[0.0; WIDTH]; ORDERS]; ORDERS];
        for b in 0..WIDTH {
            let mut rows = [[0.0; WIDTH]; ORDERS];
            for a in 0..WIDTH {
                for (row, weights) in rows.iter_mut().zip(&x.weights) {
                    for (row, stored) in row.iter_mut().zip(&stored[b][a]) {
                        *row += stored * weights[a];
                    }
                }
            }
            for (along_y, (slices, weights)) in slices.iter_mut().zip(&y.weights).enumerate() {
                for (slices, row) in slices[..ORDERS - along_y].iter_mut().zip(&rows) {
                    for (slice, row) in slices.iter_mut().zip(row) {
                        *slice += row * weights[b];
                    }
                }
            }
        }
        asked.map(|[along_x, along_y, along_z]| {
            let (slices, weights) = (&slices[along_y][along_x], &z.weights[along_z]);
            slices.iter().zip(weights).fold(0.0, |sum, (slice, weight)| sum + slice * weight)
        })
    }
}

impl<T: Sample> ScalarField for Sampled<'_, T> {
    fn dims(&self) -> [usize; 3] {
        self.view.dims()
    }

    fn index_to_world(&self) -> Affine {
        self.view.frame().index_to_world
    }

    fn value(&self, ijk: [f64; 3]) -> f64 {
        let [value] = self.sums::<1, 1>(ijk, [[0; 3]]);
        self.view.scaling().value(value)
    }

    fn is_known(&self, ijk: [f64; 3]) -> bool {
        let is_place = ijk.iter().all(|c| c.is_finite());
        if !matches!(T::DTYPE, Dtype::F32 | Dtype::F64) {
            return is_place;
        }
        let ([i, j, k], [nx, ny, nz]) = (ijk, self.view.dims());
        let (x, y, z) = (samples(i, nx), samples(j, ny), samples(k, nz));
        let is_finite = |sample: T| sample.to_f64().is_finite();
        let fours = |n: usize| self.view.four([x.start, y.start + n % WIDTH, z.start + n / WIDTH]);
        if [&x, &y, &z].iter().all(|line| line.len() == WIDTH) && fours(0).is_some() {
            // All are asked, side by side.
            let known = |row: &[T; WIDTH]| row.iter().fold(true, |all, &s| all & is_finite(s));
            return (0..WIDTH * WIDTH).fold(is_place, |all, n| all & fours(n).is_some_and(known));
        }
        let rows = z.flat_map(|k| y.clone().map(move |j| [j, k]));
        let mut places = rows.flat_map(|[j, k]| x.clone().map(move |i| [i, j, k]));
        is_place && places.all(|place| is_finite(self.view.stored(place)))
    }

    /// From the least and the greatest sample around, whose middle no value is farther from than half of what they are from each other times
    /// [`growth`](Sampled::growth). Of more than 2¹⁸ samples nothing is said.
    fn bounds(&self, ijk: Aabb) -> Interval {
        let Some(([least, greatest], is_border)) = self.stored_around(ijk) else {
            return Interval::EVERYTHING;
        };
        let middle = 0.5 * least + 0.5 * greatest;
        // A sum of 64 products, each off by a few units in its last place, of which weights are no more together than this.
        let rounding = 128.0 * f64::EPSILON * least.abs().max(greatest.abs());
        let half = Self::growth(is_border) * (0.5 * greatest - 0.5 * least + rounding);
        let scaling = self.view.scaling();
        let [a, b] = [middle - half, middle + half].map(|stored| scaling.value(stored));
        // What a value means is rounded after that: a step farther, so that none is without.
        let (low, high) = (a.min(b).next_down(), a.max(b).next_up());
        match low.is_finite() && high.is_finite() {
            true => Interval { low, high },
            false => Interval::EVERYTHING,
        }
    }

    fn fill(&self, points: [Range<usize>; 3], values: &mut [f64]) {
        let [x, y, z] = &points;
        assert_eq!(values.len(), x.len() * y.len() * z.len(), "one value for each point");
        if values.is_empty() {
            return;
        }
        let ijk = Aabb {
            min: points.each_ref().map(|range| range.start as f64),
            max: points.each_ref().map(|range| (range.end - 1) as f64),
        };
        // At a sample its weight is 1 and those of others are 0, which matters where they are not finite.
        let is_float = matches!(T::DTYPE, Dtype::F32 | Dtype::F64);
        let are_samples = !is_float || self.stored_around(ijk).is_some();
        let rows = z.clone().flat_map(|k| y.clone().map(move |j| [j, k]));
        for (row, [j, k]) in values.chunks_exact_mut(x.len()).zip(rows) {
            for (value, i) in row.iter_mut().zip(x.clone()) {
                *value = match are_samples {
                    // As in the sum, which has no −0.
                    true => self.view.scaling().value(self.view.stored([i, j, k]).to_f64() + 0.0),
                    false => self.value([i, j, k].map(|c| c as f64)),
                };
            }
        }
    }

    fn slope(&self, ijk: [f64; 3]) -> Slope {
        let scaling = self.view.scaling();
        let [value, x, y, z] = self.sums::<2, 4>(ijk, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]);
        let gradient = [x, y, z].map(|part| part * scaling.slope());
        Slope { value: scaling.value(value), gradient }
    }

    fn jet(&self, ijk: [f64; 3]) -> Jet {
        let scaling = self.view.scaling();
        let firsts = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
        let seconds = [[2, 0, 0], [0, 2, 0], [0, 0, 2], [0, 1, 1], [1, 0, 1], [1, 1, 0]];
        let asked: [[usize; 3]; 10] =
            std::array::from_fn(|n| if n < 4 { firsts[n] } else { seconds[n - 4] });
        let [value, rest @ ..] = self.sums::<3, 10>(ijk, asked);
        let [x, y, z, xx, yy, zz, yz, xz, xy] = rest.map(|part| part * scaling.slope());
        Jet {
            value: scaling.value(value),
            gradient: [x, y, z],
            hessian: [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]],
        }
    }
}

#[cfg(test)]
mod tests;
