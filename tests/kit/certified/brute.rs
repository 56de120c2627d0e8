//! The topology of a cell as a fine lattice of points shows it: the oracle's own oracle.
//!
//! No boxes, no simple codes, no arcs. Points of like sign that are neighbours are in one region. Regions and
//! patches are the nodes and edges of a tree, since the cell is a ball: a patch is a pair of regions that
//! touch. It parts the cell in two, X and Y, each what points of certain regions span: points less edges plus
//! squares less cubes. The Euler characteristic of the patch is that of X plus that of Y less that of a ball.
//! Right only where the lattice is fine enough, which another one can make likely.

use super::{Cell, Patch, Region, pieces::Pieces};
use isokit::geom::cube::Edge;
use std::collections::{BTreeMap, BTreeSet};

/// Points of a lattice of so many steps a side, and the region of each.
struct Lattice {
    steps: usize,
    regions: Vec<usize>,
}

/// The cell with these corner values, on a lattice of so many steps a side.
pub(super) fn brute(corners: [i64; 8], steps: usize) -> Cell {
    let side = steps + 1;
    let weight = |at: usize, bit: usize| if bit == 1 { at } else { steps - at } as i64;
    let value = |n: usize| -> i64 {
        let ijk = [n % side, n / side % side, n / side / side];
        let weight = |k: usize| (0..3).map(|t| weight(ijk[t], k >> t & 1)).product::<i64>();
        (0..8).map(|k| weight(k) * corners[k]).sum()
    };
    let inside: Vec<bool> = (0..side.pow(3)).map(|n| value(n) >= 0).collect();
    let mut lattice = Lattice { steps, regions: vec![0; side.pow(3)] };
    let mut pieces = Pieces::new(side.pow(3));
    let edges: Vec<[usize; 2]> =
        (0..3).flat_map(|t| lattice.spans(1 << t)).map(|span| [span[0], span[1]]).collect();
    for &[a, b] in edges.iter().filter(|[a, b]| inside[*a] == inside[*b]) {
        pieces.join(a, b);
    }
    lattice.regions = (0..side.pow(3)).map(|n| pieces.root(n)).collect();

    let mut patches: BTreeMap<[usize; 2], Patch> = BTreeMap::new();
    let pair = |[a, b]: [usize; 2]| {
        let [a, b] = [lattice.regions[a], lattice.regions[b]];
        [a.min(b), a.max(b)]
    };
    let cut = edges.iter().filter(|[a, b]| inside[*a] != inside[*b]);
    let touching: BTreeSet<[usize; 2]> = cut.map(|&edge| pair(edge)).collect();
    for &parted in &touching {
        let rest = touching.iter().filter(|&&other| other != parted).copied();
        let euler = lattice.euler_between(parted[0], &rest.collect::<Vec<_>>());
        patches.insert(parted, Patch { euler, edges: vec![] });
    }
    let at = |k: usize| (0..3).map(|t| (k >> t & 1) * steps * side.pow(t as u32)).sum::<usize>();
    for edge in Edge::all() {
        let [low, high] = edge.ends().map(|end| at(end.index()));
        if inside[low] != inside[high] {
            let patch = patches.get_mut(&pair([low, high])).expect("they touch on this edge");
            patch.edges.push(edge.index());
        }
    }
    let mut regions: BTreeMap<usize, Region> = BTreeMap::new();
    for (n, &region) in lattice.regions.iter().enumerate() {
        regions.entry(region).or_insert(Region { inside: inside[n], corners: vec![] });
    }
    for corner in 0..8 {
        regions.get_mut(&lattice.regions[at(corner)]).expect("all are there").corners.push(corner);
    }
    let mut cell =
        Cell { patches: patches.into_values().collect(), regions: regions.into_values().collect() };
    cell.patches.sort_by_key(|patch| patch.edges.first().copied());
    cell.regions.sort_by_key(|region| region.corners.first().copied());
    cell
}

impl Lattice {
    /// The corners of all points, edges, squares or cubes that extend along these axes.
    fn spans(&self, axes: usize) -> impl Iterator<Item = Vec<usize>> {
        let side = self.steps + 1;
        let lows = (0..side.pow(3)).filter(move |n| {
            (0..3).all(|t| axes >> t & 1 == 0 || n / side.pow(t) % side < side - 1)
        });
        let offsets = (0..8).filter(move |corner| corner & !axes == 0);
        let offsets: Vec<usize> = offsets
            .map(|corner| (0..3).map(|t| (corner >> t & 1) * side.pow(t as u32)).sum())
            .collect();
        lows.map(move |low| offsets.iter().map(|offset| low + offset).collect())
    }

    /// The Euler characteristic of what is between X, all that is reached from a region by these steps, and
    /// the rest.
    fn euler_between(&self, first: usize, steps: &[[usize; 2]]) -> i64 {
        let mut reached = BTreeSet::from([first]);
        for _ in steps {
            for pair in steps {
                if pair.iter().any(|n| reached.contains(n)) {
                    reached.extend(pair);
                }
            }
        }
        let is_x: Vec<bool> = self.regions.iter().map(|region| reached.contains(region)).collect();
        let mut euler = -1;
        for axes in 0_usize..8 {
            let held =
                self.spans(axes).filter(|span| span.iter().all(|&n| is_x[n] == is_x[span[0]]));
            let sign = if axes.count_ones() % 2 == 0 { 1 } else { -1 };
            euler += sign * held.count() as i64;
        }
        euler
    }
}
