//! Whether a mesh is a surface, and which.
//!
//! Three checkers that people use mean three things by "manifold", so everything is counted apart and the
//! verdict names what it lacks. Everything is decided around vertices: the triangles around a vertex know
//! all of its edges. Most vertices of most meshes are ordinary, amid one closed fan of triangles that are
//! wound alike; the first look finds these, and joins triangles to pieces as it goes. Only the others are
//! looked at a second time, when the pieces are known, to tell what is wrong with them, and with which.
//!
//! Triangles are left out of all but their own counter if they name a missing vertex, and out of all but
//! `degenerate_triangles` if they name a vertex twice: these have no inside and share no edge, and the
//! surface is as closed without them.
//!
//! A torus of 4 000 000 triangles takes 0.25 s on 2 cores and 92 MB beside the mesh (0.40 s on one; 1.1 s if
//! its vertices and triangles are shuffled; 1.4 s if every triangle has vertices, and so a piece, of its
//! own; x86-64 Xeon, 2 threads, November 2026). Sorting all edges as 64-bit keys, which finds neither fans
//! nor pieces, took 0.25 s by itself.

use crate::{
    Component, Measure, TriMesh,
    adjacency::{Spoke, Stars, edges, is_sound, others, spokes},
    chunks::Tallies,
    components::Pieces,
    measure::{Part, finite_bounds, measure_parts},
    quality::is_degenerate,
};
use isokit_job::{CHUNK, Cancelled, Job, Stopped, in_chunks};

/// What can be said of a mesh as a surface. An empty mesh is a surface in every respect.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// Vertices, used or not.
    pub vertices: u64,
    /// Triangles, sound or not.
    pub triangles: u64,
    /// Edges of sound triangles, each counted once.
    pub edges: u64,
    /// Vertices in no sound triangle.
    pub unused_vertices: u64,
    /// Vertices with a coordinate that is NaN or infinite. Their triangles are left out of area, volume
    /// and bounds.
    pub non_finite_vertices: u64,
    /// Triangles that name a vertex that is not there.
    pub out_of_range_triangles: u64,
    /// Triangles without area: a vertex named twice, or corners exactly on one line.
    pub degenerate_triangles: u64,
    /// Triangles whose three vertices, in any order, an earlier triangle has too.
    pub duplicate_triangles: u64,
    /// Edges of one triangle only.
    pub boundary_edges: u64,
    /// Edges of more than two triangles.
    pub nonmanifold_edges: u64,
    /// Vertices around which the triangles are not one fan, open or closed: those in which surfaces touch,
    /// and the ends of edges of more than two triangles.
    pub nonmanifold_vertices: u64,
    /// Edges that triangles pass in one direction at least twice more often than in the other: two
    /// neighbours wound against one another, if the edge has but two.
    pub inconsistent_edges: u64,
    /// The pieces, in the order of their first triangles.
    pub components: Vec<Component>,
    /// Area, volume and box of the whole.
    pub measure: Measure,
}

/// Finds out everything about a mesh that [`Topology`] tells.
///
/// # Errors
///
/// If the job is cancelled or allows less memory than the neighbours take: 8 bytes per vertex, 16 per
/// triangle.
pub fn topology(mesh: &TriMesh, job: &Job) -> Result<Topology, Stopped> {
    let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
    job.progress.begin("check", 4 * vertices as u64 + 2 * triangles as u64);
    let stars = Stars::new(vertices, &mesh.triangles, job)?;
    // `Stars` numbers triangles in 32 bits, or refuses.
    let pieces = Pieces::new(triangles as u32);
    let others = first_look(mesh, &stars, &pieces, job)?;
    let (labels, count) = pieces.labels(|t| is_sound(mesh.triangles[t], vertices));
    let looks = second_look(mesh, &stars, &others, &labels, job)?;
    drop((stars, others));

    let (bounds, non_finite_vertices) = finite_bounds(mesh, job)?;
    let parts = measure_parts(mesh, bounds, count, |t| labels[t], job)?;
    let (out_of_range_triangles, degenerate_triangles) = without_area(mesh, job)?;

    let sum = |counter: fn(&Look) -> u64| looks.iter().map(counter).sum::<u64>();
    let mut topology = Topology {
        vertices: vertices as u64,
        triangles: triangles as u64,
        unused_vertices: sum(|look| look.unused_vertices),
        non_finite_vertices,
        out_of_range_triangles,
        degenerate_triangles,
        duplicate_triangles: sum(|look| look.duplicate_triangles),
        nonmanifold_vertices: sum(|look| look.nonmanifold_vertices),
        components: components(&labels, looks, &parts),
        ..Topology::default()
    };
    for component in &topology.components {
        topology.edges += component.edges;
        topology.boundary_edges += component.boundary_edges;
        topology.nonmanifold_edges += component.nonmanifold_edges;
        topology.inconsistent_edges += component.inconsistent_edges;
    }
    let mut whole = Part::default();
    parts.into_iter().for_each(|part| whole.join(part));
    topology.measure = Measure { area: whole.area.total(), volume: whole.volume.total(), bounds };
    Ok(topology)
}

