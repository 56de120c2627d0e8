//! Where the gradient of a distance leads, and how it turns.

use super::At;
use crate::{
    MeshSolid,
    distance::{Part, near},
};
use isokit_geom::vector::{cross, dot, length, sub};
use isokit_lanes::Facet;

/// Nearer than this to the surface, where the mesh is about 1 large, a point is taken to be on it: what leads away from the
/// nearest point is rounding then, and the normals of faces are not.
const ON: f64 = 1e-12;

/// How far beside a point of an edge it is asked what lies on both sides of a face, as a part of the face.
const ASIDE: f64 = 1.0 / 1024.0;

/// How often another place is tried if edges go through that one too.
const TRIES: u32 = 8;

/// The sine of an angle that is none.
const ALIKE: f64 = 1e-7;

/// The gradient of the signed distance, one long: towards what is inside; 0 where there is none.
pub(super) fn inward(solid: &MeshSolid, at: &At) -> [f64; 3] {
    let distance = at.near.squared.sqrt();
    if distance <= ON
        && let Some(normal) = normal_inward(solid, at.point)
    {
        return normal;
    }
    if distance == 0.0 {
        return [0.0; 3];
    }
    let sign = if at.value < 0.0 { -1.0 } else { 1.0 };
    at.near.away.map(|c| sign * c / distance)
}

/// Of a face that a point is on, the normal that leads inside, if there is a face.
///
/// Which side that is the winding number says on both sides of the face: with all others as they are, and with it as it is
/// seen from above and from below. The sign of the distance says nothing, for it may be rounding.
fn normal_inward(solid: &MeshSolid, point: [f64; 3]) -> Option<[f64; 3]> {
    let facets = solid.bvh().facets();
    let weight = |n: u32| solid.windings().weight(n);
    let touching = touching(solid, point);
    let faces = || touching.iter().copied().filter(|&n| facets[n as usize].has_area);
    // One that counts, if there is one.
    let face = faces().find(|&n| weight(n) != 0.0).or_else(|| faces().next())?;
    let facet = &facets[face as usize];
    let is_turned = weight(face) < 0.0;
    let is_turned = match within(solid, point, facet) {
        Some((place, here)) => {
            let alike = |n: u32| dot(facets[n as usize].normal, facet.normal).signum();
            let count = here.iter().map(|&n| weight(n) * alike(n)).sum();
            let [above, below] = solid.sides(place, &here, count);
            if above == below { is_turned } else { above }
        }
        None => is_turned,
    };
    Some(if is_turned { facet.normal } else { facet.normal.map(|c| -c) })
}

/// A point of a face, and the faces that it is on. It is the one that is asked for unless that is on an edge of one of them, which
/// others would share; then one beside it that is not.
fn within(solid: &MeshSolid, point: [f64; 3], facet: &Facet) -> Option<([f64; 3], Vec<u32>)> {
    let facets = solid.bvh().facets();
    let places = (0..TRIES).map(|n| {
        let n = f64::from(n);
        let [first, third] = facet.edges;
        // Some place between the edges of the face, another one with each step.
        let aim = [0, 1, 2]
            .map(|k| facet.corner[k] + (0.2 + 0.05 * n) * first[k] + (0.45 - 0.04 * n) * third[k]);
        [0, 1, 2].map(|k| point[k] + n * ASIDE * (aim[k] - point[k]))
    });
    places.into_iter().find_map(|place| {
        let mut here = touching(solid, place);
        here.retain(|&n| facets[n as usize].has_area);
        let is_clear = |&n: &u32| edges_at(place, &facets[n as usize]) == [None; 3];
        here.iter().all(is_clear).then_some((place, here))
    })
}

/// All facets that a point is on, in their order.
fn touching(solid: &MeshSolid, point: [f64; 3]) -> Vec<u32> {
    let mut found = vec![];
    solid.bvh().visit(point, ON * ON, |n| {
        if near(point, &solid.bvh().facets()[n as usize]).squared <= ON * ON {
            found.push(n);
        }
        ON * ON
    });
    found.sort_unstable();
    found
}

/// The second derivatives of the signed distance in the world.
///
/// Of the distance d from a point they are (1 − u uᵀ)/d, with u one long away from it. Where the nearest point goes along
/// with the place, on an edge along e, they lack e eᵀ/d; where it goes any way, on a face, they are 0.
pub(super) fn bends(solid: &MeshSolid, at: &At) -> [[f64; 3]; 3] {
    let distance = at.near.squared.sqrt();
    if at.near.part == Part::Face || distance <= ON {
        return [[0.0; 3]; 3];
    }
    let u = at.near.away.map(|c| c / distance);
    let along = match free(solid, at, u) {
        Free::Nowhere => [0.0; 3],
        Free::Along(edge) => edge,
        Free::Anywhere => return [[0.0; 3]; 3],
    };
    let sign = if at.value < 0.0 { -1.0 } else { 1.0 };
    let scale = sign / (distance * solid.place().scale());
    [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            let own = if i == j { 1.0 } else { 0.0 };
            scale * (own - u[i] * u[j] - along[i] * along[j])
        })
    })
}

/// Which ways the nearest point can go.
enum Free {
    Nowhere,
    Along([f64; 3]),
    Anywhere,
}

/// Along edges that it is on and that are at right angles to what leads away from it. Of an edge in a plane, which is none of
/// the surface's, there are two such ways; of a corner in an edge that goes on straight there is one.
fn free(solid: &MeshSolid, at: &At, u: [f64; 3]) -> Free {
    let facet = &solid.bvh().facets()[at.facet as usize];
    let [_, first, third] = at.near.shares();
    // Not the point less what leads there, which from far away is rounded too much.
    let nearest = [0, 1, 2]
        .map(|k| facet.corner[k] + (first * facet.edges[0][k] + third * facet.edges[1][k]));
    let mut free = match at.near.part {
        Part::Edge(edge) => Free::Along(edge),
        Part::Face | Part::Corner => Free::Nowhere,
    };
    for n in touching(solid, nearest) {
        let facet = &solid.bvh().facets()[n as usize];
        if facet.has_area && length(cross(u, facet.normal)) < ALIKE {
            return Free::Anywhere;
        }
        for edge in edges_at(nearest, facet).into_iter().flatten() {
            if dot(edge, u).abs() >= ALIKE {
                continue;
            }
            free = match free {
                Free::Nowhere => Free::Along(edge),
                Free::Along(other) if length(cross(edge, other)) < ALIKE => free,
                Free::Along(_) | Free::Anywhere => return Free::Anywhere,
            };
        }
    }
    free
}

/// The directions of the edges of a facet that a point is on, one long.
fn edges_at(point: [f64; 3], facet: &Facet) -> [Option<[f64; 3]>; 3] {
    let [first, third] = facet.edges;
    let from = sub(point, facet.corner);
    let across = sub(third, first);
    let sides = [(from, first), (from, third), (sub(from, first), across)];
    let [a, b, c] = [0, 1, 2].map(|n| {
        let ((from, edge), share) = (sides[n], facet.shares[n]);
        let along = (dot(from, edge) * share).clamp(0.0, 1.0);
        let beside = [0, 1, 2].map(|k| from[k] - along * edge[k]);
        (share > 0.0 && dot(beside, beside) <= ON * ON).then(|| edge.map(|c| c * share.sqrt()))
    });
    [a, b, c]
}
