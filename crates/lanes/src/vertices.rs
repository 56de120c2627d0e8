//! Where edges are crossed, and the normals there, 16 edges at a time.
//!
//! The samples around the ends of a batch of edges are loaded into arrays, one number per edge, and
//! everything after that is plain arithmetic on whole arrays, which becomes vector code as wide as the
//! machine has. There is one text for all levels, no fused multiply-add and no estimate of a reciprocal,
//! so the bits are the same. Only the loads are written twice: AVX-512 gathers.
//!
//! The arithmetic knows only finite values. Edges where something is not finite, or where the gradient
//! vanishes or is too large or small to square, come back marked, and the caller places them one by one.
//! A batch takes edges of any axis and row, so that none runs half empty on a sparse surface.

mod load;
#[cfg(test)]
mod tests;

use crate::{Lane, Level, Samples};
use load::{Load, Plain};

/// An array by an expression of the lane's number. A macro, so that it always becomes part of the
/// function that the level's instructions are enabled for; closures do not.
macro_rules! each {
    ($n:ident => $lane:expr) => {{
        let mut lanes = [Default::default(); BATCH];
        let mut $n = 0;
        while $n < BATCH {
            lanes[$n] = $lane;
            $n += 1;
        }
        lanes
    }};
}

/// The same for the three axes, written out so that each is a constant.
macro_rules! each_axis {
    ($axis:ident => $part:expr) => {
        [
            {
                let $axis = 0;
                $part
            },
            {
                let $axis = 1;
                $part
            },
            {
                let $axis = 2;
                $part
            },
        ]
    };
}

/// Edges per batch: two registers of f64 at the widest.
pub const BATCH: usize = 16;

/// The range of a gradient's greatest part within which its square neither overflows nor vanishes.
pub const TAME: std::ops::Range<f64> = 1e-120..1e120;

/// A type of coordinate in the output: `f32` or `f64`.
pub trait Coordinate: Copy + Default + Send + sealed::Sealed {
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
    /// The place of sample (0, 0, 0).
    pub origin: [f64; 3],
    /// Index along z of the first slice that is in memory.
    pub first_slice: f64,
    /// What turns a gradient in index space into one in world space, by columns.
    pub covectors: [[f64; 3]; 3],
}

impl Field {
    /// The place in world space of a point of index space.
    #[inline(always)]
    pub fn world(&self, ijk: [f64; 3]) -> [f64; 3] {
        each_axis!(k => {
            let along = |axis: usize| self.columns[axis][k] * ijk[axis];
            along(0) + (along(1) + (along(2) + self.origin[k]))
        })
    }

    /// The gradient in world space of a gradient in index space.
    #[inline(always)]
    pub fn world_gradient(&self, gradient: [f64; 3]) -> [f64; 3] {
        each_axis!(k => {
            let along = |axis: usize| self.covectors[axis][k] * gradient[axis];
            along(0) + along(1) + along(2)
        })
    }
}

/// Edges between samples, by axis and lower end.
#[derive(Clone, Copy, Debug)]
pub struct Edges {
    /// The axis, 0 to 2, of each.
    axis: [u32; BATCH],
    /// The lower end of each, x, y and z apart.
    low: [[u32; BATCH]; 3],
    count: usize,
}

impl Default for Edges {
    fn default() -> Self {
        Self { axis: [0; BATCH], low: [[0; BATCH]; 3], count: 0 }
    }
}

impl Edges {
    /// Adds an edge and says whether the batch is full now.
    ///
    /// # Panics
    ///
    /// If it was full before.
    #[inline(always)]
    pub fn push(&mut self, axis: usize, low: [u32; 3]) -> bool {
        self.axis[self.count] = axis as u32;
        self.low[0][self.count] = low[0];
        self.low[1][self.count] = low[1];
        self.low[2][self.count] = low[2];
        self.count += 1;
        self.count == BATCH
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Axis and lower end of edge `n`.
    pub fn get(&self, n: usize) -> (usize, [u32; 3]) {
        (self.axis[n] as usize, [self.low[0][n], self.low[1][n], self.low[2][n]])
    }

    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.count = 0;
    }
}

/// The vertices of a batch.
#[derive(Clone, Debug)]
pub struct Vertices<C> {
    /// Where they are, in world space.
    pub positions: [[C; 3]; BATCH],
    /// Unit normals, against the gradient.
    pub normals: [[f32; 3]; BATCH],
    /// Bit `n` is set where the vertex of edge `n` has yet to be placed.
    pub odd: u32,
}

