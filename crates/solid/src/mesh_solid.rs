//! What a mesh encloses, be it open, doubled or wound the wrong way in parts.

use crate::{
    bvh::Bvh,
    distance::{Near, Part, near},
    paint::Paint,
    repair::{Repaired, repaired},
    winding::{Rim, Search, Windings},
};
use isokit_geom::Aabb;
use isokit_job::{Job, Stopped};
use isokit_lanes::exactly;
use isokit_mesh::{Rgba, TriMesh};

/// Why a mesh encloses nothing that can be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolidError {
    /// There is no triangle.
    #[error("the mesh has no triangles")]
    Empty,
    /// More than can be numbered.
    #[error("the mesh has {count} triangles, at most {} can be", 1_u32 << 31)]
    TooMany {
        /// How many.
        count: usize,
    },
    /// A corner is no place.
    #[error("triangle {triangle}, vertex {vertex}: expected finite coordinates, found {place:?}")]
    NotFinite {
        /// Counted from 0.
        triangle: usize,
        /// Counted from 0.
        vertex: u32,
        /// What was found.
        place: [f64; 3],
    },
    /// A corner is no vertex.
    #[error("triangle {triangle} names vertex {vertex}, of {vertices}")]
    NoVertex {
        /// Counted from 0.
        triangle: usize,
        /// Counted from 0.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// Vertices and their colours do not go together.
    #[error("the mesh has {colors} colours for {vertices} vertices")]
    Colors {
        /// How many colours there are.
        colors: usize,
        /// How many vertices.
        vertices: usize,
    },
    /// It was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// When a point is inside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Inside {
    /// If the surface winds around it half a time or more, either way round: what is wound inside out is solid too.
    #[default]
    EitherWay,
    /// If the surface winds around it half a time or more, counter-clockwise seen from outside.
    Outward,
}

/// How a mesh is made ready.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SolidOptions {
    /// When a point is inside. Default: [`Inside::EitherWay`].
    pub inside: Inside,
    /// What is done about faces that are wound against their neighbours. Default: [`Winding::Mended`].
    pub winding: Winding,
}

/// What is done about faces that are wound against their neighbours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Winding {
    /// Across edges of two triangles, both are wound alike, as most of the area of the piece was.
    #[default]
    Mended,
    /// Nothing.
    AsItIs,
}

/// What is wrong with a mesh, and what was done about it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flaws {
    /// Edges at which the surface ends, as it counts: in a mesh that is closed there are none.
    pub open_edges: usize,
    /// Triangles that are in the same place as another, wound the same way; they count once.
    pub doubled: usize,
    /// Triangles that lie back to back with another; both are surface, and neither bounds a solid.
    pub back_to_back: usize,
    /// Triangles that were turned to be wound as their neighbours.
    pub turned: usize,
    /// Triangles without an area.
    pub flat: usize,
}

/// The solid that a mesh encloses: how far its surface is, and whether a point is inside.
#[derive(Clone, Debug)]
pub struct MeshSolid {
    bounds: Aabb,
    place: Place,
    bvh: Bvh,
    windings: Windings,
    rim: Option<Rim>,
    inside: Inside,
    flaws: Flaws,
    paint: Option<Paint>,
}

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// Where it is.
    pub point: [f64; 3],
    /// Which triangle of the mesh it is on; of several one.
    pub triangle: u32,
    /// How far it is.
    pub distance: f64,
    /// What of the triangle it is on.
    pub part: Part,
    /// How much of each corner of the triangle is in it: its barycentric coordinates, none below 0, which add up to 1.
    pub shares: [f64; 3],
    /// The triangle's normal, one long; none if it has no area.
    pub normal: Option<[f64; 3]>,
}

/// The space that is computed in: the middle of the mesh is 0, and no coordinate exceeds 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    middle: [f64; 3],
    /// A power of two, so that nothing is rounded by it.
    scale: f64,
}

