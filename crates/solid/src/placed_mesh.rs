//! A mesh on a lattice: its signed distance as a field.
//!
//! The gradient of a distance is one long in the world and leads away from the nearest point. How it turns depends on where
//! that point is: above a face not at all, around an edge like a distance from a line, around a corner like one from a point
//! (the module `turning`).

mod turning;

use crate::{
    MeshSolid, VoxelOptions,
    distance::{Near, THIN},
    mesh_solid::signed,
    voxelize::{BLOCK, Lattice, farthest},
};
use isokit_field::{Interval, Jet, ScalarField, Slope};
use isokit_geom::{
    Aabb, Affine,
    vector::{dot, length},
};
use isokit_lanes::exactly;
use isokit_volume::Grid;
use std::ops::Range;
use turning::{bends, inward};

/// The signed distance of a mesh as a function of index space, in world units, positive inside.
/// [`MeshSolid::placed`] makes one.
///
/// Values at lattice points are those of [`voxelize`](crate::voxelize), which rounds them to f32: samples of the one and the
/// other are the same, and so are surfaces made of them.
///
/// The gradient leads away from the nearest point of the surface, or towards it from outside; of several one. On the surface,
/// where there is no such way, it is the normal of a face there that leads inside; of a sheet that bounds nothing the one
/// against which it is wound. It is 0 only at an edge or point that no face with an area touches. The Hessian is that of the
/// distance from the plane, the line or the point that is nearest; on the surface it is 0.
///
/// A point that is not finite has no value.
///
/// # Examples
///
/// ```
/// use isokit_field::{FieldSamples, ScalarField, sample};
/// use isokit_job::Job;
/// use isokit_mesh::{Positions, TriMesh};
/// use isokit_solid::{MeshSolid, SolidOptions, grid_around};
///
/// let corners = vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
/// let mesh = TriMesh {
///     positions: Positions::F64(corners),
///     triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
///     ..TriMesh::default()
/// };
/// let job = Job::default();
/// let solid = MeshSolid::new(&mesh, SolidOptions::default(), &job)?;
/// let grid = grid_around(solid.bounds(), [0.5; 3], 2, Default::default(), Default::default())?;
///
/// // The first sample is at −1, so this is the point (1, 1, 0.25).
/// let field = solid.placed(&grid);
/// let slope = field.slope([4.0, 4.0, 2.5]);
/// assert_eq!(slope.value, 0.25);
/// assert_eq!(slope.gradient, [0.0, 0.0, 0.5]);
/// let volume = sample::<f32>(FieldSamples::new(&field, grid.frame)?, &job)?;
/// assert_eq!(volume.view().dims(), field.dims());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PlacedMesh<'a> {
    solid: &'a MeshSolid,
    grid: Grid,
    /// By how much distances may be wrong where the surface has triangles so thin that they count as their edges, in world units.
    thin: f64,
}

/// By how much a value may be wrong, as a part of the coordinates that it is made of.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A point and what is nearest to it.
struct At {
    /// As the solid computes.
    point: [f64; 3],
    facet: u32,
    near: Near,
    /// In world units.
    value: f64,
}

impl MeshSolid {
    /// Its signed distance at the points of a lattice, and between them.
    pub fn placed(&self, grid: &Grid) -> PlacedMesh<'_> {
        let thin = self.bvh().facets().iter().filter(|facet| !facet.has_area);
        let longest = thin.fold(0.0_f64, |longest, facet| {
            let [first, third] = facet.edges;
            let across = [0, 1, 2].map(|k| third[k] - first[k]);
            [first, third, across].map(length).into_iter().fold(longest, f64::max)
        });
        // What lies between the edges of such a triangle is no farther from them than `THIN` of the longest, on both sides of it.
        PlacedMesh { solid: self, grid: *grid, thin: 2.0 * THIN * longest * self.place().scale() }
    }
}

impl PlacedMesh<'_> {
    fn point(&self, ijk: [f64; 3]) -> [f64; 3] {
        self.solid.place().inward(self.index_to_world().point(ijk))
    }

    fn at(&self, ijk: [f64; 3]) -> Option<At> {
        let point = self.point(ijk);
        let (facet, near) = self.solid.nearest(point)?;
        let value = signed(self.distance(&near), || self.solid.is_in(point));
        Some(At { point, facet, near, value })
    }

    fn distance(&self, near: &Near) -> f64 {
        near.squared.sqrt() * self.solid.place().scale()
    }

    /// A gradient in the world as one in index space.
    fn pulled(&self, gradient: [f64; 3]) -> [f64; 3] {
        self.index_to_world().columns().map(|column| dot(column, gradient))
    }

    /// By how much values of a box may be wrong.
    fn slack(&self, ijk: Aabb, value: f64, radius: f64) -> f64 {
        let affine = self.index_to_world();
        let (origin, columns) = (affine.origin(), affine.columns());
        let reach = |k: usize| {
            let along =
                |axis: usize| columns[axis][k].abs() * ijk.min[axis].abs().max(ijk.max[axis].abs());
            origin[k].abs() + along(0) + along(1) + along(2)
        };
        let world = reach(0) + reach(1) + reach(2) + self.solid.bounds().reach();
        ROUNDING * (world + value.abs() + radius) + self.thin
    }

    /// Whether a ball that the surface does not go through is inside; none if part of it may be and part not.
    fn ball_is_in(&self, centre: [f64; 3], radius: f64) -> Option<bool> {
        let radius = radius / self.solid.place().scale();
        let change = self.solid.change(centre, radius, radius);
        self.solid.is_in_by(centre, change + ROUNDING * (1.0 + change))
    }
}

