//! Reconstruction filters: how much of each sample is the value at a place between them.
//!
//! Along each axis a value is the sum of samples, each weighed by where it lies from the place; in space by the product of
//! the three. Mitchell & Netravali 1988, "Reconstruction filters in computer graphics", say what errors such filters make.

use std::{cmp::Ordering, f64::consts::PI};

/// A symmetric function of a distance along an axis, in units of the distance of samples.
pub trait SeparableKernel: Sync {
    /// From here on it is 0.
    fn radius(&self) -> f64;

    /// How much of a sample counts, at a place that is so far above it.
    fn weight(&self, distance: f64) -> f64;

    /// The derivative of the weight; where it has an edge, the mean of both sides.
    fn slope(&self, distance: f64) -> f64;

    /// The second derivative of the weight; where the slope has an edge, the mean of both sides. Of edges and jumps of the
    /// weight itself it says nothing.
    fn bend(&self, distance: f64) -> f64;

    /// If the weights are not of samples, but of numbers that have to be found first so that the sum goes through the
    /// samples: how. Default: they are of samples.
    fn spline(&self) -> Option<Spline> {
        None
    }
}

impl<K: SeparableKernel + ?Sized> SeparableKernel for &K {
    fn radius(&self) -> f64 {
        (**self).radius()
    }

    fn weight(&self, distance: f64) -> f64 {
        (**self).weight(distance)
    }

    fn slope(&self, distance: f64) -> f64 {
        (**self).slope(distance)
    }

    fn bend(&self, distance: f64) -> f64 {
        (**self).bend(distance)
    }

    fn spline(&self) -> Option<Spline> {
        (**self).spline()
    }
}

/// What pieces weigh at samples: pieces that go on for two distances and the half of one at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spline {
    /// In its middle.
    pub middle: f64,
    /// One sample beside it.
    pub beside: f64,
}

impl Spline {
    /// How much less a number that was found counts from one sample to the next: between −1 and 0.
    pub(crate) fn pole(self) -> f64 {
        let half = 0.5 * self.middle / self.beside;
        -(half + (half * half - 1.0).sqrt()).recip()
    }

    /// How much a sample counts for the number at itself.
    pub(crate) fn share(self) -> f64 {
        let pole = self.pole();
        -pole / (1.0 - pole * pole) / self.beside
    }
}

/// The filters of the field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// The sample that is nearest; of two the one above.
    Nearest,
    /// The straight line from sample to sample. Errors of O(h²).
    Linear,
    /// The interpolating spline of degree 2, with a continuous gradient. Errors of O(h³). Unser, Aldroubi & Eden 1993.
    QuadraticBSpline,
    /// The interpolating spline of degree 3, with continuous second derivatives. Errors of O(h⁴), the least of all here.
    CubicBSpline,
    /// Mitchell & Netravali's cubics. `b` and `c` are 0 and 1/2 for Catmull & Rom's, the one that goes through the samples
    /// with errors of O(h³); 1/3 and 1/3 for the compromise of blur and ringing that they recommend; 1 and 0 for the
    /// B-spline as it is, which smooths.
    Cubic {
        /// How much it blurs.
        b: f64,
        /// How much it rings.
        c: f64,
    },
    /// The sine of a distance over the distance, which would be right for what has no waves shorter than two samples, in
    /// a window that lets it end.
    Sinc {
        /// How it ends.
        window: Window,
        /// After how many samples, from 1 on.
        lobes: u8,
    },
    /// The spline of degree 2 as it is, through no samples: it smooths.
    SmoothQuadratic,
}

/// How a filter that would go on is made to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Window {
    /// The middle wave of a wider sine over distance (Lanczos; Duchon 1979, "Lanczos filtering in one and two dimensions").
    Lanczos,
    /// A raised cosine.
    Hann,
    /// Two cosines, with less beyond the frequencies that are kept. Harris 1978, "On the use of windows for harmonic
    /// analysis with the discrete Fourier transform".
    Blackman,
}

impl Filter {
    /// Catmull & Rom's.
    pub const CATMULL_ROM: Self = Self::Cubic { b: 0.0, c: 0.5 };

