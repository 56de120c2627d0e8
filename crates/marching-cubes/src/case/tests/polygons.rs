//! That polygons are the loops of the cases, with all ways to fill them.

use super::{
    super::{TRIANGLES, polygons::POLYGONS},
    derive::{self, Pairing},
    triangulate,
};
use isokit_geom::cube::Edge;
use isokit_lanes::CORNERS;
use std::collections::BTreeSet;

/// The triangles of a way to cut something, in whatever order, each from its least corner.
type Way = BTreeSet<[usize; 3]>;

fn way(triangles: impl IntoIterator<Item = [Edge; 3]>) -> Way {
    let named = |triangle: [Edge; 3]| {
        let mut triangle = triangle.map(Edge::index);
        let least = (0..3).min_by_key(|&n| triangle[n]).unwrap();
        triangle.rotate_left(least);
        triangle
    };
    triangles.into_iter().map(named).collect()
}

#[test]
fn the_ways_to_cut_polygons_are_all_that_keep_diagonals_out_of_faces() {
    for case in 0..=255 {
        let rings = derive::loops(case, Pairing::SeparateInside);
        let mut rings = rings.iter().filter(|ring| ring.len() > 3);
        let triangles = TRIANGLES[usize::from(case)];
        for polygon in POLYGONS.of(case).map(|number| POLYGONS.get(number)) {
            let ring = rings.next().unwrap();
            assert_eq!(polygon.corners, ring.len(), "{case:#010b}");
            let own = &triangles[polygon.first..][..ring.len() - 2];
            let corners = polygon.named[0][..ring.len()].iter();
            let corners = corners.map(|&at| Edge::new(own.as_flattened()[usize::from(at)]));
            assert_eq!(corners.collect::<Vec<_>>(), *ring, "{case:#010b}");
            let turned: Vec<[u8; 3]> = own.iter().map(|&[a, b, c]| [a, c, b]).collect();
            let corners = polygon.named[1][..ring.len()].iter();
            let corners = corners.map(|&at| Edge::new(turned.as_flattened()[usize::from(at)]));
            assert_eq!(corners.collect::<Vec<_>>(), *ring, "{case:#010b}, turned");

            let all_ways = POLYGONS.ways(ring.len());
            let ways = all_ways.triangles.iter().map(|triangles| {
                let triangles = triangles[..ring.len() - 2].iter();
                way(triangles.map(|corners| corners.map(|n| ring[usize::from(n)])))
            });
            let mut ways: Vec<Way> = ways.collect();
            let own = way(own.iter().map(|t| t.map(Edge::new)));
            assert_eq!(ways[polygon.own as usize], own, "{case:#010b}");
            for number in (0..ways.len()).rev() {
                if polygon.ways_in_faces[number / 32] << (number % 32) >> 31 == 1 {
                    ways.remove(number);
                }
            }
            let all: BTreeSet<Way> = triangulate::face_safe(ring).into_iter().map(way).collect();
            assert_eq!(ways.len(), all.len(), "{case:#010b}");
            assert_eq!(ways.into_iter().collect::<BTreeSet<_>>(), all, "{case:#010b}");
        }
        assert_eq!(rings.next(), None, "{case:#010b}");
    }
}

#[test]
fn the_diagonals_of_a_way_are_the_sides_that_its_triangles_share() {
    let diagonals = |corners: usize| -> Vec<[usize; 2]> {
        let pairs = (0..corners).flat_map(|a| (a + 1..corners).map(move |b| [a, b]));
        pairs.filter(|[a, b]| b - a > 1 && b - a < corners - 1).collect()
    };
    for corners in 4..=CORNERS {
        let ways = POLYGONS.ways(corners);
        for (way, triangles) in ways.all.iter().zip(&ways.triangles) {
            let triangles = &triangles[..corners - 2];
            let sides = triangles.iter();
            let sides: Vec<_> = sides.flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
            let shared = sides.iter().filter(|[a, b]| a < b && sides.contains(&[*b, *a]));
            let shared: BTreeSet<_> = shared.map(|side| side.map(usize::from)).collect();
            let named = way.diagonals[..corners - 3].iter();
            let named = named.map(|&d| diagonals(corners)[usize::from(d)]).collect();
            assert_eq!(shared, named);
            let triples = |n: usize| {
                (n + 1..corners).flat_map(move |b| (b + 1..corners).map(move |c| [n, b, c]))
            };
            let triples: Vec<_> = (0..corners).flat_map(triples).collect();
            let named = way.triangles[..corners - 2].iter().map(|&t| triples[usize::from(t)]);
            assert!(named.eq(triangles.iter().map(|triangle| triangle.map(usize::from))));
        }
    }
}
