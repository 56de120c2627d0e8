//! What fills a cell: a disc in every loop, or a tube between two loops and a disc in every other.
//!
//! The regions into which loops cut the surface of a cell form a tree: each loop joins two of them, and a
//! closed surface falls apart at every loop. A tube joins two regions A and C of one sign. In the slice
//! that shows it, the four edges around belong to regions that follow each other, A, B, C, D, and back to
//! A; a tree has no such ring of four, so B and D are the same. The two loops of the tube are those
//! between A and that region, and between it and C.

use super::table::{CENTRE, Disc, resolved};
use isokit_geom::cube::Edge;

/// Vertices of the ring that a tube has around its waist.
pub(super) const WAIST: usize = 6;

/// What fills a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    discs: &'static [Disc],
    /// The discs whose loops a tube joins instead.
    ends: Option<[usize; 2]>,
}

impl Patch {
    /// For a code that is not simple, the faces that are joined, and two corners that the interior joins.
    pub(super) fn new(code: u8, joined: u8, tunnel: Option<[u8; 2]>) -> Self {
        let row = resolved(code, joined);
        let beside = |disc: &Disc| {
            let ends = Edge::new(disc.ring[0]).ends();
            ends.map(|corner| row.regions[corner.index()])
        };
        let between = |region: u8| {
            let other = move |(n, disc): (usize, &Disc)| match beside(disc) {
                [a, b] if a == region => Some((n, b)),
                [a, b] if b == region => Some((n, a)),
                _ => None,
            };
            row.discs.iter().enumerate().filter_map(other)
        };
        let ends = tunnel.and_then(|ends| {
            let [a, c] = ends.map(|k| row.regions[usize::from(k)]);
            between(a).find_map(|(n, shared)| {
                let meets = |&(_, other): &(usize, u8)| other == shared;
                between(c).find(meets).map(|(m, _)| [n, m])
            })
        });
        Self { discs: row.discs, ends }
    }

    /// The discs.
    pub(super) fn discs(&self) -> impl Iterator<Item = &'static Disc> {
        let (discs, ends) = (self.discs, self.ends);
        let is_filled = move |n: &usize| ends.is_none_or(|ends| !ends.contains(n));
        (0..discs.len()).filter(is_filled).map(move |n| &discs[n])
    }

    /// The two loops of the tube.
    pub(super) fn tube(&self) -> Option<[&'static [u8]; 2]> {
        self.ends.map(|ends| ends.map(|n| self.discs[n].ring))
    }

    /// The loop of the fan.
    pub(super) fn fan(&self) -> Option<&'static [u8]> {
        self.discs().find(|disc| disc.is_fan()).map(|disc| disc.ring)
    }

    /// Vertices in the interior: a waist or the centre of a fan, since both need more edges than there are.
    pub(super) fn vertices(&self) -> usize {
        match self.ends {
            Some(_) => WAIST,
            None => usize::from(self.fan().is_some()),
        }
    }

    pub(super) fn triangles(&self) -> usize {
        let discs: usize = self.discs().map(|disc| disc.triangles.len()).sum();
        let tube = |rings: [&[u8]; 2]| rings.iter().map(|ring| ring.len() + WAIST).sum();
        discs + self.tube().map_or(0, tube)
    }

    /// Adds the triangles of the tube to `out`; the vertices of the waist are [`CENTRE`] and those after it.
    /// `distances` are those of an edge's crossing from the vertices of the waist: of the ways to turn the waist
    /// the one with the least sum of distances is taken.
    pub(super) fn bridge(&self, distances: impl Fn(u8) -> [f64; WAIST], out: &mut Vec<[u8; 3]>) {
        let Some(rings) = self.tube() else { return };
        let mut twice_around = [[[0.0; 2 * WAIST]; 12]; 2];
        for (ring, twice_around) in rings.iter().zip(&mut twice_around) {
            for (&edge, both) in ring.iter().zip(twice_around) {
                let once = distances(edge);
                both[..WAIST].copy_from_slice(&once);
                both[WAIST..].copy_from_slice(&once);
            }
        }
        let best = |end: usize, is_reversed: bool| {
            let mut lengths = [0.0; WAIST];
            for step in strip(rings[end], Turn { first: 0, is_reversed }) {
                // With another first vertex the same step is at a vertex so much later.
                let later = &twice_around[end][step.edge][step.waist..step.waist + WAIST];
                lengths.iter_mut().zip(later).for_each(|(sum, distance)| *sum += distance);
            }
            let turns = (0..WAIST).map(|first| (lengths[first], Turn { first, is_reversed }));
            // Of equal ones the first.
            turns.reduce(|best, next| if next.0 < best.0 { next } else { best })
        };
        // Along one of the loops the waist runs as it does, along the other against that.
        let ways = [[false, true], [true, false]].map(|ways| {
            let ends = [best(0, ways[0]), best(1, ways[1])];
            ends.map(|end| end.expect("a waist has vertices"))
        });
        let [one, other] = ways.map(|[a, b]| a.0 + b.0);
        let turns = if other < one { ways[1] } else { ways[0] };
        for (ring, (_, turn)) in rings.into_iter().zip(turns) {
            for step in strip(ring, turn) {
                let [p, r] = [ring[step.edge], CENTRE + step.waist as u8];
                out.push(match step.next {
                    Next::Edge(q) => [p, ring[q], r],
                    Next::Waist(s) => [p, CENTRE + s as u8, r],
                });
            }
        }
    }
}

/// Where along the waist a strip begins, and which way round it runs.
#[derive(Clone, Copy, Debug)]
struct Turn {
    first: usize,
    is_reversed: bool,
}

/// A triangle of a strip: a vertex of the loop, one of the waist, and the next of either.
#[derive(Clone, Copy, Debug)]
struct Step {
    edge: usize,
    waist: usize,
    next: Next,
}

#[derive(Clone, Copy, Debug)]
enum Next {
    Edge(usize),
    Waist(usize),
}

/// The triangles between a loop and the waist, which take turns as evenly as they can: neither side is
/// run around while the other stands, so no two vertices are joined twice.
fn strip(ring: &[u8], turn: Turn) -> impl Iterator<Item = Step> {
    let sides = ring.len();
    // Neither goes once more around: what is asked for the remainder is less than twice the divisor.
    let around = |n: usize, all: usize| if n < all { n } else { n - all };
    let waist = move |n: usize| match turn.is_reversed {
        true => around(turn.first + WAIST - n, WAIST),
        false => around(turn.first + n, WAIST),
    };
    let (mut i, mut j) = (0, 0);
    (0..sides + WAIST).map(move |_| {
        let (edge, at) = (around(i, sides), waist(j));
        let next = if (2 * i + 1) * WAIST <= (2 * j + 1) * sides {
            i += 1;
            Next::Edge(around(i, sides))
        } else {
            j += 1;
            Next::Waist(waist(j))
        };
        Step { edge, waist: at, next }
    })
}

#[cfg(test)]
mod tests;
