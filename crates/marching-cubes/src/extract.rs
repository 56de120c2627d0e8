//! The entry: volume, value, options, sink.

use crate::{
    Boundary, Degenerate, ExtractError, ExtractOptions,
    layout::{Layout, words_of_row},
    planes::{Lattice, Planes},
    triangles::{self, Winding},
    vertex::{Coordinate, Placement},
};
use isokit_job::{Cancelled, Job};
use isokit_mesh::{Counts, MeshSink, Piece, PositionsMut, Precision, TriMesh};
use isokit_volume::{Sample, View};
use rayon::prelude::*;

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
/// more, or the job was cancelled or would take more memory than it may.
pub fn extract<T: Sample>(
    view: &View<'_, T>,
    iso: f64,
    options: &ExtractOptions,
    job: &Job,
) -> Result<TriMesh, ExtractError> {
    let mut mesh = TriMesh::with_normals();
    extract_into(view, iso, options, &mut mesh, job)?;
    Ok(mesh)
}

/// The surface where the value is `iso`, handed to a sink as one piece.
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
    let (precision, margin) = precision(view, options);
    job.threads.run(|| {
        let plan = Plan::new(view, lattice, iso, options, job)?;
        let counts = plan.counts();
        let bytes = output_bytes(counts, precision, sink.wants_normals());
        job.limits.probe("surface", bytes, 1)?;
        let piece = sink.piece(counts, precision).map_err(ExtractError::Sink)?;
        let placement = Placement::new(*view, lattice.guard, iso, margin);
        plan.fill(&placement, piece, options.layers_per_task.get(), job)?;
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
        // Classify, count and fill each go through all slices once.
        job.progress.begin("extract", 3 * view.dims()[2] as u64);
        let planes = Planes::classify(view, lattice, iso, options.nan, job)?;
        let layout = match planes.is_empty() || !lattice.has_cells() {
            true => None,
            false => Some(Layout::new(&planes, options.layers_per_task.get(), job)?),
        };
        let mirrors = view.frame().index_to_world.determinant() < 0.0;
        let winding = if mirrors { Winding::Turned } else { Winding::Kept };
        Ok(Self { planes, layout, winding })
    }

    fn counts(&self) -> Counts {
        self.layout.as_ref().map_or(Counts::default(), Layout::counts)
    }

    fn fill<T: Sample>(
        &self,
        placement: &Placement<'_, T>,
        piece: Piece<'_>,
        layers_per_task: usize,
        job: &Job,
    ) -> Result<(), Cancelled> {
        let Piece { positions, normals, triangles } = piece;
        match positions {
            PositionsMut::F32(positions) => {
                let out = Slab { positions, normals, triangles };
                self.fill_all(placement, out, layers_per_task, job)
            }
            PositionsMut::F64(positions) => {
                let out = Slab { positions, normals, triangles };
                self.fill_all(placement, out, layers_per_task, job)
            }
        }
    }

    fn fill_all<T: Sample, C: Coordinate>(
        &self,
        placement: &Placement<'_, T>,
        mut out: Slab<'_, C>,
        layers_per_task: usize,
        job: &Job,
    ) -> Result<(), Cancelled> {
        let Some(layout) = &self.layout else { return Ok(()) };
        let slices = self.planes.lattice.points[2];
        let mut tasks = vec![];
        for first in (0..slices).step_by(layers_per_task) {
            let end = slices.min(first.saturating_add(layers_per_task));
            let [before, after] = [layout.slices[first], layout.slices[end]];
            let vertices = (after.vertices - before.vertices) as usize;
            let triangles = (after.triangles - before.triangles) as usize;
            tasks.push((first..end, out.split_off(vertices, triangles)));
        }
        tasks.into_par_iter().try_for_each(|(slices, mut slab)| {
            job.check()?;
            for z in slices {
                self.fill_vertices(layout, placement, z, &mut slab);
                self.fill_triangles(layout, z, &mut slab);
                job.progress.advance(1);
            }
            Ok(())
        })
    }

    /// The vertices that a slice owns: those along x and y row by row, then those along z.
    fn fill_vertices<T: Sample, C: Coordinate>(
        &self,
        layout: &Layout,
        placement: &Placement<'_, T>,
        z: usize,
        slab: &mut Slab<'_, C>,
    ) {
        let [_, ny, _] = self.planes.lattice.points;
        let row = |y: usize| layout.row(self.planes.lattice, y, z);
        let (first_z, end) = (row(0).z, layout.slices[z + 1].vertices as u32);
        let mut in_slice = slab.split_off((first_z - row(0).x) as usize, 0);
        for y in 0..ny {
            let own = row(y);
            let (next_x, next_z) = match y + 1 < ny {
                true => (row(y + 1).x, row(y + 1).z),
                false => (first_z, end),
            };
            let mut along = [
                in_slice.split_off((own.y - own.x) as usize, 0),
                in_slice.split_off((next_x - own.y) as usize, 0),
                slab.split_off((next_z - own.z) as usize, 0),
            ];
            words_of_row(&self.planes, layout.live.as_ref(), [y, z], |w, word| {
                for (axis, mut cuts) in [word.x[0], word.y[0], word.z[0]].into_iter().enumerate() {
                    while cuts != 0 {
                        let x = 64 * w + cuts.trailing_zeros() as usize;
                        cuts &= cuts - 1;
                        along[axis].push(placement, &placement.cut(axis, [x, y, z]));
                    }
                }
            });
        }
    }

    fn fill_triangles<C>(&self, layout: &Layout, z: usize, slab: &mut Slab<'_, C>) {
        let [_, ny, nz] = self.planes.lattice.points;
        if z + 1 == nz {
            return;
        }
        for y in 0..ny - 1 {
            let out = std::mem::take(&mut slab.triangles);
            slab.triangles = triangles::fill_row(&self.planes, layout, [y, z], self.winding, out);
        }
    }
}

