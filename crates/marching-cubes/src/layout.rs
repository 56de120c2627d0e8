//! How much each row makes, and where it puts it.
//!
//! Vertices are numbered slice by slice: those on the edges along x and y of a slice, row by row, then
//! those on the edges along z to the next slice, row by row. Triangles are numbered row by row. Both
//! orders are those of a reader who sees one slice after another, so a volume that streams by gives the
//! same numbers as one in memory.

use crate::{
    ExtractError,
    case::COUNTS,
    planes::{Lattice, Planes},
    row::{LiveCells, Word},
};
use isokit_job::{Cancelled, Job};
use isokit_mesh::Counts;
use rayon::prelude::*;

/// What one row of lattice points owns. First its counts; then, in their place, the number of the
/// first of each. Triangles are numbered from the slice's first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Row {
    /// Vertices on edges along x.
    pub(crate) x: u32,
    /// Vertices on edges along y, to the next row.
    pub(crate) y: u32,
    /// Vertices on edges along z, to the next slice.
    pub(crate) z: u32,
    /// Triangles of the cells that start at the row.
    pub(crate) triangles: u32,
}

/// The number of the first vertex and triangle of every slice and row.
#[derive(Debug)]
pub(crate) struct Layout {
    pub(crate) rows: Vec<Row>,
    /// One more than there are slices: the last holds the totals.
    pub(crate) slices: Vec<Counts>,
    pub(crate) live: Option<LiveCells>,
}

impl Layout {
    /// Counts, then sums.
    pub(crate) fn new<E: Send>(
        planes: &Planes,
        layers_per_task: usize,
        job: &Job,
    ) -> Result<Self, ExtractError<E>> {
        let lattice = planes.lattice;
        let [_, ny, _] = lattice.points;
        let live = planes.missing.as_ref().map(|missing| LiveCells::new(lattice, missing));
        let mut rows: Vec<Row> = job.limits.zeroed("rows", lattice.rows())?;
        let tasks = rows.par_chunks_mut(ny.saturating_mul(layers_per_task)).enumerate();
        let counted = tasks.map(|(task, slab)| {
            job.check()?;
            let slices = slab.chunks_exact_mut(ny).enumerate();
            let counts = slices.map(|(n, slice)| {
                let z = task * layers_per_task + n;
                job.progress.advance(1);
                count_slice(planes, live.as_ref(), z, slice)
            });
            Ok(counts.collect::<Vec<Counts>>())
        });
        let counted = counted.collect::<Result<Vec<_>, Cancelled>>()?.concat();
        let slices = running_sum(&counted);
        let whole = slices[counted.len()];
        let widest = counted.iter().map(|slice| slice.triangles).max().unwrap_or(0);
        if whole.vertices > u32::MAX.into() || widest > u32::MAX.into() {
            let Counts { vertices, triangles } = whole;
            return Err(ExtractError::TooLarge { vertices, triangles });
        }
        let slices_of_rows = rows.par_chunks_exact_mut(ny).zip(&slices);
        // No number exceeds the total, which fits.
        slices_of_rows.for_each(|(slice, first)| number_rows(slice, first.vertices as u32));
        Ok(Self { rows, slices, live })
    }

    /// Vertices and triangles of the whole surface.
    pub(crate) fn counts(&self) -> Counts {
        self.slices[self.slices.len() - 1]
    }

    /// The record of a row.
    #[inline(always)]
    pub(crate) fn row(&self, lattice: Lattice, y: usize, z: usize) -> Row {
        self.rows[y + lattice.points[1] * z]
    }
}

/// Calls `each(w, word)` for every word of the cells that start in row `y`, `z` and of the edges that the
/// row owns. Beyond the last row or slice the row itself stands in, so that no edge leads there.
#[inline(always)]
pub(crate) fn words_of_row(
    planes: &Planes,
    live: Option<&LiveCells>,
    [y, z]: [usize; 2],
    mut each: impl FnMut(usize, &Word),
) {
    let Lattice { points: [_, ny, nz], words, .. } = planes.lattice;
    let (next_y, next_z) = ((y + 1).min(ny - 1), (z + 1).min(nz - 1));
    let rows = [(y, z), (next_y, z), (y, next_z), (next_y, next_z)];
    let rows = rows.map(|(y, z)| planes.inside.row(y, z));
    let has_cells = next_y > y && next_z > z;
    for w in 0..words {
        let mut word = Word::new(rows, w, planes.lattice.cells(w));
        if !has_cells {
            word.active = 0;
        }
        if word.is_blank() {
            continue;
        }
        if let Some(live) = live {
            word.keep(live, [y, z], w);
        }
        each(w, &word);
    }
}

fn count_slice(planes: &Planes, live: Option<&LiveCells>, z: usize, slice: &mut [Row]) -> Counts {
    let mut counts = Counts::default();
    for (y, row) in slice.iter_mut().enumerate() {
        words_of_row(planes, live, [y, z], |_, word| {
            row.x += word.x[0].count_ones();
            row.y += word.y[0].count_ones();
            row.z += word.z[0].count_ones();
            let mut active = word.active;
            while active != 0 {
                row.triangles += u32::from(COUNTS[word.case(active.trailing_zeros())]);
                active &= active - 1;
            }
        });
        counts.vertices += u64::from(row.x) + u64::from(row.y) + u64::from(row.z);
        counts.triangles += u64::from(row.triangles);
    }
    counts
}

/// What lies before each slice, and after the last.
fn running_sum(slices: &[Counts]) -> Vec<Counts> {
    let mut sum = Counts::default();
    let mut sums = vec![sum];
    for slice in slices {
        sum.vertices += slice.vertices;
        sum.triangles += slice.triangles;
        sums.push(sum);
    }
    sums
}

/// Replaces the counts of a slice's rows by the numbers of their first.
fn number_rows(slice: &mut [Row], first: u32) {
    let (mut vertex, mut triangle) = (first, 0);
    let mut next = |count: &mut u32| {
        let own = vertex;
        // After the last vertex of all this may be one beyond what fits; it names none then.
        vertex = vertex.wrapping_add(*count);
        *count = own;
    };
    for row in &mut *slice {
        next(&mut row.x);
        next(&mut row.y);
    }
    for row in slice {
        next(&mut row.z);
        (row.triangles, triangle) = (triangle, triangle + row.triangles);
    }
}
