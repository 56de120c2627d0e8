//! What the trilinear interpolant joins: across a face, and through the interior of a cell.
//!
//! *Face.* On a face whose diagonal A, C is inside and whose other diagonal B, D is not, the saddle of the
//! bilinear interpolant is inside where A·C − B·D ≥ 0, since A + C − B − D is positive: Nielson & Hamann,
//! "The asymptotic decider", Visualization 1991, without the division.
//!
//! *Interior.* Slice the cell across one axis at t. The values at the four edges along that axis, in
//! cyclic order, are linear in t; let A(t) and C(t) have one sign and B(t) and D(t) the other. The slice
//! joins A with C where q(t) = A(t)·C(t) − B(t)·D(t) > 0 for A > 0 (and as well for A < 0, where both
//! products keep their signs). q is a quadratic in t. Where it is positive at an end of the cell a face
//! has joined the two already; so what is left to ask is whether q has a maximum within the cell, whether
//! the four signs are as said there, and whether it is positive. With q = a·t² + b·t + c and m = −2a the
//! maximum is at t = b/m, and everything is a sign of a polynomial of the corner values of the fourth
//! degree at most. Any of the three axes gives the same answer.
//!
//! It need not be asked where two corners of one face, A and C, are alone on their side and the face keeps them
//! apart. From that face to the opposite one A(t) and C(t) change sides and B(t) and D(t) stay on theirs, so as long as
//! they are apart neither |A| / |B| nor |C| / |D| grows, and q = A·C − B·D stays at 0 or below.
//!
//! *Ties.* The isovalue counts as lower by something infinitely small: a value of 0 is inside, a saddle
//! at 0 joins the inside and does not join the outside. There the interpolant's own surface is no
//! manifold, and the cell is called singular.

use super::number::{Number, Question};
use std::cmp::Ordering::{self, Equal, Greater, Less};

/// Whether the two inside corners of an ambiguous face are joined across it: values are those of the
/// corners in cyclic order, the first of them inside. The answer is that of the saddle's value with 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Saddle;

impl Question<4> for Saddle {
    type Answer = Ordering;

    #[inline(always)]
    fn answer<T: Number>(&self, [a, b, c, d]: [T; 4]) -> Option<Ordering> {
        a.times(&c).minus(&b.times(&d)).sign()
    }
}

/// Which corners the interior joins, as seen along axis 0, 1 or 2; values are those of the eight corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interior {
    pub(super) axis: usize,
}

/// A maximum of q within the cell, at which the signs are as they must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Body {
    /// The edges A and C among the four along the axis, in cyclic order: 0 and 2, or 1 and 3.
    pub(super) first: usize,
    /// Whether A and C are inside there.
    pub(super) is_inside: bool,
    /// How q compares with 0 there.
    pub(super) value: Ordering,
}

impl Body {
    /// Whether A and C are joined.
    pub(super) fn joins(self) -> bool {
        match self.is_inside {
            true => self.value != Less,
            false => self.value == Greater,
        }
    }
}

/// The lower ends of the four edges along an axis, in cyclic order.
pub(super) fn around(axis: usize) -> [usize; 4] {
    let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
    [0, u, u | v, v]
}

impl Question<8> for Interior {
    type Answer = Option<Body>;

    #[inline(always)]
    fn answer<T: Number>(&self, corners: [T; 8]) -> Option<Option<Body>> {
        let low = around(self.axis);
        let edge = |n: usize| {
            let k = low[n % 4];
            let [start, end] = [&corners[k], &corners[k | 1 << self.axis]];
            (start.clone(), end.minus(start))
        };
        let [f0, f1, f2, f3] = [edge(0), edge(1), edge(2), edge(3)];
        let curvature = f0.1.times(&f2.1).minus(&f1.1.times(&f3.1));
        // The other diagonal has −q, which bends the other way.
        let (first, curvature, [a, b, c, d]) = match curvature.sign()? {
            Less => (0, curvature, [f0, f1, f2, f3]),
            Greater => (1, curvature.minus(&curvature).minus(&curvature), [f1, f2, f3, f0]),
            Equal => return Some(None),
        };
        let slope = |[p, r]: [&(T, T); 2]| p.0.times(&r.1).plus(&r.0.times(&p.1));
        let slope = slope([&a, &c]).minus(&slope([&b, &d]));
        let run = curvature.minus(&curvature).minus(&curvature).minus(&curvature);
        if slope.sign()? != Greater || slope.minus(&run).sign()? != Less {
            return Some(None);
        }
        // Times `run`, which is positive.
        let top = |(start, rise): &(T, T)| start.times(&run).plus(&slope.times(rise)).sign();
        let side = top(&a)?;
        if side == Equal || top(&c)? != side {
            return Some(None);
        }
        for other in [top(&b)?, top(&d)?] {
            // A value of 0 is inside, whichever side A and C are on.
            if other == side || (other == Equal && side == Greater) {
                return Some(None);
            }
        }
        let start = a.0.times(&c.0).minus(&b.0.times(&d.0));
        // b² − 4ac with −4a = 2 · run.
        let rest = run.times(&start);
        let value = slope.times(&slope).plus(&rest).plus(&rest).sign()?;
        Some(Some(Body { first, is_inside: side == Greater, value }))
    }
}

#[cfg(test)]
mod tests {
    use super::{Interior, Saddle};
    use crate::trilinear::number::ask;
    use std::cmp::Ordering;

    #[test]
    fn a_saddle_on_the_isovalue_is_a_tie_at_any_scale() {
        for scale in [1.0, 1e-310, 1e300] {
            let of = |values: [f64; 4]| ask(&Saddle, values.map(|value| value * scale), None);
            assert_eq!(of([3.0, -2.0, 4.0, -6.0]), Ordering::Equal);
            assert_eq!(of([3.0, -2.0, 4.5, -6.0]), Ordering::Greater);
            assert_eq!(of([3.0, -2.5, 4.0, -6.0]), Ordering::Less);
        }
    }

    #[test]
    fn two_far_corners_are_joined_where_the_middle_is_inside() {
        // The middle of the cell has the mean of the corners; along every axis the slice there decides.
        for (rest, expected) in [(-1.0, None), (-0.2, Some(true))] {
            let mut values = [rest; 8];
            (values[0], values[7]) = (1.0, 1.0);
            for axis in 0..3 {
                let found = ask(&Interior { axis }, values, None);
                let joins = found.filter(|body| body.is_inside).map(|body| body.joins());
                assert_eq!(joins.filter(|&joins| joins), expected, "{rest}, axis {axis}");
            }
        }
    }

    #[test]
    fn a_body_saddle_on_the_isovalue_is_a_tie() {
        // Twice the product of the three distances from the middle, and the same seen from beyond.
        let sides = |k: usize| (0..3).filter(|axis| k >> axis & 1 == 1).count();
        let values = [0, 1, 2, 3, 4, 5, 6, 7].map(|k| match sides(k) {
            0 | 3 => 1.0,
            _ => -1.0 / 3.0,
        });
        let ties = values.map(|value: f64| (value * 3.0).round());
        for axis in 0..3 {
            let body = ask(&Interior { axis }, ties, None).unwrap();
            assert_eq!(body.value, Ordering::Equal, "axis {axis}");
            let lifted = ask(&Interior { axis }, ties.map(|value| value + 1e-9), None).unwrap();
            assert!(lifted.is_inside && lifted.joins(), "axis {axis}");
            let lowered = ask(&Interior { axis }, ties.map(|value| value - 1e-9), None).unwrap();
            assert!(!(lowered.is_inside && lowered.joins()), "axis {axis}");
        }
    }
}