/// Joins triangles that share an edge. Returns, for each chunk of vertices, those that are not ordinary.
fn first_look(
    mesh: &TriMesh,
    stars: &Stars,
    pieces: &Pieces,
    job: &Job,
) -> Result<Vec<Vec<u32>>, Cancelled> {
    in_chunks(mesh.positions.len(), job, |range| {
        let mut others = vec![];
        let mut around = vec![];
        for vertex in range {
            let star = stars.of(vertex);
            if unite_closed_fan(&mesh.triangles, star, vertex as u32, pieces) {
                continue;
            }
            others.push(vertex as u32);
            spokes(&mesh.triangles, star, vertex, &mut around);
            for edge in edges(&around).filter(|edge| edge[0].to > vertex as u32) {
                for pair in edge.windows(2) {
                    pieces.unite(star[pair[0].place as usize], star[pair[1].place as usize]);
                }
            }
        }
        others
    })
}

/// Walks once around a vertex, joining each triangle to the next. False if that is not possible: then
/// the vertex is not ordinary, and what was joined shares an edge all the same.
#[inline]
fn unite_closed_fan(triangles: &[[u32; 3]], star: &[u32], vertex: u32, pieces: &Pieces) -> bool {
    /// More triangles than this around a vertex are rare, and searching among them would be slow.
    const MOST: usize = 16;
    let n = star.len();
    if !(3..=MOST).contains(&n) {
        return false;
    }
    let mut sides = [[0; 2]; MOST];
    for (sides, &t) in sides.iter_mut().zip(star) {
        *sides = others(triangles[t as usize], vertex);
    }
    let sides = &sides[..n];
    // The walk always goes on in the first triangle that begins where the last one ended. If it visits
    // as many as there are before it is back at the first, no two begin at the same place.
    let mut here = 0;
    for step in 1..=n {
        let end = sides[here][1];
        let Some(next) = sides.iter().position(|side| side[0] == end) else { return false };
        if (next == 0) != (step == n) {
            return false;
        }
        // Once for each edge: from its lesser end.
        if end > vertex {
            pieces.unite(star[here], star[next]);
        }
        here = next;
    }
    true
}

/// What is found in a chunk of vertices.
struct Look {
    unused_vertices: u64,
    duplicate_triangles: u64,
    nonmanifold_vertices: u64,
    pieces: Tallies<Tally>,
}

/// What is found of a piece, each edge at its lesser end.
#[derive(Default)]
struct Tally {
    vertices: u64,
    boundary_edges: u64,
    nonmanifold_edges: u64,
    nonmanifold_vertices: u64,
    inconsistent_edges: u64,
    /// How often triangles use the non-manifold edges.
    overuses: u64,
}

/// Counts vertices, and what is wrong with those that are not ordinary.
fn second_look(
    mesh: &TriMesh,
    stars: &Stars,
    others: &[Vec<u32>],
    labels: &[u32],
    job: &Job,
) -> Result<Vec<Look>, Cancelled> {
    in_chunks(mesh.positions.len(), job, |range| {
        let mut look = Look {
            unused_vertices: 0,
            duplicate_triangles: 0,
            nonmanifold_vertices: 0,
            pieces: Tallies::new(),
        };
        let mut others = others[range.start / CHUNK].iter().copied().peekable();
        let mut around = vec![];
        for vertex in range {
            let star = stars.of(vertex);
            if others.next_if_eq(&(vertex as u32)).is_none() {
                look.pieces.of(labels[star[0] as usize]).vertices += 1;
            } else if star.is_empty() {
                look.unused_vertices += 1;
            } else {
                spokes(&mesh.triangles, star, vertex, &mut around);
                look.at(vertex as u32, &around, |spoke| {
                    labels[star[spoke.place as usize] as usize]
                });
                look.duplicate_triangles += duplicates(&mesh.triangles, star, vertex as u32);
            }
        }
        look
    })
}

