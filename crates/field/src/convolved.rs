//! A volume convolved with any kernel: what [`resample`](crate::resample) makes of it, at any place and with derivatives.
//!
//! In space the kernel is the product of three, one along each axis, so derivatives are those of its factors: each is a sum
//! over the same samples with other weights (Möller, Machiraju, Mueller & Yagel 1997, "Evaluation and design of filters using
//! a Taylor series expansion"). Of a spline that goes through the samples the numbers are found first, for all places at once
//! (Unser, Aldroubi & Eden 1993, "B-spline signal processing: part II").

mod line;

use crate::{
    Interval, Jet, ResampleError, ScalarField, SeparableKernel, Slope,
    resample::{AXES, MOST, spline_numbers},
};
use isokit_geom::{Aabb, Affine};
use isokit_job::Job;
use isokit_volume::{Dtype, Sample, View};
use line::{Line, Stencil};
use std::ops::Range;

/// Bounds of a box that more samples are in are not looked for.
const MOST_IN_BOX: usize = 1 << 18;

/// Of kernels that reach farther no bounds are known: it would take long to find out how much their weights are together.
const WIDE: f64 = 16.0;

/// Of kernels that reach less far neither: there are places where nothing counts.
const NARROW: f64 = 0.5;

/// A volume as a kernel sees it, at any place: values, gradients and Hessians of the convolution of samples and kernel.
///
/// On the lattice and at any other place it is what [`resample`](crate::resample) makes there of samples that come no farther
/// from each other: for kernels that are no splines to the bit, but that it keeps f32 for samples of 8 and 16 bits and of
/// f32; for splines but for rounding. So the border is that of `resample` too: a line goes on as the cubic through its last
/// four samples, or of kernels that reach farther than two of them turned around the last; and so does the field for a
/// little. Along each axis weights add up to 1.
///
/// Derivatives are those of the kernel. Where they have an edge, as those of [`Linear`](crate::Filter::Linear) at samples,
/// they are the mean of both sides; those of [`Nearest`](crate::Filter::Nearest) are 0.
///
/// Where nothing counts, as between samples for a kernel that reaches less than half way, there is no value.
/// A sample that is not finite leaves none where it counts, and no derivative where it counts for that. For splines all
/// must be finite.
///
/// # Examples
///
/// ```
/// use isokit_field::{Convolved, Filter, ScalarField};
/// use isokit_job::Job;
/// use isokit_volume::{Grid, Volume};
///
/// // The samples of x² + y z, which a spline of degree 3 keeps.
/// let grid = Grid::new([6, 5, 4], Default::default())?;
/// let sample = |n: u64| [n % 6, n / 6 % 5, n / 30].map(|i| i as f64);
/// let samples = (0..120).map(sample).map(|[x, y, z]| x * x + y * z).collect();
/// let volume = Volume::new(grid, samples)?;
///
/// let field = Convolved::new(volume.view(), Filter::CubicBSpline, &Job::default())?;
/// let jet = field.jet([1.5, 2.25, 0.5]);
/// assert!((jet.value - 3.375).abs() < 1e-12);
/// assert!((jet.gradient[0] - 3.0).abs() < 1e-12);
/// assert!((jet.hessian[1][2] - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Convolved<'a, T, K> {
    view: View<'a, T>,
    kernel: K,
    numbers: Numbers,
    /// How much the absolute values of weights are together at most along each axis, away from the border and anywhere; none
    /// where it is not known.
    stretches: Option<[[f64; 2]; 3]>,
}

/// What is weighed.
#[derive(Clone, Debug)]
enum Numbers {
    /// The samples of the view.
    Samples,
    /// The numbers of a spline, one more at each end of each axis, x fastest.
    Single(Vec<f32>),
    Double(Vec<f64>),
}

