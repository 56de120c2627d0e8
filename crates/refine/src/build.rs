//! The mesh that cut edges make.
//!
//! Vertices keep their numbers; new ones follow in the order of their edges. What a triangle becomes takes
//! its place, in order.

use crate::{
    RefineError,
    edges::Edges,
    exact::in_chunks,
    ground::Ground,
    split::{Corner, Split, WHOLE},
};
use isokit_job::{CHUNK, Cancelled, Job};
use isokit_lanes::exactly;
use isokit_mesh::{Counts, Positions, TriMesh};
use rayon::prelude::*;

/// Cuts a mesh. With it come the numbers of the new vertices by their edges.
pub(crate) fn build(
    (mesh, edges): (&TriMesh, &Edges),
    split: &Split<'_>,
    ground: &Ground<'_>,
    job: &Job,
) -> Result<(TriMesh, Vec<u32>), RefineError> {
    const WHAT: &str = "refined surface";
    let (job, states) = (&job.unwatched(), &split.states[..]);
    let sizes = in_chunks(mesh.triangles.len(), job, |range| {
        let cuts = |t: usize| edges.sides[t].iter().filter(|&&e| states[e as usize] != WHOLE);
        range.map(|t| 1 + cuts(t).count()).sum::<usize>()
    })?;
    let held = mesh.positions.len();
    let new = states.iter().filter(|&&state| state != WHOLE).count();
    let counts =
        Counts { vertices: (held + new) as u64, triangles: sizes.iter().sum::<usize>() as u64 };
    let Counts { vertices, triangles } = counts;
    if vertices.max(triangles) > u64::from(u32::MAX) {
        return Err(RefineError::TooLarge { vertices, triangles });
    }
    let bytes = counts.bytes(mesh.positions.precision(), mesh.normals.is_some());
    job.limits.probe(WHAT, bytes, 1)?;

    let mut numbers = job.limits.vec(WHAT, Some(states.len() as u64))?;
    let mut next = held as u32;
    for &state in states {
        numbers.push(next);
        next += u32::from(state != WHOLE);
    }
    let mut built = vec![[0_u32; 3]; triangles as usize];
    let (mut parts, mut rest) = (vec![], &mut built[..]);
    for &size in &sizes {
        let (part, after) = rest.split_at_mut(size);
        parts.push(part);
        rest = after;
    }
    let fill = |(n, part): (usize, &mut [[u32; 3]])| {
        job.check()?;
        let range = n * CHUNK..mesh.triangles.len().min((n + 1) * CHUNK);
        let mut out = part.iter_mut();
        let mut put = |triangle| out.by_ref().take(1).for_each(|out| *out = triangle);
        exactly(|| {
            for t in range {
                if split.is_whole(t, states) {
                    put(mesh.triangles[t]);
                    continue;
                }
                let (children, count) = split.children(t, states);
                for child in &children[..count] {
                    put(child.map(|corner| corner.number(&numbers)));
                }
            }
        });
        Ok::<(), Cancelled>(())
    };
    job.threads.run(|| parts.into_par_iter().enumerate().try_for_each(fill))?;

    let cut = || (0..states.len()).filter(|&edge| states[edge] != WHOLE);
    let places = cut().map(|edge| split.place(Corner::Edge(edge as u32), states));
    let positions = match &mesh.positions {
        Positions::F32(old) => {
            let new = places.map(|place| place.map(|c| c as f32));
            Positions::F32(longer(old, new, vertices as usize))
        }
        Positions::F64(old) => Positions::F64(longer(old, places, vertices as usize)),
    };
    let normals = match &mesh.normals {
        None => None,
        Some(old) => {
            let new = in_chunks(states.len(), job, |range| {
                let cut = range.filter(|&edge| states[edge] != WHOLE);
                let normal = |edge: usize| {
                    let place = split.place(Corner::Edge(edge as u32), states);
                    let ends = edges.ends[edge].map(|vertex| old[vertex as usize]);
                    match split.is_along_creases() {
                        true => between(ends),
                        false => normal(place, ends, ground),
                    }
                };
                cut.map(normal).collect::<Vec<_>>()
            })?;
            Some(longer(old, new.into_iter().flatten(), vertices as usize))
        }
    };
    Ok((TriMesh { positions, normals, triangles: built, ..TriMesh::default() }, numbers))
}

/// Some items, and more behind them.
pub(crate) fn longer<T: Copy>(old: &[T], new: impl Iterator<Item = T>, count: usize) -> Vec<T> {
    let mut all = Vec::with_capacity(count);
    all.extend_from_slice(old);
    all.extend(new);
    all
}

/// The normal of the field at a place, or, where it has none, between those of both ends of an edge.
fn normal(place: [f64; 3], ends: [[f32; 3]; 2], ground: &Ground<'_>) -> [f32; 3] {
    let spot = ground.spot(place);
    let field = || ground.ascent(ground.field().slope(spot.ijk).gradient, [false; 3]);
    let ascent = if spot.is_beyond { None } else { field() };
    if let Some(ascent) = ascent {
        return ascent.direction.map(|c| -c as f32);
    }
    between(ends)
}

