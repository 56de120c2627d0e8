//! The roots of cubics, 16 at a time, and two times 16 in turn.
//!
//! `vertex/curve.rs` of `marching-cubes` has the definition, for one, with the same operations in the same
//! order, so that the bits are the same, and says why. There is no loop that ends sooner for one edge than for
//! another. The roots that the short way there does not find, a few in ten thousand, are left to the caller.
//!
//! Each operation needs what the one before gives. So two batches go side by side, and while one waits the
//! other is worked at.

use super::{
    curves::Line,
    wide::{Float, Task, Wide},
};

/// Steps of Halley's in f32.
const STEPS: usize = 2;

/// Corrections in f64.
const CORRECTIONS: usize = 2;

/// If the last is so small, a root is found.
const SMALL: f64 = 1.0 / (1_u64 << 36) as f64;

/// Finds where lines are crossed, as far as `reach` from the middle of their edges.
pub(super) struct Roots<'a> {
    pub(super) lines: &'a mut [[Line; 2]],
    pub(super) reach: f64,
}

impl Task for Roots<'_> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let (least, most) = (wide.f64(-self.reach), wide.f64(self.reach));
        for lines in self.lines {
            let (roots, is_lost) = cross(wide, lines);
            for ((line, root), is_lost) in lines.iter_mut().zip(roots).zip(is_lost) {
                // Within half an edge they are already.
                let root = if self.reach < 0.5 { root.max(least).min(most) } else { root };
                wide.store_f64(root, &mut line.delta);
                line.is_odd |= is_lost;
            }
        }
    }
}

/// An expression for the first of two, and for the second. A macro, since closures are not always inlined into
/// the function that a level's instructions are enabled for.
macro_rules! both {
    ($n:ident => $value:expr) => {{
        let first = {
            let $n = 0;
            $value
        };
        let second = {
            let $n = 1;
            $value
        };
        [first, second]
    }};
}

/// Where cubics through four values cross the edge in their middle, or the straight lines do if those ring; the
/// bits of those that have yet to be found.
#[inline(always)]
fn cross<W: Wide>(wide: W, lines: &[Line; 2]) -> ([W::F64; 2], [u16; 2]) {
    let (zero, half) = (wide.f64(0.0), wide.f64(0.5));
    let a = both!(n => wide.load_f64(&lines[n].values[1]));
    let b = both!(n => wide.load_f64(&lines[n].values[2]));
    let rise = both!(n => b[n] - a[n]);
    let straight = both!(n => (a[n] + b[n]) / rise[n] * wide.f64(-0.5));
    let scale = both!(n => wide.f64(0.25) / rise[n]);
    let before = both!(n => wide.load_f64(&lines[n].values[0]));
    let after = both!(n => wide.load_f64(&lines[n].values[3]));
    let even = both!(n =>
        ((before[n] + after[n]) - (a[n] + b[n])) * scale[n]
    );
    let odd = both!(n =>
        ((after[n] - before[n]) * wide.f64(1.0 / 3.0) - rise[n]) * (scale[n] + scale[n])
    );
    let narrow = Narrow::<W> {
        even: both!(n => wide.f64_to_f32(even[n])),
        odd: both!(n => wide.f64_to_f32(odd[n])),
        straight: both!(n => wide.f64_to_f32(straight[n])),
    };
    let is_plain = narrow.is_plain(wide);
    let (s, factor, is_good) = narrow.roots(wide);
    // Corrected by what is one over the slope.
    let mut s = both!(n => wide.f32_to_f64(s[n]));
    let factor = both!(n => wide.f32_to_f64(factor[n]));
    let mut step = s;
    for _ in 0..CORRECTIONS {
        let edge = both!(n => s[n] * s[n] - wide.f64(0.25));
        let both = both!(n => even[n] + s[n] * odd[n]);
        let value = both!(n => (s[n] - straight[n]) + edge[n] * both[n]);
        step = both!(n => value[n] * factor[n]);
        s = both!(n => s[n] - step[n]);
    }
    // At a sample that is the isovalue there is nothing to search.
    let is_curved = both!(n => is_plain[n] & straight[n].abs().less(half));
    let is_small = both!(n => step[n].abs().less(wide.f64(SMALL)));
    let is_on_edge = both!(n => !half.less(s[n].abs()));
    let is_found = both!(n => is_good[n] & is_small[n] & is_on_edge[n]);
    // No finite rise, no line.
    let is_finite = both!(n => zero.less(scale[n].abs()));
    (
        both!(n => wide.select_f64(is_curved[n], s[n], straight[n])),
        both!(n => !is_finite[n] | (is_curved[n] & !is_found[n])),
    )
}