/// The part of the output that is still to be written.
struct Slab<'a, C> {
    positions: &'a mut [[C; 3]],
    normals: Option<&'a mut [[f32; 3]]>,
    triangles: &'a mut [[u32; 3]],
}

impl<'a, C: Coordinate> Slab<'a, C> {
    /// Takes the first so many vertices and triangles.
    fn split_off(&mut self, vertices: usize, triangles: usize) -> Slab<'a, C> {
        fn first<'a, T>(all: &mut &'a mut [T], count: usize) -> &'a mut [T] {
            let (first, rest) = std::mem::take(all).split_at_mut(count);
            *all = rest;
            first
        }
        Slab {
            positions: first(&mut self.positions, vertices),
            normals: self.normals.as_mut().map(|normals| first(normals, vertices)),
            triangles: first(&mut self.triangles, triangles),
        }
    }

    /// Writes the next vertex.
    #[inline(always)]
    fn push<T: Sample>(&mut self, placement: &Placement<'_, T>, cut: &crate::vertex::Cut) {
        if let Some(position) = self.positions.split_off_first_mut() {
            *position = placement.position(cut);
        }
        if let Some(normal) = self.normals.as_mut().and_then(|all| all.split_off_first_mut()) {
            *normal = placement.normal(cut);
        }
    }
}

/// What the caller chose, or f32 while it is exact enough, and the margin that then keeps vertices apart.
fn precision<T: Sample>(view: &View<'_, T>, options: &ExtractOptions) -> (Precision, f64) {
    /// What vertices keep from samples wherever rounding allows it.
    const USUAL: f64 = 1.0 / 1024.0;
    /// More would show.
    const GREATEST: f64 = 1.0 / 16.0;
    let mut bounds = view.grid().bounds();
    if options.boundary == Boundary::Closed {
        let reach = view.frame().index_to_world.spacing().iter().sum::<f64>() * GREATEST;
        bounds = bounds.with(bounds.min.map(|c| c - reach)).with(bounds.max.map(|c| c + reach));
    }
    let affine = view.frame().index_to_world;
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

fn output_bytes(counts: Counts, precision: Precision, normals: bool) -> Option<u64> {
    let position = match precision {
        Precision::F32 => 12,
        Precision::F64 => 24,
    };
    let vertex = position + if normals { 12 } else { 0 };
    counts.vertices.checked_mul(vertex)?.checked_add(counts.triangles.checked_mul(12)?)
}

#[cfg(test)]
mod tests;
