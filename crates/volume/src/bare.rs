//! Where a surface is not deep within another one.
//!
//! The surface of a higher value lies within that of a lower one: all samples inside of it are inside of the other. In most
//! cells it goes through, all samples around are inside of the lower one too, and that one is more than a cell away. The
//! others are found here, 64 cells at a time.

use crate::{Sample, View};
use isokit_job::{Job, OverLimit, Stopped, Work};
use isokit_lanes::{Threshold, Thresholds, WORD, exactly, signs_of_many, words};
use rayon::prelude::*;
use std::ops::Range;

/// Layers of cells that are looked at at a time.
const LAYERS: usize = 16;

/// Cells of a surface within another one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Crossed {
    /// How many it goes through, or closes in at the border.
    pub count: u64,
    /// Those of them, by their lower corners, around which not all samples are inside of the outer surface: the eight of
    /// the cell and the next ones on all sides.
    pub bare: Vec<[usize; 3]>,
}

/// Cells that a surface goes through, and where an outer one is near. `None` if there are more of those than `most`, or
/// if there is an axis without cells.
///
/// # Errors
///
/// If the job is cancelled or does not allow the memory.
pub fn bare_cells<T: Sample>(
    view: &View<'_, T>,
    [outer, inner]: [Threshold<T>; 2],
    most: usize,
    job: &Job,
) -> Result<Option<Crossed>, Stopped> {
    if view.dims().iter().any(|&n| n < 2) {
        return Ok(None);
    }
    let Some(thresholds) = Thresholds::new(&[outer, inner]) else {
        // No sample is inside.
        return Ok((inner == Threshold::Never).then(Crossed::default));
    };
    let layers = view.dims()[2] - 1;
    let chunk: Work<'_, _, _> = &|n: usize| {
        job.check()?;
        let range = n * LAYERS..layers.min((n + 1) * LAYERS);
        exactly(|| Ok(Rows::of(view, &thresholds, range.clone(), job)?.bare(range)))
    };
    let chunks = (0..layers.div_ceil(LAYERS)).into_par_iter();
    let found: Result<Vec<_>, Stopped> = job.threads.run(|| chunks.map(chunk).collect());
    let found = found?;
    let bare: usize = found.iter().map(|found| found.bare.len()).sum();
    Ok((bare <= most).then(|| {
        let count = found.iter().map(|found| found.count).sum();
        Crossed { count, bare: found.into_iter().flat_map(|found| found.bare).collect() }
    }))
}

/// Which samples of some slices are inside of the outer surface, and which of the inner one.
struct Rows {
    dims: [usize; 3],
    /// The slices.
    slices: Range<usize>,
    /// Words of a row.
    words: usize,
    /// Row by row, words for the outer surface and then for the inner one.
    bits: Vec<u64>,
}

/// Which one is asked for.
#[derive(Clone, Copy)]
enum Which {
    Outer,
    Inner,
}

impl Rows {
    /// Of the slices around layers of cells.
    fn of<T: Sample>(
        view: &View<'_, T>,
        thresholds: &Thresholds<T>,
        layers: Range<usize>,
        job: &Job,
    ) -> Result<Self, OverLimit> {
        let dims = view.dims();
        let slices = layers.start.saturating_sub(1)..dims[2].min(layers.end + 2);
        let (words, rows) = (words(dims[0]), slices.len() * dims[1]);
        let mut bits = job.limits.zeroed("signs of samples", Some((2 * words * rows) as u64))?;
        let mut scratch = vec![];
        for (n, out) in bits.chunks_exact_mut(2 * words).enumerate() {
            let row = view.row(n % dims[1], slices.start + n / dims[1]);
            signs_of_many(row.gather(&mut scratch), thresholds, out, words);
        }
        Ok(Self { dims, slices, words, bits })
    }

    fn row(&self, which: Which, j: usize, k: usize) -> &[u64] {
        let first = 2 * self.words * ((k - self.slices.start) * self.dims[1] + j);
        let first = first + if matches!(which, Which::Inner) { self.words } else { 0 };
        &self.bits[first..first + self.words]
    }