impl<C: Coordinate> Default for Vertices<C> {
    fn default() -> Self {
        let positions = [[C::default(); 3]; BATCH];
        Self { positions, normals: [[0.0; 3]; BATCH], odd: 0 }
    }
}

/// Whether normals are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normals {
    /// They are not.
    None,
    /// They are.
    Gradient,
}

/// Places the vertices of a batch of edges. An edge whose ends are not both samples is odd.
pub fn vertices<T: Lane, C: Coordinate>(
    samples: &Samples<'_, T>,
    field: &Field,
    edges: &Edges,
    normals: Normals,
    out: &mut Vertices<C>,
) {
    vertices_at(Level::current(), samples, field, edges, normals, out);
}

fn vertices_at<T: Lane, C: Coordinate>(
    level: Level,
    samples: &Samples<'_, T>,
    field: &Field,
    edges: &Edges,
    normals: Normals,
    out: &mut Vertices<C>,
) {
    let batch = Batch { samples, field, edges, normals };
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { batch.avx512(out) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { batch.avx2(out) }
        }
        _ => batch.place(Plain, out),
    }
}

struct Batch<'b, 'a, T> {
    samples: &'b Samples<'a, T>,
    field: &'b Field,
    edges: &'b Edges,
    normals: Normals,
}

/// One number for each edge.
type Lanes<N = f64> = [N; BATCH];

/// An end of every edge: its number among the samples, and its place along x, y, z.
struct Ends {
    number: Lanes<i64>,
    place: [Lanes<u32>; 3],
}

