//! Files with three numbers per sample, and what is read of them: one quantity, as f32.
//!
//! The numbers of a sample lie beside each other, or all first ones come before all second ones. Either way the file
//! is read as one lattice three times as large, and three strided views of it are the components. A vector is along
//! the axes of the world, or along those that the header says.

use super::{Described, VolumeFile, VolumeOptions, colors::Colored, stored::Order};
use crate::{ReadError, ReadFault};
use isokit_geom::vector::Vector;
use isokit_job::Job;
use isokit_volume::{AnyVolume, Grid, Quantity, Sample, Vectors, View, Volume, for_any};

/// Vectors along the axes of the world.
pub(super) const ALONG_AXES: [Vector; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// What to say of numbers that make no volume.
pub(super) const ADVICE: &str =
    "--quantity says what is read of vectors: x, y, z, speed, divergence, vorticity or q-criterion";

/// How the components lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layout {
    /// The three numbers of a sample beside each other.
    Together,
    /// Three volumes one after another.
    Apart,
}

/// Samples of three numbers, as a header describes them.
pub(super) struct Triples {
    pub(super) layout: Layout,
    /// Of the lattice of vectors.
    pub(super) dims: [u64; 3],
    /// What is said to somebody who asks for a volume; none if it is one as well.
    pub(super) fault: Option<ReadFault>,
    /// Whether the components are volumes that may be asked for by number.
    pub(super) are_volumes: bool,
}

/// What is asked for of vectors, and how they lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    quantity: Quantity,
    layout: Layout,
    /// Of the lattice of vectors.
    dims: [u64; 3],
}

/// What is made of a file of vectors.
#[derive(Clone, Debug)]
pub(super) struct Flow {
    quantity: Quantity,
    layout: Layout,
    pub(super) grid: Grid,
    to_world: [Vector; 3],
}

impl Described {
    /// The lattice of all numbers, and what is to be made of them, if that is asked for.
    pub(super) fn of_numbers(
        mut self,
        options: &VolumeOptions,
    ) -> Result<(Self, Option<Wanted>), ReadFault> {
        let (triples, colored) = (self.triples.take(), self.colored.take());
        // Vectors of bytes may be colours too; what can only be colours is neither values nor vectors.
        if let (None, Some(Colored { fault, .. })) = (&triples, colored) {
            return Err(fault);
        }
        let Some(quantity) = options.quantity else {
            let fault = triples.and_then(|triples| {
                let is_volume = triples.are_volumes && options.volume_index.is_some();
                triples.fault.filter(|_| !is_volume)
            });
            return fault.map_or(Ok((self, None)), Err);
        };
        let caller = |says: String| Err(ReadFault::Caller(says.into()));
        if options.volume_index.is_some() {
            return caller(
                "--quantity takes all volumes for components, --volume-index one".into(),
            );
        }
        let (layout, dims) = match triples {
            Some(Triples { layout, dims, .. }) => (layout, dims),
            None if self.volumes == 3 => (Layout::Apart, self.dims),
            None => {
                let found = match self.volumes {
                    1 => "one".to_owned(),
                    volumes => format!("{volumes} volumes of one"),
                };
                return caller(format!(
                    "--quantity is of vectors: three numbers per sample, found {found}"
                ));
            }
        };
        if self.stored.order != Order::XFastest {
            return caller("--quantity of an array in Fortran order: save it in C order".into());
        }
        let along = if layout == Layout::Together { 0 } else { 2 };
        let Some(whole) = dims[along].checked_mul(3) else {
            return caller(format!("three times {dims:?} samples are more than 64 bits can count"));
        };
        let mut all = dims;
        all[along] = whole;
        (self.dims, self.volumes) = (all, 1);
        Ok((self, Some(Wanted { quantity, layout, dims })))
    }
}

impl Flow {
    /// Of the lattice of all numbers.
    pub(super) fn new(wanted: Wanted, all: &Grid, to_world: [Vector; 3]) -> Self {
        let Wanted { quantity, layout, dims } = wanted;
        let grid = Grid::new(dims, all.frame).expect("a third of a lattice is one");
        Self { quantity, layout, grid, to_world }
    }

    /// Whether values are made of how vectors change in space.
    pub(super) fn is_derived(&self) -> bool {
        !matches!(self.quantity, Quantity::Component(_) | Quantity::Speed)
    }

    /// The quantity of all samples.
    pub(super) fn collect(self, numbers: VolumeFile, job: &Job) -> Result<AnyVolume, ReadError> {
        let path = numbers.path.clone();
        let all = numbers.collect(job)?;
        let made = for_any!(&all, all => {
            Vectors::new(self.views(all), self.to_world).quantity(self.quantity, job)
        });
        made.map(AnyVolume::from).map_err(|stopped| ReadFault::from(stopped).at(path))
    }

    fn views<'a, T: Sample>(&self, all: &'a Volume<T>) -> [View<'a, T>; 3] {
        // All samples are in memory, so their numbers are of its address space.
        let [nx, ny, nz] = self.grid.dims().map(|n| n as isize);
        let (step, next) = match self.layout {
            Layout::Together => (3, 1),
            Layout::Apart => (1, (nx * ny * nz) as usize),
        };
        let strides = [step, step * nx, step * nx * ny];
        [0, 1, 2].map(|component| {
            let view = View::strided(all.samples(), component * next, strides, &self.grid);
            view.expect("three numbers for each sample").with_scaling(all.scaling())
        })
    }
}

#[cfg(test)]
mod tests;
