//! How well shaped triangles are, and which have no shape at all.

use crate::TriMesh;
use isokit_geom::vector::{Vector, dot, length, normal, sub};
use isokit_job::{Cancelled, Job, in_chunks};
use robust::{Coord, orient2d};

/// Whether three points are on one line, or in one place. The answer is exact, not a matter of rounding,
/// for points whose coordinates are finite and, where not 0, within a factor of 10²⁵⁰ of one another.
/// Points with a coordinate that is not finite are on no line.
pub fn is_degenerate(corners: [[f64; 3]; 3]) -> bool {
    let [a, b, c] = corners;
    let (u, v) = (sub(b, a), sub(c, a));
    // On a line all three projections are. One whose area is beyond its rounding error is not.
    let planes = [(0, 1), (1, 2), (2, 0)];
    let is_apart = planes.iter().any(|&(i, j)| {
        let (p, q) = (u[i] * v[j], u[j] * v[i]);
        (p - q).abs() > 2.0 * f64::EPSILON * (p.abs() + q.abs()) + f64::MIN_POSITIVE
    });
    if is_apart || !corners.iter().flatten().all(|c| c.is_finite()) {
        return false;
    }
    let corners = scaled(corners);
    planes.iter().all(|&(i, j)| {
        let [a, b, c] = corners.map(|corner| Coord { x: corner[i], y: corner[j] });
        orient2d(a, b, c) == 0.0
    })
}

/// The same triangle so large that products of its coordinates neither vanish nor overflow.
fn scaled(corners: [Vector; 3]) -> [Vector; 3] {
    let largest = corners.iter().flatten().fold(0.0, |largest: f64, c| largest.max(c.abs()));
    if largest == 0.0 {
        return corners;
    }
    let exponent = 400 - largest.log2().floor() as i32;
    // In two steps, since one power of two need not be a number.
    let (half, rest) = (2_f64.powi(exponent / 2), 2_f64.powi(exponent - exponent / 2));
    corners.map(|corner| corner.map(|c| c * half * rest))
}

/// The shapes of the triangles of a mesh, lengths in the unit of its positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// The least angle of any triangle, in degrees: 0 if one has no area.
    pub least_angle_deg: f64,
    /// The greatest angle of any triangle, in degrees: 180 if one has no area.
    pub greatest_angle_deg: f64,
    /// The least area.
    pub least_area: f64,
    /// The length of the shortest side.
    pub least_edge: f64,
    /// The length of the longest side.
    pub greatest_edge: f64,
    /// How many triangles have a least angle below each of [`LEAST_ANGLES_DEG`](Self::LEAST_ANGLES_DEG)
    /// but not below the one before.
    pub triangles_by_least_angle: [u64; Quality::LEAST_ANGLES_DEG.len()],
}

impl Quality {
    /// Upper ends of the classes of least angles, in degrees. No triangle has a least angle above 60°;
    /// the last end leaves room for rounding.
    pub const LEAST_ANGLES_DEG: [f64; 7] = [1.0, 5.0, 10.0, 20.0, 30.0, 45.0, 61.0];
}

/// Looks at the shapes of all triangles. Those that name a missing vertex or a vertex that is not finite
/// are left out; `None` if that leaves none.
///
/// # Errors
///
/// If the job is cancelled.
pub fn quality(mesh: &TriMesh, job: &Job) -> Result<Option<Quality>, Cancelled> {
    job.progress.begin("quality", mesh.triangles.len() as u64);
    let ends = Quality::LEAST_ANGLES_DEG.map(|angle| 1.0 / angle.to_radians().tan());
    let vertices = mesh.positions.len();
    let chunks = in_chunks(mesh.triangles.len(), job, |range| {
        let present = mesh.triangles[range].iter().copied();
        let present = present.filter(|t| t.iter().all(|&vertex| (vertex as usize) < vertices));
        let mut shapes = Shapes::default();
        present.for_each(|triangle| shapes.add(mesh.corners(triangle), &ends));
        shapes
    })?;
    let all = chunks.into_iter().fold(Shapes::default(), Shapes::join);
    Ok((all.by_least_angle != [0; ENDS]).then(|| all.quality()))
}

const ENDS: usize = Quality::LEAST_ANGLES_DEG.len();

