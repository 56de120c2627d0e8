//! A lattice edge that the surface cuts, and where it does.

use isokit::volume::{Sample, View};

/// A lattice edge. Its order is the one in which an extractor numbers its vertices: slice by slice, the
/// edges within a slice before those that lead to the next, row by row, of a row first those along x.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct CutEdge {
    z: i64,
    leads_to_next_slice: bool,
    y: i64,
    axis: usize,
    x: i64,
}

impl CutEdge {
    /// The edge between neighbouring points, in either order, of a lattice that starts `guard` points
    /// before the first sample.
    pub(super) fn between(a: [usize; 3], b: [usize; 3], guard: usize) -> Self {
        let axis = (0..3).find(|&k| a[k] != b[k]).expect("two points");
        let [x, y, z] = std::array::from_fn(|k| a[k].min(b[k]) as i64 - guard as i64);
        Self { z, leads_to_next_slice: axis == 2, y, axis, x }
    }

    /// The axis it runs along.
    pub fn axis(&self) -> usize {
        self.axis
    }

    /// Its lower end, in samples; −1 where that lies outside the volume.
    pub fn low(&self) -> [i64; 3] {
        [self.x, self.y, self.z]
    }

    /// Its middle, in samples.
    pub fn middle(&self) -> [f64; 3] {
        let mut middle = self.low().map(|c| c as f64);
        middle[self.axis] += 0.5;
        middle
    }

    /// Where it is cut, in edge lengths from its middle: between −½ and ½ less the margin. Beside the
    /// outside of the volume it is cut at the sample, beside a value that is not finite at the other one.
    pub fn cut<T: Sample>(&self, view: &View<'_, T>, iso: f64, margin: f64) -> f64 {
        let mut high = self.low();
        high[self.axis] += 1;
        let value = |ijk: [i64; 3]| {
            let held = (0..3).all(|k| (0..view.dims()[k] as i64).contains(&ijk[k]));
            held.then(|| view.value(ijk.map(|i| i as usize)))
        };
        let is_finite = |value: Option<f64>| value.is_some_and(f64::is_finite);
        let delta = match [value(self.low()), value(high)] {
            [Some(a), Some(b)] if a.is_finite() && b.is_finite() => {
                // A power of two, so that nothing overflows and nothing vanishes.
                let scale =
                    if a.abs().max(b.abs()) > 1.0 { 2_f64.powi(-4) } else { 2_f64.powi(60) };
                let [alpha, beta] = [a, b].map(|end| end * scale - iso * scale);
                ((alpha + beta) / 2.0) / (alpha - beta)
            }
            [None, _] => 0.5,
            [_, None] => -0.5,
            [low, high] => match [is_finite(low), is_finite(high)] {
                [true, false] => -0.5,
                [false, true] => 0.5,
                _ => 0.0,
            },
        };
        delta.clamp(margin - 0.5, 0.5 - margin)
    }

    /// Where it is cut, in world space.
    pub fn position<T: Sample>(&self, view: &View<'_, T>, iso: f64, margin: f64) -> [f64; 3] {
        let mut ijk = self.middle();
        ijk[self.axis] += self.cut(view, iso, margin);
        view.frame().index_to_world.point(ijk)
    }
}

#[cfg(test)]
mod tests {
    use super::CutEdge;
    use isokit::geom::Frame;
    use isokit::volume::{Grid, Volume};

    fn cut(a: f64, b: f64, iso: f64, margin: f64) -> f64 {
        let grid = Grid::new([2, 1, 1], Frame::default()).unwrap();
        let volume = Volume::new(grid, vec![a, b]).unwrap();
        CutEdge::between([0, 0, 0], [1, 0, 0], 0).cut(&volume.view(), iso, margin)
    }

    #[test]
    fn linear_interpolation_cuts_where_it_should() {
        assert_eq!(cut(0.0, 4.0, 1.0, 0.0), -0.25);
        assert_eq!(cut(4.0, 0.0, 1.0, 0.0), 0.25);
        assert_eq!(cut(-f64::MAX, f64::MAX, 0.0, 0.0), 0.0);
        assert_eq!(cut(0.0, 4e-320, 2e-320, 0.0), 0.0);
        assert_eq!(cut(0.0, 4.0, 4.0, 0.125), 0.375);
        assert_eq!([cut(1.0, f64::NAN, 0.0, 0.0), cut(f64::INFINITY, 1.0, 2.0, 0.0)], [-0.5, 0.5]);
    }

    #[test]
    fn edges_are_in_the_order_of_slices_then_rows() {
        let edge = |low: [usize; 3], axis: usize| {
            let mut high = low;
            high[axis] += 1;
            CutEdge::between(high, low, 1)
        };
        let ordered = [
            edge([0, 0, 0], 0),
            edge([5, 0, 0], 0),
            edge([0, 0, 0], 1),
            edge([0, 1, 0], 0),
            edge([0, 0, 0], 2),
            edge([0, 0, 1], 0),
        ];
        assert!(ordered.is_sorted(), "{ordered:?}");
        assert_eq!(ordered[1].low(), [4, -1, -1]);
        assert_eq!(ordered[1].middle(), [4.5, -1.0, -1.0]);
    }
}
