//! For tests: a field known in closed form, with bounds and cheaper within a box; filters of each kind.

use crate::{Filter, Interval, Jet, ScalarField, Slope, Window};
use isokit_geom::{Aabb, Affine};
use std::ops::Range;

/// sin(a x + 0.3) + 0.5 cos(a y) z, and within a box the same with a memory of the box.
pub(crate) struct Waves {
    dims: [usize; 3],
    within: Option<Aabb>,
}

const PACE: f64 = 0.37;

impl Waves {
    pub(crate) fn new(dims: [usize; 3]) -> Self {
        Self { dims, within: None }
    }
}

impl ScalarField for Waves {
    fn dims(&self) -> [usize; 3] {
        self.dims
    }

    fn index_to_world(&self) -> Affine {
        Affine::axis_aligned([0.5, 0.25, 2.0], [1.0, -3.0, 0.0]).unwrap()
    }

    fn value(&self, ijk: [f64; 3]) -> f64 {
        if let Some(Aabb { min, max }) = self.within {
            assert!((0..3).all(|k| min[k] <= ijk[k] && ijk[k] <= max[k]), "asked without");
        }
        (PACE * ijk[0] + 0.3).sin() + 0.5 * (PACE * ijk[1]).cos() * ijk[2]
    }

    fn slope(&self, ijk: [f64; 3]) -> Slope {
        let Jet { value, gradient, .. } = self.jet(ijk);
        Slope { value, gradient }
    }

    fn jet(&self, ijk @ [x, y, z]: [f64; 3]) -> Jet {
        let ((sx, cx), (sy, cy)) = ((PACE * x + 0.3).sin_cos(), (PACE * y).sin_cos());
        let (yy, yz) = (-0.5 * PACE * PACE * cy * z, -0.5 * PACE * sy);
        Jet {
            value: self.value(ijk),
            gradient: [PACE * cx, -0.5 * PACE * sy * z, 0.5 * cy],
            hessian: [[-PACE * PACE * sx, 0.0, 0.0], [0.0, yy, yz], [0.0, yz, 0.0]],
        }
    }

    fn bounds(&self, ijk: Aabb) -> Interval {
        // No steeper than this along each axis.
        let steep = [PACE, 0.5 * PACE * ijk.reach(), 0.5];
        let middle: [f64; 3] = std::array::from_fn(|k| 0.5 * (ijk.min[k] + ijk.max[k]));
        let reach: f64 = (0..3).map(|k| 0.5 * (ijk.max[k] - ijk.min[k]) * steep[k]).sum();
        let (value, reach) = (Waves::new(self.dims).value(middle), reach + 1e-9);
        match (value - reach).is_nan() || (value + reach).is_nan() {
            true => Interval::EVERYTHING,
            false => Interval { low: value - reach, high: value + reach },
        }
    }

    fn within(&self, ijk: Aabb) -> Option<Box<dyn ScalarField + '_>> {
        Some(Box::new(Self { dims: self.dims, within: Some(ijk) }))
    }

    fn fill(&self, points: [Range<usize>; 3], values: &mut [f64]) {
        let [x, y, z] = points;
        assert_eq!(values.len(), x.len() * y.len() * z.len());
        for (n, value) in values.iter_mut().enumerate() {
            let k = z.start + n / x.len() / y.len();
            let ijk = [x.start + n % x.len(), y.start + n / x.len() % y.len(), k];
            *value = self.value(ijk.map(|i| i as f64));
        }
    }
}

/// One of each kind of filter, and of those with a width more than one.
pub(crate) fn filters() -> Vec<Filter> {
    let sinc = |window, lobes| Filter::Sinc { window, lobes };
    vec![
        Filter::Nearest,
        Filter::Linear,
        Filter::QuadraticBSpline,
        Filter::CubicBSpline,
        Filter::SmoothQuadratic,
        Filter::CubicBSpline.smoothing(),
        Filter::CATMULL_ROM,
        Filter::MITCHELL,
        sinc(Window::Lanczos, 2),
        sinc(Window::Lanczos, 3),
        sinc(Window::Hann, 5),
        sinc(Window::Blackman, 4),
    ]
}
