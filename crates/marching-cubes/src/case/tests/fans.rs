//! Second proof that meshes close, independent of the first: all that can surround one lattice edge.
//!
//! Four cells meet at a lattice edge and have 18 samples. For every choice of their signs, 2¹⁸ and along
//! each of the three axes, the triangles at the vertex on that edge must be one closed fan: as one walks
//! around the vertex, each triangle hands over to the next until the first comes back, and none is left.
//! The proof reads nothing but the table.

use super::block::{Block, EDGE_NAMES, Sides, edge_above};
use crate::case::TRIANGLES;

#[test]
fn the_triangles_around_every_vertex_are_one_closed_fan() {
    for axis in 0..3 {
        let (block, low) = around_an_edge(axis);
        let high = low + block.sample(std::array::from_fn(|i| usize::from(i == axis)));
        for signs in 0..block.patterns() {
            let is_cut = (signs >> low ^ signs >> high) & 1 == 1;
            let fan = fan(block.triangles(signs, &TRIANGLES), edge_above(low, axis));
            let expected = if is_cut { Fan::Closed } else { Fan::Empty };
            assert_eq!(fan, expected, "axis {axis}, signs {signs:#020b}");
        }
    }
}

#[test]
fn no_side_near_a_lattice_edge_is_used_twice() {
    for axis in 0..3 {
        let (block, _) = around_an_edge(axis);
        for signs in 0..block.patterns() {
            let sides = Sides::of(block.triangles(signs, &TRIANGLES));
            assert_eq!(sides.over_used, 0, "axis {axis}, signs {signs:#020b}");
        }
    }
}

#[test]
fn a_broken_fan_is_noticed() {
    let around = |rims: &[[usize; 2]]| {
        let triangles: Vec<_> = rims.iter().map(|&[p, q]| [0, p, q]).collect();
        fan(triangles.into_iter(), 0)
    };
    assert_eq!(around(&[]), Fan::Empty);
    assert_eq!(around(&[[1, 2], [2, 3], [3, 1]]), Fan::Closed);
    assert_eq!(around(&[[1, 2], [2, 3]]), Fan::Broken, "open");
    assert_eq!(around(&[[1, 2], [2, 1]]), Fan::Broken, "folded flat");
    assert_eq!(around(&[[1, 2], [2, 3], [3, 1], [1, 4]]), Fan::Broken, "a side used twice");
    let two = [[1, 2], [2, 3], [3, 1], [4, 5], [5, 6], [6, 4]];
    assert_eq!(around(&two), Fan::Broken, "two fans touching in a point");
}

/// The block of the four cells around a lattice edge along `axis`, and the sample that edge starts from.
fn around_an_edge(axis: usize) -> (Block, usize) {
    let block = Block::new(std::array::from_fn(|i| if i == axis { 2 } else { 3 }));
    let low = block.sample(std::array::from_fn(|i| usize::from(i != axis)));
    (block, low)
}

#[derive(Debug, PartialEq, Eq)]
enum Fan {
    Empty,
    Closed,
    Broken,
}

/// How the triangles with the corner `vertex` lie around it.
fn fan(triangles: impl Iterator<Item = [usize; 3]>, vertex: usize) -> Fan {
    const NONE: usize = usize::MAX;
    let (mut next, mut count, mut start) = ([NONE; EDGE_NAMES], 0, NONE);
    for [a, b, c] in triangles {
        let (from, to) = match vertex {
            v if v == a => (b, c),
            v if v == b => (c, a),
            v if v == c => (a, b),
            _ => continue,
        };
        if next[from] != NONE {
            return Fan::Broken;
        }
        next[from] = to;
        (start, count) = (from, count + 1);
    }
    if count == 0 {
        return Fan::Empty;
    }
    let (mut at, mut steps) = (next[start], 1);
    while at != start && at != NONE && steps < count {
        (at, steps) = (next[at], steps + 1);
    }
    if at == start && steps == count && count >= 3 { Fan::Closed } else { Fan::Broken }
}