    /// The cells of layers, x fastest.
    fn bare(&self, layers: Range<usize>) -> Crossed {
        let mut found = Crossed::default();
        for (k, j) in layers.flat_map(|k| (0..self.dims[1] - 1).map(move |j| (k, j))) {
            for w in 0..self.words {
                let crossed = self.crossed([j, k], w);
                if crossed == 0 {
                    continue;
                }
                found.count += u64::from(crossed.count_ones());
                let mut bare = crossed & !self.surrounded([j, k], w);
                while bare != 0 {
                    found.bare.push([w * WORD + bare.trailing_zeros() as usize, j, k]);
                    bare &= bare - 1;
                }
            }
        }
        found
    }

    /// Cells that the inner surface goes through, or in which it closes at the border: at the border all that have a sample
    /// inside.
    fn crossed(&self, [j, k]: [usize; 2], w: usize) -> u64 {
        let corners = [(j, k), (j + 1, k), (j, k + 1), (j + 1, k + 1)];
        let corners = corners.map(|(j, k)| self.row(Which::Inner, j, k));
        let word = |w: usize, fold: fn(u64, u64) -> u64| {
            corners.iter().map(|row| row.get(w).copied().unwrap_or(0)).reduce(fold).unwrap_or(0)
        };
        let [any, all] = [|a, b| a | b, |a, b| a & b]
            .map(|fold: fn(u64, u64) -> u64| [word(w, fold), word(w + 1, fold)]);
        let any = any[0] | next(any, 1);
        let all = all[0] & next(all, 1);
        let [nx, ny, nz] = self.dims;
        let is_border = j == 0 || k == 0 || j + 2 == ny || k + 2 == nz;
        let border = if is_border { u64::MAX } else { bit(0, w) | bit(nx - 2, w) };
        any & (!all | border) & below(nx - 1, w)
    }

    /// Cells around which all samples are inside of the outer surface.
    fn surrounded(&self, [j, k]: [usize; 2], w: usize) -> u64 {
        let [_, ny, nz] = self.dims;
        if j == 0 || k == 0 || j + 3 > ny || k + 3 > nz {
            return 0;
        }
        let word = |w: usize| {
            let rows = (k - 1..k + 3).flat_map(|k| (j - 1..j + 3).map(move |j| (j, k)));
            rows.map(|(j, k)| self.row(Which::Outer, j, k).get(w).copied().unwrap_or(0))
                .fold(u64::MAX, |all, word| all & word)
        };
        let (own, after) = (word(w), word(w + 1));
        if own == 0 {
            return 0;
        }
        let before = w.checked_sub(1).map_or(0, word);
        let ahead = [own, after];
        own & (own << 1 | before >> 63) & next(ahead, 1) & next(ahead, 2)
    }
}

/// The bits that come so many after those of a word.
fn next([own, after]: [u64; 2], by: u32) -> u64 {
    own >> by | after << (64 - by)
}

/// Bit `n` of a row, if it is in word `w`.
fn bit(n: usize, w: usize) -> u64 {
    if n / WORD == w { 1 << (n % WORD) } else { 0 }
}

/// The bits of word `w` below bit `n` of a row.
fn below(n: usize, w: usize) -> u64 {
    match n.saturating_sub(w * WORD) {
        0 => 0,
        left if left < WORD => (1 << left) - 1,
        _ => u64::MAX,
    }
}

#[cfg(test)]
mod tests {
    use super::{Crossed, bare_cells};
    use crate::{Grid, Scaling, Volume};
    use isokit_job::{Job, Limits, Stopped, Threads};
    use isokit_lanes::Threshold;
    use std::num::NonZeroUsize;

    fn chance(dims: [usize; 3], smooth: bool, seed: u64) -> Volume<u8> {
        let grid = Grid::new(dims.map(|n| n as u64), Default::default()).unwrap();
        let mut state = seed;
        let mut next = |n: u64| {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
            let noise = (state >> 58) as f64;
            let place = [
                n as usize % dims[0],
                n as usize / dims[0] % dims[1],
                n as usize / dims[0] / dims[1],
            ];
            let away =
                (0..3).map(|k| (place[k] as f64 - dims[k] as f64 / 2.0).powi(2)).sum::<f64>();
            if smooth {
                (200.0 - 8.0 * away.sqrt() + noise).clamp(0.0, 255.0) as u8
            } else {
                (state >> 56) as u8
            }
        };
        Volume::new(grid, (0..grid.count()).map(&mut next).collect()).unwrap()
    }

