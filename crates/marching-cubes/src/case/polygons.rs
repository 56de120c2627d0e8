//! The polygons in which the surface goes through a cell, and all ways to cut each into triangles.
//!
//! They are read off the table: the triangles of a polygon share its corners, and its sides are those that no two of
//! them share. That is done once, when diagonals are first fitted: a surface that is cut as the table does needs none of it.
//! A way that draws a diagonal within a face of the cell is none: the cell behind that face may draw the same.

use super::TRIANGLES;
use isokit_geom::cube::Edge;
use isokit_lanes::{CORNERS, DIAGONALS, TRIPLES, Way, diagonals, triples};
use std::{array, ops::Range, sync::LazyLock};

/// A polygon that can be cut in more than one way.
#[derive(Debug)]
pub(crate) struct Polygon {
    /// How many corners it has: 4 to [`CORNERS`].
    pub(crate) corners: usize,
    /// Its first triangle among those of the case; the others follow.
    pub(crate) first: usize,
    /// Where its triangles, one after the other, name its corners, counter-clockwise seen from outside; and where they do if
    /// all are turned.
    pub(crate) named: [[u8; CORNERS]; 2],
    /// The way that the table has, by number.
    pub(crate) own: u32,
    /// A bit for each way that draws a diagonal within a face, the first of 32 the highest.
    pub(crate) ways_in_faces: [u32; 2],
}

/// All ways to cut a polygon of so many corners.
#[derive(Debug, Default)]
pub(crate) struct Ways {
    pub(crate) all: Vec<Way>,
    /// The corners of the triangles of each, in the order of the polygon; after those, anything.
    pub(crate) triangles: Vec<[[u8; 3]; CORNERS - 2]>,
}

/// Those of all cases.
#[derive(Debug)]
pub(crate) struct Polygons {
    /// Where those of each case begin in `all`, and last how many there are.
    first: [u16; 257],
    all: Vec<Polygon>,
    /// By the number of corners.
    ways: [Ways; CORNERS + 1],
}

pub(crate) static POLYGONS: LazyLock<Polygons> = LazyLock::new(|| {
    let mut polygons = Polygons { first: [0; 257], all: vec![], ways: array::from_fn(Ways::new) };
    for (case, triangles) in TRIANGLES.iter().enumerate() {
        polygons.add(triangles);
        polygons.first[case + 1] = polygons.all.len() as u16;
    }
    polygons
});

impl Polygons {
    /// The numbers of those of a case that can be cut in more than one way.
    #[inline(always)]
    pub(crate) fn of(&self, case: u8) -> Range<u16> {
        self.first[usize::from(case)]..self.first[usize::from(case) + 1]
    }

    /// The polygon of a number.
    #[inline(always)]
    pub(crate) fn get(&self, number: u16) -> &Polygon {
        &self.all[usize::from(number)]
    }

    /// The ways to cut those of so many corners.
    #[inline(always)]
    pub(crate) fn ways(&self, corners: usize) -> &Ways {
        &self.ways[corners]
    }

    /// Adds those of a case.
    fn add(&mut self, triangles: &[[u8; 3]]) {
        let mut first = 0;
        while first < triangles.len() {
            let ring = ring(&triangles[first..]);
            let own = &triangles[first..][..ring.len() - 2];
            if own.len() > 1 {
                self.all.push(Polygon::new(own, &ring, first, &self.ways[ring.len()]));
            }
            first += own.len();
        }
    }
}

impl Polygon {
    fn new(own: &[[u8; 3]], ring: &[u8], first: usize, ways: &Ways) -> Self {
        let corner = |edge: u8| ring.iter().position(|&e| e == edge).expect("a corner") as u8;
        let cut = sorted(own.iter().map(|triangle| triangle.map(corner)));
        let own_way = ways.triangles.iter().position(|way| way[..own.len()] == cut);
        let (diagonals, _) = numbered(ring.len());
        let is_in_face = diagonals.map(|corners| {
            let [a, b] = corners.map(|corner| Edge::new(ring[corner]));
            a.common_face(b).is_some()
        });
        let is_in_some_face =
            |way: &Way| way.diagonals[..own.len() - 1].iter().any(|&d| is_in_face[usize::from(d)]);
        let bit = |(n, way): (usize, &Way)| u64::from(is_in_some_face(way)) << 63 >> n;
        let bits = ways.all.iter().enumerate().map(bit).fold(0, |bits, bit| bits | bit);
        let named = array::from_fn(|n: usize| {
            let is_it = |edge: &u8| ring.get(n) == Some(edge);
            own.as_flattened().iter().position(is_it).map_or(0, |at| at as u8)
        });
        let turned = named.map(|at| [at, at + 1, at - u8::from(at > 0)][usize::from(at % 3)]);
        Self {
            corners: ring.len(),
            first,
            named: [named, turned],
            own: own_way.expect("it is one of all") as u32,
            ways_in_faces: [(bits >> 32) as u32, bits as u32],
        }
    }
}

