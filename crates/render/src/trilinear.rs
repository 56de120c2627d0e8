//! A volume between its samples: trilinear, in f64.

use crate::Ray;
use isokit_geom::{Affine, vector::Vector};
use isokit_volume::{Sample, View};

/// The values of a volume between its samples, in its box from the first sample to the last. One that is
/// infinite is taken for NaN by its cells.
#[derive(Clone, Copy, Debug)]
pub struct Trilinear<'a, T> {
    view: View<'a, T>,
    affine: Affine,
    /// What takes a gradient in index space to the world, as columns.
    covectors: [[f64; 3]; 3],
}

impl<'a, T: Sample> Trilinear<'a, T> {
    /// The values of a volume.
    pub fn new(view: View<'a, T>) -> Self {
        let affine = view.frame().index_to_world;
        Self { view, affine, covectors: affine.covector_columns() }
    }

    /// The value at a place of the world. None beyond the box, none where a sample of the cell is NaN, and none in a
    /// volume of one sample along an axis, which has no cells.
    pub fn at(&self, place: Vector) -> Option<f64> {
        let (ijk, dims) = (self.affine.inverse_point(place), self.view.dims());
        let within = |k: usize| dims[k] > 1 && (0.0..=dims[k] as f64 - 1.0).contains(&ijk[k]);
        (0..3).all(within).then(|| self.at_index(ijk)).filter(|value| !value.is_nan())
    }

    /// From where to where a ray is in the box, as distances from where it begins; none beside it. A volume of one
    /// sample along an axis has no inside.
    pub(crate) fn interval(&self, ray: &Ray) -> Option<[f64; 2]> {
        let dims = self.view.dims();
        if dims.contains(&1) {
            return None;
        }
        let origin = self.affine.inverse_point(ray.origin);
        let direction = self.affine.inverse_vector(ray.direction);
        let (mut near, mut far) = (0.0_f64, f64::INFINITY);
        for k in 0..3 {
            let last = dims[k] as f64 - 1.0;
            let ends = [0.0, last].map(|end| (end - origin[k]) / direction[k]);
            if direction[k] == 0.0 {
                // Beside the box, or in it all along.
                if !(0.0..=last).contains(&origin[k]) {
                    return None;
                }
                continue;
            }
            near = near.max(ends[0].min(ends[1]));
            far = far.min(ends[0].max(ends[1]));
        }
        // Not where a camera so far away that numbers end has made one that is no number, or no end.
        (far > near && far.is_finite()).then_some([near, far])
    }

    /// The value at a place in index space: from the least value of the cell's corners to the greatest, whatever is
    /// rounded.
    pub(crate) fn at_index(&self, place: [f64; 3]) -> f64 {
        let (cell, [x, y, z]) = self.cell(place);
        let scaling = self.view.scaling();
        let corners = self.view.cell(cell).map(|sample| scaling.value(sample.to_f64()));
        let edge = |k: usize| between(corners[k], corners[k + 1], x);
        between(between(edge(0), edge(2), y), between(edge(4), edge(6), y), z)
    }

    /// What points across the border at which the volume ends along an axis.
    pub(crate) fn across(&self, axis: usize) -> Vector {
        self.covectors[axis]
    }

    /// The volume.
    pub(crate) fn view(&self) -> &View<'a, T> {
        &self.view
    }

    /// Index space to the world.
    pub(crate) fn affine(&self) -> &Affine {
        &self.affine
    }

    /// The cell of a place in index space, and how far in it the place is along each axis, from 0 to 1. Rounding may
    /// lead out of the volume; the nearest cell goes on there.
    #[inline(always)]
    fn cell(&self, place: [f64; 3]) -> ([usize; 3], [f64; 3]) {
        let mut part = [0.0; 3];
        let cell = std::array::from_fn(|k| {
            // What is below 0 becomes 0.
            let low = (place[k] as usize).min(self.view.dims()[k].saturating_sub(2));
            part[k] = (place[k] - low as f64).clamp(0.0, 1.0);
            low
        });
        (cell, part)
    }

    /// The gradient in the world, but for its length, at a place in index space: by central differences of values a
    /// sample before and after along each axis, which is what interpolating the central differences at samples
    /// gives; at the border and beside what has no value, by that of one side.
    #[inline(always)]
    pub(crate) fn gradient(&self, place: [f64; 3]) -> Vector {
        let (cell, part) = self.cell(place);
        let dims = self.view.dims();
        if (0..3).all(|k| cell[k] >= 1 && cell[k] + 2 < dims[k]) {
            let found = self.within(cell, part);
            if found.iter().all(|part| part.is_finite()) {
                return self.in_world(found);
            }
        }
        self.beside(place)
    }

    /// The same, in index space, where there are samples on all sides.
    #[inline(always)]
    fn within(&self, cell: [usize; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
        let row = |j: usize, k: usize| -> [f64; 4] {
            let low = [cell[0] - 1, cell[1] + j - 1, cell[2] + k - 1];
            match self.view.four(low) {
                Some(four) => four.map(Sample::to_f64),
                None => {
                    std::array::from_fn(|i| self.view.stored([low[0] + i, low[1], low[2]]).to_f64())
                }
            }
        };
        // By places along y and z; of those on the outer rows only the two in the middle count.
        let rows = [row(1, 1), row(2, 1), row(1, 2), row(2, 2)];
        let line: [f64; 4] = std::array::from_fn(|i| {
            mix(mix(rows[0][i], rows[1][i], y), mix(rows[2][i], rows[3][i], y), z)
        });
        let middle = |row: [f64; 4]| mix(row[1], row[2], x);
        let [a, b, c, d] = rows.map(middle);
        let rise = |[before, low, high, after]: [f64; 4], share: f64| {
            mix(high, after, share) - mix(before, low, share)
        };
        let outer = |j: usize, k: usize| middle(row(j, k));
        let along_y = mix(
            rise([outer(0, 1), a, b, outer(3, 1)], y),
            rise([outer(0, 2), c, d, outer(3, 2)], y),
            z,
        );
        let along_z = mix(
            rise([outer(1, 0), a, c, outer(1, 3)], z),
            rise([outer(2, 0), b, d, outer(2, 3)], z),
            y,
        );
        [rise(line, x), along_y, along_z].map(|rise| rise * self.view.scaling().slope())
    }

    fn in_world(&self, part: Vector) -> Vector {
        let columns = &self.covectors;
        std::array::from_fn(|k| {
            columns[0][k] * part[0] + columns[1][k] * part[1] + columns[2][k] * part[2]
        })
    }

    /// The gradient where samples are missing on a side.
    #[inline(never)]
    fn beside(&self, place: [f64; 3]) -> Vector {
        let dims = self.view.dims();
        let part: [f64; 3] = std::array::from_fn(|k| {
            let at = |offset: f64| {
                let mut there = place;
                there[k] = (place[k] + offset).clamp(0.0, dims[k] as f64 - 1.0);
                (self.at_index(there), there[k])
            };
            let rise = |(below, low): (f64, f64), (above, high): (f64, f64)| {
                Some((above - below) / (high - low)).filter(|rise| rise.is_finite())
            };
            let (before, after) = (at(-1.0), at(1.0));
            let one_sided = || rise(before, at(0.0)).or_else(|| rise(at(0.0), after));
            rise(before, after).or_else(one_sided).unwrap_or(0.0)
        });
        self.in_world(part)
    }
}

