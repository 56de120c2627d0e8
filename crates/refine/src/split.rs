//! Which edges get a new vertex, where it lies, and what becomes of the triangles.
//!
//! A new vertex belongs to its edge, so the triangles on both sides have it, and no crack opens. A triangle
//! is cut by as many of its sides as were chosen: into four, three or two, or it stays. So the mesh is
//! conforming whichever edges are chosen, and any of them may be given up again.

use crate::{
    RefineError,
    edges::Edges,
    ground::Ground,
    settle::{Rules, settle},
};
use isokit_geom::vector::{Vector, dot, normal, sub};
use isokit_job::{CHUNK, Cancelled, Job};
use isokit_lanes::exactly;
use isokit_mesh::{Precision, TriMesh};
use rayon::prelude::*;

/// What becomes of an edge: it stays whole.
pub(crate) const WHOLE: u8 = 0;
/// It is cut in its middle.
pub(crate) const HALVED: u8 = 1;
/// It is cut, and the new vertex lies on the surface.
pub(crate) const MOVED: u8 = 2;

/// A corner of a new triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Corner {
    Vertex(u32),
    /// The new vertex of this edge.
    Edge(u32),
}

impl Corner {
    /// The number of the vertex, where that of edge `n` has the number `numbers[n]`.
    pub(crate) fn number(self, numbers: &[u32]) -> u32 {
        match self {
            Self::Vertex(vertex) => vertex,
            Self::Edge(edge) => numbers[edge as usize],
        }
    }
}

/// Whether an edge is to be cut.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Cut {
    /// No.
    Not,
    /// In its middle.
    Middle,
    /// And the new vertex is to lie there, rounded as the mesh keeps it.
    At(Vector),
}

/// Which way the surface looks at a vertex, if that is known.
pub(crate) type Outward<'a> = &'a (dyn Fn(u32) -> Option<Vector> + Sync);

/// Edges of a mesh that are to be cut.
pub(crate) struct Split<'a> {
    mesh: &'a TriMesh,
    edges: &'a Edges,
    /// Which way new triangles are to look, each as its first old corner does; else as the triangle that was there.
    outward: Option<Outward<'a>>,
    /// What becomes of each edge.
    pub(crate) states: Vec<u8>,
    /// Where the surface is, for each edge that is to be cut there.
    moved: Vec<Vector>,
}

impl<'a> Split<'a> {
    /// Cuts the edges that are `chosen`, as far as no triangle becomes flat or turns over and no vertex gets to where
    /// another one is.
    pub(crate) fn new(
        (mesh, edges): (&'a TriMesh, &'a Edges),
        ground: &Ground<'_>,
        chosen: impl Fn(usize) -> bool + Sync,
        job: &Job,
    ) -> Result<Self, RefineError> {
        let cut = |edge: usize| match chosen(edge) {
            false => Cut::Not,
            true => on_surface(mesh, edges.ends[edge], ground).map_or(Cut::Middle, Cut::At),
        };
        Self::cut((mesh, edges), cut, None, ground, job)
    }

    /// Cuts edges as `cut` says of each, as far as no triangle becomes flat, or looks away from where the surface looks.
    pub(crate) fn cut(
        (mesh, edges): (&'a TriMesh, &'a Edges),
        cut: impl Fn(usize) -> Cut + Sync,
        outward: Option<Outward<'a>>,
        ground: &Ground<'_>,
        job: &Job,
    ) -> Result<Self, RefineError> {
        const WHAT: &str = "the new vertices of the surface";
        let count = edges.len() as u64;
        job.limits.probe(WHAT, Some(count), 2 * size_of::<(u8, Vector)>())?;
        job.progress.begin("refine", count);
        // Where few are cut, most of the memory is never written.
        let (mut states, mut moved) = (vec![WHOLE; edges.len()], vec![[0.0; 3]; edges.len()]);
        // Beside a crease a middle is no help: an edge is cut on it, or stays whole.
        let given = if outward.is_some() { HALVED } else { MOVED };
        let fill = |(n, (states, moved)): (usize, (&mut [u8], &mut [Vector]))| {
            job.check()?;
            exactly(|| {
                for (edge, (state, moved)) in (n * CHUNK..).zip(states.iter_mut().zip(moved)) {
                    match cut(edge) {
                        Cut::Not => {}
                        Cut::Middle => *state = HALVED,
                        Cut::At(place) => (*state, *moved) = (given, place),
                    }
                }
            });
            job.progress.advance(states.len() as u64);
            Ok::<(), Cancelled>(())
        };
        job.threads.run(|| {
            let chunks = states.par_chunks_mut(CHUNK).zip(moved.par_chunks_mut(CHUNK));
            chunks.enumerate().try_for_each(fill)
        })?;
        let split = Self { mesh, edges, outward, states: vec![], moved };
        let rules = Rules {
            parts: &edges.sides,
            is_bad: |t: usize, states: &[u8]| split.spoils(t, states, ground),
            count: edges.len() + mesh.positions.len(),
            place: |n: usize, states: &[u8]| match states.get(n) {
                Some(&WHOLE) => None,
                Some(_) => Some(ground.in_file(split.place(Corner::Edge(n as u32), states))),
                None => Some(ground.in_file(mesh.positions.get(n - states.len()))),
            },
        };
        settle(&mut states, &rules, job)?;
        Ok(Self { states, ..split })
    }

