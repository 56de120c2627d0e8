//! Which triangles of a mesh count as its surface, and how they are wound.
//!
//! Vertices in exactly the same place are one. Of triangles in the same place that are wound alike one counts; two that are
//! back to back add up to nothing, unless most of the mesh is so, as some programs write surfaces that are to be seen from
//! both sides: then one of each counts. Across edges of two triangles the winding is made the same, piece by piece; of the
//! two ways, the one that has more of the area already. What is then left over of the edges, each added with its
//! direction, is where the surface ends: nothing if it is closed, in whatever way it goes through itself.

use crate::{Flaws, SolidError, Winding};
use isokit_geom::vector::{length, normal};
use isokit_job::{Job, Stopped};
use isokit_mesh::{TriMesh, is_degenerate};
use rayon::prelude::*;

/// A surface that is ready to be asked about.
#[derive(Clone, Debug)]
pub(crate) struct Repaired {
    /// The corners of all triangles.
    pub(crate) triangles: Vec<[[f64; 3]; 3]>,
    /// How often each counts: 1, 0, or −1 if it was turned.
    pub(crate) weights: Vec<f64>,
    /// The edges at which it ends, and how often each counts.
    pub(crate) rim: Vec<([[f64; 3]; 2], f64)>,
    pub(crate) flaws: Flaws,
}

/// Bytes that are needed for a triangle, about.
const BYTES: usize = 900;

pub(crate) fn repaired(
    mesh: &TriMesh,
    winding: Winding,
    job: &Job,
) -> Result<Repaired, SolidError> {
    let count = mesh.triangles.len();
    if count == 0 {
        return Err(SolidError::Empty);
    }
    if count >= 1 << 31 {
        return Err(SolidError::TooMany { count });
    }
    let needed = "distances to the mesh";
    job.limits.allow(needed, Some(count as u64), BYTES).map_err(Stopped::from)?;
    check(mesh)?;
    let triangles: Vec<_> = mesh.triangles.iter().map(|&t| mesh.corners(t)).collect();
    let places = places(mesh, job);
    let named: Vec<[u32; 3]> =
        mesh.triangles.iter().map(|t| t.map(|v| places[v as usize])).collect();
    let mut flaws = Flaws {
        flat: triangles.iter().filter(|&&corners| is_degenerate(corners)).count(),
        ..Flaws::default()
    };
    let mut weights = once(&named, &mut flaws, job);
    job.check().map_err(Stopped::from)?;
    let edges = edges(&named, &weights, job);
    if winding == Winding::Mended {
        flaws.turned = mend(&triangles, &edges, &mut weights);
    }
    let mut rim = vec![];
    for both in edges.chunk_by(|a, b| a.ends == b.ends) {
        let net: f64 = both.iter().map(|edge| edge.way * weights[edge.triangle as usize]).sum();
        if net != 0.0 {
            let one = &both[0];
            let corners = triangles[one.triangle as usize];
            rim.push((one.sides.map(|side| corners[side as usize]), net.abs()));
        }
    }
    flaws.open_edges = rim.len();
    Ok(Repaired { triangles, weights, rim, flaws })
}

fn check(mesh: &TriMesh) -> Result<(), SolidError> {
    let vertices = mesh.positions.len();
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        for &vertex in corners {
            if vertex as usize >= vertices {
                return Err(SolidError::NoVertex { triangle, vertex, vertices });
            }
            let place = mesh.positions.get(vertex as usize);
            if !place.iter().all(|c| c.is_finite()) {
                return Err(SolidError::NotFinite { triangle, vertex, place });
            }
        }
    }
    Ok(())
}

/// A number for each vertex, the same for those in the same place.
fn places(mesh: &TriMesh, job: &Job) -> Vec<u32> {
    // −0 is 0.
    let key = |v: u32| mesh.positions.get(v as usize).map(|c| (c + 0.0).to_bits());
    let mut order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    job.threads.run(|| order.par_sort_unstable_by_key(|&v| (key(v), v)));
    let mut places = vec![0; order.len()];
    for same in order.chunk_by(|&a, &b| key(a) == key(b)) {
        same.iter().for_each(|&v| places[v as usize] = same[0]);
    }
    places
}

