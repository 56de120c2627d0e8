//! Which surfaces lie wholly behind an opaque one, before they are made.
//!
//! Surfaces of one scan lie within each other: what is inside of a higher value is inside of a lower one. So the opaque
//! surface of the lowest value, which must be closed, is a wall before all of higher values, wherever it is more than a
//! cell away from them; no picture is needed to know that. In most scans there are cells in which it is not: at a thin
//! place, around a cavity, at the border. There the wall is drawn as the pictures draw it, and must be nearer than the whole
//! cell at all points that the cell reaches; and if it is not, than the triangles in the cell, of which little pieces are made
//! (`pieces.rs`). If so in all cells and from all viewpoints, the surface is hidden.
//!
//! A surface is hidden as a whole or not at all: what is extracted of a part of the scan is at places that are rounded
//! otherwise, and the picture might be another one. Of surfaces that are seen in part the rasteriser leaves out what is not.

mod pieces;

use super::{Scene, SceneError, Viewpoint, meshes::Part};
use crate::pipeline::Scan;
use isokit_geom::{Aabb, Affine, vector::Vector};
use isokit_job::{Job, Stopped};
use isokit_mesh::TriMesh;
use isokit_render::{
    Camera, Paint, Painted, Size, are_behind, boxes_in_sight, hides_within, kept_bounds,
};
use isokit_volume::{Crossed, bare_cells, for_any};

/// A surface with more cells than this near the wall is not looked at: it is sooner made.
const MOST: usize = 1 << 14;

/// Nor is one of which more than one cell in so many is near the wall: few of those are hidden, and to know it takes as long.
const SHARE: u64 = 16;

/// Except if that are no more cells than these.
const FEW: u64 = 512;

/// The greatest distance of a cap from the border of the samples, in edge lengths.
const CAP: f64 = 1.0 / 16.0;

/// An opaque surface, and those within it.
pub(super) struct Wall<'a> {
    scene: &'a Scene,
    scan: &'a Scan,
    parts: &'a [Option<Part>],
    part: &'a Part,
    /// Index space of the part to world space.
    affine: Affine,
    /// Which one it is.
    pub(super) surface: usize,
    /// Those of higher values.
    pub(super) within: Vec<usize>,
    /// How far its caps are from the border of the samples, in edge lengths; once it is made.
    pub(super) margin: f64,
}

impl<'a> Wall<'a> {
    /// The wall of a scene whose surfaces are made of these parts of a scan, if there is one, and something within it.
    pub(super) fn of(scene: &'a Scene, scan: &'a Scan, parts: &'a [Option<Part>]) -> Option<Self> {
        if scene.raster.needs_surroundings() {
            return None;
        }
        let iso = |n: usize| scene.surfaces[n].iso.filter(|_| parts[n].is_some());
        let known = (0..parts.len()).filter_map(|n| Some((n, iso(n)?)));
        let is_wall = |&(n, _): &(usize, f64)| {
            let look = &scene.surfaces[n];
            look.opacity >= 1.0 && scene.clips_of(look).next().is_none()
        };
        let lowest = known.clone().filter(is_wall).min_by(|a, b| a.1.total_cmp(&b.1));
        let (surface, lowest) = lowest?;
        let within: Vec<usize> = known.filter(|&(_, iso)| iso > lowest).map(|(n, _)| n).collect();
        let part = parts[surface].as_ref()?;
        let affine = scan.frame().starting_at(part.each_ref().map(|range| range.start)).ok()?;
        let affine = affine.index_to_world;
        let wall = Self { scene, scan, parts, part, affine, surface, within, margin: CAP };
        (!wall.within.is_empty()).then_some(wall)
    }

    /// Which of the surfaces within it are hidden in pictures from all viewpoints, when the others are made.
    pub(super) fn hidden(
        &self,
        meshes: &[TriMesh],
        (viewpoints, size): (&[Viewpoint], Size),
        job: &Job,
    ) -> Result<Vec<usize>, SceneError> {
        let mut hidden = vec![];
        for &n in &self.within {
            hidden.extend(self.bare(n, job)?.map(|cells| (n, cells)));
        }
        let Some(bounds) = kept_bounds(&meshes[self.surface], &[]) else { return Ok(vec![]) };
        let around = self.scan.around();
        let is_framed = |viewpoint: &Viewpoint| matches!(viewpoint, Viewpoint::Framed { .. });
        let frame = match viewpoints.iter().any(is_framed) {
            false => around.0,
            true => match self.scene.extent(meshes) {
                Some(bounds)
                    if hidden.len() == self.within.len() && self.are_in(&hidden, bounds) =>
                {
                    bounds
                }
                _ => return Ok(vec![]),
            },
        };
        for viewpoint in viewpoints {
            let seen = if is_framed(viewpoint) { frame } else { around.0 };
            let camera = viewpoint.camera((seen, around.1), size)?;
            // A cell less what rounding moves a vertex by.
            let gap = 0.75 * self.affine.least_stretch();
            if !hides_within(bounds.corners(), gap, (&camera, size)) {
                return Ok(vec![]);
            }
            let (mesh, paint) = (&meshes[self.surface], Paint::Plain([0.0; 3]));
            let wall = Painted { mesh, paint, opacity: 1.0, clips: &[] };
            let mut left = vec![];
            for (n, cells) in hidden {
                if self.is_hidden((n, &cells), &wall, (&camera, size), job)? {
                    left.push((n, cells));
                }
            }
            hidden = left;
        }
        // One that goes through no cell is not there.
        let hidden = hidden.into_iter().filter(|(_, cells)| cells.count > 0);
        Ok(hidden.map(|(n, _)| n).collect())
    }

