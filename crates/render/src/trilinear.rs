//! A volume between its samples: trilinear, in f32.

use crate::Ray;
use isokit_geom::{Affine, vector::Vector};
use isokit_volume::{Sample, Scaling, View};

/// The values of a volume between its samples, in its box from the first sample to the last. Of samples that are i32,
/// u32 or f64 what differs by less than a ten-millionth is one value.
#[derive(Clone, Copy, Debug)]
pub struct Trilinear<'a, T> {
    view: View<'a, T>,
    affine: Affine,
    /// What takes a gradient in index space to the world, as columns.
    covectors: [[f64; 3]; 3],
    scale: Scale,
}

/// What a stored sample means, in f32.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    pub(crate) slope: f32,
    pub(crate) intercept: f32,
}

impl<'a, T: Sample> Trilinear<'a, T> {
    /// The values of a volume.
    pub fn new(view: View<'a, T>) -> Self {
        let affine = view.frame().index_to_world;
        let (covectors, scale) = (affine.covector_columns(), Scale::of(view.scaling()));
        Self { view, affine, covectors, scale }
    }

    /// The value at a place of the world. None beyond the box, and none where a sample of the cell is NaN.
    pub fn at(&self, place: Vector) -> Option<f64> {
        let ijk = self.affine.inverse_point(place);
        let within = |k: usize| (0.0..=self.view.dims()[k] as f64 - 1.0).contains(&ijk[k]);
        if !(0..3).all(within) {
            return None;
        }
        let (cell, part) = self.cell(ijk);
        Some(f64::from(self.value(cell, part))).filter(|value| !value.is_nan())
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

    /// The value at a place in index space.
    pub(crate) fn at_index(&self, place: [f64; 3]) -> f64 {
        let (cell, part) = self.cell(place);
        f64::from(self.value(cell, part))
    }

    /// What points across the border at which the volume ends along an axis.
    pub(crate) fn across(&self, axis: usize) -> Vector {
        self.covectors[axis]
    }

    /// What stored samples mean.
    pub(crate) fn scale(&self) -> Scale {
        self.scale
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
    pub(crate) fn cell(&self, place: [f64; 3]) -> ([usize; 3], [f32; 3]) {
        let mut part = [0.0; 3];
        let cell = std::array::from_fn(|k| {
            // What is below 0 becomes 0.
            let low = (place[k] as usize).min(self.view.dims()[k].saturating_sub(2));
            part[k] = ((place[k] - low as f64) as f32).clamp(0.0, 1.0);
            low
        });
        (cell, part)
    }

    /// The value in a cell.
    #[inline(always)]
    pub(crate) fn value(&self, cell: [usize; 3], [x, y, z]: [f32; 3]) -> f32 {
        let corners = self.view.cell(cell).map(|sample| sample.to_f64() as f32);
        let edge = |k: usize| mix(corners[k], corners[k + 1], x);
        let stored = mix(mix(edge(0), edge(2), y), mix(edge(4), edge(6), y), z);
        self.scale.value(stored)
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
                return self.in_world(found.map(f64::from));
            }
        }
        self.beside(place)
    }

    /// The same, in index space, where there are samples on all sides.
    #[inline(always)]
    fn within(&self, cell: [usize; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
        let row = |j: usize, k: usize| -> [f32; 4] {
            let low = [cell[0] - 1, cell[1] + j - 1, cell[2] + k - 1];
            match self.view.four(low) {
                Some(four) => four.map(|sample| sample.to_f64() as f32),
                None => std::array::from_fn(|i| {
                    self.view.stored([low[0] + i, low[1], low[2]]).to_f64() as f32
                }),
            }
        };
        // By places along y and z; of those on the outer rows only the two in the middle count.
        let rows = [row(1, 1), row(2, 1), row(1, 2), row(2, 2)];
        let line: [f32; 4] = std::array::from_fn(|i| {
            mix(mix(rows[0][i], rows[1][i], y), mix(rows[2][i], rows[3][i], y), z)
        });
        let middle = |row: [f32; 4]| mix(row[1], row[2], x);
        let [a, b, c, d] = rows.map(middle);
        let rise = |[before, low, high, after]: [f32; 4], share: f32| {
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
        [rise(line, x), along_y, along_z].map(|rise| rise * self.scale.slope)
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
                let (cell, part) = self.cell(there);
                (f64::from(self.value(cell, part)), there[k])
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
fn mix(a: f32, b: f32, share: f32) -> f32 {
    a + (b - a) * share
}

impl Scale {
    pub(crate) fn of(scaling: Scaling) -> Self {
        Self { slope: scaling.slope() as f32, intercept: scaling.intercept() as f32 }
    }

    /// The value of a stored sample. Rounding keeps order: it never falls where samples rise, or never rises.
    #[inline(always)]
    pub(crate) fn value(self, stored: f32) -> f32 {
        stored * self.slope + self.intercept
    }
}

#[cfg(test)]
mod tests {
    use super::Trilinear;
    use isokit_geom::{Affine, Frame};
    use isokit_volume::{Grid, Volume};

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
