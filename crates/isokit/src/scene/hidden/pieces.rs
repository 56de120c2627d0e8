//! Little pieces of a surface: what it is like in a few cells, without the rest of it.
//!
//! A piece is extracted from the samples around some cells, with as many more on all sides as vertices depend on. Its
//! vertices are those of the whole, but that places which are counted from another sample are rounded otherwise: the last
//! digit may differ. So pieces tell where the surface is, and are not drawn themselves.

use super::Wall;
use crate::{
    pipeline::Normals,
    scene::{Scene, SceneError, meshes::Part},
};
use isokit_geom::vector::Vector;
use isokit_job::Job;
use isokit_mesh::TriMesh;
use std::collections::{BTreeMap, BTreeSet};

/// Of more cells than that the surface is sooner made.
pub(super) const MOST: usize = 1 << 12;

/// Cells along a side of a piece.
const SIDE: usize = 16;

/// More pieces than that take longer than to make the surface.
const PIECES: usize = 64;

/// Samples beyond the cells: more than what vertices depend on.
const MARGIN: usize = 6;

/// How near to the side of a cell, in edge lengths, a triangle may be in either of two.
const NEAR: f64 = 0.1;

impl Wall<'_> {
    /// The triangles of a surface in some cells, and perhaps some beside them; `None` if they are not to be had for little.
    pub(super) fn pieces(
        &self,
        n: usize,
        cells: &[[usize; 3]],
        job: &Job,
    ) -> Result<Option<Vec<[Vector; 3]>>, SceneError> {
        let mut pieces = BTreeMap::<_, Vec<_>>::new();
        for &cell in cells {
            pieces.entry(cell.map(|i| i / SIDE)).or_default().push(cell);
        }
        if pieces.is_empty() {
            return Ok(Some(vec![]));
        }
        // Of other samples than the wall's a surface may keep its vertices elsewhere apart.
        let is_worth_it = self.is_alike(n) && pieces.len() <= PIECES;
        let Some(iso) = self.scene.surfaces[n].iso.filter(|_| is_worth_it) else {
            return Ok(None);
        };
        let options = Scene::surface_options().with_normals(Normals::None);
        let mut found = vec![];
        for cells in pieces.values() {
            let (part, mut made) = (self.part_around(cells), [TriMesh::default()]);
            let job = &job.unwatched();
            let made_so = self.scan.meshes_of_part(&part, &[iso], &options, &mut made, job)?;
            // Else vertices next to samples are elsewhere.
            if made_so.iter().any(|one| one.margin != self.margin) {
                return Ok(None);
            }
            let cells = cells.iter().copied().collect();
            let triangles = made[0].triangles.iter().map(|&triangle| made[0].corners(triangle));
            found.extend(triangles.filter(|&corners| self.is_in(corners, &cells)));
        }
        Ok(Some(found))
    }

    /// By less than that a vertex of a piece is not at the place of the whole's, in world units.
    pub(super) fn off(&self) -> f64 {
        // Numbers have the digits of f32 at least, and both are rounded to the nearest.
        self.scan.around().0.reach() * f64::from(4.0 * f32::EPSILON)
    }

    /// The samples around cells of the wall's part.
    fn part_around(&self, cells: &[[usize; 3]]) -> Part {
        std::array::from_fn(|k| {
            let along = cells.iter().map(|cell| cell[k] + self.part[k].start);
            let (least, most) = along.fold((usize::MAX, 0), |(a, b), i| (a.min(i), b.max(i)));
            let first = least.saturating_sub(MARGIN).max(self.part[k].start);
            first..(most + 2 + MARGIN).min(self.part[k].end)
        })
    }

    /// Whether a triangle is in one of some cells, or at the side of one.
    fn is_in(&self, corners: [Vector; 3], cells: &BTreeSet<[usize; 3]>) -> bool {
        let middle =
            std::array::from_fn(|k| corners.iter().map(|corner| corner[k]).sum::<f64>() / 3.0);
        let middle = self.affine.inverse_point(middle);
        let ends: [[usize; 2]; 3] = std::array::from_fn(|k| {
            // Caps are in the cells at the border.
            let last = self.part[k].len() - 2;
            [middle[k] - NEAR, middle[k] + NEAR].map(|i| (i.max(0.0) as usize).min(last))
        });
        let corner = |n: usize| std::array::from_fn(|k| ends[k][n >> k & 1]);
        (0..8).any(|n| cells.contains(&corner(n)))
    }
}
