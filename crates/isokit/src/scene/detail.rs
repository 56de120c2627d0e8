//! How much detail a picture can show: samples that are nearer to each other than its pixels need not be looked at.

use super::{Scene, SceneError, Viewpoint, needs::Views};
use crate::pipeline::{Lattice, Scan};
use isokit_geom::Aabb;
use isokit_job::Job;
use isokit_lanes::Side;
use isokit_mesh::TriMesh;
use isokit_render::{Projection, Size};
use isokit_volume::{Sample, View, for_any};

/// Surfaces as far as pixels show them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OnScreen {
    /// One for each surface of the scene, as [`Scene::meshes`] has them.
    pub meshes: Vec<TriMesh>,
    /// How often samples were halved along x, y, z.
    pub halvings: [u32; 3],
    /// Bricks that a surface goes through, once for each surface.
    pub bricks: u64,
    /// Those in which nothing of it was left.
    pub bricks_lost: u64,
}

/// Of fewer samples along an axis none are left out.
const FEWEST: usize = 8;

impl Scene {
    /// How often samples can be [halved](Scan::halved) along x, y, z so that in a picture of a box from each of the
    /// viewpoints they are nowhere in it farther from each other than pixels.
    ///
    /// # Errors
    ///
    /// If a camera sees nothing.
    pub fn halvings(
        lattice: &Lattice,
        bounds: Aabb,
        (viewpoints, size): (&[Viewpoint], Size),
    ) -> Result<[u32; 3], SceneError> {
        let space = lattice.frame().space;
        let mut pixel = f64::INFINITY;
        for viewpoint in viewpoints {
            let camera = viewpoint.camera((bounds, space), size)?;
            let ahead = bounds.corners().map(|corner| camera.view(corner)[2]);
            let nearest = match camera.projection() {
                Projection::Parallel { .. } => 1.0,
                Projection::Perspective { .. } => ahead.into_iter().fold(f64::INFINITY, f64::min),
            };
            let height = 2.0 * nearest / camera.magnification();
            pixel = pixel.min(height / f64::from(size.height.get()));
        }
        let (affine, part) = (lattice.frame().index_to_world, lattice.part());
        let spacing = affine.spacing();
        Ok(std::array::from_fn(|k| {
            // Beyond some distance there is no map from samples to the world.
            let is_map = |apart: f64| {
                let mut factors = [1.0; 3];
                factors[k] = apart / spacing[k];
                affine.scaled_steps(factors).is_ok()
            };
            let (mut halvings, mut apart, mut count) = (0, 2.0 * spacing[k], part[k].len());
            while apart <= pixel && count >= FEWEST && is_map(apart) {
                (halvings, apart, count) = (halvings + 1, 2.0 * apart, count.div_ceil(2));
            }
            halvings
        }))
    }

    /// The surfaces of a scan that can be seen, as [`meshes`](Self::meshes), of as few samples as pictures of that size
    /// from these viewpoints show: nowhere are they farther from each other than pixels.
    ///
    /// # Errors
    ///
    /// As [`meshes`](Self::meshes), or if a camera sees nothing.
    pub fn meshes_on_screen(
        &self,
        scan: &Scan,
        camera: (&[Viewpoint], Size),
        job: &Job,
    ) -> Result<OnScreen, SceneError> {
        self.check_names()?;
        let (around, is_surrounded) = (scan.around().0, self.raster.needs_surroundings());
        let views = self.views(scan.lattice(), camera, is_surrounded)?;
        let mut halvings = Self::halvings(scan.lattice(), around, camera)?;
        loop {
            let coarse = scan.halved(halvings, job)?;
            let meshes = self.meshes_in(coarse.as_ref().unwrap_or(scan), &views, job)?;
            // Pictures are framed by the surfaces, which are less than the scan.
            let bounds = self.extent(&meshes).unwrap_or(around);
            let needed = Self::halvings(scan.lattice(), bounds, camera)?;
            if (0..3).any(|k| needed[k] < halvings[k]) {
                halvings = std::array::from_fn(|k| needed[k].min(halvings[k]));
                continue;
            }
            let (bricks, bricks_lost) = match &coarse {
                Some(coarse) => self.lost(scan, (coarse, halvings), &views, job)?,
                None => (0, 0),
            };
            return Ok(OnScreen { meshes, halvings, bricks, bricks_lost });
        }
    }

    /// Bricks that surfaces go through, and those of them in which fewer samples have none.
    fn lost(
        &self,
        scan: &Scan,
        (coarse, halvings): (&Scan, [u32; 3]),
        views: &Views,
        job: &Job,
    ) -> Result<(u64, u64), SceneError> {
        let isos = self.surfaces.iter();
        let isos = isos.filter(|look| self.part_of(look, scan.lattice(), views).is_ok());
        let isos: Vec<f64> = isos.filter_map(|look| look.iso).collect();
        let mut counts = (0, 0);
        for_any!(scan.volume(), volume => {
            let view = scan.view(volume);
            let bricks = scan.part_bricks(&view, job)?;
            let grid = bricks.grid();
            for &iso in &isos {
                let sides = bricks.sides(view.scaling().threshold(iso));
                let [nx, ny, _] = grid.counts();
                let active = sides.of_brick.iter().enumerate().filter(|(_, side)| **side == Side::Both);
                for (number, _) in active {
                    job.check()?;
                    let brick = [number % nx, number / nx % ny, number / nx / ny];
                    let samples = std::array::from_fn(|k| grid.samples(k, brick[k]));
                    let is_left = for_any!(coarse.volume(), volume => {
                        has_both(&coarse.view(volume), samples, halvings, iso)
                    });
                    counts.0 += 1;
                    counts.1 += u64::from(!is_left);
                }
            }
        });
        Ok(counts)
    }
}

/// Whether samples of a box, of which fewer are left, are on both sides of a value.
fn has_both<T: Sample>(
    view: &View<'_, T>,
    samples: [std::ops::RangeInclusive<usize>; 3],
    halvings: [u32; 3],
    iso: f64,
) -> bool {
    let threshold = view.scaling().threshold::<T>(iso);
    let [x, y, z]: [_; 3] = std::array::from_fn(|k| {
        let last = view.dims()[k] - 1;
        // With the ones around.
        let [first, end] = [*samples[k].start(), *samples[k].end()].map(|at| at >> halvings[k]);
        first.min(last)..(end + 2).min(last + 1)
    });
    let mut found = [false; 2];
    for (k, j) in z.flat_map(|k| y.clone().map(move |j| (k, j))) {
        for i in x.clone() {
            found[usize::from(threshold.is_inside(view.stored([i, j, k])))] = true;
        }
        if found == [true; 2] {
            return true;
        }
    }
    false
}
