//! A volume that is larger than memory: a window of slices goes over it, and the surface follows.
//!
//! In the window lie the slices whose surface is made, and those that it looks at: with linear placement one
//! below and two above, since an edge between the last slice and the next needs the gradient at its upper
//! end; with another so many more as its stencils are longer. What is made of a window is the part of the whole surface that belongs to its slices, with the same numbers
//! and the same bits: vertices are numbered slice by slice anyway, and places are worked out from the
//! slice's number in the volume. Beyond the ends of a window that are no ends of the volume the lattice
//! has guards like everywhere, but no slice that is made looks so far.
//!
//! Where a source knows bricks ([`SlabSource::bricks`]) it is asked for the rows around the surfaces only.
//!
//! An error of the data is found in the last slice as well as in the first. Then sinks have got a part of
//! the surface, and the counts in the error are those of the whole volume all the same.

mod budget;
mod needed;
mod window;

pub use budget::Budget;

use crate::{
    ExtractError, ExtractOptions, Extracted, Nan, SlabError, Source, Topology,
    diagonals::Cases,
    extract::{on_threads, passes, precision, surface_bytes},
    fill::Fill,
    layout::{Layout, Part},
    planes::{Lattice, Planes},
    trilinear::Values,
    vertex::Placer,
    winding::Winding,
};
use isokit_job::{Job, OverLimit};
use isokit_lanes::exactly;
use isokit_mesh::{Counts, MeshSink, MeshSinks, Precision};
use isokit_volume::{Grid, Sample, SlabSource, View};
use std::ops::Range;
use window::Window;

/// What to extract, and how much of it is in memory at a time.
#[derive(Clone, Copy, Debug)]
pub struct Slabs<'a> {
    /// Isovalues, one for each surface.
    pub isos: &'a [f64],
    /// How samples become a surface.
    pub options: &'a ExtractOptions,
    /// How much is in memory.
    pub budget: Budget,
}

/// The surfaces where the value is one of several isovalues, from one pass over the slices of a volume.
/// Each is handed to its sink in pieces, which together are the surface that
/// [`extract_into`](crate::extract_into) hands over as one. What bricks of the source tell, where it has some, changes no
/// byte; with NaN that the options mask or forbid they are left aside.
///
/// # Errors
///
/// As [`extract_into`](crate::extract_into), of every sink, and if the source fails or the surface of one slice takes
/// more than the bytes of a piece.
pub fn extract_slabs<T: Sample, R: SlabSource<T>, S: MeshSinks<Error: Send> + Send>(
    source: &mut R,
    slabs: &Slabs<'_>,
    sinks: &mut S,
    job: &Job,
) -> Result<Vec<Extracted>, SlabError<R::Error, S::Error>> {
    let grid = *source.grid();
    check(&grid, slabs)?;
    let mut surfaces = vec![];
    for (n, &iso) in slabs.isos.iter().enumerate() {
        surfaces.push(Surface::new(iso, Cases::wanted(slabs.options, &mut sinks.sink(n))?));
    }
    let precision = exactly(|| precision(&grid, slabs.options))?;
    let making = Making { slabs, precision, job };
    let mut window = Window::new(&*source, slabs, job).map_err(ExtractError::from)?;
    let passes = 1 + passes(slabs.options) * surfaces.len() as u64;
    job.progress.begin("extract", passes.saturating_mul(grid.dims()[2]));
    while !window.is_last() {
        window.advance(source, job).map_err(SlabError::Source)?;
        if slabs.options.nan == Nan::Error {
            window.look_for_nan(job).map_err(ExtractError::from)?;
        }
        if window.nan.count > 0 {
            continue; // only to count them
        }
        let (view, bricks) = (window.view(), window.bricks());
        let known = bricks.as_ref().and_then(|bricks| Source::with_bricks(&view, bricks));
        let known = known.unwrap_or(Source::from(&view));
        let mut planes = on_threads(job, || making.planes(&known))?;
        job.progress.advance(window.new_slices());
        for (n, (surface, planes)) in surfaces.iter_mut().zip(&mut planes).enumerate() {
            let mut sink = sinks.sink(n);
            let held = window.held(planes.lattice);
            on_threads(job, || making.part(&held, planes, surface, &mut sink))?;
        }
    }
    if let Some(first) = window.nan.first {
        return Err(ExtractError::Nan { count: window.nan.count, first }.into());
    }
    let (precision, margin) = making.precision;
    let (skipped, mut found) = (window.skipped(), vec![]);
    for (n, surface) in surfaces.into_iter().enumerate() {
        let Surface { counts, singular_cells, is_begun, is_too_large, cases, .. } = surface;
        if is_too_large {
            let Counts { vertices, triangles } = counts;
            return Err(ExtractError::TooLarge { vertices, triangles }.into());
        }
        if !is_begun {
            sinks.sink(n).piece(counts, precision).map_err(ExtractError::Sink)?;
        }
        if let Some(cases) = cases {
            on_threads(job, || cases.fit(&mut sinks.sink(n), &grid, job))?;
        }
        found.push(Extracted { counts, precision, margin, singular_cells, skipped });
    }
    Ok(found)
}

/// What can be told before the first sample.
pub(crate) fn check<E>(grid: &Grid, slabs: &Slabs<'_>) -> Result<(), ExtractError<E>> {
    if let Some(&iso) = slabs.isos.iter().find(|iso| !iso.is_finite()) {
        return Err(ExtractError::Iso(iso));
    }
    // A window is never so high, whatever the volume is.
    let is_too_long = |n: &u64| *n > i32::MAX as u64 - 2;
    match grid.dims()[..2].iter().position(is_too_long) {
        Some(axis) => Err(ExtractError::TooLong { axis, size: grid.dims()[axis] as usize }),
        None => Ok(()),
    }
}

