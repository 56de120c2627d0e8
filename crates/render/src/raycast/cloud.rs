//! Light in a cloud of particles: what comes from far away, is hidden on its way into the volume, and scattered once
//! (Blinn 1982, "Light reflection functions for simulation of clouds and dusty surfaces"; Max 1995, section on single
//! scattering).
//!
//! How much light comes to a sample is found slice by slice, away from the light: as much as came to the place in the slice
//! before from which it comes, less what hides it between the two (Behrens & Ratering 1998, "Adding shadows to a
//! texture-based volume renderer"). That takes one look at each sample, and softens shadows a little.

use super::Medium;
use crate::{Camera, transfer::slope_at};
use isokit_geom::vector::{Vector, dot, length, unit};
use isokit_job::{Job, Stopped, Work};
use isokit_lanes::exactly;
use isokit_volume::Sample;
use rayon::prelude::*;
use std::mem;

/// Light that particles scatter, alike to all sides or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Where light comes from, in the world; of any length above 0. From nowhere comes none.
    pub from: Vector,
    /// How much of it is scattered to the eye where nothing is in its way: 0 or more.
    pub strength: f32,
    /// The share of its colour that a place has without that light.
    pub ambient: f32,
    /// Whether it is scattered ahead, up to 0.99, back, down to −0.99, or to all sides alike, 0 (Henyey & Greenstein 1941).
    /// What reaches the eye is that of the camera's own direction, all over the picture.
    pub ahead: f32,
}

/// How much light comes to each sample.
#[derive(Clone, Debug)]
pub(crate) struct Cloud {
    dims: [usize; 3],
    open: Vec<f32>,
    strength: f32,
    ambient: f32,
}

impl Cloud {
    /// The light in a volume whose opacities are those over such a length; none if nothing is scattered.
    ///
    /// # Errors
    ///
    /// If the job is cancelled or does not allow a number for each sample.
    pub(crate) fn new<T: Sample>(
        medium: &Medium<'_, T>,
        over: f64,
        (scatter, camera): (Option<Scatter>, &Camera),
        job: &Job,
    ) -> Result<Option<Self>, Stopped> {
        let Some(scatter) = scatter else { return Ok(None) };
        let Some(from) = unit(scatter.from) else { return Ok(None) };
        let Scatter { strength, ambient, .. } =
            Scatter { from, ..scatter }.seen_along(camera.forward());
        let (view, affine) = (medium.view, medium.view.frame().index_to_world);
        let (dims, columns) = (view.dims(), affine.covector_columns());
        let all = dims.iter().map(|&n| n as u64).product();
        let towards = affine.inverse_vector(from);
        let axis =
            (1..3).fold(0, |most, k| if towards[k].abs() > towards[most].abs() { k } else { most });
        let mut open: Vec<f32> = job.limits.zeroed("light in the volume", Some(all))?;
        // From a sample to where its light comes through the slice before, and how far that is.
        let back = towards.map(|c| c / towards[axis].abs());
        let far = length(affine.vector(back)) / over;
        let [across, down] = [(axis + 1) % 3, (axis + 2) % 3];
        let (wide, tall) = (dims[across], dims[down]);
        let extinction = |ijk: [usize; 3]| {
            let place = affine.point(ijk.map(|i| i as f64));
            let value = view.value(ijk);
            if value.is_nan() || !medium.clips.iter().all(|clip| clip.keeps(place)) {
                return 0.0;
            }
            let has_slopes = medium.model.has_slopes();
            let slope = if has_slopes { slope_at(view, &columns, ijk) } else { 0.0 };
            medium.model.extinction([value, slope], over)
        };
        // Two numbers of each sample of a slice, and those of the slice before.
        job.limits.probe("slices of light", Some((wide * tall) as u64), 4 * size_of::<f64>())?;
        let mut before =
            Slice { wide, tall, open: vec![1.0; wide * tall], hides: vec![0.0; wide * tall] };
        let mut own = before.clone();
        let mut number = 0;
        while number < dims[axis] {
            job.check()?;
            let slice = if back[axis] > 0.0 { dims[axis] - 1 - number } else { number };
            let place = |n: usize| {
                let mut ijk = [0; 3];
                (ijk[axis], ijk[across], ijk[down]) = (slice, n % wide, n / wide);
                ijk
            };
            let one = |n: usize| {
                let hides = extinction(place(n));
                let from = [(n % wide) as f64 + back[across], (n / wide) as f64 + back[down]];
                let (open, on_the_way) = before.at(from);
                // In the first slice light has come through nothing yet.
                let hidden = if number == 0 { 0.0 } else { 0.5 * (hides + on_the_way) * far };
                ((open * (-hidden).exp()) as f32, hides as f32)
            };
            let row: Work<'_, _, _> = &|(row, (open, hides)): (usize, (&mut [f32], &mut [f32]))| {
                exactly(|| {
                    for (n, (open, hides)) in (row * wide..).zip(open.iter_mut().zip(hides)) {
                        (*open, *hides) = one(n);
                    }
                });
            };
            job.threads.run(|| {
                let rows = own.open.par_chunks_mut(wide).zip(own.hides.par_chunks_mut(wide));
                rows.enumerate().with_min_len(1024_usize.div_ceil(wide)).for_each(row);
            });
            for (n, &light) in own.open.iter().enumerate() {
                let [i, j, k] = place(n);
                open[i + dims[0] * (j + dims[1] * k)] = light;
            }
            mem::swap(&mut before, &mut own);
            number += 1;
        }
        Ok(Some(Self { dims, open, strength, ambient }))
    }

    /// How much light a place in index space has.
    pub(crate) fn light(&self, place: [f64; 3]) -> f32 {
        let mut part = [0.0; 3];
        let low: [usize; 3] = std::array::from_fn(|k| {
            // What is below 0 becomes 0.
            let low = (place[k] as usize).min(self.dims[k].saturating_sub(2));
            part[k] = (place[k] - low as f64).clamp(0.0, 1.0) as f32;
            low
        });
        let [nx, ny, _] = self.dims;
        let edge = |j: usize, k: usize| {
            let first = low[0] + nx * (low[1] + j + ny * (low[2] + k));
            mix(self.open[first], self.open[first + 1], part[0])
        };
        let side = |k: usize| mix(edge(0, k), edge(1, k), part[1]);
        self.ambient + self.strength * mix(side(0), side(1), part[2])
    }
}

