//! All passes at once, over a few slices at a time while their samples are in the cache.
//!
//! Where the surface goes into memory that was used before, or into more new memory than it is likely to take, it
//! is not needed to know how large it is before the first vertex is written. Slabs of slices are begun in their
//! order. Each is classified and counted, waits until the slab before it knows how much that makes, takes its part of
//! the memory, and fills it. Samples around the surface are so read from the cache, where the passes one after another
//! (`planes`, `layout`, `fill`) read them from memory a second time. Numbers and bits are theirs.
//!
//! Where bricks tell what is looked at, slabs of which nothing is are left out, and those after them begin with zeros.
//!
//! The vertices and triangles between two slabs are the second's, which takes a copy of the last slice of bits of
//! the first. If the memory does not suffice, the passes do the rest; if a sample is NaN and that matters,
//! everything.

use crate::{
    diagonals::Cases,
    fill::{Fill, Rest, Scratch, are_large, in_large_pages},
    layout::{Layout, Row, check_size},
    planes::{Lattice, Planes, Signs},
    sparse::{Choice, Visits},
    trilinear::Values,
    vertex::Placer,
    winding::Winding,
};
use isokit_job::{Cancelled, Job, Turns};
use isokit_lanes::{Coordinate, Word, exactly};
use isokit_mesh::{Counts, Piece, PositionsMut, Precision};
use isokit_volume::{BrickGrid, Sample};
use std::{
    ops::Range,
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

/// What there is to extract.
pub(crate) struct Sweep<'a, T> {
    /// By one threshold.
    pub(crate) signs: Signs<'a, T>,
    /// What is looked at, where that is not everything.
    pub(crate) choice: Option<&'a Choice>,
    pub(crate) values: Values<'a, T>,
    /// Whether the values decide what the signs leave open.
    pub(crate) decides: bool,
    pub(crate) placer: Placer<'a, T>,
    pub(crate) winding: Winding,
    pub(crate) cases: Option<&'a Cases>,
}

/// How far it came.
pub(crate) enum Swept {
    /// All is filled.
    Whole { counts: Counts, singular_cells: u64 },
    /// The slices up to this one are filled.
    Part { filled: usize },
}

/// Bytes of samples in a slab: with those that the next one looks at they stay in a cache of 2 MiB.
const SLAB: usize = 1 << 20;

/// Slices in a slab, even if they are larger, where that leaves slabs enough for all threads: the last one is counted
/// by the next slab too. Spheres in f32 of 512³ and 1024³ take a twentieth less time (EPYC, one thread, November 2026).
const SLICES: usize = 2;

/// The same where they are filled in bands. What is left of a slab in the cache counts for less then: a gyroid in f32 of
/// 1024² samples a slice takes 0.92 of the time with eight, a sphere as long (EPYC of 2021, November 2026).
const LARGE_SLICES: usize = 8;

/// Samples of which a surface in new memory is worth a sweep. Fewer are in the cache for each of the passes.
const MANY: u64 = 1 << 19;

/// Slabs per thread at the least.
const SLABS: usize = 8;

/// What threads hand to each other.
struct Shared<'a, C> {
    turns: Turns,
    /// The bits of the last slice of each slab that is looked at, on their way to the next.
    ends: Vec<Mutex<Option<Vec<u64>>>>,
    left: Mutex<Left<'a, C>>,
    has_nan: AtomicBool,
}

/// The memory that is left, and what is before it.
struct Left<'a, C> {
    rest: Rest<'a, C>,
    before: Counts,
    singular_cells: u64,
    /// Slices up to this one have got theirs.
    filled: usize,
}

/// What a thread needs for its slabs.
struct Own<T> {
    planes: Planes,
    layout: Layout,
    words: Vec<Word>,
    samples: Vec<T>,
    scratch: Scratch,
}

