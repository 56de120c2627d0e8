//! Area, enclosed volume and box.
//!
//! The volume is that of the signed tetrahedra from one point to every triangle (the divergence theorem).
//! The point is the centre of the box, so that a mesh far from the origin loses no digits. All sums are
//! compensated and made in an order that does not depend on the number of threads.

use crate::{
    TriMesh,
    adjacency::is_sound,
    chunks::{Sum, Tallies},
};
use isokit_geom::{
    Aabb,
    vector::{dot, length, normal, sub},
};
use isokit_job::{Cancelled, Job, in_chunks};

/// How large a surface is, in the unit of its positions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measure {
    /// Sum of the areas of all triangles.
    pub area: f64,
    /// The volume inside a closed surface that is wound consistently; negative if it is wound inside
    /// out. Means nothing for any other.
    pub volume: f64,
    /// The box around all finite vertices, used or not; none if there are none.
    pub bounds: Option<Aabb>,
}

/// Measures a mesh. Triangles that name a missing vertex or a vertex that is not finite are left out.
///
/// # Errors
///
/// If the job is cancelled.
pub fn measure(mesh: &TriMesh, job: &Job) -> Result<Measure, Cancelled> {
    job.progress.begin("measure", (mesh.positions.len() + mesh.triangles.len()) as u64);
    let (bounds, _) = finite_bounds(mesh, job)?;
    let [whole] = &measure_parts(mesh, bounds, 1, |_| 0, job)?[..] else {
        unreachable!("one part was asked for")
    };
    Ok(Measure { area: whole.area.total(), volume: whole.volume.total(), bounds })
}

/// Area and volume of a part of a mesh.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Part {
    pub(crate) area: Sum,
    pub(crate) volume: Sum,
}

impl Part {
    pub(crate) fn join(&mut self, other: Self) {
        self.area.join(other.area);
        self.volume.join(other.volume);
    }
}

/// The box around the finite vertices, and how many are not finite. Advances by the vertices.
pub(crate) fn finite_bounds(mesh: &TriMesh, job: &Job) -> Result<(Option<Aabb>, u64), Cancelled> {
    let is_finite = |position: &[f64; 3]| position.iter().all(|c| c.is_finite());
    let chunks = in_chunks(mesh.positions.len(), job, |range| {
        let vertices = range.len();
        let mut finite = 0;
        let positions = range.map(|vertex| mesh.positions.get(vertex)).filter(is_finite);
        let bounds = Aabb::around(positions.inspect(|_| finite += 1));
        (bounds, (vertices - finite) as u64)
    })?;
    let boxes = chunks.iter().filter_map(|(bounds, _)| *bounds);
    let bounds = Aabb::around(boxes.flat_map(|bounds| [bounds.min, bounds.max]));
    Ok((bounds, chunks.iter().map(|(_, missing)| missing).sum()))
}

/// Area and volume of each of `parts` parts, `part` naming that of each sound triangle. Advances by the
/// triangles.
pub(crate) fn measure_parts(
    mesh: &TriMesh,
    bounds: Option<Aabb>,
    parts: usize,
    part: impl Fn(usize) -> u32 + Sync,
    job: &Job,
) -> Result<Vec<Part>, Cancelled> {
    let centre = bounds.map_or([0.0; 3], |b| std::array::from_fn(|k| b.min[k].midpoint(b.max[k])));
    let chunks = in_chunks(mesh.triangles.len(), job, |range| {
        let mut tallies = Tallies::<Part>::new();
        for t in range.filter(|&t| is_sound(mesh.triangles[t], mesh.positions.len())) {
            let corners = mesh.corners(mesh.triangles[t]);
            let normal = normal(corners);
            let area = length(normal) / 2.0;
            // The same for all three corners, but for rounding.
            let volume = dot(sub(corners[0], centre), normal) / 6.0;
            if area.is_finite() && volume.is_finite() {
                let tally = tallies.of(part(t));
                tally.area.add(area);
                tally.volume.add(volume);
            }
        }
        tallies
    })?;
    let mut all = vec![Part::default(); parts];
    for (label, tally) in chunks.into_iter().flat_map(Tallies::each) {
        all[label].join(tally);
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::measure;
    use crate::{
        Positions, TriMesh,
        kit::{cube, mesh, moved, sphere, threads},
    };
    use isokit_geom::Aabb;
    use isokit_job::Job;
    use std::f64::consts::PI;

    #[track_caller]
    fn check(mesh: &TriMesh, area: f64, volume: f64, tolerance: f64) {
        let found = measure(mesh, &Job::default()).unwrap();
        let near = |found: f64, expected: f64| (found / expected - 1.0).abs() <= tolerance;
        assert!(near(found.area, area) && near(found.volume, volume), "{found:?}");
    }

    #[test]
    fn a_unit_cube_has_volume_one_and_area_six() {
        check(&cube(), 6.0, 1.0, 0.0);
        let bounds = measure(&cube(), &Job::default()).unwrap().bounds;
        assert_eq!(bounds, Some(Aabb { min: [0.0; 3], max: [1.0; 3] }));
    }

    #[test]
    fn a_finer_sphere_is_nearer_to_the_true_one() {
        for (splits, tolerance) in [(2, 9e-2), (3, 2.4e-2), (4, 6e-3), (5, 1.5e-3)] {
            check(&sphere(splits), 4.0 * PI, 4.0 / 3.0 * PI, tolerance);
        }
    }

    #[test]
    fn a_place_far_from_the_origin_costs_no_digits() {
        let near = measure(&sphere(3), &Job::default()).unwrap();
        // Multiples of 2⁻²⁴ move by 10⁶ without rounding, so both are the same sphere.
        let snapped = moved(&sphere(3), |x| (x * 16_777_216.0).round() / 16_777_216.0);
        let far = moved(&snapped, |x| x + 1e6);
        check(&far, near.area, near.volume, 1e-6);
        let near = measure(&snapped, &Job::default()).unwrap();
        check(&far, near.area, near.volume, 1e-12);
        check(&moved(&cube(), |x| x - 1e6), 6.0, 1.0, 1e-9);
    }

    #[test]
    fn inside_out_is_negative() {
        let mut inside_out = cube();
        inside_out.triangles.iter_mut().for_each(|triangle| triangle.reverse());
        check(&inside_out, 6.0, -1.0, 0.0);
    }

    #[test]
    fn what_is_broken_is_left_out() {
        let mut broken = cube();
        let Positions::F64(positions) = &mut broken.positions else { panic!("kit uses f64") };
        positions.push([f64::NAN, 0.0, 0.0]);
        positions.push([0.0, f64::INFINITY, 0.0]);
        broken.triangles.extend([[0, 1, 8], [9, 0, 1], [0, 1, 10], [u32::MAX, 0, 0], [0, 0, 1]]);
        check(&broken, 6.0, 1.0, 0.0);
    }

    #[test]
    fn nothing_measures_nothing() {
        let nothing = measure(&mesh(&[], &[]), &Job::default()).unwrap();
        assert_eq!((nothing.area, nothing.volume, nothing.bounds), (0.0, 0.0, None));
    }

    #[test]
    fn any_number_of_threads_measures_the_same() {
        let sphere = sphere(6);
        let one = measure(&sphere, &threads(1)).unwrap();
        for count in [2, 3, 7] {
            assert_eq!(measure(&sphere, &threads(count)).unwrap(), one);
        }
    }
}
