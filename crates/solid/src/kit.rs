//! Small meshes for tests, and chance.

use isokit_geom::{Affine, Frame};
use isokit_job::{Job, Threads};
use isokit_mesh::{Positions, TriMesh};
use isokit_volume::Grid;
use std::{array, f64::consts::TAU, num::NonZeroUsize};

pub(crate) fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> TriMesh {
    TriMesh {
        positions: Positions::F64(positions.to_vec()),
        triangles: triangles.to_vec(),
        ..TriMesh::default()
    }
}

/// The cube from −1 to 1, its vertices at the bits x, y, z of their numbers.
pub(crate) fn cube() -> TriMesh {
    let corner = |k: u32| array::from_fn(|axis| f64::from(2 * (k >> axis & 1)) - 1.0);
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    mesh(&(0..8).map(corner).collect::<Vec<_>>(), triangles.as_flattened())
}

/// A ball of radius 1 with `2 n` meridians and `n` bands of triangles; the poles are many vertices in one place.
pub(crate) fn ball(n: u32) -> TriMesh {
    let place = |i: u32, j: u32| {
        let (a, b) = (f64::from(i) / f64::from(2 * n) * TAU, f64::from(j) / f64::from(2 * n) * TAU);
        let ring = if j == 0 || j == n { 0.0 } else { b.sin() };
        let [x, y] = if i.is_multiple_of(2 * n) { [1.0, 0.0] } else { [a.cos(), a.sin()] };
        [ring * x, ring * y, -b.cos()]
    };
    let name = |i: u32, j: u32| j * (2 * n + 1) + i;
    let mut triangles = vec![];
    for (i, j) in (0..2 * n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        if j > 0 {
            triangles.push([a, b, c]);
        }
        if j + 1 < n {
            triangles.push([a, c, d]);
        }
    }
    let places: Vec<_> = (0..=n).flat_map(|j| (0..=2 * n).map(move |i| place(i, j))).collect();
    mesh(&places, &triangles)
}

/// The part of a ball that is not above a height.
pub(crate) fn bowl(height: f64) -> TriMesh {
    let mut ball = ball(40);
    let is_kept = |t: &[u32; 3]| ball.corners(*t).iter().all(|c| c[2] <= height);
    let kept = ball.triangles.iter().copied().filter(is_kept).collect();
    ball.triangles = kept;
    ball
}

/// A ball without some of its triangles, others turned or twice there.
pub(crate) fn broken() -> TriMesh {
    let mut mesh = ball(14);
    let mut chance = Chance(11);
    let all = std::mem::take(&mut mesh.triangles);
    for mut triangle in all {
        match chance.below(9) {
            0 => continue,
            1 => triangle.swap(0, 1),
            2 => mesh.triangles.push(triangle),
            _ => {}
        }
        mesh.triangles.push(triangle);
    }
    mesh
}

/// The same mesh with each vertex elsewhere.
pub(crate) fn moved(all: &TriMesh, by: impl Fn([f64; 3]) -> [f64; 3]) -> TriMesh {
    mesh(&all.positions.iter().map(by).collect::<Vec<_>>(), &all.triangles)
}

/// The same mesh, wound the other way.
pub(crate) fn turned(all: &TriMesh) -> TriMesh {
    let mut all = all.clone();
    all.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    all
}

/// A job on so many threads.
pub(crate) fn threads(count: usize) -> Job {
    let count = NonZeroUsize::new(count).expect("at least one");
    Job { threads: Threads::new(count).expect("threads"), ..Job::default() }
}

/// Numbers that look like chance and are always the same (splitmix64).
pub(crate) struct Chance(pub(crate) u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// From 0 to one less.
    pub(crate) fn below(&mut self, n: u32) -> u32 {
        (self.next() % u64::from(n)) as u32
    }

    /// From −1 to 1.
    pub(crate) fn number(&mut self) -> f64 {
        self.next() as f64 / u64::MAX as f64 * 2.0 - 1.0
    }

    pub(crate) fn point(&mut self) -> [f64; 3] {
        array::from_fn(|_| self.number())
    }

    /// Triangles anywhere; some are edges, points, doubled, or in one plane with others.
    pub(crate) fn soup(&mut self, count: usize) -> TriMesh {
        let mut places: Vec<[f64; 3]> = vec![];
        for _ in 0..3 * count {
            let tie = self.point().map(|c| (c * 3.0).round() / 3.0);
            let place = if self.below(2) == 0 { tie } else { self.point() };
            places.push(place);
        }
        let vertices = places.len() as u32;
        let triangle = |_| array::from_fn(|_| self.below(vertices));
        mesh(&places, &(0..count).map(triangle).collect::<Vec<_>>())
    }
}

/// A lattice.
pub(crate) fn grid(dims: [u64; 3], index_to_world: Affine) -> Grid {
    Grid::new(dims, Frame { index_to_world, ..Frame::default() }).unwrap()
}

/// From −1.5 to 1.5 on each axis.
pub(crate) fn around(n: u64) -> Grid {
    let spacing = 3.0 / (n - 1) as f64;
    grid([n; 3], Affine::axis_aligned([spacing; 3], [-1.5; 3]).unwrap())
}

/// A lattice whose steps are at no right angles.
pub(crate) fn oblique() -> Grid {
    let columns = [[0.11, 0.02, 0.0], [-0.03, 0.07, 0.04], [0.01, 0.0, 0.2]];
    grid([23, 37, 18], Affine::new(columns, [-1.2, -1.6, -2.0]).unwrap())
}
