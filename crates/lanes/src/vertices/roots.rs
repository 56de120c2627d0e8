//! The roots of cubics and quintics, 16 at a time.
//!
//! `vertex/curve/short.rs` of `marching-cubes` has the definition, for one, with the same operations in the same
//! order, so that the bits are the same, and says why. The roots that this way does not find, fewer than
//! one in five hundred, are left to the caller.
//!
//! What does not go well becomes NaN, of which no comparison holds: so it is not found, and no mask is kept.
//!
//! Each operation needs what the one before gives. So the way is taken in stages, each by several batches in turn:
//! a stage is short enough for the machine to work at some batches at once.

use super::{
    Coordinate,
    curves::{Crossing, Line},
};
use crate::wide::{BATCH, Float, Mask, Task, Wide};
use std::ops::Range;

/// The rises of which no f32 that counts overflows or loses a digit: 2⁻⁶⁰ to 2⁶⁰.
const TAME: Range<f32> = 8.673_617_4e-19..1.152_921_5e18;

/// If the correction is so small, a root is found.
const SMALL: f64 = 1.0 / (1_u64 << 21) as f64;

/// Where no correction follows, the last step is no longer.
const SHORT: f32 = 1.0 / 512.0;

/// And no more of it is due to the bend.
const BENT: f32 = 1.0 / 128.0;

/// And the slope is no less, over the rise.
const STEEP: f32 = 1.0 / 8.0;

/// Finds where lines are crossed, as far as `reach` from the middle of their edges. Values of f64 are used up.
pub struct Roots<'a, C> {
    pub(super) batches: (&'a mut [Line<C>], &'a mut [Crossing]),
    pub(super) searches: &'a mut [Search],
    /// Pairs of samples on a line, 2 or 3.
    pub(super) pairs: usize,
    pub(super) reach: f64,
}

impl<C: Coordinate> Task for Roots<'_, C> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        match self.pairs {
            2 => self.find::<W, 2>(wide),
            _ => self.find::<W, 3>(wide),
        }
    }
}

impl<C: Coordinate> Roots<'_, C> {
    #[inline(always)]
    fn find<W: Wide, const PAIRS: usize>(self, wide: W) {
        let (lines, crossings) = self.batches;
        let searches = &mut self.searches[..lines.len()];
        for (line, search) in lines.iter_mut().zip(&mut *searches) {
            search.begin::<W, C, PAIRS>(wide, line);
        }
        for (line, search) in lines.iter_mut().zip(&mut *searches) {
            search.first_step::<W, C, PAIRS>(wide, line);
        }
        for search in &mut *searches {
            search.step::<W, PAIRS>(wide);
        }
        C::finish::<W, PAIRS>(wide, (lines, searches), crossings);
        if self.reach < 0.5 {
            // Within half an edge they are already.
            let (least, most) = (wide.f64(-self.reach), wide.f64(self.reach));
            for Crossing { delta, .. } in crossings {
                wide.store_f64(wide.load_f64(delta).max(least).min(most), delta);
            }
        }
    }
}

/// What is known of the roots of a batch in f32: the curves over their rises, c₁s + c₂s² + … + c₅s⁵ − fall, and how
/// far the search is.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Search {
    fall: [f32; BATCH],
    c: [[f32; BATCH]; 5],
    /// One over the rise, for f64; NaN where that is not tame.
    scale: [f32; BATCH],
    /// The place.
    s: [f32; BATCH],
    /// One over the slope near there, for f64; NaN where the search did not go well.
    factor: [f32; BATCH],
    /// If an end is the isovalue anywhere, between what all roots lie: there both are that end.
    between: [[f32; BATCH]; 2],
    /// Where an end is.
    is_end: u16,
}

impl Search {
    pub(super) const DEFAULT: Self = Self {
        fall: [0.0; BATCH],
        c: [[0.0; BATCH]; 5],
        scale: [0.0; BATCH],
        s: [0.0; BATCH],
        factor: [0.0; BATCH],
        between: [[0.0; BATCH]; 2],
        is_end: 0,
    };

