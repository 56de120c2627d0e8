//! Kernels on the signal that they are compared by: Marschner & Lobb 1994, "An evaluation of reconstruction filters for volume
//! rendering", section 5. Nearly all of it is below the frequency that samples can hold, but not by far.

use super::{convolved, volume};
use crate::{Filter, ScalarField, Window};
use std::f64::consts::PI;

/// Samples from −1 to 1 on each axis, as in the paper.
const N: usize = 41;

/// Per unit of the signal.
const PER_UNIT: f64 = (N - 1) as f64 / 2.0;

const ALPHA: f64 = 0.25;
const WAVES: f64 = 6.0;

fn at(ijk: [f64; 3]) -> [f64; 3] {
    ijk.map(|c| c / PER_UNIT - 1.0)
}

fn signal([x, y, z]: [f64; 3]) -> f64 {
    let ring = (2.0 * PI * WAVES * (PI * x.hypot(y) / 2.0).cos()).cos();
    (1.0 - (PI * z / 2.0).sin() + ALPHA * (1.0 + ring)) / (2.0 * (1.0 + ALPHA))
}

/// Its gradient.
fn slope([x, y, z]: [f64; 3]) -> [f64; 3] {
    let r = x.hypot(y);
    let (sin, cos) = (PI * r / 2.0).sin_cos();
    let ring = (2.0 * PI * WAVES * cos).sin() * PI * PI * WAVES * sin;
    let along = |c: f64| if r > 0.0 { ALPHA * ring * c / r } else { 0.0 };
    let whole = 2.0 * (1.0 + ALPHA);
    [along(x) / whole, along(y) / whole, -PI / 2.0 * (PI * z / 2.0).cos() / whole]
}

/// Root mean squares of the errors of values and of gradients, in units of the signal, away from the border.
fn errors(filter: Filter) -> [f64; 2] {
    let samples = volume([N; 3], |ijk| signal(at(ijk)) as f32);
    let field = convolved(&samples, filter);
    let (mut squares, count) = ([0.0; 2], 4000);
    for n in 0..count {
        // Numbers that fill a cube evenly: Roberts 2018, "The unreasonable effectiveness of quasirandom sequences".
        let place = [0.819_172_513, 0.671_043_607, 0.549_700_478]
            .map(|step| 6.0 + (N - 13) as f64 * (f64::from(n) * step).fract());
        let found = field.slope(place);
        let (value, exact) = (signal(at(place)), slope(at(place)));
        squares[0] += (found.value - value).powi(2);
        let off = |k: usize| (found.gradient[k] * PER_UNIT - exact[k]).powi(2);
        squares[1] += off(0) + off(1) + off(2);
    }
    squares.map(|sum| (sum / f64::from(count)).sqrt())
}

#[test]
fn the_better_kernel_is_nearer_to_the_signal_of_marschner_and_lobb() {
    let ranks = [
        Filter::Nearest,
        Filter::Linear,
        Filter::CATMULL_ROM,
        Filter::QuadraticBSpline,
        Filter::CubicBSpline,
        Filter::Sinc { window: Window::Blackman, lobes: 8 },
    ];
    for pair in ranks.windows(2) {
        let [worse, better] = [pair[0], pair[1]].map(errors);
        for (worse, better) in worse.into_iter().zip(better) {
            assert!(better < 0.8 * worse, "{pair:?}: {better}, {worse}");
        }
    }
    // What smooths blurs the waves, the B-spline more than Mitchell and Netravali's.
    let smooth = [Filter::CubicBSpline.smoothing(), Filter::MITCHELL, Filter::CATMULL_ROM];
    let [most, less, none] = smooth.map(|filter| errors(filter)[0]);
    assert!(most > 1.5 * less && less > 1.3 * none, "{most}, {less}, {none}");
}