impl<T: Sample> Sweep<'_, T> {
    /// Fills `room` as far as it goes.
    pub(crate) fn run(&self, room: Piece<'_>, job: &Job) -> Result<Swept, Cancelled> {
        let Piece { positions, normals, triangles } = in_large_pages(room);
        match positions {
            PositionsMut::F32(positions) => self.slabs(Rest { positions, normals, triangles }, job),
            PositionsMut::F64(positions) => self.slabs(Rest { positions, normals, triangles }, job),
        }
    }

    /// Whether what threads need for their slabs is allowed. The rows of a slice may take more than its samples.
    pub(crate) fn is_allowed(&self, job: &Job) -> bool {
        let [slabs, per_slab] = self.size(job);
        let threads = slabs.min(job.threads.count()) as u64;
        let row = (self.signs.lattice.words * size_of::<u64>() + size_of::<Row>()) as u64;
        // A slab has the slices below it and above it too.
        let rows = (self.signs.lattice.points[1] as u64).checked_mul(per_slab as u64 + 2);
        let bytes = rows.and_then(|rows| rows.checked_mul(row));
        let bytes = bytes.and_then(|bytes| bytes.checked_mul(threads));
        job.limits.probe("slabs", bytes, 1).is_ok()
    }

    /// Vertices and triangles that few surfaces exceed: those of noise do. So much new memory costs nothing where it
    /// is not written, if the system gives pages at their first touch, and the allocator has none to clear: glibc
    /// has no list of 32 MiB and more. Nothing elsewhere, or if twice as much is not allowed and there, or if the
    /// samples stay in the cache for the passes.
    pub(crate) fn likely(&self, (precision, has_normals): (Precision, bool), job: &Job) -> Counts {
        let samples = self.signs.view.dims().iter().map(|&n| n as u64).product::<u64>();
        let ample = samples.max(1 << 24);
        let likely = Counts { vertices: ample / 4, triangles: ample / 2 };
        let bytes = likely.bytes(precision, has_normals);
        let gives_pages = cfg!(all(target_os = "linux", target_pointer_width = "64"));
        match gives_pages && samples >= MANY && job.limits.probe("surface", bytes, 2).is_ok() {
            true => likely,
            false => Counts::default(),
        }
    }

    /// How many slabs there are, and the slices of samples in each but the last.
    fn size(&self, job: &Job) -> [usize; 2] {
        let [nx, ny, slices] = self.signs.view.dims();
        let fit = SLAB / (nx * ny * size_of::<T>());
        let least = match (self.choice, are_large::<T>([nx, ny])) {
            (Some(_), _) => BrickGrid::CELLS[2], // they are left out by layers of bricks
            (None, true) => LARGE_SLICES,
            (None, false) => SLICES,
        };
        let per_slab = fit.max(least).min(slices / (job.threads.count() * SLABS)).max(1);
        [slices.div_ceil(per_slab), per_slab]
    }

    fn slabs<C: Coordinate>(&self, rest: Rest<'_, C>, job: &Job) -> Result<Swept, Cancelled> {
        job.check()?;
        let threads = job.threads.count();
        let slabs = self.looked_at(job);
        let mut ends: Vec<Mutex<Option<Vec<u64>>>> = vec![];
        ends.resize_with(slabs.len(), Mutex::default);
        let shared = Shared {
            turns: Turns::default(),
            ends,
            left: Mutex::new(Left {
                rest,
                before: Counts::default(),
                singular_cells: 0,
                filled: 0,
            }),
            has_nan: AtomicBool::new(false),
        };
        let all: usize = slabs.iter().map(Range::len).sum();
        job.progress.advance((self.signs.view.dims()[2] - all) as u64);
        let slab = |own: &mut Own<T>, n: usize| {
            job.check()?;
            job.progress.advance(slabs[n].len() as u64);
            let is_next = n > 0 && slabs[n - 1].end == slabs[n].start;
            exactly(|| self.slab((n, is_next), slabs[n].clone(), own, &shared));
            Ok(())
        };
        let visits = self.choice.map(|choice| &choice.visits[0]);
        shared.turns.run(slabs.len(), threads, || Own::new(self.signs.lattice, visits), slab)?;
        let left = shared.left.into_inner().unwrap_or_else(PoisonError::into_inner);
        let Left { before: counts, singular_cells, filled, .. } = left;
        Ok(match (shared.has_nan.into_inner(), shared.turns.is_over()) {
            (true, _) => Swept::Part { filled: 0 },
            (false, true) => Swept::Part { filled },
            (false, false) => Swept::Whole { counts, singular_cells },
        })
    }

    /// The slices of samples of each slab that is looked at.
    fn looked_at(&self, job: &Job) -> Vec<Range<usize>> {
        let (slices, [slabs, per_slab]) = (self.signs.view.dims()[2], self.size(job));
        let all = (0..slabs).map(|n| n * per_slab..slices.min((n + 1) * per_slab));
        all.filter(|slab| self.choice.is_none_or(|choice| choice.needs(slab))).collect()
    }

    /// From the samples of the slab that is the `n`th to be looked at, next after the one before or not, to vertices and
    /// triangles; nothing if the sweep ends before.
    fn slab<C: Coordinate>(
        &self,
        (n, is_next): (usize, bool),
        samples: Range<usize>,
        own: &mut Own<T>,
        shared: &Shared<'_, C>,
    ) -> Option<()> {
        let Lattice { points: [_, ny, nz], guard, .. } = self.signs.lattice;
        let slice_words = self.signs.lattice.slice_words();
        // The last slice of the slab before, where there is one, is this one's.
        let below = usize::from(samples.start > 0);
        let first = samples.start + guard - below;
        let window = own.planes.inside.window(first, below + samples.len());
        let (end_of_last, classified) = window.split_at_mut(below * slice_words);
        if !self.classify(samples.clone(), classified, &mut own.samples) {
            shared.has_nan.store(true, Ordering::Relaxed);
            shared.turns.end();
            return None;
        }
        let mut handed = vec![];
        if is_next {
            handed = shared.turns.until(|| lock(&shared.ends[n - 1]).take())?;
            end_of_last.copy_from_slice(&handed);
            handed.clear();
        }
        handed.extend_from_slice(&classified[classified.len() - slice_words..]);
        *lock(&shared.ends[n]) = Some(handed);

        let is_last = samples.end == self.signs.view.dims()[2];
        let end = if is_last { nz } else { samples.end + guard - 1 };
        let slices = if below == 0 { 0 } else { first }..end;
        let values = self.decides.then_some(&self.values);
        own.layout.count_some(&own.planes, values, slices.clone(), &mut own.words);
        if !shared.turns.wait(n) {
            return None;
        }
        let taken = lock(&shared.left).take(&own.layout, end);
        let Some((room, before)) = taken else {
            shared.turns.end();
            return None;
        };
        shared.turns.pass();
        own.layout.number_from(before, ny);
        let (planes, layout) = (&own.planes, &own.layout);
        let Self { placer, values, winding, cases, .. } = *self;
        let fill = Fill { planes, layout, placer, values, winding, cases };
        fill.some(slices, room, &mut own.scratch);
        Some(())
    }

    /// The bits of some slices of samples, into zeros. False if there is a NaN that matters.
    fn classify(&self, slices: Range<usize>, bits: &mut [u64], scratch: &mut Vec<T>) -> bool {
        let words = self.signs.lattice.slice_words();
        let mut of_slices = slices.zip(bits.chunks_exact_mut(words));
        of_slices.all(|(k, bits)| match self.choice {
            None => self.signs.classify(k, (bits, words), scratch),
            Some(choice) => {
                self.signs.classify_chosen(k, choice, &mut [bits], scratch);
                true
            }
        })
    }
}

impl<T> Own<T> {
    fn new(lattice: Lattice, visits: Option<&Visits>) -> Self {
        Self {
            planes: Planes { visits: visits.cloned(), ..Planes::blank(lattice) },
            layout: Layout::empty(),
            words: vec![],
            samples: vec![],
            scratch: Scratch::default(),
        }
    }
}

impl<'a, C> Left<'a, C> {
    /// Takes room for the slices of a layout up to slice `end`, and says what is before. None if there is not
    /// enough, or more than can be numbered.
    fn take(&mut self, layout: &Layout, end: usize) -> Option<(Rest<'a, C>, Counts)> {
        let (before, counts) = (self.before, layout.sum());
        let after = Counts {
            vertices: before.vertices + counts.vertices,
            triangles: before.triangles + counts.triangles,
        };
        let is_numbered = check_size::<()>(after, layout.widest()).is_ok();
        if !is_numbered || !self.rest.holds(counts) {
            return None;
        }
        self.before = after;
        self.singular_cells += layout.singular_cells();
        self.filled = end;
        Some((self.rest.split_off(counts), before))
    }
}

/// A thread that panicked ends the sweep in any case.
fn lock<M>(mutex: &Mutex<M>) -> MutexGuard<'_, M> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