    /// Whether triangle `t` stays as it is. Where few edges are cut most do, and this is soon asked.
    #[inline]
    pub(crate) fn is_whole(&self, t: usize, states: &[u8]) -> bool {
        self.edges.sides[t].iter().all(|&side| states[side as usize] == WHOLE)
    }

    /// The triangles that triangle `t` becomes, in order, and how many.
    pub(crate) fn children(&self, t: usize, states: &[u8]) -> ([[Corner; 3]; 4], usize) {
        let (corner, sides) = (self.mesh.triangles[t], self.edges.sides[t]);
        let v = |k: usize| Corner::Vertex(corner[k % 3]);
        let m = |k: usize| Corner::Edge(sides[k % 3]);
        let is_cut = sides.map(|side| states[side as usize] != WHOLE);
        let whole = [v(0), v(1), v(2)];
        match is_cut.iter().filter(|&&is_cut| is_cut).count() {
            0 => ([whole; 4], 1),
            1 => {
                let k = is_cut.iter().position(|&is_cut| is_cut).unwrap_or(0);
                let halves = [[v(k), m(k), v(k + 2)], [m(k), v(k + 1), v(k + 2)]];
                ([halves[0], halves[1], whole, whole], 2)
            }
            2 => {
                // The corner opposite the whole side is cut off; the rest has four corners.
                let k = is_cut.iter().position(|&is_cut| !is_cut).unwrap_or(0);
                let (a, b, p) = (v(k), v(k + 1), v(k + 2));
                let (to_a, to_b) = (m(k + 2), m(k + 1));
                let length = |from: Corner, to: Corner| {
                    let along = sub(self.place(from, states), self.place(to, states));
                    dot(along, along)
                };
                let rest = match length(a, to_b) < length(to_a, b) {
                    true => [[to_a, a, to_b], [a, b, to_b]],
                    false => [[to_a, a, b], [to_a, b, to_b]],
                };
                ([[p, to_a, to_b], rest[0], rest[1], whole], 3)
            }
            _ => {
                let around = |k: usize| [v(k), m(k), m(k + 2)];
                ([around(0), around(1), around(2), [m(0), m(1), m(2)]], 4)
            }
        }
    }

    /// Where a corner lies, as its position is kept.
    pub(crate) fn place(&self, corner: Corner, states: &[u8]) -> Vector {
        match corner {
            Corner::Vertex(vertex) => self.mesh.positions.get(vertex as usize),
            Corner::Edge(edge) if states[edge as usize] == MOVED || self.is_along_creases() => {
                self.moved[edge as usize]
            }
            Corner::Edge(edge) => self.rounded(middle(self.mesh, self.edges.ends[edge as usize])),
        }
    }

    /// The place as the mesh keeps it.
    pub(crate) fn rounded(&self, place: Vector) -> Vector {
        rounded(place, self.mesh)
    }

    /// Whether the surface is known to look different ways on both sides of new vertices.
    pub(crate) fn is_along_creases(&self) -> bool {
        self.outward.is_some()
    }

    /// Whether a triangle that comes of triangle `t` is flat, or turned over: it looks away from where that looks. But a
    /// triangle may look along the surface, as thin ones do, and what comes of it better: if by the field all of that looks
    /// outward, none is.
    fn spoils(&self, t: usize, states: &[u8], ground: &Ground<'_>) -> bool {
        if self.is_whole(t, states) {
            return false;
        }
        let before = normal(self.mesh.corners(self.mesh.triangles[t]));
        let (children, count) = self.children(t, states);
        let places = |child: &[Corner; 3]| child.map(|corner| self.place(corner, states));
        let is_spoiled = children[..count].iter().any(|child| {
            let old = child.iter().find_map(|corner| match corner {
                Corner::Vertex(vertex) => self.outward?(*vertex),
                Corner::Edge(_) => None,
            });
            ground.is_spoiled(places(child), old.unwrap_or(before))
        });
        let look_outward = || ground.look_outward(before, children[..count].iter().map(places));
        // Along a crease the field does not tell which way a triangle looks.
        is_spoiled && (self.is_along_creases() || !look_outward())
    }
}

/// The middle of an edge.
pub(crate) fn middle(mesh: &TriMesh, [a, b]: [u32; 2]) -> Vector {
    let (a, b) = (mesh.positions.get(a as usize), mesh.positions.get(b as usize));
    std::array::from_fn(|k| a[k].midpoint(b[k]))
}

/// The place as a mesh keeps it.
pub(crate) fn rounded(place: Vector, mesh: &TriMesh) -> Vector {
    match mesh.positions.precision() {
        Precision::F32 => place.map(|c| f64::from(c as f32)),
        Precision::F64 => place,
    }
}

/// Where the surface is from the middle of an edge, no farther than half of its length.
fn on_surface(mesh: &TriMesh, ends: [u32; 2], ground: &Ground<'_>) -> Option<Vector> {
    let [a, b] = ends.map(|vertex| mesh.positions.get(vertex as usize));
    let [from, to] = [a, b].map(|place| ground.spot(place));
    let along = sub(b, a);
    let reach = 0.5 * dot(along, along).sqrt();
    if from.is_beyond || to.is_beyond {
        return None;
    }
    let (middle, held) = (middle(mesh, ends), from.held_with(&to));
    let place = ground.projected_beside_borders(middle, held, reach)?;
    Some(rounded(place, mesh))
}
