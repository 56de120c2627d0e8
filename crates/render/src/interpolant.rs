//! A volume between its samples, as a kernel has it.

use crate::{Ray, Trilinear};
use isokit_field::{Sampled, ScalarField};
use isokit_geom::vector::Vector;
use isokit_volume::{Sample, View};

/// How values between samples are made of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kernel {
    /// Of the eight samples around: trilinear, with central differences for gradients.
    #[default]
    Linear,
    /// Of 64 samples around: the product of three cubics with a continuous gradient (Catmull & Rom 1974, "A class of local
    /// interpolating splines"), so that edges of cells are not seen. Values may be beyond those of the samples. Beside
    /// samples that are no finite numbers it is linear.
    CatmullRom,
}

/// The values of a volume between its samples, in its box from the first sample to the last.
#[derive(Clone, Copy, Debug)]
pub struct Interpolant<'a, T> {
    pub(crate) linear: Trilinear<'a, T>,
    /// What is between samples, if that is not linear.
    cubic: Option<Sampled<'a, T>>,
}

impl<'a, T: Sample> Interpolant<'a, T> {
    /// What a kernel makes of the samples of `view`.
    pub fn new(view: View<'a, T>, kernel: Kernel) -> Self {
        let cubic = match kernel {
            Kernel::Linear => None,
            Kernel::CatmullRom => Some(Sampled::catmull_rom(view)),
        };
        Self { linear: Trilinear::new(view), cubic }
    }

    /// The value at a place of the world. None beyond the box, none where a sample of the cell is NaN, and none in a
    /// volume of one sample along an axis, which has no cells.
    pub fn at(&self, place: Vector) -> Option<f64> {
        let index = self.linear.index_of(place)?;
        Some(self.at_index(index)).filter(|value| !value.is_nan())
    }

    /// Whether it is cubic.
    pub(crate) fn is_cubic(&self) -> bool {
        self.cubic.is_some()
    }

    /// The value at a place in index space; NaN if there is none.
    pub(crate) fn at_index(&self, place: [f64; 3]) -> f64 {
        let cubic = self.cubic.map(|field| field.value(place));
        cubic.filter(|value| value.is_finite()).unwrap_or_else(|| self.linear.at_index(place))
    }

    /// The gradient in the world at a place in index space.
    pub(crate) fn gradient(&self, place: [f64; 3]) -> Vector {
        let cubic = self.cubic.map(|field| field.slope(place).gradient);
        match cubic.filter(|gradient| gradient.iter().all(|part| part.is_finite())) {
            Some(gradient) => self.linear.in_world(gradient),
            None => self.linear.gradient(place),
        }
    }

    /// What a cell is made of by polynomials: [`Sampled::control_points`].
    pub(crate) fn control_points(&self, cell: [usize; 3]) -> [[[f64; 4]; 4]; 4] {
        let cubic = self.cubic.unwrap_or(Sampled::catmull_rom(*self.linear.view()));
        cubic.control_points(cell)
    }

    /// From which value to which it may be in a cell, if it is cubic there.
    pub(crate) fn reach_of_cubic(&self, cell: [usize; 3]) -> Option<[f64; 2]> {
        let [x, y, z] = self.cubic?.around(cell);
        let (view, dims) = (self.linear.view(), self.linear.view().dims());
        let is_inner = |k: usize| cell[k] >= 1 && cell[k] + 2 < dims[k];
        let is_border = !(0..3).all(is_inner);
        let (mut least, mut greatest, mut is_finite) = (f64::INFINITY, f64::NEG_INFINITY, true);
        for (k, j) in z.flat_map(|k| y.clone().map(move |j| (k, j))) {
            let mut add = |sample: T| {
                let stored = sample.to_f64();
                is_finite &= stored.is_finite();
                (least, greatest) = (least.min(stored), greatest.max(stored));
            };
            let four = if x.len() == 4 { view.four([x.start, j, k]) } else { None };
            match four {
                Some(four) => four.iter().for_each(|&sample| add(sample)),
                None => x.clone().for_each(|i| add(view.stored([i, j, k]))),
            }
        }
        let [a, b] = Self::reach([least, greatest], true, is_border);
        let [a, b] = [a, b].map(|stored| view.scaling().value(stored));
        // Sums of weighted samples are rounded.
        let slack = 1e-13 * a.abs().max(b.abs());
        is_finite.then_some([a.min(b) - slack, a.max(b) + slack])
    }

    /// From which value to which it is in a cell, in stored values, of which the samples are in a range: those of the
    /// cell, and those that a cubic is made of besides.
    pub(crate) fn reach([least, greatest]: [f64; 2], is_cubic: bool, is_border: bool) -> [f64; 2] {
        if !is_cubic {
            return [least, greatest];
        }
        let beyond = 0.5 * (Sampled::<T>::growth(is_border) - 1.0) * (greatest - least);
        // Of infinite samples there is no cubic.
        let beyond = if beyond.is_finite() { beyond } else { 0.0 };
        [least - beyond, greatest + beyond]
    }

    /// From where to where a ray is in the box: as [`Trilinear::interval`].
    pub(crate) fn interval(&self, ray: &Ray) -> Option<[f64; 2]> {
        self.linear.interval(ray)
    }
}
