//! From numbers that are counted through a file to a mesh that counts its own.

use crate::ReadFault;
use isokit_geom::Aabb;
use isokit_job::Job;
use isokit_mesh::{Attributes, Positions, Rgba, TriMesh};
use std::ops::Range;

/// An object as it stands in the file.
#[derive(Debug, Default)]
pub(super) struct Object {
    /// `None` for what comes before the first object.
    pub(super) name: Option<String>,
    pub(super) iso: Option<f64>,
    pub(super) color: Option<Rgba>,
    pub(super) material: Option<String>,
    /// Whether the file says that it needs f64.
    pub(super) is_f64: bool,
    /// The number of the vertex that comes next in the file.
    pub(super) first_vertex: usize,
    pub(super) faces: Vec<[Corner; 3]>,
}

/// A corner of a face: numbers of a position and a normal, counted from 0 through the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Corner {
    pub(super) vertex: u32,
    /// [`Corner::NONE`] if it has none.
    pub(super) normal: u32,
}

impl Corner {
    pub(super) const NONE: u32 = u32::MAX;
}

impl Object {
    /// The mesh, of its own vertices and of others that its faces name, both in the order of the file; and
    /// whether it has normals that were left out, since they differ within a vertex. Where some vertices have colours, others
    /// are `plain`.
    pub(super) fn mesh(
        &self,
        own: Range<usize>,
        (positions, colors): (&[[f64; 3]], &[Option<Rgba>]),
        normals: &[[f32; 3]],
        is_ours: bool,
        plain: Rgba,
        job: &Job,
    ) -> Result<(TriMesh, bool), ReadFault> {
        let corners = || self.faces.iter().flatten();
        let is_own = |vertex: u32| own.contains(&(vertex as usize));
        let mut foreign: Vec<u32> =
            corners().map(|corner| corner.vertex).filter(|&vertex| !is_own(vertex)).collect();
        foreign.sort_unstable();
        foreign.dedup();
        let before = foreign.partition_point(|&vertex| (vertex as usize) < own.start);
        let [low, high] = [&foreign[..before], &foreign[before..]];
        // Own vertices stand between the foreign ones from before and from behind.
        let renamed = |vertex: u32| match is_own(vertex) {
            true => (before + vertex as usize - own.start) as u32,
            false => {
                let place = foreign.partition_point(|&other| other < vertex);
                (if place < before { place } else { place + own.len() }) as u32
            }
        };
        let count = Some((own.len() + foreign.len()) as u64);
        let mut all = job.limits.vec("vertices", count)?;
        let pick = |&vertex: &u32| positions[vertex as usize];
        all.extend(low.iter().map(pick));
        all.extend_from_slice(&positions[own.clone()]);
        all.extend(high.iter().map(pick));
        let numbers = || {
            let [low, high] = [low, high].map(|all| all.iter().map(|&vertex| vertex as usize));
            low.chain(own.clone()).chain(high)
        };
        let color = |vertex: usize| colors.get(vertex).copied().flatten();
        let has_colors = numbers().any(|vertex| color(vertex).is_some());
        let painted = numbers().map(|vertex| color(vertex).unwrap_or(plain));
        let colors = has_colors.then(|| painted.collect());
        let attributes = Attributes { values: None, colors };
        let triangles = self.faces.iter().map(|face| face.map(|corner| renamed(corner.vertex)));
        let triangles = triangles.collect();
        let needs_f64 = if is_ours { self.is_f64 } else { is_far(&all) };
        let normals = self.vertex_normals(all.len(), normals, renamed);
        let has_split = normals.is_none();
        let positions = match needs_f64 {
            true => Positions::F64(all),
            false => Positions::F32(all.iter().map(|xyz| xyz.map(|c| c as f32)).collect()),
        };
        let normals = normals.filter(|normals| !normals.is_empty());
        Ok((TriMesh { positions, normals, triangles, attributes }, has_split))
    }

    /// One normal for each vertex; none at all if some corner has none, `None` if two corners disagree.
    fn vertex_normals(
        &self,
        count: usize,
        normals: &[[f32; 3]],
        renamed: impl Fn(u32) -> u32,
    ) -> Option<Vec<[f32; 3]>> {
        let corners = || self.faces.iter().flatten();
        if self.faces.is_empty() || corners().any(|corner| corner.normal == Corner::NONE) {
            return Some(vec![]);
        }
        let mut of_vertex = vec![Corner::NONE; count];
        for corner in corners() {
            let known = &mut of_vertex[renamed(corner.vertex) as usize];
            if *known == Corner::NONE {
                *known = corner.normal;
            }
            let [a, b] = [*known, corner.normal].map(|number| normals[number as usize]);
            if a.map(f32::to_bits) != b.map(f32::to_bits) {
                return None;
            }
        }
        // A vertex of no face shows no normal; any direction will do.
        let normal = |number: u32| normals.get(number as usize).copied().unwrap_or([0.0, 0.0, 1.0]);
        Some(of_vertex.into_iter().map(normal).collect())
    }
}

/// Whether f32 would move a vertex by more than a millionth of the size of all.
fn is_far(positions: &[[f64; 3]]) -> bool {
    const VISIBLE: f64 = 1e-6;
    let finite = positions.iter().copied().filter(|xyz| xyz.iter().all(|c| c.is_finite()));
    Aabb::around(finite).is_some_and(|bounds| {
        let size = (0..3).map(|k| (bounds.max[k] - bounds.min[k]).powi(2)).sum::<f64>().sqrt();
        let step = bounds.reach() * f64::from(f32::EPSILON) / 2.0;
        size > 0.0 && step > VISIBLE * size
    })
}

#[cfg(test)]
mod tests {
    use super::is_far;

    #[test]
    fn far_is_meant_by_the_size_of_the_surface() {
        assert!(!is_far(&[]));
        assert!(!is_far(&[[-90.0, 0.0, 0.0], [250.0, 100.0, 0.0]]));
        assert!(is_far(&[[500_000.0, 0.0, 0.0], [500_100.0, 0.0, 0.0]]));
        assert!(!is_far(&[[f64::NAN, 0.0, 0.0], [1.0, 0.0, 0.0]]));
    }
}
