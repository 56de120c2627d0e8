//! Where the edges of a row are crossed, and the normals there.
//!
//! One loop over batches of edges: the samples around the ends of a batch are gathered into arrays, one
//! number per edge, and everything after that is plain arithmetic on whole arrays, which becomes vector
//! code as wide as the machine has. There is one text for all levels, no fused multiply-add and no
//! estimate of a reciprocal, so the bits are the same.
//!
//! The loop knows only finite values. Edges where something is not finite, or where the gradient
//! vanishes or is too large or small to square, are named to the caller, who places them one by one.

use crate::{Lane, Level};

/// Edges per batch: two registers of f64 at the widest.
const BATCH: usize = 16;

/// The range of a gradient's greatest part within which its square neither overflows nor vanishes.
pub const TAME: std::ops::Range<f64> = 1e-120..1e120;

/// A type of coordinate in the output: `f32` or `f64`.
pub trait Coordinate: Copy + Send + sealed::Sealed {
    /// The coordinate nearest to a value.
    fn round(value: f64) -> Self;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

impl Coordinate for f32 {
    #[inline(always)]
    fn round(value: f64) -> Self {
        value as f32
    }
}

impl Coordinate for f64 {
    #[inline(always)]
    fn round(value: f64) -> Self {
        value
    }
}

/// A row of samples, and the rows beside it.
#[derive(Clone, Copy, Debug)]
pub struct Beside<'a, T> {
    /// The row itself.
    pub row: &'a [T],
    /// The next lower and the next higher row along y, or the row itself where there is none.
    pub y: [&'a [T]; 2],
    /// The same along z.
    pub z: [&'a [T]; 2],
    /// What turns the differences along y and z into a slope: ½ between two neighbours, 1 at a border.
    pub factors: [f64; 2],
}

/// Edges along one axis whose lower ends lie in one row.
#[derive(Clone, Copy, Debug)]
pub struct EdgesOfRow<'a, T> {
    /// The axis, 0 to 2.
    pub axis: usize,
    /// Around the lower ends.
    pub low: Beside<'a, T>,
    /// Around the upper ends. Along x this is the same row, one sample on.
    pub high: Beside<'a, T>,
    /// The row's place in index space along y and z.
    pub place: [f64; 2],
}

/// Everything beside the samples that a vertex depends on.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// The isovalue.
    pub iso: f64,
    /// The value of a stored sample is `stored · slope + intercept`.
    pub slope: f64,
    /// See `slope`.
    pub intercept: f64,
    /// How far from the middle of its edge a vertex may be, in edge lengths.
    pub reach: f64,
    /// Where a step along x, y, z of index space leads.
    pub columns: [[f64; 3]; 3],
    /// The place of the first sample.
    pub origin: [f64; 3],
    /// What turns a gradient in index space into one in world space, by columns.
    pub covectors: [[f64; 3]; 3],
}

impl Field {
    /// The place in world space of a point of index space.
    #[inline(always)]
    pub fn world(&self, ijk: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| {
            let along = |axis: usize| self.columns[axis][k] * ijk[axis];
            along(0) + (along(1) + (along(2) + self.origin[k]))
        })
    }

    /// The gradient in world space of a gradient in index space.
    #[inline(always)]
    pub fn world_gradient(&self, gradient: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| {
            let along = |axis: usize| self.covectors[axis][k] * gradient[axis];
            along(0) + along(1) + along(2)
        })
    }
}

/// Places the vertices of the edges at `x`, in order.
///
/// Numbers of edges that the loop cannot place are appended to `odd`; what stands in their places then is
/// of no meaning.
///
/// # Panics
///
/// If the rows differ in length, an edge has an end beyond them, or there are fewer places than edges.
pub fn vertices<T: Lane + Into<f64>, C: Coordinate>(
    edges: &EdgesOfRow<'_, T>,
    field: &Field,
    x: &[u32],
    positions: &mut [[C; 3]],
    normals: Option<&mut [[f32; 3]]>,
    odd: &mut Vec<usize>,
) {
    vertices_at(Level::current(), edges, field, x, positions, normals, odd);
}

fn vertices_at<T: Lane + Into<f64>, C: Coordinate>(
    level: Level,
    edges: &EdgesOfRow<'_, T>,
    field: &Field,
    x: &[u32],
    positions: &mut [[C; 3]],
    normals: Option<&mut [[f32; 3]]>,
    odd: &mut Vec<usize>,
) {
    let run = Run { edges, field, x };
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { run.avx512(positions, normals, odd) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { run.avx2(positions, normals, odd) }
        }
        _ => run.plain(positions, normals, odd),
    }
}

struct Run<'r, 'a, T> {
    edges: &'r EdgesOfRow<'a, T>,
    field: &'r Field,
    x: &'r [u32],
}

type Lanes = [f64; BATCH];

#[inline(always)]
fn each(f: impl FnMut(usize) -> f64) -> Lanes {
    std::array::from_fn(f)
}

/// One batch of crossings.
struct Crossings {
    delta: Lanes,
    is_odd: [bool; BATCH],
}

