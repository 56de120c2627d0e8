//! The edges of a surface that passes by, and what hangs together by them.

use super::Gauge;
use crate::components::Pieces;
use rayon::prelude::*;

/// Edges so far.
#[derive(Debug, Default)]
pub(super) struct Edges {
    edges: u64,
    boundary: u64,
    nonmanifold: u64,
    inconsistent: u64,
    /// Parts of the surface that no triangle to come can touch.
    complete_parts: u64,
    /// Edges that triangles to come may share, by the parts, counted from 0, that they belong to.
    carried: Vec<Side>,
    carried_parts: u32,
    /// Used again for each piece.
    sides: Vec<Side>,
}

/// An edge as triangles of one part pass it.
#[derive(Clone, Copy, Debug)]
struct Side {
    /// The lesser vertex, then the greater.
    edge: u64,
    /// A triangle of the piece, or a part that was carried.
    part: u32,
    /// How often it is passed from the lesser vertex to the greater, and back.
    passed: [u16; 2],
}

impl Side {
    fn lesser(&self) -> u64 {
        self.edge >> 32
    }
}

impl Edges {
    /// Looks at the next triangles. Those to come name no vertex before `end`.
    pub(super) fn look(&mut self, triangles: &[[u32; 3]], end: u64) {
        let carried_parts = self.carried_parts;
        let pieces = Pieces::new(carried_parts + triangles.len() as u32);
        let mut sides = std::mem::take(&mut self.sides);
        sides.clear();
        sides.append(&mut self.carried);
        for (part, names) in (carried_parts..).zip(triangles) {
            for k in 0..3 {
                let (a, b) = (names[k], names[(k + 1) % 3]);
                let edge = u64::from(a.min(b)) << 32 | u64::from(a.max(b));
                sides.push(Side { edge, part, passed: if a < b { [1, 0] } else { [0, 1] } });
            }
        }
        sides.par_sort_unstable_by_key(|side| side.edge);
        for same in sides.chunk_by(|a, b| a.edge == b.edge) {
            same.windows(2).for_each(|pair| pieces.unite(pair[0].part, pair[1].part));
            // More than two are too many, however many they are.
            let passed = [0, 1].map(|way| {
                same.iter().fold(0, |sum: u16, side| sum.saturating_add(side.passed[way]))
            });
            if same[0].lesser() >= end {
                self.carried.push(Side { passed, ..same[0] });
            } else {
                self.count(passed);
            }
        }
        self.sides = sides;
        let (labels, count) = pieces.labels(|_| true);
        let mut carried = vec![u32::MAX; count];
        self.carried_parts = 0;
        for side in &mut self.carried {
            let number = &mut carried[labels[side.part as usize] as usize];
            if *number == u32::MAX {
                *number = self.carried_parts;
                self.carried_parts += 1;
            }
            side.part = *number;
        }
        self.complete_parts += count as u64 - u64::from(self.carried_parts);
    }

    /// Counts an edge all of whose triangles have come.
    fn count(&mut self, [there, back]: [u16; 2]) {
        let triangles = u32::from(there) + u32::from(back);
        self.edges += 1;
        self.boundary += u64::from(triangles == 1);
        self.nonmanifold += u64::from(triangles > 2);
        self.inconsistent += u64::from(there.abs_diff(back) > 1);
    }

    /// What is known of edges when no triangle is to come.
    pub(super) fn finish(mut self) -> Gauge {
        for side in std::mem::take(&mut self.carried) {
            self.count(side.passed);
        }
        Gauge {
            edges: self.edges,
            boundary_edges: self.boundary,
            nonmanifold_edges: self.nonmanifold,
            inconsistent_edges: self.inconsistent,
            components: self.complete_parts + u64::from(self.carried_parts),
            ..Gauge::default()
        }
    }
}
