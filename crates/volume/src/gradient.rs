//! How fast the value changes at a lattice point.

use crate::{Sample, View};

/// The gradient of the value in index space, per sample: [`differences`] of what samples mean.
///
/// # Panics
///
/// If there is no such lattice point.
pub fn gradient<T: Sample>(view: &View<'_, T>, ijk: [usize; 3]) -> [f64; 3] {
    differences(view, ijk).map(|difference| difference * view.scaling().slope())
}

/// How fast stored samples change along x, y, z, per sample: central differences, one-sided at the border.
///
/// Along an axis on which a difference is not finite, because a neighbour is NaN or infinite, the other
/// side alone is asked; where that is of no use either, and along an axis of one sample, it is 0.
///
/// # Panics
///
/// If there is no such lattice point.
pub fn differences<T: Sample>(view: &View<'_, T>, ijk: [usize; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| {
        let at = |offset: isize| {
            let mut there = ijk;
            there[axis] = there[axis].wrapping_add_signed(offset);
            (there[axis] < view.dims()[axis]).then(|| view.stored(there).to_f64())
        };
        let stored = match (at(-1), at(1)) {
            (Some(below), Some(above)) => difference(above, below, 0.5).or_else(|| {
                let here = view.stored(ijk).to_f64();
                difference(above, here, 1.0).or_else(|| difference(here, below, 1.0))
            }),
            (Some(below), None) => difference(view.stored(ijk).to_f64(), below, 1.0),
            (None, Some(above)) => difference(above, view.stored(ijk).to_f64(), 1.0),
            (None, None) => None,
        };
        stored.unwrap_or(0.0)
    })
}

/// `(above − below) · factor` if it is finite, for all finite samples.
#[inline(always)]
fn difference(above: f64, below: f64, factor: f64) -> Option<f64> {
    let plain = (above - below) * factor;
    if plain.is_finite() {
        return Some(plain);
    }
    // Only f64 samples of opposite sign near the greatest can overflow; saturate, keep the sign.
    (above.is_finite() && below.is_finite()).then(|| f64::MAX.copysign(above - below))
}

#[cfg(test)]
mod tests {
    use super::gradient;
    use crate::{Grid, Scaling, Volume};
    use isokit_geom::Frame;

    fn volume(f: impl Fn([f64; 3]) -> f64) -> Volume<f64> {
        let grid = Grid::new([5, 4, 3], Frame::default()).unwrap();
        let point = |n: usize| [n % 5, n / 5 % 4, n / 20].map(|i| i as f64);
        Volume::new(grid, (0..60).map(|n| f(point(n))).collect()).unwrap()
    }

    #[test]
    fn a_linear_field_has_one_gradient_everywhere() {
        let volume = volume(|[x, y, z]| 2.0 * x - 3.0 * y + 0.5 * z);
        let scaled = volume.with_scaling(Scaling::new(-2.0, 7.0).unwrap());
        for ijk in [[0, 0, 0], [4, 3, 2], [2, 1, 1], [0, 2, 2]] {
            assert_eq!(gradient(&scaled.view(), ijk), [-4.0, 6.0, -1.0], "{ijk:?}");
        }
    }

    #[test]
    fn a_neighbour_without_a_value_is_passed_over() {
        let hole = volume(|[x, y, z]| if x == 1.0 { f64::NAN } else { 2.0 * x + y + z });
        assert_eq!(gradient(&hole.view(), [2, 1, 1]), [2.0, 1.0, 1.0]);
        assert_eq!(gradient(&hole.view(), [0, 1, 1]), [0.0, 1.0, 1.0]);
    }

    #[test]
    fn the_greatest_samples_give_a_finite_gradient() {
        let steep = volume(|[x, _, _]| if x > 2.0 { f64::MAX } else { -f64::MAX });
        assert_eq!(gradient(&steep.view(), [2, 1, 1]), [f64::MAX, 0.0, 0.0]);
    }
}
