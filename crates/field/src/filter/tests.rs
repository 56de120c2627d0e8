//! What makes filters right: that they add up to 1, that they are symmetric, which polynomials they keep, their slopes.

use super::{Filter, SeparableKernel, Window};

const BSPLINES: [Filter; 4] = [
    Filter::QuadraticBSpline,
    Filter::CubicBSpline,
    Filter::SmoothQuadratic,
    Filter::Cubic { b: 1.0, c: 0.0 },
];

fn polynomial_filters() -> Vec<Filter> {
    let cubics = [(0.0, 0.5), (1.0 / 3.0, 1.0 / 3.0), (0.2, 0.7), (1.5, -0.25)];
    let cubics = cubics.map(|(b, c)| Filter::Cubic { b, c });
    [&[Filter::Nearest, Filter::Linear][..], &BSPLINES, &cubics].concat()
}

fn windowed() -> Vec<Filter> {
    let windows = [Window::Lanczos, Window::Hann, Window::Blackman];
    let of = |window| (1..8).map(move |lobes| Filter::Sinc { window, lobes });
    windows.into_iter().flat_map(of).collect()
}

fn all() -> Vec<Filter> {
    [polynomial_filters(), windowed()].concat()
}

/// Places between samples, and on them.
fn places() -> impl Iterator<Item = f64> {
    (0..=64).map(|n| f64::from(n) / 64.0)
}

/// The sum over samples of a function of their places, weighed as at a place.
fn sum(filter: Filter, place: f64, function: impl Fn(f64) -> f64) -> f64 {
    (-9..=9).map(|i| filter.weight(place - f64::from(i)) * function(i.into())).sum()
}

#[test]
fn weights_add_up_to_one() {
    for filter in polynomial_filters() {
        for place in places() {
            assert!((sum(filter, place, |_| 1.0) - 1.0).abs() < 1e-14, "{filter:?} at {place}");
        }
    }
    // A window takes a little from all of them; as many lobes as are used leave little to miss.
    for filter in windowed().into_iter().filter(|filter| filter.radius() >= 3.0) {
        for place in places() {
            assert!((sum(filter, place, |_| 1.0) - 1.0).abs() < 0.02, "{filter:?} at {place}");
        }
    }
}

#[test]
fn filters_are_symmetric_and_end_where_they_say() {
    for filter in all() {
        for n in 0..700 {
            let t = f64::from(n) / 64.0;
            // Of two that are as near, the nearest is the one above.
            let is_tie = filter == Filter::Nearest && t == 0.5;
            assert!(is_tie || filter.weight(t) == filter.weight(-t), "{filter:?} at {t}");
            assert_eq!(filter.slope(t), -filter.slope(-t), "{filter:?} at {t}");
            assert_eq!(filter.bend(t), filter.bend(-t), "{filter:?} at {t}");
            assert!(t < filter.radius() || filter.weight(t) == 0.0 || is_tie, "{filter:?}");
            let is_within = t <= filter.radius();
            assert!(is_within || (filter.slope(t), filter.bend(t)) == (0.0, 0.0), "{filter:?}");
        }
        let end = filter.radius();
        assert!(filter == Filter::Nearest || filter.weight(end - 1e-9).abs() < 1e-8, "{filter:?}");
    }
}

#[test]
fn filters_that_interpolate_are_one_at_their_sample_and_nothing_at_others() {
    let through = all().into_iter().filter(|filter| match filter {
        Filter::Cubic { b, .. } => *b == 0.0,
        other => !BSPLINES.contains(other),
    });
    for filter in through {
        assert!((filter.weight(0.0) - 1.0).abs() < 1e-15, "{filter:?}");
        for n in 1..9 {
            assert_eq!(filter.weight(n.into()), 0.0, "{filter:?} at {n}");
        }
    }
}

