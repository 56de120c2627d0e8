//! Where edges are crossed, and the normals there, 16 edges at a time.
//!
//! The samples around the ends of a batch of edges are loaded, one number per edge, and everything after
//! that is arithmetic on all sixteen. There is one text for all levels, no fused multiply-add and no
//! estimate of a reciprocal, so the bits are the same; `wide.rs` has what the text is written in.
//!
//! Positions are f64 until they are whole. Normals come out as f32 and are made in f32, from differences
//! of samples that are rounded once; they are right to a few units of their last place.
//!
//! The arithmetic knows only finite values. Edges where something is not finite, or where the gradient
//! vanishes or is too large or small to square, are called odd, and the caller places them one by one.
//! A batch takes edges of any axis and row, so that none runs half empty on a sparse surface.
//!
//! `curves.rs` places vertices on cubics and quintics, with normals of a high order.

mod curves;
mod edges;
mod field;
mod roots;
mod slopes;
#[cfg(test)]
mod tests;
mod wide;

pub use curves::{Curve, OneByOne, curved_vertices};
pub use edges::{BLOCK, Edges};
pub use field::{Coordinate, Field};
pub(crate) use wide::Exact;

use crate::{Lane, Level, Samples};
use wide::{BATCH, Float, Task, Wide, run_at};

/// The greatest part of a gradient of differences, so that no part of any weight has lost a digit: from 2⁻⁶⁰
/// to 2¹²⁰.
const TAME: std::ops::Range<f32> = 8.673_617_4e-19..1.329_228e36;

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
    let kernel = Kernel { samples, field, directions: field.directions(), edges };
    run_at(level, Straight { kernel, out });
}

struct Kernel<'b, 'a, T> {
    samples: &'b Samples<'a, T>,
    field: &'b Field,
    directions: [[f32; 3]; 3],
    edges: &'b Edges,
}

/// The edges of a batch: the places of both ends along x, y, z, and what is true of each edge.
struct Batch<W: Wide> {
    axis: W::U32,
    low: [W::U32; 3],
    high: [W::U32; 3],
    /// The lower end is not a sample, or the upper one.
    is_outside: u16,
    /// Both ends have both neighbours along every axis.
    is_inner: bool,
}

/// The samples at both ends of each edge, and the differences of their neighbours along x, y, z: those
/// two steps apart, and at a border twice those one step apart. No differences where none are wanted.
struct Around<W: Wide, E: Exact> {
    ends: [E::Of<W>; 2],
    differences: Option<[[W::F32; 3]; 2]>,
}

/// All vertices of linear interpolation.
struct Straight<'k, 'b, 'a, T, C> {
    kernel: Kernel<'b, 'a, T>,
    out: Vertices<'k, C>,
}

impl<T: Lane, C: Coordinate> Task for Straight<'_, '_, '_, T, C> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        self.kernel.run(wide, self.out);
    }
}

impl<T: Lane> Kernel<'_, '_, T> {
    #[inline(always)]
    fn run<C: Coordinate>(&self, wide: impl Wide, out: Vertices<'_, C>) {
        let Vertices { positions, mut normals, odd } = out;
        assert_eq!(positions.len(), self.edges.len(), "room for every vertex");
        let mut places = [[C::default(); 3]; BATCH];
        let mut directions = [[0.0; 3]; BATCH];
        for (number, positions) in positions.chunks_mut(BATCH).enumerate() {
            let (first, own) = (number * BATCH, positions.len());
            let normals = normals.as_mut().map(|all| &mut all[first..first + own]);
            // The last batch may have less room than it has numbers.
            let is_whole = own == BATCH;
            let to = if is_whole { positions.first_chunk_mut() } else { None };
            let (is_wanted, normals_to) = match (normals, is_whole) {
                (None, _) => (false, None),
                (Some(normals), true) => (true, normals.first_chunk_mut()),
                (Some(_), false) => (true, None),
            };
            let normals_to = is_wanted.then(|| normals_to.unwrap_or(&mut directions));
            let is_odd = self.batch(wide, first, to.unwrap_or(&mut places), normals_to);
            let mut left = is_odd & (u16::MAX >> (BATCH - own));
            while left != 0 {
                odd.push(first as u32 + left.trailing_zeros());
                left &= left - 1;
            }
        }
        let (whole, rest) = positions.as_chunks_mut::<BATCH>();
        rest.copy_from_slice(&places[..rest.len()]);
        if let Some(normals) = normals {
            normals[whole.len() * BATCH..].copy_from_slice(&directions[..rest.len()]);
        }
    }

