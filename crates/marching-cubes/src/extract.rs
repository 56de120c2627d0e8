//! The entries: volume, value, options, sink; or several values with a sink each.

use crate::{
    Boundary, Degenerate, Diagonals, ExtractError, ExtractOptions, Nan, Skipped, Source, Topology,
    diagonals::Cases,
    fill::Fill,
    layout::{Layout, check_size},
    planes::{Lattice, Planes, Signs},
    sparse::Choice,
    sweep::{Sweep, Swept},
    tally::{Tally, Whole},
    trilinear::Values,
    vertex::Placer,
    winding::Winding,
};
use isokit_job::Job;
use isokit_lanes::{Thresholds, exactly};
use isokit_mesh::{Counts, MeshSink, Precision, TriMesh};
use isokit_volume::{Grid, Sample, View};
use std::{ops::ControlFlow, slice};

/// What can be said of a surface that went into a sink.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Extracted {
    /// Vertices and triangles.
    pub counts: Counts,
    /// How positions were handed over.
    pub precision: Precision,
    /// The least distance that a vertex keeps from the samples at both ends of its edge, in edge
    /// lengths; 0 with [`Degenerate::Exact`].
    pub margin: f64,
    /// Cells in which a saddle that decides what the surface connects is exactly on the isovalue. There the
    /// trilinear field has no surface that is a manifold; the mesh is one, with the inside joined. 0 with
    /// [`Topology::Table`], which does not ask.
    pub singular_cells: u64,
    /// What was not done, for all surfaces of the call together.
    pub skipped: Skipped,
}

/// The surface where the value is `iso`, with gradient normals, in memory.
///
/// # Errors
///
/// If `iso` is not finite, the volume has NaN and the options forbid it, the surface has 2³² vertices or
/// more, an axis 2³¹ samples or so, the coordinates' type does not tell neighbouring samples apart, or
/// the job was cancelled or would take more memory than it may.
pub fn extract<T: Sample>(
    view: &View<'_, T>,
    iso: f64,
    options: &ExtractOptions,
    job: &Job,
) -> Result<TriMesh, ExtractError> {
    let mut mesh = TriMesh::with_normals();
    extract_into(view, iso, options, &mut mesh.refill(), job)?;
    Ok(mesh)
}

/// The surface where the value is `iso`, handed to a sink as one piece. [`TriMesh::refill`] makes a sink
/// that uses the memory of a mesh again, which takes less time than new memory: no page is touched for the
/// first time. What was in it does not matter.
///
/// # Errors
///
/// As [`extract`], and if the sink has no room, or diagonals are to be fitted and it does not keep the surface, or takes
/// no normals.
pub fn extract_into<T: Sample, S: MeshSink<Error: Send> + Send>(
    view: &View<'_, T>,
    iso: f64,
    options: &ExtractOptions,
    sink: &mut S,
    job: &Job,
) -> Result<Extracted, ExtractError<S::Error>> {
    Ok(extract_many(view, &[iso], options, slice::from_mut(sink), job)?[0])
}

/// How many vertices and triangles the surface has; neither is made.
///
/// # Errors
///
/// As [`extract`].
pub fn count<T: Sample>(
    view: &View<'_, T>,
    iso: f64,
    options: &ExtractOptions,
    job: &Job,
) -> Result<Counts, ExtractError> {
    Ok(count_many(view, &[iso], options, job)?[0])
}

