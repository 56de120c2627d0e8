//! Which lattice points are inside, one bit each.
//!
//! The *lattice* is the samples, and for a closed boundary one guard point beyond each end of each axis,
//! all of them outside. No volume is copied for that: a row is shifted by one bit, and the guard rows are
//! one row of zeros that all share. Bit `i % 64` of word `i / 64` is point `i`; bits beyond the last point
//! are 0.

use crate::{Boundary, ExtractError, Nan};
use isokit_job::{Cancelled, Job};
use isokit_lanes::{Threshold, nans, signs, words};
use isokit_volume::{Sample, View};
use rayon::prelude::*;

/// Sizes of the lattice, and where the samples are in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lattice {
    /// Points along x, y, z.
    pub(crate) points: [usize; 3],
    /// Lattice index of the first sample on each axis: 1 behind a guard, else 0.
    pub(crate) guard: usize,
    /// Words per row.
    pub(crate) words: usize,
}

impl Lattice {
    pub(crate) fn new(dims: [usize; 3], boundary: Boundary) -> Self {
        let guard = usize::from(boundary == Boundary::Closed);
        let points = dims.map(|n| n.saturating_add(2 * guard));
        Self { points, guard, words: words(points[0]) }
    }

    /// Whether there is a cell. Without one no triangle uses an edge, so no edge has a vertex.
    pub(crate) fn has_cells(&self) -> bool {
        self.points.iter().all(|&n| n > 1)
    }

    /// Rows of points.
    pub(crate) fn rows(&self) -> Option<u64> {
        (self.points[1] as u64).checked_mul(self.points[2] as u64)
    }

    /// The cells in word `w` of a row: every point but the last is the low corner of one.
    #[inline(always)]
    pub(crate) fn cells(&self, w: usize) -> u64 {
        match w + 1 == self.words {
            true => (1 << ((self.points[0] - 1) % 64)) - 1,
            false => u64::MAX,
        }
    }
}

/// One bit for every lattice point.
#[derive(Debug)]
pub(crate) struct Plane {
    lattice: Lattice,
    /// The rows that hold samples.
    bits: Vec<u64>,
    /// The row of every guard.
    zeros: Vec<u64>,
}

impl Plane {
    /// Row `y` of slice `z` of the lattice.
    #[inline(always)]
    pub(crate) fn row(&self, y: usize, z: usize) -> &[u64] {
        let Lattice { points, guard, words } = self.lattice;
        let (j, k) = (y.wrapping_sub(guard), z.wrapping_sub(guard));
        let (ny, nz) = (points[1] - 2 * guard, points[2] - 2 * guard);
        if j < ny && k < nz {
            let first = (j + ny * k) * words;
            &self.bits[first..first + words]
        } else {
            &self.zeros
        }
    }

    /// The four rows around the cells that start in row `y`, `z`: at (y, z) = 00, 10, 01, 11.
    #[inline(always)]
    pub(crate) fn rows(&self, y: usize, z: usize) -> [&[u64]; 4] {
        [(y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1)].map(|(y, z)| self.row(y, z))
    }
}

/// The planes of one extraction.
#[derive(Debug)]
pub(crate) struct Planes {
    pub(crate) lattice: Lattice,
    /// Which points are inside.
    pub(crate) inside: Plane,
    /// Which points have no value; only where those leave a border.
    pub(crate) missing: Option<Plane>,
}

/// NaN samples met in a task.
#[derive(Clone, Copy, Default)]
struct Found {
    count: u64,
    first: Option<[usize; 3]>,
}

impl Planes {
    /// Compares every sample once.
    pub(crate) fn classify<T: Sample, E: Send>(
        view: &View<'_, T>,
        lattice: Lattice,
        iso: f64,
        nan: Nan,
        job: &Job,
    ) -> Result<Self, ExtractError<E>> {
        let threshold = view.scaling().threshold::<T>(iso);
        let inside = |row: &[T], _, out: &mut [u64]| {
            signs(row, threshold, out);
            Found::default()
        };
        let missing = |row: &[T], [j, k]: [usize; 2], out: &mut [u64]| {
            nans(row, out);
            let count = out.iter().map(|word| u64::from(word.count_ones())).sum();
            let word = out.iter().position(|&word| word != 0);
            let first = word.map(|w| [64 * w + out[w].trailing_zeros() as usize, j, k]);
            Found { count, first }
        };
        let may_miss = nan != Nan::Outside && !T::DTYPE.is_integer();
        let missing = match may_miss {
            true => Some(plane(view, lattice, missing, job)?),
            false => None,
        };
        let missing = match (missing, nan) {
            (Some((_, Found { count, first: Some(first) })), Nan::Error) => {
                return Err(ExtractError::Nan { count, first });
            }
            (Some((plane, Found { count: 1.., .. })), Nan::Mask) => Some(plane),
            _ => None,
        };
        let inside = match threshold {
            // Nothing is inside, whatever the samples are: not one is read.
            Threshold::Never => Plane { lattice, bits: vec![], zeros: vec![] },
            _ => plane(view, lattice, inside, job)?.0,
        };
        Ok(Self { lattice, inside, missing })
    }

