//! The entry: volume, value, options, sink.

use crate::{
    Boundary, Degenerate, ExtractError, ExtractOptions,
    fill::{Fill, Winding},
    layout::Layout,
    planes::{Lattice, Planes},
    vertex::Placement,
};
use isokit_job::Job;
use isokit_mesh::{Counts, MeshSink, Precision, TriMesh};
use isokit_volume::{Grid, Sample, View};

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
}

/// The surface where the value is `iso`, with gradient normals, in memory.
///
/// # Errors
///
/// If `iso` is not finite, the volume has NaN and the options forbid it, the surface has 2³² vertices or
/// more, an axis 2³¹ samples or so, or the job was cancelled or would take more memory than it may.
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
/// that uses the memory of a mesh again.
///
/// # Errors
///
/// As [`extract`], and if the sink has no room.
pub fn extract_into<T: Sample, S: MeshSink<Error: Send> + Send>(
    view: &View<'_, T>,
    iso: f64,
    options: &ExtractOptions,
    sink: &mut S,
    job: &Job,
) -> Result<Extracted, ExtractError<S::Error>> {
    let lattice = Lattice::new(view.dims(), options.boundary);
    let (precision, margin) = precision(&view.grid(), options);
    job.threads.run(|| {
        let plan = Plan::new(view, lattice, iso, options, job)?;
        let counts = plan.counts();
        let bytes = output_bytes(counts, precision, sink.wants_normals());
        job.limits.probe("surface", bytes, 1)?;
        let piece = sink.piece(counts, precision).map_err(ExtractError::Sink)?;
        if let Some(layout) = &plan.layout {
            let placement = Placement::new(*view, iso, margin, 0.0);
            let fill = Fill { planes: &plan.planes, layout, placement, winding: plan.winding };
            let slices = 0..lattice.points[2];
            fill.piece(slices, piece, options.layers_per_task.get(), job)?;
        }
        Ok(Extracted { counts, precision, margin })
    })
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
    let lattice = Lattice::new(view.dims(), options.boundary);
    job.threads.run(|| Ok(Plan::new(view, lattice, iso, options, job)?.counts()))
}

/// A surface that is counted and numbered but not yet made. No layout where there can be none.
struct Plan {
    planes: Planes,
    layout: Option<Layout>,
    winding: Winding,
}

impl Plan {
    fn new<T: Sample, E: Send>(
        view: &View<'_, T>,
        lattice: Lattice,
        iso: f64,
        options: &ExtractOptions,
        job: &Job,
    ) -> Result<Self, ExtractError<E>> {
        if !iso.is_finite() {
            return Err(ExtractError::Iso(iso));
        }
        if let Some(axis) = lattice.points.iter().position(|&n| n > i32::MAX as usize) {
            return Err(ExtractError::TooLong { axis, size: view.dims()[axis] });
        }
        // Classify, count and fill each go through all slices once.
        job.progress.begin("extract", 3 * view.dims()[2] as u64);
        let planes = Planes::classify(view, lattice, iso, options.nan, job)?;
        let layout = match planes.is_empty() || !lattice.has_cells() {
            true => None,
            false => Some(Layout::new(&planes, options.layers_per_task.get(), job)?),
        };
        Ok(Self { planes, layout, winding: Winding::of(view.frame()) })
    }

    fn counts(&self) -> Counts {
        self.layout.as_ref().map_or(Counts::default(), Layout::counts)
    }
}

/// What the caller chose, or f32 while it is exact enough, and the margin that then keeps vertices apart.
pub(crate) fn precision(grid: &Grid, options: &ExtractOptions) -> (Precision, f64) {
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
    // Four steps of the coordinate's type at the outermost place, in the shortest edge lengths.
    let needed = 4.0 * step_of_f32(bounds.reach()) / affine.least_stretch();
    let fits = needed <= GREATEST;
    let precision = options.precision.unwrap_or(match fits {
        true => Precision::F32,
        false => Precision::F64,
    });
    let margin = match (options.degenerate, precision) {
        (Degenerate::Exact, _) => 0.0,
        (_, Precision::F64) => USUAL,
        (_, Precision::F32) => needed.clamp(USUAL, GREATEST),
    };
    (precision, margin)
}

/// The distance from `value`, which is not negative, to the next f32 above it.
fn step_of_f32(value: f64) -> f64 {
    let value = value as f32;
    f64::from(value.next_up()) - f64::from(value)
}

/// What so many vertices and triangles take. `None` if that cannot be counted.
pub(crate) fn output_bytes(counts: Counts, precision: Precision, normals: bool) -> Option<u64> {
    let position = match precision {
        Precision::F32 => 12,
        Precision::F64 => 24,
    };
    let vertex = position + if normals { 12 } else { 0 };
    counts.vertices.checked_mul(vertex)?.checked_add(counts.triangles.checked_mul(12)?)
}

#[cfg(test)]
mod tests;