impl Place {
    pub(crate) fn of(bounds: Aabb) -> Self {
        let Aabb { min: low, max: high } = bounds;
        let half = [0, 1, 2].map(|k| 0.5 * high[k] - 0.5 * low[k]);
        let reach = half.into_iter().fold(0.0, f64::max);
        let exponent = if reach > 0.0 { reach.log2().ceil() as i32 + 1 } else { 0 };
        let scale = 2.0_f64.powi(exponent.clamp(-1000, 1000));
        Self { middle: [0, 1, 2].map(|k| 0.5 * low[k] + 0.5 * high[k]), scale }
    }

    pub(crate) fn inward(&self, xyz: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| (xyz[k] - self.middle[k]) / self.scale)
    }

    /// World units in one unit of this space.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }
}

/// How wrong the triangles of a box may be if they are taken as one, step by step until it is clear whether a point is inside.
/// With the last there are no such boxes.
const LIMITS: [f64; 6] = [4e-3, 5e-4, 6e-5, 8e-6, 1e-6, 0.0];

impl MeshSolid {
    /// The solid that a mesh encloses. If vertices have colours, its surface has them too.
    ///
    /// # Errors
    ///
    /// If it has no triangles, or a triangle whose corners are no places, or not a colour for each vertex; if it is larger than
    /// the job allows, or the job is cancelled.
    pub fn new(mesh: &TriMesh, options: SolidOptions, job: &Job) -> Result<Self, SolidError> {
        let Repaired { triangles, weights, rim, flaws } =
            exactly(|| repaired(mesh, options.winding, job))?;
        job.check().map_err(Stopped::from)?;
        let mut bounds = Aabb { min: triangles[0][0], max: triangles[0][0] };
        triangles.as_flattened().iter().for_each(|&corner| bounds = bounds.with(corner));
        let place = Place::of(bounds);
        let inward = |corners: &[[f64; 3]; 3]| corners.map(|corner| place.inward(corner));
        let local: Vec<_> = triangles.iter().map(inward).collect();
        let edges: Vec<_> =
            rim.iter().map(|(ends, count)| (ends.map(|end| place.inward(end)), *count)).collect();
        let (bvh, windings, rim) = job.threads.run(|| {
            exactly(|| {
                let bvh = Bvh::new(&local);
                let weights = bvh.triangles().iter().map(|&t| weights[t as usize]).collect();
                let windings = Windings::new(&bvh, weights);
                (bvh, windings, Rim::new(&edges))
            })
        });
        let paint = Paint::of(mesh, bvh.triangles(), job)?;
        Ok(Self { bounds, place, bvh, windings, rim, inside: options.inside, flaws, paint })
    }

    /// What was found wrong with the mesh.
    pub fn flaws(&self) -> Flaws {
        self.flaws
    }

    /// The box around all triangles; vertices of none do not count.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// When a point is inside.
    pub fn inside(&self) -> Inside {
        self.inside
    }

    /// The nearest point of the surface; none of a point that is not finite.
    pub fn closest(&self, xyz: [f64; 3]) -> Option<Closest> {
        exactly(|| {
            let (number, found) = self.nearest(self.place.inward(xyz))?;
            let scale = self.place.scale();
            let facet = &self.bvh.facets()[number as usize];
            Some(Closest {
                point: [0, 1, 2].map(|k| xyz[k] - found.away[k] * scale),
                triangle: self.bvh.triangles()[number as usize],
                distance: found.squared.sqrt() * scale,
                part: found.part,
                shares: found.shares(),
                normal: facet.has_area.then_some(facet.normal),
            })
        })
    }

    /// The colour of the nearest point of the surface: those of the triangle's corners, mixed by
    /// [`shares`](Closest::shares), each of the four numbers on its own as it is kept, and rounded. None of a point that is
    /// not finite, or if vertices have no colours.
    pub fn color(&self, xyz: [f64; 3]) -> Option<Rgba> {
        let paint = self.paint.as_ref()?;
        exactly(|| {
            let (number, found) = self.nearest(self.place.inward(xyz))?;
            Some(paint.mixed(number, found.shares()))
        })
    }

    /// How often the surface winds around a point, within an allowance of the plain sum of solid angles; 0: the plain sum.
    /// NaN of a point that is not finite.
    pub fn winding(&self, xyz: [f64; 3], allowance: f64) -> f64 {
        exactly(|| self.windings.at(&self.bvh, self.place.inward(xyz), allowance).0)
    }