    /// The definition: all samples of and around each cell.
    fn plainly(volume: &Volume<u8>, [outer, inner]: [u8; 2]) -> Crossed {
        let (view, dims) = (volume.view(), volume.grid().dims().map(|n| n as usize));
        let at = |place: [usize; 3]| view.stored(place);
        let mut cells = Crossed::default();
        for k in 0..dims[2] - 1 {
            for (i, j) in (0..dims[1] - 1).flat_map(|j| (0..dims[0] - 1).map(move |i| (i, j))) {
                let low = [i, j, k];
                let corner = |n: usize| std::array::from_fn(|axis| low[axis] + (n >> axis & 1));
                let inside = (0..8).filter(|&n| at(corner(n)) >= inner).count();
                let is_border = (0..3).any(|axis| low[axis] == 0 || low[axis] + 2 == dims[axis]);
                let around = |n: usize| [n % 4, n / 4 % 4, n / 16];
                let is_surrounded = !(0..3)
                    .any(|axis| low[axis] == 0 || low[axis] + 3 > dims[axis])
                    && (0..64).map(around).all(|n| {
                        let place = std::array::from_fn(|axis| low[axis] + n[axis] - 1);
                        at(place) >= outer
                    });
                let is_crossed = inside > 0 && (inside < 8 || is_border);
                cells.count += u64::from(is_crossed);
                if is_crossed && !is_surrounded {
                    cells.bare.push(low);
                }
            }
        }
        cells
    }

    fn found(volume: &Volume<u8>, isos: [u8; 2], most: usize, job: &Job) -> Option<Crossed> {
        bare_cells(&volume.view(), isos.map(Threshold::AtLeast), most, job).unwrap()
    }

    #[test]
    fn cells_are_those_of_the_definition_for_all_sizes_and_threads() {
        for (n, dims) in
            [[2, 2, 2], [2, 9, 5], [3, 3, 3], [64, 6, 7], [65, 5, 20], [66, 4, 37], [130, 19, 4]]
                .into_iter()
                .enumerate()
        {
            for smooth in [true, false] {
                let volume = chance(dims, smooth, n as u64);
                for isos in [[60, 120], [60, 61], [0, 3], [2, 250]] {
                    let expected = plainly(&volume, isos);
                    for threads in [1, 3] {
                        let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
                        let job = Job { threads, ..Job::default() };
                        let cells = found(&volume, isos, usize::MAX, &job);
                        assert_eq!(cells.as_ref(), Some(&expected), "{dims:?}, {isos:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn deep_within_an_outer_surface_there_is_none() {
        let volume = chance([40, 40, 40], true, 5);
        let job = Job::default();
        let deep = found(&volume, [60, 150], 0, &job).unwrap();
        assert!(deep.bare.is_empty() && deep.count > 100, "{deep:?}");
        assert!(found(&volume, [60, 64], usize::MAX, &job).unwrap().bare.len() > 1000);
        assert_eq!(found(&volume, [60, 64], 1000, &job), None, "too many");
    }

    #[test]
    fn of_values_that_no_sample_has_there_is_none_and_of_planes_nothing_is_known() {
        let (volume, job) = (chance([9, 9, 9], true, 1), Job::default());
        let of = |outer, inner| bare_cells(&volume.view(), [outer, inner], 99, &job).unwrap();
        assert_eq!(of(Threshold::AtLeast(1), Threshold::Never), Some(Crossed::default()));
        assert_eq!(of(Threshold::Never, Threshold::AtLeast(1)), None);
        let falling = Scaling::new(-1.0, 0.0).unwrap().threshold::<u8>(-100.0);
        assert_eq!(of(falling, Threshold::AtLeast(1)), None, "one rises and one falls");
        assert_eq!(found(&chance([9, 1, 9], true, 1), [1, 2], 99, &job), None);
        let job = Job { limits: Limits { bytes: 100 }, ..Job::default() };
        let refused = bare_cells(&volume.view(), [1, 2].map(Threshold::AtLeast), 99, &job);
        assert!(matches!(refused, Err(Stopped::OverLimit(_))), "{refused:?}");
    }
}