/// Extremes so far. Angles are compared by their cotangents, which fall from ∞ at 0° to −∞ at 180° and
/// cost no arcus function.
#[derive(Clone, Copy)]
struct Shapes {
    greatest_cot: f64,
    least_cot: f64,
    least_area: f64,
    least_square: f64,
    greatest_square: f64,
    by_least_angle: [u64; ENDS],
}

impl Default for Shapes {
    fn default() -> Self {
        Self {
            greatest_cot: f64::NEG_INFINITY,
            least_cot: f64::INFINITY,
            least_area: f64::INFINITY,
            least_square: f64::INFINITY,
            greatest_square: 0.0,
            by_least_angle: [0; ENDS],
        }
    }
}

impl Shapes {
    fn add(&mut self, corners: [Vector; 3], ends: &[f64; ENDS]) {
        let doubled_area = length(normal(corners));
        if !doubled_area.is_finite() {
            return;
        }
        let [a, b, c] = corners;
        let sides = [sub(b, a), sub(c, b), sub(a, c)];
        let (mut greatest, mut least) = (f64::NEG_INFINITY, f64::INFINITY);
        for k in 0..3 {
            let square = dot(sides[k], sides[k]);
            self.least_square = self.least_square.min(square);
            self.greatest_square = self.greatest_square.max(square);
            let cot = -dot(sides[k], sides[(k + 2) % 3]) / doubled_area;
            greatest = greatest.max(cot);
            least = least.min(cot);
        }
        if doubled_area == 0.0 {
            (greatest, least) = (f64::INFINITY, f64::NEG_INFINITY);
        }
        self.greatest_cot = self.greatest_cot.max(greatest);
        self.least_cot = self.least_cot.min(least);
        self.least_area = self.least_area.min(doubled_area / 2.0);
        let class = ends.iter().position(|&end| greatest > end).unwrap_or(ENDS - 1);
        self.by_least_angle[class] += 1;
    }

    fn join(self, other: Self) -> Self {
        Self {
            greatest_cot: self.greatest_cot.max(other.greatest_cot),
            least_cot: self.least_cot.min(other.least_cot),
            least_area: self.least_area.min(other.least_area),
            least_square: self.least_square.min(other.least_square),
            greatest_square: self.greatest_square.max(other.greatest_square),
            by_least_angle: std::array::from_fn(|k| {
                self.by_least_angle[k] + other.by_least_angle[k]
            }),
        }
    }