/// Cubics less the isovalue over the difference of the ends, in f32: their even parts, their odd parts, and
/// where they were crossed without both.
struct Narrow<W: Wide> {
    even: [W::F32; 2],
    odd: [W::F32; 2],
    straight: [W::F32; 2],
}

impl<W: Wide> Narrow<W> {
    /// The coefficients of s, and of 1 with the other sign.
    #[inline(always)]
    fn line(&self, wide: W) -> [[W::F32; 2]; 2] {
        let (one, quarter) = (wide.f32(1.0), wide.f32(0.25));
        [
            both!(n => one - quarter * self.odd[n]),
            both!(n => self.straight[n] + quarter * self.even[n]),
        ]
    }

    /// Those that are monotone on the edge, or convex or concave.
    #[inline(always)]
    fn is_plain(&self, wide: W) -> [u16; 2] {
        let ([linear, _], Self { even, odd, .. }) = (self.line(wide), self);
        let (zero, one, half, three) = (wide.f32(0.0), wide.f32(1.0), wide.f32(0.5), wide.f32(3.0));
        both!(n => {
            let (twice, thrice) = (even[n] + even[n], three * odd[n]);
            let turns = twice.abs().less(thrice.abs());
            let ends_rise = !(one + half * odd[n]).less(even[n].abs());
            let rises = odd[n].less(zero) | !(thrice * linear[n]).less(even[n] * even[n]);
            !turns | (ends_rise & rises)
        })
    }

    /// Places near to the roots, one over the slope there, and the bits of those where that is fit to be used.
    #[inline(always)]
    fn roots(&self, wide: W) -> ([W::F32; 2], [W::F32; 2], [u16; 2]) {
        let ([linear, fall], Self { even, odd, .. }) = (self.line(wide), self);
        let (zero, one, two) = (wide.f32(0.0), wide.f32(1.0), wide.f32(2.0));
        let flat = both!(n => one - wide.f32(0.0625) * odd[n]);
        let square = both!(n => flat[n] * flat[n] + wide.f32(4.0) * even[n] * fall[n]);
        let root = both!(n => square[n].max(zero).sqrt());
        let mut s = both!(n => (fall[n] + fall[n]) / (flat[n] + root[n]));
        let mut factor = s;
        for _ in 0..STEPS {
            let [second, steep, slope] = self.slopes(s, linear);
            let value = both!(n => second[n] * s[n] - fall[n]);
            let bend = both!(n => odd[n] * s[n] + steep[n]);
            let pull = both!(n => slope[n] * slope[n] - value[n] * bend[n]);
            factor = both!(n => slope[n] / pull[n]);
            s = both!(n => s[n] - value[n] * factor[n]);
        }
        let [_, _, slope] = self.slopes(s, linear);
        let factor = both!(n => factor[n] * (two - slope[n] * factor[n]));
        let is_good = both!(n => zero.less(slope[n]) & zero.less(factor[n]));
        (s, factor, is_good)
    }

    /// By Horner's rule what is multiplied by s in the value, what is in the slope, and the slope.
    #[inline(always)]
    fn slopes(&self, s: [W::F32; 2], linear: [W::F32; 2]) -> [[W::F32; 2]; 3] {
        let Self { even, odd, .. } = *self;
        let third = both!(n => odd[n] * s[n]);
        let first = both!(n => third[n] + even[n]);
        let second = both!(n => first[n] * s[n] + linear[n]);
        let steep = both!(n => first[n] + third[n]);
        [second, steep, both!(n => steep[n] * s[n] + second[n])]
    }
}