/// The normal between those of both ends of an edge.
fn between(ends: [[f32; 3]; 2]) -> [f32; 3] {
    let sum: [f64; 3] = std::array::from_fn(|k| f64::from(ends[0][k]) + f64::from(ends[1][k]));
    let length = sum.iter().map(|c| c * c).sum::<f64>().sqrt();
    // Of two that look away from each other, neither is better.
    if length > 1e-3 { sum.map(|c| (c / length) as f32) } else { ends[0] }
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::{
        Isosurface,
        edges::{Edges, NEW},
        ground::Ground,
        split::{Split, WHOLE},
    };
    use isokit_field::{Jet, ScalarField, Slope};
    use isokit_geom::Affine;
    use isokit_job::Job;
    use isokit_mesh::{Positions, Precision, TriMesh, topology};

    /// A field that nobody knows, so that new vertices stay in the middle of their edges.
    struct Unknown;

    impl ScalarField for Unknown {
        fn dims(&self) -> [usize; 3] {
            [9; 3]
        }

        fn index_to_world(&self) -> Affine {
            Affine::IDENTITY
        }

        fn value(&self, _: [f64; 3]) -> f64 {
            f64::NAN
        }

        fn slope(&self, _: [f64; 3]) -> Slope {
            Slope { value: f64::NAN, gradient: [f64::NAN; 3] }
        }

        fn jet(&self, _: [f64; 3]) -> Jet {
            Jet { value: f64::NAN, gradient: [f64::NAN; 3], hessian: [[f64::NAN; 3]; 3] }
        }
    }

    #[test]
    fn whichever_edges_are_chosen_the_mesh_is_closed_and_of_the_same_shape() {
        let corners = vec![[1.0; 3], [5.0, 1.0, 1.0], [1.0, 6.0, 2.0], [2.0, 1.0, 7.0]];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let normals = Some(vec![[0.0, 0.0, 1.0]; 4]);
        let mesh = TriMesh {
            positions: Positions::F32(corners),
            normals,
            triangles,
            ..TriMesh::default()
        };
        let (job, surface) = (Job::default(), Isosurface { field: &Unknown, iso: 0.0 });
        let before = topology(&mesh, &job).unwrap();
        let edges = Edges::new(&mesh, &job).unwrap();
        assert_eq!(edges.ends, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]);
        let ground = Ground::new(surface, Precision::F32);
        for choice in 0..64_u32 {
            let chosen = |edge: usize| choice >> edge & 1 == 1;
            let split = Split::new((&mesh, &edges), &ground, chosen, &job).unwrap();
            let (built, numbers) = build((&mesh, &edges), &split, &ground, &job).unwrap();
            let (after, from) = edges.after(&split, (&built, &numbers), &job).unwrap();
            assert_eq!(after, Edges::new(&built, &job).unwrap(), "{choice:b}");
            for (ends, &old) in after.ends.iter().zip(&from).filter(|(_, old)| **old != NEW) {
                assert_eq!(*ends, edges.ends[old as usize], "{choice:b}");
            }
            let kept = from.iter().filter(|&&old| old != NEW).count() as u32;
            assert_eq!(kept, 6 - choice.count_ones(), "{choice:b}");
            let found = topology(&built, &job).unwrap();
            assert_eq!(found.shortfalls(), [""; 0], "{choice:b}");
            assert_eq!(found.vertices, 4 + u64::from(choice.count_ones()));
            assert_eq!(found.triangles, 4 + 2 * u64::from(choice.count_ones()));
            let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
            assert!(near(found.measure.area, before.measure.area), "{choice:b}");
            assert!(near(found.measure.volume, before.measure.volume), "{choice:b}");
        }
    }

    #[test]
    fn edges_whose_middles_meet_and_one_through_a_vertex_stay_whole() {
        // Two tetrahedra with sides that cross in (2, 2, 0), and one with a corner in the middle of a side of another.
        let corners = vec![
            [3.0, 3.0, 0.0],
            [1.0, 1.0, 0.0],
            [2.0, 1.0, 3.0],
            [1.0, 3.0, 4.0],
            [3.0, 1.0, 0.0],
            [1.0, 3.0, 0.0],
            [2.0, 1.0, -3.0],
            [0.5, 1.0, -4.0],
            [1.5, 1.0, 1.5],
            [1.5, 0.0, 1.5],
            [1.5, 0.0, 0.0],
            [2.5, 0.5, 1.0],
        ];
        let solid = |n: u32| [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|t| t.map(|v| v + n));
        let triangles = [0, 4, 8].into_iter().flat_map(solid).collect();
        let positions = Positions::F32(corners);
        let mesh = TriMesh { positions, triangles, ..TriMesh::default() };
        let (job, surface) = (Job::default(), Isosurface { field: &Unknown, iso: 0.0 });
        let edges = Edges::new(&mesh, &job).unwrap();
        let ground = Ground::new(surface, Precision::F32);
        let split = Split::new((&mesh, &edges), &ground, |_| true, &job).unwrap();
        let whole = (0..edges.len()).filter(|&edge| split.states[edge] == WHOLE);
        let whole: Vec<_> = whole.map(|edge| edges.ends[edge]).collect();
        assert_eq!(whole, [[0, 1], [1, 2], [4, 5]]);
        let built = build((&mesh, &edges), &split, &ground, &job).unwrap().0;
        let mut places: Vec<_> = built.positions.iter().map(|p| p.map(f64::to_bits)).collect();
        places.sort_unstable();
        assert!(places.windows(2).all(|pair| pair[0] != pair[1]));
        assert_eq!(topology(&built, &job).unwrap().shortfalls(), [""; 0]);
    }
}
