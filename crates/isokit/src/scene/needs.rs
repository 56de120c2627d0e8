//! What a scene needs, and what it does not.

use super::{Scene, SceneError, SurfaceLook, Viewpoint};
use crate::pipeline::Scan;
use isokit_geom::{HalfSpace, vector::dot};
use isokit_job::Job;
use isokit_lanes::Side;
use isokit_render::Size;
use isokit_volume::{Sample, View, for_any};
use std::ops::Range;

/// What is computed for the surfaces of a scene, and what is not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Needs {
    /// The surfaces in the scene's order.
    pub surfaces: Vec<SurfaceNeed>,
    /// Bricks of the scan.
    pub bricks: u64,
    /// Bricks that hold no surface that can be seen, or nothing that rays can show.
    pub bricks_skipped: u64,
    /// Samples of the scan.
    pub samples: u64,
    /// Samples that no surface needs, since planes cut away what is there, or no picture shows it.
    pub samples_skipped: u64,
}

/// What is computed for one surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceNeed {
    /// Its name.
    pub name: String,
    /// The samples that are looked at along x, y, z, of all in the scan; or why none.
    pub part: Result<[Range<usize>; 3], Unneeded>,
}

/// Why a surface is not made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unneeded {
    /// Nobody sees it.
    #[error("its opacity is 0")]
    Transparent,
    /// Nothing of it is left.
    #[error("planes cut it away")]
    CutAway,
    /// No picture shows it.
    #[error("it is beside the picture")]
    Beside,
    /// It is there already.
    #[error("it is a mesh")]
    Mesh,
}

/// What pictures show from each of several viewpoints: for one that shows all, no planes.
pub(super) type Views = Vec<Vec<HalfSpace>>;

/// A box in index space: from where to where it reaches along x, y, z.
type Ends = [[f64; 2]; 3];

/// Samples that are looked at beyond a plane, so that vertices and normals are those of the whole: one for the cell
/// that the plane goes through, and three for placement and normals.
const MARGIN: f64 = 4.0;

impl Scene {
    /// What the surfaces of a scan need for pictures of a size from some viewpoints. Reads the scan once.
    ///
    /// # Errors
    ///
    /// If a plane names a surface that is not there, if a camera sees nothing, or if the job is cancelled.
    pub fn needs(
        &self,
        scan: &Scan,
        camera: (&[Viewpoint], Size),
        job: &Job,
    ) -> Result<Needs, SceneError> {
        self.check_names()?;
        let views = self.views(scan, camera, self.raster.needs_surroundings())?;
        let need = |look: &SurfaceLook| SurfaceNeed {
            name: look.name.clone(),
            part: self.part_of(look, scan, &views),
        };
        let surfaces: Vec<_> = self.surfaces.iter().map(need).collect();
        let samples = |part: &[Range<usize>; 3]| -> u64 {
            part.iter().map(|range| range.len() as u64).product()
        };
        let parts: Vec<_> = surfaces.iter().filter_map(|need| need.part.as_ref().ok()).collect();
        // The box around all parts is what is looked at.
        let around = parts.iter().copied().cloned().reduce(|a, b| {
            std::array::from_fn(|k| a[k].start.min(b[k].start)..a[k].end.max(b[k].end))
        });
        let all = samples(&scan.part());
        let needed = around.as_ref().map_or(0, samples);
        let (bricks, active) = for_any!(scan.volume(), volume => {
            self.bricks(&surfaces, &scan.view(volume), scan, job)?
        });
        let (bricks_skipped, samples_skipped) = (bricks - active, all - needed);
        Ok(Needs { surfaces, bricks, bricks_skipped, samples: all, samples_skipped })
    }

    /// What pictures of the values of a scan need. Reads the scan once.
    ///
    /// # Errors
    ///
    /// If a plane names a surface that is not there, if nothing says what values look like, if a camera sees nothing, or
    /// if the job is cancelled.
    pub fn needs_of_rays(
        &self,
        scan: &Scan,
        camera: (&[Viewpoint], Size),
        job: &Job,
    ) -> Result<Needs, SceneError> {
        self.check_names()?;
        let views = self.views(scan, camera, self.raycast.scatter.is_some())?;
        let model = self.model.as_ref().ok_or(SceneError::NoTransfer)?;
        let corner = scan.part().map(|range| range.start);
        let samples = scan.part().iter().map(|range| range.len() as u64).product();
        for_any!(scan.volume(), volume => {
            let view = scan.view(volume);
            let (bricks, scaling) = (scan.part_bricks(&view, job)?, view.scaling());
            let grid = bricks.grid();
            let is_seen = |brick: &[usize; 3]| {
                let range = bricks.extents()[grid.number(*brick)].range();
                let shows = range.is_some_and(|ends| {
                    let [a, b] = ends.map(|end| scaling.value(end.to_f64()));
                    model.shows_any([a.min(b), a.max(b)])
                });
                let ends: Ends = std::array::from_fn(|k| {
                    let along = grid.samples(k, brick[k]);
                    [*along.start(), *along.end()].map(|end| (end + corner[k]) as f64)
                });
                let is_in = |half: &HalfSpace| kept(half, scan, ends).is_some();
                let is_shown = |view: &Vec<HalfSpace>| view.iter().all(is_in);
                shows && self.cuts_of_all().all(|half| is_in(&half)) && views.iter().any(is_shown)
            };
            let seen = all_of(grid.counts()).filter(is_seen).count() as u64;
            let bricks = all_of(grid.counts()).count() as u64;
            let bricks_skipped = bricks - seen;
            Ok(Needs { bricks, bricks_skipped, samples, ..Needs::default() })
        })
    }