impl Scatter {
    /// The same with what reaches the eye of light that is scattered along such a direction: more or less than of light
    /// that is scattered to all sides alike.
    fn seen_along(self, towards: Vector) -> Self {
        let g = self.ahead.clamp(-0.99, 0.99);
        // Between where the light goes and where it is seen from.
        let cosine = (dot(self.from, towards) / (length(self.from) * length(towards))) as f32;
        let strength = self.strength * (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cosine).powf(1.5);
        Self { strength, ..self }
    }
}

/// A slice across the way of the light.
#[derive(Clone)]
struct Slice {
    wide: usize,
    tall: usize,
    open: Vec<f32>,
    hides: Vec<f32>,
}

impl Slice {
    /// The light at a place, and what hides light there; beyond the volume nothing does.
    fn at(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let (column, row) = (x.floor(), y.floor());
        let (mut open, mut hides) = (0.0, 0.0);
        for n in 0..4 {
            let [right, down] = [n & 1, n >> 1].map(f64::from);
            let share =
                |at: f64, low: f64, next: f64| if next > 0.0 { at - low } else { 1.0 - (at - low) };
            let weight = share(x, column, right) * share(y, row, down);
            let (column, row) = (column + right, row + down);
            let is_within =
                column >= 0.0 && row >= 0.0 && column < self.wide as f64 && row < self.tall as f64;
            let number = row as usize * self.wide + column as usize;
            let (own, hidden) = if is_within {
                (f64::from(self.open[number]), f64::from(self.hides[number]))
            } else {
                (1.0, 0.0)
            };
            open += weight * own;
            hides += weight * hidden;
        }
        (open, hides)
    }
}

fn mix(a: f32, b: f32, share: f32) -> f32 {
    a + (b - a) * share
}

#[cfg(test)]
mod tests {
    use super::{Cloud, Scatter};
    use crate::{
        Camera, ControlPoint, Material, Medium, Mixture, OpticalModel, Projection, SlopeFunction,
        TransferFunction,
    };
    use isokit_geom::{Affine, Frame};
    use isokit_job::{Job, Threads};
    use isokit_volume::{Grid, Volume};
    use std::num::NonZeroUsize;

    fn fog(opacity: f32) -> OpticalModel {
        let points = vec![ControlPoint { value: 0.0, color: [1.0; 3], opacity }];
        TransferFunction::new(points).unwrap().into()
    }

    fn volume() -> Volume<u8> {
        let index_to_world = Affine::axis_aligned([0.5, 1.0, 2.0], [3.0, 0.0, 0.0]).unwrap();
        let grid = Grid::new([41, 21, 11], Frame { index_to_world, ..Frame::default() }).unwrap();
        Volume::new(grid, vec![1; 41 * 21 * 11]).unwrap()
    }

    fn cloud(from: [f64; 3], threads: usize) -> Cloud {
        cloud_of(&volume(), &fog(0.1), from, threads)
    }