#[test]
fn lines_and_parabolas_are_kept_by_those_that_claim_it() {
    let keeps = |filter: Filter, function: fn(f64) -> f64, is_near: f64| {
        for place in places() {
            let off = sum(filter, place, function) - function(place);
            assert!(off.abs() < is_near, "{filter:?} at {place}: {off}");
        }
    };
    let line: fn(f64) -> f64 = |x| 3.0 - 2.0 * x;
    for filter in polynomial_filters() {
        let is_wide = match filter {
            Filter::Nearest => false,
            // Where b + 2c is 1, as Mitchell & Netravali found.
            Filter::Cubic { b, c } => (b + 2.0 * c - 1.0_f64).abs() < 1e-15,
            _ => true,
        };
        if is_wide {
            keeps(filter, line, 1e-12);
        }
    }
    keeps(Filter::CATMULL_ROM, |x| x * x - 0.5 * x, 1e-12);
}

#[test]
fn slopes_are_derivatives_of_the_weights() {
    for filter in all() {
        for n in 0..700 {
            let t = f64::from(n) / 64.0 + 0.005;
            let step = 1e-6;
            let found = (filter.weight(t + step) - filter.weight(t - step)) / (2.0 * step);
            assert!((found - filter.slope(t)).abs() < 1e-7, "{filter:?} at {t}: {found}");
            let found = (filter.slope(t + step) - filter.slope(t - step)) / (2.0 * step);
            assert!((found - filter.bend(t)).abs() < 1e-7, "{filter:?} at {t}: {found}");
        }
    }
}

#[test]
fn at_edges_slopes_and_bends_are_the_mean_of_both_sides() {
    for filter in all() {
        for n in 0..16 {
            let t = f64::from(n) / 2.0;
            let mean =
                |of: fn(&Filter, f64) -> f64| 0.5 * (of(&filter, t - 1e-9) + of(&filter, t + 1e-9));
            assert!((mean(Filter::slope) - filter.slope(t)).abs() < 1e-7, "{filter:?} at {t}");
            assert!((mean(Filter::bend) - filter.bend(t)).abs() < 1e-6, "{filter:?} at {t}");
        }
    }
}

#[test]
fn close_to_a_sample_derivatives_of_sines_are_as_exact_as_elsewhere() {
    // The first terms of their series: 1 − (πt)²/6 for the sine over the distance, and the same of the window.
    for filter in windowed() {
        let Filter::Sinc { window: Window::Lanczos, lobes } = filter else { continue };
        let end = f64::from(lobes);
        let bend = -std::f64::consts::PI.powi(2) / 3.0 * (1.0 + 1.0 / (end * end));
        for t in [1e-3, 1e-5, 1e-7, 1e-10] {
            assert!((filter.bend(t) - bend).abs() < 100.0 * t * t + 1e-14, "{filter:?} at {t}");
            let slope = filter.slope(t) / t;
            assert!((slope - bend).abs() < 100.0 * t * t + 1e-14, "{filter:?} at {t}: {slope}");
        }
    }
}

#[test]
fn splines_weigh_what_their_pieces_are_at_samples() {
    for filter in [Filter::QuadraticBSpline, Filter::CubicBSpline] {
        let spline = filter.spline().unwrap();
        assert!((spline.middle - filter.weight(0.0)).abs() < 1e-15);
        assert!((spline.beside - filter.weight(1.0)).abs() < 1e-15);
        assert!((spline.middle + 2.0 * spline.beside - 1.0).abs() < 1e-15);
        // Neighbours of the number at one sample make nothing of the sample beside it.
        let (pole, share) = (spline.pole(), spline.share());
        let number = |n: i32| share * pole.powi(n.abs());
        for n in -5..=5 {
            let made = spline.beside * (number(n - 1) + number(n + 1)) + spline.middle * number(n);
            let wanted = if n == 0 { 1.0 } else { 0.0 };
            assert!((made - wanted).abs() < 1e-14, "{filter:?} at {n}: {made}");
        }
        assert_eq!(filter.smoothing().spline(), None);
        assert!(places().all(|t| (filter.smoothing().weight(t) - filter.weight(t)).abs() < 1e-15));
    }
    assert_eq!(Filter::MITCHELL.smoothing(), Filter::MITCHELL);
}