impl ScalarField for PlacedMesh<'_> {
    fn dims(&self) -> [usize; 3] {
        self.grid.dims().map(|n| usize::try_from(n).unwrap_or(usize::MAX))
    }

    fn index_to_world(&self) -> Affine {
        self.grid.frame.index_to_world
    }

    fn value(&self, ijk: [f64; 3]) -> f64 {
        exactly(|| self.at(ijk).map_or(f64::NAN, |at| at.value))
    }

    fn is_known(&self, ijk: [f64; 3]) -> bool {
        let nearest = exactly(|| self.solid.nearest(self.point(ijk)));
        nearest.is_some_and(|(_, near)| self.distance(&near).is_finite())
    }

    fn slope(&self, ijk: [f64; 3]) -> Slope {
        exactly(|| match self.at(ijk) {
            Some(at) => Slope { value: at.value, gradient: self.pulled(inward(self.solid, &at)) },
            None => Slope { value: f64::NAN, gradient: [f64::NAN; 3] },
        })
    }

    fn jet(&self, ijk: [f64; 3]) -> Jet {
        exactly(|| {
            let Some(at) = self.at(ijk) else {
                return Jet {
                    value: f64::NAN,
                    gradient: [f64::NAN; 3],
                    hessian: [[f64::NAN; 3]; 3],
                };
            };
            let gradient = self.pulled(inward(self.solid, &at));
            let half = bends(self.solid, &at).map(|row| self.pulled(row));
            let columns = [0, 1, 2].map(|k| self.pulled(half.map(|row| row[k])));
            // To the bit symmetric, whatever rounding did.
            let entry = |i: usize, j: usize| 0.5 * (columns[i][j] + columns[j][i]);
            let hessian = [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)));
            Jet { value: at.value, gradient, hessian }
        })
    }

    /// From the value in the middle of the box, from which others differ by no more than half its longest diagonal in the world: a
    /// signed distance changes no faster than its place. That holds where the sign changes on the surface only, as it does of
    /// closed meshes, in whatever way they go through themselves. Of others the winding number may come past a half
    /// anywhere; so if the surface is farther than the half diagonal, it is asked how fast the winding number can change, and
    /// if that is not enough for another sign, the same bounds hold. Otherwise both signs are within.
    fn bounds(&self, ijk: Aabb) -> Interval {
        let middle = [0, 1, 2].map(|k| 0.5 * ijk.min[k] + 0.5 * ijk.max[k]);
        let half = [0, 1, 2].map(|k| 0.5 * ijk.max[k] - 0.5 * ijk.min[k]);
        exactly(|| {
            let Some(at) = self.at(middle) else { return Interval::EVERYTHING };
            let radius = farthest(&self.index_to_world(), half);
            let far = radius + self.slack(ijk, at.value, radius);
            let distance = at.value.abs();
            if !(distance + far).is_finite() {
                return Interval::EVERYTHING;
            }
            let is_one_side = self.solid.is_closed()
                || (distance > far && self.ball_is_in(at.point, far).is_some());
            match is_one_side {
                true => Interval { low: at.value - far, high: at.value + far },
                false => Interval { low: -distance - far, high: distance + far },
            }
        })
    }

    fn fill(&self, points: [Range<usize>; 3], values: &mut [f64]) {
        let [nx, ny, nz] = points.each_ref().map(ExactSizeIterator::len);
        assert_eq!(values.len(), nx * ny * nz, "one value for each point");
        let lattice = Lattice::new(self.solid, &self.grid, &VoxelOptions::default());
        let blocks = |axis: usize| (0..points[axis].len()).step_by(BLOCK);
        for (z, y) in blocks(2).flat_map(|z| blocks(1).map(move |y| (z, y))) {
            for x in blocks(0) {
                let low = [x, y, z];
                let size = [0, 1, 2].map(|k| BLOCK.min(points[k].len() - low[k]));
                let from = [0, 1, 2].map(|k| points[k].start + low[k]);
                let (found, _) = exactly(|| lattice.block(from, size));
                for (n, row) in found.chunks_exact(size[0]).enumerate() {
                    let first = ((z + n / size[1]) * ny + y + n % size[1]) * nx + x;
                    values[first..first + size[0]].copy_from_slice(row);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
