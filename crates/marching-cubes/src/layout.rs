//! How much each row makes, and where it puts it.
//!
//! Vertices are numbered slice by slice: those on the edges along x and y of a slice, row by row, then
//! those on the edges along z to the next slice, row by row. Triangles are numbered row by row. What
//! special cells make follows, slice by slice: their interior vertices after the vertices on edges, their
//! triangles after those of the other cells. These orders are those of a reader who sees one slice after
//! another, so a volume that streams by gives the same numbers as one in memory.

use crate::{
    ExtractError,
    case::COUNTS,
    masked::LiveCells,
    planes::{Counted, Lattice, Planes},
    trilinear::{SpecialCells, Values},
};
use isokit_job::{Cancelled, Job, Work};
use isokit_lanes::{
    Word, count_flat_rows, count_rows, count_rows_with_open, count_words, exactly,
    open_words_of_rows, words_of_rows,
};
use isokit_mesh::Counts;
use isokit_volume::Sample;
use rayon::prelude::*;
use std::ops::Range;

/// What one row of lattice points owns. First its counts; then, in their place, the number of the
/// first of each. Triangles are numbered from the slice's first.
pub(crate) use isokit_lanes::RowCounts as Row;

/// Slices of the lattice, and what lies before the first of them.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) slices: Range<usize>,
    pub(crate) before: Counts,
}

/// The number of the first vertex and triangle of every slice and row.
#[derive(Debug)]
pub(crate) struct Layout {
    /// The slice that `rows`, `slices` and `special` begin with.
    first: usize,
    rows: Vec<Row>,
    /// One more than there are slices: the last holds the totals.
    slices: Vec<Counts>,
    live: Option<LiveCells>,
    /// Those of every slice; none where the cases settle everything.
    special: Vec<SpecialCells>,
}

impl Layout {
    /// Counts, then sums. With values, what the signs of a cell leave open is decided by them. What was
    /// counted on the way to the planes is taken from them.
    pub(crate) fn new<T: Sample, E: Send>(
        planes: &mut Planes,
        values: Option<&Values<'_, T>>,
        layers_per_task: usize,
        job: &Job,
    ) -> Result<Self, ExtractError<E>> {
        let part = Part { slices: 0..planes.lattice.points[2], before: Counts::default() };
        Self::part((planes, values), &part, layers_per_task, job)
    }