impl<'a, T: Sample, K: SeparableKernel> Convolved<'a, T, K> {
    /// The convolution of the samples of `view` and `kernel`. For a spline its numbers are kept, f32; of i32, u32 and f64,
    /// f64. The same for any number of threads.
    ///
    /// # Errors
    ///
    /// If an axis has more samples or the kernel reaches farther than is numbered. For a spline: if a sample is not finite,
    /// if the job allows less memory than the numbers take, or there is none, or if it is cancelled.
    pub fn new(view: View<'a, T>, kernel: K, job: &Job) -> Result<Self, ResampleError> {
        let radius = kernel.radius();
        for (axis, size) in view.dims().into_iter().enumerate() {
            let needed = (size as u64).max(radius as u64);
            if needed > MOST.into() {
                return Err(ResampleError::TooMany { axis: AXES[axis], needed, most: MOST.into() });
            }
        }
        let numbers = match (kernel.spline(), T::DTYPE) {
            (None, _) => Numbers::Samples,
            (Some(spline), Dtype::I32 | Dtype::U32 | Dtype::F64) => {
                Numbers::Double(spline_numbers(&view, spline, job)?)
            }
            (Some(spline), _) => Numbers::Single(spline_numbers(&view, spline, job)?),
        };
        let field = Self { view, kernel, numbers, stretches: None };
        let stretches = || [0, 1, 2].map(|axis| field.line(axis).stretches());
        let stretches = (NARROW..=WIDE).contains(&radius).then(stretches);
        Ok(Self { stretches, ..field })
    }

    fn line(&self, axis: usize) -> Line<'_, K> {
        let is_spline = !matches!(self.numbers, Numbers::Samples);
        Line { kernel: &self.kernel, size: self.view.dims()[axis], is_spline }
    }

    fn stencils(&self, ijk: [f64; 3], derivatives: usize) -> [Stencil; 3] {
        [0, 1, 2].map(|axis| self.line(axis).stencil(ijk[axis], derivatives))
    }

    /// The numbers of a part of a row.
    #[inline]
    fn row(&self, x: Range<usize>, j: usize, k: usize, row: &mut Vec<f64>) {
        let [nx, ny, _] = self.view.dims();
        let first = (k * (ny + 2) + j) * (nx + 2);
        let own = first + x.start..first + x.end;
        row.clear();
        match &self.numbers {
            Numbers::Samples => row.extend(x.map(|i| self.view.stored([i, j, k]).to_f64())),
            Numbers::Single(numbers) => row.extend(numbers[own].iter().map(|&n| f64::from(n))),
            Numbers::Double(numbers) => row.extend_from_slice(&numbers[own]),
        }
    }

    /// Sums over stencils, along x, then y, then z: for each of the derivatives that are asked for, as orders along x, y, z,
    /// `ORDERS` less one in all at most.
    fn sums<const ORDERS: usize, const N: usize>(
        &self,
        [x, y, z]: [&Stencil; 3],
        asked: [[usize; 3]; N],
    ) -> [f64; N] {
        let mut row = Vec::with_capacity(x.numbers().len());
        let mut sums = [-0.0; N];
        for (c, k) in z.numbers().enumerate() {
            let mut slice = [[-0.0; ORDERS]; ORDERS];
            for (b, j) in y.numbers().enumerate() {
                self.row(x.numbers(), j, k, &mut row);
                let along_x: [f64; ORDERS] = std::array::from_fn(|order| x.sum(order, &row));
                for (along_y, slice) in slice.iter_mut().enumerate() {
                    let Some(weight) = y.weight(along_y, b) else { continue };
                    for (sum, row) in slice.iter_mut().zip(&along_x[..ORDERS - along_y]) {
                        *sum += weight * row;
                    }
                }
            }
            for (sum, [along_x, along_y, along_z]) in sums.iter_mut().zip(asked) {
                if let Some(weight) = z.weight(along_z, c) {
                    *sum += weight * slice[along_y][along_x];
                }
            }
        }
        sums
    }

    fn value_of(&self, stencils: [&Stencil; 3]) -> f64 {
        let [value] = self.sums::<1, 1>(stencils, [[0; 3]]);
        self.view.scaling().value(value)
    }

    /// Bounds of the numbers that the field is made of in a box, how much the absolute values of their weights are together
    /// there at most, and how many are weighed at a place along all axes. None if a number is not finite, if the box leaves
    /// the lattice, if there are too many to look at, or if it is not known.
    fn numbers_around(&self, ijk: Aabb) -> Option<([f64; 2], f64, usize)> {
        let (mut stretch, mut count) = (1.0, 0);
        let mut lines: [Range<usize>; 3] = Default::default();
        for (axis, held) in lines.iter_mut().enumerate() {
            let (low, high, line) = (ijk.min[axis], ijk.max[axis], self.line(axis));
            let last = (line.size - 1) as f64;
            if !(low >= 0.0 && low <= high && high <= last) {
                return None;
            }
            *held = line.held(low, high);
            count += held.len();
            let is_border = low < line.reach() || high > last - line.reach();
            stretch *= self.stretches?[axis][usize::from(is_border)];
        }
        if lines.iter().any(Range::is_empty) {
            return None;
        }
        let [x, y, z] = lines;
        if x.len().saturating_mul(y.len()).saturating_mul(z.len()) > MOST_IN_BOX {
            return None;
        }
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        let mut row = vec![];
        for (k, j) in z.flat_map(|k| y.clone().map(move |j| (k, j))) {
            self.row(x.clone(), j, k, &mut row);
            for &number in &row {
                if !number.is_finite() {
                    return None;
                }
                ends = [ends[0].min(number), ends[1].max(number)];
            }
        }
        Some((ends, stretch, count))
    }
}

