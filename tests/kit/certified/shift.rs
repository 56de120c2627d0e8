//! The number that stands for an infinitesimal where a saddle is exactly 0.
//!
//! The surface at −ε is the same, up to a homeomorphism of the cell, for all ε between 0 and the least
//! magnitude of a negative critical value: of the field in the cell, on a face, on an edge, at a corner. The
//! values of `K·f + 1` are those of `f + 1/K`, and integers. So K has to exceed 1 over that magnitude.
//!
//! - Corners, and edges with them: integers, so K ≥ 2 will do.
//! - A face with corners A, B, C, D in cyclic order: its saddle is n/e, with n = AC − BD, e = A + C − B − D.
//! - The inside: put A(t) … D(t) for the four edges along one axis. At a critical point of value c at height
//!   t, (A−c)(C−c) − (B−c)(D−c) = q(t) − c·e(t) has a double zero at t: where e(t) is not 0, the saddle
//!   q/e of the slice is stationary there; where it is 0 the slice is constant. With q = at² + bt + n and
//!   e = e₀ + e₁t, c is a root of (b − c·e₁)² − 4a(n − c·e₀) = Pc² + Qc + R. If that vanishes for every c
//!   while e does not, a = b = e₁ = 0 and c = n/e₀ is the saddle of a face; if e vanishes too, use another
//!   axis, and if it does so on all three, the field is linear and a critical value is that of a corner.
//!   A root c between −1 and 0 is at least |R| / (|P| + |Q|) in magnitude, or |Q/P| if R is 0.

use isokit::geom::cube::{Corner, Face};

/// Values must be below this for the bound of a singular cell, whose terms are at most 128 times the
/// fourth power.
const LARGEST: i128 = 1 << 29;

/// Fields to subdivide in turn until one ends: the values themselves and, where it can be had, `K·f + 1`,
/// which comes first if a critical value may be 0.
pub(super) fn attempts(corners: [i64; 8]) -> Vec<[i128; 8]> {
    let mut values = corners.map(i128::from);
    let factor = values.iter().fold(0, |a, &b| gcd(a, b)).max(1);
    values = values.map(|v| v / factor);
    let mut attempts = vec![values];
    if let Some(Bound { scale, singular }) = bound(&values) {
        attempts.insert(usize::from(!singular), values.map(|v| v * scale + 1));
    }
    attempts
}

struct Bound {
    /// K.
    scale: i128,
    /// Whether a saddle is 0, of a face or of the box, if need be beyond its border.
    singular: bool,
}

fn bound(values: &[i128; 8]) -> Option<Bound> {
    if values.iter().any(|v| v.abs() >= LARGEST) {
        return None;
    }
    let mut bound = Bound { scale: 2, singular: false };
    // K > numerator / denominator
    let mut exceed = |numerator: i128, denominator: i128| match denominator {
        0 => bound.singular = true,
        _ => bound.scale = bound.scale.max(numerator.abs() / denominator.abs() + 1),
    };
    for face in Face::all() {
        let [a, b, c, d] = face.corners().map(|k| values[k.index()]);
        let (n, e) = (a * c - b * d, a + c - b - d);
        if e != 0 {
            exceed(e, n);
        }
    }
    for axis in 0..3 {
        let low = Face::new(2 * axis).corners();
        let [a0, b0, c0, d0] = low.map(|k| values[k.index()]);
        let rise = |k: Corner| values[k.across(axis.into()).index()] - values[k.index()];
        let [da, db, dc, dd] = low.map(rise);
        let a = da * dc - db * dd;
        let b = a0 * dc + c0 * da - b0 * dd - d0 * db;
        let n = a0 * c0 - b0 * d0;
        let (e0, e1) = (a0 + c0 - b0 - d0, da + dc - db - dd);
        let (p, q, r) = (e1 * e1, 4 * a * e0 - 2 * b * e1, b * b - 4 * a * n);
        exceed(p.abs() + q.abs(), r);
        if r == 0 && q != 0 {
            exceed(p, q);
        }
    }
    Some(bound)
}

fn gcd(a: i128, b: i128) -> i128 {
    if b == 0 { a.abs() } else { gcd(b, a % b) }
}