    /// Whether a point is inside. A point of the surface is.
    pub fn is_inside(&self, xyz: [f64; 3]) -> bool {
        self.signed_distance(xyz) >= 0.0
    }

    /// How far the surface is, positive inside; NaN of a point that is not finite.
    pub fn signed_distance(&self, xyz: [f64; 3]) -> f64 {
        exactly(|| {
            let point = self.place.inward(xyz);
            let Some((_, found)) = self.nearest(point) else { return f64::NAN };
            signed(found.squared.sqrt() * self.place.scale(), || self.is_in(point))
        })
    }

    pub(crate) fn place(&self) -> Place {
        self.place
    }

    pub(crate) fn paint(&self) -> Option<&Paint> {
        self.paint.as_ref()
    }

    pub(crate) fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    pub(crate) fn windings(&self) -> &Windings {
        &self.windings
    }

    /// Of a point where it is computed; the facet, the first of those that are as near, and how it is near.
    pub(crate) fn nearest(&self, point: [f64; 3]) -> Option<(u32, Near)> {
        if !point.iter().all(|c| c.is_finite()) {
            return None;
        }
        let mut best: Option<(u32, Near)> = None;
        self.bvh.visit(point, f64::INFINITY, |number| {
            let found = near(point, &self.bvh.facets()[number as usize]);
            let before = |known: u32, best: Near| {
                found.squared < best.squared || found.squared == best.squared && number < known
            };
            if best.is_none_or(|(known, best)| before(known, best)) {
                best = Some((number, found));
            }
            best.map_or(f64::INFINITY, |(_, best)| best.squared)
        });
        best
    }

    /// Whether a point is inside, whatever else is known of it.
    pub(crate) fn is_in(&self, point: [f64; 3]) -> bool {
        self.is_in_by(point, 0.0).unwrap_or_else(|| {
            let (winding, _) = self.windings.at(&self.bvh, point, 0.0);
            self.half(winding) >= 0.0
        })
    }

    /// Which of the two sides of a face are inside, above it and below, at a point on some facets that lie in one place: these,
    /// and how often they count together, as those do that are wound like the face.
    pub(crate) fn sides(&self, point: [f64; 3], facets: &[u32], count: f64) -> [bool; 2] {
        let mut search = Search::without(facets, &self.windings, &self.bvh, point);
        let mut halves = [0.0; 2];
        for limit in LIMITS {
            let (winding, error) = search.open(limit);
            // The surface is seen under half of all directions from either side, and counts from below.
            halves = [-0.5, 0.5].map(|half| self.half(winding + half * count));
            if halves.iter().all(|half| half.abs() > error) {
                break;
            }
        }
        halves.map(|half| half >= 0.0)
    }

    /// Whether a point is inside, and all others around it where the winding number differs by no more than `change`; none
    /// where they may not be alike.
    pub(crate) fn is_in_by(&self, point: [f64; 3], change: f64) -> Option<bool> {
        let mut search = Search::new(&self.windings, &self.bvh, point);
        for limit in LIMITS {
            let (winding, error) = search.open(limit);
            let half = self.half(winding);
            if half.abs() > error + change {
                return Some(half > 0.0);
            }
            if half.abs() + error <= change {
                return None;
            }
        }
        None
    }

    /// Positive inside.
    fn half(&self, winding: f64) -> f64 {
        match self.inside {
            Inside::EitherWay => winding.abs() - 0.5,
            Inside::Outward => winding - 0.5,
        }
    }

    /// No less than the change of the winding number along any way of a length in a ball that does not cross the surface.
    pub(crate) fn change(&self, centre: [f64; 3], radius: f64, way: f64) -> f64 {
        self.rim.as_ref().map_or(0.0, |rim| rim.steepness(centre, radius) * way)
    }

    /// Whether the surface ends nowhere.
    pub(crate) fn is_closed(&self) -> bool {
        self.rim.is_none()
    }
}

/// A distance with its sign: of 0 none.
pub(crate) fn signed(distance: f64, is_inside: impl FnOnce() -> bool) -> f64 {
    if distance == 0.0 || is_inside() { distance } else { -distance }
}

#[cfg(test)]
mod tests;