impl<T: Sample, K: SeparableKernel> ScalarField for Convolved<'_, T, K> {
    fn dims(&self) -> [usize; 3] {
        self.view.dims()
    }

    fn index_to_world(&self) -> Affine {
        self.view.frame().index_to_world
    }

    fn value(&self, ijk: [f64; 3]) -> f64 {
        self.value_of(self.stencils(ijk, 0).each_ref())
    }

    /// From the least and the greatest of the numbers that count there, whose middle no value is farther from than half of
    /// what they are from each other times the sum of the absolute values of weights, as it is at most. Of more than 2¹⁸ of
    /// them, and of kernels that reach farther than 16 samples or less than half of one, nothing is said. A kernel is taken to be
    /// smooth but at whole and half distances, and its second derivative to be no more than doubled within 1/64 of a sample, as of
    /// all of [`Filter`](crate::Filter).
    fn bounds(&self, ijk: Aabb) -> Interval {
        let Some(([least, greatest], stretch, count)) = self.numbers_around(ijk) else {
            return Interval::EVERYTHING;
        };
        let middle = 0.5 * least + 0.5 * greatest;
        let most = stretch * least.abs().max(greatest.abs());
        // Weights and sums along each axis are off by a few units in the last place for each number.
        let rounding = 8.0 * (count + 8) as f64 * f64::EPSILON * most + f64::MIN_POSITIVE;
        let half = stretch * (0.5 * greatest - 0.5 * least) + rounding;
        let scaling = self.view.scaling();
        let [a, b] = [middle - half, middle + half].map(|number| scaling.value(number));
        // What a value means is rounded after that: a step farther, so that none is without.
        let (low, high) = (a.min(b).next_down(), a.max(b).next_up());
        match low.is_finite() && high.is_finite() && most.is_finite() {
            true => Interval { low, high },
            false => Interval::EVERYTHING,
        }
    }

    fn fill(&self, points: [Range<usize>; 3], values: &mut [f64]) {
        let lengths = points.each_ref().map(ExactSizeIterator::len);
        assert_eq!(values.len(), lengths.iter().product(), "one value for each point");
        let along = |axis: usize| -> Vec<Stencil> {
            let line = self.line(axis);
            points[axis].clone().map(|i| line.stencil(i as f64, 0)).collect()
        };
        let [x, y, z] = [along(0), along(1), along(2)];
        let rows = z.iter().flat_map(|z| y.iter().map(move |y| (y, z)));
        for (row, (y, z)) in values.chunks_exact_mut(x.len().max(1)).zip(rows) {
            for (value, x) in row.iter_mut().zip(&x) {
                *value = self.value_of([x, y, z]);
            }
        }
    }

    fn slope(&self, ijk: [f64; 3]) -> Slope {
        let stencils = self.stencils(ijk, 1);
        let asked = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
        let [value, gradient @ ..] = self.sums::<2, 4>(stencils.each_ref(), asked);
        let scaling = self.view.scaling();
        let of = |part: f64| if value.is_nan() { f64::NAN } else { part * scaling.slope() };
        Slope { value: scaling.value(value), gradient: gradient.map(of) }
    }

    fn jet(&self, ijk: [f64; 3]) -> Jet {
        let stencils = self.stencils(ijk, 2);
        let firsts = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
        let seconds = [[2, 0, 0], [0, 2, 0], [0, 0, 2], [0, 1, 1], [1, 0, 1], [1, 1, 0]];
        let asked: [[usize; 3]; 10] =
            std::array::from_fn(|n| if n < 4 { firsts[n] } else { seconds[n - 4] });
        let [value, rest @ ..] = self.sums::<3, 10>(stencils.each_ref(), asked);
        let scaling = self.view.scaling();
        let of = |part: f64| if value.is_nan() { f64::NAN } else { part * scaling.slope() };
        let [x, y, z, xx, yy, zz, yz, xz, xy] = rest.map(of);
        Jet {
            value: scaling.value(value),
            gradient: [x, y, z],
            hessian: [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]],
        }
    }
}

#[cfg(test)]
mod tests;
