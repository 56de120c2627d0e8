//! What a scene needs, and what it does not.

use super::{Scene, SceneError, SurfaceLook, Viewpoint};
use crate::pipeline::{Lattice, Scan, ScanFile, count};
use isokit_geom::{HalfSpace, vector::dot};
use isokit_job::Job;
use isokit_lanes::Side;
use isokit_render::Size;
use isokit_volume::{Bricks, Sample, Scaling, for_any, for_dtype};
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
    /// No picture shows it: known only once [the others are made](Scene::meshes_in_sight).
    #[error("it is behind opaque surfaces")]
    Hidden,
}

/// What pictures show from each of several viewpoints: for one that shows all, no planes.
pub(super) type Views = Vec<Vec<HalfSpace>>;

/// A box in index space: from where to where it reaches along x, y, z.
type Ends = [[f64; 2]; 3];

/// Samples that are looked at beyond a plane, so that vertices and normals are those of the whole: one for the cell
/// that the plane goes through, and three for placement and normals.
const MARGIN: f64 = 4.0;

impl Scene {
    /// What the surfaces of a scan need for pictures of a size from some viewpoints. Looks at each sample once.
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
        let needs = self.needs_of_lattice(scan.lattice(), camera)?;
        for_any!(scan.volume(), volume => {
            let view = scan.view(volume);
            let bricks = scan.part_bricks(&view, job)?;
            Ok(self.with_bricks(needs, (bricks, view.scaling()), scan.lattice()))
        })
    }

    /// The same of a scan of which no sample was read. Of bricks it is known only if an [index](Scan::index) is kept beside
    /// the file: else there are 0.
    ///
    /// # Errors
    ///
    /// As [`needs`](Self::needs).
    pub fn needs_of_file(
        &self,
        file: &ScanFile,
        camera: (&[Viewpoint], Size),
    ) -> Result<Needs, SceneError> {
        let needs = self.needs_of_lattice(file.lattice(), camera)?;
        for_dtype!(file.dtype(), T => Ok(match file.bricks::<T>() {
            Some(bricks) => self.with_bricks(needs, (&bricks, file.scaling()), file.lattice()),
            None => needs,
        }))
    }

    /// The samples that pictures of surfaces depend on, along x, y, z: of none nothing is seen.
    ///
    /// A scan of which [only those were read](ScanFile::read_wanted) has the same pictures, byte for byte.
    ///
    /// # Errors
    ///
    /// As [`needs`](Self::needs).
    pub fn samples_of_surfaces(
        &self,
        lattice: &Lattice,
        camera: (&[Viewpoint], Size),
    ) -> Result<Option<[Range<usize>; 3]>, SceneError> {
        let needs = self.needs_of_lattice(lattice, camera)?;
        Ok(around(needs.surfaces.iter().filter_map(|need| need.part.as_ref().ok())))
    }

    /// What surfaces need, but for bricks.
    fn needs_of_lattice(
        &self,
        lattice: &Lattice,
        camera: (&[Viewpoint], Size),
    ) -> Result<Needs, SceneError> {
        self.check_names()?;
        let views = self.views(lattice, camera, self.raster.needs_surroundings())?;
        let need = |look: &SurfaceLook| SurfaceNeed {
            name: look.name.clone(),
            part: self.part_of(look, lattice, &views),
        };
        let surfaces: Vec<_> = self.surfaces.iter().map(need).collect();
        // The box around all parts is what is looked at.
        let needed = around(surfaces.iter().filter_map(|need| need.part.as_ref().ok()));
        let samples = lattice.count();
        let samples_skipped = samples - needed.as_ref().map_or(0, count);
        Ok(Needs { surfaces, samples, samples_skipped, ..Needs::default() })
    }

    /// What pictures of the values of a scan need. Looks at each sample once.
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
        let needs = self.needs_of_values(scan.lattice(), camera)?;
        for_any!(scan.volume(), volume => {
            let view = scan.view(volume);
            let bricks = (scan.part_bricks(&view, job)?, view.scaling());
            self.with_seen_bricks(needs, bricks, (scan.lattice(), camera))
        })
    }

    /// The same of a scan of which no sample was read: as [`needs_of_file`](Self::needs_of_file).
    ///
    /// # Errors
    ///
    /// As [`needs_of_rays`](Self::needs_of_rays).
    pub fn needs_of_rays_of_file(
        &self,
        file: &ScanFile,
        camera: (&[Viewpoint], Size),
    ) -> Result<Needs, SceneError> {
        let needs = self.needs_of_values(file.lattice(), camera)?;
        for_dtype!(file.dtype(), T => match file.bricks::<T>() {
            Some(bricks) => {
                let bricks = (&bricks, file.scaling());
                self.with_seen_bricks(needs, bricks, (file.lattice(), camera))
            }
            None => Ok(needs),
        })
    }

    /// The samples that pictures of values depend on: as [`samples_of_surfaces`](Self::samples_of_surfaces), for rays and
    /// splats.
    ///
    /// # Errors
    ///
    /// As [`needs_of_rays`](Self::needs_of_rays).
    pub fn samples_of_rays(
        &self,
        lattice: &Lattice,
        camera: (&[Viewpoint], Size),
    ) -> Result<Option<[Range<usize>; 3]>, SceneError> {
        self.check_names()?;
        let views = self.views_of_rays(lattice, camera)?;
        let cuts: Vec<_> = self.cuts_of_all().collect();
        Ok(left_of(lattice, cuts.iter(), &views).ok())
    }

    fn needs_of_values(
        &self,
        lattice: &Lattice,
        camera: (&[Viewpoint], Size),
    ) -> Result<Needs, SceneError> {
        let samples = lattice.count();
        let needed = self.samples_of_rays(lattice, camera)?.as_ref().map_or(0, count);
        Ok(Needs { samples, samples_skipped: samples - needed, ..Needs::default() })
    }

    /// The same with bricks in which nothing can be seen.
    fn with_seen_bricks<T: Sample>(
        &self,
        needs: Needs,
        (bricks, scaling): (&Bricks<T>, Scaling),
        (lattice, camera): (&Lattice, (&[Viewpoint], Size)),
    ) -> Result<Needs, SceneError> {
        let views = self.views_of_rays(lattice, camera)?;
        let model = self.model.as_ref().ok_or(SceneError::NoTransfer)?;
        let (grid, corner) = (bricks.grid(), lattice.part().map(|range| range.start));
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
            let is_in = |half: &HalfSpace| kept(half, lattice, ends).is_some();
            let is_shown = |view: &Vec<HalfSpace>| view.iter().all(is_in);
            shows && self.cuts_of_all().all(|half| is_in(&half)) && views.iter().any(is_shown)
        };
        let bricks = all_of(grid.counts()).count() as u64;
        let bricks_skipped = bricks - all_of(grid.counts()).filter(is_seen).count() as u64;
        Ok(Needs { bricks, bricks_skipped, ..needs })
    }

    /// The same with bricks that hold no surface, and of which the volume does not end within one.
    fn with_bricks<T: Sample>(
        &self,
        needs: Needs,
        (bricks, scaling): (&Bricks<T>, Scaling),
        lattice: &Lattice,
    ) -> Needs {
        let (grid, corner) = (bricks.grid(), lattice.part().map(|range| range.start));
        let thresholds = self.surfaces.iter().zip(&needs.surfaces).filter_map(|(look, need)| {
            let part = need.part.as_ref().ok()?;
            Some((scaling.threshold::<T>(look.iso?), part))
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
        let bricks = all_of(grid.counts()).count() as u64;
        let bricks_skipped = bricks - all_of(grid.counts()).filter(is_active).count() as u64;
        Needs { bricks, bricks_skipped, ..needs }
    }

    /// What pictures of values show: all, if light comes from beside them.
    fn views_of_rays(
        &self,
        lattice: &Lattice,
        camera: (&[Viewpoint], Size),
    ) -> Result<Views, SceneError> {
        self.views(lattice, camera, self.raycast.scatter.is_some())
    }

    /// What pictures of a size show from viewpoints; all, if they depend on what is beside them.
    pub(super) fn views(
        &self,
        lattice: &Lattice,
        (viewpoints, size): (&[Viewpoint], Size),
        needs_surroundings: bool,
    ) -> Result<Views, SceneError> {
        let aspect = f64::from(size.width.get()) / f64::from(size.height.get());
        let view = |viewpoint: &Viewpoint| match viewpoint {
            Viewpoint::At { .. } if !needs_surroundings => {
                Ok(viewpoint.camera(lattice.around(), size)?.frustum(aspect))
            }
            _ => Ok(vec![]),
        };
        viewpoints.iter().map(view).collect()
    }

    /// The samples that a surface needs, of the whole lattice.
    pub(super) fn part_of(
        &self,
        look: &SurfaceLook,
        lattice: &Lattice,
        views: &Views,
    ) -> Result<[Range<usize>; 3], Unneeded> {
        if look.iso.is_none() {
            return Err(Unneeded::Mesh);
        }
        if look.opacity <= 0.0 {
            return Err(Unneeded::Transparent);
        }
        left_of(lattice, self.clips_of(look).map(|clip| &clip.half), views)
    }
}

/// The samples of a part that planes leave and pictures show, and those around them.
fn left_of<'a>(
    lattice: &Lattice,
    mut cuts: impl Iterator<Item = &'a HalfSpace>,
    views: &Views,
) -> Result<[Range<usize>; 3], Unneeded> {
    let part = lattice.part();
    let all = part.each_ref().map(|range| [range.start as f64, range.end as f64 - 1.0]);
    let within = |ends: Ends, half: &HalfSpace| kept(half, lattice, ends);
    let left = cuts.try_fold(all, within).ok_or(Unneeded::CutAway)?;
    let shown = views.iter().filter_map(|view| view.iter().try_fold(left, within));
    let both =
        |a: Ends, b: Ends| std::array::from_fn(|k| [a[k][0].min(b[k][0]), a[k][1].max(b[k][1])]);
    let ends = shown.reduce(both).ok_or(Unneeded::Beside)?;
    Ok(std::array::from_fn(|k| {
        let Range { start, end } = part[k].clone();
        let first = (ends[k][0] - MARGIN).floor().max(start as f64) as usize;
        let last = (ends[k][1] + MARGIN).ceil().min(end as f64 - 1.0) as usize;
        first..last + 1
    }))
}

/// The box around boxes of samples.
fn around<'a>(parts: impl Iterator<Item = &'a [Range<usize>; 3]>) -> Option<[Range<usize>; 3]> {
    parts
        .cloned()
        .reduce(|a, b| std::array::from_fn(|k| a[k].start.min(b[k].start)..a[k].end.max(b[k].end)))
}

/// All bricks.
fn all_of([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// The box, in index space, around what a plane keeps of a box.
fn kept(half: &HalfSpace, lattice: &Lattice, ends: Ends) -> Option<Ends> {
    let affine = &lattice.frame().index_to_world;
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