/// The surfaces of several values with one pass over the samples to classify them: the same, byte for
/// byte, as [`extract_into`] makes one by one. Each value has its sink.
///
/// Beside the output, memory for one bit per sample and value is in use; of one value, no more than a few slices
/// where the sink has memory or gets it ([`MeshSink::spare`]). With [`Diagonals::Fitted`](crate::Diagonals::Fitted) it is one byte
/// more for each cell that the surface crosses.
///
/// # Errors
///
/// As [`extract_into`]. Sinks that were filled before stay filled.
///
/// # Panics
///
/// If there are not as many sinks as values.
pub fn extract_many<'a, T: Sample, S: MeshSink<Error: Send> + Send>(
    samples: impl Into<Source<'a, T>>,
    isos: &[f64],
    options: &ExtractOptions,
    sinks: &mut [S],
    job: &Job,
) -> Result<Vec<Extracted>, ExtractError<S::Error>> {
    assert_eq!(isos.len(), sinks.len(), "one sink per isovalue");
    let source: Source<'_, T> = samples.into();
    let view = &source.view;
    let (precision, margin) = exactly(|| precision(&view.grid(), options))?;
    let mut cases = vec![];
    for sink in &mut *sinks {
        cases.push(Cases::wanted(options, sink)?);
    }
    on_threads(job, || {
        let mut filled = 0;
        if let ([iso], [sink], [cases]) = (isos, &mut *sinks, &cases[..]) {
            match swept(&source, *iso, (precision, margin), options, (sink, cases.as_ref()), job)? {
                ControlFlow::Break(extracted) => return Ok(vec![extracted]),
                ControlFlow::Continue(slices) => filled = slices,
            }
        }
        let (planes, skipped) = classified(&source, isos, passes(options), options, job)?;
        let cases = cases.iter().map(Option::as_ref);
        let surfaces = planes.into_iter().zip(isos).zip(sinks.iter_mut().zip(cases));
        let extract = |((mut planes, &iso), (sink, cases)): ((Planes, &f64), (&mut S, _))| {
            let values = Values::new(*view, iso, planes.lattice.guard);
            let layout = layout(&mut planes, &values, options, job)?;
            let counts = layout.as_ref().map_or(Counts::default(), Layout::counts);
            let singular_cells = layout.as_ref().map_or(0, Layout::singular_cells);
            job.limits.probe("surface", surface_bytes(counts, precision, (sink, cases)), 1)?;
            let piece = sink.piece(counts, precision).map_err(ExtractError::Sink)?;
            // What the sweep filled; of an empty surface, all.
            let before = if layout.is_some() { filled } else { planes.lattice.points[2] };
            job.progress.advance(planes.lattice.sampled(&(0..before)));
            if let Some(layout) = &layout {
                let placer = Placer::new(*view, iso, margin, 0.0).with_options(options);
                let winding = Winding::of(view.frame());
                let fill = Fill { planes: &planes, layout, placer, values, winding, cases };
                let slices = filled..planes.lattice.points[2];
                fill.piece(
                    slices,
                    piece.after(layout.before(filled)),
                    options.layers_per_task.get(),
                    job,
                )?;
            }
            if let Some(cases) = cases {
                cases.fit(sink, &view.grid(), job)?;
            }
            Ok(Extracted { counts, precision, margin, singular_cells, skipped })
        };
        surfaces.map(extract).collect()
    })
}

