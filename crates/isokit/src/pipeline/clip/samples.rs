//! The samples of a volume, and what is less than the isovalue beyond planes.

use crate::pipeline::SurfaceOptions;
use isokit_geom::{
    Affine, HalfSpace,
    vector::{Vector, dot, length},
};
use isokit_job::{Job, Stopped};
use isokit_lanes::{Extent, exactly};
use isokit_marching_cubes::{
    Budget, Extracted, Placement, SlabError, Slabs, extract_slabs, extract_sparse,
};
use isokit_mesh::TriMesh;
use isokit_volume::{Bricks, Grid, Points, Sample, SampleSource, SlabSource, View};
use rayon::prelude::*;
use std::{borrow::Cow, ops::Range};

/// A plane as the lattice sees it.
pub(super) struct Cut {
    /// How much farther beyond it the next sample along x, y, z is, and how far the first; in world units.
    step: Vector,
    first: f64,
    /// Out of what is kept, one long.
    pub(super) normal: Vector,
}

/// Bytes of the samples that planes cut, in f64, of which more are not held at a time, unless these are fewer slices than
/// [`SLICES`].
pub(super) const WINDOW: u64 = 64 << 20;

/// Slices that may be held at least. Three of them are those of the window before: of few, threads make little at a time.
const SLICES: usize = 16;

const _: () = assert!(SLICES >= Placement::Linear.least_window(), "planes go with no other");

pub(super) fn cuts(affine: &Affine, planes: &[HalfSpace]) -> Vec<Cut> {
    let cut = |plane: &HalfSpace| {
        let long = length(plane.normal());
        let step = affine.columns().map(|column| dot(plane.normal(), column) / long);
        let first = plane.beyond(affine.origin()) / long;
        Cut { step, first, normal: plane.normal().map(|c| c / long) }
    };
    planes.iter().map(cut).collect()
}

/// How fast what is beyond a plane falls: about as values do.
pub(super) fn steep<T: Sample>(view: &View<'_, T>, [least, greatest]: [f64; 2]) -> f64 {
    let spacing = view.frame().index_to_world.spacing().into_iter().fold(0.0, f64::max);
    (0.25 * (greatest - least) / spacing).clamp(f64::MIN_POSITIVE, f64::MAX)
}

/// The values, and what is less than the isovalue beyond the planes.
pub(super) struct Clipped<'a, T: Sample> {
    pub(super) view: View<'a, T>,
    pub(super) iso: f64,
    pub(super) steep: f64,
    pub(super) cuts: &'a [Cut],
    pub(super) known: Option<Cow<'a, Bricks<T>>>,
}

impl<T: Sample> Clipped<'_, T> {
    /// Their surface: near it only where that is known, or else a few slices at a time.
    pub(super) fn mesh_into(
        &self,
        options: &SurfaceOptions,
        mesh: &mut TriMesh,
        job: &Job,
    ) -> Result<Vec<Extracted>, SlabError<Stopped>> {
        options.prepare(mesh);
        let (iso, extract) = (self.iso, &options.extract);
        if self.known.is_some() {
            return Ok(vec![extract_sparse(self, iso, extract, &mut mesh.refill(), job)?]);
        }
        let slice = size_of::<f64>() as u64 * self.grid().slice_count();
        let window = SLICES.max((WINDOW / slice) as usize);
        let budget = Budget { window, piece_bytes: u64::MAX };
        let slabs = Slabs { isos: &[iso], options: extract, budget };
        extract_slabs(&mut self.slices(job), &slabs, &mut vec![mesh.refill()], job)
    }

    pub(super) fn slices<'a>(&'a self, job: &'a Job) -> ClippedSlices<'a, T> {
        ClippedSlices { clipped: self, grid: self.grid(), next: 0, job }
    }

    fn sample(&self, ijk: [usize; 3]) -> f64 {
        let beyond = self.beyond(|cut| cut.beyond(ijk.map(|n| n as f64)));
        match beyond > 0.0 {
            true => (self.iso - self.steep * beyond).min(self.iso.next_down()),
            false => self.view.value(ijk),
        }
    }

    /// The greatest of what is told of the planes.
    fn beyond(&self, of: impl Fn(&Cut) -> f64) -> f64 {
        self.cuts.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
    }
}

impl<T: Sample> SampleSource<f64> for Clipped<'_, T> {
    fn grid(&self) -> Grid {
        self.view.grid()
    }

    fn extent(&self, points: &Points) -> Option<Extent<f64>> {
        let stored = self.known.as_ref()?.extent(points);
        let ends =
            stored.range().map(|ends| ends.map(|end| self.view.scaling().value(end.to_f64())));
        let kept = ends.map_or(Extent::EMPTY, |[a, b]| Extent {
            least: a.min(b),
            greatest: a.max(b),
            has_nan: false,
        });
        let kept = Extent { has_nan: stored.has_nan, ..kept };
        let cut =
            Extent { least: f64::NEG_INFINITY, greatest: self.iso.next_down(), has_nan: false };
        // Rounding keeps order, so no sample of the box is nearer or farther than its corners are.
        let [nearest, farthest] = [Cut::nearest, Cut::farthest]
            .map(|corner| self.beyond(|cut| cut.beyond(corner(cut, points))));
        Some(match () {
            () if nearest > 0.0 => cut,
            () if farthest > 0.0 => kept.with(cut),
            () => kept,
        })
    }

    fn fill(&self, [x, y, z]: &Points, samples: &mut [f64]) {
        assert_eq!(samples.len(), x.len() * y.len() * z.len(), "one for each point");
        let rows = z.clone().flat_map(|k| y.clone().map(move |j| (j, k)));
        for (row, (j, k)) in samples.chunks_exact_mut(x.len().max(1)).zip(rows) {
            for (sample, i) in row.iter_mut().zip(x.clone()) {
                *sample = self.sample([i, j, k]);
            }
        }
    }
}

/// The same, slice by slice.
pub(super) struct ClippedSlices<'a, T: Sample> {
    clipped: &'a Clipped<'a, T>,
    grid: Grid,
    next: usize,
    job: &'a Job,
}

impl<T: Sample> SlabSource<f64> for ClippedSlices<'_, T> {
    type Error = Stopped;

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn fill(&mut self, slices: &mut [f64]) -> Result<(), Stopped> {
        let [nx, ny, _] = self.clipped.view.dims();
        let (clipped, first) = (self.clipped, self.next * ny);
        let fill = |(n, row): (usize, &mut [f64])| {
            let [j, k] = [(first + n) % ny, (first + n) / ny];
            exactly(|| clipped.fill(&[0..nx, j..j + 1, k..k + 1], row));
        };
        self.job.threads.run(|| slices.par_chunks_mut(nx).enumerate().for_each(fill));
        self.next += slices.len() / (nx * ny);
        Ok(())
    }
}

impl Cut {
    /// How far beyond the plane a place of index space is, in world units.
    pub(super) fn beyond(&self, ijk: Vector) -> f64 {
        self.first + dot(self.step, ijk)
    }

    /// The corner of a box that is least beyond the plane.
    fn nearest(&self, points: &Points) -> Vector {
        self.corner(points, |step| step < 0.0)
    }

    /// The one that is most beyond it.
    fn farthest(&self, points: &Points) -> Vector {
        self.corner(points, |step| step > 0.0)
    }

    fn corner(&self, points: &Points, is_last: impl Fn(f64) -> bool) -> Vector {
        let end = |axis: usize| {
            let Range { start, end } = points[axis];
            if is_last(self.step[axis]) { end - 1 } else { start }
        };
        [0, 1, 2].map(|axis| end(axis) as f64)
    }
}
