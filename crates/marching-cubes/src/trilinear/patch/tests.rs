//! What fills a cell, for every code, every choice of its faces and every tunnel that there could be.

use super::{Patch, WAIST};
use crate::trilinear::table::{
    CENTRE,
    derive::{choices, codes},
    resolved,
};
use isokit_geom::cube::{Corner, Edge, Face};
use std::collections::{BTreeMap, BTreeSet};

/// Every code that is not simple, with every choice of faces, without a tunnel and with each that joins
/// two regions beside a third.
fn all() -> impl Iterator<Item = (u8, u8, Option<[u8; 2]>)> {
    codes().flat_map(|code| choices(code).map(move |joined| (code, joined))).flat_map(
        |(code, joined)| {
            let row = resolved(code, joined);
            let mut beside: BTreeMap<u8, BTreeSet<u8>> = BTreeMap::new();
            for disc in row.discs {
                let [a, b] = Edge::new(disc.ring[0]).ends().map(|k| row.regions[k.index()]);
                beside.entry(a).or_default().insert(b);
                beside.entry(b).or_default().insert(a);
            }
            let mut tunnels = BTreeSet::from([None]);
            for around in beside.values() {
                for (&a, &c) in around.iter().flat_map(|a| around.iter().map(move |c| (a, c))) {
                    if a != c {
                        tunnels.insert(Some([a, c]));
                    }
                }
            }
            tunnels.into_iter().map(move |tunnel| (code, joined, tunnel))
        },
    )
}

/// All triangles, with distances by chance.
fn triangles(patch: &Patch, seed: u64) -> Vec<[u8; 3]> {
    let mut triangles: Vec<_> = patch.discs().flat_map(|disc| disc.triangles).copied().collect();
    let distance = |edge: u8, n: usize| {
        let mixed = (seed + u64::from(edge) * 37 + n as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (mixed >> 40) as f64
    };
    patch.bridge(|edge| std::array::from_fn(|n| distance(edge, n)), &mut triangles);
    triangles
}

fn sides([a, b, c]: [u8; 3]) -> [[u8; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// The pieces of a surface: the loops that bound each, and its Euler characteristic.
fn pieces(triangles: &[[u8; 3]]) -> Vec<(usize, i32)> {
    let mut piece: BTreeMap<u8, u8> = triangles.as_flattened().iter().map(|&v| (v, v)).collect();
    for _ in 0..piece.len() {
        for [a, b] in triangles.iter().copied().flat_map(sides) {
            let least = piece[&a].min(piece[&b]);
            piece.extend([(a, least), (b, least)]);
        }
    }
    let names: BTreeSet<u8> = piece.values().copied().collect();
    let of = |name: u8| {
        let own: Vec<_> = triangles.iter().copied().filter(|t| piece[&t[0]] == name).collect();
        let each: BTreeSet<[u8; 2]> = own.iter().copied().flat_map(sides).collect();
        let rim = each.iter().filter(|&&[a, b]| !each.contains(&[b, a]));
        let mut next: BTreeMap<u8, u8> = rim.map(|&[a, b]| (a, b)).collect();
        let edges = (each.len() + next.len()) / 2;
        let vertices = piece.values().filter(|&&other| other == name).count();
        let mut loops = 0;
        while let Some((first, mut at)) = next.pop_first() {
            loops += 1;
            while at != first {
                at = next.remove(&at).expect("a rim is made of loops");
            }
        }
        (loops, vertices as i32 - edges as i32 + own.len() as i32)
    };
    names.into_iter().map(of).collect()
}

#[test]
fn every_patch_has_the_counts_that_it_says() {
    for (code, joined, tunnel) in all() {
        let patch = Patch::new(code, joined, tunnel);
        let triangles = triangles(&patch, 1);
        assert_eq!(triangles.len(), patch.triangles(), "{code:08b}, {joined:06b}, {tunnel:?}");
        let inner: BTreeSet<_> =
            triangles.as_flattened().iter().filter(|&&v| v >= CENTRE).collect();
        assert_eq!(inner.len(), patch.vertices());
        let greatest = inner.last().map_or(0, |&&last| usize::from(last - CENTRE) + 1);
        assert_eq!(greatest, patch.vertices(), "they are numbered without gaps");
        assert_eq!(patch.tube().is_some(), tunnel.is_some());
        assert!(patch.vertices() <= WAIST);
    }
}

/// As many tubes as there are loops and one, less the regions that are left.
#[test]
fn discs_have_one_loop_each_and_a_tube_has_two() {
    for (code, joined, tunnel) in all() {
        let loops = resolved(code, joined).discs.len();
        let mut regions = BTreeSet::from(resolved(code, joined).regions);
        if let Some([_, c]) = tunnel {
            regions.remove(&c);
        }
        for seed in 0..3 {
            let found = pieces(&triangles(&Patch::new(code, joined, tunnel), seed));
            let count = |piece| found.iter().filter(|&&one| one == piece).count();
            let tubes = count((2, 0));
            assert_eq!(tubes, loops + 1 - regions.len(), "{code:08b}, {joined:06b}, {tunnel:?}");
            assert_eq!((found.len(), count((1, 1))), (loops - tubes, loops - 2 * tubes));
        }
    }
}

#[test]
fn no_side_is_used_twice_the_same_way_and_the_rim_is_the_loops() {
    for (code, joined, tunnel) in all() {
        let triangles = triangles(&Patch::new(code, joined, tunnel), 5);
        let all: Vec<_> = triangles.iter().copied().flat_map(sides).collect();
        let each: BTreeSet<_> = all.iter().copied().collect();
        assert_eq!(each.len(), all.len(), "{code:08b}, {joined:06b}, {tunnel:?}");
        let rim = each.iter().copied().filter(|&[p, q]| !each.contains(&[q, p]));
        let rings = resolved(code, joined).discs.iter().map(|disc| disc.ring);
        let sides = rings
            .flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)).map(|(&p, &q)| [p, q]));
        assert_eq!(rim.collect::<BTreeSet<_>>(), sides.collect(), "{code:08b}, {joined:06b}");
    }
}