    fn quality(self) -> Quality {
        Quality {
            least_angle_deg: 1_f64.atan2(self.greatest_cot).to_degrees(),
            greatest_angle_deg: 1_f64.atan2(self.least_cot).to_degrees(),
            least_area: self.least_area,
            least_edge: self.least_square.sqrt(),
            greatest_edge: self.greatest_square.sqrt(),
            triangles_by_least_angle: self.by_least_angle,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Quality, is_degenerate, quality};
    use crate::{
        TriMesh,
        kit::{cube, mesh, positions, sphere, threads},
    };
    use isokit_job::Job;
    use proptest::prelude::*;

    fn of(mesh: &TriMesh) -> Quality {
        quality(mesh, &Job::default()).unwrap().unwrap()
    }

    #[test]
    fn a_cube_is_made_of_halved_squares() {
        let found = of(&cube());
        assert!((found.least_angle_deg - 45.0).abs() < 1e-12);
        assert!((found.greatest_angle_deg - 90.0).abs() < 1e-12);
        assert_eq!((found.least_area, found.least_edge), (0.5, 1.0));
        assert_eq!(found.greatest_edge, 2_f64.sqrt());
        assert_eq!(found.triangles_by_least_angle.iter().sum::<u64>(), 12);
    }

    #[test]
    fn every_triangle_is_in_one_class() {
        assert_eq!(of(&sphere(4)).triangles_by_least_angle.iter().sum::<u64>(), 8 * 4_u64.pow(4));
        let equilateral = mesh(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], &[[0, 1, 2]]);
        assert_eq!(of(&equilateral).triangles_by_least_angle, [0, 0, 0, 0, 0, 0, 1]);
        let sliver = mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1e-9, 0.0]], &[[0, 1, 2]]);
        assert_eq!(of(&sliver).triangles_by_least_angle, [1, 0, 0, 0, 0, 0, 0]);
        assert!((of(&sliver).least_angle_deg / 1e-9_f64.to_degrees() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn no_area_is_no_angle_and_half_a_turn() {
        for triangle in [[0, 0, 1], [0, 1, 2]] {
            let flat = mesh(&[[0.0; 3], [1.0; 3], [3.0; 3]], &[triangle]);
            let found = of(&flat);
            assert_eq!((found.least_angle_deg, found.greatest_angle_deg), (0.0, 180.0));
            assert_eq!(found.least_area, 0.0);
        }
    }

    #[test]
    fn what_is_broken_has_no_shape() {
        let mut broken = cube();
        positions(&mut broken).push([f64::NAN; 3]);
        broken.triangles.extend([[0, 1, 8], [0, 1, 9]]);
        assert_eq!(of(&broken), of(&cube()));
        assert_eq!(quality(&mesh(&[], &[[0, 1, 2]]), &Job::default()), Ok(None));
    }

    #[test]
    fn any_number_of_threads_sees_the_same() {
        let sphere = sphere(6);
        assert_eq!(quality(&sphere, &threads(1)), quality(&sphere, &threads(3)));
    }

    #[test]
    fn one_bit_off_the_line_is_not_on_it() {
        // 0.1, 0.2 and 0.3 are none of them what they say, so these are not on a line; the halves are.
        assert!(!is_degenerate([0.1, 0.2, 0.3].map(|x| [x, 1.0 - x, 0.5])));
        assert!(is_degenerate([0.25, 0.5, 0.75].map(|x| [x, 1.0 - x, 0.5])));
        for scale in [1e-300, 1e-150, 1.0, 1e150, 1e300] {
            let line = [[1.0, 3.0, 5.0], [2.0, 6.0, 10.0], [4.0, 12.0, 20.0]];
            let line = line.map(|point| point.map(|c| c * 2_f64.powi(f64::log2(scale) as i32)));
            assert!(is_degenerate(line), "{scale}");
            for k in 0..3 {
                let mut bent = line;
                bent[2][k] = bent[2][k].next_up();
                assert!(!is_degenerate(bent), "{scale}, axis {k}");
            }
        }
    }

    #[test]
    fn the_least_numbers_are_told_apart_too() {
        let least = f64::from_bits(1);
        assert!(!is_degenerate([[0.0; 3], [least, 0.0, 0.0], [0.0, least, 0.0]]));
        assert!(is_degenerate([[0.0; 3], [least, 0.0, 0.0], [3.0 * least, 0.0, 0.0]]));
        assert!(
            is_degenerate([[0.0; 3]; 3]) && is_degenerate([[-0.0, 0.0, 0.0], [0.0; 3], [1.0; 3]])
        );
        assert!(!is_degenerate([[f64::NAN; 3], [0.0; 3], [1.0; 3]]));
        assert!(!is_degenerate([[f64::INFINITY; 3], [0.0; 3], [1.0; 3]]));
    }

    proptest! {
        /// Nearly on a line, and so large that f64 rounds their products.
        #[test]
        fn integers_are_judged_as_integers_judge_them(
            a in prop::array::uniform3(-1_i128 << 30..1 << 30),
            step in prop::array::uniform3(-1_i128 << 28..1 << 28),
            times in -3..4_i128,
            nudge in prop::array::uniform3(-1..2_i128),
        ) {
            let b: [i128; 3] = std::array::from_fn(|k| a[k] + step[k]);
            for nudge in [nudge, [0; 3]] {
                let c: [i128; 3] = std::array::from_fn(|k| a[k] + times * step[k] + nudge[k]);
                let (u, v) = (step, std::array::from_fn::<_, 3, _>(|k| c[k] - a[k]));
                let is_flat = (0..3).all(|k| u[k] * v[(k + 1) % 3] == u[(k + 1) % 3] * v[k]);
                let corners = [a, b, c].map(|corner| corner.map(|c| c as f64));
                prop_assert_eq!(is_degenerate(corners), is_flat);
            }
        }

        /// A point of f32 halfway between two others is on their line.
        #[test]
        fn the_middle_is_on_the_line(a: [i32; 3], step: [i16; 3]) {
            let at = |n: f64| -> [f64; 3] {
                std::array::from_fn(|k| f64::from(a[k] as f32 / 1024.0) + n * f64::from(step[k]) / 1024.0)
            };
            prop_assert!(is_degenerate([at(0.0), at(1.0), at(2.0)]));
        }
    }
}
