//! Chance against a count too plain to be wrong.

use super::of;
use crate::{
    Topology, TriMesh,
    kit::{chance, graph, mesh, moved, sphere, threads, torus},
    topology::topology,
};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// The counters that do not depend on positions, by the definitions, each found on its own.
fn oracle(vertices: u32, triangles: &[[u32; 3]]) -> BTreeMap<&'static str, i64> {
    let out_of_range = triangles.iter().filter(|t| t.iter().any(|&v| v >= vertices)).count();
    let is_sound = |[a, b, c]: &[u32; 3]| {
        a != b && b != c && c != a && [a, b, c].into_iter().all(|&v| v < vertices)
    };
    let sound: Vec<[u32; 3]> = triangles.iter().copied().filter(is_sound).collect();

    let mut sets = BTreeSet::new();
    let duplicates = sound.iter().filter(|t| !sets.insert(BTreeSet::from(**t))).count();

    let mut edges: BTreeMap<(u32, u32), (i64, i64)> = BTreeMap::new();
    for &[a, b, c] in &sound {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let passes = edges.entry((p.min(q), p.max(q))).or_default();
            if p < q { passes.0 += 1 } else { passes.1 += 1 }
        }
    }
    let used: BTreeSet<u32> = sound.iter().flatten().copied().collect();

    // A vertex is manifold if the opposite sides of its triangles are one path or one cycle.
    let split = |v: u32| {
        let mut links: Vec<BTreeSet<u32>> = vec![];
        let mut degrees: BTreeMap<u32, usize> = BTreeMap::new();
        for triangle in sound.iter().filter(|t| t.contains(&v)) {
            let mut link: BTreeSet<u32> = triangle.iter().copied().filter(|&w| w != v).collect();
            link.iter().for_each(|&w| *degrees.entry(w).or_default() += 1);
            links.retain(|other| {
                let meets = !other.is_disjoint(&link);
                if meets {
                    link.extend(other);
                }
                !meets
            });
            links.push(link);
        }
        links.len() > 1 || degrees.values().any(|&degree| degree > 2)
    };

    let mut pieces: Vec<BTreeSet<(u32, u32)>> = vec![];
    for &[a, b, c] in &sound {
        let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| (p.min(q), p.max(q)));
        let mut piece = BTreeSet::from(sides);
        pieces.retain(|other| {
            let meets = !other.is_disjoint(&piece);
            if meets {
                piece.extend(other);
            }
            !meets
        });
        pieces.push(piece);
    }

    let count = |is_so: fn(i64, i64) -> bool| {
        edges.values().filter(|(there, back)| is_so(*there, *back)).count() as i64
    };
    BTreeMap::from([
        ("edges", edges.len() as i64),
        ("unused", i64::from(vertices) - used.len() as i64),
        ("out of range", out_of_range as i64),
        ("degenerate", (triangles.len() - out_of_range - sound.len()) as i64),
        ("duplicate", duplicates as i64),
        ("boundary", count(|there, back| there + back == 1)),
        ("nonmanifold edges", count(|there, back| there + back > 2)),
        ("nonmanifold vertices", used.iter().filter(|&&v| split(v)).count() as i64),
        ("inconsistent", count(|there, back| (there - back).abs() >= 2)),
        ("components", pieces.len() as i64),
        ("euler", used.len() as i64 - edges.len() as i64 + sound.len() as i64),
    ])
}

fn counters(found: &Topology) -> BTreeMap<&'static str, i64> {
    BTreeMap::from([
        ("edges", found.edges as i64),
        ("unused", found.unused_vertices as i64),
        ("out of range", found.out_of_range_triangles as i64),
        ("degenerate", found.degenerate_triangles as i64),
        ("duplicate", found.duplicate_triangles as i64),
        ("boundary", found.boundary_edges as i64),
        ("nonmanifold edges", found.nonmanifold_edges as i64),
        ("nonmanifold vertices", found.nonmanifold_vertices as i64),
        ("inconsistent", found.inconsistent_edges as i64),
        ("components", found.components.len() as i64),
        ("euler", found.euler()),
    ])
}

/// Triangles that name some of few vertices, so that they meet often; and, at times, one that is not there.
fn soup() -> impl Strategy<Value = (u32, Vec<[u32; 3]>)> {
    (1..12_u32).prop_flat_map(|vertices| {
        let name = 0..vertices + u32::from(vertices % 3 == 0);
        (Just(vertices), prop::collection::vec([name.clone(), name.clone(), name], 0..40))
    })
}

