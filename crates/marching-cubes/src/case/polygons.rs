//! The polygons in which the surface goes through a cell, and all ways to cut each into triangles.
//!
//! They are read off the table: the triangles of a polygon share its corners, and its sides are those that no two of
//! them share. A way that draws a diagonal within a face of the cell is none: the cell behind that face may draw the same.

use super::TRIANGLES;
use isokit_geom::cube::Edge;
use std::{array, sync::LazyLock};

/// The most corners that a polygon has.
pub(crate) const CORNERS: usize = 7;

/// The most diagonals that one has.
pub(crate) const MOST: usize = CORNERS * (CORNERS - 3) / 2;

/// A polygon that can be cut in more than one way.
#[derive(Debug)]
pub(crate) struct Polygon {
    /// How many corners it has: 4 to 7.
    pub(crate) corners: usize,
    /// Its first triangle among those of the case; the others follow.
    pub(crate) first: usize,
    /// Where its triangles, one after the other, name its corners, counter-clockwise seen from outside; and where they do if
    /// all are turned.
    pub(crate) named: [[u8; CORNERS]; 2],
    /// Where its fillings begin among all, and how many it has.
    pub(crate) fillings: [usize; 2],
    /// Which of them the table has.
    pub(crate) own: usize,
}

/// A way to cut a polygon of `n` corners. The rest of both lists is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Filling {
    /// The `n - 3` [`diagonals`], by number.
    pub(crate) diagonals: [u8; CORNERS - 3],
    /// The corners of the `n - 2` triangles, the way round that the polygon has.
    pub(crate) triangles: [[u8; 3]; CORNERS - 2],
}

/// Those of all cases.
#[derive(Debug)]
pub(crate) struct Polygons {
    /// Where those of each case begin in `all`, and last how many there are.
    first: [u16; 257],
    all: Vec<Polygon>,
    /// Those of polygons of as many corners that may be joined alike are the same.
    fillings: Vec<Filling>,
}

pub(crate) static POLYGONS: LazyLock<Polygons> = LazyLock::new(|| {
    let mut polygons = Polygons { first: [0; 257], all: vec![], fillings: vec![] };
    let fillings = array::from_fn(fillings);
    for (case, triangles) in TRIANGLES.iter().enumerate() {
        polygons.add(triangles, &fillings);
        polygons.first[case + 1] = polygons.all.len() as u16;
    }
    polygons
});

/// The diagonals of a polygon of `N` corners, as pairs of these, in order; the rest is 0.
pub(crate) const fn diagonals<const N: usize>() -> [[usize; 2]; MOST] {
    let (mut all, mut count, mut a) = ([[0; 2]; MOST], 0, 0);
    while a < N {
        let mut b = a + 2;
        while b < N && b - a < N - 1 {
            all[count] = [a, b];
            count += 1;
            b += 1;
        }
        a += 1;
    }
    all
}

impl Polygons {
    /// Those of a case that can be cut in more than one way.
    #[inline(always)]
    pub(crate) fn of(&self, case: u8) -> &[Polygon] {
        let case = usize::from(case);
        &self.all[self.first[case].into()..self.first[case + 1].into()]
    }

    /// The ways to cut a polygon.
    #[inline(always)]
    pub(crate) fn fillings(&self, polygon: &Polygon) -> &[Filling] {
        let [first, count] = polygon.fillings;
        &self.fillings[first..first + count]
    }

    /// Adds those of a case. `fillings` has all ways to cut a polygon of so many corners.
    fn add(&mut self, triangles: &[[u8; 3]], fillings: &[Vec<Filling>; CORNERS + 1]) {
        let mut first = 0;
        while first < triangles.len() {
            let ring = ring(&triangles[first..]);
            let own = &triangles[first..][..ring.len() - 2];
            if own.len() > 1 {
                let polygon = self.polygon((own, &ring), first, &fillings[ring.len()]);
                self.all.push(polygon);
            }
            first += own.len();
        }
    }

    fn polygon(
        &mut self,
        (own, ring): (&[[u8; 3]], &[u8]),
        first: usize,
        fillings: &[Filling],
    ) -> Polygon {
        let corner = |edge: u8| ring.iter().position(|&e| e == edge).expect("a corner") as u8;
        let own_filling = sorted(own.iter().map(|triangle| triangle.map(corner)));
        let cut = |filling: &Filling| filling.triangles[..own.len()] == own_filling;
        let diagonals = diagonals_of(ring.len());
        let is_clear = diagonals.map(|corners| {
            let [a, b] = corners.map(|corner| Edge::new(ring[corner]));
            a.common_face(b).is_none()
        });
        let is_safe = |filling: &&Filling| {
            filling.diagonals[..own.len() - 1].iter().all(|&d| is_clear[usize::from(d)])
        };
        let fillings: Vec<Filling> = fillings.iter().filter(is_safe).copied().collect();
        let known = self.fillings.windows(fillings.len()).position(|some| some == fillings);
        let begin = known.unwrap_or(self.fillings.len());
        if known.is_none() {
            self.fillings.extend(&fillings);
        }
        let named = |n: usize| {
            let is_it = |edge: &u8| ring.get(n) == Some(edge);
            own.as_flattened().iter().position(is_it).map_or(0, |at| at as u8)
        };
        let named = array::from_fn(named);
        let turned = named.map(|at| [at, at + 1, at - u8::from(at > 0)][usize::from(at % 3)]);
        Polygon {
            corners: ring.len(),
            first,
            named: [named, turned],
            fillings: [begin, fillings.len()],
            own: fillings.iter().position(cut).expect("the table keeps out of faces"),
        }
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

/// All ways to cut a polygon of so many corners; none if it has less than four.
fn fillings(corners: usize) -> Vec<Filling> {
    if corners < 4 {
        return vec![];
    }
    let numbered = diagonals_of(corners);
    let filling = |triangles: Vec<[u8; 3]>| {
        let mut filling = Filling::default();
        let triangles = sorted(triangles);
        filling.triangles[..triangles.len()].copy_from_slice(&triangles);
        let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [a, c]]);
        let number = |[a, b]: [u8; 2]| numbered.iter().position(|d| *d == [a.into(), b.into()]);
        let mut joined: Vec<_> = sides.filter_map(number).collect();
        joined.sort_unstable();
        joined.dedup(); // each is a side of two triangles
        for (diagonal, number) in filling.diagonals.iter_mut().zip(joined) {
            *diagonal = number as u8;
        }
        filling
    };
    let ring: Vec<u8> = (0..corners as u8).collect();
    triangulations(&ring).into_iter().map(filling).collect()
}

fn diagonals_of(corners: usize) -> [[usize; 2]; MOST] {
    match corners {
        4 => diagonals::<4>(),
        5 => diagonals::<5>(),
        6 => diagonals::<6>(),
        _ => diagonals::<CORNERS>(),
    }
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