    /// Whether it is known without a look that there is no surface.
    pub(crate) fn is_empty(&self) -> bool {
        self.inside.bits.is_empty()
    }
}

/// A bit for every sample, by `test`, which is given a row, its place, and the words to fill.
fn plane<T: Sample, E>(
    view: &View<'_, T>,
    lattice: Lattice,
    test: impl Fn(&[T], [usize; 2], &mut [u64]) -> Found + Sync,
    job: &Job,
) -> Result<(Plane, Found), ExtractError<E>> {
    let [nx, ny, nz] = view.dims();
    let rows = (ny as u64).checked_mul(nz as u64);
    let count = rows.and_then(|rows| rows.checked_mul(lattice.words as u64));
    let mut bits: Vec<u64> = job.limits.zeroed("sign plane", count)?;
    let fill = |(k, slice): (usize, &mut [u64])| {
        job.check()?;
        let (mut found, mut scratch) = (Found::default(), vec![]);
        for (j, out) in slice.chunks_exact_mut(lattice.words).enumerate() {
            let row = view.row(j, k).gather(&mut scratch);
            let more = test(row, [j, k], &mut out[..words(nx)]);
            found = Found { count: found.count + more.count, first: found.first.or(more.first) };
            if lattice.guard == 1 {
                shift_by_one(out);
            }
        }
        job.progress.advance(1);
        Ok(found)
    };
    let slices = bits.par_chunks_exact_mut(lattice.words * ny).enumerate();
    let found: Vec<Found> = slices.map(fill).collect::<Result<_, Cancelled>>()?;
    let count = found.iter().map(|found| found.count).sum();
    let first = found.iter().find_map(|found| found.first);
    Ok((Plane { lattice, bits, zeros: vec![0; lattice.words] }, Found { count, first }))
}

/// Moves every bit of a row to the next place, and clears the first.
fn shift_by_one(row: &mut [u64]) {
    let mut carry = 0;
    for word in row {
        (carry, *word) = (*word >> 63, *word << 1 | carry);
    }
}

#[cfg(test)]
mod tests {
    use super::{Lattice, Planes};
    use crate::{Boundary, ExtractError, Nan};
    use isokit_job::Job;
    use isokit_volume::{Grid, Volume};
    use std::convert::Infallible;

    fn planes(
        dims: [u64; 3],
        sample: impl Fn(usize) -> f32,
        (boundary, nan): (Boundary, Nan),
    ) -> Result<Planes, ExtractError<Infallible>> {
        let grid = Grid::new(dims, Default::default()).unwrap();
        let samples = (0..grid.count() as usize).map(sample).collect();
        let volume = Volume::new(grid, samples).unwrap();
        let lattice = Lattice::new(volume.view().dims(), boundary);
        Planes::classify(&volume.view(), lattice, 0.0, nan, &Job::default())
    }

    fn bit(row: &[u64], i: usize) -> bool {
        row[i / 64] >> (i % 64) & 1 == 1
    }

    #[test]
    fn a_guard_surrounds_the_samples_of_a_closed_volume() {
        for nx in [1, 2, 61, 62, 63, 64, 65, 126, 127, 128] {
            let all = planes([nx as u64, 3, 2], |_| 1.0, (Boundary::Closed, Nan::Outside)).unwrap();
            assert_eq!(all.lattice.points, [nx + 2, 5, 4]);
            for (y, z) in (0..5).flat_map(|y| (0..4).map(move |z| (y, z))) {
                let inner = (1..4).contains(&y) && (1..3).contains(&z);
                for i in 0..all.lattice.words * 64 {
                    let expected = inner && (1..=nx).contains(&i);
                    assert_eq!(bit(all.inside.row(y, z), i), expected, "{nx}: {i}, {y}, {z}");
                }
            }
        }
    }

    #[test]
    fn an_open_volume_is_its_samples() {
        let odd = |i: usize| if i % 2 == 1 { 1.0 } else { -1.0 };
        let all = planes([65, 2, 2], odd, (Boundary::Open, Nan::Outside)).unwrap();
        assert_eq!(all.inside.row(0, 0), [0xAAAA_AAAA_AAAA_AAAA, 0]);
        assert_eq!(all.inside.row(1, 0), [0x5555_5555_5555_5555, 1]);
        assert_eq!((all.lattice.cells(0), all.lattice.cells(1)), (u64::MAX, 0));
    }

    #[test]
    fn nan_is_counted_or_marked_as_the_policy_says() {
        let holes = |i: usize| if i == 5 || i == 70 { f32::NAN } else { 1.0 };
        let error = planes([66, 2, 1], holes, (Boundary::Open, Nan::Error)).unwrap_err();
        assert_eq!(error, ExtractError::Nan { count: 2, first: [5, 0, 0] });
        let masked = planes([66, 2, 1], holes, (Boundary::Closed, Nan::Mask)).unwrap();
        let missing = masked.missing.unwrap();
        assert!(bit(missing.row(1, 1), 6) && bit(missing.row(2, 1), 5));
        assert_eq!(missing.row(2, 1)[1], 0);
        let outside = planes([66, 2, 1], holes, (Boundary::Open, Nan::Outside)).unwrap();
        assert!(outside.missing.is_none() && !bit(outside.inside.row(0, 0), 5));
    }
}