    /// Takes the values of lines, and of f64, whose roots will be corrected, leaves in their place the sums of the ends, the
    /// rises, and the even and the odd parts times the rises. The search gets the curves, and begins where straight lines
    /// are crossed.
    #[inline(always)]
    fn begin<W: Wide, C: Coordinate, const PAIRS: usize>(&mut self, wide: W, line: &mut Line<C>) {
        let (zero, half) = (C::splat(wide, 0.0), C::splat(wide, 0.5));
        let a = C::load(wide, &line.values[PAIRS - 1]);
        let b = C::load(wide, &line.values[PAIRS]);
        let (sum, rise) = (a + b, b - a);
        let is_end = !(a.min(b).less(zero) & zero.less(a.max(b)));
        let below = C::load(wide, &line.values[PAIRS - 2]);
        let above = C::load(wide, &line.values[PAIRS + 1]);
        let even = below + above;
        let odd = (above - below) * C::splat(wide, 1.0 / 3.0);
        let (a, b) = (even - sum, odd - rise);
        let mut parts = [a * C::splat(wide, 0.25), b * half, zero, zero];
        if PAIRS == 3 {
            let below = C::load(wide, &line.values[0]);
            let above = C::load(wide, &line.values[2 * PAIRS - 1]);
            let a_u = ((below + above) - even) * half - a;
            let b_u = ((above - below) * C::splat(wide, 1.0 / 5.0) - odd) * half - b;
            parts[2] = a_u * C::splat(wide, 1.0 / 24.0);
            parts[3] = b_u * C::splat(wide, 1.0 / 12.0);
        }
        let narrow_rise = C::to_f32(wide, rise);
        let size = narrow_rise.abs();
        let is_tame = size.less(wide.f32(TAME.end)) & !size.less(wide.f32(TAME.start));
        let scale = wide.select_f32(is_tame, wide.f32(1.0) / narrow_rise, wide.f32(f32::NAN));
        let straight = C::to_f32(wide, sum) * scale * wide.f32(-0.5);
        let is_end = is_end & is_tame;
        self.is_end = is_end.bits();
        if self.is_end != 0 {
            let (is_low, low, high) = (straight.less(wide.f32(0.0)), wide.f32(-0.5), wide.f32(0.5));
            let [least, most] = &mut self.between;
            wide.store_f32(wide.select_f32(is_end & !is_low, high, low), least);
            wide.store_f32(wide.select_f32(is_end & is_low, low, high), most);
        }
        let mut narrow = [straight; 4];
        for n in 0..2 * PAIRS - 2 {
            narrow[n] = C::to_f32(wide, parts[n]) * scale;
        }
        if C::IS_DOUBLE {
            let [even, odd, even_u, odd_u] = parts;
            let held = [sum, rise, even, odd, even_u, odd_u];
            for (part, to) in held.into_iter().zip(&mut line.values[..2 * PAIRS]) {
                C::store(wide, part, to);
            }
            wide.store_f32(scale, &mut self.scale);
        }
        self.keep::<W, PAIRS>(wide, Curves::new::<PAIRS>(wide, straight, narrow));
        wide.store_f32(straight, &mut self.s);
    }

    /// From where straight lines are crossed to where parabolas are. Curves that are not plain become straight.
    #[inline(always)]
    fn first_step<W: Wide, C: Coordinate, const PAIRS: usize>(
        &mut self,
        wide: W,
        line: &mut Line<C>,
    ) {
        let mut curves = self.curves::<W, PAIRS>(wide);
        let is_plain = curves.is_plain::<PAIRS>(wide);
        if is_plain.bits() != u16::MAX {
            let straight = wide.load_f32(&self.s);
            curves = curves.straightened::<PAIRS>(wide, is_plain, straight);
            let parts = if C::IS_DOUBLE { &mut line.values[2..2 * PAIRS] } else { &mut [] };
            for part in parts {
                let (own, none) = (C::load(wide, part), C::splat(wide, 0.0));
                C::store(wide, C::select(wide, is_plain, own, none), part);
            }
            self.keep::<W, PAIRS>(wide, curves);
        }
        wide.store_f32(curves.of_parabola::<PAIRS>(wide), &mut self.s);
    }

    #[inline(always)]
    fn keep<W: Wide, const PAIRS: usize>(&mut self, wide: W, curves: Curves<W>) {
        wide.store_f32(curves.fall, &mut self.fall);
        for (c, to) in curves.c.into_iter().zip(&mut self.c[..2 * PAIRS - 1]) {
            wide.store_f32(c, to);
        }
    }

    #[inline(always)]
    fn curves<W: Wide, const PAIRS: usize>(&self, wide: W) -> Curves<W> {
        let mut c = [wide.f32(0.0); 5];
        for (c, from) in c.iter_mut().zip(&self.c[..2 * PAIRS - 1]) {
            *c = wide.load_f32(from);
        }
        Curves { fall: wide.load_f32(&self.fall), c }
    }