/// The surface in one sweep, where the sink has memory before it is known how much it takes; or how many slices
/// are filled.
fn swept<T: Sample, S: MeshSink<Error: Send> + Send>(
    Source { view, bricks }: &Source<'_, T>,
    iso: f64,
    (precision, margin): (Precision, f64),
    options: &ExtractOptions,
    (sink, cases): (&mut S, Option<&Cases>),
    job: &Job,
) -> Result<ControlFlow<Extracted, usize>, ExtractError<S::Error>> {
    let lattice = checked(view, &[iso], options)?;
    let threshold = [view.scaling().threshold(iso)];
    let thresholds = Thresholds::new(&threshold).filter(|_| lattice.has_cells());
    let Some(thresholds) = thresholds else { return Ok(ControlFlow::Continue(0)) };
    let mut stops_at_nan = options.nan != Nan::Outside && !T::DTYPE.is_integer();
    if let Some(bricks) = bricks {
        if stops_at_nan && bricks.has_nan() {
            return Ok(ControlFlow::Continue(0));
        }
        stops_at_nan = false;
    }
    let choice = bricks.map(|bricks| Choice::new(bricks, &threshold, lattice));
    let sweep = Sweep {
        signs: Signs { view: *view, lattice, thresholds, stops_at_nan },
        choice: choice.as_ref(),
        values: Values::new(*view, iso, lattice.guard).at_hand(),
        decides: options.topology == Topology::Trilinear,
        placer: Placer::new(*view, iso, margin, 0.0).with_options(options),
        winding: Winding::of(view.frame()),
        cases,
    };
    let mut likely = sweep.likely((precision, sink.wants_normals()), job);
    if options.nan == Nan::Mask && sweep.signs.stops_at_nan {
        // All would be done again.
        likely = Counts::default();
    }
    let room = if sweep.is_allowed(job) { sink.spare(likely, precision) } else { None };
    let Some(room) = room else { return Ok(ControlFlow::Continue(0)) };
    let slices = view.dims()[2] as u64;
    job.progress.begin("extract", slices * (1 + u64::from(cases.is_some())));
    let (counts, singular_cells) = match sweep.run(room, job).map_err(ExtractError::from)? {
        Swept::Whole { counts, singular_cells } => (counts, singular_cells),
        Swept::Part { filled } => {
            if filled == 0 {
                cases.into_iter().for_each(Cases::clear); // everything is done again
            }
            return Ok(ControlFlow::Continue(filled));
        }
    };
    // The memory is there.
    job.limits.allow("surface", surface_bytes(counts, precision, (sink, cases)), 1)?;
    sink.piece(counts, precision).map_err(ExtractError::Sink)?;
    if let Some(cases) = cases {
        cases.fit(sink, &view.grid(), job)?;
    }
    let samples_read = view.dims().iter().map(|&n| n as u64).product();
    let all = Skipped { samples_read, ..Skipped::default() };
    let skipped = choice.map_or(all, |choice| choice.skipped);
    Ok(ControlFlow::Break(Extracted { counts, precision, margin, singular_cells, skipped }))
}

/// What a surface takes, with the cases of its cells where they are kept; none if that does not fit 64 bits.
pub(crate) fn surface_bytes<S: MeshSink>(
    counts: Counts,
    precision: Precision,
    (sink, cases): (&S, Option<&Cases>),
) -> Option<u64> {
    // A cell whose case is kept has a triangle.
    let of_cases = if cases.is_some() { counts.triangles } else { 0 };
    counts.bytes(precision, sink.wants_normals())?.checked_add(of_cases)
}

/// How many vertices and triangles the surfaces of several values have, with one pass over the samples.
///
/// # Errors
///
/// As [`extract`].
pub fn count_many<'a, T: Sample>(
    samples: impl Into<Source<'a, T>>,
    isos: &[f64],
    options: &ExtractOptions,
    job: &Job,
) -> Result<Vec<Counts>, ExtractError> {
    let source: Source<'_, T> = samples.into();
    on_threads(job, || {
        if source.bricks.is_none()
            && options.topology == Topology::Table
            && let Some(counts) = tallied(&source.view, isos, options, job)?
        {
            return Ok(counts);
        }
        let (planes, _) = classified(&source, isos, 1, options, job)?;
        let count = |(mut planes, &iso): (Planes, &f64)| {
            let values = Values::new(source.view, iso, planes.lattice.guard);
            let layout = layout(&mut planes, &values, options, job)?;
            Ok(layout.as_ref().map_or(Counts::default(), Layout::counts))
        };
        planes.into_iter().zip(isos).map(count).collect()
    })
}

/// Runs `work` on the threads of a job, which may be set otherwise than the caller's.
pub(crate) fn on_threads<R: Send>(job: &Job, work: impl FnOnce() -> R + Send) -> R {
    job.threads.run(|| exactly(work))
}

/// The counts by the short way, where no sample is NaN or that does not matter.
fn tallied<T: Sample>(
    view: &View<'_, T>,
    isos: &[f64],
    options: &ExtractOptions,
    job: &Job,
) -> Result<Option<Vec<Counts>>, ExtractError> {
    let lattice = checked(view, isos, options)?;
    let stops_at_nan = options.nan != Nan::Outside && !T::DTYPE.is_integer();
    if !lattice.has_cells() {
        return Ok(None);
    }
    job.progress.begin("count", lattice.points[2] as u64);
    let Some(tally) = Tally::of(*view, lattice, isos, stops_at_nan, job)? else {
        return Ok(None);
    };
    let count = |whole: Whole| check_size(whole.counts, whole.widest).map(|()| whole.counts);
    tally.into_iter().map(count).collect::<Result<_, _>>().map(Some)
}

