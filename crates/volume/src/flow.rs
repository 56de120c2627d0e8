//! What a field of vectors is at its samples: how fast, how it spreads and turns.
//!
//! Derivatives are [`differences`]: central, at the border one-sided, in world units by the whole affine. So
//! their error is of order two in the distance of samples inside, of order one at the border. Along an axis of one
//! sample a field is constant.

use crate::{Sample, View, Volume, differences};
use isokit_geom::vector::{Vector, dot, length};
use isokit_job::{Job, Stopped, Work};
use isokit_lanes::exactly;
use rayon::prelude::*;
use std::{array, fmt, str::FromStr};

/// A number that is made of a vector and of how it changes in space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// The component along an axis of the world: 0, 1 or 2 for x, y, z.
    Component(usize),
    /// How long the vector is.
    Speed,
    /// ∇ · v: how fast what flows spreads.
    Divergence,
    /// |∇ × v|: twice as fast as what flows turns.
    Vorticity,
    /// The second invariant of the velocity gradient, ½ (|Ω|² − |S|²) with Frobenius norms of its antisymmetric and its
    /// symmetric part: above 0 in vortices, where turning outweighs stretching (Hunt, Wray & Moin 1988).
    QCriterion,
}

impl Quantity {
    /// All of them, with their names.
    pub const ALL: [(Self, &str); 7] = [
        (Self::Component(0), "x"),
        (Self::Component(1), "y"),
        (Self::Component(2), "z"),
        (Self::Speed, "speed"),
        (Self::Divergence, "divergence"),
        (Self::Vorticity, "vorticity"),
        (Self::QCriterion, "q-criterion"),
    ];

    /// Of a vector, and of its derivatives: `rows[c][k]` is that of component `c` along axis `k`.
    fn of(self, vector: Vector, rows: impl FnOnce() -> [Vector; 3]) -> f64 {
        match self {
            Self::Component(axis) => vector[axis],
            Self::Speed => length(vector),
            Self::Divergence => {
                let rows = rows();
                rows[0][0] + rows[1][1] + rows[2][2]
            }
            Self::Vorticity => {
                let rows = rows();
                let turn = |k: usize| {
                    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                    rows[j][i] - rows[i][j]
                };
                length([turn(0), turn(1), turn(2)])
            }
            Self::QCriterion => {
                // |Ω|² − |S|² is minus the trace of the square.
                let rows = rows();
                let square = |c: usize| (0..3).map(|k| rows[c][k] * rows[k][c]).sum::<f64>();
                -0.5 * (square(0) + square(1) + square(2))
            }
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = Self::ALL.into_iter().find(|(quantity, _)| quantity == self);
        f.write_str(named.map_or("component", |(_, name)| name))
    }
}

/// Not a quantity.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected x, y, z, speed, divergence, vorticity or q-criterion, found {0:?}")]
pub struct ParseQuantityError(String);

impl FromStr for Quantity {
    type Err = ParseQuantityError;

    fn from_str(text: &str) -> Result<Self, ParseQuantityError> {
        let named = Self::ALL.into_iter().find(|(_, name)| *name == text);
        named.map(|(quantity, _)| quantity).ok_or_else(|| ParseQuantityError(text.to_owned()))
    }
}

/// Three components on one lattice, and which way they point.
#[derive(Clone, Copy, Debug)]
pub struct Vectors<'a, T> {
    components: [View<'a, T>; 3],
    /// What takes a vector as it is stored to the world, as columns.
    to_world: [Vector; 3],
}

impl<'a, T: Sample> Vectors<'a, T> {
    /// The vectors of three components, each `to_world[c]` long in the world where its value is 1.
    ///
    /// # Panics
    ///
    /// If the components have different lattices.
    pub fn new(components: [View<'a, T>; 3], to_world: [Vector; 3]) -> Self {
        let [x, y, z] = &components;
        assert!(x.dims() == y.dims() && x.dims() == z.dims(), "components of one lattice");
        assert!(x.frame() == y.frame() && x.frame() == z.frame(), "components of one lattice");
        Self { components, to_world }
    }

    /// A quantity at each sample, as f32: NaN where a component is. A neighbour without a value is passed over, and
    /// changes nothing farther away.
    ///
    /// # Errors
    ///
    /// If the job is cancelled or allows less memory.
    ///
    /// # Panics
    ///
    /// If a component is asked for that is not 0, 1 or 2.
    pub fn quantity(&self, quantity: Quantity, job: &Job) -> Result<Volume<f32>, Stopped> {
        let grid = self.components[0].grid();
        let slice = self.components[0].dims()[0] * self.components[0].dims()[1];
        let mut values: Vec<f32> = job.limits.zeroed("values of a flow", Some(grid.count()))?;
        job.progress.begin("flow", grid.dims()[2]);
        let covectors = grid.frame.index_to_world.covector_columns();
        let fill: Work<'_, _, _> = &|(k, values): (usize, &mut [f32])| {
            job.check()?;
            exactly(|| self.fill(quantity, (k, &covectors), values));
            job.progress.advance(1);
            Ok::<_, Stopped>(())
        };
        job.threads.run(|| values.par_chunks_mut(slice).enumerate().try_for_each(fill))?;
        Ok(Volume::new(grid, values).expect("a value for each sample"))
    }

    /// The quantity in slice `k`.
    fn fill(&self, quantity: Quantity, (k, covectors): (usize, &[Vector; 3]), values: &mut [f32]) {
        let [nx, ny, _] = self.components[0].dims();
        for (j, row) in (0..ny).zip(values.chunks_exact_mut(nx)) {
            for (i, value) in row.iter_mut().enumerate() {
                let ijk = [i, j, k];
                let vector = self.in_world(self.components.map(|one| one.value(ijk)));
                let found = match vector.iter().any(|c| c.is_nan()) {
                    true => f64::NAN,
                    false => quantity.of(vector, || self.derivatives(ijk, covectors)),
                };
                *value = found as f32;
            }
        }
    }

    /// How each component changes along each axis of the world.
    fn derivatives(&self, ijk: [usize; 3], covectors: &[Vector; 3]) -> [Vector; 3] {
        let stored = self.components.map(|one| {
            let slope = one.scaling().slope();
            let per_sample = differences(&one, ijk).map(|difference| difference * slope);
            array::from_fn(|k| dot(per_sample, covectors.map(|column| column[k])))
        });
        // Column by column of the derivatives, each a vector.
        let columns: [Vector; 3] =
            array::from_fn(|k| self.in_world(stored.map(|row: Vector| row[k])));
        array::from_fn(|c| columns.map(|column| column[c]))
    }

    fn in_world(&self, vector: Vector) -> Vector {
        const SAME: [Vector; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        if self.to_world == SAME {
            return vector;
        }
        array::from_fn(|k| dot(vector, self.to_world.map(|column| column[k])))
    }
}

#[cfg(test)]
mod tests;