    /// Whether a surface that the wall encloses is hidden near it too.
    fn is_hidden(
        &self,
        (n, cells): (usize, &Crossed),
        wall: &Painted<'_>,
        camera: (&Camera, Size),
        job: &Job,
    ) -> Result<bool, SceneError> {
        let smoothing = self.scene.raster.smoothing;
        let reach = |number: usize| self.reach(n, cells.bare[number]);
        let boxes = (reach, cells.bare.len(), pieces::MOST);
        let Some(seen) = boxes_in_sight(wall, boxes, camera, smoothing, job)? else {
            return Ok(false);
        };
        let near: Vec<_> = seen.into_iter().map(|number| cells.bare[number]).collect();
        let Some(triangles) = self.pieces(n, &near, job)? else { return Ok(false) };
        let triangles = (triangles.into_iter(), self.off());
        Ok(are_behind(wall, triangles, camera, smoothing, job)?)
    }

    /// The cells of a surface, in its part, and those not more than one away from the wall; `None` if these are too many.
    fn bare(&self, n: usize, job: &Job) -> Result<Option<Crossed>, Stopped> {
        let Some([outer, inner]) = self.isos(n) else { return Ok(None) };
        for_any!(self.scan.volume(), volume => {
            let view = self.scan.part_of(volume, self.part);
            let thresholds = [outer, inner].map(|iso| view.scaling().threshold(iso));
            let found = bare_cells(&view, thresholds, MOST, job)?;
            let is_worth_it =
                |cells: &Crossed| cells.bare.len() as u64 <= FEW.max(cells.count / SHARE);
            Ok(found.filter(is_worth_it))
        })
    }

    fn isos(&self, n: usize) -> Option<[f64; 2]> {
        Some([self.scene.surfaces[self.surface].iso?, self.scene.surfaces[n].iso?])
    }

    fn corners(&self, index: Aabb) -> [Vector; 8] {
        index.corners().map(|corner| self.affine.point(corner))
    }

    /// What vertices of a surface in a cell can reach.
    fn reach(&self, n: usize, cell: [usize; 3]) -> [Vector; 8] {
        let margin = if self.is_alike(n) { self.margin } else { CAP };
        // Rounding moves a vertex by less than that.
        self.corners(self.cell(cell, margin / 4.0, margin))
    }

    /// Whether a surface is made of the same samples as the wall, so that caps of both are at the same places.
    fn is_alike(&self, n: usize) -> bool {
        self.parts[n].as_ref() == Some(self.part)
    }

    /// A cell that is so much larger on all sides, and at the border so much more.
    fn cell(&self, cell: [usize; 3], larger: f64, at_border: f64) -> Aabb {
        let end = |is_border: bool| larger + if is_border { at_border } else { 0.0 };
        Aabb {
            min: std::array::from_fn(|k| cell[k] as f64 - end(cell[k] == 0)),
            max: std::array::from_fn(|k| {
                (cell[k] + 1) as f64 + end(cell[k] + 2 == self.part[k].len())
            }),
        }
    }

    /// Whether surfaces lie in a box that is around the wall: so that a picture that is framed by it is framed by all. The
    /// cells that are left out are within the wall itself; caps of the same samples are at places of the wall's caps.
    fn are_in(&self, surfaces: &[(usize, Crossed)], bounds: Aabb) -> bool {
        surfaces.iter().all(|(n, cells)| {
            let at_border = if self.is_alike(*n) { 0.0 } else { CAP };
            cells.bare.iter().all(|&cell| {
                let corners = self.corners(self.cell(cell, 0.0, at_border));
                corners.into_iter().all(|corner| bounds.with(corner) == bounds)
            })
        })
    }
}
