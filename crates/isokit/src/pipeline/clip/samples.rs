//! The samples of a volume, and what is less than the isovalue beyond planes and outside of a mask.

use super::Mask;
use crate::pipeline::SurfaceOptions;
use isokit_geom::{
    Affine, HalfSpace,
    vector::{Vector, dot, length},
};
use isokit_job::{Job, Stopped};
use isokit_lanes::{Extent, Side, exactly};
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

/// Through what an edge leaves the solid.
pub(super) enum Through<'a> {
    /// The surface of the field.
    Field,
    Plane(&'a Cut),
    Mask,
}

/// As near as vertices come to samples at the nearest, in parts of an edge.
const NEAR: f64 = 1e-3;

/// How often an edge that leaves a mask is halved to find where: more than f32 shows.
const HALVINGS: u32 = 24;

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

/// How fast what is cut away falls from where the cut is: about as values do.
pub(super) struct Fall {
    /// In a unit of the world.
    steep: f64,
    /// How far samples outside of a mask are from it.
    masked: f64,
}

impl Fall {
    pub(super) fn of<T: Sample>(view: &View<'_, T>, [least, greatest]: [f64; 2]) -> Self {
        let masked = view.frame().index_to_world.spacing().into_iter().fold(0.0, f64::max);
        let steep = (0.25 * (greatest - least) / masked).clamp(f64::MIN_POSITIVE, f64::MAX);
        Self { steep, masked }
    }
}

/// The values, and what is less than the isovalue where planes and a mask cut.
pub(super) struct Clipped<'a, T: Sample> {
    pub(super) view: View<'a, T>,
    pub(super) iso: f64,
    pub(super) fall: Fall,
    pub(super) cuts: &'a [Cut],
    pub(super) mask: Option<&'a Mask>,
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
        let place = ijk.map(|n| n as f64);
        let mut beyond = self.beyond(|cut| cut.beyond(place));
        if !self.is_masked_in(place) {
            beyond = beyond.max(self.fall.masked);
        }
        match beyond > 0.0 {
            true => (self.iso - self.fall.steep * beyond).min(self.iso.next_down()),
            false => self.view.value(ijk),
        }
    }

    /// Whether a sample is kept and inside.
    fn is_inside(&self, ijk: Vector) -> bool {
        self.value(ijk) >= self.iso
            && self.cuts.iter().all(|cut| cut.beyond(ijk) <= 0.0)
            && self.is_masked_in(ijk)
    }

    fn is_masked_in(&self, ijk: Vector) -> bool {
        self.mask.is_none_or(|mask| mask.keeps(ijk))
    }

    fn value(&self, sample: Vector) -> f64 {
        self.view.value(sample.map(|c| c as usize))
    }

    /// Where the edge of a vertex leaves the solid, and through what, if vertices keep `margin` from samples, in parts of an
    /// edge. None of a vertex that is on no edge between two samples: on the border of the volume, or within a cell.
    pub(super) fn leaves(&self, ijk: Vector, margin: f64) -> Option<(Vector, Through<'_>)> {
        let margin = margin.max(NEAR);
        let nearest = ijk.map(f64::round);
        let away = [0, 1, 2].map(|k| (ijk[k] - nearest[k]).abs());
        let axis = (1..3).fold(0, |most, k| if away[k] > away[most] { k } else { most });
        // Rounding moves a vertex by less than half of the margin.
        let is_on_edge = (0..3).all(|k| (away[k] < 0.5 * margin) != (k == axis));
        let dims = self.view.dims();
        let (mut low, mut high) = (nearest, nearest);
        (low[axis], high[axis]) = (ijk[axis].floor(), ijk[axis].floor() + 1.0);
        let is_within = |end: Vector| (0..3).all(|k| end[k] >= 0.0 && end[k] < dims[k] as f64);
        if !(is_on_edge && is_within(low) && is_within(high)) {
            return None;
        }
        let (from, to) = if self.is_inside(low) { (low, high) } else { (high, low) };
        let at =
            |share: f64| -> Vector { std::array::from_fn(|k| from[k] + (to[k] - from[k]) * share) };
        let mut first = (f64::INFINITY, Through::Field);
        if self.value(to) < self.iso {
            first.0 = falls_below(self.iso, self.value(from), self.value(to));
        }
        for cut in self.cuts {
            let [before, after] = [from, to].map(|end| cut.beyond(end));
            if after > 0.0 && -before / (after - before) < first.0 {
                first = (-before / (after - before), Through::Plane(cut));
            }
        }
        if !self.is_masked_in(to) {
            let share = self.leaves_mask(at);
            if share < first.0 {
                first = (share, Through::Mask);
            }
        }
        let (share, through) = first;
        share.is_finite().then(|| (at(share.clamp(margin, 1.0 - margin)), through))
    }

    /// Where between 0, which is in the mask, and 1, which is not, places leave it.
    fn leaves_mask(&self, at: impl Fn(f64) -> Vector) -> f64 {
        let (mut within, mut outside) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (within + outside);
            match self.is_masked_in(at(middle)) {
                true => within = middle,
                false => outside = middle,
            }
        }
        0.5 * (within + outside)
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
        let masked = self.mask.map_or(Side::Inside, |mask| mask.side(points));
        Some(match () {
            () if nearest > 0.0 || masked == Side::Outside => cut,
            () if farthest > 0.0 || masked == Side::Both => kept.with(cut),
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

/// In what part of the way from a value inside to one outside the isovalue is. What is infinite is not left, or at once.
fn falls_below(iso: f64, inside: f64, outside: f64) -> f64 {
    if inside == f64::INFINITY {
        return 1.0;
    }
    match inside - outside {
        fall if fall.is_finite() => (inside - iso) / fall,
        _ => (0.5 * inside - 0.5 * iso) / (0.5 * inside - 0.5 * outside),
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
