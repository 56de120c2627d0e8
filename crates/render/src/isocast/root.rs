//! The one place of a part of a way where a function of it changes sides.

/// Where between two places it is: by Newton's steps, within what is left of a bracket (Press et al., "Numerical
/// recipes", section 9.4). `at` says what is there, to be compared with 0, and how it rises; `is_inside_there`, on which
/// side the end is.
pub(super) fn root(
    at: impl Fn(f64) -> [f64; 2],
    [mut from, mut to]: [f64; 2],
    is_inside_there: bool,
) -> f64 {
    let mut t = 0.5 * (from + to);
    for _ in 0..60 {
        let [value, rise] = at(t);
        match (value >= 0.0) == is_inside_there {
            true => to = t,
            false => from = t,
        }
        let newton = t - value / rise;
        let next = if newton >= from && newton <= to { newton } else { 0.5 * (from + to) };
        if (next - t).abs() <= 1e-15 {
            return next;
        }
        t = next;
    }
    t
}

#[cfg(test)]
mod tests {
    use super::root;

    #[test]
    fn it_is_found_where_newtons_steps_lead_astray() {
        // Steep, flat, and flat where it changes sides.
        let off = |found: f64, at: f64| assert!((found - at).abs() < 1e-14, "{found} for {at}");
        off(root(|t| [t - 0.25, 1.0], [0.0, 1.0], true), 0.25);
        off(root(|t| [0.25 - t, -1.0], [0.0, 1.0], false), 0.25);
        let tangent =
            |t: f64| [(50.0 * (t - 0.1)).atan(), 50.0 / (1.0 + (50.0 * (t - 0.1)).powi(2))];
        off(root(tangent, [0.0, 1.0], true), 0.1);
        off(root(|t| [if t < 0.7 { -1.0 } else { 1.0 }, 0.0], [0.5, 1.0], true), 0.7);
    }
}
