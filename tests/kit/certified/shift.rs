//! The number that stands for an infinitesimal where a saddle is exactly 0.
//!
//! The surface at −ε is the same, up to a homeomorphism of the cell, for all ε between 0 and the least
//! magnitude of a negative critical value: of the field in the cell, on a face, on an edge, at a corner. The
//! values of `K·f + 1` have the signs of `f + 1/K`, and are integers. So K has to exceed 1 over that
//! magnitude; any such K will do.
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

/// How many numbers are tried before a cell is given up. A plane of the subdivision may have a singular face
/// of its own, which the next number mends.
const TRIES: i128 = 8;

/// Values must be below this for a bound: four times a product of two of them, or of two sums of two, fits.
const LARGEST: i128 = 1 << 60;

/// Fields to subdivide in turn until one ends: the values themselves and, where it can be had, `K·f + 1`
/// for some K; these first if a critical value may be 0.
pub(super) fn attempts(corners: [i64; 8]) -> impl Iterator<Item = [i128; 8]> {
    let mut values = corners.map(i128::from);
    let factor = values.iter().fold(0, |a, &b| gcd(a, b)).max(1);
    values = values.map(|v| v / factor);
    let bound = bound(&values);
    let singular = bound.as_ref().is_some_and(|bound| bound.singular);
    let scales = bound.into_iter().flat_map(|bound| bound.scale..bound.scale + TRIES);
    let shifted = scales.map(move |scale| values.map(|v| v * scale + 1));
    let plain = |now: bool| now.then_some(values).into_iter();
    plain(!singular).chain(shifted).chain(plain(singular))
}

struct Bound {
    /// K.
    scale: i128,
    /// Whether a saddle is 0, of a face or of the box, be it beyond their borders.
    singular: bool,
}

fn bound(values: &[i128; 8]) -> Option<Bound> {
    let largest = values.iter().map(|v| v.abs()).max().filter(|&v| v < LARGEST)?;
    let (mut scale, mut singular) = (2.0_f64, false);
    // K exceeds an upper bound over a lower one.
    let mut exceed = |upper: f64, lower: f64| match lower {
        0.0 => singular = true,
        _ => scale = scale.max(upper / lower * MARGIN + 1.0),
    };
    for face in Face::all() {
        let [a, b, c, d] = face.corners().map(|k| values[k.index()]);
        if a + c != b + d {
            exceed((a + c - b - d).abs() as f64, gap([a, c], [b, d])?);
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
        let product = |x: i128, y: i128| x.abs() as f64 * y.abs() as f64;
        let (p, q) = (product(e1, e1), product(4 * a, e0) + product(2 * b, e1));
        let r = gap([b, b], [4 * a, n])?;
        exceed(p + q, r);
        let q = gap([4 * a, e0], [2 * b, e1])?;
        if r == 0.0 && q != 0.0 {
            exceed(p, q);
        }
    }
    // Rounded up, and small enough for what it will be multiplied with.
    let scale = scale.ceil() as i128;
    (scale + TRIES).checked_mul(largest + 1).map(|_| Bound { scale, singular })
}

/// More than what a few roundings of an `f64` take away.
const MARGIN: f64 = 1.0 + 1e-12;

/// A lower bound, and a close one, of how far two products are apart; 0 only if they are equal. None if that
/// cannot be told: the products do not fit, and agree in their first digits.
fn gap([a, b]: [i128; 2], [c, d]: [i128; 2]) -> Option<f64> {
    let exact = a.checked_mul(b).zip(c.checked_mul(d)).and_then(|(x, y)| x.checked_sub(y));
    if let Some(exact) = exact {
        return Some(exact.unsigned_abs() as f64 / MARGIN);
    }
    let (x, y) = (a as f64 * b as f64, c as f64 * d as f64);
    let off = (x.abs() + y.abs()) * (MARGIN - 1.0);
    Some((x - y).abs() - off).filter(|&gap| gap > off)
}

fn gcd(a: i128, b: i128) -> i128 {
    if b == 0 { a.abs() } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::{bound, gap};

    #[test]
    fn a_gap_is_close_below_the_difference_and_0_only_where_there_is_none() {
        let large = 1 << 80;
        assert_eq!(gap([3, 5], [-5, -3]), Some(0.0));
        assert!((22.999..=23.0).contains(&gap([7, 5], [4, 3]).unwrap()));
        let half = 2_f64.powi(159);
        let found = gap([large, large], [large, large / 2]).unwrap();
        assert!((half * (1.0 - 1e-11)..=half).contains(&found));
        assert_eq!(gap([large, large], [large, large - 1]), None, "it does not show in an f64");
        assert_eq!(gap([large, large], [large, large]), None);
    }

    #[test]
    fn a_bound_is_above_1_over_the_nearest_critical_value_below() {
        // The saddles of the faces are −1/20 and 1/28, those of the inside 0 and −1/9.
        let found = bound(&[-9, 7, 7, -5, 7, -5, -5, 3]).unwrap();
        assert!(found.singular && (10..100).contains(&found.scale), "{}", found.scale);
        // One face has a saddle of −1/12.
        let found = bound(&[4, -3, -3, 2, 9, 9, 9, 9]).unwrap();
        assert!((13..100).contains(&found.scale) && !found.singular, "{}", found.scale);
    }
}
