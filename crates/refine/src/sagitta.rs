//! By how much triangles may leave their surface, from the second derivatives of the field.
//!
//! With F the field less the isovalue, and h the greatest |eᵀ H e| along each side e of a triangle, F on the
//! triangle differs from what is linear between its corners by at most the greatest value of
//!
//! ```text
//! ½ (λ₀λ₁ h₀₁ + λ₁λ₂ h₁₂ + λ₂λ₀ h₂₀)
//! ```
//!
//! and the distance to the surface is that over |∇F|, to first order. To it comes what the corners themselves
//! are off. [`Known`] has both.
//!
//! Of a triangle whose bound is too great those sides are divided that make it so, whatever its neighbours
//! need. A side on a rim counts in the plane of the border; caps are flat and count nothing.

use crate::{RefineError, edges::Edges, exact::in_chunks, known::Known};
use isokit_job::Job;
use isokit_mesh::TriMesh;

/// What is known of the edges of a mesh and its triangles.
pub(crate) struct Sagitta {
    /// Whether an edge is to be divided.
    too_long: Vec<bool>,
    /// The greatest bound of a triangle that is not above the error, if there is such a triangle.
    pub(crate) bound: Option<f64>,
    /// Triangles whose bound is above the error, or unknown.
    pub(crate) unbounded: u64,
}

impl Sagitta {
    /// Edges are divided so often at most: each into 1024.
    pub(crate) const ROUNDS: u32 = 10;

    /// A corner that is off by a greater part of the error spoils a triangle that no division mends.
    const CORNERS: f64 = 0.25;

    /// Looks at all triangles.
    pub(crate) fn of(
        (mesh, edges): (&TriMesh, &Edges),
        known: &Known,
        error: f64,
        job: &Job,
    ) -> Result<Self, RefineError> {
        let looks = in_chunks(mesh.triangles.len(), &job.unwatched(), |range| {
            let (mut bound, mut unbounded, mut long) = (None::<f64>, 0, vec![]);
            for t in range {
                let (sides, corners) = (edges.sides[t], mesh.triangles[t]);
                let bends = sides.map(|edge| known.bends[edge as usize]);
                let off = corners.iter().fold(0.0_f64, |most, &v| most.max(known.offs[v as usize]));
                let own = raised(bends) + off;
                if own <= error {
                    bound = Some(bound.map_or(own, |most| most.max(own)));
                    continue;
                }
                unbounded += 1;
                let most = bends.into_iter().fold(0.0, f64::max);
                if most.is_finite() && off <= Self::CORNERS * error {
                    let counts = |k: &usize| bends[*k] > 0.5 * most;
                    long.extend((0..3).filter(counts).map(|k| sides[k]));
                }
            }
            (bound, unbounded, long)
        })?;
        let mut found = Self { too_long: vec![false; edges.len()], bound: None, unbounded: 0 };
        for (bound, unbounded, long) in looks {
            // A number is greater than none.
            found.bound = if bound > found.bound { bound } else { found.bound };
            found.unbounded += unbounded;
            long.into_iter().for_each(|edge| found.too_long[edge as usize] = true);
        }
        Ok(found)
    }

    /// Whether an edge is to be divided: its triangle may leave the surface by too much, and dividing helps.
    pub(crate) fn is_too_long(&self, edge: usize) -> bool {
        self.too_long[edge]
    }
}

/// The greatest value of ½ (λ₀λ₁a + λ₁λ₂b + λ₂λ₀c) on a triangle. For squared lengths of sides it is half of
/// the square of the circle's radius around it, or an eighth of the longest where that is outside.
fn raised(bends: [f64; 3]) -> f64 {
    let [a, b, c] = bends;
    let most = a.max(b).max(c);
    if !(most.is_finite() && most > 0.0) {
        return most;
    }
    // By the greatest first, so that no product vanishes or overflows.
    let [a, b, c] = bends.map(|bend| bend / most);
    if a + b + c <= 2.0 {
        return most / 8.0;
    }
    let doubled_area = 2.0 * (a * b + b * c + c * a) - (a * a + b * b + c * c);
    most * (0.5 * a * b * c / doubled_area)
}

#[cfg(test)]
mod tests {
    use super::raised;

    #[test]
    fn a_bound_is_the_greatest_value_that_is_seen_on_the_triangle() {
        let bends = [[1.0, 1.0, 1.0], [2.0, 1.0, 1.0], [5.0, 1.0, 2.0], [3.0, 2.5, 1.0]];
        for [a, b, c] in bends.into_iter().chain([[0.0, 1e-200, 1e-200], [1e300, 8e299, 9e299]]) {
            let mut seen = 0.0_f64;
            for (i, j) in (0..=300).flat_map(|i| (0..=300 - i).map(move |j| (i, j))) {
                let [x, y] = [i, j].map(|n| f64::from(n) / 300.0);
                let z = 1.0 - x - y;
                seen = seen.max(0.5 * (x * y * a + y * z * b + z * x * c));
            }
            let found = raised([a, b, c]);
            assert!(seen <= found * (1.0 + 1e-12) && found <= seen * 1.0002, "{found:e}, {seen:e}");
        }
        assert_eq!(raised([0.0; 3]), 0.0);
        assert_eq!(raised([1.0, f64::INFINITY, 0.0]), f64::INFINITY);
    }
}
