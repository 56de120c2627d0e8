//! Steps through cubics between samples, ray by ray.

use super::march::{Front, March};
use crate::{Gathered, transfer::Place};
use isokit_field::ScalarField;
use isokit_geom::vector::{Vector, length};
use isokit_volume::Sample;

impl<T: Sample> March<'_, T> {
    /// The value at a place in index space; NaN if there is none.
    pub(super) fn value(&self, place: [f64; 3]) -> f64 {
        let cubic = self.cubic.map(|field| field.value(place));
        cubic.filter(|value| value.is_finite()).unwrap_or_else(|| self.field.at_index(place))
    }

    /// The gradient in the world at a place in index space.
    pub(super) fn gradient(&self, place: [f64; 3]) -> Vector {
        let cubic = self.cubic.map(|field| field.slope(place).gradient);
        match cubic.filter(|gradient| gradient.iter().all(|part| part.is_finite())) {
            Some(gradient) => self.field.in_world(gradient),
            None => self.field.gradient(place),
        }
    }

    /// Adds what is seen in the next steps of rays; the bits of those that are as good as opaque then.
    pub(super) fn gather_cubic(&self, mut ready: u16, front: &mut Front) -> u16 {
        let mut are_opaque = 0;
        while ready != 0 {
            let n = ready.trailing_zeros() as usize;
            ready &= ready - 1;
            let next = self.of_step(front, n).dimmed(self.share(front, n));
            let gathered = front.gathered(n).over(next);
            front.set(n, gathered);
            are_opaque |= u16::from(gathered.opacity >= self.opaque) << n;
        }
        are_opaque
    }

    /// What a ray's next step looks like.
    fn of_step(&self, front: &Front, n: usize) -> Gathered {
        let (way, steps) = (&front.ways[n], front.on.steps[n]);
        let place = way.at(steps);
        let shade = |gradient| self.light.map(|light| light.answer(gradient, way.towards));
        if self.lookup.has_integrals() {
            let ends = [steps - 0.5, steps + 0.5].map(|end| self.value(way.at(end)));
            let gradient = if self.light.is_some() { self.gradient(place) } else { [0.0; 3] };
            return self.between(ends, 1.0, shade(gradient));
        }
        let Some(seen) = self.lookup.place(self.value(place) as f32) else {
            return Gathered::NOTHING;
        };
        let gradient = if self.has_gradients() { self.gradient(place) } else { [0.0; 3] };
        self.lookup.gathered(Place { slope: length(gradient), ..seen }, shade(gradient))
    }
}
