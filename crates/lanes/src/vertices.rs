//! Where edges are crossed, and the normals there, 16 edges at a time.
//!
//! The samples around the ends of a batch of edges are loaded, one number per edge, and everything after
//! that is arithmetic on all sixteen. There is one text for all levels, no fused multiply-add and no
//! estimate of a reciprocal, so the bits are the same; `wide.rs` of the crate has what the text is written in.
//!
//! Positions are f64 until they are whole; but where curves are crossed is found in the type of the coordinates
//! (`curves/line.rs`). Normals come out as f32 and are made in f32, from differences of samples that are rounded once; they
//! are right to a few units of their last place.
//!
//! The arithmetic knows only finite values. Edges where something is not finite, or where the gradient
//! vanishes or is too large or small to square, are called odd, and the caller places them one by one.
//! A batch takes edges of any axis and row, so that none runs half empty on a sparse surface.
//!
//! `curves.rs` places vertices on cubics and quintics, with the same normals or such of a higher order.

mod around;
mod curves;
mod edges;
mod field;
mod normals;
mod roots;
#[cfg(test)]
pub(crate) mod tests;

pub(crate) use curves::Loading;
pub use curves::{Curve, Gradient, ONE_BEFORE, OneByOne, curved_vertices};
pub use edges::{BLOCK, Edges};
use field::Places;
pub use field::{Coordinate, Field};
pub(crate) use normals::Normals;

use crate::{
    Lane, Level, Samples,
    prefetch::prefetch_beyond,
    wide::{BATCH, Exact, Float, Mask, Task, Wide},
};

/// The greatest part of a gradient of differences, so that no part of any weight has lost a digit: from 2⁻⁶⁰
/// to 2¹²⁰.
const TAME: std::ops::Range<f32> = 8.673_617_4e-19..1.329_228e36;

/// Room that is asked for while a batch is written, in bytes behind the batch.
const AHEAD: usize = 1 << 10;

/// Where the vertices of edges go.
#[derive(Debug)]
pub struct Vertices<'a, C> {
    /// Places in world space.
    pub positions: &'a mut [[C; 3]],
    /// Unit normals, against the gradient; none are made where there is no room for them.
    pub normals: Option<&'a mut [[f32; 3]]>,
    /// The numbers of the odd edges are added here: those have yet to be placed.
    pub odd: &'a mut Vec<u32>,
}

impl<C> Vertices<'_, C> {
    /// Panics unless there is room for exactly so many.
    fn check(&self, edges: usize) {
        assert_eq!(self.positions.len(), edges, "room for every vertex");
        if let Some(normals) = &self.normals {
            assert_eq!(normals.len(), edges, "room for every normal");
        }
    }
}

/// Places the vertices of edges. An edge whose ends are not both samples is odd.
///
/// # Panics
///
/// If `out` has not room for exactly one vertex per edge.
pub fn vertices<T: Lane, C: Coordinate>(
    samples: &Samples<'_, T>,
    field: &Field,
    edges: &Edges,
    out: Vertices<'_, C>,
) {
    vertices_at(Level::current(), samples, field, edges, out);
}

fn vertices_at<T: Lane, C: Coordinate>(
    level: Level,
    samples: &Samples<'_, T>,
    field: &Field,
    edges: &Edges,
    out: Vertices<'_, C>,
) {
    out.check(edges.len());
    let Vertices { positions, normals, odd } = out;
    let (kernel, positions) = (Kernel::new(samples, field, edges), C::places(positions));
    T::place_straight(level, Straight { kernel, positions, normals, odd });
}

pub struct Kernel<'b, 'a, T> {
    samples: &'b Samples<'a, T>,
    field: &'b Field,
    /// Those of the field.
    directions: [[f32; 3]; 3],
    starts: Option<[f64; 3]>,
    /// Stored samples are not their values.
    is_scaled: bool,
    /// The isovalue, if it is an f32 and values are samples that f32 holds: then to subtract it in f32 gives the same bits
    /// as to do so in f64 and to round (Figueroa 1995).
    narrow_iso: Option<f32>,
    edges: &'b Edges,
}

/// All vertices of linear interpolation.
pub struct Straight<'k, 'b, 'a, T> {
    kernel: Kernel<'b, 'a, T>,
    positions: Places<'k>,
    normals: Option<&'k mut [[f32; 3]]>,
    odd: &'k mut Vec<u32>,
}

