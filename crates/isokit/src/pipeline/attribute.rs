//! The values of another scan at the vertices of a mesh.

mod colors;

use crate::pipeline::{PipelineError, Scan};
use isokit_field::{Between, probe};
use isokit_geom::{Affine, Frame, Space, vector::Vector};
use isokit_job::{Job, in_chunks};
use isokit_lanes::exactly;
use isokit_mesh::TriMesh;
use isokit_volume::for_any;

/// From the coordinates of a scan's meshes to the sample numbers of another scan.
pub(super) struct Way {
    /// Samples of the scan to where its meshes are, and to where they were before; none if that is the same.
    placed: Option<[Affine; 2]>,
    /// What brings the axes and the unit of that world to those of the other one.
    factors: Vector,
    other: Affine,
}

impl Way {
    pub(super) fn index_of(&self, xyz: Vector) -> Vector {
        let source = match &self.placed {
            Some([placed, source]) => source.point(placed.inverse_point(xyz)),
            None => xyz,
        };
        self.other.inverse_point(std::array::from_fn(|k| source[k] * self.factors[k]))
    }
}

impl Scan {
    /// Where the samples were before they were [placed](Self::placed) elsewhere.
    pub fn source_frame(&self) -> &Frame {
        &self.source
    }

    /// The values of another scan at the vertices of a mesh of this one: NaN where it has none, as
    /// [`probe`] says, or one beyond what f32 holds. The mesh is where this scan is; the other scan may have any lattice and any part.
    ///
    /// Both are taken to be in one world. Between RAS and LPS axes are turned and units are converted, where
    /// both scans say what theirs are; where either does not, [`differences`](Self::differences) says so.
    ///
    /// # Errors
    ///
    /// If the job is cancelled or allows less memory.
    pub fn attribute(
        &self,
        mesh: &TriMesh,
        other: &Self,
        between: Between,
        job: &Job,
    ) -> Result<Vec<f32>, PipelineError> {
        let way = self.way(other.source_frame());
        for_any!(other.volume(), volume => {
            let view = other.view(volume);
            // Sample numbers count from the first of the whole.
            let first = other.part().map(|range| range.start as f64);
            let value = |ijk: Vector| {
                let ijk = std::array::from_fn(|k| ijk[k] - first[k]);
                let value = probe(&view, ijk, between).map(|value| value as f32);
                value.filter(|value| value.is_finite()).unwrap_or(f32::NAN)
            };
            at_vertices(mesh, &way, ("values of vertices", value), job)
        })
    }

    /// What neither scan's file says of whether they are in one world, each a sentence for the user.
    pub fn differences(&self, other: &Self) -> Vec<String> {
        self.differences_from(other.source_frame())
    }

    /// The same of this scan and the frame that another file gives.
    pub fn differences_from(&self, there: &Frame) -> Vec<String> {
        let here = self.source_frame();
        let mut notes = vec![];
        let same = "they are taken to be the same";
        if here.space != there.space && [here.space, there.space].contains(&Space::Unknown) {
            notes.push(format!("axes are {} and {}; {same}", here.space, there.space));
        }
        let metres = [here.unit.metres(), there.unit.metres()];
        if here.unit != there.unit && metres.contains(&None) {
            notes.push(format!("units are {} and {}; {same}", here.unit, there.unit));
        }
        notes
    }

    pub(super) fn way(&self, there: &Frame) -> Way {
        let here = self.source_frame();
        let is_turned = here.space != there.space
            && here.space != Space::Unknown
            && there.space != Space::Unknown;
        let turn = if is_turned { [-1.0, -1.0, 1.0] } else { [1.0; 3] };
        let scale = match [here.unit.metres(), there.unit.metres()] {
            [Some(from), Some(to)] => from / to,
            _ => 1.0,
        };
        let placed = self.frame().index_to_world;
        Way {
            placed: (placed != here.index_to_world).then_some([placed, here.index_to_world]),
            factors: turn.map(|sign| sign * scale),
            other: there.index_to_world,
        }
    }
}

/// What there is of something, which has a name, at all vertices of a mesh.
fn at_vertices<T: Copy + Send>(
    mesh: &TriMesh,
    way: &Way,
    (what, at): (&'static str, impl Fn(Vector) -> T + Sync),
    job: &Job,
) -> Result<Vec<T>, PipelineError> {
    let vertices = mesh.positions.len();
    let mut all: Vec<T> = job.limits.vec(what, Some(vertices as u64))?;
    job.progress.begin("probe", vertices as u64);
    let chunks = in_chunks(vertices, job, |range| {
        let one = |vertex: usize| at(way.index_of(mesh.positions.get(vertex)));
        exactly(|| range.map(one).collect::<Vec<T>>())
    })?;
    chunks.iter().for_each(|chunk| all.extend_from_slice(chunk));
    Ok(all)
}

/// The source of other samples that were made in the world `placed`, whose own source is `source`.
pub(super) fn source_of(new: Frame, (placed, source): (&Frame, &Frame)) -> Frame {
    if placed == source {
        return new;
    }
    let (to, from) = (&source.index_to_world, &placed.index_to_world);
    let columns = new.index_to_world.columns().map(|c| to.vector(from.inverse_vector(c)));
    let origin = to.point(from.inverse_point(new.index_to_world.origin()));
    // Both are maps, so one after the other is one, but at the ends of what numbers hold.
    let index_to_world = Affine::new(columns, origin).unwrap_or(new.index_to_world);
    Frame { index_to_world, ..*source }
}

#[cfg(test)]
mod tests;
