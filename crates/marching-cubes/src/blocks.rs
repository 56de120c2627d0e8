//! A surface of samples that are made where it may be, and nowhere else: what it costs is proportional to the
//! surface, not to the volume.
//!
//! A *block* is 8 × 8 × 8 samples. What is known of boxes of samples says of most blocks that they lie on one side,
//! first of large boxes, then of their eighths (`seek`; Duff 1992, "Interval arithmetic and recursive subdivision for implicit functions
//! and constructive solid geometry"). The samples of all others are made. Where cells are crossed, the blocks that
//! vertices and normals look at are made too (`crossed`). Then a window of slices goes over the volume as in [`slabs`](crate::slabs), in which
//! these blocks are laid out; between them is anything (`window`). Nobody looks there, so the surface is that of
//! all samples, to the last bit.

mod crossed;
mod layer;
mod seek;
#[cfg(test)]
mod tests;
mod window;

use crate::{
    Budget, ExtractError, ExtractOptions, Extracted, Nan, Skipped, Slabs,
    diagonals::Cases,
    extract::{on_threads, passes, precision},
    slabs::{Held, Making, Surface, check},
};
use isokit_job::Job;
use isokit_lanes::exactly;
use isokit_mesh::MeshSink;
use isokit_volume::{Sample, SampleSource};
use layer::BlockGrid;
use seek::Seek;
use window::Window;

/// The surface where the value is `iso` of samples that are made where it may be, handed to a sink in pieces: byte for byte the
/// one that [`extract_into`](crate::extract_into) makes of all samples.
///
/// With [`Nan::Error`] the samples that are NaN are counted where they are, which the source says.
///
/// # Errors
///
/// As [`extract_into`](crate::extract_into).
pub fn extract_sparse<T: Sample, S: MeshSink<Error: Send> + Send>(
    source: &dyn SampleSource<T>,
    iso: f64,
    options: &ExtractOptions,
    sink: &mut S,
    job: &Job,
) -> Result<Extracted, ExtractError<S::Error>> {
    let (grid, isos) = (source.grid(), &[iso]);
    let budget = Budget { window: 0, piece_bytes: u64::MAX };
    let slabs = Slabs { isos, options, budget };
    check(&grid, &slabs)?;
    let precision = exactly(|| precision(&grid, options))?;
    let making = Making { slabs: &slabs, precision, job };
    let blocks = BlockGrid::new(grid.dims(), job)?;
    let seek = Seek::new(source, blocks, iso, options.nan, job);
    let mut window = Window::new(seek, grid.frame, options)?;
    let mut surface = Surface::new(iso, Cases::wanted(options, sink)?);
    let layers = blocks.counts[2];
    job.progress.begin("extract", (1 + passes(options)) * grid.dims()[2]);
    for first in (0..layers).step_by(window.layers_together()) {
        let own = first..layers.min(first + window.layers_together());
        on_threads(job, || {
            window.advance(&own)?;
            if window.nan.count > 0 && options.nan == Nan::Error {
                return Ok(()); // only to count them
            }
            let Some(mut planes) = window.planes(&own)? else { return Ok(()) };
            let held: Held<'_, T> = window.held(&own, planes.lattice);
            making.part(&held, &mut planes, &mut surface, sink)
        })?;
    }
    if let (Some(first), Nan::Error) = (window.nan.first, options.nan) {
        return Err(ExtractError::Nan { count: window.nan.count, first });
    }
    let Surface { counts, singular_cells, is_begun, is_too_large, cases, .. } = surface;
    if is_too_large {
        return Err(ExtractError::TooLarge {
            vertices: counts.vertices,
            triangles: counts.triangles,
        });
    }
    let (precision, margin) = making.precision;
    if !is_begun {
        sink.piece(counts, precision).map_err(ExtractError::Sink)?;
    }
    if let Some(cases) = cases {
        on_threads(job, || cases.fit(sink, &grid, job))?;
    }
    let all: u64 = blocks.counts.iter().map(|&n| n as u64).product();
    let skipped = Skipped {
        bricks: all,
        bricks_skipped: all - window.blocks_made,
        samples_read: window.samples_made,
    };
    Ok(Extracted { counts, precision, margin, singular_cells, skipped })
}