    /// The same for some slices. Of the slice after them, which their triangles look up to, only the
    /// vertices along x and y are counted.
    pub(crate) fn part<T: Sample, E: Send>(
        (planes, values): (&mut Planes, Option<&Values<'_, T>>),
        part: &Part,
        layers_per_task: usize,
        job: &Job,
    ) -> Result<Self, ExtractError<E>> {
        let lattice = planes.lattice;
        let [_, ny, _] = lattice.points;
        let Part { slices: own, before } = part;
        let Counted { mut rows, done } = match planes.counted.take() {
            Some(counted) => counted,
            None => Counted::none(lattice, job)?,
        };
        let live = planes.missing.as_ref().map(|missing| LiveCells::new(lattice, missing, job));
        let live = live.transpose()?;
        let counting = Counting { planes, live: live.as_ref() };
        let tasks = rows.par_chunks_mut(ny.saturating_mul(layers_per_task)).enumerate();
        let of_slab: Work<'_, _, _> = &|(task, slab): (usize, &mut [Row])| {
            job.check()?;
            let mut scratch = vec![];
            let slices = slab.chunks_exact_mut(ny).enumerate();
            let counts = slices.map(|(n, slice)| {
                let z = task * layers_per_task + n;
                if z < own.start || z > own.end {
                    return <_>::default();
                }
                if z == own.end {
                    counting.flat((z, done[z]), slice, &mut scratch);
                    return <_>::default();
                }
                let mut special = SpecialCells::default();
                let found = (&mut special, &mut scratch);
                exactly(|| counting.slice((z, done[z]), slice, values, found));
                let special = special.shrunk();
                job.progress.advance(lattice.sampled(&(z..z + 1)));
                (counts_of(slice, &special), special)
            });
            Ok(counts.collect::<Vec<_>>())
        };
        let counted = tasks.map(of_slab).collect::<Result<Vec<_>, Cancelled>>()?;
        let (counted, special): (Vec<_>, Vec<_>) = counted.into_iter().flatten().unzip();
        let slices = running_sum(*before, &counted);
        let widest = counted.iter().map(|slice| slice.triangles).max().unwrap_or(0);
        check_size(slices[counted.len()], widest)?;
        let slices_of_rows = rows.par_chunks_exact_mut(ny).zip(slices.par_windows(2)).enumerate();
        // No triangle names an edge of a slice without, unless it is that after the last own one. No number
        // exceeds the total, which fits.
        let number: Work<'_, _, _> = &|(z, (slice, ends)): (usize, (&mut [Row], &[Counts]))| {
            if ends[0] != ends[1] || z == own.end {
                number_rows(slice, ends[0].vertices as u32);
            }
        };
        slices_of_rows.for_each(number);
        Ok(Self { first: 0, rows, slices, live, special })
    }

    /// None yet.
    pub(crate) fn empty() -> Self {
        Self { first: 0, rows: vec![], slices: vec![], live: None, special: vec![] }
    }

    /// Counts some slices only, and of the one after them, which their triangles look up to, the vertices along
    /// x and y. They are to be numbered next.
    pub(crate) fn count_some<T: Sample>(
        &mut self,
        planes: &Planes,
        values: Option<&Values<'_, T>>,
        own: Range<usize>,
        scratch: &mut Vec<Word>,
    ) {
        let [_, ny, nz] = planes.lattice.points;
        let counting = Counting { planes, live: None };
        self.first = own.start;
        self.rows.clear();
        self.rows.resize(ny * (nz.min(own.end + 1) - own.start), Row::default());
        self.slices.clear();
        self.special.resize_with(own.len(), SpecialCells::default);
        for (z, slice) in (own.start..).zip(self.rows.chunks_exact_mut(ny)) {
            if z == own.end {
                counting.flat((z, false), slice, scratch);
                break;
            }
            let special = &mut self.special[z - own.start];
            special.clear();
            counting.slice((z, false), slice, values, (special, scratch));
            self.slices.push(counts_of(slice, special));
        }
    }

    /// What all slices make that were counted and are not numbered yet.
    pub(crate) fn sum(&self) -> Counts {
        self.slices.iter().fold(Counts::default(), |sum, slice| Counts {
            vertices: sum.vertices + slice.vertices,
            triangles: sum.triangles + slice.triangles,
        })
    }

    /// The most triangles that one of them has.
    pub(crate) fn widest(&self) -> u64 {
        self.slices.iter().map(|slice| slice.triangles).max().unwrap_or(0)
    }

    /// Numbers what was counted.
    pub(crate) fn number_from(&mut self, before: Counts, ny: usize) {
        self.slices = running_sum(before, &self.slices);
        for (slice, counts) in self.rows.chunks_exact_mut(ny).zip(&self.slices) {
            number_rows(slice, counts.vertices as u32);
        }
    }

    /// What lies before slice `z`; after the last slice, everything.
    #[inline(always)]
    pub(crate) fn before(&self, z: usize) -> Counts {
        self.slices[z - self.first]
    }

    /// The special cells of a slice.
    pub(crate) fn special(&self, z: usize) -> &SpecialCells {
        &self.special[z - self.first]
    }

    /// Cells in which a saddle that decides is exactly on the isovalue.
    pub(crate) fn singular_cells(&self) -> u64 {
        self.special.iter().map(|slice| slice.singular).sum()
    }

    /// The number of the first vertex of a slice that lies on no edge.
    #[inline(always)]
    pub(crate) fn first_inner(&self, z: usize) -> u32 {
        (self.before(z + 1).vertices - self.special(z).vertices) as u32
    }

    /// Vertices and triangles of the whole surface.
    pub(crate) fn counts(&self) -> Counts {
        self.slices[self.slices.len() - 1]
    }

    /// Whether some rows of a slice make nothing: what follows them begins where they begin.
    #[inline(always)]
    pub(crate) fn are_blank(&self, lattice: Lattice, rows: Range<usize>, z: usize) -> bool {
        let (own, first) = (self.row(lattice, rows.start, z), self.row(lattice, 0, z));
        let (before, end, special) = (self.before(z), self.before(z + 1), self.special(z));
        let next = match rows.end < lattice.points[1] {
            true => self.row(lattice, rows.end, z),
            false => Row {
                x: first.z,
                y: first.z,
                z: self.first_inner(z),
                triangles: (end.triangles - before.triangles - special.triangles) as u32,
            },
        };
        (own.x, own.z, own.triangles) == (next.x, next.z, next.triangles)
    }

    /// The words of some rows of a slice that hold a crossed cell or a cut edge of the row.
    pub(crate) fn words(&self, planes: &Planes, rows: Range<usize>, z: usize, out: &mut Vec<Word>) {
        words(planes, self.live.as_ref(), rows, z, out);
    }

    /// The record of a row.
    #[inline(always)]
    pub(crate) fn row(&self, lattice: Lattice, y: usize, z: usize) -> Row {
        self.rows[y + lattice.points[1] * (z - self.first)]
    }
}

