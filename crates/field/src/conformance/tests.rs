//! The suite against fields that are right, and against some that are not.

use super::{Suite, check};
use crate::{Interval, Jet, Sampled, ScalarField, Slope, kit::Waves};
use isokit_geom::{Aabb, Affine};
use isokit_volume::{Grid, Sample, Scaling, Volume};
use std::{ops::Range, panic};

fn volume<T: Sample>(dims: [u64; 3], sample: impl Fn(u64) -> T) -> Volume<T> {
    let grid = Grid::new(dims, Default::default()).unwrap();
    let mixed = |n: u64| (n.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 20).wrapping_mul(0x5851_F42D);
    let samples = (0..grid.count()).map(|n| sample(mixed(n) >> 8)).collect();
    Volume::new(grid, samples).unwrap().with_scaling(Scaling::new(-0.5, 3.0).unwrap())
}

fn check_sampled<T: Sample>(volume: &Volume<T>) {
    check(&Sampled::new(volume.view()));
    check(&Sampled::catmull_rom(volume.view()));
}

#[test]
fn waves_conform() {
    check(&Waves::new([20, 15, 9]));
}

#[test]
fn samples_of_any_kind_conform_seen_through_either_cubic() {
    for dims in [[9, 12, 7], [4, 4, 4], [3, 2, 5], [1, 8, 1], [1, 1, 1]] {
        check_sampled(&volume(dims, |r| r as u8));
        check_sampled(&volume(dims, |r| r as i16));
        check_sampled(&volume(dims, |r| (r % 1000) as f32 - 500.0));
        check_sampled(&volume(dims, |r| match r % 97 {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::MAX,
            n => n as f64,
        }));
    }
    let waves = Waves::new([16, 14, 12]);
    let job = isokit_job::Job::default();
    let samples = crate::FieldSamples::new(&waves, Default::default()).unwrap();
    check_sampled(&crate::sample::<f64>(samples, &job).unwrap());
}

/// A field with something wrong.
struct Wrong {
    field: Waves,
    what: What,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum What {
    Value,
    Gradient,
    Hessian,
    Turned,
    Bounds,
    Within,
    Fill,
    Known,
    Panic,
}

impl ScalarField for Wrong {
    fn dims(&self) -> [usize; 3] {
        self.field.dims()
    }

    fn index_to_world(&self) -> Affine {
        self.field.index_to_world()
    }

    fn value(&self, ijk: [f64; 3]) -> f64 {
        assert!(self.what != What::Panic || !ijk[1].is_infinite());
        self.field.value(ijk)
    }

    fn is_known(&self, ijk: [f64; 3]) -> bool {
        self.field.is_known(ijk) && (self.what != What::Known || ijk[2] > 0.5)
    }

    fn slope(&self, ijk: [f64; 3]) -> Slope {
        let slope = self.field.slope(ijk);
        Slope { value: slope.value + if self.what == What::Value { 1e-3 } else { 0.0 }, ..slope }
    }

    fn jet(&self, ijk: [f64; 3]) -> Jet {
        let mut jet = self.field.jet(ijk);
        match self.what {
            What::Gradient => jet.gradient[1] *= 1.001,
            What::Hessian => jet.hessian[0][0] *= 1.01,
            What::Turned => jet.hessian[1][2] *= 1.01,
            _ => {}
        }
        jet
    }

    fn bounds(&self, ijk: Aabb) -> Interval {
        let bounds @ Interval { low, high } = self.field.bounds(ijk);
        match self.what {
            What::Bounds => Interval { low: 0.4 * low + 0.6 * high, high },
            _ => bounds,
        }
    }

    fn within(&self, ijk: Aabb) -> Option<Box<dyn ScalarField + '_>> {
        match self.what {
            What::Within => {
                Some(Box::new(Wrong { field: Waves::new(self.dims()), what: What::Hessian }))
            }
            _ => self.field.within(ijk),
        }
    }

    fn fill(&self, points: [Range<usize>; 3], values: &mut [f64]) {
        self.field.fill(points, values);
        if self.what == What::Fill {
            values.iter_mut().for_each(|value| *value += 1e-15);
        }
    }
}

#[test]
fn whoever_breaks_a_law_is_found_out() {
    for (what, law) in [
        (What::Value, "the value at"),
        (What::Gradient, "a part of the gradient"),
        (What::Hessian, "the Hessian along"),
        (What::Turned, "not symmetric"),
        (What::Bounds, "is not within"),
        (What::Within, "within a box the field"),
        (What::Fill, "what is filled"),
        (What::Known, "whether"),
        (What::Panic, "what != What::Panic"),
    ] {
        let wrong = Wrong { field: Waves::new([20, 15, 9]), what };
        let found = panic::catch_unwind(|| Suite { places: 100, ..Suite::default() }.check(&wrong));
        let said = found.unwrap_err();
        let said = said.downcast_ref::<String>().map(String::as_str);
        let said = said.unwrap_or("what != What::Panic");
        assert!(said.contains(law), "{what:?}: {said}");
    }
}
