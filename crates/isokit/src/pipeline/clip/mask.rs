//! What another volume keeps of a scan, by the values of its samples.

use crate::pipeline::{Lattice, Scan};
use isokit_geom::vector::{Vector, dot};
use isokit_job::{Job, Stopped, Work};
use isokit_lanes::{Side, WORD, exactly, words};
use isokit_volume::{Points, Sample, View, for_any};
use rayon::prelude::*;

/// Which places of a part of a scan another volume keeps: those whose nearest sample there has one of some values, such as
/// the label of an organ. Of two samples as near it is the later one; places in terms of samples are rounded to 2⁻²⁴
/// for that. What is farther than half a sample outside of that volume is not kept.
///
/// [`Scan::mask`] makes it, of the part that is looked at, and where the scan is [placed](Scan::placed).
#[derive(Clone, Debug)]
pub struct Mask {
    /// One bit for each sample of the other volume, in words that begin with each row.
    bits: Vec<u64>,
    dims: [usize; 3],
    /// For each axis of the other volume, how its sample number changes with those of the scan's part, and where it begins.
    rows: [(Vector, f64); 3],
    /// Where the scan is.
    of: Lattice,
}

/// What sample numbers are rounded to, so that places halfway between samples go one way. What sums of products lose is
/// far less.
const FINEST: f64 = 1.0 / (1 << 24) as f64;

impl Scan {
    /// What `other` keeps of this scan: places whose nearest sample in it has one of the values; without any given, a value
    /// other than 0. NaN keeps nothing. That volume may have any lattice and any part; in which world it is, is decided
    /// as by [`attribute`](Self::attribute).
    ///
    /// # Errors
    ///
    /// If the job is cancelled or allows less memory.
    pub fn mask(&self, other: &Self, values: Option<&[f64]>, job: &Job) -> Result<Mask, Stopped> {
        let (way, here) = (self.way(other.source_frame()), self.frame().index_to_world);
        let [first, skipped] = [self, other].map(|scan| scan.part().map(|part| part.start as f64));
        let mut rows = rows(|ijk| way.index_of(here.point(ijk)));
        for ((step, start), skipped) in rows.iter_mut().zip(skipped) {
            *start += dot(*step, first) - skipped;
        }
        let mut sorted = values.map(<[f64]>::to_vec);
        if let Some(all) = &mut sorted {
            all.retain(|value| !value.is_nan());
            all.sort_by(f64::total_cmp);
        }
        for_any!(other.volume(), volume => {
            let view = other.view(volume);
            let bits = bits(&view, sorted.as_deref(), job)?;
            Ok(Mask { bits, dims: view.dims(), rows, of: self.lattice().clone() })
        })
    }
}

/// Sample numbers of another volume as sums over those of the scan, of which `at` tells them.
fn rows(at: impl Fn(Vector) -> Vector) -> [(Vector, f64); 3] {
    let start = at([0.0; 3]);
    let ends = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(at);
    std::array::from_fn(|k| (ends.map(|end| end[k] - start[k]), start[k]))
}

/// Which samples have one of the values, which are sorted.
fn bits<T: Sample>(
    view: &View<'_, T>,
    values: Option<&[f64]>,
    job: &Job,
) -> Result<Vec<u64>, Stopped> {
    let [nx, ny, nz] = view.dims();
    let slice = words(nx) * ny;
    let mut bits = job.limits.zeroed("mask", (slice as u64).checked_mul(nz as u64))?;
    let scaling = view.scaling();
    let fill: Work<'_, _, _> = &|(k, slice): (usize, &mut [u64])| {
        job.check()?;
        exactly(|| {
            let mut scratch = vec![];
            for (j, row) in slice.chunks_exact_mut(words(nx)).enumerate() {
                let samples = view.row(j, k).gather(&mut scratch);
                for (word, samples) in row.iter_mut().zip(samples.chunks(WORD)) {
                    for (n, sample) in samples.iter().enumerate() {
                        let value = scaling.value(sample.to_f64());
                        *word |= u64::from(is_one_of(value, values)) << n;
                    }
                }
            }
        });
        Ok::<_, Stopped>(())
    };
    job.threads.run(|| bits.par_chunks_mut(slice).enumerate().try_for_each(fill))?;
    Ok(bits)
}

fn is_one_of(value: f64, sorted: Option<&[f64]>) -> bool {
    match sorted {
        None => value != 0.0 && !value.is_nan(),
        Some(values) => {
            let at = values.partition_point(|&one| one < value);
            values.get(at).is_some_and(|&one| one == value)
        }
    }
}

impl Mask {
    /// How many samples of the other volume keep something.
    pub fn count(&self) -> u64 {
        self.bits.iter().map(|word| u64::from(word.count_ones())).sum()
    }

    /// Whether it is of a part of a scan, in that place.
    pub(super) fn is_of(&self, lattice: &Lattice) -> bool {
        self.of == *lattice
    }

    /// Whether a place in the index space of the scan's part is kept.
    pub(super) fn keeps(&self, ijk: Vector) -> bool {
        let at = self.rows.map(|(step, start)| start + dot(step, ijk));
        let at = at.map(|number| (number / FINEST).round() * FINEST);
        let last = self.dims.map(|n| n as f64 - 1.0);
        (0..3).all(|k| at[k] >= -0.5 && at[k] <= last[k] + 0.5)
            && self.bit([0, 1, 2].map(|k| (at[k].clamp(0.0, last[k]) + 0.5).floor() as usize))
    }

    /// Which of the places between some samples of the scan are kept. Of what is near an end of the other volume, or where its
    /// samples differ, nothing is said.
    pub(super) fn side(&self, points: &Points) -> Side {
        let mut within: Points = [0..0, 0..0, 0..0];
        let mut is_outside = false;
        for (k, within) in within.iter_mut().enumerate() {
            let (step, start) = self.rows[k];
            let [mut least, mut greatest] = [start; 2];
            for (axis, range) in points.iter().enumerate() {
                let ends = [range.start, range.end - 1].map(|end| step[axis] * end as f64);
                least += ends[0].min(ends[1]);
                greatest += ends[0].max(ends[1]);
            }
            // A sample more on both sides: rounding is less.
            let (least, greatest) = (least.floor() - 1.0, greatest.ceil() + 1.0);
            // Of what is no number too.
            is_outside |= !(least >= 0.0 && greatest < self.dims[k] as f64);
            // As numbers are cast, what is below 0 is 0.
            *within = least as usize..(greatest as usize).saturating_add(1).min(self.dims[k]);
        }
        let [x, y, z] = within;
        let bits = z.flat_map(|k| {
            let x = &x;
            y.clone().flat_map(move |j| x.clone().map(move |i| self.bit([i, j, k])))
        });
        let (mut some, mut none) = (false, is_outside);
        for bit in bits {
            some |= bit;
            none |= !bit;
            if some && none {
                return Side::Both;
            }
        }
        if some { Side::Inside } else { Side::Outside }
    }

    fn bit(&self, [i, j, k]: [usize; 3]) -> bool {
        let row = (j + self.dims[1] * k) * words(self.dims[0]);
        self.bits[row + i / WORD] >> (i % WORD) & 1 == 1
    }
}

#[cfg(test)]
mod tests;