    /// The one that Mitchell & Netravali recommend.
    pub const MITCHELL: Self = Self::Cubic { b: 1.0 / 3.0, c: 1.0 / 3.0 };

    /// The same filter as it is, without the numbers being found first through which a spline goes through the samples: it
    /// smooths, and needs no more samples than are near. Others stay.
    #[must_use]
    pub fn smoothing(self) -> Self {
        match self {
            Self::CubicBSpline => Self::Cubic { b: 1.0, c: 0.0 },
            Self::QuadraticBSpline => Self::SmoothQuadratic,
            other => other,
        }
    }
}

impl SeparableKernel for Filter {
    fn radius(&self) -> f64 {
        match self {
            Self::Nearest => 0.5,
            Self::Linear => 1.0,
            Self::QuadraticBSpline | Self::SmoothQuadratic => 1.5,
            Self::CubicBSpline | Self::Cubic { .. } => 2.0,
            Self::Sinc { lobes, .. } => f64::from(*lobes),
        }
    }

    fn weight(&self, distance: f64) -> f64 {
        let t = distance.abs();
        if t >= self.radius() {
            return if *self == Self::Nearest && distance == -0.5 { 1.0 } else { 0.0 };
        }
        match *self {
            Self::Nearest => 1.0,
            Self::Linear => 1.0 - t,
            Self::QuadraticBSpline | Self::SmoothQuadratic if t < 0.5 => 0.75 - t * t,
            Self::QuadraticBSpline | Self::SmoothQuadratic => 0.5 * (1.5 - t) * (1.5 - t),
            Self::CubicBSpline => cubic(t, 1.0, 0.0)[0],
            Self::Cubic { b, c } => cubic(t, b, c)[0],
            Self::Sinc { window, lobes } => sinc(t)[0] * window.at(t, lobes.into())[0],
        }
    }

    fn slope(&self, distance: f64) -> f64 {
        let t = distance.abs();
        if t > self.radius() {
            return 0.0;
        }
        let falling = match *self {
            Self::Nearest => 0.0,
            Self::Linear => mean_at(t, 1.0, -1.0, 0.0),
            Self::QuadraticBSpline | Self::SmoothQuadratic if t < 0.5 => -2.0 * t,
            Self::QuadraticBSpline | Self::SmoothQuadratic => t - 1.5,
            Self::CubicBSpline => cubic(t, 1.0, 0.0)[1],
            Self::Cubic { b, c } => cubic(t, b, c)[1],
            Self::Sinc { window, lobes } => {
                let ([wave, steep, _], [window, ends, _]) = (sinc(t), window.at(t, lobes.into()));
                steep * window + wave * ends
            }
        };
        match distance {
            0.0 => 0.0,
            _ => falling * distance.signum(),
        }
    }

    fn bend(&self, distance: f64) -> f64 {
        let t = distance.abs();
        let end = self.radius();
        if t > end {
            return 0.0;
        }
        match *self {
            Self::Nearest | Self::Linear => 0.0,
            Self::QuadraticBSpline | Self::SmoothQuadratic => match t < 1.0 {
                true => mean_at(t, 0.5, -2.0, 1.0),
                false => mean_at(t, end, 1.0, 0.0),
            },
            Self::CubicBSpline => cubic_bend(t, 1.0, 0.0),
            Self::Cubic { b, c } => cubic_bend(t, b, c),
            Self::Sinc { window, lobes } => {
                let ([wave, steep, bent], [window, ends, bends]) =
                    (sinc(t), window.at(t, lobes.into()));
                mean_at(t, end, bent * window + 2.0 * steep * ends + wave * bends, 0.0)
            }
        }
    }

    fn spline(&self) -> Option<Spline> {
        match self {
            Self::QuadraticBSpline => Some(Spline { middle: 0.75, beside: 0.125 }),
            Self::CubicBSpline => Some(Spline { middle: 2.0 / 3.0, beside: 1.0 / 6.0 }),
            _ => None,
        }
    }
}

