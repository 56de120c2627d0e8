//! Small meshes that tests of several rooms use.

use crate::{Positions, TriMesh};
use isokit_job::{Job, Threads};
use std::{array, collections::BTreeMap, num::NonZeroUsize};

/// A mesh with f64 positions.
pub(crate) fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> TriMesh {
    let (positions, triangles) = (Positions::F64(positions.to_vec()), triangles.to_vec());
    TriMesh { positions, normals: None, triangles, ..TriMesh::default() }
}

/// A mesh whose vertices nobody asks the place of: on a curve of which no three points are on a line.
pub(crate) fn graph(vertices: u32, triangles: &[[u32; 3]]) -> TriMesh {
    let curve = |t: f64| [t, t * t, t * t * t];
    mesh(&(0..vertices).map(|t| curve(t.into())).collect::<Vec<_>>(), triangles)
}

/// The positions of a mesh of this kit.
pub(crate) fn positions(mesh: &mut TriMesh) -> &mut Vec<[f64; 3]> {
    match &mut mesh.positions {
        Positions::F64(positions) => positions,
        Positions::F32(_) => unreachable!("the kit uses f64"),
    }
}

/// The same mesh with each coordinate changed.
pub(crate) fn moved(mesh: &TriMesh, by: impl Fn(f64) -> f64) -> TriMesh {
    let mut mesh = mesh.clone();
    positions(&mut mesh).iter_mut().flatten().for_each(|c| *c = by(*c));
    mesh
}

/// Four triangles around a corner of the unit cube.
pub(crate) fn tetrahedron() -> TriMesh {
    mesh(
        &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    )
}

/// The unit cube, its vertices at the bits x, y, z of their numbers.
pub(crate) fn cube() -> TriMesh {
    let corner = |k: u32| array::from_fn(|axis| f64::from(k >> axis & 1));
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    mesh(&(0..8).map(corner).collect::<Vec<_>>(), triangles.as_flattened())
}

/// A strip of `n` quads whose ends are joined, after half a turn if it is a Möbius strip.
pub(crate) fn strip(n: u32, is_moebius: bool) -> TriMesh {
    let triangles: Vec<_> = (0..n)
        .flat_map(|i| {
            let (low, high) = (2 * i, 2 * i + 1);
            let [next_low, next_high] = match (i + 1 == n, is_moebius) {
                (true, true) => [1, 0],
                (true, false) => [0, 1],
                (false, _) => [low + 2, high + 2],
            };
            [[low, next_low, high], [high, next_low, next_high]]
        })
        .collect();
    graph(2 * n, &triangles)
}

/// A torus of `n` by `n` quads around the z axis, radii 2 and 1.
pub(crate) fn torus(n: u32) -> TriMesh {
    let angle = |i: u32| f64::from(i) / f64::from(n) * std::f64::consts::TAU;
    let place = |i: u32, j: u32| {
        let ring = 2.0 + angle(j).cos();
        [ring * angle(i).cos(), ring * angle(i).sin(), angle(j).sin()]
    };
    let name = |i: u32, j: u32| i % n * n + j % n;
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let quad = |(i, j)| {
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    mesh(
        &cells.clone().map(|(i, j)| place(i, j)).collect::<Vec<_>>(),
        &cells.flat_map(quad).collect::<Vec<_>>(),
    )
}

/// The unit sphere: an octahedron of which each triangle is cut in four `splits` times.
pub(crate) fn sphere(splits: u32) -> TriMesh {
    let mut all: Vec<[f64; 3]> = vec![];
    for axis in 0..3 {
        for side in [1.0, -1.0] {
            all.push(array::from_fn(|k| if k == axis { side } else { 0.0 }));
        }
    }
    let mut triangles = vec![];
    for [x, y, z] in (0..8).map(|k: u32| array::from_fn(|axis| 2 * axis as u32 + (k >> axis & 1))) {
        // Each mirror turns the winding over.
        let is_mirrored = (x + y + z) % 2 == 1;
        triangles.push(if is_mirrored { [x, z, y] } else { [x, y, z] });
    }
    for _ in 0..splits {
        let mut between = BTreeMap::new();
        let mut halfway = |a: u32, b: u32| {
            *between.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let sum: [f64; 3] = array::from_fn(|k| all[a as usize][k] + all[b as usize][k]);
                let length = sum.iter().map(|c| c * c).sum::<f64>().sqrt();
                all.push(sum.map(|c| c / length));
                all.len() as u32 - 1
            })
        };
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let [ab, bc, ca] = [halfway(a, b), halfway(b, c), halfway(c, a)];
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    mesh(&all, &triangles)
}

/// The triangles with vertices of their own, as STL has them.
pub(crate) fn exploded(whole: &TriMesh) -> TriMesh {
    let corners = whole.triangles.iter().flat_map(|&triangle| whole.corners(triangle));
    let triangles: Vec<_> =
        (0..whole.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    mesh(&corners.collect::<Vec<_>>(), &triangles)
}

/// A job on so many threads.
pub(crate) fn threads(count: usize) -> Job {
    let count = NonZeroUsize::new(count).expect("at least one");
    Job { threads: Threads::new(count).expect("threads"), ..Job::default() }
}

/// Numbers that look like chance and are always the same (splitmix64).
pub(crate) fn chance(seed: &mut u64) -> u64 {
    *seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*seed ^ *seed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