impl Look {
    /// Counts a vertex that may have anything wrong with it, and the edges to greater ones.
    fn at(&mut self, vertex: u32, spokes: &[Spoke], piece: impl Fn(&Spoke) -> u32) {
        // The piece of each fan and, once more, that of each edge with too many triangles: so a piece
        // that is here twice is not manifold here.
        let mut here: Vec<u32> = first_of_fans(spokes).map(&piece).collect();
        for edge in edges(spokes) {
            let label = piece(&edge[0]);
            if edge.len() > 2 {
                here.push(label);
            }
            if edge[0].to > vertex {
                let leaving = edge.iter().filter(|spoke| spoke.leaves).count();
                let tally = self.pieces.of(label);
                tally.boundary_edges += u64::from(edge.len() == 1);
                tally.inconsistent_edges += u64::from(leaving.abs_diff(edge.len() - leaving) > 1);
                if edge.len() > 2 {
                    tally.nonmanifold_edges += 1;
                    tally.overuses += edge.len() as u64;
                }
            }
        }
        self.nonmanifold_vertices += u64::from(here.len() > 1);
        here.sort_unstable();
        for same in here.chunk_by(|a, b| a == b) {
            let tally = self.pieces.of(same[0]);
            tally.vertices += 1;
            tally.nonmanifold_vertices += u64::from(same.len() > 1);
        }
    }
}

/// One side of each fan: of each set of triangles around a vertex that hang together by edges there.
fn first_of_fans(spokes: &[Spoke]) -> impl Iterator<Item = &Spoke> {
    let fans = Pieces::new(spokes.len() as u32 / 2);
    for edge in edges(spokes) {
        edge.windows(2).for_each(|pair| fans.unite(pair[0].place, pair[1].place));
    }
    spokes.iter().filter(move |spoke| spoke.leaves && fans.is_first(spoke.place))
}

/// How many triangles around their least vertex repeat another.
fn duplicates(triangles: &[[u32; 3]], star: &[u32], vertex: u32) -> u64 {
    let sides = star.iter().map(|&t| others(triangles[t as usize], vertex));
    let mut sides: Vec<[u32; 2]> = sides
        .filter(|&[a, b]| a > vertex && b > vertex)
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    sides.sort_unstable();
    sides.windows(2).filter(|pair| pair[0] == pair[1]).count() as u64
}

/// How many triangles name a missing vertex, and how many of the others have no area.
fn without_area(mesh: &TriMesh, job: &Job) -> Result<(u64, u64), Cancelled> {
    let vertices = mesh.positions.len();
    let counts = in_chunks(mesh.triangles.len(), job, |range| {
        let (mut missing, mut degenerate) = (0, 0);
        for &triangle in &mesh.triangles[range] {
            if triangle.iter().any(|&vertex| vertex as usize >= vertices) {
                missing += 1;
            } else if !is_sound(triangle, vertices) || is_degenerate(mesh.corners(triangle)) {
                degenerate += 1;
            }
        }
        (missing, degenerate)
    })?;
    Ok(counts.into_iter().fold((0, 0), |sum, count| (sum.0 + count.0, sum.1 + count.1)))
}

/// Puts together what was found of each piece.
fn components(labels: &[u32], looks: Vec<Look>, parts: &[Part]) -> Vec<Component> {
    let of_part = |part: &Part| Component {
        area: part.area.total(),
        volume: part.volume.total(),
        ..Component::default()
    };
    let mut components: Vec<Component> = parts.iter().map(of_part).collect();
    for &label in labels {
        // A triangle in no piece has a label beyond all of them.
        if let Some(component) = components.get_mut(label as usize) {
            component.triangles += 1;
        }
    }
    // All sides of all triangles are 3 per triangle. Those of edges with one triangle or with more than
    // two are counted here; the others lie in pairs.
    components.iter_mut().for_each(|component| component.edges = 3 * component.triangles);
    for (label, tally) in looks.into_iter().flat_map(|look| look.pieces.each()) {
        let component = &mut components[label];
        component.vertices += tally.vertices;
        component.boundary_edges += tally.boundary_edges;
        component.nonmanifold_edges += tally.nonmanifold_edges;
        component.nonmanifold_vertices += tally.nonmanifold_vertices;
        component.inconsistent_edges += tally.inconsistent_edges;
        component.edges -= tally.boundary_edges + tally.overuses;
    }
    for component in &mut components {
        component.edges =
            component.edges / 2 + component.boundary_edges + component.nonmanifold_edges;
    }
    components
}

#[cfg(test)]
mod tests;