impl<T: Lane> Batch<'_, '_, T> {
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    fn avx2<C: Coordinate>(&self, out: &mut Vertices<C>) {
        self.place(Plain, out);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
    fn avx512<C: Coordinate>(&self, out: &mut Vertices<C>) {
        // SAFETY: this function runs only where the machine has AVX-512 F.
        self.place(unsafe { load::Gather::new() }, out);
    }

    #[inline(always)]
    fn place<C: Coordinate>(&self, load: impl Load, out: &mut Vertices<C>) {
        let Field { iso, slope, intercept, reach, .. } = *self.field;
        let (low, high, mut is_odd) = self.ends();
        let value = |ends: &Ends| {
            // SAFETY: both ends of every edge are lattice points, as `ends` makes them.
            let stored = unsafe { load.load(self.samples, &ends.number) };
            each!(n => (stored[n] * slope + intercept) - iso)
        };
        let (a, b) = (value(&low), value(&high));
        let difference = each!(n => a[n] - b[n]);
        // Not `clamp`, which asks after NaN; those are odd.
        let delta = each!(n => ((a[n] + b[n]) / difference[n] * 0.5).max(-reach).min(reach));
        for n in 0..BATCH {
            is_odd[n] |= !difference[n].is_finite();
        }
        self.write_positions(&delta, &mut out.positions);
        if self.normals == Normals::Gradient {
            let share = each!(n => 0.5 + delta[n]);
            let gradients = [self.gradients(load, &low), self.gradients(load, &high)];
            self.write_normals(gradients, share, &mut is_odd, &mut out.normals);
        }
        out.odd = (0..BATCH).fold(0, |odd, n| odd | u32::from(is_odd[n]) << n);
        out.odd &= (1 << self.edges.count) - 1;
    }

    /// Both ends of every edge, and which edges do not lie between two samples. Those stand on the first
    /// sample instead, so that all numbers are sound.
    #[inline(always)]
    fn ends(&self) -> (Ends, Ends, Lanes<bool>) {
        let Edges { axis, low, .. } = self.edges;
        let (dims, strides) = (self.samples.dims(), self.samples.strides());
        let step = |n: usize, along: usize| u32::from(axis[n] == along as u32);
        // No size exceeds 2³¹ − 1, so a wrapped −1 is beyond all of them, and + 1 does not overflow.
        let outside = |n: usize, along: usize| {
            low[along][n] >= dims[along]
                || low[along][n].wrapping_add(step(n, along)) >= dims[along]
        };
        let is_odd = each!(n => outside(n, 0) | outside(n, 1) | outside(n, 2));
        let low: [Lanes<u32>; 3] =
            each_axis!(along => each!(n => if is_odd[n] { 0 } else { low[along][n] }));
        let high: [Lanes<u32>; 3] = each_axis!(along => each!(n => if is_odd[n] { 0 } else { low[along][n] + step(n, along) }));
        let number = |place: &[Lanes<u32>; 3]| {
            each!(n => {
                let along = |axis: usize| i64::from(place[axis][n]) * strides[axis];
                self.samples.first() + along(0) + along(1) + along(2)
            })
        };
        let ends = |place: [Lanes<u32>; 3]| Ends { number: number(&place), place };
        (ends(low), ends(high), is_odd)
    }

    #[inline(always)]
    fn write_positions<C: Coordinate>(&self, delta: &Lanes, out: &mut [[C; 3]; BATCH]) {
        let Edges { axis, low, .. } = self.edges;
        let ijk: [Lanes; 3] = each_axis!(along => {
            each!(n => {
                let first = if along == 2 { self.field.first_slice } else { 0.0 };
                let place = f64::from(low[along][n]) + first;
                if axis[n] == along as u32 { place + 0.5 + delta[n] } else { place }
            })
        });
        let mut world = [[0.0; BATCH]; 3];
        for n in 0..BATCH {
            let place = self.field.world([ijk[0][n], ijk[1][n], ijk[2][n]]);
            [world[0][n], world[1][n], world[2][n]] = place;
        }
        let world = each_axis!(k => each!(n => C::round(world[k][n])));
        for (n, place) in out.iter_mut().enumerate() {
            *place = [world[0][n], world[1][n], world[2][n]];
        }
    }

    /// Differences in index space at an end of each edge, one-sided at the border.
    #[inline(always)]
    fn gradients(&self, load: impl Load, ends: &Ends) -> [Lanes; 3] {
        let (dims, strides) = (self.samples.dims(), self.samples.strides());
        each_axis!(along => {
            let (place, last) = (&ends.place[along], dims[along] - 1);
            let below: Lanes<i64> = each!(n => if place[n] > 0 { strides[along] } else { 0 });
            let above: Lanes<i64> = each!(n => if place[n] < last { strides[along] } else { 0 });
            let factor = each!(n => if place[n] > 0 && place[n] < last { 0.5 } else { 1.0 });
            let (below, above) =
                (each!(n => ends.number[n] - below[n]), each!(n => ends.number[n] + above[n]));
            // SAFETY: an end is a lattice point; one step down is too unless its place is 0, and one
            // step up unless its place is the last, and then no step is made.
            let [lower, upper] =
                unsafe { [load.load(self.samples, &below), load.load(self.samples, &above)] };
            each!(n => (upper[n] - lower[n]) * factor[n] * self.field.slope)
        })
    }

    #[inline(always)]
    fn write_normals(
        &self,
        [low, high]: [[Lanes; 3]; 2],
        share: Lanes,
        is_odd: &mut Lanes<bool>,
        out: &mut [[f32; 3]; BATCH],
    ) {
        let gradient: [Lanes; 3] = each_axis!(axis => each!(n => low[axis][n] * (1.0 - share[n]) + high[axis][n] * share[n]));
        let mut world = [[0.0; BATCH]; 3];
        for n in 0..BATCH {
            let g = self.field.world_gradient([gradient[0][n], gradient[1][n], gradient[2][n]]);
            [world[0][n], world[1][n], world[2][n]] = g;
        }
        let greatest = each!(n => world[0][n].abs().max(world[1][n].abs()).max(world[2][n].abs()));
        let outward = each!(n => {
            let [a, b, c] = [world[0][n], world[1][n], world[2][n]];
            -1.0 / (a * a + b * b + c * c).sqrt()
        });
        let normal = each_axis!(k => each!(n => (world[k][n] * outward[n]) as f32));
        for n in 0..BATCH {
            // A NaN among the parts may hide behind the maximum of the others, not behind a sum.
            let sum = low[0][n] + low[1][n] + low[2][n] + high[0][n] + high[1][n] + high[2][n];
            is_odd[n] |= !(greatest[n] >= TAME.start && greatest[n] < TAME.end && sum.is_finite());
        }
        for (n, place) in out.iter_mut().enumerate() {
            *place = [normal[0][n], normal[1][n], normal[2][n]];
        }
    }
}
