//! What the simple boxes of an octree add up to.

use super::{
    Cell, Patch, Region,
    octree::{Node, Octree},
    pieces::Pieces,
};
use isokit::geom::cube::Edge;
use std::collections::BTreeMap;

/// The boxes around a stratum, by the sides of its planes on which they lie; none outside the cell, and none
/// where two sides would differ on an axis along which the stratum extends.
type Around = [Option<usize>; 8];

/// What a box holds, at most one of each; the three hang together with their like in other boxes.
const DISC: usize = 0;
const INSIDE: usize = 1;
const OUTSIDE: usize = 2;

impl Octree {
    /// Patches and regions.
    pub(super) fn cell(&self) -> Cell {
        let mut pieces = Pieces::new(3 * self.boxes.len());
        let mut eulers = vec![];
        self.strata(&mut |planes, around| {
            let (deepest, corners) = self.stratum(planes, around);
            let inside =
                corners.iter().filter(|&&k| self.boxes[deepest].code >> k & 1 == 1).count();
            let holds = [(INSIDE, inside > 0), (OUTSIDE, inside < corners.len())];
            let mixed = holds.iter().all(|(_, held)| *held);
            if mixed {
                // A disc, an arc, a point.
                eulers.push((deepest, if planes.count_ones() == 1 { -1 } else { 1 }));
            }
            for (kind, held) in holds.into_iter().chain([(DISC, mixed)]) {
                for beside in around.iter().flatten().filter(|_| held) {
                    pieces.join(3 * deepest + kind, 3 * beside + kind);
                }
            }
        });

        let mut patches: BTreeMap<usize, Patch> = BTreeMap::new();
        for (leaf, euler) in eulers {
            let patch = patches.entry(pieces.root(3 * leaf + DISC));
            patch.or_insert(Patch { euler: 0, edges: vec![] }).euler += euler;
        }
        for edge in Edge::all() {
            if let Some(leaf) = self.leaf_that_cuts(edge) {
                let patch = patches.get_mut(&pieces.root(3 * leaf + DISC));
                patch.expect("a disc is counted").edges.push(edge.index());
            }
        }
        let mut regions: BTreeMap<usize, Region> = BTreeMap::new();
        for corner in 0..8 {
            let inside = self.boxes[Self::ROOT].code >> corner & 1 == 1;
            let leaf = self.descend(corner);
            let root = pieces.root(3 * leaf + if inside { INSIDE } else { OUTSIDE });
            let region = regions.entry(root).or_insert(Region { inside, corners: vec![] });
            region.corners.push(corner);
        }
        let mut cell = Cell {
            patches: patches.into_values().collect(),
            regions: regions.into_values().collect(),
        };
        cell.patches.sort_by_key(|patch| patch.edges.first().copied());
        cell.regions.sort_by_key(|region| region.corners.first().copied());
        cell
    }

    /// The deepest box around a stratum, of which the stratum is a part, and the corners that they share.
    fn stratum(&self, planes: usize, around: &Around) -> (usize, Vec<usize>) {
        let boxes = (0..8).filter_map(|sides| Some((sides, around[sides]?)));
        let (sides, deepest) =
            boxes.max_by_key(|&(_, leaf)| self.boxes[leaf].depth).expect("it is in the cell");
        // A box on the low side of a plane touches it with its high corners.
        let corners = (0..8).filter(|corner| corner & planes == planes & !sides);
        (deepest, corners.collect())
    }

    /// Visits every box, face and edge of the subdivision: the axes across which it is flat, as bits, and the
    /// boxes around it.
    fn strata(&self, visit: &mut dyn FnMut(usize, &Around)) {
        for planes in 0..7 {
            for sides in subsets(planes) {
                let mut around = [None; 8];
                around[sides] = Some(Self::ROOT);
                self.walk(planes, around, visit);
            }
        }
    }

    fn walk(&self, planes: usize, around: Around, visit: &mut dyn FnMut(usize, &Around)) {
        let parts = |leaf: usize| self.boxes[leaf].parts;
        if around.iter().flatten().all(|&leaf| parts(leaf).is_none()) {
            return visit(planes, &around);
        }
        // Along an axis a part is the low half, the high half, or the plane in the middle.
        for new in subsets(!planes & 7).filter(|new| planes | new != 7) {
            for high in subsets(!(planes | new) & 7) {
                let mut finer = [None; 8];
                for sides in subsets(planes | new) {
                    // Whoever is on the low side of an old plane touches it with the high half.
                    let part = (planes & !sides) | (new & sides) | high;
                    let coarse = around[sides & planes];
                    finer[sides] = coarse.map(|leaf| parts(leaf).map_or(leaf, |all| all[part]));
                }
                self.walk(planes | new, finer, visit);
            }
        }
    }

    /// The box in which this cell edge is cut, if it is.
    fn leaf_that_cuts(&self, edge: Edge) -> Option<usize> {
        let ends = edge.ends().map(|end| end.index());
        let mut halves = vec![Self::ROOT];
        while let Some(half) = halves.pop() {
            let Node { code, parts, .. } = &self.boxes[half];
            match parts {
                Some(parts) => halves.extend(ends.map(|end| parts[end])),
                None if (code >> ends[0] ^ code >> ends[1]) & 1 == 1 => return Some(half),
                None => {}
            }
        }
        None
    }

    /// The box at this corner of the cell.
    fn descend(&self, corner: usize) -> usize {
        let mut leaf = Self::ROOT;
        while let Some(parts) = self.boxes[leaf].parts {
            leaf = parts[corner];
        }
        leaf
    }
}

/// All sets of bits within a set.
fn subsets(of: usize) -> impl Iterator<Item = usize> {
    (0..8).filter(move |set| set & !of == 0)
}