/// What is `inner` up to an edge and `outer` beyond.
fn mean_at(t: f64, edge: f64, inner: f64, outer: f64) -> f64 {
    match t.total_cmp(&edge) {
        Ordering::Less => inner,
        Ordering::Equal => 0.5 * (inner + outer),
        Ordering::Greater => outer,
    }
}

/// Mitchell & Netravali's cubic up to a distance of 1, and from there to 2: from the highest power on, six times.
fn pieces(b: f64, c: f64) -> [[f64; 4]; 2] {
    [
        [12.0 - 9.0 * b - 6.0 * c, -18.0 + 12.0 * b + 6.0 * c, 0.0, 6.0 - 2.0 * b],
        [-b - 6.0 * c, 6.0 * b + 30.0 * c, -12.0 * b - 48.0 * c, 8.0 * b + 24.0 * c],
    ]
}

/// The cubic at a distance from 0 to 2, and its derivative.
fn cubic(t: f64, b: f64, c: f64) -> [f64; 2] {
    let [p3, p2, p1, p0] = pieces(b, c)[usize::from(t >= 1.0)];
    [((p3 * t + p2) * t + p1) * t + p0, (3.0 * p3 * t + 2.0 * p2) * t + p1].map(|sum| sum / 6.0)
}

/// The second derivative of the cubic.
fn cubic_bend(t: f64, b: f64, c: f64) -> f64 {
    let [inner, outer] = pieces(b, c).map(|[p3, p2, ..]| (6.0 * p3 * t + 2.0 * p2) / 6.0);
    match t <= 1.0 {
        true => mean_at(t, 1.0, inner, outer),
        false => mean_at(t, 2.0, outer, 0.0),
    }
}

/// The sine of `t` half turns over `t` half turns, with two derivatives. At samples it is 0 to the last digit.
fn sinc(t: f64) -> [f64; 3] {
    if t == 0.0 {
        return [1.0, 0.0, -PI * PI / 3.0];
    }
    let (sine, cosine) = (PI * t).sin_cos();
    let sine = if t.fract() == 0.0 { 0.0 } else { sine };
    let wave = sine / (PI * t);
    if t < 0.3 {
        // Close to 0 sine and cosine take away nearly all of each other.
        let [steep, bent] = sinc_series(PI * t);
        return [wave, PI * steep, PI * PI * bent];
    }
    let steep = (cosine - wave) / t;
    // t times the wave is a sine: its second derivative says what the wave's is.
    [wave, steep, -PI * PI * wave - 2.0 * steep / t]
}

/// The derivatives of the sine of a number over the number, which is less than 1: the sum of its powers.
fn sinc_series(u: f64) -> [f64; 2] {
    let square = u * u;
    let (mut power, mut slope, mut bend) = (1.0, 0.0, 0.0);
    // The last ones are less than what is rounded.
    for k in 1..=10 {
        let n = f64::from(2 * k);
        // (−1)ᵏ u²ᵏ⁻² / (2k + 1)!
        power *= if k == 1 { -1.0 / 6.0 } else { -square / (n * (n + 1.0)) };
        slope += n * power * u;
        bend += n * (n - 1.0) * power;
    }
    [slope, bend]
}

impl Window {
    /// At a distance of at most `end`, with two derivatives.
    fn at(self, t: f64, end: f64) -> [f64; 3] {
        let turn = PI / end;
        let wave = |times: f64| {
            let (sine, cosine) = (times * turn * t).sin_cos();
            [cosine, -times * turn * sine, -times * turn * times * turn * cosine]
        };
        match self {
            Self::Lanczos => {
                let [wave, steep, bent] = sinc(t / end);
                [wave, steep / end, bent / end / end]
            }
            Self::Hann => {
                let [cosine, steep, bent] = wave(1.0);
                [0.5 + 0.5 * cosine, 0.5 * steep, 0.5 * bent]
            }
            Self::Blackman => {
                let (once, twice) = (wave(1.0), wave(2.0));
                let [window, rest @ ..] = [0, 1, 2].map(|n| 0.5 * once[n] + 0.08 * twice[n]);
                [0.42 + window, rest[0], rest[1]]
            }
        }
    }
}

#[cfg(test)]
mod tests;