    /// The vertices of the batch that begins with edge `first`; the bits of those that are odd.
    #[inline(always)]
    fn batch<C: Coordinate, W: Wide>(
        &self,
        wide: W,
        first: usize,
        positions: &mut [[C; 3]; BATCH],
        normals: Option<&mut [[f32; 3]; BATCH]>,
    ) -> u16 {
        let batch = self.ends(wide, first);
        let around = match batch.is_inner && self.samples.is_near(1) {
            true => self.inner(wide, &batch, normals.is_some()),
            false => self.border(wide, &batch, normals.is_some()),
        };
        let (a, b) = (self.above_iso(wide, around.ends[0]), self.above_iso(wide, around.ends[1]));
        let (difference, half, reach) = (a - b, wide.f64(0.5), self.field.reach);
        let delta = (a + b) / difference * half;
        let delta = delta.max(wide.f64(-reach)).min(wide.f64(reach));
        C::write(wide, self.field.places(wide, batch.axis, batch.low, delta), positions);
        let infinite = wide.f64(f64::INFINITY);
        let is_finite = difference.less(infinite) & wide.f64(f64::NEG_INFINITY).less(difference);
        let mut is_odd = batch.is_outside | !is_finite;
        if let (Some(normals), Some(differences)) = (normals, around.differences) {
            let share = wide.f64_to_f32(half + delta);
            is_odd |= self.write_normals(wide, differences, share, normals);
        }
        is_odd
    }

    /// Values less the isovalue.
    #[inline(always)]
    fn above_iso<W: Wide>(&self, wide: W, end: <T::Exact as Exact>::Of<W>) -> W::F64 {
        let Field { iso, slope, intercept, .. } = *self.field;
        let mut value = T::Exact::to_f64(wide, end);
        // By one and nothing they are the same, but for the sign of 0, which does not matter.
        if slope != 1.0 || intercept != 0.0 {
            value = value * wide.f64(slope) + wide.f64(intercept);
        }
        value - wide.f64(iso)
    }

    /// Both ends of the edges of a batch.
    #[inline(always)]
    fn ends<W: Wide>(&self, wide: W, first: usize) -> Batch<W> {
        let [axis, x, y] = self.edges.batch(first);
        let (axis, low) = (wide.load(axis), [wide.load(x), wide.load(y), wide.u32(self.edges.z())]);
        let (zero, one) = (wide.u32(0), wide.u32(1));
        let mut high = low;
        let (mut is_sample, mut is_inner) = (u16::MAX, u16::MAX);
        for along in 0..3 {
            let is_along = wide.equal(axis, wide.u32(along as u32));
            high[along] = low[along] + wide.select(is_along, one, zero);
            // No size exceeds 2³¹ − 1, so a wrapped −1 is beyond all of them.
            let size = self.samples.dims()[along];
            let within = wide.u32(size.saturating_sub(2));
            for end in [low[along], high[along]] {
                is_sample &= wide.less(end, wide.u32(size));
                is_inner &= wide.less(end + wide.u32(u32::MAX), within);
            }
        }
        Batch { axis, low, high, is_outside: !is_sample, is_inner: is_inner == u16::MAX }
    }