    /// How many bricks there are, and how many of them hold surfaces, or where the volume ends what is inside of one.
    fn bricks<T: Sample>(
        &self,
        needs: &[SurfaceNeed],
        view: &View<'_, T>,
        scan: &Scan,
        job: &Job,
    ) -> Result<(u64, u64), SceneError> {
        let bricks = scan.part_bricks(view, job)?;
        let (grid, corner) = (bricks.grid(), scan.part().map(|range| range.start));
        let thresholds = self.surfaces.iter().zip(needs).filter_map(|(look, need)| {
            let part = need.part.as_ref().ok()?;
            Some((view.scaling().threshold::<T>(look.iso?), part))
        });
        let thresholds: Vec<_> = thresholds.collect();
        let is_active = |brick: &[usize; 3]| {
            thresholds.iter().any(|(threshold, part)| {
                let is_within = |k: usize| {
                    let samples = grid.samples(k, brick[k]);
                    let (first, last) = (samples.start() + corner[k], samples.end() + corner[k]);
                    first < part[k].end && last >= part[k].start
                };
                let is_last = |k: usize| brick[k] == 0 || brick[k] + 1 == grid.counts()[k];
                let holds = match bricks.extents()[grid.number(*brick)].side(*threshold) {
                    Side::Both => true,
                    Side::Inside => (0..3).any(is_last),
                    Side::Outside => false,
                };
                holds && (0..3).all(is_within)
            })
        };
        let count = all_of(grid.counts()).count() as u64;
        Ok((count, all_of(grid.counts()).filter(is_active).count() as u64))
    }

    /// What pictures of a size show from viewpoints; all, if they depend on what is beside them.
    pub(super) fn views(
        &self,
        scan: &Scan,
        (viewpoints, size): (&[Viewpoint], Size),
        needs_surroundings: bool,
    ) -> Result<Views, SceneError> {
        let aspect = f64::from(size.width.get()) / f64::from(size.height.get());
        let view = |viewpoint: &Viewpoint| match viewpoint {
            Viewpoint::At { .. } if !needs_surroundings => {
                Ok(viewpoint.camera(scan.around(), size)?.frustum(aspect))
            }
            _ => Ok(vec![]),
        };
        viewpoints.iter().map(view).collect()
    }

    /// The samples that a surface needs.
    pub(super) fn part_of(
        &self,
        look: &SurfaceLook,
        scan: &Scan,
        views: &Views,
    ) -> Result<[Range<usize>; 3], Unneeded> {
        if look.iso.is_none() {
            return Err(Unneeded::Mesh);
        }
        if look.opacity <= 0.0 {
            return Err(Unneeded::Transparent);
        }
        let part = scan.part();
        let all = part.each_ref().map(|range| [range.start as f64, range.end as f64 - 1.0]);
        let within = |ends: Ends, half: &HalfSpace| kept(half, scan, ends);
        let left = self.clips_of(look).map(|clip| &clip.half).try_fold(all, within);
        let left = left.ok_or(Unneeded::CutAway)?;
        let shown = views.iter().filter_map(|view| view.iter().try_fold(left, within));
        let around = |a: Ends, b: Ends| {
            std::array::from_fn(|k| [a[k][0].min(b[k][0]), a[k][1].max(b[k][1])])
        };
        let ends = shown.reduce(around).ok_or(Unneeded::Beside)?;
        Ok(std::array::from_fn(|k| {
            let Range { start, end } = part[k].clone();
            let first = (ends[k][0] - MARGIN).floor().max(start as f64) as usize;
            let last = (ends[k][1] + MARGIN).ceil().min(end as f64 - 1.0) as usize;
            first..last + 1
        }))
    }
}

/// All bricks.
fn all_of([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// The box, in index space, around what a plane keeps of a box.
fn kept(half: &HalfSpace, scan: &Scan, ends: Ends) -> Option<Ends> {
    let affine = &scan.frame().index_to_world;
    let normal = affine.columns().map(|column| dot(half.normal(), column));
    let offset = -half.beyond(affine.origin());
    // The least that an axis can bring.
    let least =
        |k: usize| ends[k].map(|end| normal[k] * end).into_iter().fold(f64::INFINITY, f64::min);
    let sum: f64 = (0..3).map(least).sum();
    if sum > offset {
        return None;
    }
    Some(std::array::from_fn(|k| {
        let [low, high] = ends[k];
        let end = (offset - (sum - least(k))) / normal[k];
        match normal[k] {
            n if n > 0.0 => [low, high.min(end.max(low))],
            n if n < 0.0 => [low.max(end.min(high)), high],
            _ => [low, high],
        }
    }))
}