    /// A step of Halley's. By how much of the value it went is given back.
    #[inline(always)]
    fn step<W: Wide, const PAIRS: usize>(&mut self, wide: W) -> W::F32 {
        let s = wide.load_f32(&self.s);
        let [value, slope, bend] = self.curves::<W, PAIRS>(wide).at::<PAIRS>(s);
        let factor = slope / (slope * slope - value * bend);
        wide.store_f32(s - value * factor, &mut self.s);
        factor
    }

    /// Another, and one over the slope where it ends.
    #[inline(always)]
    pub(super) fn last_step<W: Wide, const PAIRS: usize>(&mut self, wide: W) {
        let factor = self.step::<W, PAIRS>(wide);
        let s = wide.load_f32(&self.s);
        let [_, slope, _] = self.curves::<W, PAIRS>(wide).at::<PAIRS>(s);
        let one = wide.f32(1.0);
        let is_near = (one - slope * factor).abs().less(wide.f32(1.0 / 32.0));
        let is_good = wide.f32(0.0).less(slope) & is_near;
        wide.store_f32(wide.select_f32(is_good, one / slope, wide.f32(f32::NAN)), &mut self.factor);
    }

    /// Another step of Halley's, to the roots. Those that have yet to be found are called odd.
    #[inline(always)]
    pub(super) fn step_to<W: Wide, const PAIRS: usize>(&self, wide: W, crossing: &mut Crossing) {
        let s = wide.load_f32(&self.s);
        let [value, slope, bend] = self.curves::<W, PAIRS>(wide).at::<PAIRS>(s);
        let (steep, pull) = (slope * slope, value * bend);
        let step = value * (slope / (steep - pull));
        let s = s - step;
        // What is left falls with the cube of the step, and with the square of how much it turned.
        let is_short = step.abs().less(wide.f32(SHORT));
        let is_little = pull.abs().less(wide.f32(BENT) * steep);
        let is_found =
            is_short & is_little & wide.f32(STEEP).less(slope) & !wide.f32(0.5).less(s.abs());
        self.end(wide, wide.f32_to_f64(s), is_found, crossing);
    }

    /// From roots in f32 to those of what is held in place of the values on lines.
    #[inline(always)]
    pub(super) fn correct<W: Wide, const PAIRS: usize>(
        &self,
        wide: W,
        line: &Line<f64>,
        crossing: &mut Crossing,
    ) {
        let half = wide.f64(0.5);
        let mut held = [half; 6];
        for (held, from) in held.iter_mut().zip(&line.values[..2 * PAIRS]) {
            *held = wide.load_f64(from);
        }
        let [sum, rise, even, odd, even_u, odd_u] = held;
        let s = wide.f32_to_f64(wide.load_f32(&self.s));
        let factor = wide.load_f32(&self.factor) * wide.load_f32(&self.scale);
        let square = s * s;
        let (mut a, mut b) = (even, odd);
        if PAIRS == 3 {
            let v = square - wide.f64(2.25);
            (a, b) = (a + v * even_u, b + v * odd_u);
        }
        let value = (s * rise + sum * half) + (square - wide.f64(0.25)) * (a + s * b);
        let step = value * wide.f32_to_f64(factor);
        let s = s - step;
        let is_found = step.abs().less(wide.f64(SMALL)) & !half.less(s.abs());
        self.end(wide, s, is_found, crossing);
    }

    /// Where an end is the isovalue there was nothing to search: that is the root.
    #[inline(always)]
    fn end<W: Wide>(&self, wide: W, mut s: W::F64, is_found: W::Mask, crossing: &mut Crossing) {
        crossing.is_odd |= !(self.is_end | is_found.bits());
        if self.is_end != 0 {
            let [least, most] = &self.between;
            let (least, most) = (wide.load_f32(least), wide.load_f32(most));
            s = s.max(wide.f32_to_f64(least)).min(wide.f32_to_f64(most));
        }
        wide.store_f64(s, &mut crossing.delta);
    }
}

/// Curves over their rises.
#[derive(Clone, Copy)]
struct Curves<W: Wide> {
    fall: W::F32,
    c: [W::F32; 5],
}