impl Ways {
    /// Those of polygons of so many corners; none of less than four.
    fn new(corners: usize) -> Self {
        let mut ways = Self::default();
        if corners < 4 {
            return ways;
        }
        let (diagonals, triples) = numbered(corners);
        let ring: Vec<u8> = (0..corners as u8).collect();
        for triangles in triangulations(&ring) {
            let triangles = sorted(triangles);
            let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [a, c]]);
            let number = |side: [u8; 2]| diagonals.iter().position(|d| *d == side.map(usize::from));
            let mut joined: Vec<_> = sides.filter_map(number).collect();
            joined.sort_unstable();
            joined.dedup(); // each is a side of two triangles
            let (mut way, mut kept) = (Way::default(), <[[u8; 3]; CORNERS - 2]>::default());
            for (slot, number) in way.diagonals.iter_mut().zip(joined) {
                *slot = number as u8;
            }
            for (n, triangle) in triangles.into_iter().enumerate() {
                let is_it = |triple: &[usize; 3]| *triple == triangle.map(usize::from);
                way.triangles[n] = triples.iter().position(is_it).expect("in order") as u8;
                kept[n] = triangle;
            }
            ways.all.push(way);
            ways.triangles.push(kept);
        }
        ways
    }
}

/// The diagonals and triples of a polygon of so many corners, four or more.
fn numbered(corners: usize) -> ([[usize; 2]; DIAGONALS], [[usize; 3]; TRIPLES]) {
    match corners {
        4 => (diagonals::<4>(), triples::<4>()),
        5 => (diagonals::<5>(), triples::<5>()),
        6 => (diagonals::<6>(), triples::<6>()),
        _ => (diagonals::<CORNERS>(), triples::<CORNERS>()),
    }
}

/// The edges around the polygon that the first triangle belongs to, from its least on.
fn ring(triangles: &[[u8; 3]]) -> Vec<u8> {
    let sides = || triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let is_rim = |[a, b]: &[u8; 2]| !sides().any(|side| side == [*b, *a]);
    let mut next = [None; 12];
    sides().filter(is_rim).for_each(|[a, b]| next[usize::from(a)] = Some(b));
    // Each edge belongs to one polygon, and the table begins with the least edge.
    let begin = triangles[0][0];
    let follows = |&edge: &u8| next[usize::from(edge)].filter(|&edge| edge != begin);
    std::iter::successors(Some(begin), follows).collect()
}

/// Each from its least corner, in ascending order.
fn sorted(triangles: impl IntoIterator<Item = [u8; 3]>) -> Vec<[u8; 3]> {
    let mut triangles: Vec<_> = triangles.into_iter().map(least_first).collect();
    triangles.sort_unstable();
    triangles
}

/// Every triangulation of `ring`: some triangle stands on the side from its last corner to its first.
pub(crate) fn triangulations<T: Copy>(ring: &[T]) -> Vec<Vec<[T; 3]>> {
    if ring.len() < 3 {
        return vec![vec![]]; // nothing to fill, in one way
    }
    let last = ring.len() - 1;
    let mut found = vec![];
    for tip in 1..last {
        for before in triangulations(&ring[..=tip]) {
            for after in triangulations(&ring[tip..]) {
                found.push([&[[ring[0], ring[tip], ring[last]]], &*before, &*after].concat());
            }
        }
    }
    found
}

/// The same triangle, named from its least corner.
pub(crate) fn least_first<T: Ord + Copy>([a, b, c]: [T; 3]) -> [T; 3] {
    [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().expect("three ways")
}
