//! What a surface is, found out while it passes by in pieces.
//!
//! A piece is looked at once and forgotten. What may still change is carried to the next: triangles that
//! name vertices to come, and edges that triangles to come may share, each with the part of the surface
//! that it belongs to. That takes as much memory as a slice makes, whatever the length of the surface.
//!
//! It asks that no triangle names a vertex of an earlier piece, as marching slice by slice gives them.

mod edges;
mod sinks;

pub use sinks::Gauged;

use crate::{Measure, TriMesh, chunks::Sum, is_degenerate};
use edges::Edges;
use isokit_geom::{
    Aabb,
    vector::{dot, length, normal, sub},
};
use isokit_job::CHUNK;
use rayon::prelude::*;

/// What is known of a surface that was never in memory as a whole. The same as
/// [`topology`](crate::topology) finds out, sums but for rounding.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gauge {
    /// Vertices.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// Edges, each counted once.
    pub edges: u64,
    /// Edges of one triangle only.
    pub boundary_edges: u64,
    /// Edges of more than two triangles.
    pub nonmanifold_edges: u64,
    /// Edges along which neighbours are wound against one another.
    pub inconsistent_edges: u64,
    /// Triangles without area.
    pub degenerate_triangles: u64,
    /// Parts that hang together by edges.
    pub components: u64,
    /// Area, volume and box.
    pub measure: Measure,
}

impl Gauge {
    /// Vertices − edges + triangles.
    pub fn euler(&self) -> i64 {
        self.vertices as i64 - self.edges as i64 + self.triangles as i64
    }
}

/// A triangle of which corners are missing yet.
type Open = ([u32; 3], [[f64; 3]; 3]);

/// What is known so far.
#[derive(Debug, Default)]
struct Passing {
    vertices: u64,
    triangles: u64,
    edges: Edges,
    bounds: Option<Aabb>,
    /// What volumes are measured from: the first vertex.
    from: Option<[f64; 3]>,
    sums: Sums,
    open: Vec<Open>,
}

/// Sums over triangles.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    area: Sum,
    volume: Sum,
    normal: [Sum; 3],
    degenerate: u64,
}

impl Sums {
    fn add(&mut self, corners: [[f64; 3]; 3], from: [f64; 3]) {
        let normal = normal(corners);
        self.area.add(length(normal) / 2.0);
        self.volume.add(dot(sub(corners[0], from), normal) / 6.0);
        (0..3).for_each(|k| self.normal[k].add(normal[k]));
        self.degenerate += u64::from(is_degenerate(corners));
    }

    fn join(&mut self, other: Self) {
        self.area.join(other.area);
        self.volume.join(other.volume);
        (0..3).for_each(|k| self.normal[k].join(other.normal[k]));
        self.degenerate += other.degenerate;
    }
}

impl Passing {
    /// Looks at the next piece.
    fn look(&mut self, piece: &TriMesh) {
        let first = self.vertices;
        let held = piece.positions.len();
        if held > 0 && self.from.is_none() {
            self.from = Some(piece.positions.get(0));
        }
        self.vertices += held as u64;
        self.triangles += piece.triangles.len() as u64;
        let boxes = (0..held).into_par_iter().step_by(CHUNK).map(|start| {
            let end = held.min(start + CHUNK);
            Aabb::around((start..end).map(|vertex| piece.positions.get(vertex)))
        });
        let boxes: Vec<Option<Aabb>> = boxes.collect();
        let boxes = self.bounds.into_iter().chain(boxes.into_iter().flatten());
        self.bounds = Aabb::around(boxes.flat_map(|bounds| [bounds.min, bounds.max]));
        let from = self.from.unwrap_or_default();
        let corner = |vertex: u32| {
            let place = u64::from(vertex).checked_sub(first)? as usize;
            (place < held).then(|| piece.positions.get(place))
        };
        for (names, mut corners) in std::mem::take(&mut self.open) {
            (0..3).for_each(|k| corners[k] = corner(names[k]).unwrap_or(corners[k]));
            self.place((names, corners), from);
        }
        let chunks = piece.triangles.par_chunks(CHUNK).map(|triangles| {
            let (mut sums, mut open) = (Sums::default(), vec![]);
            for &names in triangles {
                let corners = names.map(corner);
                match corners {
                    [Some(a), Some(b), Some(c)] => sums.add([a, b, c], from),
                    _ => open.push((names, corners.map(Option::unwrap_or_default))),
                }
            }
            (sums, open)
        });
        for (sums, open) in chunks.collect::<Vec<_>>() {
            self.sums.join(sums);
            self.open.extend(open);
        }
        self.edges.look(&piece.triangles, self.vertices);
    }

    /// Measures a triangle if its vertices have come, or keeps it.
    fn place(&mut self, open: Open, from: [f64; 3]) {
        match open.0.iter().all(|&vertex| u64::from(vertex) < self.vertices) {
            true => self.sums.add(open.1, from),
            false => self.open.push(open),
        }
    }

    /// What is known when no piece is to come.
    fn finish(self) -> Gauge {
        let Sums { area, volume, normal, degenerate } = self.sums;
        let edges = self.edges.finish();
        // As if measured from the middle of the box, which makes a difference for open surfaces.
        let from = self.from.unwrap_or_default();
        let middle = self
            .bounds
            .map_or(from, |bounds| std::array::from_fn(|k| bounds.min[k].midpoint(bounds.max[k])));
        let moved = dot(sub(middle, from), normal.map(Sum::total)) / 6.0;
        Gauge {
            vertices: self.vertices,
            triangles: self.triangles,
            degenerate_triangles: degenerate,
            measure: Measure {
                area: area.total(),
                volume: volume.total() - moved,
                bounds: self.bounds,
            },
            ..edges
        }
    }
}

#[cfg(test)]
mod tests;
