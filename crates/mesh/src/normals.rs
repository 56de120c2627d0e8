//! Vertex normals made from the triangles around each vertex.

use crate::{TriMesh, adjacency::Stars};
use isokit_geom::vector::{Vector, dot, length, normal};
use isokit_job::{Job, Stopped, in_chunks};

/// Gives each vertex the mean of the normals of its triangles, each weighted by its area.
///
/// Every normal has length 1. Where the mean says nothing, because the triangles cancel out or have no area,
/// a vertex gets the normal of the first of its largest triangles; where none has an area, or there is
/// none, +z.
///
/// # Errors
///
/// If the job is cancelled or allows less memory than the neighbours take; the mesh is then as it was.
pub fn area_normals(mesh: &mut TriMesh, job: &Job) -> Result<(), Stopped> {
    let vertices = mesh.positions.len();
    job.progress.begin("normals", 2 * vertices as u64);
    let stars = Stars::new(vertices, &mesh.triangles, job)?;
    let around = |vertex: usize| {
        let star = stars.of(vertex).iter();
        star.map(|&t| normal(mesh.corners(mesh.triangles[t as usize])))
    };
    let chunks = in_chunks(vertices, job, |range| {
        range.map(|vertex| mean(around(vertex))).collect::<Vec<_>>()
    })?;
    mesh.normals = Some(chunks.concat());
    Ok(())
}

/// The direction of the sum of some normals.
fn mean(normals: impl Iterator<Item = Vector> + Clone) -> [f32; 3] {
    /// Below this part of its terms a sum is rounding, not a direction.
    const NOISE: f64 = 1e-12;
    let finite =
        normals.map(|normal| (length(normal), normal)).filter(|(area, _)| area.is_finite());
    let (mut sum, mut areas) = ([0.0; 3], 0.0);
    let mut largest = (0.0, [0.0, 0.0, 1.0]);
    for (area, normal) in finite {
        sum = std::array::from_fn(|k| sum[k] + normal[k]);
        areas += area;
        if area > largest.0 {
            largest = (area, normal);
        }
    }
    let direction = if length(sum) > NOISE * areas { sum } else { largest.1 };
    let length = dot(direction, direction).sqrt();
    direction.map(|c| (c / length) as f32)
}

#[cfg(test)]
mod tests {
    use super::area_normals;
    use crate::{
        TriMesh,
        kit::{cube, mesh, moved, sphere, threads},
    };
    use isokit_job::{Cancelled, Job, Stopped};

    fn normals(mut mesh: TriMesh) -> Vec<[f32; 3]> {
        area_normals(&mut mesh, &Job::default()).unwrap();
        mesh.normals.unwrap()
    }

    #[track_caller]
    fn assert_near(found: [f32; 3], expected: [f64; 3], tolerance: f64) {
        let is_near = (0..3).all(|k| (f64::from(found[k]) - expected[k]).abs() <= tolerance);
        assert!(is_near, "{found:?} is not {expected:?}");
    }

    #[test]
    fn normals_of_a_sphere_point_away_from_its_centre() {
        let sphere = sphere(5);
        for (normal, position) in normals(sphere.clone()).into_iter().zip(sphere.positions.iter()) {
            assert_near(normal, position, 1e-2);
            let square: f32 = normal.iter().map(|c| c * c).sum();
            assert!((square - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_larger_triangle_has_the_greater_say() {
        // Of two faces at a right angle, one is twice as large.
        let corner = mesh(
            &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]],
            &[[0, 1, 2], [0, 3, 1]],
        );
        let (z, y) = (2.0 / 5_f64.sqrt(), 1.0 / 5_f64.sqrt());
        assert_near(normals(corner)[0], [0.0, y, z], 1e-7);
    }

    #[test]
    fn a_normal_is_never_zero_and_never_nan() {
        let both_sides = [[0, 1, 2], [2, 1, 0]];
        let places = [[0.0; 3], [0.3, 0.0, 0.0], [0.1, 0.7, 0.0], [f64::NAN; 3], [5.0; 3]];
        let cancelled = normals(mesh(&places, &both_sides));
        assert_eq!(cancelled, [[0.0, 0.0, 1.0]; 5]);
        let flat = mesh(&[[0.0; 3], [1.0; 3], [2.0; 3]], &[[0, 1, 2], [0, 1, 7], [1, 1, 0]]);
        assert_eq!(normals(flat), [[0.0, 0.0, 1.0]; 3]);
        // Where a larger one joins the two, it decides.
        let mut third = mesh(&places, &both_sides);
        third.triangles.insert(0, [0, 2, 1]);
        assert_eq!(normals(third)[0], [0.0, 0.0, -1.0]);
    }

    #[test]
    fn scale_does_not_matter() {
        for scale in [2_f64.powi(-140), 2_f64.powi(120)] {
            assert_eq!(normals(moved(&sphere(1), |x| x * scale)), normals(sphere(1)));
        }
    }

    #[test]
    fn any_number_of_threads_makes_the_same_normals() {
        let made = |count: usize| {
            let mut sphere = sphere(6);
            area_normals(&mut sphere, &threads(count)).unwrap();
            sphere
        };
        assert_eq!(made(1), made(3));
    }

    #[test]
    fn a_cancelled_job_leaves_the_mesh_as_it_was() {
        let (mut mesh, job) = (cube(), Job::default());
        job.cancel.cancel();
        assert_eq!(area_normals(&mut mesh, &job), Err(Stopped::Cancelled(Cancelled)));
        assert_eq!(mesh, cube());
    }
}
