//! Where edges are crossed by cubics, 16 edges at a time.
//!
//! `vertex/curve.rs` of `marching-cubes` has the definition, for one edge, with the same operations in the
//! same order, so that the bits are the same. Here all sixteen search until the last has found its root;
//! those that have it wait. Edges that are not between inner samples, or whose values are not finite, are
//! called odd and left to the caller.

use super::{Batch, Field, Kernel, wide};
use crate::{Coordinate, Edges, Lane, Level, Samples};
use wide::{BATCH, Float, Plain, Wide};

/// Steps after which a root is taken as it is.
const STEPS: usize = 96;

/// A step so short ends the search.
const SHORT: f64 = 1.0 / (1_u64 << 20) as f64;

/// And one so short if it halves the bracket.
const SHORTEST: f64 = 1.0 / (1_u64 << 42) as f64;

/// Where vertices on cubics go.
#[derive(Debug)]
pub struct Crossings<'a, C> {
    /// Places in world space.
    pub positions: &'a mut [[C; 3]],
    /// The same in edge lengths from the middle of the edge, if somebody wants them.
    pub deltas: Option<&'a mut [f64]>,
    /// The numbers of the odd edges are added here: those have yet to be placed.
    pub odd: &'a mut Vec<u32>,
}

/// Places vertices where the cubic through the four samples nearest on the line of an edge has the isovalue;
/// where the cubic rings, where the straight line has it.
///
/// # Panics
///
/// If `out` has not room for exactly one vertex per edge.
pub fn cubic_crossings<T: Lane, C: Coordinate>(
    samples: &Samples<'_, T>,
    field: &Field,
    edges: &Edges,
    out: Crossings<'_, C>,
) {
    let level = Level::current();
    let kernel = Kernel { samples, field, directions: [[0.0; 3]; 3], edges };
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { kernel.cubics_avx512(out) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { kernel.cubics_avx2(out) }
        }
        _ => kernel.cubics(Plain, out),
    }
}