    fn cloud_of(
        volume: &Volume<u8>,
        model: &OpticalModel,
        from: [f64; 3],
        threads: usize,
    ) -> Cloud {
        let view = volume.view();
        let medium = Medium { view: &view, bricks: None, model, clips: &[] };
        let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
        let job = Job { threads, ..Job::default() };
        let scatter = Scatter { from, strength: 1.0, ambient: 0.0, ahead: 0.0 };
        let projection = Projection::Parallel { height: 9.0 };
        let camera = Camera::new([0.0; 3], [0.0, 9.0, 0.0], [0.0, 0.0, 1.0], projection).unwrap();
        Cloud::new(&medium, 2.0, (Some(scatter), &camera), &job).unwrap().unwrap()
    }

    #[test]
    fn light_fades_by_its_way_through_the_fog() {
        // A box of 20 edges; the middle of what light has come through without having been near to its sides.
        for (from, place, way) in [
            ([1.0, 0.0, 0.0], [20.0, 10.0, 5.0], 10.0),
            ([-3.0, 0.0, 0.0], [10.0, 10.0, 5.0], 5.0),
            ([0.0, 1.0, 0.0], [20.0, 17.0, 5.0], 3.0),
            ([0.0, 0.0, -1.0], [20.0, 10.0, 3.0], 6.0),
            ([1.0, 1.0, 0.0], [36.0, 10.0, 5.0], 2.0 * 2.0_f64.sqrt()),
        ] {
            let found = cloud(from, 1).light(place);
            let expected = 0.9_f64.powf(way / 2.0);
            assert!((f64::from(found) - expected).abs() < 1e-4, "{from:?}: {found} for {expected}");
        }
    }

    #[test]
    fn light_is_the_same_for_any_number_of_threads() {
        let from = [1.0, 2.0, 0.7];
        assert_eq!(cloud(from, 1).open, cloud(from, 3).open);
    }

    #[test]
    fn a_direction_counts_and_not_its_length() {
        let open = |factor: f64| cloud([1.0, 2.0, 0.7].map(|c| c * factor), 1).open;
        for factor in [2.0_f64.powi(900), 2.0_f64.powi(-900)] {
            assert_eq!(open(factor), open(1.0), "{factor}");
        }
    }

    #[test]
    fn what_is_seen_of_slopes_and_surfaces_hides_light_and_nothing_else() {
        let OpticalModel::Values(white) = fog(0.5) else { unreachable!("fog is of values") };
        let fading: OpticalModel = SlopeFunction::fading(white, 100.0).unwrap().into();
        let material =
            |values, density| Material { values, color: [1.0; 3], opacity: 0.0, density };
        let materials = vec![material([0.0, 10.0], 0.0), material([200.0, 255.0], 1.0)];
        let wall: OpticalModel = Mixture::new(materials, 0.75).unwrap().into();
        // Even, but for a rise of 10 samples, half a unit each, from 0 to 210.
        let rise = |n: u64| (21 * (n % 41).saturating_sub(20).min(10)) as u8;
        let grid = *volume().grid();
        let volume = Volume::new(grid, (0..grid.count()).map(rise).collect()).unwrap();
        for (model, expected) in [(fading, 0.5_f64.powf(0.42 * 2.5)), (wall, 0.25)] {
            let cloud = cloud_of(&volume, &model, [-1.0, 0.0, 0.0], 1);
            assert!((cloud.light([15.0, 10.0, 5.0]) - 1.0).abs() < 1e-6);
            let found = f64::from(cloud.light([36.0, 10.0, 5.0]));
            assert!((found / expected - 1.0).abs() < 0.05, "{found} for {expected}");
        }
    }

    #[test]
    fn light_is_scattered_ahead_back_or_to_all_sides() {
        let scatter = |ahead| Scatter { from: [0.0, 0.0, 5.0], strength: 1.0, ambient: 0.2, ahead };
        let seen = |ahead, towards| scatter(ahead).seen_along(towards).strength;
        let (against, with) = ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
        assert_eq!([seen(0.0, against), seen(0.0, with)], [1.0; 2]);
        assert!(seen(0.5, against) > 4.0 && seen(0.5, with) < 0.4);
        assert!((seen(-0.5, with) - seen(0.5, against)).abs() < 1e-5);
        // All directions together get what they would get alike: by Simpson's rule over the cosine.
        let at = |n: u32| {
            let cosine = f64::from(n) / 50.0 - 1.0;
            f64::from(seen(0.4, [(1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine]))
        };
        let sum: f64 = (0..50).map(|n| at(2 * n) + 4.0 * at(2 * n + 1) + at(2 * n + 2)).sum();
        assert!((sum / 300.0 - 1.0).abs() < 1e-4, "{sum}");
    }
}