impl<T: Lane + Into<f64>> Run<'_, '_, T> {
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    fn avx2<C: Coordinate>(
        &self,
        positions: &mut [[C; 3]],
        normals: Option<&mut [[f32; 3]]>,
        odd: &mut Vec<usize>,
    ) {
        self.plain(positions, normals, odd);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
    fn avx512<C: Coordinate>(
        &self,
        positions: &mut [[C; 3]],
        normals: Option<&mut [[f32; 3]]>,
        odd: &mut Vec<usize>,
    ) {
        self.plain(positions, normals, odd);
    }

    #[inline(always)]
    fn plain<C: Coordinate>(
        &self,
        positions: &mut [[C; 3]],
        mut normals: Option<&mut [[f32; 3]]>,
        odd: &mut Vec<usize>,
    ) {
        for first in (0..self.x.len()).step_by(BATCH) {
            let batch = &self.x[first..self.x.len().min(first + BATCH)];
            // The last batch is filled up with its last edge.
            let x: [usize; BATCH] = std::array::from_fn(|n| batch[n.min(batch.len() - 1)] as usize);
            let places = first..first + batch.len();
            let Crossings { delta, mut is_odd } = self.crossings(&x);
            self.write_positions(&x, &delta, &mut positions[places.clone()]);
            if let Some(normals) = &mut normals {
                self.write_normals(&x, &delta, &mut is_odd, &mut normals[places]);
            }
            if is_odd.contains(&true) {
                odd.extend((0..batch.len()).filter(|&n| is_odd[n]).map(|n| first + n));
            }
        }
    }

    /// How far on along x the upper end is.
    #[inline(always)]
    fn step(&self) -> usize {
        usize::from(self.edges.axis == 0)
    }

    #[inline(always)]
    fn crossings(&self, x: &[usize; BATCH]) -> Crossings {
        let Field { iso, slope, intercept, reach, .. } = *self.field;
        let step = self.step();
        let low = each(|n| self.edges.low.row[x[n]].into());
        let high = each(|n| self.edges.high.row[x[n] + step].into());
        let above = |stored: Lanes| each(|n| (stored[n] * slope + intercept) - iso);
        let (a, b) = (above(low), above(high));
        let difference = each(|n| a[n] - b[n]);
        let delta = each(|n| (a[n] + b[n]) / difference[n] * 0.5);
        Crossings {
            // Not `clamp`, which asks after NaN; those are odd, and placed by the caller.
            delta: each(|n| delta[n].max(-reach).min(reach)),
            is_odd: std::array::from_fn(|n| !difference[n].is_finite()),
        }
    }

    #[inline(always)]
    fn write_positions<C: Coordinate>(
        &self,
        x: &[usize; BATCH],
        delta: &Lanes,
        out: &mut [[C; 3]],
    ) {
        let [y, z] = self.edges.place;
        let mut ijk = [each(|n| x[n] as f64), [y; BATCH], [z; BATCH]];
        let along = &mut ijk[self.edges.axis];
        *along = each(|n| along[n] + 0.5 + delta[n]);
        let mut world = [[0.0; BATCH]; 3];
        for n in 0..BATCH {
            let place = self.field.world([ijk[0][n], ijk[1][n], ijk[2][n]]);
            [world[0][n], world[1][n], world[2][n]] = place;
        }
        let world = world.map(|lanes| lanes.map(C::round));
        for (n, place) in out.iter_mut().enumerate() {
            *place = [world[0][n], world[1][n], world[2][n]];
        }
    }

    #[inline(always)]
    fn write_normals(
        &self,
        x: &[usize; BATCH],
        delta: &Lanes,
        is_odd: &mut [bool; BATCH],
        out: &mut [[f32; 3]],
    ) {
        let slope = self.field.slope;
        let step = self.step();
        let low = gradients(&self.edges.low, x, 0, slope);
        let high = gradients(&self.edges.high, x, step, slope);
        let share = each(|n| 0.5 + delta[n]);
        let gradient: [Lanes; 3] = std::array::from_fn(|axis| {
            each(|n| low[axis][n] * (1.0 - share[n]) + high[axis][n] * share[n])
        });
        let mut world = [[0.0; BATCH]; 3];
        for n in 0..BATCH {
            let g = self.field.world_gradient([gradient[0][n], gradient[1][n], gradient[2][n]]);
            [world[0][n], world[1][n], world[2][n]] = g;
        }
        let greatest = each(|n| world[0][n].abs().max(world[1][n].abs()).max(world[2][n].abs()));
        let length = each(|n| {
            let [a, b, c] = [world[0][n], world[1][n], world[2][n]];
            (a * a + b * b + c * c).sqrt()
        });
        let outward = each(|n| -1.0 / length[n]);
        let normal = world.map(|part| {
            let unit = each(|n| part[n] * outward[n]);
            unit.map(|part| part as f32)
        });
        for n in 0..BATCH {
            // A NaN among the parts may hide behind the maximum of the others, not behind a sum.
            let sum = low[0][n] + low[1][n] + low[2][n] + high[0][n] + high[1][n] + high[2][n];
            is_odd[n] |= !TAME.contains(&greatest[n]) || !sum.is_finite();
        }
        for (n, place) in out.iter_mut().enumerate() {
            *place = [normal[0][n], normal[1][n], normal[2][n]];
        }
    }
}

/// Differences at the samples `x + step` of a row, one-sided at its ends, times the slope of the scaling.
#[inline(always)]
fn gradients<T: Lane + Into<f64>>(
    beside: &Beside<'_, T>,
    x: &[usize; BATCH],
    step: usize,
    slope: f64,
) -> [Lanes; 3] {
    let last = beside.row.len() - 1;
    let below = |n: usize| (x[n] + step).saturating_sub(1);
    let above = |n: usize| (x[n] + step + 1).min(last);
    let factor = each(|n| if above(n) - below(n) == 2 { 0.5 } else { 1.0 });
    let lower = each(|n| beside.row[below(n)].into());
    let upper = each(|n| beside.row[above(n)].into());
    let along_x = each(|n| (upper[n] - lower[n]) * factor[n] * slope);
    let across = |rows: [&[T]; 2], factor: f64| {
        let lower = each(|n| rows[0][x[n] + step].into());
        let upper = each(|n| rows[1][x[n] + step].into());
        each(|n| (upper[n] - lower[n]) * factor * slope)
    };
    [along_x, across(beside.y, beside.factors[0]), across(beside.z, beside.factors[1])]
}