impl<T: Lane> Kernel<'_, '_, T> {
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    fn cubics_avx2<C: Coordinate>(&self, out: Crossings<'_, C>) {
        self.cubics(Plain, out);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
    fn cubics_avx512<C: Coordinate>(&self, out: Crossings<'_, C>) {
        // SAFETY: this function runs only where the machine has AVX-512 F, BW, DQ and VL.
        self.cubics(unsafe { wide::Avx512::new() }, out);
    }

    #[inline(always)]
    fn cubics<C: Coordinate>(&self, wide: impl Wide, out: Crossings<'_, C>) {
        let Crossings { positions, mut deltas, odd } = out;
        assert_eq!(positions.len(), self.edges.len(), "room for every vertex");
        let mut places = [[C::default(); 3]; BATCH];
        let mut thrice = [[0.0; 3]; BATCH];
        for (number, positions) in positions.chunks_mut(BATCH).enumerate() {
            let (first, own) = (number * BATCH, positions.len());
            let wanted = deltas.is_some().then_some(&mut thrice);
            // The last batch may have less room than it has numbers.
            let is_odd = match positions.first_chunk_mut() {
                Some(positions) => self.batch_of_cubics(wide, first, positions, wanted),
                None => {
                    let is_odd = self.batch_of_cubics(wide, first, &mut places, wanted);
                    positions.copy_from_slice(&places[..own]);
                    is_odd
                }
            };
            if let Some(deltas) = &mut deltas {
                for (delta, [own, ..]) in deltas[first..first + own].iter_mut().zip(&thrice) {
                    *delta = *own;
                }
            }
            let mut left = is_odd & (u16::MAX >> (BATCH - own));
            while left != 0 {
                odd.push(first as u32 + left.trailing_zeros());
                left &= left - 1;
            }
        }
    }

    /// The vertices of the batch that begins with edge `first`; the bits of those that are odd.
    #[inline(always)]
    fn batch_of_cubics<C: Coordinate, W: Wide>(
        &self,
        wide: W,
        first: usize,
        positions: &mut [[C; 3]; BATCH],
        deltas: Option<&mut [[f64; 3]; BATCH]>,
    ) -> u16 {
        let mut batch = self.ends(wide, first);
        let is_outer = if batch.is_inner { 0 } else { self.keep_inner(wide, &mut batch) };
        if is_outer == u16::MAX || !self.samples.is_near() {
            return u16::MAX;
        }
        let strides = self.samples.strides();
        // Numbers in a slice fit, as `is_near` says.
        let steps = [wide.u32(strides[0] as u32), wide.u32(strides[1] as u32)];
        let low = batch.low[0] * steps[0] + batch.low[1] * steps[1];
        let mut step = wide.u32(strides[2] as u32);
        step = wide.select(wide.equal(batch.axis, wide.u32(1)), steps[1], step);
        step = wide.select(wide.equal(batch.axis, wide.u32(0)), steps[0], step);
        let high = low + step;
        let places = [low + step * wide.u32(u32::MAX), low, high, high + step];
        let slice = self.samples.first() + i64::from(self.edges.z()) * strides[2];
        let mut values = [wide.f64(0.0); 4];
        for (value, at) in values.iter_mut().zip(places) {
            // SAFETY: both ends of every edge are samples, and so are their neighbours along every axis.
            let sample = unsafe { wide.near(self.samples, slice, at) };
            *value = self.above_iso(wide, sample);
        }
        let [_, a, b, _] = values;
        let (difference, reach) = (a - b, self.field.reach);
        let straight = (a + b) / difference * wide.f64(0.5);
        let delta = cubic(wide, values, straight);
        let delta = delta.max(wide.f64(-reach)).min(wide.f64(reach));
        C::write(wide, self.places(wide, &batch, delta), positions);
        if let Some(deltas) = deltas {
            wide.interleave_f64([delta; 3], deltas);
        }
        let infinite = wide.f64(f64::INFINITY);
        is_outer | !(difference.less(infinite) & wide.f64(f64::NEG_INFINITY).less(difference))
    }

    /// Puts an edge that is an inner one in the place of those that are not; the bits of those.
    #[inline(always)]
    fn keep_inner<W: Wide>(&self, wide: W, batch: &mut Batch<W>) -> u16 {
        let mut is_inner = u16::MAX;
        for along in 0..3 {
            // No size exceeds 2³¹ − 1, so a wrapped −1 is beyond all of them.
            let within = wide.u32(self.samples.dims()[along].saturating_sub(2));
            for end in [batch.low[along], batch.high[along]] {
                is_inner &= wide.less(end + wide.u32(u32::MAX), within);
            }
        }
        if is_inner != 0 {
            let kept = is_inner.trailing_zeros() as usize;
            let [low, high] = [&mut batch.low, &mut batch.high];
            for numbers in low.iter_mut().chain(high).chain([&mut batch.axis]) {
                *numbers = wide.select(is_inner, *numbers, wide.u32(wide.store(*numbers)[kept]));
            }
        }
        !is_inner
    }
}

/// The roots of cubics through four values, where those do not ring; else what `straight` is.
#[inline(always)]
fn cubic<W: Wide>(wide: W, [before, a, b, after]: [W::F64; 4], straight: W::F64) -> W::F64 {
    let (zero, one, half) = (wide.f64(0.0), wide.f64(1.0), wide.f64(0.5));
    let (rise, infinite) = (b - a, wide.f64(f64::INFINITY));
    let scale = one / rise;
    let even = ((before + after) * half - (a + b) * half) * half * scale;
    let odd = ((after - before) / wide.f64(3.0) - rise) * half * scale;
    let (even_size, odd_size) = (even.max(zero - even), odd.max(zero - odd));
    let turns = (wide.f64(2.0) * even_size).less(wide.f64(3.0) * odd_size);
    let ends_rise = !(one + half * odd).less(even_size);
    let least = odd * (wide.f64(3.0) - wide.f64(0.75) * odd);
    let rises = ends_rise & (odd.less(zero) | !least.less(even * even));
    let mut active = even_size.less(infinite) & odd_size.less(infinite) & (!turns | rises);
    let (mut low, mut high) = (wide.f64(-0.5), half);
    let (mut s, mut last) = (straight, wide.f64(4.0));
    for _ in 0..STEPS {
        if active == 0 {
            break;
        }
        let edge = s * s - wide.f64(0.25);
        let both = even + s * odd;
        let twice = wide.f64(2.0) * s;
        let value = (s - straight) + edge * both;
        let slope = one + twice * both + edge * odd;
        let bend = both + twice * odd;
        low = wide.select_f64(zero.less(value), low, s);
        high = wide.select_f64(value.less(zero), high, s);
        let (steep, pull) = (slope * slope, value * bend);
        let next = s - value * slope / (steep - pull);
        let step = next - s;
        let size = step.max(zero - step);
        let is_good = !next.less(low) & !high.less(next) & next.less(one);
        let is_good = is_good & !last.less(wide.f64(8.0) * size);
        let is_good = is_good & !(half * steep).less(pull.max(zero - pull));
        let next = wide.select_f64(is_good, next, (low + high) * half);
        let step = next - s;
        let size = step.max(zero - step);
        s = wide.select_f64(active, next, s);
        last = size;
        let enough = wide.select_f64(is_good, wide.f64(SHORT), wide.f64(SHORTEST));
        active &= enough.less(size);
    }
    s
}