/// Around every vertex the triangles are one fan, open on an edge and closed in the interior.
#[test]
fn every_vertex_has_one_fan() {
    for (code, joined, tunnel) in all() {
        let triangles = triangles(&Patch::new(code, joined, tunnel), 9);
        for &vertex in triangles.as_flattened() {
            let turned = triangles.iter().flat_map(|&[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]]);
            let next: BTreeMap<u8, u8> =
                turned.filter(|t| t[0] == vertex).map(|[_, from, to]| (from, to)).collect();
            let reached: BTreeSet<u8> = next.values().copied().collect();
            let first = next.keys().find(|from| !reached.contains(from));
            assert_eq!(first.is_none(), vertex >= CENTRE, "{code:08b}, {joined:06b}, {tunnel:?}");
            let start = *first.or(next.keys().next()).unwrap();
            let (mut at, mut steps) = (start, 0);
            while let Some(&to) = next.get(&at).filter(|_| steps < next.len()) {
                (at, steps) = (to, steps + 1);
                if at == start {
                    break;
                }
            }
            assert_eq!(steps, next.len(), "{code:08b}, {joined:06b}, {tunnel:?}");
        }
    }
}

#[test]
fn no_inner_side_of_a_tube_lies_in_a_face() {
    for (code, joined, tunnel) in all() {
        let triangles = triangles(&Patch::new(code, joined, tunnel), 13);
        let each: BTreeSet<_> = triangles.iter().copied().flat_map(sides).collect();
        for [p, q] in each.iter().filter(|&&[p, q]| each.contains(&[q, p])) {
            let is_flat = |face: Face| {
                [p, q].iter().all(|&&name| name < CENTRE && face.contains(Edge::new(name)))
            };
            assert!(!Face::all().any(is_flat), "{code:08b}, {joined:06b}, {tunnel:?}: {p} to {q}");
        }
    }
}

#[test]
fn the_loops_of_a_tube_lie_between_what_it_joins_and_one_other_region() {
    for (code, joined, tunnel) in all() {
        let patch = Patch::new(code, joined, tunnel);
        let (Some(rings), Some(joins)) = (patch.tube(), tunnel) else { continue };
        let regions = resolved(code, joined).regions;
        let mut others = BTreeSet::new();
        for (ring, own) in rings.into_iter().zip(joins) {
            let ends = ring.iter().map(|&edge| Edge::new(edge).ends().map(Corner::index));
            for [a, b] in ends.map(|ends| ends.map(|k| regions[k])) {
                assert!(a == own || b == own, "{code:08b}, {joined:06b}, {tunnel:?}");
                others.insert(if a == own { b } else { a });
            }
        }
        assert_eq!(others.len(), 1, "{code:08b}, {joined:06b}, {tunnel:?}");
    }
}
