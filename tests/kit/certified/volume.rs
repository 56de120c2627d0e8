//! The topology of a whole trilinear surface, from that of its cells.
//!
//! Patches of neighbouring cells meet in the arcs on their common faces, and these in the points on cut
//! lattice edges. So the Euler characteristic is that of all patches, less one for each arc, plus one for
//! each point. Every lattice face beside a cut edge has one end of an arc there: half an arc, whichever way
//! the arcs of an ambiguous face lead, so a piece's arcs are counted at its edges.

use super::{cell, pieces::Pieces};
use isokit::geom::cube::{Corner, Edge};
use std::collections::BTreeMap;

/// The Euler characteristic of each connected piece of the surface in a lattice of samples, x fastest, less
/// the isovalue, in ascending order. The surface ends where the lattice does. None if a cell is undecided.
///
/// # Panics
///
/// If there are not as many samples as `dims` says.
pub fn volume(dims: [usize; 3], samples: &[i64]) -> Option<Vec<i64>> {
    assert_eq!(samples.len(), dims.iter().product::<usize>(), "one sample for each point");
    let steps = [1, dims[0], dims[0] * dims[1]];
    let mut pieces = Pieces::new(3 * samples.len());
    let mut twice: Vec<(usize, i64)> = vec![];
    for low in points(dims.map(|n| n.saturating_sub(1))) {
        let number = |corner: Corner| -> usize {
            (0..3).map(|axis| (low[axis] + corner.offset()[axis]) * steps[axis]).sum()
        };
        let corners = std::array::from_fn(|k| samples[number(Corner::new(k as u8))]);
        for patch in cell(corners)?.patches {
            let edges = patch.edges.iter().map(|&e| Edge::new(e as u8));
            let edges: Vec<usize> =
                edges.map(|edge| 3 * number(edge.ends()[0]) + edge.axis()).collect();
            twice.push((edges[0], 2 * patch.euler));
            edges.iter().for_each(|&edge| pieces.join(edges[0], edge));
        }
    }
    if dims.iter().all(|&n| n > 1) {
        for (n, point) in points(dims).enumerate() {
            for axis in (0..3).filter(|&axis| point[axis] + 1 < dims[axis]) {
                if (samples[n] >= 0) != (samples[n + steps[axis]] >= 0) {
                    let others = (0..3).filter(|&other| other != axis);
                    let faces = others.map(|other| {
                        i64::from(point[other] > 0) + i64::from(point[other] + 1 < dims[other])
                    });
                    twice.push((3 * n + axis, 2 - faces.sum::<i64>()));
                }
            }
        }
    }
    let mut eulers: BTreeMap<usize, i64> = BTreeMap::new();
    for (edge, count) in twice {
        *eulers.entry(pieces.root(edge)).or_default() += count;
    }
    let mut eulers: Vec<i64> = eulers.into_values().map(|twice| twice / 2).collect();
    eulers.sort_unstable();
    Some(eulers)
}

/// The same samples with a layer of outside ones all around, so that the surface is closed. In a cell between
/// samples and such a layer the field falls monotonically from what it is on the samples' face, wherever it
/// is inside, so the topology is the same for every value below 0.
pub fn enclosed(dims: [usize; 3], samples: &[i64]) -> ([usize; 3], Vec<i64>) {
    let larger = dims.map(|n| n + 2);
    let held = points(larger).map(|point| {
        let held = (0..3).all(|axis| (1..=dims[axis]).contains(&point[axis]));
        let [x, y, z] = point;
        if held { samples[x - 1 + dims[0] * (y - 1 + dims[1] * (z - 1))] } else { -1 }
    });
    (larger, held.collect())
}

/// The points of a lattice, x fastest.
fn points([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}
