//! Where a function of one variable is 0, near a place and no farther than allowed.

/// Steps after which a root is taken as it is; the bracket is then down to nothing.
const STEPS: usize = 100;

/// A step so short, in units of the reach, ends the search. What is left is far below it, since steps shrink
/// faster than by any factor.
const SHORT: f64 = 1.0 / (1_u64 << 24) as f64;

/// A root of `f` no farther than `reach` from 0, on the side to which `f` should change its sign if it rises
/// as fast as `slope` says, above 0. None where it does not change it there, or is not finite.
///
/// A bracket is opened from 0 outwards, twice as far each time, so the root is one of the nearest. Then
/// it closes by the rule of Anderson & Björck 1973, which never leaves it. "Positive" includes 0, as inside
/// includes the isovalue.
pub(crate) fn root(f: impl Fn(f64) -> f64, slope: f64, reach: f64) -> Option<f64> {
    let start = f(0.0);
    if start == 0.0 {
        return Some(0.0);
    }
    let way = if start < 0.0 { 1.0 } else { -1.0 };
    let f = |t: f64| Some(f(way * t)).filter(|value| value.is_finite());
    let (mut a, mut f_a) = (0.0, Some(start).filter(|value| value.is_finite())?);
    let mut b = (1.25 * start.abs() / slope).clamp(SHORT * reach, reach);
    let mut f_b = f(b)?;
    while (f_b >= 0.0) == (f_a >= 0.0) {
        if b >= reach {
            return None;
        }
        (a, f_a) = (b, f_b);
        b = (2.0 * b).min(reach);
        f_b = f(b)?;
    }
    for _ in 0..STEPS {
        let line = b - f_b * ((b - a) / (f_b - f_a));
        let is_within = line > a.min(b) && line < a.max(b);
        let next = if is_within { line } else { a.midpoint(b) };
        let f_next = f(next)?;
        let step = (next - b).abs();
        if (f_next >= 0.0) == (f_b >= 0.0) {
            // The other end stays: it counts for less from time to time, so that it moves too.
            let share = 1.0 - f_next / f_b;
            f_a *= if share > 0.0 { share } else { 0.5 };
        } else {
            (a, f_a) = (b, f_b);
        }
        (b, f_b) = (next, f_next);
        if f_b == 0.0 || step <= SHORT * reach {
            break;
        }
    }
    Some(way * b)
}

#[cfg(test)]
mod tests {
    use super::root;

    /// A function, and how steep it is at 0.
    type Shape = (fn(f64) -> f64, f64);

    #[test]
    fn roots_of_many_shapes_are_found_to_the_last_digits() {
        let shapes: [Shape; 5] = [
            (|x| x, 1.0),
            (|x| x.sinh() + 0.3 * x, 1.3),
            (|x| (3.0 * x).tanh(), 3.0),
            (|x| x * x * x + 1e-3 * x, 1e-3),
            (|x| 1e200 * (x.exp() - 1.0), 1e200),
        ];
        for (f, slope) in shapes {
            for n in -40..=40 {
                let place = f64::from(n) / 50.0;
                let found = root(|t| f(t - place), slope, 1.0).expect("it is within reach");
                assert!((found - place).abs() < 1e-9, "{found}, {place}");
            }
        }
    }

    #[test]
    fn none_is_found_beyond_the_reach_or_where_nothing_changes_its_sign() {
        assert_eq!(root(|t| t - 1.01, 1.0, 1.0), None);
        assert_eq!(root(|t| t * t + 0.1, 1.0, 1.0), None);
        assert_eq!(root(|_| f64::NAN, 1.0, 1.0), None);
        assert_eq!(root(|t| if t > 0.1 { f64::NAN } else { t - 0.5 }, 1.0, 1.0), None);
        assert_eq!(root(|t| t - 0.5, 0.0, 1.0).map(|t| (t * 1e9).round()), Some(5e8));
        assert_eq!(root(|_| 0.0, 0.0, 1.0), Some(0.0));
    }

    #[test]
    fn of_two_roots_the_near_one_is_taken() {
        let found = root(|t| (t - 0.1) * (0.8 - t), 0.7, 1.0).expect("two are within reach");
        assert!((found - 0.1).abs() < 1e-9, "{found}");
    }
}