/// The words of some rows of a slice that hold a crossed cell or a cut edge of the row.
fn words(
    planes: &Planes,
    live: Option<&LiveCells>,
    rows: Range<usize>,
    z: usize,
    out: &mut Vec<Word>,
) {
    let own = planes.rows_of_slice(z);
    let rows = rows.start.max(own.start)..rows.end.min(own.end);
    if rows.is_empty() {
        return out.clear();
    }
    words_of_rows(&planes.inside.slices(z), rows, out);
    if let Some(live) = live {
        out.iter_mut().for_each(|word| live.restrict(word, z));
    }
}

/// Whether 32 bits number all vertices, and the triangles of each slice, of which there are at most `widest`.
pub(crate) fn check_size<E>(
    Counts { vertices, triangles }: Counts,
    widest: u64,
) -> Result<(), ExtractError<E>> {
    match vertices > u32::MAX.into() || widest > u32::MAX.into() {
        true => Err(ExtractError::TooLarge { vertices, triangles }),
        false => Ok(()),
    }
}

/// What slices are counted from.
struct Counting<'a> {
    planes: &'a Planes,
    live: Option<&'a LiveCells>,
}

impl Counting<'_> {
    /// Counts what the rows of slice `z` make, unless they are counted already. With values, finds the special
    /// cells, and takes their triangles from the rows.
    fn slice<T: Sample>(
        &self,
        (z, is_counted): (usize, bool),
        slice: &mut [Row],
        values: Option<&Values<'_, T>>,
        (special, scratch): (&mut SpecialCells, &mut Vec<Word>),
    ) {
        let rows = self.planes.rows_of_slice(z);
        if rows.is_empty() {
            return;
        }
        let bits = self.planes.inside.slices(z);
        let own = &mut slice[rows.clone()];
        match (self.live, is_counted, values) {
            (None, true, None) => {}
            (None, false, None) => count_rows(&bits, rows, own),
            (None, true, Some(_)) => open_words_of_rows(&bits, rows, scratch),
            (None, false, Some(_)) => count_rows_with_open(&bits, rows, own, scratch),
            // Such slices are never counted before.
            (Some(_), ..) => {
                words(self.planes, self.live, rows, z, scratch);
                count_words(scratch, slice);
                if values.is_some() {
                    scratch.iter_mut().for_each(|word| word.active = word.open());
                }
            }
        }
        if let Some(values) = values {
            special.look_at(values, (z, scratch), |row, case| {
                slice[row].triangles -= u32::from(COUNTS[usize::from(case)]);
            });
        }
    }

    /// Counts the vertices along x and y that the rows of slice `z` make, unless all is counted already.
    fn flat(&self, (z, is_counted): (usize, bool), slice: &mut [Row], scratch: &mut Vec<Word>) {
        let rows = self.planes.rows_of_slice(z);
        match (self.live, is_counted) {
            (None, true) => {}
            (None, false) => {
                let own = &mut slice[rows.clone()];
                return count_flat_rows(&self.planes.inside.slices(z), rows, own);
            }
            // Such slices are never counted before.
            (Some(_), _) => {
                words(self.planes, self.live, rows, z, scratch);
                count_words(scratch, slice);
            }
        }
        slice.iter_mut().for_each(|row| (row.z, row.triangles) = (0, 0));
    }
}

/// What rows and special cells make.
fn counts_of(slice: &[Row], special: &SpecialCells) -> Counts {
    let mut counts = Counts { vertices: special.vertices, triangles: special.triangles };
    for row in slice {
        counts.vertices += u64::from(row.x) + u64::from(row.y) + u64::from(row.z);
        counts.triangles += u64::from(row.triangles);
    }
    counts
}

/// What lies before each slice, and after the last.
fn running_sum(before: Counts, slices: &[Counts]) -> Vec<Counts> {
    let mut sum = before;
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