/// Part of the way from one number to another.
#[inline(always)]
fn mix(a: f64, b: f64, share: f64) -> f64 {
    a + (b - a) * share
}

/// The same, and between them whatever is rounded. Where one is NaN so is what comes out.
#[inline(always)]
fn between(a: f64, b: f64, share: f64) -> f64 {
    mix(a, b, share).max(a.min(b)).min(a.max(b)) + 0.0 * (a - b)
}

#[cfg(test)]
mod tests {
    use super::Trilinear;
    use isokit_geom::{Affine, Frame};
    use isokit_volume::{Grid, Scaling, Volume};

    #[test]
    fn there_is_nothing_between_the_samples_of_one_slice() {
        let grid = Grid::new([3, 3, 1], Frame::default()).unwrap();
        let volume = Volume::new(grid, vec![1_u8; 9]).unwrap();
        assert_eq!(Trilinear::new(volume.view()).at([1.0, 1.0, 0.0]), None);
    }

    #[test]
    fn a_value_is_never_beyond_those_of_its_corners() {
        let grid = Grid::new([2; 3], Frame::default()).unwrap();
        let scaling = Scaling::new(0.1, 0.0).unwrap();
        let flat = Volume::new(grid, vec![7_i16; 8]).unwrap().with_scaling(scaling);
        let steep = Volume::new(grid, (0..8).map(|n| [1.0, 1e17][n & 1]).collect::<Vec<f64>>());
        let steep = steep.unwrap();
        for n in 0..1000 {
            let place = [n % 10, n / 10 % 10, n / 100].map(|c| f64::from(c) / 9.0);
            assert_eq!(Trilinear::new(flat.view()).at(place), Some(scaling.value(7.0)));
            let found = Trilinear::new(steep.view()).at(place).unwrap();
            assert!((1.0..=1e17).contains(&found), "{place:?}: {found}");
        }
    }

    #[test]
    fn gradients_keep_what_is_small_beside_a_large_offset() {
        let grid = Grid::new([5; 3], Frame::default()).unwrap();
        let value = |n: u64| 1e9 + 0.25 * (n % 5) as f64 - 0.5 * (n / 5 % 5) as f64;
        let volume = Volume::new(grid, (0..125).map(value).collect::<Vec<f64>>()).unwrap();
        let found = Trilinear::new(volume.view()).gradient([1.5, 2.25, 1.75]);
        assert_eq!(found.map(|part| part / found[0]), [1.0, -2.0, 0.0]);
    }

    #[test]
    fn the_value_at_a_place_is_that_of_its_cell_and_there_is_none_beyond() {
        let index_to_world = Affine::axis_aligned([2.0, 1.0, 0.5], [10.0, 0.0, 0.0]).unwrap();
        let grid = Grid::new([3, 2, 2], Frame { index_to_world, ..Frame::default() }).unwrap();
        let value = |n: u64| (n % 3) as f32 + 10.0 * (n / 3 % 2) as f32 + 100.0 * (n / 6) as f32;
        let mut samples: Vec<f32> = (0..12).map(value).collect();
        let volume = Volume::new(grid, samples.clone()).unwrap();
        let (view, at) = (volume.view(), |place| Trilinear::new(volume.view()).at(place));
        assert_eq!(at([11.0, 0.5, 0.25]), Some(0.5 + 5.0 + 50.0));
        assert_eq!(at([14.0, 1.0, 0.5]), Some(112.0));
        assert_eq!([at([9.9, 0.0, 0.0]), at([10.0, 1.1, 0.0]), at([f64::NAN; 3])], [None; 3]);
        assert_eq!(view.dims(), [3, 2, 2]);
        samples[0] = f32::NAN;
        let holed = Volume::new(grid, samples).unwrap();
        assert_eq!(Trilinear::new(holed.view()).at([11.0, 0.5, 0.25]), None);
        assert!(Trilinear::new(holed.view()).at([13.0, 0.5, 0.25]).is_some());
    }
}