impl<T: Lane> Task for Straight<'_, '_, '_, T> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Self { kernel, mut positions, mut normals, odd } = self;
        let count = kernel.edges.len();
        let mut directions = [[0.0; 3]; BATCH];
        for first in (0..count).step_by(BATCH) {
            let own = BATCH.min(count - first);
            let normals_to = normals.as_mut().map(|all| match all[first..].first_chunk_mut() {
                Some(own) => {
                    prefetch_beyond::<AHEAD, _>(own);
                    own
                }
                // The last batch may have less room than it has numbers.
                None => &mut directions,
            });
            let is_odd = kernel.batch(wide, first, &mut positions, normals_to);
            let mut left = is_odd & (u16::MAX >> (BATCH - own));
            while left != 0 {
                odd.push(first as u32 + left.trailing_zeros());
                left &= left - 1;
            }
        }
        if let Some(normals) = normals {
            let rest = normals.as_chunks_mut::<BATCH>().1;
            rest.copy_from_slice(&directions[..rest.len()]);
        }
    }
}

impl<'b, 'a, T: Lane> Kernel<'b, 'a, T> {
    fn new(samples: &'b Samples<'a, T>, field: &'b Field, edges: &'b Edges) -> Self {
        // By one and nothing they are the same, but for the sign of 0, which does not matter.
        let is_scaled = field.slope != 1.0 || field.intercept != 0.0;
        let (directions, starts) = (field.directions(), field.starts());
        let narrow_iso = field.iso as f32;
        let is_narrow = !is_scaled && f64::from(narrow_iso) == field.iso && !T::Exact::IS_DOUBLE;
        let narrow_iso = is_narrow.then_some(narrow_iso);
        Self { samples, field, directions, starts, is_scaled, narrow_iso, edges }
    }

    /// The vertices of the batch that begins with edge `first`; the bits of those that are odd.
    #[inline(always)]
    fn batch<W: Wide>(
        &self,
        wide: W,
        first: usize,
        positions: &mut Places<'_>,
        normals: Option<&mut [[f32; 3]; BATCH]>,
    ) -> u16 {
        let batch = self.ends(wide, first);
        let around = self.around(wide, &batch, normals.is_some());
        let (a, b) = (self.above_iso(wide, around.ends[0]), self.above_iso(wide, around.ends[1]));
        let (difference, half, reach) = (a - b, wide.f64(0.5), self.field.reach);
        let delta = (a + b) / difference * half;
        let delta = delta.max(wide.f64(-reach)).min(wide.f64(reach));
        let places = self.field.places(wide, self.starts, batch.axis, batch.low, delta);
        positions.write(wide, first, places);
        let infinite = wide.f64(f64::INFINITY);
        let is_finite = difference.less(infinite) & wide.f64(f64::NEG_INFINITY).less(difference);
        let mut is_odd = batch.is_outside | !is_finite.bits();
        if let Some(normals) = normals {
            let share = wide.f64_to_f32(half + delta);
            is_odd |= self.write_normals(wide, around.differences, share, normals);
        }
        is_odd
    }

    /// Values less the isovalue.
    #[inline(always)]
    fn above_iso<W: Wide>(&self, wide: W, end: <T::Exact as Exact>::Of<W>) -> W::F64 {
        let Field { iso, slope, intercept, .. } = *self.field;
        let mut value = T::Exact::to_f64(wide, end);
        if self.is_scaled {
            value = value * wide.f64(slope) + wide.f64(intercept);
        }
        value - wide.f64(iso)
    }

    /// The normals of gradients between those of the ends; the bits of those that are odd.
    #[inline(always)]
    fn write_normals<W: Wide>(
        &self,
        wide: W,
        [low, high]: [[W::F32; 3]; 2],
        share: W::F32,
        out: &mut [[f32; 3]; BATCH],
    ) -> u16 {
        let (rest, d) = (wide.f32(1.0) - share, &self.directions);
        let mut mixed = low;
        for along in 0..3 {
            mixed[along] = low[along] * rest + high[along] * share;
        }
        let mut world = mixed;
        for k in 0..3 {
            let x_y = wide.f32(d[0][k]) * mixed[0] + wide.f32(d[1][k]) * mixed[1];
            world[k] = x_y + wide.f32(d[2][k]) * mixed[2];
        }
        let zero = wide.f32(0.0);
        let mut greatest = zero;
        for part in world {
            greatest = greatest.max(part.abs());
        }
        // By a power of two, which changes no digit: no square overflows or vanishes.
        let scale = wide.to_unit(greatest);
        for part in &mut world {
            *part = *part * scale;
        }
        let square = world[0] * world[0] + world[1] * world[1] + world[2] * world[2];
        let outward = wide.f32(-1.0) / square.sqrt();
        wide.interleave([world[0] * outward, world[1] * outward, world[2] * outward], out);
        let is_tame = greatest.less(wide.f32(TAME.end)) & !greatest.less(wide.f32(TAME.start));
        // A part that is NaN may hide behind the greatest of the others, not in the sum of squares.
        !(is_tame & square.less(wide.f32(16.0))).bits()
    }
}