/// How often a surface is gone through once the signs are known: counted, filled, and looked at again to fit its diagonals.
pub(crate) fn passes(options: &ExtractOptions) -> u64 {
    2 + u64::from(options.diagonals == Diagonals::Fitted)
}

/// The planes of all isovalues, once it is known that there may be surfaces, each of which is gone through `passes` times.
fn classified<T: Sample, E: Send>(
    source: &Source<'_, T>,
    isos: &[f64],
    passes: u64,
    options: &ExtractOptions,
    job: &Job,
) -> Result<(Vec<Planes>, Skipped), ExtractError<E>> {
    let view = &source.view;
    let lattice = checked(view, isos, options)?;
    // Each pass goes through all slices once.
    let passes = 1 + passes * isos.len() as u64;
    job.progress.begin("extract", passes * view.dims()[2] as u64);
    Planes::classify(source, lattice, isos, options.nan, job)
}

/// The lattice, once it is known that it can be numbered.
fn checked<T: Sample, E>(
    view: &View<'_, T>,
    isos: &[f64],
    options: &ExtractOptions,
) -> Result<Lattice, ExtractError<E>> {
    if let Some(&iso) = isos.iter().find(|iso| !iso.is_finite()) {
        return Err(ExtractError::Iso(iso));
    }
    let lattice = Lattice::new(view.dims(), options.boundary);
    match lattice.points.iter().position(|&n| n > i32::MAX as usize) {
        Some(axis) => Err(ExtractError::TooLong { axis, size: view.dims()[axis] }),
        None => Ok(lattice),
    }
}

/// The numbers of all vertices and triangles; none where there can be none.
fn layout<T: Sample, E: Send>(
    planes: &mut Planes,
    values: &Values<'_, T>,
    options: &ExtractOptions,
    job: &Job,
) -> Result<Option<Layout>, ExtractError<E>> {
    if planes.is_empty() || !planes.lattice.has_cells() {
        job.progress.advance(planes.lattice.sampled(&(0..planes.lattice.points[2])));
        return Ok(None);
    }
    let values = (options.topology == Topology::Trilinear).then_some(values);
    Layout::new(planes, values, options.layers_per_task.get(), job).map(Some)
}

/// What the caller chose, or f32 while it is exact enough, and the margin that then keeps vertices apart.
pub(crate) fn precision<E>(
    grid: &Grid,
    options: &ExtractOptions,
) -> Result<(Precision, f64), ExtractError<E>> {
    /// What vertices keep from samples wherever rounding allows it.
    const USUAL: f64 = 1.0 / 1024.0;
    /// More would show.
    const GREATEST: f64 = 1.0 / 16.0;
    let affine = grid.frame.index_to_world;
    let mut bounds = grid.bounds();
    if options.boundary == Boundary::Closed {
        let reach = affine.spacing().iter().sum::<f64>() * GREATEST;
        bounds = bounds.with(bounds.min.map(|c| c - reach)).with(bounds.max.map(|c| c + reach));
    }
    // Four steps of the coordinate's type at the outermost place, in the shortest edge lengths. Not a
    // number if the type does not reach so far.
    let (reach, stretch) = (bounds.reach(), affine.least_stretch());
    let needed = |precision| {
        4.0 / stretch
            * match precision {
                Precision::F32 => f64::from((reach as f32).next_up()) - f64::from(reach as f32),
                Precision::F64 => reach.next_up() - reach,
            }
    };
    let fits = |precision| needed(precision) <= GREATEST;
    let precision = options.precision.unwrap_or(match fits(Precision::F32) {
        true => Precision::F32,
        false => Precision::F64,
    });
    // What f32 cannot hold is the caller's wish if he chose it, as long as it holds anything.
    if !fits(Precision::F64) || !needed(precision).is_finite() {
        return Err(ExtractError::TooFar { reach, spacing: stretch });
    }
    let margin = match options.degenerate {
        Degenerate::Exact => 0.0,
        Degenerate::Never => needed(precision).clamp(USUAL, GREATEST),
    };
    Ok((precision, margin))
}

#[cfg(test)]
mod tests;
