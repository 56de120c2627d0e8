//! The values of a volume at places between its samples, as they are carried to something else: the vertices of
//! a mesh.
//!
//! A sample stands for its surroundings, up to half of the way to where the next one would be. So a place that is
//! no farther than that beyond the first or last sample has a value, that of the nearest place within; one that
//! is farther has none. The vertices of caps, which lie on the border, have one however they are rounded.

use isokit_geom::vector::Vector;
use isokit_volume::{Sample, View};

/// What is between samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Between {
    /// What is linear along each axis: for quantities.
    #[default]
    Linear,
    /// The nearest sample, of two as near the later one: for labels.
    Nearest,
}

/// The value at a place in index space. None farther than half a sample beyond the border, none at a place that is
/// no number, and none where a sample that has a part in it is not finite.
///
/// Linear functions come out as they are, but for rounding.
pub fn probe<T: Sample>(view: &View<'_, T>, ijk: Vector, between: Between) -> Option<f64> {
    let last = view.dims().map(|n| n as f64 - 1.0);
    let is_near = |k: usize| ijk[k] >= -0.5 && ijk[k] <= last[k] + 0.5;
    if !(0..3).all(is_near) {
        return None;
    }
    let place: Vector = std::array::from_fn(|k| ijk[k].clamp(0.0, last[k]));
    let value = match between {
        Between::Nearest => view.value(place.map(|c| (c + 0.5).floor() as usize)),
        Between::Linear => linear(view, place),
    };
    value.is_finite().then_some(value)
}

/// At a place between the first and last samples.
fn linear<T: Sample>(view: &View<'_, T>, place: Vector) -> f64 {
    let low = place.map(|c| c as usize);
    let part: Vector = std::array::from_fn(|k| place[k] - low[k] as f64);
    let mut sum = 0.0;
    for corner in 0..8 {
        let up = [0, 1, 2].map(|k| corner >> k & 1);
        let share = |k: usize| if up[k] == 1 { part[k] } else { 1.0 - part[k] };
        let weight = share(0) * share(1) * share(2);
        // What has no part in it is not asked: it may be NaN, or beyond the last sample.
        if weight > 0.0 {
            sum += weight * view.value(std::array::from_fn(|k| low[k] + up[k]));
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::{Between, probe};
    use isokit_geom::Frame;
    use isokit_volume::{Grid, Scaling, Volume};

    fn volume(dims: [u64; 3], f: impl Fn([f64; 3]) -> f64) -> Volume<f64> {
        let grid = Grid::new(dims, Frame::default()).unwrap();
        let [nx, ny, _] = dims;
        let at = |n: u64| f([n % nx, n / nx % ny, n / (nx * ny)].map(|i| i as f64));
        Volume::new(grid, (0..grid.count()).map(at).collect()).unwrap()
    }

    #[test]
    fn what_is_linear_along_each_axis_comes_out_as_it_is() {
        let f = |[x, y, z]: [f64; 3]| 2.0 * x - 3.0 * y + 0.5 * z + 0.25 * x * y * z - 7.0;
        let volume = volume([5, 4, 3], f).with_scaling(Scaling::new(2.0, 1.0).unwrap());
        for n in 0..600 {
            let place = [n % 17, n / 17 % 13, n / 221].map(f64::from);
            let place = std::array::from_fn(|k| place[k] * [0.25, 0.25, 0.9][k]);
            let found = probe(&volume.view(), place, Between::Linear).unwrap();
            assert!((found - (2.0 * f(place) + 1.0)).abs() < 1e-12, "{place:?}");
        }
    }

    #[test]
    fn half_a_sample_beyond_the_border_there_is_a_value_and_no_farther() {
        let volume = volume([4, 3, 1], |[x, y, _]| x + 10.0 * y);
        let at = |place, between| probe(&volume.view(), place, between);
        for between in [Between::Linear, Between::Nearest] {
            assert_eq!(at([-0.5, 0.0, 0.5], between), Some(0.0));
            assert_eq!(at([3.5, 2.0, -0.5], between), Some(23.0));
            for place in [[-0.51, 0.0, 0.0], [0.0, 2.51, 0.0], [1.0, 1.0, 0.6], [f64::NAN; 3]] {
                assert_eq!(at(place, between), None, "{place:?}");
            }
        }
    }

    #[test]
    fn a_sample_without_value_counts_where_it_has_a_part() {
        let volume = volume([3; 3], |[x, _, _]| if x == 1.0 { f64::NAN } else { x });
        let at = |x, between| probe(&volume.view(), [x, 1.0, 1.0], between);
        let found = [0.0, 0.01, 1.0, 1.99, 2.0].map(|x| at(x, Between::Linear));
        assert_eq!(found, [Some(0.0), None, None, None, Some(2.0)]);
        let found = [0.49, 0.5, 1.49, 1.5].map(|x| at(x, Between::Nearest));
        assert_eq!(found, [Some(0.0), None, None, Some(2.0)]);
    }
}