/// A closed surface with some triangles turned, left out, repeated or bent: mostly sound.
fn damaged() -> impl Strategy<Value = (u32, Vec<[u32; 3]>)> {
    (any::<bool>(), prop::collection::vec((0..5, any::<u32>(), any::<u32>()), 0..6)).prop_map(
        |(is_round, damages)| {
            let mesh = if is_round { sphere(1) } else { torus(4) };
            let (vertices, mut triangles) = (mesh.positions.len() as u32, mesh.triangles);
            for (kind, at, to) in damages {
                let at = at as usize % triangles.len();
                match kind {
                    0 => triangles[at].reverse(),
                    1 => drop(triangles.swap_remove(at)),
                    2 => triangles.push(triangles[at]),
                    3 => triangles[at][0] = to % vertices,
                    _ => {
                        let (from, to) = (triangles[at][0], to % vertices);
                        let names = triangles.iter_mut().flatten();
                        names.filter(|v| **v == from).for_each(|v| *v = to);
                    }
                }
            }
            (vertices, triangles)
        },
    )
}

/// The numbers below `n`, shuffled.
fn shuffled(n: usize, mut seed: u64) -> Vec<u32> {
    let mut all: Vec<u32> = (0..n as u32).collect();
    for i in (1..n).rev() {
        all.swap(i, (chance(&mut seed) % (i as u64 + 1)) as usize);
    }
    all
}

/// The same surface with vertices and triangles in another order, each triangle from another corner.
fn reordered(whole: &TriMesh, seed: u64) -> TriMesh {
    let names = shuffled(whole.positions.len(), seed);
    let mut places = vec![[0.0; 3]; names.len()];
    names
        .iter()
        .zip(whole.positions.iter())
        .for_each(|(&name, place)| places[name as usize] = place);
    let rename = |v: u32| names.get(v as usize).copied().unwrap_or(v);
    let triangles = shuffled(whole.triangles.len(), !seed).into_iter().map(|t| {
        let mut triangle = whole.triangles[t as usize].map(rename);
        triangle.rotate_left(t as usize % 3);
        triangle
    });
    mesh(&places, &triangles.collect::<Vec<_>>())
}

proptest! {
    #[test]
    fn soups_are_counted_by_the_definitions((vertices, triangles) in soup()) {
        let found = topology(&graph(vertices, &triangles), &threads(2)).unwrap();
        prop_assert_eq!(counters(&found), oracle(vertices, &triangles));
    }

    #[test]
    fn damaged_surfaces_are_counted_by_the_definitions((vertices, triangles) in damaged()) {
        let found = of(&graph(vertices, &triangles));
        prop_assert_eq!(counters(&found), oracle(vertices, &triangles));
    }

    #[test]
    fn pieces_add_up_to_the_whole((vertices, triangles) in damaged()) {
        let found = of(&graph(vertices, &triangles));
        let sum = |f: fn(&crate::Component) -> u64| found.components.iter().map(f).sum::<u64>();
        let sound = found.triangles - found.degenerate_triangles;
        prop_assert_eq!(sum(|c| c.triangles), sound);
        prop_assert!(sum(|c| c.vertices) >= found.vertices - found.unused_vertices);
        prop_assert!(sum(|c| c.nonmanifold_vertices) <= found.nonmanifold_vertices);
        let closed = found.components.iter().filter(|c| c.genus().is_some());
        prop_assert!(closed.clone().all(|c| c.euler() == 2 - 2 * c.genus().unwrap() as i64));
    }

    #[test]
    fn order_does_not_matter((vertices, triangles) in damaged(), seed: u64) {
        let mesh = graph(vertices, &triangles);
        let (one, other) = (of(&mesh), of(&reordered(&mesh, seed)));
        prop_assert_eq!(counters(&one), counters(&other));
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * one.measure.area * 1e4;
        prop_assert!(near(one.measure.area, other.measure.area));
        if one.is_closed() && one.is_oriented() {
            prop_assert!(near(one.measure.volume, other.measure.volume));
        }
    }

    #[test]
    fn a_power_of_two_scales_measures_and_nothing_else(
        (vertices, triangles) in damaged(),
        exponent in -40..40,
    ) {
        let (mesh, scale) = (graph(vertices, &triangles), 2_f64.powi(exponent));
        let (one, other) = (of(&mesh), of(&moved(&mesh, |x| x * scale)));
        prop_assert_eq!(counters(&one), counters(&other));
        prop_assert_eq!(one.measure.area * scale.powi(2), other.measure.area);
        prop_assert_eq!(one.measure.volume * scale.powi(3), other.measure.volume);
    }
}

#[test]
fn any_number_of_threads_finds_the_same() {
    // Several chunks of vertices, many pieces, all kinds of flaws.
    let mut seed = 7;
    let triangles: Vec<[u32; 3]> = (0..60_000)
        .map(|_| {
            let near = chance(&mut seed) as u32 % 50_000;
            std::array::from_fn(|_| near + chance(&mut seed) as u32 % 4)
        })
        .collect();
    let soup = graph(50_000, &triangles);
    let one = topology(&soup, &threads(1)).unwrap();
    assert!(one.components.len() > 1000 && one.nonmanifold_edges > 1000);
    for count in [2, 3, 7] {
        assert_eq!(topology(&soup, &threads(count)).unwrap(), one);
    }
}
