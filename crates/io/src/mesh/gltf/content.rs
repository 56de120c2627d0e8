//! What glTF wants to know of the numbers it holds, and what it does not take.

use super::Scale;
use crate::{
    WriteFault,
    mesh::{SurfaceHead, Written, outline::Outline, sound},
};
use isokit_mesh::Positions;
use std::array;

/// Least and greatest of the numbers that are written, axis by axis: the box that glTF wants exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) min: [f32; 3],
    pub(super) max: [f32; 3],
}

impl Default for Bounds {
    /// Around nothing.
    fn default() -> Self {
        Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] }
    }
}

impl Bounds {
    /// Takes in vertices from number `first` on; fails at one that has no place in f32.
    pub(super) fn take(
        &mut self,
        positions: &Positions,
        scale: Scale,
        head: &SurfaceHead,
        first: u64,
    ) -> Result<(), WriteFault> {
        for (vertex, xyz) in (first..).zip(positions.iter()) {
            let stored = scale.store(xyz);
            if !stored.iter().all(|c| c.is_finite()) {
                let flaw = format!("vertex {vertex} is at {xyz:?}; glTF holds finite f32 only");
                return Err(sound::fault(&head.name, &flaw));
            }
            self.min = array::from_fn(|k| self.min[k].min(stored[k]));
            self.max = array::from_fn(|k| self.max[k].max(stored[k]));
        }
        Ok(())
    }
}

/// A vertex whose normal has no direction: glTF allows no such normals.
#[derive(Clone, Copy, Debug)]
pub(super) struct Undirected {
    vertex: u64,
    normal: [f32; 3],
}

impl Undirected {
    /// The first of normals that begin with that of vertex `first`.
    pub(super) fn find(normals: &[[f32; 3]], first: u64) -> Option<Self> {
        let has_none = |normal: &[f32; 3]| !unit(*normal).iter().all(|c| c.is_finite());
        let at = normals.iter().position(has_none)?;
        Some(Self { vertex: first + at as u64, normal: normals[at] })
    }

    /// Says that there are no normals then.
    pub(super) fn report(self, head: &SurfaceHead, written: &mut Written) {
        let (name, Self { vertex, normal }) = (&head.name, self);
        written.warnings.push(format!(
            "surface {name:?}: the normal of vertex {vertex} is {normal:?}, which is no direction; \
             written without normals"
        ));
    }
}

/// A normal of length 1, as it is where it is near enough; not finite where it has no direction.
pub(super) fn unit(normal: [f32; 3]) -> [f32; 3] {
    const NEAR: f64 = 1e-4;
    let square: f64 = normal.iter().map(|&c| f64::from(c) * f64::from(c)).sum();
    if (square - 1.0).abs() <= NEAR {
        return normal;
    }
    normal.map(|c| (f64::from(c) / square.sqrt()) as f32)
}

/// Says that there are no values then: glTF has no word for none.
pub(super) fn report_valueless(count: usize, head: &SurfaceHead, written: &mut Written) {
    let name = &head.name;
    written.warnings.push(format!(
        "surface {name:?}: {count} vertices have no value, for which glTF has no word; written without values"
    ));
}

/// Says which surfaces are left out, since nothing of them would be seen.
pub(super) fn report_unseen<'a>(
    outlines: impl IntoIterator<Item = &'a Outline>,
    written: &mut Written,
) {
    for Outline { head, counts, .. } in outlines {
        if counts.triangles == 0 && counts.vertices > 0 {
            let (name, count) = (&head.name, counts.vertices);
            let lost = format!("surface {name:?}: {count} vertices and no triangle; left out");
            written.warnings.push(lost);
        }
    }
}