impl<W: Wide> Curves<W> {
    #[inline(always)]
    fn new<const PAIRS: usize>(wide: W, straight: W::F32, parts: [W::F32; 4]) -> Self {
        let ([mut a, mut b, a_u, b_u], quarter) = (parts, wide.f32(0.25));
        let (mut c2, mut c3) = (a, b);
        if PAIRS == 3 {
            (a, b) = (a - wide.f32(2.25) * a_u, b - wide.f32(2.25) * b_u);
            (c2, c3) = (a - quarter * a_u, b - quarter * b_u);
        }
        let c1 = wide.f32(1.0) - quarter * b;
        Self { fall: straight + quarter * a, c: [c1, c2, c3, a_u, b_u] }
    }

    /// With straight lines in place of those that are not plain.
    #[inline(always)]
    fn straightened<const PAIRS: usize>(
        mut self,
        wide: W,
        is_plain: W::Mask,
        straight: W::F32,
    ) -> Self {
        self.fall = wide.select_f32(is_plain, self.fall, straight);
        self.c[0] = wide.select_f32(is_plain, self.c[0], wide.f32(1.0));
        for n in 1..2 * PAIRS - 1 {
            self.c[n] = wide.select_f32(is_plain, self.c[n], wide.f32(0.0));
        }
        self
    }

    /// Those that are monotone on the edge, or convex or concave.
    #[inline(always)]
    fn is_plain<const PAIRS: usize>(&self, wide: W) -> W::Mask {
        let [c1, c2, c3, c4, c5] = self.c;
        let (zero, one, half, three) = (wide.f32(0.0), wide.f32(1.0), wide.f32(0.5), wide.f32(3.0));
        if PAIRS == 2 {
            let (twice, thrice) = (c2 + c2, three * c3);
            let turns = twice.abs().less(thrice.abs());
            let ends_rise = !(one + half * c3).less(c2.abs());
            let rises = c3.less(zero) | !(thrice * c1).less(c2 * c2);
            return !turns | (ends_rise & rises);
        }
        let (d1, d2) = (c2, wide.f32(0.75) * c3);
        let (d3, d4) = (half * c4, wide.f32(0.3125) * c5);
        let third = wide.f32(1.0 / 3.0);
        let rising = [
            (c1, wide.f32(0.25) * d1),
            (c1 + d2 * wide.f32(1.0 / 6.0), half * d1),
            (c1 + half * d2, wide.f32(0.75) * d1 + wide.f32(0.25) * d3),
            (c1 + (d2 + d4), d1 + d3),
        ];
        let bending = [
            (d1, (third + third) * d2),
            (d1 + d3, (one + third) * d2),
            (d1 + three * d3, (d2 + d2) + wide.f32(4.0) * d4),
        ];
        let none = wide.mask(0);
        let (mut falls, mut bends_down, mut bends_up) = (none, none, none);
        for (even, odd) in rising {
            falls = falls | (even - odd.abs()).less(zero);
        }
        for (even, odd) in bending {
            bends_down = bends_down | (even - odd.abs()).less(zero);
            bends_up = bends_up | zero.less(even + odd.abs());
        }
        !(falls & bends_down & bends_up)
    }

    /// The roots of parabolas that are near.
    #[inline(always)]
    fn of_parabola<const PAIRS: usize>(&self, wide: W) -> W::F32 {
        let [c1, c2, c3, c4, c5] = self.c;
        let (mut fall, mut second, mut first) = (self.fall, c2, c1 + wide.f32(0.1875) * c3);
        if PAIRS == 3 {
            fall = fall + wide.f32(0.0078125) * c4;
            second = second + wide.f32(0.25) * c4;
            first = first + wide.f32(0.0390625) * c5;
        }
        let square = (first * first + wide.f32(4.0) * second * fall).max(wide.f32(0.0));
        (fall + fall) / (first + square.sqrt())
    }

    /// Values, slopes, and halves of second derivatives, by Horner's rule.
    #[inline(always)]
    fn at<const PAIRS: usize>(&self, s: W::F32) -> [W::F32; 3] {
        let ([c1, c2, c3, c4, c5], fall) = (self.c, self.fall);
        if PAIRS == 2 {
            let third = c3 * s;
            let first = third + c2;
            let second = first * s + c1;
            let steep = first + third;
            return [second * s - fall, steep * s + second, third + steep];
        }
        let fifth = c5 * s;
        let b4 = fifth + c4;
        let (b3, d3) = (b4 * s + c3, fifth + b4);
        let (b2, d2, e2) = (b3 * s + c2, d3 * s + b3, fifth + d3);
        let (b1, d1, e1) = (b2 * s + c1, d2 * s + b2, e2 * s + d2);
        [b1 * s - fall, d1 * s + b1, e1 * s + d1]
    }
}