    /// What is around edges that are all inner ones.
    #[inline(always)]
    fn inner<W: Wide>(
        &self,
        wide: W,
        batch: &Batch<W>,
        with_differences: bool,
    ) -> Around<W, T::Exact> {
        let strides = self.samples.strides();
        // Numbers in a slice fit, as `is_near` says.
        let steps = [wide.u32(strides[0] as u32), wide.u32(strides[1] as u32)];
        let low = batch.low[0] * steps[0] + batch.low[1] * steps[1];
        let mut step = wide.u32(strides[2] as u32);
        step = wide.select(wide.equal(batch.axis, wide.u32(1)), steps[1], step);
        step = wide.select(wide.equal(batch.axis, wide.u32(0)), steps[0], step);
        let ends = [low, low + step];
        let slice = self.samples.first() + i64::from(self.edges.z()) * strides[2];
        // SAFETY: both ends of every edge are samples, and so are their neighbours along every axis.
        unsafe {
            Around {
                ends: [
                    wide.near(self.samples, slice, ends[0]),
                    wide.near(self.samples, slice, ends[1]),
                ],
                differences: match with_differences {
                    true => Some([
                        self.differences(wide, slice, ends[0]),
                        self.differences(wide, slice, ends[1]),
                    ]),
                    false => None,
                },
            }
        }
    }

    /// The differences between the neighbours of samples, along x, y, z.
    ///
    /// # Safety
    ///
    /// Each sample must have them.
    #[inline(always)]
    unsafe fn differences<W: Wide>(&self, wide: W, from: i64, at: W::U32) -> [W::F32; 3] {
        let mut differences = [wide.f32(0.0); 3];
        for (difference, stride) in differences.iter_mut().zip(self.samples.strides()) {
            // SAFETY: the caller says so.
            let [above, below] = unsafe {
                [
                    wide.near(self.samples, from + stride, at),
                    wide.near(self.samples, from - stride, at),
                ]
            };
            *difference = T::Exact::difference(wide, above, below);
        }
        differences
    }

    /// What is around any edges. Instead of one that lies outside the first sample is looked at.
    #[inline(always)]
    fn border<W: Wide>(
        &self,
        wide: W,
        batch: &Batch<W>,
        with_differences: bool,
    ) -> Around<W, T::Exact> {
        let mut samples = [[T::Exact::default(); BATCH]; 2];
        let mut steps = [[[[T::Exact::default(); BATCH]; 2]; 3]; 2];
        let mut scales = [[[1.0; BATCH]; 3]; 2];
        for (end, places) in [batch.low, batch.high].into_iter().enumerate() {
            let [x, y, z] = [wide.store(places[0]), wide.store(places[1]), wide.store(places[2])];
            for n in 0..BATCH {
                let is_outside = batch.is_outside >> n & 1 == 1;
                let place = if is_outside { [0; 3] } else { [x[n], y[n], z[n]] };
                samples[end][n] = self.sample(place);
                for along in 0..if with_differences { 3 } else { 0 } {
                    let last = self.samples.dims()[along] - 1;
                    let to = [(place[along] + 1).min(last), place[along].saturating_sub(1)];
                    for (step, to) in to.into_iter().enumerate() {
                        let mut moved = place;
                        moved[along] = to;
                        steps[end][along][step][n] = self.sample(moved);
                    }
                    if to[0] - to[1] < 2 {
                        scales[end][along][n] = 2.0;
                    }
                }
            }
        }
        let mut differences = [[wide.f32(0.0); 3]; 2];
        for (end, along) in [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)] {
            let [above, below] = &steps[end][along];
            let (above, below) = (T::Exact::load(wide, above), T::Exact::load(wide, below));
            let difference = T::Exact::difference(wide, above, below);
            differences[end][along] = difference * wide.load_f32(&scales[end][along]);
        }
        Around {
            ends: [T::Exact::load(wide, &samples[0]), T::Exact::load(wide, &samples[1])],
            differences: if with_differences { Some(differences) } else { None },
        }
    }

    #[inline(always)]
    fn sample(&self, place: [u32; 3]) -> T::Exact {
        let (dims, strides) = (self.samples.dims(), self.samples.strides());
        debug_assert!(place.iter().zip(dims).all(|(&place, size)| place < size), "{place:?}");
        let along = |axis: usize| i64::from(place[axis]) * strides[axis];
        let number = self.samples.first() + along(0) + along(1) + along(2);
        // SAFETY: `place` is a lattice point, whose sample lies in the slice.
        unsafe { *self.samples.all().get_unchecked(number as usize) }.exact()
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
        !(is_tame & square.less(wide.f32(16.0)))
    }
}