/// How far a surface is.
pub(crate) struct Surface {
    iso: f64,
    /// Vertices and triangles so far.
    pub(crate) counts: Counts,
    pub(crate) singular_cells: u64,
    pub(crate) is_begun: bool,
    pub(crate) is_too_large: bool,
    /// If diagonals are to be fitted.
    pub(crate) cases: Option<Cases>,
}

/// Slices of a volume that are in memory.
pub(crate) struct Held<'a, T> {
    pub(crate) view: View<'a, T>,
    /// The number of the first of them in the volume.
    pub(crate) first: u64,
    /// Slices of the lattice over them whose surface is made now.
    pub(crate) own: Range<usize>,
}

impl Surface {
    pub(crate) fn new(iso: f64, cases: Option<Cases>) -> Self {
        let counts = Counts::default();
        Self { iso, counts, singular_cells: 0, is_begun: false, is_too_large: false, cases }
    }
}

/// What holds for all parts of all surfaces.
pub(crate) struct Making<'a> {
    pub(crate) slabs: &'a Slabs<'a>,
    /// And the margin.
    pub(crate) precision: (Precision, f64),
    pub(crate) job: &'a Job,
}

impl Making<'_> {
    /// The planes of all isovalues. NaN that is an error was looked for already.
    fn planes<T: Sample, E: Send>(
        &self,
        source: &Source<'_, T>,
    ) -> Result<Vec<Planes>, ExtractError<E>> {
        let Slabs { isos, options, .. } = self.slabs;
        let nan = if options.nan == Nan::Mask { Nan::Mask } else { Nan::Outside };
        let lattice = Lattice::new(source.view.dims(), options.boundary);
        // Slices that were held before are gone through again.
        Ok(Planes::classify(source, lattice, isos, nan, &self.job.unwatched())?.0)
    }

    /// The part of a surface that belongs to the slices of a window.
    pub(crate) fn part<T: Sample, S: MeshSink<Error: Send>>(
        &self,
        held: &Held<'_, T>,
        planes: &mut Planes,
        surface: &mut Surface,
        sink: &mut S,
    ) -> Result<(), ExtractError<S::Error>> {
        let (view, lattice, job) = (held.view, planes.lattice, self.job);
        if planes.is_empty() || !lattice.has_cells() {
            job.progress.advance(2 * lattice.sampled(&held.own)); // neither counted nor filled
            return Ok(());
        }
        let part = Part { slices: held.own.clone(), before: surface.counts };
        let layers = self.layers_per_task(&part.slices);
        let values = Values::new(view, surface.iso, lattice.guard);
        let is_trilinear = self.slabs.options.topology == Topology::Trilinear;
        let decided = (&mut *planes, is_trilinear.then_some(&values));
        let layout = match Layout::part(decided, &part, layers, job) {
            Err(ExtractError::TooLarge { vertices, triangles }) => {
                surface.counts = Counts { vertices, triangles };
                surface.is_too_large = true;
                return Ok(());
            }
            layout => layout?,
        };
        surface.counts = layout.before(part.slices.end);
        surface.singular_cells += layout.singular_cells();
        if surface.is_too_large {
            return Ok(()); // only to count it
        }
        let first_slice = held.first as f64;
        let placer = Placer::new(view, surface.iso, self.precision.1, first_slice)
            .with_options(self.slabs.options);
        let winding = Winding::of(view.frame());
        let cases = surface.cases.as_ref();
        let fill = Fill { planes, layout: &layout, placer, values, winding, cases };
        let mut slices = part.slices;
        while !slices.is_empty() {
            let next = self.piece(&layout, &slices, sink.wants_normals())?;
            let counts = between(&layout, &next);
            slices.start = next.end;
            if counts == Counts::default() {
                job.progress.advance(lattice.sampled(&next));
                continue;
            }
            surface.is_begun = true;
            let bytes = surface_bytes(counts, self.precision.0, (sink, cases));
            job.limits.probe("surface", bytes, 1)?;
            let piece = sink.piece(counts, self.precision.0).map_err(ExtractError::Sink)?;
            let layers = self.layers_per_task(&next);
            fill.piece(next, piece, layers, job)?;
        }
        Ok(())
    }

    /// The first of some slices whose surface goes into one piece.
    fn piece(
        &self,
        layout: &Layout,
        slices: &Range<usize>,
        normals: bool,
    ) -> Result<Range<usize>, OverLimit> {
        let limit = self.slabs.budget.piece_bytes;
        let bytes = |end: usize| {
            let counts = between(layout, &(slices.start..end));
            counts.bytes(self.precision.0, normals).unwrap_or(u64::MAX)
        };
        // More slices never make less.
        let fits = (slices.start + 1..=slices.end).rev().find(|&end| bytes(end) <= limit);
        let needed = bytes(slices.start + 1);
        let over = || OverLimit { what: "the surface of one slice", needed, limit };
        fits.map(|end| slices.start..end).ok_or_else(over)
    }

    /// Few enough that every thread gets some of the slices.
    fn layers_per_task(&self, slices: &Range<usize>) -> usize {
        let share = slices.len() / (4 * self.job.threads.count());
        share.clamp(1, self.slabs.options.layers_per_task.get())
    }
}

/// What some slices make.
fn between(layout: &Layout, slices: &Range<usize>) -> Counts {
    let [before, after] = [slices.start, slices.end].map(|z| layout.before(z));
    Counts {
        vertices: after.vertices - before.vertices,
        triangles: after.triangles - before.triangles,
    }
}

#[cfg(test)]
mod tests;
