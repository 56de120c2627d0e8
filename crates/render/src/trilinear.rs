//! A volume between its samples: trilinear, in f64.

use crate::Ray;
use isokit_geom::{
    Affine, HalfSpace,
    vector::{Vector, dot},
};
use isokit_volume::{Sample, View};

/// The values of a volume between its samples, in its box from the first sample to the last. One that is
/// infinite is taken for NaN by its cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trilinear<'a, T> {
    view: View<'a, T>,
    affine: Affine,
    /// What takes a gradient in index space to the world, as columns.
    covectors: [[f64; 3]; 3],
}

impl<'a, T: Sample> Trilinear<'a, T> {
    /// The values of a volume.
    pub(crate) fn new(view: View<'a, T>) -> Self {
        let affine = view.frame().index_to_world;
        Self { view, affine, covectors: affine.covector_columns() }
    }

    /// The value at a place of the world. None beyond the box, none where a sample of the cell is NaN, and none in a
    /// volume of one sample along an axis, which has no cells.
    #[cfg(test)]
    pub(crate) fn at(&self, place: Vector) -> Option<f64> {
        Some(self.at_index(self.index_of(place)?)).filter(|value| !value.is_nan())
    }

    /// A place of the world in index space. None beyond the box, and none in a volume of one sample along an axis.
    pub(crate) fn index_of(&self, place: Vector) -> Option<[f64; 3]> {
        let (ijk, dims) = (self.affine.inverse_point(place), self.view.dims());
        let within = |k: usize| dims[k] > 1 && (0.0..=dims[k] as f64 - 1.0).contains(&ijk[k]);
        (0..3).all(within).then_some(ijk)
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

    /// The same, as far as planes keep it.
    pub(crate) fn interval_within(&self, ray: &Ray, clips: &[HalfSpace]) -> Option<[f64; 2]> {
        cut(self.interval(ray)?, ray, clips)
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

    /// The gradient in the world at a place in index space: central differences at samples, at the border those of one
    /// side, interpolated. Beside what has no value it is found by differences of values around the place.
    #[inline(always)]
    pub(crate) fn gradient(&self, place: [f64; 3]) -> Vector {
        let (cell, part) = self.cell(place);
        let found = self.within(cell, part);
        match found.iter().all(|part| part.is_finite()) {
            true => self.in_world(found),
            false => self.beside(place),
        }
    }

    /// The same in index space. What is missing beyond the border goes on from there in a straight line: a central
    /// difference with it is that of one side.
    #[inline(always)]
    fn within(&self, cell: [usize; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
        let dims = self.view.dims();
        let has = [0, 1, 2].map(|k| [cell[k] >= 1, cell[k] + 2 < dims[k]]);
        let [i, j, k] = cell;
        let rows = [
            self.four([i, j, k], has[0]),
            self.four([i, j + 1, k], has[0]),
            self.four([i, j, k + 1], has[0]),
            self.four([i, j + 1, k + 1], has[0]),
        ];
        let mut line = [0.0; 4];
        for (n, value) in line.iter_mut().enumerate() {
            *value = mix(mix(rows[0][n], rows[1][n], y), mix(rows[2][n], rows[3][n], y), z);
        }
        let [a, b, c, d] = rows.map(|row| mix(row[1], row[2], x));
        let along_y = mix(
            self.along([i, j, k], (1, has[1]), [a, b], [x, y]),
            self.along([i, j, k + 1], (1, has[1]), [c, d], [x, y]),
            z,
        );
        let along_z = mix(
            self.along([i, j, k], (2, has[2]), [a, c], [x, z]),
            self.along([i, j + 1, k], (2, has[2]), [b, d], [x, z]),
            y,
        );
        // Over two samples.
        [rise(line, x), along_y, along_z].map(|rise| 0.5 * rise * self.view.scaling().slope())
    }

    /// How values rise along y or z, over two samples, between a row along x and the next. A row before or after them
    /// that is not there goes on from them.
    #[inline(always)]
    fn along(
        &self,
        row: [usize; 3],
        (axis, [before, after]): (usize, [bool; 2]),
        [low, high]: [f64; 2],
        [x, share]: [f64; 2],
    ) -> f64 {
        let (mut below, mut above) = (row, row);
        below[axis] = below[axis].wrapping_sub(1);
        above[axis] += 2;
        let below = if before { self.middle(below, x) } else { 2.0 * low - high };
        let above = if after { self.middle(above, x) } else { 2.0 * high - low };
        rise([below, low, high, above], share)
    }

    /// Between a sample and the next along x.
    #[inline(always)]
    fn middle(&self, [x, y, z]: [usize; 3], share: f64) -> f64 {
        let at = |x: usize| self.view.stored([x, y, z]).to_f64();
        mix(at(x), at(x + 1), share)
    }

    /// A sample and the next along x, and those before and after them; what is missing goes on in a straight line.
    #[inline(always)]
    fn four(&self, [x, y, z]: [usize; 3], has: [bool; 2]) -> [f64; 4] {
        let at = |x: usize| self.view.stored([x, y, z]).to_f64();
        let (low, high) = (at(x), at(x + 1));
        let before = if has[0] { at(x - 1) } else { 2.0 * low - high };
        let after = if has[1] { at(x + 2) } else { 2.0 * high - low };
        [before, low, high, after]
    }

    /// A gradient in index space, in the world.
    pub(crate) fn in_world(&self, part: Vector) -> Vector {
        let columns = &self.covectors;
        std::array::from_fn(|k| {
            columns[0][k] * part[0] + columns[1][k] * part[1] + columns[2][k] * part[2]
        })
    }

    /// The gradient where samples around have no value.
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

/// What planes keep of a ray from one distance to another.
#[inline]
pub(crate) fn cut(
    [mut near, mut far]: [f64; 2],
    ray: &Ray,
    clips: &[HalfSpace],
) -> Option<[f64; 2]> {
    for clip in clips {
        let (beyond, along) = (clip.beyond(ray.origin), dot(clip.normal(), ray.direction));
        let end = -beyond / along;
        match (along > 0.0, along < 0.0) {
            (true, _) => far = far.min(end),
            (_, true) => near = near.max(end),
            // Along the plane, on one side of it.
            _ if beyond > 0.0 => return None,
            _ => {}
        }
    }
    (far > near).then_some([near, far])
}

/// How values rise between the two in the middle of four, over two of them.
#[inline(always)]
fn rise([before, low, high, after]: [f64; 4], share: f64) -> f64 {
    mix(high, after, share) - mix(before, low, share)
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
        assert_eq!(found, [0.25, -0.5, 0.0]);
    }

    #[test]
    fn gradients_of_what_rises_evenly_are_its_slopes_at_the_border_too() {
        let index_to_world = Affine::axis_aligned([2.0, 0.5, 1.0], [0.0; 3]).unwrap();
        for dims in [[5, 4, 6], [2, 3, 2]] {
            let grid = Grid::new(dims, Frame { index_to_world, ..Frame::default() }).unwrap();
            let [nx, ny, _] = dims;
            let value = |n: u64| {
                let [i, j, k] = [n % nx, n / nx % ny, n / nx / ny].map(|c| c as f32);
                3.0 * i - j + 4.0 * k
            };
            let volume = Volume::new(grid, (0..grid.count()).map(value).collect()).unwrap();
            let field = Trilinear::new(volume.view());
            for n in 0..1000_u64 {
                let place: [f64; 3] = std::array::from_fn(|k| {
                    let part = n / 10_u64.pow(k as u32) % 10;
                    part as f64 / 9.0 * (dims[k] - 1) as f64
                });
                let found = field.gradient(place);
                let off =
                    (0..3).map(|k| (found[k] - [1.5, -2.0, 4.0][k]).abs()).fold(0.0, f64::max);
                assert!(off < 1e-12, "{place:?}: {found:?}");
            }
        }
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
