//! First proof that meshes close: every pair of neighbouring cells, 3 axes × 2¹² signs.
//!
//! The two cells' triangles are put together as a mesh has them. On the common face every side must occur
//! once in each direction; nowhere may one occur twice in the same. Two wrong tables, each the right one
//! but for a single property, show that the proof can fail.

use super::{
    block::{Block, Sides},
    derive::{self, Pairing},
    triangulate::Triangle,
};
use crate::case::TRIANGLES;
use isokit_geom::cube::Edge;

#[test]
fn neighbours_leave_no_side_open_and_use_none_twice() {
    assert_eq!(survey(&TRIANGLES), Survey { pairs: 12_288, open: 0, over_used: 0 });
}

#[test]
fn the_other_pairing_closes_too() {
    let table = table(|case| derive::triangles(case, Pairing::SeparateOutside));
    assert_eq!(survey(&table), Survey { pairs: 12_288, open: 0, over_used: 0 });
}

/// The rule of 1987: more than four inside corners are drawn as their complement.
#[test]
fn complements_taken_for_equal_leave_holes() {
    let table = table(|case| match case.count_ones() {
        0..=4 => derive::triangles(case, Pairing::SeparateInside),
        _ => derive::triangles(!case, Pairing::SeparateInside)
            .into_iter()
            .map(|[a, b, c]| [a, c, b])
            .collect(),
    });
    let found = survey(&table);
    assert_eq!(found, Survey { pairs: 12_288, open: 660, over_used: 0 });
}

/// Each fan is a sound surface by itself; only a neighbour shows what is wrong with it.
#[test]
fn a_fan_from_the_least_edge_meets_its_neighbour_in_a_face() {
    let table = table(|case| {
        let loops = derive::loops(case, Pairing::SeparateInside);
        let fan = |ring: &Vec<Edge>| {
            let apex = ring[0];
            ring[1..].windows(2).map(|side| [apex, side[0], side[1]]).collect::<Vec<_>>()
        };
        loops.iter().flat_map(fan).collect()
    });
    let found = survey(&table);
    assert_eq!(found, Survey { pairs: 12_288, open: 0, over_used: 18 });
}

/// What the pairs have, counted in pairs.
#[derive(Debug, PartialEq, Eq)]
struct Survey {
    pairs: usize,
    /// With a side on the common face that only one of the two cells uses.
    open: usize,
    /// With a side that two triangles use in the same direction.
    over_used: usize,
}

fn survey(table: &[impl AsRef<[[u8; 3]]>]) -> Survey {
    let mut found = Survey { pairs: 0, open: 0, over_used: 0 };
    for axis in 0..3 {
        let mut points = [2; 3];
        points[axis] = 3;
        let block = Block::new(points);
        let on_common_face = |edge| block.is_in_plane(edge, axis, 1);
        for signs in 0..block.patterns() {
            let sides = Sides::of(block.triangles(signs, table));
            let is_open = sides.open().any(|[p, q]| on_common_face(p) && on_common_face(q));
            found.pairs += 1;
            found.open += usize::from(is_open);
            found.over_used += usize::from(sides.over_used > 0);
        }
    }
    found
}

fn table(of: impl Fn(u8) -> Vec<Triangle>) -> Vec<Vec<[u8; 3]>> {
    let numbers = |triangle: Triangle| triangle.map(|e| e.index() as u8);
    (0..=255).map(|case| of(case).into_iter().map(numbers).collect()).collect()
}