/// 1 for each triangle that counts, 0 for others.
fn once(named: &[[u32; 3]], flaws: &mut Flaws, job: &Job) -> Vec<f64> {
    let sorted = |t: u32| {
        let mut corners = named[t as usize];
        corners.sort_unstable();
        corners
    };
    let is_even = |t: u32| {
        let [a, b, c] = named[t as usize];
        (a < b) ^ (b < c) ^ (a < c)
    };
    let mut order: Vec<u32> = (0..named.len() as u32).collect();
    job.threads.run(|| order.par_sort_unstable_by_key(|&t| (sorted(t), t)));
    let mut weights = vec![1.0; named.len()];
    let mut pairs = vec![];
    for same in order.chunk_by(|&a, &b| sorted(a) == sorted(b)).filter(|same| same.len() > 1) {
        let [a, b, c] = sorted(same[0]);
        if a == b || b == c {
            continue; // an edge, which is no side of anything
        }
        let first = same[0];
        let other = same.iter().copied().find(|&t| is_even(t) != is_even(first));
        let kept = 1 + usize::from(other.is_some());
        flaws.doubled += same.len() - kept;
        same.iter().for_each(|&t| weights[t as usize] = 0.0);
        weights[first as usize] = 1.0;
        if let Some(other) = other {
            pairs.push((first, other));
        }
    }
    flaws.back_to_back = 2 * pairs.len();
    let is_two_sided = 2 * flaws.back_to_back > named.len() - flaws.doubled;
    if !is_two_sided {
        pairs.iter().for_each(|&(first, _)| weights[first as usize] = 0.0);
    }
    weights
}

/// An edge of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Ends([u32; 2]);

#[derive(Clone, Copy, Debug)]
struct Edge {
    ends: Ends,
    triangle: u32,
    /// Which corners of the triangle.
    sides: [u8; 2],
    /// 1 from the lesser end to the greater, else −1.
    way: f64,
}

/// The edges of all triangles that count, those with the same ends together.
fn edges(named: &[[u32; 3]], weights: &[f64], job: &Job) -> Vec<Edge> {
    let of = |(t, corners): (usize, &[u32; 3])| {
        let corners = *corners;
        [[0_u8, 1], [1, 2], [2, 0]].map(|sides| {
            let [a, b] = sides.map(|side| corners[side as usize]);
            let way = if a < b { 1.0 } else { -1.0 };
            Edge { ends: Ends([a.min(b), a.max(b)]), triangle: t as u32, sides, way }
        })
    };
    let all = named.iter().enumerate().filter(|(t, _)| weights[*t] != 0.0).flat_map(of);
    let mut all: Vec<Edge> = all.filter(|edge| edge.ends.0[0] != edge.ends.0[1]).collect();
    let key = |edge: &Edge| (edge.ends, edge.triangle, edge.sides);
    job.threads.run(|| all.par_sort_unstable_by_key(key));
    all
}

/// Winds neighbours alike, and says how many triangles were turned for it.
fn mend(triangles: &[[[f64; 3]; 3]], edges: &[Edge], weights: &mut [f64]) -> usize {
    const NONE: u32 = u32::MAX;
    // Up to three neighbours each, and whether they are wound alike.
    let mut beside = vec![[(NONE, true); 3]; triangles.len()];
    let mut is_mended = true;
    for both in edges.chunk_by(|a, b| a.ends == b.ends) {
        if let [a, b] = both {
            let is_alike = a.way != b.way;
            is_mended &= is_alike;
            beside[a.triangle as usize][a.sides[0] as usize] = (b.triangle, is_alike);
            beside[b.triangle as usize][b.sides[0] as usize] = (a.triangle, is_alike);
        }
    }
    if is_mended {
        return 0;
    }
    let mut ways = vec![0.0; triangles.len()];
    let mut turned = 0;
    for start in 0..triangles.len() {
        if ways[start] != 0.0 || weights[start] == 0.0 {
            continue;
        }
        ways[start] = 1.0;
        let (mut piece, mut next) = (vec![start], 0);
        while next < piece.len() {
            let t = piece[next];
            next += 1;
            for (neighbour, is_alike) in beside[t].into_iter().filter(|(n, _)| *n != NONE) {
                let neighbour = neighbour as usize;
                if ways[neighbour] == 0.0 {
                    ways[neighbour] = if is_alike { ways[t] } else { -ways[t] };
                    piece.push(neighbour);
                }
            }
        }
        let more: f64 = piece.iter().map(|&t| ways[t] * length(normal(triangles[t]))).sum();
        let kept = if more >= 0.0 { 1.0 } else { -1.0 };
        for t in piece {
            if ways[t] != kept {
                weights[t] = -1.0;
                turned += 1;
            }
        }
    }
    turned
}
